//! Measurements of frames and of pairs of frames: their noise, the ratio of their brightness, the correlation of their
//! noise.

use crate::detector::noise_model::high_pass::{FREE_VALUES, HighPass, quiet_variance};
use rayon::prelude::*;

/// Correlation of consecutive frames below which it is taken for none.
const LEAST_CORRELATION: f32 = 0.15;

/// Variances in the squares of single frames and of differences of neighbours.
pub(super) struct Looks {
    /// For each frame, the variance in each square.
    pub(super) frames: Vec<Vec<f32>>,
    /// For each frame, the variance of the quiet squares.
    pub(super) noise: Vec<f32>,
    /// For each frame but the last, the variance of its difference to the next in each square.
    pairs: Vec<Vec<f32>>,
    /// For each of these differences, the variance of the quiet squares.
    in_pairs: Vec<f32>,
}

impl Looks {
    pub(super) fn new(squares: &HighPass) -> Self {
        let count = squares.frames();
        let quiet = |all: &Vec<Vec<f32>>| all.par_iter().map(|v| quiet_variance(v.clone(), FREE_VALUES)).collect();
        let frames: Vec<Vec<f32>> = (0..count).into_par_iter().map(|t| squares.variances(&[(t, 1.0)])).collect();
        let pairs = (1..count).into_par_iter().map(|t| squares.variances(&[(t - 1, 1.0), (t, -1.0)])).collect();
        Self { noise: quiet(&frames), in_pairs: quiet(&pairs), frames, pairs }
    }

    /// Variance of the noise of one frame, measured in the difference of two.
    pub(super) fn in_pair(&self, squares: &HighPass, a: usize, b: usize) -> f32 {
        if a + 1 == b {
            self.in_pairs[a]
        } else {
            quiet_variance(squares.variances(&[(a, 1.0), (b, -1.0)]), FREE_VALUES)
        }
    }
}

/// Ratio of brightnesses: the median over the squares, weighted by the reference's brightness.
pub(super) fn bright_ratio(squares: &[f32], reference: &[f32]) -> f32 {
    let mut ratios: Vec<(f32, f32)> =
        squares.iter().zip(reference).filter(|(_, r)| **r > 0.0).map(|(x, r)| (x / r, *r)).collect();
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * ratios.iter().map(|(_, weight)| weight).sum::<f32>();
    let mut so_far = 0.0;
    for (ratio, weight) in ratios {
        so_far += weight;
        if so_far >= half {
            return ratio;
        }
    }
    1.0
}

/// Standard deviation of values around their straight line over time; 0 for fewer than three.
pub(super) fn spread_without_trend(points: &[(f32, f32)]) -> f32 {
    let n = points.len() as f32;
    if points.len() < 3 {
        return 0.0;
    }
    let mean = |value: fn(&(f32, f32)) -> f32| points.iter().map(value).sum::<f32>() / n;
    let (t, x) = (mean(|p| p.0), mean(|p| p.1));
    let along = points.iter().map(|p| (p.0 - t) * (p.1 - x)).sum::<f32>();
    let slope = along / points.iter().map(|p| (p.0 - t).powi(2)).sum::<f32>();
    (points.iter().map(|p| (p.1 - x - slope * (p.0 - t)).powi(2)).sum::<f32>() / (n - 2.0)).sqrt()
}

/// Correlation of the noise of consecutive frames, from the flattest squares; 0 where shared texture may explain it.
pub(super) fn correlation(squares: &HighPass, looks: &Looks, kept: &[usize]) -> f32 {
    if kept.len() < 5 {
        return 0.0;
    }
    // The squares are chosen by the first frames and measured in the others, so that the choice does not bias the
    // measurement.
    let (choosing, measuring) = kept.split_at(2);
    let mean = |variances: &[&[f32]]| -> Vec<f32> {
        let n = variances.len() as f32;
        (0..squares.places.len()).map(|i| variances.iter().map(|v| v[i]).sum::<f32>() / n).collect()
    };
    let own =
        |frames: &[usize]| -> Vec<f32> { mean(&frames.iter().map(|&t| &looks.frames[t][..]).collect::<Vec<_>>()) };
    let chosen_by = own(choosing);
    let mut order: Vec<usize> = (0..squares.places.len()).collect();
    order.sort_by(|&a, &b| chosen_by[a].total_cmp(&chosen_by[b]));
    let flat = &order[..order.len().div_ceil(3)];
    let of_frames = own(measuring);
    let neighbours = measuring.windows(2).filter(|w| w[0] + 1 == w[1]);
    let of_pairs = mean(&neighbours.map(|w| &looks.pairs[w[0]][..]).collect::<Vec<_>>());
    let mut frames: Vec<f32> = flat.iter().map(|&i| of_frames[i]).collect();
    let pairs: f32 = flat.iter().map(|&i| of_pairs[i]).sum();
    let own: f32 = frames.iter().sum();
    if own <= 0.0 || pairs.is_nan() {
        return 0.0;
    }
    let shared = 1.0 - pairs / own;
    // Noise varies little from square to square; texture does.
    frames.sort_by(f32::total_cmp);
    let spread = frames[frames.len() * 8 / 10] / frames[frames.len() * 2 / 10].max(f32::MIN_POSITIVE);
    if shared > LEAST_CORRELATION && spread < 1.6 { shared.min(0.95) } else { 0.0 }
}

/// Median of `values` (the upper one of two); 0 where there are none.
pub(in crate::detector::noise_model) fn median(mut values: Vec<f32>) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}
