//! Descriptors: 4×4 histograms of gradient directions around a feature, turned by its orientation.
//!
//! As in VLFeat: 4×4 cells of 3σ, each a histogram of 8 directions, with trilinear weights under a Gaussian of two
//! cells. All 128 are normalised, cut at 0.2, normalised, L1-normalised, rooted ("RootSIFT"), times 512, cut at 255.
//!
//! Pooled over scales, after Dong and Soatto ("Domain-Size Pooling in Local Descriptors: DSP-SIFT", CVPR 2015): the
//! sums of each scale are normalised and added before the root, and not cut, which in the dark costs matches.

use crate::detector::feature::Descriptor;
use crate::kernel::gradient::{GradientRow, Lane, max, min, reach, vector_of, whole, window};
use crate::kernel::patch::{LANES, Patch};
use multiversion::multiversion;
use std::f32::consts::TAU;

/// Side of a cell, in σ.
const MAGNIFICATION: f32 = 3.0;

/// Buffers that [`sums`] reuses from feature to feature.
#[derive(Debug, Default)]
pub struct DescriptorScratch {
    along_u: Vec<f32>,
    along_v: Vec<f32>,
    samples: Samples,
}

/// Radius that a descriptor of scale `sigma` reads, octave pixels: half its diagonal. The level must reach one farther.
pub fn descriptor_radius(sigma: f32) -> usize {
    (std::f32::consts::SQRT_2 * MAGNIFICATION * sigma * (CELLS as f32 + 1.0) / 2.0 + 0.5).floor() as usize
}

/// Radius of the disc of pixels that a coarser scale `sigma` of a pooled descriptor reads, pixels of the level: half
/// the side of the turned square. The level around it must reach one pixel farther.
pub fn coarse_radius(sigma: f32) -> usize {
    (HALF * MAGNIFICATION * sigma + 0.5).floor() as usize
}

/// Sums of the weighted gradients in each direction of each cell, row by row.
pub type Sums = [f32; BINS];

/// Half the side of the square that counts, in cells: nothing is added beyond it.
const HALF: f32 = (CELLS + 1) as f32 / 2.0;

/// The turned square: cell coordinates are `cos·du + sin·dv` and `cos·dv − sin·du` from its centre.
pub struct Square {
    place: (f32, f32),
    cos: f32,
    sin: f32,
    orientation: f32,
    /// Radius of the disc that counts, pixels.
    radius: f32,
    /// Distance of the rows that are visited, at least 1.
    row_step: usize,
    /// Pixels to each side of the centre that are read.
    reach: usize,
}

impl Square {
    /// Square of a feature at `place`, scale `sigma`, in octave pixels, turned by `orientation` radians in [0, 2π).
    pub fn of(place: (f32, f32), sigma: f32, orientation: f32) -> Self {
        let square = Self::new(place, MAGNIFICATION * sigma + f32::EPSILON, orientation);
        Self { reach: descriptor_radius(sigma), ..square }
    }

    /// As [`Self::of`], for a coarser scale of a pooled descriptor: without the corners beyond [`coarse_radius`], whose
    /// weights are small, and without rows between which the level hardly changes.
    pub fn coarse(place: (f32, f32), sigma: f32, orientation: f32) -> Self {
        let cell = MAGNIFICATION * sigma;
        let (radius, row_step, reach) = (HALF * cell, sigma as usize, coarse_radius(sigma));
        Self { radius, row_step, reach, ..Self::new(place, cell, orientation) }
    }

    fn new(place: (f32, f32), cell: f32, orientation: f32) -> Self {
        // Sides that are never exactly parallel to the pixels cross every row.
        let slanted = |x: f32| if x.abs() < 1e-9 { 1e-9 } else { x };
        let (sin, cos) = orientation.sin_cos();
        let (cos, sin) = (slanted(cos / cell), slanted(sin / cell));
        Self { place, cos, sin, orientation, radius: f32::INFINITY, row_step: 1, reach: 0 }
    }

    /// Function from a row's distance `dv` below the centre to the first and last column inside, from the centre.
    #[inline(always)]
    fn interval(&self) -> impl Fn(f32) -> (f32, f32) {
        // Where |cos·du + sin·dv| and |cos·dv − sin·du| are at most HALF.
        let (slope_a, half_a) = (-self.sin / self.cos, HALF / self.cos.abs());
        let (slope_b, half_b) = (self.cos / self.sin, HALF / self.sin.abs());
        let radius = self.radius;
        #[inline(always)]
        move |dv| {
            let (a, b) = (slope_a * dv, slope_b * dv);
            let half = max(radius * radius - dv * dv, 0.0).sqrt();
            (max(max(a - half_a, b - half_b), -half), min(min(a + half_a, b + half_b), half))
        }
    }
}

/// The 128 sums, cells row by row, in an octave of `size`; `level` holds one pixel more around than the square reads.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn sums(level: &Patch, size: (usize, usize), square: &Square, scratch: &mut DescriptorScratch) -> Sums {
    let &Square { place: (x, y), cos, sin, orientation, row_step, reach: far, .. } = square;
    let (columns, rows) = (reach(x, far as i64, size.0), reach(y, far as i64, size.1));
    // A Gaussian of half the descriptor's width, which is two cells.
    let spread = 2.0 / (cos * cos + sin * sin).sqrt();
    let DescriptorScratch { along_u, along_v, samples } = scratch;
    window(columns.clone(), x, spread, along_u);
    window(rows.clone(), y, spread, along_v);
    let interval = square.interval();
    let mut cells = PairedCells::new();
    samples.room(BATCH + columns.clone().count());
    let mut held = 0;
    let orientation = orientation * (DIRECTIONS as f32 / TAU);
    for (v, &weight_v) in rows.clone().zip(along_v.iter()).step_by(row_step.max(1)) {
        let dv = v as f32 - y;
        let (left, right) = interval(dv);
        // Columns outside the turned square are never visited: at 45° they are half of all.
        let left = max((x + left).ceil(), columns.start as f32);
        let right = min((x + right).floor(), columns.end as f32 - 1.0);
        if left > right {
            continue;
        }
        let (start, end) = (left as i64, right as i64 + 1);
        let (row, length) = (GradientRow::new(level, start, v), (end - start) as usize);
        let weights_u = &along_u[(start - columns.start) as usize..];
        for at in (0..length).step_by(LANES) {
            let (magnitude, eighths) = row.vector(at);
            let weights = vector_of(weights_u, at);
            let first = start as f32 + at as f32 - x;
            let out = samples.vector(held + at);
            // Arithmetic without branches; the scattered sums follow per batch, in `PairedCells::add`.
            for i in 0..LANES {
                let turned = eighths[i] - orientation;
                let turned = if turned < 0.0 { turned + DIRECTIONS as f32 } else { turned };
                let direction = min(turned.floor(), LAST_DIRECTION);
                // Distances in cells from the padding's first cell.
                let du = first + i as f32;
                let cx = cos.mul_add(du, sin.mul_add(dv, HALF));
                let cy = cos.mul_add(dv, (-sin).mul_add(du, HALF));
                let bx = min(max(cx.floor(), 0.0), CELLS as f32);
                let by = min(max(cy.floor(), 0.0), CELLS as f32);
                let weight = magnitude[i] * (weights[i] * weight_v);
                out.cell[i] = whole(by * PAIRS as f32 + bx);
                out.direction[i] = whole(direction);
                out.past_direction[i] = turned - direction;
                out.past_column[i] = cx - bx;
                out.lower[i] = weight * (cy - by);
                out.upper[i] = weight - out.lower[i];
            }
        }
        held += length;
        if held >= BATCH {
            cells.add(samples, held);
            held = 0;
        }
    }
    cells.add(samples, held);
    cells.sums()
}

/// Samples whose weights are computed as vectors before the sums take sample by sample.
const BATCH: usize = 256;
const LAST_DIRECTION: f32 = (DIRECTIONS - 1) as f32;

/// Sum of `f` over the bins, in as many partial sums as a vector has lanes.
#[inline(always)]
fn sum_of(bins: &[f32; BINS], f: impl Fn(f32) -> f32) -> f32 {
    let mut sums = [0.0f32; LANES];
    for vector in bins.chunks_exact(LANES) {
        for i in 0..LANES {
            sums[i] += f(vector[i]);
        }
    }
    sums.iter().sum()
}

#[inline(always)]
fn normalise(bins: &mut [f32; BINS]) {
    let norm = sum_of(bins, |x| x * x).sqrt();
    if norm > 0.0 {
        bins.iter_mut().for_each(|x| *x /= norm);
    }
}

/// Converts the sums of one scale to a descriptor.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn quantise(mut bins: Sums) -> Descriptor {
    normalise(&mut bins);
    // As in SIFT, few strong gradients must not outweigh all others.
    bins.iter_mut().for_each(|x| *x = x.min(0.2));
    normalise(&mut bins);
    in_bytes(&bins)
}

/// Pools the sums of several scales to a descriptor.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn pool(scales: &[Sums]) -> Descriptor {
    let mut total = [0.0; BINS];
    for mut bins in scales.iter().copied() {
        normalise(&mut bins);
        total.iter_mut().zip(bins).for_each(|(total, bin)| *total += bin);
    }
    in_bytes(&total)
}

/// Bytes in UBC/COLMAP's order: within a cell the directions run the other way round than VLFeat's, the first stays.
#[inline(always)]
fn in_bytes(bins: &Sums) -> Descriptor {
    let sum = sum_of(bins, |x| x);
    if sum <= 0.0 {
        return [0; BINS];
    }
    to_vlfeat_order(&bins.map(|x| ((x / sum).sqrt() * 512.0 + 0.5).min(255.0) as i32 as u8))
}

/// Converts a descriptor to VLFeat's order; its own inverse.
pub fn to_vlfeat_order(descriptor: &Descriptor) -> Descriptor {
    let mut out = [0; BINS];
    for (out, cell) in out.chunks_exact_mut(DIRECTIONS).zip(descriptor.chunks_exact(DIRECTIONS)) {
        out.iter_mut().enumerate().for_each(|(direction, out)| *out = cell[(DIRECTIONS - direction) % DIRECTIONS]);
    }
    out
}

const CELLS: usize = 4;
const DIRECTIONS: usize = 8;
const BINS: usize = CELLS * CELLS * DIRECTIONS;
/// Number of cells along a side with one more at each end, so that pixels outside need no test.
const PADDED: usize = CELLS + 2;
/// Number of independent accumulators, so that an addition need not wait for the one before it.
const TURNS: usize = 4;

const PAIRS: usize = PADDED - 1;

/// Weighted values of some pixels, in the order of the pixels. Cells and directions are counted from the padding on.
#[derive(Debug, Default)]
struct Samples {
    /// Pair of cells above the pixel, between which it lies.
    cell: Vec<u32>,
    /// Direction before the pixel's, and the pixel's distance from it, in steps of directions.
    direction: Vec<u32>,
    past_direction: Vec<f32>,
    /// Distance of the pixel from the pair's left cell, as a fraction of the way to the right one.
    past_column: Vec<f32>,
    /// Weights in the pair and in the one below it.
    upper: Vec<f32>,
    lower: Vec<f32>,
}

struct SampleVector<'a> {
    cell: &'a mut [u32; LANES],
    direction: &'a mut [u32; LANES],
    past_direction: &'a mut Lane,
    past_column: &'a mut Lane,
    upper: &'a mut Lane,
    lower: &'a mut Lane,
}

impl Samples {
    fn room(&mut self, count: usize) {
        let count = count + LANES;
        if self.cell.len() < count {
            self.cell.resize(count, 0);
            self.direction.resize(count, 0);
            for values in [&mut self.past_direction, &mut self.past_column, &mut self.upper, &mut self.lower] {
                values.resize(count, 0.0);
            }
        }
    }

    #[inline(always)]
    fn vector(&mut self, at: usize) -> SampleVector<'_> {
        fn part<T>(values: &mut [T], at: usize) -> &mut [T; LANES] {
            (&mut values[at..at + LANES]).try_into().expect("a vector")
        }
        SampleVector {
            cell: part(&mut self.cell, at),
            direction: part(&mut self.direction, at),
            past_direction: part(&mut self.past_direction, at),
            past_column: part(&mut self.past_column, at),
            upper: part(&mut self.upper, at),
            lower: part(&mut self.lower, at),
        }
    }
}

/// Sums for each pair of neighbouring cells of a row: first the left cell's parts, then the right one's. A sample adds
/// to one pair and to the one below; kept apart, pairs never overlap.
#[repr(C, align(64))]
struct PairedCells([[[f32; 2 * DIRECTIONS]; PADDED * PAIRS]; TURNS]);

/// For each direction, its share in a pair's directions, and the change of the share towards the next direction.
#[repr(C, align(64))]
struct Shares([[[f32; 2 * DIRECTIONS]; 2]; DIRECTIONS]);

static SHARES: Shares = {
    let mut shares = [[[0.0; 2 * DIRECTIONS]; 2]; DIRECTIONS];
    let mut direction = 0;
    while direction < DIRECTIONS {
        let next = (direction + 1) % DIRECTIONS;
        let [at, change] = &mut shares[direction];
        (at[direction], at[DIRECTIONS + direction]) = (1.0, 1.0);
        (change[direction], change[DIRECTIONS + direction]) = (-1.0, -1.0);
        (change[next], change[DIRECTIONS + next]) = (1.0, 1.0);
        direction += 1;
    }
    Shares(shares)
};

impl PairedCells {
    #[inline(always)]
    fn new() -> Self {
        Self([[[0.0; 2 * DIRECTIONS]; PADDED * PAIRS]; TURNS])
    }

    #[inline(always)]
    fn add(&mut self, samples: &mut Samples, count: usize) {
        // Unused samples of the last turn add nothing.
        samples.upper[count..count + TURNS].fill(0.0);
        samples.lower[count..count + TURNS].fill(0.0);
        let count = count.next_multiple_of(TURNS);
        let Samples { cell, direction, past_direction, past_column, upper, lower } = &*samples;
        let (cell, direction, past_direction) = (&cell[..count], &direction[..count], &past_direction[..count]);
        let (past_column, upper, lower) = (&past_column[..count], &upper[..count], &lower[..count]);
        for first in (0..count).step_by(TURNS) {
            for (turn, pairs) in self.0.iter_mut().enumerate() {
                let i = first + turn;
                let [at, change] = &SHARES.0[direction[i] as usize % DIRECTIONS];
                let mut share = [0.0f32; 2 * DIRECTIONS];
                for (j, share) in share.iter_mut().enumerate() {
                    // 1 − past for the left cell, past for the right one.
                    let (start, slope) = if j < DIRECTIONS { (1.0, -1.0) } else { (0.0, 1.0) };
                    let column = past_column[i].mul_add(slope, start);
                    *share = past_direction[i].mul_add(change[j], at[j]) * column;
                }
                let pair = (cell[i] as usize).min((CELLS + 1) * PAIRS - 1);
                for (weight, pair) in [(upper[i], pair), (lower[i], pair + PAIRS)] {
                    for (sum, share) in pairs[pair].iter_mut().zip(&share) {
                        *sum = weight.mul_add(*share, *sum);
                    }
                }
            }
        }
    }

    fn sums(&self) -> [f32; BINS] {
        let mut out = [0.0; BINS];
        for (cell, out) in out.chunks_exact_mut(DIRECTIONS).enumerate() {
            let right = (cell / CELLS + 1) * PAIRS + cell % CELLS;
            for pairs in &self.0 {
                for (direction, out) in out.iter_mut().enumerate() {
                    *out += pairs[right][DIRECTIONS + direction] + pairs[right + 1][direction];
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::orient::tests::{SIZE, level_of};

    fn by_definition(level: &Patch, (x, y): (f32, f32), sigma: f32, orientation: f32) -> [f64; BINS] {
        let mut bins = [0.0; BINS];
        let cell = f64::from(MAGNIFICATION * sigma);
        let (sin, cos) = f64::from(orientation).sin_cos();
        for v in 1..100 {
            for u in 1..100 {
                let at = |du: i64, dv: i64| f64::from(level.row(v + dv)[(u + du) as usize]);
                let (gu, gv) = (0.5 * (at(1, 0) - at(-1, 0)), 0.5 * (at(0, 1) - at(0, -1)));
                let (du, dv) = (u as f64 - f64::from(x), v as f64 - f64::from(y));
                let (nx, ny) = ((cos * du + sin * dv) / cell, (cos * dv - sin * du) / cell);
                let window = (-(nx * nx + ny * ny) / 8.0).exp();
                let turned = (gv.atan2(gu) - f64::from(orientation)).rem_euclid(std::f64::consts::TAU);
                for (i, bin) in bins.iter_mut().enumerate() {
                    let (direction, cell) = (i % DIRECTIONS, i / DIRECTIONS);
                    let (cx, cy) = ((cell % CELLS) as f64 - 1.5, (cell / CELLS) as f64 - 1.5);
                    let far = (turned / std::f64::consts::TAU * 8.0 - direction as f64).abs();
                    let tent = |d: f64| (1.0 - d.abs()).max(0.0);
                    *bin += gu.hypot(gv) * window * tent(nx - cx) * tent(ny - cy) * tent(far.min(8.0 - far));
                }
            }
        }
        bins
    }

    #[test]
    fn the_fast_sums_are_the_definition() {
        let level = level_of(|u, v| (0.3 * u + 0.01 * u * v).sin() + (0.2 * v + 0.1 * u).cos() + 0.003 * u * v);
        for (i, orientation) in [0.0, 0.4, 1.0, std::f32::consts::FRAC_PI_2, 2.5, 3.9, 5.5, 6.2].into_iter().enumerate()
        {
            // The last ones reach beyond the image.
            let (place, sigma) = ((50.3 + 3.1 * i as f32, 49.6 - 4.2 * i as f32), 2.0 + 0.3 * i as f32);
            let expected = by_definition(&level, place, sigma, orientation);
            let square =
                Square { reach: descriptor_radius(sigma), ..Square::new(place, MAGNIFICATION * sigma, orientation) };
            let found = sums(&level, SIZE, &square, &mut DescriptorScratch::default());
            let largest = expected.iter().copied().fold(0.0, f64::max);
            for (found, expected) in found.iter().zip(expected) {
                assert!((f64::from(*found) - expected).abs() < 1e-4 * largest, "{orientation}: {found} {expected}");
            }
        }
    }

    #[test]
    fn a_disc_without_some_rows_gives_nearly_the_sums_of_the_square() {
        let wave = level_of(|u, v| (0.11 * u + 0.003 * u * v).sin() + (0.13 * v + 0.1 * u).cos());
        for (place, sigma, orientation) in
            [((50.3, 49.6), 2.1, 0.4), ((48.0, 51.2), 2.9, 2.5), ((12.5, 80.0), 3.1, 5.5)]
        {
            let mut scratch = DescriptorScratch::default();
            let square = sums(&wave, SIZE, &Square::of(place, sigma, orientation), &mut scratch);
            let disc = sums(&wave, SIZE, &Square::coarse(place, sigma, orientation), &mut scratch);
            let (square, disc) = (pool(&[square]), pool(&[disc]));
            let off: f32 = square.iter().zip(disc).map(|(a, b)| f32::from(a.abs_diff(b)).powi(2)).sum();
            assert!(off.sqrt() < 40.0, "{orientation}: {} of 512", off.sqrt());
        }
    }

    #[test]
    fn pooling_adds_normalised_scales() {
        let bins = |at: usize| {
            let mut bins = [0.0; BINS];
            bins[at] = 1.0 + at as f32;
            bins
        };
        // Two scales of different contrast weigh the same; the root of a half of 512 is beyond a byte.
        let pooled = pool(&[bins(0), bins(8), bins(16), bins(24), bins(32)]);
        let value = ((0.2f32).sqrt() * 512.0 + 0.5) as u8;
        for (i, &element) in pooled.iter().enumerate() {
            assert_eq!(element, if i % 8 == 0 && i <= 32 { value } else { 0 }, "{i}");
        }
        assert_eq!((pool(&[[0.0; BINS]; 2]), quantise([0.0; BINS])), ([0; BINS], [0; BINS]));
    }
}
