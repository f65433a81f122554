//! What changes from pixel to pixel in a frame, at places spread over the image: mostly its noise.
//!
//! Frames are halved and filtered by the second difference in u and in v (mask `[1 −2 1]ᵀ[1 −2 1]`), which removes everything locally linear. The filter runs
//! in squares of 16×16 image pixels, the same in every frame, so that a combination of frames is filtered as the same combination of filtered frames. Halving first looks at
//! frequencies that the search looks at too; the very finest are what files and demosaicing change most.

use super::pyramid::BoxPyramid;
use crate::plane::Plane;

/// Side of a square, halved pixels.
const SIDE: usize = 8;
/// Values of a square.
const AREA: usize = SIDE * SIDE;
/// Pixels of a square in the image.
pub const SQUARE_PIXELS: usize = 4 * AREA;
/// Most squares that are looked at: enough for a hundredth of accuracy overall and for a map of the image.
const MAX_SQUARES: usize = 1024;
/// Variance of the filtered halved pixels for white noise of variance 1 in the frame's own: the mask's squares sum to 36, a mean over four has a quarter.
const GAIN: f32 = 9.0;
/// Independent values of a square, as far as its mean square is concerned: the filter's values are correlated, and Σρ² over a square is 3.31.
pub const FREE_VALUES: f32 = AREA as f32 / 3.31;

/// The filtered squares of some frames.
#[derive(Debug, Clone)]
pub struct HighPass {
    /// Middle of each square, image pixels.
    pub places: Vec<(f32, f32)>,
    /// For each frame, the values of all squares.
    values: Vec<Vec<f32>>,
    /// For each frame, the mean of each square, fraction of full scale.
    pub brightness: Vec<Vec<f32>>,
}

impl HighPass {
    /// The squares of frames of one size, given as their pyramids; none where a side is under 20 pixels.
    pub fn new(pyramids: &[&BoxPyramid]) -> Self {
        let corners = pyramids.first().filter(|p| !p.is_empty()).map_or_else(Vec::new, |p| corners(p.level(1).size()));
        let places = corners.iter().map(|&(x, y)| ((2 * x + SIDE) as f32 - 0.5, (2 * y + SIDE) as f32 - 0.5)).collect();
        let values =
            pyramids.iter().map(|p| if corners.is_empty() { Vec::new() } else { filtered(p.level(1), &corners) });
        let brightness = pyramids.iter().map(|p| corners.iter().map(|&corner| mean(p.level(1), corner)).collect());
        Self { values: values.collect(), brightness: brightness.collect(), places }
    }

    /// The same of some of the frames.
    pub fn only(&self, frames: &[usize]) -> Self {
        Self {
            places: self.places.clone(),
            values: frames.iter().map(|&t| self.values[t].clone()).collect(),
            brightness: frames.iter().map(|&t| self.brightness[t].clone()).collect(),
        }
    }

    /// How many frames there are.
    pub fn frames(&self) -> usize {
        self.values.len()
    }

    /// The variance of white noise of one frame that would explain each square of the combination Σ `weights`·frame.
    pub fn variances(&self, weights: &[(usize, f32)]) -> Vec<f32> {
        let scale = 1.0 / (GAIN * AREA as f32 * weights.iter().map(|(_, w)| w * w).sum::<f32>());
        (0..self.places.len())
            .map(|square| {
                let range = square * AREA..(square + 1) * AREA;
                let mut sums = [0.0f32; AREA];
                for &(frame, weight) in weights {
                    sums.iter_mut().zip(&self.values[frame][range.clone()]).for_each(|(sum, x)| *sum += weight * x);
                }
                sums.iter().map(|x| x * x).sum::<f32>() * scale
            })
            .collect()
    }

    /// Whether the filtered values of two frames are exactly the same.
    pub fn same(&self, a: usize, b: usize) -> bool {
        self.values[a] == self.values[b] && self.brightness[a] == self.brightness[b]
    }
}

/// The first columns and rows of the squares of a halved image of `size`, spread evenly; a pixel stays free around them.
fn corners((width, height): (usize, usize)) -> Vec<(usize, usize)> {
    let (columns, rows) = (width.saturating_sub(2) / SIDE, height.saturating_sub(2) / SIDE);
    let total = columns * rows;
    let count = total.min(MAX_SQUARES);
    // Every so many of all squares; the rows are walked so that the columns that are taken move on from row to row.
    (0..count)
        .map(|i| {
            let index = (i as u64 * total as u64 / count as u64) as usize;
            let (column, row) = (index % columns, index / columns);
            let shifted = if count < total { (column + row * 7) % columns } else { column };
            (1 + shifted * SIDE, 1 + row * SIDE)
        })
        .collect()
}

fn filtered(halved: &Plane, corners: &[(usize, usize)]) -> Vec<f32> {
    let mut out = Vec::with_capacity(corners.len() * AREA);
    for &(x, y) in corners {
        for v in y..y + SIDE {
            let row = |v: usize| -> &[f32; SIDE + 2] {
                halved.row(v)[x - 1..=x + SIDE].try_into().expect("a square and a pixel on each side")
            };
            let (above, at, below) = (row(v - 1), row(v), row(v + 1));
            let mut second = [0.0; SIDE + 2];
            for (i, second) in second.iter_mut().enumerate() {
                *second = above[i] - 2.0 * at[i] + below[i];
            }
            out.extend((0..SIDE).map(|i| second[i] - 2.0 * second[i + 1] + second[i + 2]));
        }
    }
    out
}

fn mean(halved: &Plane, (x, y): (usize, usize)) -> f32 {
    (y..y + SIDE).map(|v| halved.row(v)[x..x + SIDE].iter().sum::<f32>()).sum::<f32>() / AREA as f32
}

/// The variance that the quieter part of some squares' variances tells, where texture may have been added to the others.
///
/// The mean of the lowest seven tenths, over what it is for noise alone: the variances of `free` independent values each spread by √(2/`free`), and the mean of the lowest
/// seven tenths of that distribution (χ²) lies 0.51 of it below the whole's.
pub fn quiet_variance(mut variances: Vec<f32>, free: f32) -> f32 {
    let count = (variances.len() * 7).div_ceil(10);
    if count == 0 {
        return 0.0;
    }
    if count < variances.len() {
        variances.select_nth_unstable_by(count, f32::total_cmp);
    }
    let lowest = &variances[..count];
    let expected = if count < variances.len() { 1.0 - 0.513 * (2.0 / free).sqrt() } else { 1.0 };
    lowest.iter().sum::<f32>() / (count as f32 * expected)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::random::Stream;

    fn noise(size: (usize, usize), sigma: f64, seed: u64) -> BoxPyramid {
        let mut stream = Stream::new(seed, 0);
        BoxPyramid::new(&Plane::from_fn(size.0, size.1, |u, _| 1e-3 * u as f32 + (sigma * stream.normal()) as f32), 1)
    }

    #[test]
    fn white_noise_on_a_ramp_has_its_variance_in_every_combination() {
        let pyramids = [noise((400, 300), 0.02, 1), noise((400, 300), 0.02, 2), noise((400, 300), 0.02, 3)];
        let squares = HighPass::new(&pyramids.iter().collect::<Vec<_>>());
        for weights in [&[(0, 1.0)][..], &[(0, 1.0), (1, -1.0)], &[(0, 1.0), (1, -2.0), (2, 1.0)]] {
            let variances = squares.variances(weights);
            let mean = variances.iter().sum::<f32>() / variances.len() as f32;
            assert!((mean / 4e-4 - 1.0).abs() < 0.03, "{mean}");
            let spread = variances.iter().map(|v| (v / mean - 1.0).powi(2)).sum::<f32>() / variances.len() as f32;
            assert!((spread * FREE_VALUES / 2.0 - 1.0).abs() < 0.2, "{spread}");
            let quiet = quiet_variance(variances, FREE_VALUES);
            assert!((quiet / 4e-4 - 1.0).abs() < 0.04, "{quiet}");
        }
        assert!(squares.same(1, 1) && !squares.same(1, 2));
    }

    #[test]
    fn texture_in_a_quarter_of_the_squares_changes_little() {
        let pyramid = noise((800, 600), 0.02, 1);
        let squares = HighPass::new(&[&pyramid]);
        assert_eq!(squares.places.len(), MAX_SQUARES);
        let mut variances = squares.variances(&[(0, 1.0)]);
        variances.iter_mut().step_by(4).for_each(|v| *v *= 10.0);
        let quiet = quiet_variance(variances, FREE_VALUES);
        assert!((quiet / 4e-4 - 1.0).abs() < 0.2, "{quiet}");
    }

    #[test]
    fn squares_lie_inside_and_everywhere() {
        let corners = corners((2000, 1500));
        assert_eq!(corners.len(), MAX_SQUARES);
        assert!(corners.iter().all(|&(x, y)| x >= 1 && y >= 1 && x + SIDE < 2000 && y + SIDE < 1500));
        let mut counts = [0usize; 20];
        corners.iter().for_each(|&(x, y)| counts[y / 300 * 4 + x / 500] += 1);
        assert!(counts.iter().all(|&n| n > MAX_SQUARES / 40), "{counts:?}");
        assert!(HighPass::new(&[&noise((18, 300), 0.1, 1)]).places.is_empty());
        assert!(HighPass::new(&[]).places.is_empty());
    }
}
