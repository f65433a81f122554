//! Positions of a synthetic burst's frames: even, left out, early, late or exchanged; or places of views.
//!
//! The things of an even burst stay: an uneven one shows them at other times, and can be compared frame by frame.

use super::{random::Stream, truth::Truth};
use crate::burst::{Offset, Positions, ViewGrid};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Frames of a synthetic burst that are not even in time, or not in time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(default, deny_unknown_fields)]
pub struct Uneven {
    /// Frames to leave out, counted from 0 and separated by commas.
    #[cfg_attr(feature = "cli", arg(long, value_name = "FRAMES", value_delimiter = ','))]
    pub drop: Vec<usize>,
    /// Largest distance of a frame from its even time, frame intervals; the first and the last frame keep theirs.
    #[cfg_attr(feature = "cli", arg(long, value_name = "FRAMES", default_value_t = 0.0))]
    pub jitter: f64,
    /// Two frames, counted from 0 among those that are not left out, that stand in each other's place, as a recorder
    /// may write them: only the images and the truth tell it.
    #[cfg_attr(feature = "cli", arg(long, value_name = "A,B", value_delimiter = ','))]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exchange: Vec<usize>,
    /// Rows and columns of the views of a light field, such as 9x9, in the place of frames in time; the slope is the
    /// disparity between neighbouring views.
    #[cfg_attr(feature = "cli", arg(long, value_name = "ROWSxCOLUMNS"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<ViewGrid>,
}

/// Largest jitter, frame intervals: frames stay in their order.
const MAX_JITTER: f64 = 0.45;
/// Stream of a seed from which jitter is drawn; the frames' noise has those from 1 on.
const JITTER_STREAM: u64 = 1 << 40;

impl Uneven {
    /// Whether the frames are even.
    pub fn is_even(&self) -> bool {
        *self == Self::default()
    }

    /// Positions of all frames before any are left out, of `frames` in time or of the views.
    pub fn whole(&self, frames: usize) -> Positions {
        self.views.map_or_else(|| Positions::even(frames), |views| Positions::grid(views.rows(), views.columns()))
    }

    /// Number of all frames, and their [span](Positions::span), without making their positions: the numbers may be any.
    pub fn count_and_span(&self, frames: usize) -> (usize, f64) {
        let Some(views) = self.views else { return (frames, frames.saturating_sub(1) as f64) };
        let [rows, columns] = [views.rows(), views.columns()].map(|side| (side - 1) as f64);
        (views.count(), if rows > 0.0 { rows.hypot(columns) } else { columns })
    }

    /// Frames that are taken of `frames` even ones, or of the views.
    ///
    /// # Errors
    /// No frame would be left, there is no such frame, too much jitter, not two frames exchanged, or views with times.
    pub fn taken(&self, frames: usize, seed: u64) -> Result<Taken> {
        if self.views.is_some() {
            if !self.drop.is_empty() || self.jitter != 0.0 || !self.exchange.is_empty() {
                let problem = "the views of a light field have no times, so none can be early, late or missing";
                return Err(Error::param("views", problem, "leave out drop, jitter and exchange"));
            }
            return Ok(Taken::all(&self.whole(frames)));
        }
        if let Some(frame) = self.drop.iter().find(|frame| **frame >= frames) {
            let remedy = format!("give frames from 0 to {}", frames.saturating_sub(1));
            return Err(Error::param("drop", format!("there is no frame {frame} of {frames}"), remedy));
        }
        if !(0.0..=MAX_JITTER).contains(&self.jitter) {
            let remedy = format!("give 0 to {MAX_JITTER}, so that frames stay in their order");
            return Err(Error::param("jitter", format!("{} frame intervals", self.jitter), remedy));
        }
        let kept: Vec<usize> = (0..frames).filter(|frame| !self.drop.contains(frame)).collect();
        let (Some(&first), Some(&last)) = (kept.first(), kept.last()) else {
            return Err(Error::param("drop", "no frame would be left", "leave out fewer frames"));
        };
        // A stream of its own: jitter changes no noise.
        let (mut stream, even) = (Stream::new(seed, JITTER_STREAM), Taken::even(frames));
        let at = |t: usize| {
            let is_end = t == first || t == last;
            // The ends keep their times, and so the burst its span.
            let late = if is_end || self.jitter == 0.0 { 0.0 } else { stream.within(-self.jitter, self.jitter) };
            (t, Offset::from(even.frames[t].1.u + late))
        };
        let mut frames: Vec<_> = kept.into_iter().map(at).collect();
        match self.exchange[..] {
            [] => {}
            // Each frame keeps its true time, which the truth reports.
            [a, b] if a != b && a.max(b) < frames.len() => frames.swap(a, b),
            _ => {
                let remedy = format!("give two frames from 0 to {}, such as 1,2", frames.len() - 1);
                return Err(Error::param("exchange", format!("these are no two frames: {:?}", self.exchange), remedy));
            }
        }
        Ok(Taken { frames, is_even: self.is_even() })
    }
}

/// Frames that are taken of an even burst.
#[derive(Debug, Clone, PartialEq)]
pub struct Taken {
    /// Index of each in the even burst, and its position from the middle of that.
    pub(super) frames: Vec<(usize, Offset)>,
    is_even: bool,
}

impl Taken {
    pub(super) fn even(frames: usize) -> Self {
        Self::all(&Positions::even(frames))
    }

    pub(super) fn all(positions: &Positions) -> Self {
        Self { frames: positions.offsets().iter().copied().enumerate().collect(), is_even: positions.is_even() }
    }

    fn times(&self) -> Vec<f64> {
        // Exchanged frames are not in order: the first in time need not be the first in the list.
        let earliest = self.frames.iter().min_by(|(_, a), (_, b)| a.u.total_cmp(&b.u));
        let Some(&(first, at_first)) = earliest else { return Vec::new() };
        self.frames.iter().map(|(_, at)| at.u - at_first.u + first as f64).collect()
    }

    fn views(&self) -> Vec<[f64; 2]> {
        let are_views = self.frames.iter().any(|(_, at)| at.v != 0.0);
        let places = self.frames.iter().map(|(_, at)| *at - self.frames[0].1);
        if are_views { places.map(|at| [at.u, at.v]).collect() } else { Vec::new() }
    }

    /// Positions of the frames in the order in which they stand: what a recorder says of exchanged ones.
    pub(super) fn positions(&self) -> Positions {
        let (views, mut times) = (self.views(), self.times());
        times.sort_by(f64::total_cmp);
        let positions = if views.is_empty() { Positions::new(&times) } else { Positions::of_views(&views) };
        positions.expect("frames follow one another, and views differ")
    }

    pub(super) fn truth(&self, even: Truth) -> Truth {
        if self.is_even {
            return even;
        }
        let views = self.views();
        if !views.is_empty() {
            return Truth { frames: self.frames.len(), views, ..even };
        }
        // Features are given at mid-burst, which moves with the frames that are left out.
        let later = self.frames.iter().map(|(_, at)| at.u).sum::<f64>() / self.frames.len() as f64;
        let mut truth = Truth { frames: self.frames.len(), t0: even.t0 + later, times: self.times(), ..even };
        for feature in &mut truth.features {
            (feature.u, feature.v) = feature.position(later);
        }
        truth
    }
}
