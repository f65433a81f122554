//! Blocks that a file's codec flattened.
//!
//! A JPEG file keeps of each block of 8×8 pixels only what exceeds half a step of its table: weak noise is rounded away
//! in most blocks, and elsewhere is as strong as the step. A flattened block is thus no evidence of low noise. Where
//! many blocks are flat, the noise is measured from all of them, and the gate allows for noise that is rare and strong
//! ([`rare`]). Without this `jpeg-20` has 8769 false features a megapixel at the strict gate, not 6.

use super::warning::{NoiseWarning, WarningKind};
use crate::detector::noise::bisected;
use crate::detector::params::doc;
use crate::error::Error;
use crate::plane::Plane;
use serde::Serialize;
use std::ops::Range;

/// Side of a codec's block, pixels; blocks begin at multiples of it.
const SIDE: usize = 8;
const BLOCKS: usize = 2048;
const FRAMES: usize = 4;
/// Share of flat blocks from which they are no evidence of low noise.
const MIN_FLAT: f32 = 0.25;
/// Ratio of the shares with structure, half a block off to in place, above which the blocks are a codec's.
const OFF_TO_IN: f32 = 1.25;
const SURE: f32 = 5.0;
/// Number of parts of an image along each axis, and number of flattened ones from which all counts as flattened.
const PARTS: usize = 4;
const MIN_PARTS: usize = 4;
/// Standard deviation of a filter, pixels, above which it does not resolve blocks.
const WIDE: f64 = 10.0;
/// Reach of a filter at the blocks that a border cuts, pixels of its octave.
const CUT_REACH: f32 = 4.0;
/// Share with structure, half a block off, below which too little is left to measure the noise; and of blocks that
/// are not of one grey.
const ENOUGH: f32 = 0.02;

/// Flattening of a burst's frames by their codec.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Flattened {
    /// Share (0 … 1) of the codec's blocks that are flat.
    pub share: f32,
    /// Share (0 … 1) of blocks half a block off the codec's that have structure: noise is left in them.
    pub shown: f32,
    /// Variance in the blocks that the right and the lower border cut, relative to that in whole blocks; at least 1.
    #[serde(skip)]
    pub(super) cut: [f32; 2],
}

impl Flattened {
    pub(super) fn find(frames: &[&Plane], step: f32) -> Option<Self> {
        let (width, height) = frames.first()?.size();
        let (columns, rows) = ((width / SIDE).saturating_sub(1), (height / SIDE).saturating_sub(1));
        let total = columns * rows;
        if step <= 0.0 || total == 0 {
            return None;
        }
        let (count, looked) = (total.min(BLOCKS), frames.len().min(FRAMES));
        let frame = |i: usize| frames[i * (frames.len() - 1) / (looked - 1).max(1)];
        // By part of the image: the number of blocks, and of flat ones in place and half a block off.
        let (mut parts, mut constant) = ([[0usize; 3]; PARTS * PARTS], 0);
        for (t, i) in (0..looked).flat_map(|t| (0..count).map(move |i| (t, i))) {
            let index = i * total / count;
            let (column, row) = (index % columns, index / columns);
            let of_part = &mut parts[row * PARTS / rows * PARTS + column * PARTS / columns];
            let at = |off: usize| (SIDE * column + off, SIDE * row + off);
            let flat = |off: usize| is_flat(frame(t), at(off), 1.01 * step);
            let corner = frame(t).at(SIDE * column, SIDE * row);
            constant += usize::from(corner > 0.0 && corner < 1.0 && is_flat(frame(t), at(0), 0.0));
            let counts = [1, usize::from(flat(0)), usize::from(flat(SIDE / 2))];
            of_part.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        let all = [0, 1, 2].map(|i| parts.iter().map(|part| part[i]).sum());
        let [share, shown] = shares(&all);
        // The noise of a part of the image alone may be flattened.
        let is_codec = is_codec(&all) || parts.iter().filter(|part| is_codec(part)).count() >= MIN_PARTS;
        // Blocks of one grey show no noise, whatever made them so; black and white ones are cut off, and reported.
        let is_codec = is_codec || constant as f32 > (1.0 - ENOUGH) * all[0] as f32;
        if !is_codec && share < 1.0 {
            return None;
        }
        let cut = cut_to_whole(frames);
        // Where no block has anything left, only a codec lets the cut ones change.
        let is_codec = is_codec || cut.contains(&f32::INFINITY);
        is_codec.then_some(Self { share, shown, cut })
    }

    /// Variance around (u, v) of a frame of `size`, as a filter of `octave` collects it, relative to whole blocks.
    pub(super) fn variance_factor_at(&self, octave: i32, (u, v): (f32, f32), (width, height): (usize, usize)) -> f32 {
        let reach = CUT_REACH * (octave as f32).exp2();
        let along = |at: f32, n: usize, ratio: f32| {
            let cut = (n % SIDE) as f32;
            let is_near = cut > 0.0 && at + reach >= n as f32 - cut;
            // A filter that is wider than the cut blocks collects less of them.
            if is_near { 1.0 + (ratio - 1.0) * (cut / reach).min(1.0) } else { 1.0 }
        };
        along(u, width, self.cut[0]).max(along(v, height, self.cut[1]))
    }

    pub(in crate::detector) fn is_measurable(&self) -> bool {
        self.shown >= ENOUGH
    }

    pub(in crate::detector) fn against_strict(&self) -> Error {
        Error::param(
            doc::NOISE_GATE.name,
            format!(
                "{:.1} % of the blocks of 8×8 pixels are flat, as JPEG files of low quality have them, so that the noise cannot be \
                 measured and the gate strict cannot promise anything",
                100.0 * self.share
            ),
            "save the frames without loss, or give auto or a number",
        )
    }

    pub(super) fn warning(&self) -> NoiseWarning {
        let percent = 100.0 * self.share;
        let what = if self.is_measurable() {
            "their noise is taken to be that of the others, which is rare and strong, and the gate is raised"
        } else {
            "too few are left to measure the noise, so false features may pass the gate"
        };
        let text = format!(
            "{percent:.1} % of the blocks of 8×8 pixels are flat, as JPEG files of low quality have them; {what}; save the frames \
             without loss"
        );
        NoiseWarning::new(WarningKind::FlattenedByCodec, self.share, text)
    }
}

/// Variance of the differences of frames in the columns and in the rows of blocks that a border cuts, relative to that
/// in whole blocks, at least 1. A codec fills a cut block by repeating its last pixel, whose noise does not cancel.
fn cut_to_whole(frames: &[&Plane]) -> [f32; 2] {
    let (width, height) = frames[0].size();
    let whole = [width / SIDE * SIDE, height / SIDE * SIDE];
    if whole == [width, height] {
        return [1.0; 2];
    }
    let mean_square = |columns: Range<usize>, rows: Range<usize>| {
        let of_row = |(pair, v): (&[&Plane], usize)| {
            let [one, next] = [0, 1].map(|t| &pair[t].row(v)[columns.clone()]);
            one.iter().zip(next).map(|(a, b)| (a - b).powi(2)).sum::<f32>()
        };
        let pairs = frames.windows(2).flat_map(|pair| rows.clone().map(move |v| (pair, v)));
        // Rows that a mask hides are NaN.
        let seen = pairs.map(of_row).filter(|sum| sum.is_finite());
        let (sum, count) = seen.fold((0.0, 0usize), |(sum, count), row| (sum + f64::from(row), count + columns.len()));
        sum / count as f64
    };
    let [right, below] = whole;
    let inside = mean_square(0..right, 0..below);
    // Without cut blocks the mean is NaN, which is no larger.
    [mean_square(right..width, 0..height), mean_square(0..right, below..height)]
        .map(|cut| if cut > inside { (cut / inside) as f32 } else { 1.0 })
}

/// Share of flat blocks, and of those with structure half a block off, of their number, that of flat ones, and off.
fn shares(counts: &[usize; 3]) -> [f32; 2] {
    let [blocks, in_place, off] = counts.map(|count| count as f32);
    [in_place / blocks, 1.0 - off / blocks]
}

/// Whether a codec made blocks flat: flat parts of a scene are flat at any offset, a codec's blocks only in place.
fn is_codec(counts: &[usize; 3]) -> bool {
    let [flat, shown] = shares(counts);
    let error = ((1.0 - flat) * flat / counts[0] as f32).sqrt();
    flat >= MIN_FLAT && shown > OFF_TO_IN * (1.0 - flat) && shown - (1.0 - flat) > SURE * error
}

fn is_flat(frame: &Plane, (u, v): (usize, usize), within: f32) -> bool {
    let (mut min, mut max) = (f32::INFINITY, f32::NEG_INFINITY);
    (v..v + SIDE).all(|v| {
        for &x in &frame.row(v)[u..u + SIDE] {
            (min, max) = (min.min(x), max.max(x));
        }
        max - min <= within
    })
}

/// Variance of D, relative to its mean, by place in a block, where each block has an offset of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct InBlock([[f64; SIDE]; SIDE]);

impl InBlock {
    /// Variance in the difference of two isotropic Gaussians of the variances `low` and `high`, pixels².
    pub fn of_filter(low: f64, high: f64) -> Self {
        if low > WIDE * WIDE {
            return Self([[1.0; SIDE]; SIDE]);
        }
        // Share of a Gaussian's weight in the block that begins `from` pixels after a place, along one axis.
        let reach = (4.0 * high.sqrt() / SIDE as f64).ceil() as i64 + 1;
        let share = |variance: f64, from: f64| {
            let below = |x: f64| 0.5 * libm::erfc(-x / (2.0 * variance).sqrt());
            below(from + SIDE as f64 - 0.5) - below(from - 0.5)
        };
        let products: [[f64; 3]; SIDE] = std::array::from_fn(|place| {
            let blocks = (-reach..=reach).map(|block| (block * SIDE as i64 - place as i64) as f64);
            blocks.fold([0.0; 3], |[a, b, c], from| {
                let (l, h) = (share(low.max(0.01), from), share(high.max(0.02), from));
                [a + l * l, b + l * h, c + h * h]
            })
        });
        // Σ over blocks of (l_u·l_v − h_u·h_v)²: a block's offset behind the difference of two Gaussians.
        let at = |u: usize, v: usize| {
            let [a, b, c] = std::array::from_fn(|i| products[u][i] * products[v][i]);
            a - 2.0 * b + c
        };
        let variances: [[f64; SIDE]; SIDE] = std::array::from_fn(|v| std::array::from_fn(|u| at(u, v)));
        let mean = variances.iter().flatten().sum::<f64>() / (SIDE * SIDE) as f64;
        Self(variances.map(|row| row.map(|x| x / mean)))
    }

    pub fn kurtosis(&self) -> f32 {
        (3.0 * self.0.iter().flatten().map(|x| x * x).sum::<f64>() / (SIDE * SIDE) as f64 - 3.0) as f32
    }

    /// Largest variance, over the places, of the mean of frames that are read `shifts` pixels farther along both axes.
    pub fn largest(&self, shifts: impl Iterator<Item = (f32, f32)>) -> f32 {
        let mut sums = [[0.0; SIDE]; SIDE];
        let mut frames = 0.0;
        for (du, dv) in shifts {
            // Only the place within a block counts, so that whole blocks of motion are none.
            let whole = |shift: f32| (shift.round() as i64).rem_euclid(SIDE as i64) as usize;
            let (du, dv) = (whole(du), whole(dv));
            for (v, row) in sums.iter_mut().enumerate() {
                let from = &self.0[(v + dv) % SIDE];
                row.iter_mut().enumerate().for_each(|(u, sum)| *sum += from[(u + du) % SIDE]);
            }
            frames += 1.0;
        }
        (sums.iter().flatten().fold(0.0, |a: f64, b| a.max(*b)) / frames) as f32
    }
}

/// Factor (at least 1) on σ of the mean of `frames` frames so that `gate` times the result is exceeded as rarely as by
/// normal noise. Noise of excess `kurtosis` is modelled as normal noise in a share 3/(3 + kurtosis) of the frames.
pub fn rare(kurtosis: f32, frames: usize, gate: f32) -> f32 {
    let present = 3.0 / (3.0 + f64::from(kurtosis.max(0.0)));
    // Beyond some dozens of frames the mean is nearly normal, and their exact number matters no more.
    let n = frames.clamp(1, 64) as f64;
    if present > 0.999 {
        return 1.0;
    }
    let beyond = |x: f64| 0.5 * libm::erfc(x * std::f64::consts::FRAC_1_SQRT_2);
    // The number of frames that hold noise is binomial; each number has a normal tail of its own.
    let chance = |m: f64| {
        let ways = libm::lgamma(n + 1.0) - libm::lgamma(m + 1.0) - libm::lgamma(n - m + 1.0);
        libm::exp(ways + m * libm::log(present) + (n - m) * libm::log(1.0 - present))
    };
    let chances: Vec<(f64, f64)> =
        (1..=n as usize).map(|m| (chance(m as f64), (m as f64 / (n * present)).sqrt())).collect();
    let gate = f64::from(gate.max(0.1));
    let wanted = beyond(gate);
    let tail = |x: f64| chances.iter().map(|(chance, deviation)| chance * beyond(x / deviation)).sum::<f64>();
    // In all frames at once the noise is 1/√present times as strong as on average.
    let range = [gate, gate / present.sqrt()];
    // The tail falls with x, so bisection finds the gate; 30 halvings exhaust `f32`.
    (bisected(range, 30, |x| tail(x) > wanted) / gate) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strict_is_refused_with_the_reason_where_nothing_is_left() {
        let left = Flattened { share: 0.999, shown: 0.002, cut: [1.0; 2] };
        assert!(!left.is_measurable() && left.warning().text.contains("too few"));
        let refused = left.against_strict().to_string();
        assert!(refused.contains("noise-gate") && refused.contains("JPEG"), "{refused}");
        assert!(Flattened { share: 0.96, shown: 0.1, cut: [1.0; 2] }.is_measurable());
    }

    #[test]
    fn flat_parts_of_a_scene_are_no_blocks() {
        // Rectangles of one grey each, at any place.
        let step = 1.0 / 255.0;
        let scene = Plane::from_fn(400, 300, |u, v| step * ((u / 37 * 7 + v / 23 * 5) % 64) as f32);
        assert_eq!(Flattened::find(&[&scene], step), None);
        assert_eq!(Flattened::find(&[&scene], 0.0), None);
        assert_eq!(Flattened::find(&[&Plane::zeros(15, 9)], step), None);
        // Blocks of one grey, but for two, show too little of the noise; black ones are cut off.
        let few = |grey: f32| {
            Plane::from_fn(400, 300, |u, v| if v == 20 && [100, 301].contains(&u) { 0.6 } else { grey * step })
        };
        assert!(Flattened::find(&[&few(90.0)], step).is_some_and(|found| !found.is_measurable()));
        assert_eq!(Flattened::find(&[&few(0.0)], step), None);
    }

    #[test]
    fn places_in_a_block_differ_most_where_the_filter_is_as_wide_as_it() {
        let largest = |sigma: f64, slope: f32| {
            let in_block = InBlock::of_filter(sigma * sigma, (1.15 * sigma).powi(2));
            in_block.largest((0..10).map(|t| (slope * t as f32, 0.0)))
        };
        assert!(largest(3.0, 0.0) > 1.5 && largest(10.0, 0.0) < 1.05, "{} {}", largest(3.0, 0.0), largest(10.0, 0.0));
        // Motion by parts of a block sees all places in it; motion by whole blocks a frame stays in place.
        assert!(largest(3.0, 1.6) < largest(3.0, 0.0) && largest(3.0, 8.0) == largest(3.0, 0.0));
    }

    #[test]
    fn rare_noise_needs_a_higher_gate() {
        for frames in [1, 10, 200] {
            assert_eq!(rare(0.0, frames, 4.9), 1.0);
            let factors = [1.0, 8.0, 60.0, 300.0].map(|kurtosis| rare(kurtosis, frames, 4.9));
            assert!(factors.is_sorted() && factors[0] > 1.0, "{factors:?}");
        }
        // In one frame: the share p of the time, with the variance 1/p, so that p·Q(x·√p) = Q(gate).
        let (share, gate) = (0.1f64, 4.0f64);
        let beyond = |x: f64| 0.5 * libm::erfc(x / 2f64.sqrt());
        let x = gate * f64::from(rare((3.0 / share - 3.0) as f32, 1, gate as f32));
        assert!((share * beyond(x * share.sqrt()) / beyond(gate) - 1.0).abs() < 1e-3, "{x}");
    }
}
