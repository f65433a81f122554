//! Maps: pictures of quantities that decide in the search, by place.

use super::error::JobError;
use super::open::OpenBurst;
use super::trail::TrailStore;
use crate::detect::prepare;
use crate::detector::view::{combined_view, coverage_view, gate_noise_map};
use crate::detector::{Combine, DetectorParams, Slope, SlopeGrid};
use crate::inspect::candidates::{WinningSlopes, winning_slopes};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::display::direction_colour;
use image::{Rgba, RgbaImage};
use serde::{Deserialize, Serialize};

/// Classes of picture, each with a shared value range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RangeClass {
    /// Frames, motion-stack images and merged frames.
    Intensity,
    /// DoG responses.
    Response,
    /// Differences of two pictures.
    Difference,
    /// Maps of the noise.
    Noise,
    /// Maps of shares, 0 … 1.
    Share,
    /// Maps of winning slopes, which have colours of their own.
    Motion,
}

impl RangeClass {
    /// Name of the class within a sentence.
    pub fn label(self) -> &'static str {
        match self {
            Self::Intensity => "frames and motion stacks",
            Self::Response => "DoG responses",
            Self::Difference => "differences",
            Self::Noise => "noise maps",
            Self::Share => "coverage maps",
            Self::Motion => "winning-slope maps",
        }
    }
}

/// The kinds of map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapKind {
    /// σ of the noise in D at the slope, octave and level, as the noise gate takes it; fraction of full scale.
    Noise,
    /// The share (0 … 1) of the frames that see each place at the slope.
    Coverage,
    /// The slope with the strongest response at each place, at the octave and level: a picture of the motion. Its
    /// values are that response, over its noise.
    Motion,
    /// The median of the frames, shifted by the slope.
    Median,
    /// Their mean without outliers.
    ClippedMean,
    /// Their largest value.
    Max,
    /// Their smallest value.
    Min,
    /// Their standard deviation.
    Deviation,
    /// Their mean minus their median.
    MeanMinusMedian,
}

/// Description of a kind of map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AboutMap {
    /// Name of the map.
    pub label: &'static str,
    /// Explanation of the map.
    pub help: &'static str,
    /// Whether it depends on octave and level, and has the octave's pixels.
    pub of_scale: bool,
    /// Whether it depends on the slope.
    pub of_slope: bool,
    /// Class of its value range.
    pub range: RangeClass,
}

impl MapKind {
    /// All kinds, in the order of menus.
    pub const ALL: [Self; 9] = [
        Self::Noise,
        Self::Coverage,
        Self::Motion,
        Self::Median,
        Self::ClippedMean,
        Self::Max,
        Self::Min,
        Self::Deviation,
        Self::MeanMinusMedian,
    ];

    /// The way to combine the shifted frames that the map shows; `None` for other maps.
    pub fn combine(self) -> Option<Combine> {
        Some(match self {
            Self::Noise | Self::Coverage | Self::Motion => return None,
            Self::Median => Combine::Median,
            Self::ClippedMean => Combine::ClippedMean,
            Self::Max => Combine::Max,
            Self::Min => Combine::Min,
            Self::Deviation => Combine::Deviation,
            Self::MeanMinusMedian => Combine::MeanMinusMedian,
        })
    }

    /// Description of the map.
    pub fn about(self) -> AboutMap {
        let combined = |label, help, range| AboutMap { label, help, of_scale: false, of_slope: true, range };
        match self {
            Self::Median => combined(
                "Median of the frames",
                "The median of the frames, shifted by the slope: what is in fewer than half of them is gone",
                RangeClass::Intensity,
            ),
            Self::ClippedMean => combined(
                "Clipped mean",
                "The mean of the frames, shifted by the slope, without values far from the median",
                RangeClass::Intensity,
            ),
            Self::Max => combined(
                "Maximum",
                "The largest value of the frames, shifted by the slope: what is bright in any of them",
                RangeClass::Intensity,
            ),
            Self::Min => combined(
                "Minimum",
                "The smallest value of the frames, shifted by the slope: what is bright in all of them",
                RangeClass::Intensity,
            ),
            Self::Deviation => combined(
                "Deviation",
                "The standard deviation of the frames, shifted by the slope: noise, and what changes",
                RangeClass::Noise,
            ),
            Self::MeanMinusMedian => combined(
                "Mean minus median",
                "What is in some frames only stands out: satellites, cars, lamps that switch, hot pixels",
                RangeClass::Difference,
            ),
            Self::Noise => AboutMap {
                label: "Local noise",
                help: "σ of the noise in the DoG at the slope, octave and level, by place, as the noise gate takes it: \
                       a candidate must be several times as large",
                of_scale: true,
                of_slope: true,
                range: RangeClass::Noise,
            },
            Self::Coverage => AboutMap {
                label: "Coverage",
                help: "The share of the frames that see each place at the slope: \
                       where it is small, fewer frames are averaged and the noise is stronger",
                of_scale: false,
                of_slope: true,
                range: RangeClass::Share,
            },
            Self::Motion => AboutMap {
                label: "Winning slope",
                help: "The slope that answers most strongly at each place, at the octave and level: its direction is \
                       the colour, and it is the brighter the further all other slopes stay behind",
                of_scale: true,
                of_slope: false,
                range: RangeClass::Motion,
            },
        }
    }

    /// Computes the map; for [`Self::Motion`] also the data of its colours.
    pub(super) fn compute(
        self,
        open: &OpenBurst,
        params: &DetectorParams,
        (slope, octave, level): (Slope, i32, i32),
        (trails, monitor): (&dyn TrailStore, &Monitor),
    ) -> Result<(Plane, Option<MotionMap>), JobError> {
        if self == Self::Motion {
            let cache = trails.get_or_make_for(open, params, monitor)?;
            let winning = winning_slopes(&cache.trail, octave, level, monitor)?;
            return Ok((winning.snr.clone(), Some(MotionMap::new(winning, params.used_slopes()))));
        }
        let (burst, params) = prepare(&open.burst, params, monitor)?;
        if let Some(combine) = self.combine() {
            return Ok((combined_view(&burst, &params, slope, combine, monitor)?, None));
        }
        let plane = match self {
            Self::Coverage => coverage_view(&burst, &params, slope, monitor),
            _ => gate_noise_map(&burst, &params, slope, octave, level, monitor),
        };
        Ok((plane?, None))
    }
}

/// Winning slope of each place, and its colours.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionMap {
    /// Winning slope of each place, as an index.
    pub winning: WinningSlopes,
    /// The slopes.
    pub grid: SlopeGrid,
    /// One opaque pixel for each place: the slope's direction and length as hue and saturation, as features have them;
    /// the brighter the more certain, dark where no response reaches the noise gate.
    pub colours: RgbaImage,
}

/// Brightness of the least certain winner, as a fraction of that of the most certain.
const MIN_BRIGHTNESS: f32 = 0.35;
/// Grey value of places where no response reaches the gate.
const NOTHING: u8 = 26;

impl MotionMap {
    fn new(winning: WinningSlopes, grid: SlopeGrid) -> Self {
        let max = grid.max_magnitude().max(f32::MIN_POSITIVE);
        let table: Vec<[u8; 3]> =
            grid.slopes().map(|slope| direction_colour(slope.v.atan2(slope.u), slope.magnitude() / max)).collect();
        let (width, height) = winning.snr.size();
        let colours = RgbaImage::from_fn(width as u32, height as u32, |x, y| {
            let at = (x as usize, y as usize);
            let sure = winning.confidence.at(at.0, at.1);
            if sure <= 0.0 {
                return Rgba([NOTHING, NOTHING, NOTHING, 255]);
            }
            let brightness = MIN_BRIGHTNESS + (1.0 - MIN_BRIGHTNESS) * sure.sqrt();
            let [r, g, b] = table[winning.slope_index.at(at.0, at.1) as usize];
            let dimmed = |c: u8| (f32::from(c) * brightness) as u8;
            Rgba([dimmed(r), dimmed(g), dimmed(b), 255])
        });
        Self { winning, grid, colours }
    }

    /// The winning slope at a pixel (column, row), and its certainty, 0 … 1.
    pub fn at(&self, (x, y): (usize, usize)) -> (Slope, f32) {
        (self.grid.slope(self.winning.slope_index.at(x, y) as usize), self.winning.confidence.at(x, y))
    }
}
