//! Winning slopes: a picture of the motion.

use crate::detector::{Slope, SlopeGrid};
use crate::inspect::candidates::WinningSlopes;
use crate::plane::display::direction_colour;
use image::{Rgba, RgbaImage};

/// Winning slope of each place, and its colours.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionMap {
    pub winning: WinningSlopes,
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
    pub(super) fn new(winning: WinningSlopes, grid: SlopeGrid) -> Self {
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
