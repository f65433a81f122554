//! What the slope finder answers.

use super::evidence::SlopeEvidence;
use crate::detector::params::slope_grid::{Slope, SlopeGrid};
use serde::Serialize;

/// What a burst shows of its motion.
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
    /// The frames move by more than a third of the picture: a film that is to be cut into bursts.
    Film,
}

/// Power of the motion stack over slopes, for the whole image at the finest level looked at.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SlopeSpectrum {
    /// Pixels per frame.
    pub slopes: Vec<Slope>,
    /// For each slope, the power without what each frame has alone, over its standard deviation if the frames had
    /// nothing in common.
    pub significance: Vec<f32>,
}

/// The slopes to be searched, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlopeFinding {
    /// What is to be searched.
    pub grid: SlopeGrid,
    /// What the burst shows.
    pub verdict: SlopeVerdict,
    /// How sure that is: the part (0 … 1) of all significant evidence, by its significance, whose slope the grid holds.
    /// 0 where nothing is seen.
    pub confidence: f32,
    /// Power of the strongest window over the standard deviation that frames with nothing in common would give it. What
    /// counts begins at 6.5 for a large window and 11.5 for a small one.
    pub significance: f32,
    /// Where most of the picture moves, degrees from +u towards +v, −180 … 180; `None` where nothing moves.
    pub direction_deg: Option<f32>,
    /// How far the picture typically moves from the first to the last frame, pixels.
    pub moved_px: f32,
    /// The largest distance of the picture's way from a uniform motion, pixels; `None` where single frames are too
    /// noisy to tell.
    pub deviation_px: Option<f32>,
    /// What each window says.
    #[serde(skip)]
    pub evidence: Vec<SlopeEvidence>,
    /// The power over slopes.
    #[serde(skip)]
    pub spectrum: SlopeSpectrum,
}

impl SlopeFinding {
    /// Slope 0, `confidence` of it.
    pub(super) fn still(confidence: f32) -> Self {
        let grid = SlopeGrid::single(Slope::default());
        Self { grid, verdict: SlopeVerdict::Still, confidence, ..Self::nothing(0.0) }
    }

    /// The usual grid, because nothing is seen: `significance` is too little.
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

    /// The same with the distance from a uniform motion, and the one above which it changes the verdict, in pixels.
    pub(super) fn with_deviation(self, deviation: Option<[f64; 2]>) -> Self {
        let bent = deviation.is_some_and(|[distance, limit]| distance > limit);
        let verdict = match self.verdict {
            SlopeVerdict::Found | SlopeVerdict::Still if bent => SlopeVerdict::NotStraight,
            verdict => verdict,
        };
        Self { verdict, deviation_px: deviation.map(|[distance, _]| distance as f32), ..self }
    }

    /// One line for people: the verdict, the grid, and how sure it is.
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

/// A grid as the options of the command line would give it.
pub fn grid_text(grid: &SlopeGrid) -> String {
    let direction = if grid.direction_deg == 0.0 { String::new() } else { format!(" at {}°", grid.direction_deg) };
    match (grid.u.count, grid.v.count) {
        (1, 1) => format!("slope {}, {}", grid.u.value(0.0), grid.v.value(0.0)),
        (_, 1) => format!("{}{direction}", grid.u),
        _ => format!("u {}, v {}{direction}", grid.u, grid.v),
    }
}
