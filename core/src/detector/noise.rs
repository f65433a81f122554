//! White noise of a frame, estimated from the burst, and the threshold on D; for other noise [`super::noise_model`].
//!
//! Estimate. Frames and differences of consecutive frames are filtered by the second difference in u and in v (mask
//! `[1 −2 1]ᵀ[1 −2 1]`, gain 6 for white noise), which removes everything locally linear; the median of the magnitudes
//! over 0.6745 is the standard deviation, which a minority of edges hardly changes. Texture can only add, so the
//! smaller of the two estimates is taken. The filter runs on short pieces of rows spread evenly over the image, the
//! same in every frame, without pixels at the ends of the file's range, where noise is cut off.
//!
//! Gate. The noise in D falls with scale while a blob's response does not. So the noise of one frame, σ_F
//! ([`frame_noise`]), is carried through mean, interpolation and filter; the gate requires |D| ≥ k·σ_D at each level.
//!
//! Propagation. For white noise the variance in D is σ_F² times the energy of the whole filter. Its parts are nearly
//! Gaussian, with inner products ∫ g(A)·g(B) = 1/√(2π(A+B)) in one dimension, for variances A and B. Bilinear sampling
//! at a fraction f adds the variance f(1−f) in its direction; its mean over the frames is taken.

use crate::burst::Burst;
use crate::detector::params::{DetectorParams, NoiseGate, SlopeExtrema};
use crate::detector::scale_space::{SIGMA_INPUT, ScaleSpace};
use crate::kernel::stack::FrameOffset;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;
use std::ops::Range;

/// Median of |x| of a standard normal variable x.
const MEDIAN_OF_NORMAL: f32 = 0.674_49;
/// Gain of the filter for white noise: σ of its output over that of its input.
const GAIN: f32 = 6.0;
/// Maximum number of places in a frame, about: the standard error of one frame's estimate is then one percent.
const MAX_PLACES: usize = 32_768;
/// Number of columns of a piece of a row, where the image has more places than [`MAX_PLACES`].
const PIECE: usize = 32;

/// Standard deviation of one frame's noise, fraction of full scale, from the frames `used` of a burst. At least the
/// rounding error of the files' numbers (step/√12). 0 for noiseless float frames or for float images under 3×3 pixels.
pub fn frame_noise(burst: &Burst, used: Range<usize>, monitor: &Monitor) -> Result<f32, Cancelled> {
    let step = burst.quantisation_step;
    let min = step / 12f32.sqrt();
    let pieces = pieces(burst.size());
    if pieces.is_empty() {
        return Ok(min);
    }
    let filtered: Vec<Filtered> = burst.frames[used]
        .par_iter()
        .map(|frame| {
            monitor.check()?;
            Ok(Filtered::new(frame, &pieces, step))
        })
        .collect::<Result<_, Cancelled>>()?;
    let deviation = |filtered: &Filtered| {
        monitor.check()?;
        Ok(filtered.deviation(step))
    };
    let of_frames: Vec<f32> = filtered.par_iter().map(deviation).collect::<Result<_, Cancelled>>()?;
    // A difference of two frames has twice the variance; texture that stands still cancels in it.
    let of_pairs: Vec<f32> = filtered
        .par_windows(2)
        .map(|pair| Ok(deviation(&pair[1].less(&pair[0]))? / 2f32.sqrt()))
        .collect::<Result<_, Cancelled>>()?;
    // Texture can only add to either estimate, so the smaller one is right.
    let medians = [of_frames, of_pairs].into_iter().filter(|values| !values.is_empty());
    let sigma = medians.map(|mut values| median_on_lattice(&mut values, 0.0)).reduce(f32::min);
    Ok(sigma.map_or(min, |sigma| sigma.max(min)))
}

/// A piece of a row: the row, and the columns of the filter's centres in it.
type Piece = (usize, Range<usize>);

/// Pieces of an image of `size`: whole rows of a small one, else spread evenly; none under 3×3 pixels.
fn pieces((width, height): (usize, usize)) -> Vec<Piece> {
    if width < 3 || height < 3 {
        return Vec::new();
    }
    let (columns, rows) = (width - 2, height - 2);
    if columns * rows <= MAX_PLACES {
        return (1..=rows).map(|v| (v, 1..columns + 1)).collect();
    }
    let length = PIECE.min(columns);
    let count = MAX_PLACES / length;
    // Steps of the golden section fill the columns evenly, whatever the number of rows.
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    (0..count)
        .map(|i| {
            let start = 1 + ((i as f64 * golden).fract() * (columns - length + 1) as f64) as usize;
            (1 + i * rows / count, start..start + length)
        })
        .collect()
}

/// Output of the filter at all places of a frame, or of the difference of two frames.
struct Filtered {
    values: Vec<f32>,
    /// Whether the filter touched a pixel whose noise was cut off, or that is masked.
    cut_off: Vec<bool>,
}

impl Filtered {
    /// Filters the `pieces` of `frame`; the smallest difference of its values is `step`.
    fn new(frame: &Plane, pieces: &[Piece], step: f32) -> Self {
        let places = pieces.iter().map(|(_, columns)| columns.len()).sum();
        let mut out = Self { values: vec![0.0; places], cut_off: vec![false; places] };
        // Ends of the file's range, where noise is cut off; float files have none. After a black level was subtracted
        // the range begins at the least value.
        let columns_read = |columns: &Range<usize>| columns.start - 1..columns.end + 1;
        let read = pieces.iter().flat_map(|(v, columns)| &frame.row(*v)[columns_read(columns)]);
        let least = read.copied().fold(0.0, f32::min);
        let whole = if step > 0.0 { least + 0.5 * step..1.0 - 0.5 * step } else { f32::NEG_INFINITY..f32::INFINITY };
        let mut at = 0;
        for (v, columns) in pieces {
            let row = |v: usize| &frame.row(v)[columns_read(columns)];
            let end = at + columns.len();
            let (values, cut_off) = (&mut out.values[at..end], &mut out.cut_off[at..end]);
            filter_piece(row(v - 1), row(*v), row(v + 1), &whole, values, cut_off);
            if frame.mask().is_some() {
                for (u, cut_off) in columns.clone().zip(cut_off) {
                    let hides = |v: usize| (u - 1..u + 2).any(|u| frame.weight_at(u, v) < 1.0);
                    *cut_off |= (v - 1..v + 2).any(hides);
                }
            }
            at = end;
        }
        out
    }

    fn less(&self, other: &Self) -> Self {
        Self {
            values: self.values.iter().zip(&other.values).map(|(a, b)| a - b).collect(),
            cut_off: self.cut_off.iter().zip(&other.cut_off).map(|(a, b)| a | b).collect(),
        }
    }

    /// Standard deviation of the frames' white noise; `step` is the smallest difference of their values. Places that
    /// touch a cut-off pixel are excluded, unless nearly all do.
    fn deviation(&self, step: f32) -> f32 {
        let counted = self.values.iter().zip(&self.cut_off).filter(|(_, cut_off)| !**cut_off);
        let mut magnitudes: Vec<f32> = Vec::with_capacity(self.values.len());
        magnitudes.extend(counted.map(|(x, _)| x.abs()));
        if magnitudes.len() * 20 < self.values.len() {
            magnitudes = self.values.iter().map(|x| x.abs()).collect();
        }
        median_on_lattice(&mut magnitudes, step) / (MEDIAN_OF_NORMAL * GAIN)
    }
}

/// Filters a piece of `row` between its neighbours `above` and `below`, each a pixel longer at both ends than `out`.
/// `cut_off` becomes whether any of the nine pixels is outside `whole`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn filter_piece(above: &[f32], row: &[f32], below: &[f32], whole: &Range<f32>, out: &mut [f32], cut_off: &mut [bool]) {
    let n = out.len();
    let (above, row, below, cut_off) = (&above[..n + 2], &row[..n + 2], &below[..n + 2], &mut cut_off[..n]);
    let second = |i: usize| above[i] - 2.0 * row[i] + below[i];
    let min = |i: usize| above[i].min(row[i]).min(below[i]);
    let max = |i: usize| above[i].max(row[i]).max(below[i]);
    for i in 0..n {
        out[i] = second(i) - 2.0 * second(i + 1) + second(i + 2);
        let (min, max) = (min(i).min(min(i + 1)).min(min(i + 2)), max(i).max(max(i + 1)).max(max(i + 2)));
        cut_off[i] = min < whole.start || max > whole.end;
    }
}

/// Median of values on a lattice of spacing `step` (0: continuous), each of which stands for the interval around it.
fn median_on_lattice(values: &mut [f32], step: f32) -> f32 {
    let (_, &mut median, _) = values.select_nth_unstable_by(values.len() / 2, f32::total_cmp);
    if step <= 0.0 {
        return median;
    }
    let near = |x: f32| (x - median).abs() < 0.5 * step;
    let below = values.iter().filter(|&&x| !near(x) && x < median).count() as f32;
    let equal = values.iter().filter(|&&x| near(x)).count() as f32;
    // For magnitudes the value 0 stands for half an interval.
    let (start, length) = if median < 0.5 * step { (0.0, 0.5 * step) } else { (median - 0.5 * step, step) };
    start + length * (values.len() as f32 * 0.5 - below) / equal
}

/// Variance of D of the mean over the frames at `offsets`, at `octave` and `level` (−1 … S), for white noise of
/// variance 1 in each frame, where all frames cover the pixel.
pub fn dog_noise_variance(space: &ScaleSpace, octave: i32, level: f64, offsets: &[FrameOffset]) -> f64 {
    // If the first octave skips pixels, the noise is white on the kept ones; lengths are then in those pixels.
    let unit = space.skip() as f64;
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
            // Energy of the difference of two Gaussians, each widened by the interpolation of this frame.
            (both(low, low) - 2.0 * both(low, high) + both(high, high)) * gain_u * gain_v
        })
        .sum();
    total / (offsets.len() as f64).powi(2)
}

/// Variance of the difference of two isotropic Gaussians, of variances `low` and `high` px², for white noise of 1.
pub(super) fn dog_energy(low: f64, high: f64) -> f64 {
    let product = |a: f64, b: f64| 1.0 / (2.0 * std::f64::consts::PI * (a + b));
    product(low, low) - 2.0 * product(low, high) + product(high, high)
}

/// The gate's factor k: given, or such that white noise gives about the allowed number of false keypoints a megapixel.
///
/// The number of local maxima of a smooth Gaussian field above k falls like k²·exp(−k²/2) per independent place; the
/// places are proportional to pixels and slopes. The factor in front was measured on pure noise.
pub fn gate_factor(params: &DetectorParams) -> f32 {
    let allowed = match params.noise_gate {
        NoiseGate::Factor(k) => return k,
        // At most one false feature is promised; with two orientations a keypoint is up to two.
        NoiseGate::Strict => 0.5,
        // They match nothing, while faint true ones that pass add to the inliers (docs/MEASUREMENTS.md).
        NoiseGate::Auto => 5.0,
        // Below the measured gates: 300 to 360 features pass; they cost time and few mismatches (docs/MEASUREMENTS.md).
        NoiseGate::Matching => 100.0,
    };
    // k²·exp(−k²/2) has no simple inverse; it falls from √2 on, so bisection finds k.
    bisected([2.0, 12.0], 60, |k| false_keypoints(params, k) > allowed) as f32
}

/// Number of keypoints a megapixel of white noise at a gate of `k` σ, without edges and twins; that of 2 σ below it.
pub fn false_keypoints(params: &DetectorParams, k: f64) -> f64 {
    let maxima_per_pixel = match params.used_extrema() {
        // One for one blob. Measured on 12 to 20 Mpx of white noise as 0.00016 … 0.00028 between k = 4.0 and 5.3, for
        // 13 slopes on a line, 7×7, and the doubled image, on samples; exact maxima are a quarter more.
        SlopeExtrema::Each => 0.000_25,
        // 0.0002 … 0.0004 from k = 3.6 to 4.8 on 18 Mpx of white noise: 1, 7 and 13 slopes, 7×7, and the doubled image.
        SlopeExtrema::Joint => 0.000_35,
    };
    let slopes = params.used_slopes().len() as f64;
    // Octave 0 and the coarser ones have 4/3 of the places of octave 0; the doubled image has four times as many.
    let places = 1e6 * 4f64.powi(-params.first_octave) * slopes;
    let k = k.max(2.0);
    maxima_per_pixel * places * k * k * (-0.5 * k * k).exp()
}

/// End of the lower part of a range, in which `is_low` holds, after this number of halvings.
pub(super) fn bisected([mut low, mut high]: [f64; 2], halvings: usize, is_low: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        *(if is_low(middle) { &mut low } else { &mut high }) = middle;
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Positions;
    use crate::detector::params::{CoarseStart, Interpolation, Slope};
    use crate::detector::stack::frame_offsets;
    use crate::synth::random::Stream;

    #[test]
    fn a_large_image_is_sampled_evenly_and_enough() {
        let (width, height) = (1000, 700);
        let pieces = pieces((width, height));
        let places: usize = pieces.iter().map(|(_, columns)| columns.len()).sum();
        assert!(places <= MAX_PLACES && places > MAX_PLACES * 9 / 10);
        assert!(pieces.iter().all(|(v, columns)| (1..height - 1).contains(v) && columns.end < width));
        // In each of 10 × 7 squares there are about as many pieces.
        let mut counts = [0usize; 70];
        pieces.iter().for_each(|(v, columns)| counts[v / 100 * 10 + columns.start / 100] += 1);
        let mean = pieces.len() / 70;
        assert!(counts.iter().all(|&n| n > mean / 2 && n < mean * 2), "{counts:?}");
    }

    #[test]
    fn propagated_noise_is_what_the_filters_leave() {
        use crate::detector::scale_space::{DogTile, OctaveFilters, Pixels, dog_tile, stack_tiles};
        use crate::kernel::gaussian_bank::FilterScratch;
        use crate::plane::tile::Region;
        let mut noise = Stream::new(7, 0);
        let frames = [(); 4].map(|()| Plane::from_fn(300, 200, |_, _| noise.normal() as f32));
        let frames: Vec<&Plane> = frames.iter().collect();
        for (first_octave, size) in [(0, (300, 200)), (-1, (600, 400)), (1, (150, 100))] {
            for slope in [Slope::new(0.0, 0.0), Slope::new(0.5, 0.0), Slope::new(1.25, -0.75)] {
                let space = ScaleSpace::starting(3, first_octave, CoarseStart::Skipped, 4.0);
                let offsets = frame_offsets(&Positions::even(4), slope, Interpolation::Linear);
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
                    assert!((measured / predicted - 1.0).abs() < tolerance, "{first_octave} {slope:?} {level_index}");
                }
            }
        }
    }

    #[test]
    fn noise_of_binned_frames_is_the_energy_of_their_impulse_responses() {
        use crate::detector::scale_space::planes::{SlopeStack, dog_plane};
        let monitor = Monitor::default();
        for (first_octave, slope) in [(1, [0.0, 0.0]), (1, [0.5, 0.0]), (1, [1.25, -0.75]), (2, [0.4, 0.3])] {
            let (space, step) = (ScaleSpace::new(3, first_octave, 4.0), 1usize << first_octave);
            let offsets = frame_offsets(&Positions::even(4), Slope::new(slope[0], slope[1]), Interpolation::Linear);
            let (side, mut energy) = (80 * step, [0.0; 2]);
            // One pixel of one frame, at each possible place beside a kept pixel.
            for (t, phase) in (0..4).flat_map(|t| (0..step * step).map(move |phase| (t, phase))) {
                let at = (side / 2 + phase % step, side / 2 + phase / step);
                let of = |frame| Plane::from_fn(side, side, |u, v| f32::from(frame == t && (u, v) == at));
                let frames = [0, 1, 2, 3].map(of);
                let binned = space.binned(&frames.each_ref(), &monitor).expect("not cancelled");
                let frames: Vec<&Plane> = binned.iter().collect();
                let size_image = (side, side);
                let base = SlopeStack { frames: &frames, offsets: &offsets, space: &space, size_image }.base();
                for (level, energy) in [1, 3].into_iter().zip(&mut energy) {
                    let dog = dog_plane(&base, &space, (80, 80), level, &monitor).expect("not cancelled");
                    *energy += dog.data().iter().map(|&x| f64::from(x).powi(2)).sum::<f64>();
                }
            }
            for (level, energy) in [0.0, 2.0].into_iter().zip(energy) {
                let ratio = (dog_noise_variance(&space, first_octave, level, &offsets) / energy).sqrt();
                assert!((ratio - 1.0).abs() < 0.03, "{first_octave} {slope:?} {level}: {ratio}");
            }
        }
    }
}
