//! Test of whether the motion is straight: each frame is where a constant slope puts it.
//!
//! The correlations of frames t and t + 1, summed over the whole image, have their peak at the shift of the picture as
//! a whole. A constant motion gives an unchanging shift. The sum of the shifts is the picture's path; its largest
//! distance from a straight one is measured here.

use super::peak::{cubic, unbiased};
use super::spectra::{CrossSpectra, Fourier, SIDE};

/// Minimum significance of every pair of neighbours.
const LEAST_SIGNIFICANCE: f64 = 6.0;
/// Maximum number of steps up a peak, and the step length below which they end, level pixels.
const MAX_STEPS: usize = 60;
const FINEST_STEP: f64 = 0.02;
/// Standard error of a shift times the significance of its peak, level pixels: one over the root of the band's
/// curvature.
const SHIFT_ERROR: f64 = 1.2;

/// Largest distance of the picture's path from a uniform one, and the distance that noise alone would cause, in level
/// pixels; `None` where single pairs of frames are too noisy to measure it.
pub(super) fn deviation(products: &CrossSpectra, fourier: &Fourier) -> Option<[f64; 2]> {
    let frame_count = products.neighbours.len() + 1;
    let variance = products.variance.first()? / products.neighbours.len() as f64;
    if frame_count < 3 || variance <= 0.0 {
        return None;
    }
    let planes = fourier.correlations(&products.neighbours, &mut fourier.scratch(0));
    let (mut way, mut min) = (vec![[0.0, 0.0]], f64::INFINITY);
    for plane in &planes {
        let ([u, v], significance) = peak_of(plane, &fourier.overlap, variance)?;
        min = min.min(significance);
        let [x, y] = *way.last()?;
        way.push([x + u, y + v]);
    }
    // Each shift has an error of about a pixel divided by its significance; the errors add up along the path.
    let noise = SHIFT_ERROR / min * (planes.len() as f64).sqrt();
    Some([distance_from_a_line(&way), noise])
}

/// Shift at which a correlation is largest, and its significance; `None` where that is too small.
fn peak_of(plane: &[f32], overlap: &[f32], variance: f64) -> Option<([f64; 2], f64)> {
    let largest = (0..plane.len()).max_by(|a, b| plane[*a].total_cmp(&plane[*b]))?;
    let significance = f64::from(plane[largest]) / variance.sqrt();
    // Frames with values that are not finite have no significance either.
    if !significance.is_finite() || significance < LEAST_SIGNIFICANCE {
        return None;
    }
    let signed = |i: usize| if i > SIDE / 2 { i as f64 - SIDE as f64 } else { i as f64 };
    let mut at = [signed(largest % SIDE), signed(largest / SIDE)];
    let unbiased = unbiased(plane, overlap);
    // Hill climbing by steps that are halved at each top.
    let mut step = 0.5;
    for _ in 0..MAX_STEPS {
        let around = [[0.0, 0.0], [step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]];
        let value = |d: &[f64; 2]| cubic(&unbiased, [at[0] + d[0], at[1] + d[1]]);
        let best = around.iter().max_by(|a, b| value(a).total_cmp(&value(b)))?;
        if *best == [0.0, 0.0] {
            step *= 0.5;
        } else {
            at = [at[0] + best[0], at[1] + best[1]];
        }
        if step < FINEST_STEP {
            break;
        }
    }
    Some((at, significance))
}

/// Largest distance of points that follow each other at equal intervals from the uniform motion that fits them best.
fn distance_from_a_line(way: &[[f64; 2]]) -> f64 {
    let middle = 0.5 * (way.len() as f64 - 1.0);
    let times: Vec<f64> = (0..way.len()).map(|t| t as f64 - middle).collect();
    let spread: f64 = times.iter().map(|t| t * t).sum();
    let fit = |axis: usize| {
        let mean = way.iter().map(|x| x[axis]).sum::<f64>() / way.len() as f64;
        let slope = way.iter().zip(&times).map(|(x, t)| x[axis] * t).sum::<f64>() / spread;
        (mean, slope)
    };
    let fits = [fit(0), fit(1)];
    let off = |x: &[f64; 2], t: f64, axis: usize| x[axis] - fits[axis].0 - fits[axis].1 * t;
    way.iter().zip(&times).map(|(x, t)| off(x, *t, 0).hypot(off(x, *t, 1))).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_way_has_no_distance_and_a_bent_one_its_own() {
        let uniform: Vec<[f64; 2]> = (0..6).map(|t| [1.5 * f64::from(t), 2.0 - 0.5 * f64::from(t)]).collect();
        assert!(distance_from_a_line(&uniform) < 1e-12);
        let there_and_back = [[0.0, 0.0], [3.0, 0.0], [0.0, 0.0]];
        assert!((distance_from_a_line(&there_and_back) - 2.0).abs() < 1e-12);
    }
}
