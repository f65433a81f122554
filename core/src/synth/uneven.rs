//! Times of the frames of a synthetic burst: even, or with frames left out, or early and late.
//!
//! Things that an even burst shows stay: an uneven one shows them at other times, so that it can be compared with the
//! even one frame by frame.

use super::random::Stream;
use super::truth::Truth;
use crate::burst::Positions;
use crate::error::Error;
use serde::{Deserialize, Serialize};

/// Frames of a synthetic burst that are not even in time.
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

    /// Frames that are taken of `frames` even ones.
    ///
    /// # Errors
    /// No frame would be left, there is no such frame, or the jitter exchanges frames.
    pub fn taken(&self, frames: usize, seed: u64) -> Result<Taken, Error> {
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
        let (mut stream, even) = (Stream::new(seed, JITTER_STREAM), Taken::even(frames));
        let at = |t: usize| {
            let is_end = t == first || t == last;
            let late = if is_end || self.jitter == 0.0 { 0.0 } else { stream.within(-self.jitter, self.jitter) };
            (t, even.frames[t].1 + late)
        };
        Ok(Taken { frames: kept.into_iter().map(at).collect(), is_even: self.is_even() })
    }
}

/// Frames that are taken of an even burst.
#[derive(Debug, Clone, PartialEq)]
pub struct Taken {
    /// Index of each in the even burst, and its time from the middle of that, frame intervals.
    pub(super) frames: Vec<(usize, f64)>,
    is_even: bool,
}

impl Taken {
    /// All of `frames` frames.
    pub(super) fn even(frames: usize) -> Self {
        let positions = Positions::even(frames);
        Self { frames: positions.offsets().iter().copied().enumerate().collect(), is_even: true }
    }

    fn times(&self) -> Vec<f64> {
        let first = self.frames.first().map_or(0.0, |(t, _)| *t as f64);
        self.frames.iter().map(|(_, at)| at - self.frames[0].1 + first).collect()
    }

    pub(super) fn positions(&self) -> Positions {
        Positions::new(&self.times()).expect("frames follow one another")
    }

    /// The truth of these frames, at their mid-burst, from that of the even burst.
    pub(super) fn truth(&self, even: Truth) -> Truth {
        if self.is_even {
            return even;
        }
        let later = self.frames.iter().map(|(_, at)| at).sum::<f64>() / self.frames.len() as f64;
        let mut truth = Truth { frames: self.frames.len(), t0: even.t0 + later, times: self.times(), ..even };
        for feature in &mut truth.features {
            (feature.u, feature.v) = feature.position(later);
        }
        truth
    }
}
