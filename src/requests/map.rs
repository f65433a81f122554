//! Pictures of the motion: winning slopes, and the field of motion.

use crate::detector::quantity::BRIGHT;
use crate::detector::{Feature, MotionField, Slope, SlopeAxis, SlopeGrid};
use crate::inspect::place::WinningSlopes;
use crate::plane::display::{Rgb, direction_colour};
use image::{Rgba, RgbaImage};

#[derive(Debug, Clone, PartialEq)]
pub struct MotionMap {
    /// Each pixel's slope and its certainty (0 … 1), row by row.
    motions: Vec<(Slope, f32)>,
    width: usize,
    /// Slopes that were searched, which with the features decide the [colours](SlopeColours).
    pub grid: SlopeGrid,
    pub field: Option<MotionField>,
}

/// Colours of slopes: along a line those of a map, so that near and far differ; in a plane hue and saturation.
#[derive(Debug, Clone)]
pub struct SlopeColours {
    line: Option<(f32, SlopeAxis)>,
    /// Length of a slope in full colour, pixels per frame.
    max_px_per_frame: f32,
    table: [Rgb; 256],
}

/// Minimum share of the motions, weighted by SNR, close to a line, for all to count as lying on it.
const ON_LINE: f64 = 0.98;

/// The line along which `grid` was searched, or on which the motions of `features` lie in a plane of slopes (a still
/// scene before a moving camera): its direction, degrees from +u towards +v, and the axis from first to last slope.
pub fn line_of(grid: &SlopeGrid, features: &[Feature]) -> Option<(f32, SlopeAxis)> {
    if !grid.is_plane() || features.len() < 3 {
        return grid.as_line();
    }
    let seen: Vec<([f64; 2], f64)> = features
        .iter()
        .map(|feature| (feature.motion().0, f64::from(feature.snr)))
        .map(|(motion, snr)| ([motion.u, motion.v].map(f64::from), snr))
        .filter(|(at, weight)| at.iter().chain([weight]).all(|x| x.is_finite()))
        .collect();
    let total = seen.iter().map(|(_, weight)| weight).sum::<f64>();
    let mean = |of: &dyn Fn([f64; 2]) -> f64| seen.iter().map(|(at, weight)| weight * of(*at)).sum::<f64>() / total;
    let centre = [mean(&|at| at[0]), mean(&|at| at[1])];
    let spread = |i: usize, j: usize| mean(&|at| (at[i] - centre[i]) * (at[j] - centre[j]));
    // The main axis of the motions, weighted by SNR.
    let (uu, uv, vv) = (spread(0, 0), spread(0, 1), spread(1, 1));
    let angle = 0.5 * (2.0 * uv).atan2(uu - vv);
    let (sin, cos) = angle.sin_cos();
    let step = f64::from(grid.u.step().max(grid.v.step()));
    let is_on = |at: &[f64; 2]| ((at[1] - centre[1]) * cos - (at[0] - centre[0]) * sin).abs() <= step;
    let (mut share, mut min, mut max) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for (at, weight) in seen.iter().filter(|(at, _)| is_on(at)) {
        let along = at[0] * cos + at[1] * sin;
        (share, min, max) = (share + weight / total, min.min(along), max.max(along));
    }
    // Motions that are all alike lie on any line.
    let is_line = share >= ON_LINE && max - min > 2.0 * step;
    let count = (((max - min) / step).round() as usize + 1).max(2);
    is_line.then_some((angle.to_degrees() as f32, SlopeAxis { min: min as f32, max: max as f32, count }))
}

impl SlopeColours {
    pub fn of(grid: &SlopeGrid, features: &[Feature]) -> Self {
        let max_px_per_frame = grid.max_magnitude().max(f32::MIN_POSITIVE);
        Self { line: line_of(grid, features), max_px_per_frame, table: BRIGHT.map.lut() }
    }

    /// Length of the motions on the rim of the wheel of colours, pixels per frame; `None` for colours along a line.
    pub fn wheel(&self) -> Option<f32> {
        self.line.is_none().then_some(self.max_px_per_frame)
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
        let motions = (0..width * height).map(|place| at(place % width, place / width)).collect();
        Self { motions, width, grid: *grid, field: None }
    }

    /// Colours of the slopes, decided with `features` of the same slopes; brighter where surer, dark where unknown.
    pub fn colours(&self, features: &[Feature]) -> RgbaImage {
        let of_slopes = SlopeColours::of(&self.grid, features);
        // Most places share their slope with the one before.
        let mut last = None;
        RgbaImage::from_fn(self.width as u32, (self.motions.len() / self.width) as u32, |x, y| {
            let (slope, sure) = self.at((x as usize, y as usize));
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
        })
    }

    /// The motion at a pixel (column, row), and its certainty, 0 … 1.
    pub fn at(&self, (x, y): (usize, usize)) -> (Slope, f32) {
        self.motions[y * self.width + x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moving(u: f32, v: f32) -> Feature {
        Feature { slope: Slope::new(u, v), slope_sigma: 0.1, snr: 10.0, ..Feature::default() }
    }

    #[test]
    fn motions_on_a_line_of_a_plane_have_its_colours_and_others_those_of_directions() {
        let plane = SlopeGrid::plane(-4.0..=4.0, 9, -4.0..=4.0, 9);
        // A camera that moves at 30°, and a hundred depths.
        let still: Vec<Feature> = (0..100).map(|i| 0.04 * i as f32).map(|d| moving(0.866 * d, 0.5 * d)).collect();
        let (degrees, axis) = line_of(&plane, &still).expect("a line");
        assert!((degrees - 30.0).abs() < 0.1 && axis.min.abs() < 0.01 && (axis.max - 3.96).abs() < 0.01, "{axis:?}");
        let colours = SlopeColours::of(&plane, &still);
        assert_eq!(colours.colour(Slope::new(0.866, 0.5)), colours.colour(Slope::new(0.866 - 0.5, 0.5 + 0.866)));
        assert_ne!(colours.colour(Slope::new(0.866, 0.5)), colours.colour(Slope::new(3.0, 1.8)));
        let map = MotionMap::new((1, 1), &plane, |_, _| (Slope::new(0.866, 0.5), 1.0));
        let [r, g, b] = colours.colour(Slope::new(0.866, 0.5));
        assert!(map.colours(&still).get_pixel(0, 0).0 == [r, g, b, 255] && map.colours(&[]) != map.colours(&still));
        // Five of them rise: too many for a line, as lanterns in a street.
        let lanterns: Vec<Feature> = still.iter().copied().chain((0..5).map(|_| moving(0.0, -3.0))).collect();
        assert_eq!(line_of(&plane, &lanterns), None);
        assert_eq!(line_of(&plane, &vec![moving(1.0, 1.0); 50]), None, "all alike");
        assert_eq!(line_of(&SlopeGrid::line(-3.0..=2.0, 6), &lanterns).map(|(degrees, _)| degrees), Some(0.0));
    }
}
