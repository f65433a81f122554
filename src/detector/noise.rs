//! The noise of a frame, estimated from the burst itself, and what is left of it in D: the noise gate.
//!
//! A threshold on |D| alone lets fine-scale noise through and loses large faint blobs, because the noise in D falls with scale while a blob's
//! response does not. So the noise of one frame, σ_F, is estimated and carried through the mean over frames, the interpolation and the DoG
//! filter; the gate asks for |D| ≥ k·σ_D at each octave and level.
//!
//! Estimate. Both each frame and each difference of consecutive frames are filtered by the second difference in u and in v (mask
//! `[1 −2 1]ᵀ[1 −2 1]`, gain 6 for white noise), which removes everything locally linear; the median of the magnitudes over 0.6745 is the standard
//! deviation, whatever a minority of edges does. Texture can only add, so the smaller of the two estimates is taken.
//!
//! Pixels at the ends of the file's range are left out: in the black parts of a dark frame the noise is cut off at zero, and half an image of zeros would
//! make any median zero.
//!
//! Propagation. For white noise the variance in D is σ_F² times the energy of the whole filter. All its parts are close to Gaussians, whose inner
//! products are known: ∫ g(A)·g(B) = 1/√(2π(A+B)) in one dimension, for variances A and B. Bilinear sampling at a fraction f adds the
//! variance f(1−f) in its direction; that differs from frame to frame and is averaged over them.

use super::motion::FrameOffset;
use super::params::{DetectorParams, NoiseGate};
use super::scale_space::{SIGMA_INPUT, ScaleSpace};
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use rayon::prelude::*;
use std::ops::Range;

/// Median of |x| of a standard normal variable.
const MEDIAN_OF_NORMAL: f32 = 0.674_49;
/// Most samples that one estimate looks at; its standard error is then about half a percent, and that of the median over frames less.
const MAX_SAMPLES: usize = 60_000;

/// The standard deviation of one frame's noise, fraction of full scale, from the frames `used` of a burst. At least the rounding error of the
/// files' numbers (step/√12). 0 for noiseless float frames or images under 3×3 pixels.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn frame_noise(burst: &Burst, used: Range<usize>, monitor: &Monitor) -> Result<f32, Cancelled> {
    let frames: Vec<&Plane> = burst.frames[used].iter().map(|f| &**f).collect();
    let step = burst.quantisation_step;
    let of_frames = estimates(frames.iter().map(|f| (*f, None)).collect(), step, monitor)?;
    let of_pairs = estimates(frames.windows(2).map(|w| (w[0], Some(w[1]))).collect(), step, monitor)?;
    let mut sigma = median(of_frames);
    if !of_pairs.is_empty() {
        sigma = sigma.min(median(of_pairs));
    }
    Ok(sigma.max(step / 12f32.sqrt()))
}

fn estimates(planes: Vec<(&Plane, Option<&Plane>)>, step: f32, monitor: &Monitor) -> Result<Vec<f32>, Cancelled> {
    planes
        .into_par_iter()
        .map(|(first, second)| {
            monitor.check()?;
            Ok(match second {
                None => noise_of(first.size(), |at| (first.data()[at], is_cut_off(first.data()[at], step)), step),
                Some(second) => {
                    let difference = |at: usize| {
                        let (a, b) = (first.data()[at], second.data()[at]);
                        (b - a, is_cut_off(a, step) || is_cut_off(b, step))
                    };
                    noise_of(first.size(), difference, step) / 2f32.sqrt()
                }
            })
        })
        .collect()
}

/// Whether a value is at the end of what the file can hold, so that its noise was cut off.
fn is_cut_off(value: f32, step: f32) -> bool {
    step > 0.0 && (value < 0.5 * step || value > 1.0 - 0.5 * step)
}

/// The standard deviation of the white noise in an image of `size`, whose pixel with running index `at` gives its value and whether it is cut off;
/// `step` is the smallest difference of its values. Places that touch a cut-off pixel don't count, unless nearly all do.
fn noise_of(size: (usize, usize), pixel: impl Fn(usize) -> (f32, bool), step: f32) -> f32 {
    let (width, height) = size;
    if width < 3 || height < 3 {
        return 0.0;
    }
    let total = (width - 2) * (height - 2);
    // A stride without a common factor with usual widths spreads the samples over the image.
    let stride = if total > MAX_SAMPLES { (total / MAX_SAMPLES) | 1 } else { 1 };
    let sample = |i: usize| {
        let centre = (1 + i / (width - 2)) * width + 1 + i % (width - 2);
        let (mut sum, mut cut_off) = (0.0, false);
        for (row, weight_v) in [(centre - width, 1.0), (centre, -2.0), (centre + width, 1.0)] {
            for (at, weight_u) in [(row - 1, 1.0), (row, -2.0), (row + 1, 1.0)] {
                let (value, cut) = pixel(at);
                sum += weight_u * weight_v * value;
                cut_off |= cut;
            }
        }
        (sum.abs(), cut_off)
    };
    let samples: Vec<(f32, bool)> = (0..total).step_by(stride).map(sample).collect();
    let mut magnitudes: Vec<f32> = samples.iter().filter(|(_, cut_off)| !cut_off).map(|(x, _)| *x).collect();
    if magnitudes.len() * 20 < samples.len() {
        magnitudes = samples.into_iter().map(|(x, _)| x).collect();
    }
    median_on_lattice(&mut magnitudes, step) / (MEDIAN_OF_NORMAL * 6.0)
}

/// The median of values that lie on a lattice of spacing `step` (0: continuous): each lattice value stands for the interval around it, so the median
/// falls inside the interval in proportion to the counts.
fn median_on_lattice(values: &mut [f32], step: f32) -> f32 {
    let middle = values.len() / 2;
    let (_, &mut median, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
    if step <= 0.0 {
        return median;
    }
    let near = |x: f32| (x - median).abs() < 0.5 * step;
    let below = values.iter().filter(|&&x| !near(x) && x < median).count() as f32;
    let equal = values.iter().filter(|&&x| near(x)).count() as f32;
    // Magnitudes: the value 0 stands for a half interval only.
    let (start, length) = if median < 0.5 * step { (0.0, 0.5 * step) } else { (median - 0.5 * step, step) };
    start + length * (values.len() as f32 * 0.5 - below) / equal
}

fn median(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    values.select_nth_unstable_by(middle, f32::total_cmp);
    values[middle]
}

/// Variance of D at `octave` and `level` (−1 … S) for white noise of variance 1 in each frame, where all frames cover: of the mean over the
/// frames at `offsets`.
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

/// The gate's factor k: the one asked for, or the one at which white noise gives about [`FALSE_PER_MEGAPIXEL`] false features per megapixel of the
/// first octave over all slopes.
///
/// The number of local maxima of a smooth Gaussian field above k falls like k²·exp(−k²/2) per independent place; the places are proportional
/// to pixels and slopes. The factor in front, [`MAXIMA_PER_PIXEL`], was measured on pure noise.
pub fn gate_factor(params: &DetectorParams) -> f32 {
    match params.noise_gate {
        NoiseGate::Factor(k) => k,
        NoiseGate::Auto => {
            let slopes = params.used_slopes().len() as f64;
            // Octave 0 and the coarser ones have 4/3 of its places; the doubled image has four times as many.
            let places = 1e6 * 4f64.powi(-params.first_octave) * slopes;
            let expected = |k: f64| MAXIMA_PER_PIXEL * places * k * k * (-0.5 * k * k).exp();
            let (mut low, mut high) = (2.0, 12.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if expected(middle) > FALSE_PER_MEGAPIXEL {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            high as f32
        }
    }
}

/// False features per megapixel of pure noise that the automatic gate aims at: half of the one that is promised.
pub const FALSE_PER_MEGAPIXEL: f64 = 0.5;
/// Measured between k = 3.6 and 4.8 on 18 Mpx of white noise as 0.0002 … 0.0004, for one slope, 7 and 13 on a line, 7×7, and the doubled image.
/// See [`gate_factor`].
pub const MAXIMA_PER_PIXEL: f64 = 0.000_35;

#[cfg(test)]
mod tests {
    use super::super::motion::frame_offsets;
    use super::super::params::Interpolation;
    use super::super::slope_grid::Slope;
    use super::*;
    use crate::synth::random::Stream;

    fn noisy_burst(sigma: f32, n: usize, scene: impl Fn(usize, usize) -> f32, round_to: f32) -> Burst {
        let mut noise = Stream::new(7, 0);
        let frames = (0..n)
            .map(|_| {
                Plane::from_fn(300, 200, |u, v| {
                    let value = scene(u, v) + sigma * noise.normal() as f32;
                    if round_to > 0.0 { (value / round_to).round() * round_to } else { value }
                })
            })
            .collect();
        let mut burst = Burst::from_planes("noise", frames);
        burst.quantisation_step = round_to;
        burst
    }

    #[test]
    fn the_estimate_is_within_three_percent_on_noise_with_edges() {
        for sigma in [0.002f32, 0.01, 0.1] {
            let burst = noisy_burst(sigma, 4, |u, v| if (u / 40 + v / 50) % 2 == 0 { 0.2 } else { 0.6 }, 0.0);
            let estimate = frame_noise(&burst, 0..4, &Monitor::default()).expect("not cancelled");
            assert!((estimate / sigma - 1.0).abs() < 0.03, "{sigma}: {estimate}");
        }
    }

    #[test]
    fn coarse_numbers_do_not_spoil_the_estimate() {
        // 8-bit frames whose noise is half, one and two grey values; rounding adds a twelfth of a step².
        for grey_values in [0.5f32, 1.0, 2.0] {
            let step = 1.0 / 255.0;
            let burst = noisy_burst(grey_values * step, 3, |u, _| 0.3 + u as f32 * 1e-4, step);
            let expected = (grey_values * grey_values + 1.0 / 12.0).sqrt() * step;
            let estimate = frame_noise(&burst, 0..3, &Monitor::default()).expect("not cancelled");
            assert!(
                (estimate / expected - 1.0).abs() < 0.05,
                "{grey_values}: {} of {}",
                estimate / step,
                expected / step
            );
        }
    }

    #[test]
    fn black_parts_where_the_noise_is_cut_off_do_not_count() {
        // Two thirds of the image are so dark that nearly all of their noise is cut off at zero.
        let (sigma, step) = (3.0 / 255.0, 1.0 / 255.0);
        let mut burst = noisy_burst(sigma, 3, |u, _| if u < 200 { -0.03 } else { 0.4 }, step);
        for frame in &mut burst.frames {
            let cut = Plane::from_vec(300, 200, frame.data().iter().map(|x| x.max(0.0)).collect());
            *frame = std::sync::Arc::new(cut);
        }
        let estimate = frame_noise(&burst, 0..3, &Monitor::default()).expect("not cancelled");
        assert!((estimate / sigma - 1.0).abs() < 0.06, "{}", estimate / sigma);
    }

    #[test]
    fn a_noiseless_burst_has_its_rounding_error() {
        let burst = noisy_burst(0.0, 2, |_, _| 0.2, 1.0 / 255.0);
        let estimate = frame_noise(&burst, 0..2, &Monitor::default()).expect("not cancelled");
        assert!(estimate <= 0.3 / 255.0 && estimate > 0.28 / 255.0);
    }

    #[test]
    fn propagated_noise_is_what_the_filters_leave() {
        use super::super::octave::{DogTile, OctaveFilters, Pixels, dog_tile, stack_tiles};
        use crate::plane::bank::FilterScratch;
        use crate::plane::tile::Region;
        let burst = noisy_burst(1.0, 4, |_, _| 0.0, 0.0);
        let frames: Vec<&Plane> = burst.frames.iter().map(|f| &**f).collect();
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
        let one = DetectorParams { slopes: super::super::SlopeGrid::line(-3.0..=3.0, 7), ..DetectorParams::default() };
        let two =
            DetectorParams { slopes: super::super::SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), ..one.clone() };
        assert!(gate_factor(&two) > gate_factor(&one) + 0.2);
        let fixed = DetectorParams { noise_gate: NoiseGate::Factor(4.5), ..one };
        assert_eq!(gate_factor(&fixed), 4.5);
    }
}
