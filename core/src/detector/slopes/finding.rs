//! Result of the slope finder.

use super::evidence::SlopeEvidence;
use crate::detector::params::slope_grid::{Slope, SlopeGrid};
use serde::Serialize;

/// Kind of motion that a burst shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SlopeVerdict {
    /// Slopes were found.
    Found,
    /// Nothing moves: a still tripod.
    Still,
    /// The frames have nothing significant in common; the grid is the usual one.
    NothingSeen,
    /// The picture does not move uniformly: no slope aligns all frames.
    NotStraight,
    /// The frames move by more than a third of the picture: a film that should be cut into bursts.
    Film,
}

/// Power of the motion stack over slopes, for the whole image at the finest level used.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SlopeSpectrum {
    /// Slopes, pixels per frame.
    pub slopes: Vec<Slope>,
    /// For each slope, the power without each frame's own, divided by its standard deviation if the frames had nothing
    /// in common.
    pub significance: Vec<f32>,
}

/// Slopes to search, and the evidence for them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlopeFinding {
    /// Grid to search.
    pub grid: SlopeGrid,
    /// Kind of motion.
    pub verdict: SlopeVerdict,
    /// Confidence: the part (0 … 1) of all significant evidence, by its significance, whose slope the grid holds. 0
    /// where there is none.
    pub confidence: f32,
    /// Power of the strongest window divided by its standard deviation if the frames had nothing in common. A window
    /// counts from 6.5 if it is large, and from 11.5 if it is small.
    pub significance: f32,
    /// Direction in which most of the picture moves, degrees from +u towards +v, −180 … 180; `None` where nothing moves
    /// or nothing is seen.
    pub direction_deg: Option<f32>,
    /// Typical motion of the picture from the first to the last frame, pixels.
    pub moved_px: f32,
    /// Largest distance of the picture's path from a uniform motion, pixels; `None` where single frames are too noisy
    /// to measure it.
    pub deviation_px: Option<f32>,
    /// Evidence of each window.
    #[serde(skip)]
    pub evidence: Vec<SlopeEvidence>,
    /// Power over slopes.
    #[serde(skip)]
    pub spectrum: SlopeSpectrum,
}

impl SlopeFinding {
    /// Finding of slope 0 with `confidence`.
    pub(super) fn still(confidence: f32) -> Self {
        let grid = SlopeGrid::single(Slope::default());
        Self { grid, verdict: SlopeVerdict::Still, confidence, ..Self::nothing(0.0) }
    }

    /// Finding of the usual grid, because nothing is seen: `significance` is too small.
    pub(super) fn nothing(significance: f32) -> Self {
        Self {
            grid: SlopeGrid::default(),
            verdict: SlopeVerdict::NothingSeen,
            confidence: 0.0,
            significance,
            direction_deg: None,
            moved_px: 0.0,
            deviation_px: None,
            evidence: Vec::new(),
            spectrum: SlopeSpectrum::default(),
        }
    }

    /// Sets the distance from a uniform motion. `deviation` is this distance and the limit above which it changes the
    /// verdict, in pixels.
    pub(super) fn with_deviation(self, deviation: Option<[f64; 2]>) -> Self {
        let bent = deviation.is_some_and(|[distance, limit]| distance > limit);
        let verdict = match self.verdict {
            SlopeVerdict::Found | SlopeVerdict::Still if bent => SlopeVerdict::NotStraight,
            verdict => verdict,
        };
        Self { verdict, deviation_px: deviation.map(|[distance, _]| distance as f32), ..self }
    }

    /// One line of text: the verdict, the grid, and the confidence.
    pub fn summary(&self) -> String {
        let grid = grid_text(&self.grid);
        let sure = format!("{:.0} % of what is seen agrees", 100.0 * self.confidence);
        match self.verdict {
            SlopeVerdict::Found => format!("found: {grid}; {sure}"),
            SlopeVerdict::Still => "nothing moves: slope 0".to_owned(),
            SlopeVerdict::NothingSeen => format!("nothing to be seen: {grid}"),
            SlopeVerdict::NotStraight => format!(
                "the motion is not straight (up to {:.1} px off): {grid}; use fewer frames",
                self.deviation_px.unwrap_or(0.0)
            ),
            SlopeVerdict::Film => format!(
                "the frames move by {:.0} px, more than a third of the picture: {grid}; cut the film into bursts",
                self.moved_px
            ),
        }
    }
}

/// Text of a grid, as the options of the command line take it.
pub fn grid_text(grid: &SlopeGrid) -> String {
    let direction = if grid.direction_deg == 0.0 { String::new() } else { format!(" at {}°", grid.direction_deg) };
    match (grid.u.count, grid.v.count) {
        (1, 1) => format!("slope {}, {}", grid.u.value(0.0), grid.v.value(0.0)),
        (_, 1) => format!("{}{direction}", grid.u),
        _ => format!("u {}, v {}{direction}", grid.u, grid.v),
    }
}
