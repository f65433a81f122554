//! Noise gate: the noise of the frames propagated to D, and the threshold on |D| that follows.
//!
//! A threshold on |D| alone lets fine-scale noise through and loses large faint blobs, because the noise in D falls
//! with scale while a blob's response does not. So the noise of one frame, σ_F ([`crate::detector::noise::estimate`]),
//! is carried through the mean over frames, the interpolation and the DoG filter; the gate requires |D| ≥ k·σ_D at each
//! octave and level.
//!
//! Propagation. For white noise the variance in D is σ_F² times the energy of the whole filter. All its parts are close
//! to Gaussians, whose inner products are known: ∫ g(A)·g(B) = 1/√(2π(A+B)) in one dimension, for variances A and B.
//! Bilinear sampling at a fraction f adds the variance f(1−f) in its direction; that differs from frame to frame and is
//! averaged over them.

use crate::detector::params::{DetectorParams, NoiseGate, SlopeExtrema};
use crate::detector::scale_space::levels::{SIGMA_INPUT, ScaleSpace};
use crate::kernel::stack::FrameOffset;

/// Variance of D of the mean over the frames at `offsets`, at `octave` and `level` (−1 … S), for white noise of
/// variance 1 in each frame, where all frames cover the pixel.
pub fn dog_noise_variance(space: &ScaleSpace, octave: i32, level: f64, offsets: &[FrameOffset]) -> f64 {
    // Where the first octave skips pixels the noise is white on the kept ones; lengths are then in those pixels.
    let unit = 2f64.powi(space.first_octave.max(0));
    let input = SIGMA_INPUT / unit;
    let variance = |s: f64| (space.sigma_image(octave, s) / unit).powi(2) - input * input;
    let (low, high) = (variance(level), variance(level + 1.0));
    let product = |a: f64, b: f64| 1.0 / (2.0 * std::f64::consts::PI * (a + b)).sqrt();
    // Doubling interpolates every second pixel half-way: a quarter of an input pixel² there, on average an eighth.
    let doubling = if space.first_octave < 0 { 0.125 } else { 0.0 };
    let total: f64 = offsets
        .iter()
        .map(|offset| {
            let spread = |part: f32| {
                let f = f64::from(part);
                if unit > 1.0 { (0.0, (1.0 - f).powi(2) + f * f) } else { (f * (1.0 - f) + doubling, 1.0) }
            };
            let ((u, gain_u), (v, gain_v)) = (spread(offset.part_u), spread(offset.part_v));
            let both = |a: f64, b: f64| product(a + u, b + u) * product(a + v, b + v);
            (both(low, low) - 2.0 * both(low, high) + both(high, high)) * gain_u * gain_v
        })
        .sum();
    total / (offsets.len() as f64).powi(2)
}

/// Variance of the difference of two isotropic Gaussians of variances `low` and `high` (pixels²) for white noise of
/// variance 1 in each pixel.
pub(in crate::detector) fn dog_energy(low: f64, high: f64) -> f64 {
    let product = |a: f64, b: f64| 1.0 / (2.0 * std::f64::consts::PI * (a + b));
    product(low, low) - 2.0 * product(low, high) + product(high, high)
}

/// The gate's factor k: the one given, or the one at which white noise gives about [`STRICT_FALSE_PER_MEGAPIXEL`] or
/// [`AUTO_FALSE_PER_MEGAPIXEL`] false keypoints per megapixel of the input over all slopes and octaves.
///
/// The number of local maxima of a smooth Gaussian field above k falls like k²·exp(−k²/2) per independent place; the
/// places are proportional to pixels and slopes. The factor in front, [`MAXIMA_PER_PIXEL`], was measured on pure noise.
pub fn gate_factor(params: &DetectorParams) -> f32 {
    let allowed = match params.noise_gate {
        NoiseGate::Factor(k) => return k,
        NoiseGate::Strict => STRICT_FALSE_PER_MEGAPIXEL,
        NoiseGate::Auto => AUTO_FALSE_PER_MEGAPIXEL,
    };
    let maxima = match params.slope_extrema {
        SlopeExtrema::Each => MAXIMA_PER_PIXEL,
        SlopeExtrema::Joint => JOINT_MAXIMA_PER_PIXEL,
    };
    let slopes = params.used_slopes().len() as f64;
    // Octave 0 and the coarser ones have 4/3 of its places; the doubled image has four times as many.
    let places = 1e6 * 4f64.powi(-params.first_octave) * slopes;
    let expected = |k: f64| maxima * places * k * k * (-0.5 * k * k).exp();
    let (mut low, mut high) = (2.0, 12.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if expected(middle) > allowed {
            low = middle;
        } else {
            high = middle;
        }
    }
    high as f32
}

/// Target of the strict gate: false keypoints per megapixel of pure noise. With two orientations a keypoint is up to
/// two features, and at most one false feature a megapixel is promised.
pub const STRICT_FALSE_PER_MEGAPIXEL: f64 = 0.5;
/// Target of the automatic gate, which serves matching: false keypoints per megapixel of pure noise. They are few
/// beside true ones and find no match, while the faint true ones that pass add to the inliers (docs/MEASUREMENTS.md).
pub const AUTO_FALSE_PER_MEGAPIXEL: f64 = 5.0;
/// Factor of `gate_factor` for extrema at each slope for itself, one for one blob. Measured on 12 to 20 Mpx of white
/// noise as 0.00016 … 0.00028 between k = 4.0 and 5.3, for 13 slopes on a line, 7×7, and the doubled image. See
/// [`gate_factor`].
pub const MAXIMA_PER_PIXEL: f64 = 0.000_2;
/// Factor of `gate_factor` for joint extrema. Measured between k = 3.6 and 4.8 on 18 Mpx of white noise as 0.0002 …
/// 0.0004, for one slope, 7 and 13 on a line, 7×7, and the doubled image.
pub const JOINT_MAXIMA_PER_PIXEL: f64 = 0.000_35;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::params::Interpolation;
    use crate::detector::params::slope_grid::Slope;
    use crate::detector::stack::offsets::frame_offsets;
    use crate::plane::Plane;
    use crate::synth::random::Stream;

    #[test]
    fn propagated_noise_is_what_the_filters_leave() {
        use crate::detector::scale_space::octave::{DogTile, OctaveFilters, Pixels, dog_tile, stack_tiles};
        use crate::kernel::gaussian_bank::FilterScratch;
        use crate::plane::tile::Region;
        let mut noise = Stream::new(7, 0);
        let frames = [(); 4].map(|()| Plane::from_fn(300, 200, |_, _| noise.normal() as f32));
        let frames: Vec<&Plane> = frames.iter().collect();
        for (first_octave, size) in [(0, (300, 200)), (-1, (600, 400)), (1, (150, 100))] {
            for slope in [Slope::new(0.0, 0.0), Slope::new(0.5, 0.0), Slope::new(1.25, -0.75)] {
                let space = ScaleSpace::new(3, first_octave, 4.0);
                let offsets = frame_offsets(4, slope, Interpolation::Linear);
                let whole = Region { columns: 0..size.0, rows: 0..size.1 };
                let bank = space.bank(true, space.all_levels());
                let filters = OctaveFilters::new(&space, &bank, &space.all_levels(), size);
                let (mut stacked, mut dog) = (Vec::new(), DogTile::default());
                stack_tiles(&frames, &[&offsets], first_octave, &whole, &mut stacked);
                let pixels = Pixels::Stacked(&stacked[0]);
                dog_tile(&filters, pixels, &whole, &mut FilterScratch::default(), &mut dog, None, &mut |_, _| ());
                for level_index in [1, 3] {
                    let data: Vec<f64> = (30..size.1 - 30)
                        .flat_map(|v| dog.levels[level_index].row(v)[30..size.0 - 30].iter().map(|&x| f64::from(x)))
                        .collect();
                    let measured = (data.iter().map(|x| x * x).sum::<f64>() / data.len() as f64).sqrt();
                    let predicted = dog_noise_variance(&space, first_octave, level_index as f64 - 1.0, &offsets).sqrt();
                    let tolerance = if first_octave == 1 { 0.12 } else { 0.06 };
                    assert!(
                        (measured / predicted - 1.0).abs() < tolerance,
                        "octave {first_octave} {slope:?} {level_index}: {measured} {predicted}"
                    );
                }
            }
        }
    }

    #[test]
    fn larger_searches_have_higher_gates() {
        let one =
            DetectorParams { slopes: crate::detector::SlopeGrid::line(-3.0..=3.0, 7), ..DetectorParams::default() };
        let two =
            DetectorParams { slopes: crate::detector::SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), ..one.clone() };
        assert!(gate_factor(&two) > gate_factor(&one) + 0.2);
        let strict = DetectorParams { noise_gate: NoiseGate::Strict, ..one.clone() };
        // A tenth of the false alarms is about ln 10 / k more.
        assert!((gate_factor(&strict) - gate_factor(&one) - 10f32.ln() / gate_factor(&one)).abs() < 0.1);
        let fixed = DetectorParams { noise_gate: NoiseGate::Factor(4.5), ..one };
        assert_eq!(gate_factor(&fixed), 4.5);
    }
}
