//! The response that a thing of known shape, size and motion should have in the search, and the SNR in D that follows.
//!
//! A thing's value under a Gaussian filter is known: that of a Gaussian blob in closed form, that of a disc as the
//! share of a Gaussian that lies in the disc. D is the difference of two of them. The stack at a slope of the grid is
//! the mean over the frames, each with the thing displaced by what its slope differs from the grid's.

use super::thing::Shape;
use burstscope_core::detector::{Scale, Slope, Trail, scale_space::SIGMA_INPUT, stack::interpolation_blur};

/// Expected response of a thing of amplitude 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// |D| of the search for an amplitude of 1, at the scale where it is largest.
    pub response: f64,
    /// σ_D there, fraction of full scale.
    pub sigma_d: f64,
}

impl Expected {
    /// SNR in D of a thing of `amplitude` (fraction of full scale).
    pub fn snr_d(&self, amplitude: f64) -> f64 {
        if self.sigma_d > 0.0 { amplitude.abs() * self.response / self.sigma_d } else { f64::INFINITY }
    }

    /// Amplitude whose SNR in D is `factor`, the noise gate.
    pub fn amplitude_at(&self, factor: f64) -> f64 {
        factor * self.sigma_d / self.response.max(f64::MIN_POSITIVE)
    }
}

/// Scales at which a thing is looked for: from its own divided by this ratio to its own times this ratio.
const SCALE_REACH: f64 = 2.0;

/// Response that the search of `trail` should give to a thing at `place` (input pixels) that moves at `slope`, at the
/// nearest slope of the grid. `None` where no scale of the search suits it, or no frame shows it.
pub fn expected(trail: &Trail, shape: Shape, radius: f64, place: (f64, f64), slope: Slope) -> Option<Expected> {
    let grid = trail.params().used_slopes();
    let at = grid.slope(grid.nearest(slope));
    let offsets = trail.offsets(at);
    let (_, kept, positions) = trail.frames();
    // The motion stack divides by the frames that cover a place, so only these count.
    let chosen = trail.showing((place.0 as f32, place.1 as f32), at);
    if chosen.is_empty() {
        return None;
    }
    let off = f64::from(slope.u - at.u).hypot(f64::from(slope.v - at.v));
    // Frames that mirror each other about mid-burst lie equally far off: each distance is filtered once.
    let displaced = distances(chosen.iter().map(|&index| positions.offset(kept[index]).length() * off).collect());
    let (blur_u, blur_v) = interpolation_blur(&offsets);
    // The filter starts from an assumed blur; a pixel is a square, and shifted frames are interpolated.
    let more = 1.0 / 12.0 + 0.5 * (blur_u + blur_v) - SIGMA_INPUT * SIGMA_INPUT;
    let (space, own_sigma) = (trail.space(), shape.sigma(radius));
    let mut best: Option<(f64, Scale)> = None;
    for octave in trail.octaves() {
        let sigma = |step: i32| space.sigma_image(octave, f64::from(step));
        let suits = |level: &i32| (own_sigma / SCALE_REACH..=own_sigma * SCALE_REACH).contains(&sigma(*level));
        let value = |step: i32| {
            let filter = (sigma(step).powi(2) + more).max(0.05).sqrt();
            let over_frames = |&(d, count): &(f64, usize)| count as f64 * filtered(shape, radius, filter, d);
            displaced.iter().map(over_frames).sum::<f64>() / chosen.len() as f64
        };
        // The upper end of a level is the lower one of the next.
        let mut known: Option<(i32, f64)> = None;
        for level in (0..space.levels as i32).filter(suits) {
            let low = known.filter(|(step, _)| *step == level).map_or_else(|| value(level), |(_, value)| value);
            let high = value(level + 1);
            known = Some((level + 1, high));
            let response = (low - high).abs();
            // A candidate is an extremum of D, not of its ratio to the noise.
            if best.is_none_or(|(best, _)| response > best) {
                best = Some((response, Scale { octave, level }));
            }
        }
    }
    let (response, scale) = best?;
    let sigma_d = f64::from(trail.sigma_d_at(scale, ((place.0 as f32, place.1 as f32), at), &chosen));
    Some(Expected { response, sigma_d })
}

/// The different distances among `all`, each with how often it occurs.
fn distances(mut all: Vec<f64>) -> Vec<(f64, usize)> {
    all.sort_by(f64::total_cmp);
    all.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect()
}

/// Value at a distance `off` from the centre of a thing of amplitude 1 under a Gaussian filter of `sigma` pixels.
fn filtered(shape: Shape, radius: f64, sigma: f64, off: f64) -> f64 {
    match shape {
        Shape::Disc => disc_filtered(radius, sigma, off),
        Shape::Blob => {
            let own = shape.sigma(radius).powi(2);
            let all = own + sigma * sigma;
            own / all * (-off * off / (2.0 * all)).exp()
        }
    }
}

/// Abscissae above 0 and weights of Gauss's integration with 16 points on −1 … 1 (Abramowitz and Stegun, 25.4.30).
const GAUSS: [(f64, f64); 8] = [
    (0.095_012_509_837_637_4, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_5),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_7),
    (0.755_404_408_355_003, 0.124_628_971_255_533_9),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_8),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_9),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_1),
];

/// Share of a Gaussian of standard deviation `sigma` around a point at distance `off` from a disc's centre that lies in
/// the disc of `radius`. A disc is at most a few σ wide here, so that few points give the integral over its rings.
fn disc_filtered(radius: f64, sigma: f64, off: f64) -> f64 {
    let s2 = sigma * sigma;
    let ring = |x: f64| {
        let rho = 0.5 * radius * (1.0 + x);
        rho / s2 * (-(rho - off).powi(2) / (2.0 * s2)).exp() * scaled_bessel_i0(rho * off / s2)
    };
    0.5 * radius * GAUSS.iter().map(|&(x, weight)| weight * (ring(x) + ring(-x))).sum::<f64>()
}

/// exp(−x)·I0(x) for x ≥ 0 (Abramowitz and Stegun, 9.8.1 and 9.8.2); the relative error is below 3e−7.
fn scaled_bessel_i0(x: f64) -> f64 {
    let polynomial = |y: f64, factors: &[f64]| factors.iter().rev().fold(0.0, |sum, factor| sum * y + factor);
    if x < 3.75 {
        let small = [1.0, 3.515_622_9, 3.089_942_4, 1.206_749_2, 0.265_973_2, 0.036_076_8, 0.004_581_3];
        (-x).exp() * polynomial((x / 3.75).powi(2), &small)
    } else {
        let large = [
            0.398_942_28,
            0.013_285_92,
            0.002_253_19,
            -0.001_575_65,
            0.009_162_81,
            -0.020_577_06,
            0.026_355_37,
            -0.016_476_33,
            0.003_923_77,
        ];
        polynomial(3.75 / x, &large) / x.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::chart::draw_disc;
    use burstscope_core::plane::{Plane, blur::GaussianKernel};

    #[test]
    fn a_filtered_disc_has_the_value_of_a_filtered_picture() {
        let mut plane = Plane::zeros(81, 81);
        draw_disc(&mut plane, 40.0, 40.0, 6.0, 1.0);
        let kernel = GaussianKernel::with_cut(3.5, 5.0);
        let blurred = burstscope_core::plane::blur::gaussian_blur(&plane, &kernel);
        // A pixel's square adds a twelfth to the variance.
        let sigma = (3.5f64 * 3.5 + 1.0 / 12.0).sqrt();
        for off in [0usize, 2, 5, 9] {
            let (is, should) = (f64::from(blurred.at(40 + off, 40)), disc_filtered(6.0, sigma, off as f64));
            assert!((is - should).abs() < 2e-3, "{off}: {is} {should}");
        }
        // In the middle of a disc, and where the disc is as wide, relative to the filter, as it ever is.
        for (radius, sigma) in [(6.0f64, 3.5), (5.0, 0.35 * 5.0), (16.0, 0.35 * 16.0)] {
            let should = 1.0 - (-radius * radius / (2.0 * sigma * sigma)).exp();
            assert!((disc_filtered(radius, sigma, 0.0) - should).abs() < 1e-6, "{radius} {sigma}");
        }
    }
}
