//! Pictures of the motion: winning slopes, and the field of motion.

use crate::detector::quantity::BRIGHT;
use crate::detector::{MotionField, Slope, SlopeAxis, SlopeGrid};
use crate::inspect::candidates::WinningSlopes;
use crate::plane::display::{Rgb, direction_colour};
use image::{Rgba, RgbaImage};

/// Motion of each pixel, and its colours.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionMap {
    /// Each pixel's slope and its certainty (0 … 1), row by row.
    motions: Vec<(Slope, f32)>,
    /// Slopes that were searched, which decide the [colours](SlopeColours).
    pub grid: SlopeGrid,
    /// The slopes' colours, the brighter the more certain, dark where nothing is known.
    pub colours: RgbaImage,
    /// The field of motion, in its picture.
    pub field: Option<MotionField>,
}

/// Colours of slopes: along a line those of a map, from its first slope to its last, so that near and far differ; in a
/// plane direction and length as hue and saturation.
#[derive(Debug, Clone)]
pub struct SlopeColours {
    line: Option<(f32, SlopeAxis)>,
    /// Length of a slope in full colour, pixels per frame.
    max_px_per_frame: f32,
    table: [Rgb; 256],
}

impl SlopeColours {
    pub fn of(grid: &SlopeGrid) -> Self {
        let max_px_per_frame = grid.max_magnitude().max(f32::MIN_POSITIVE);
        Self { line: grid.as_line(), max_px_per_frame, table: BRIGHT.map.lut() }
    }

    pub fn colour(&self, slope: Slope) -> Rgb {
        let Some((degrees, axis)) = self.line else {
            return direction_colour(slope.v.atan2(slope.u), (slope.magnitude() / self.max_px_per_frame).min(1.0));
        };
        let (sin, cos) = degrees.to_radians().sin_cos();
        let along = (cos * slope.u + sin * slope.v - axis.min) / (axis.max - axis.min);
        let [first, last] = BRIGHT.part;
        self.table[(255.0 * (first + (last - first) * along.clamp(0.0, 1.0))).round() as usize]
    }
}

/// Brightness of the least certain motion, as a fraction of that of the most certain.
const MIN_BRIGHTNESS: f32 = 0.35;
/// Grey value of places whose motion is unknown, and where no response reaches the gate.
const NOTHING: u8 = 26;

impl MotionMap {
    pub(super) fn winning(winning: &WinningSlopes, grid: &SlopeGrid) -> Self {
        let slopes: Vec<Slope> = grid.slopes().collect();
        let slope = |x: usize, y: usize| slopes[winning.slope_index.at(x, y) as usize];
        Self::new(winning.snr.size(), grid, |x, y| (slope(x, y), winning.confidence.at(x, y)))
    }

    /// The field on the pixels of an image of `size` (columns, rows).
    pub(super) fn field(field: MotionField, size: (usize, usize), grid: &SlopeGrid) -> Self {
        let map = Self::new(size, grid, |x, y| {
            let motion = field.at(x as f32, y as f32);
            (motion.slope, field.certainty(&motion))
        });
        Self { field: Some(field), ..map }
    }

    fn new((width, height): (usize, usize), grid: &SlopeGrid, at: impl Fn(usize, usize) -> (Slope, f32)) -> Self {
        let motions: Vec<(Slope, f32)> = (0..width * height).map(|place| at(place % width, place / width)).collect();
        let of_slopes = SlopeColours::of(grid);
        // Most places share their slope with the one before.
        let mut last = None;
        let colours = RgbaImage::from_fn(width as u32, height as u32, |x, y| {
            let (slope, sure) = motions[y as usize * width + x as usize];
            if sure <= 0.0 {
                return Rgba([NOTHING, NOTHING, NOTHING, 255]);
            }
            let colour = match last {
                Some((of, colour)) if of == slope => colour,
                _ => of_slopes.colour(slope),
            };
            last = Some((slope, colour));
            let brightness = MIN_BRIGHTNESS + (1.0 - MIN_BRIGHTNESS) * sure.sqrt();
            let [r, g, b] = colour.map(|c: u8| (f32::from(c) * brightness) as u8);
            Rgba([r, g, b, 255])
        });
        Self { motions, grid: *grid, colours, field: None }
    }

    /// The motion at a pixel (column, row), and its certainty, 0 … 1.
    pub fn at(&self, (x, y): (usize, usize)) -> (Slope, f32) {
        self.motions[y * self.colours.width() as usize + x]
    }
}
