//! The affine map from chip to chip: inverse-compositional Lucas–Kanade (Baker, Matthews, IJCV 2004).
//!
//! Brightness may differ by offset and factor. A weak prior holds the map near its start, where a chip is mostly noise.

use super::grid::{Affine, OnLattice, Points};
use multiversion::multiversion;
use nalgebra::{Cholesky, Const, SMatrix, SVector};

const ROUNDS: usize = 8;
/// Standard deviation of the matrix's elements about the identity.
const MATRIX_SIGMA: f32 = 0.2;
/// Standard deviation of the shift about that of the search, σ.
const SHIFT_SIGMA: f32 = 1.0;
/// Largest change of the shift in a round, σ.
const LARGEST_STEP: f32 = 0.5;
/// Largest change of the matrix's elements in a round.
const LARGEST_TURN: f32 = 0.15;
/// Noise of a chip as a share of its variance, and independent values in a squared σ, which set the prior's weight.
const NOISE: f32 = 0.3;
const INDEPENDENT: f32 = 0.6;
/// Least correlation by which the factor of brightness is taken as noise.
const LEAST_GAIN: f32 = 0.5;
/// Least share of the window, by weight, that both chips show.
const LEAST_SEEN: f32 = 0.5;
/// Unknowns: shift along x and y, and the matrix row by row, which acts on points in units of the radius.
const UNKNOWNS: usize = 6;
/// Points are padded to a multiple of this by those of weight 0.
const LANES: usize = 16;

#[derive(Debug)]
pub(super) struct Window {
    radius: f32,
    x: Vec<f32>,
    y: Vec<f32>,
    weights: Vec<f32>,
    prior: [f32; UNKNOWNS],
    /// Least correlation at the start of a fit.
    least_at_start: f32,
    /// Change of all unknowns, σ, below which a fit ends.
    still_sigmas: f32,
}

#[derive(Debug, Default)]
pub(super) struct FitScratch {
    template: Vec<f32>,
    weights: Vec<f32>,
    derivatives: [Vec<f32>; UNKNOWNS],
    values: Vec<f32>,
    seen: Vec<f32>,
}

/// Best map of all rounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    /// What the first chip shows at q of the lattice, the second shows at this map's q.
    pub map: Affine,
    /// Correlation over the window, −1 … 1.
    pub correlation: f32,
}

impl Window {
    /// Window that reaches `radius` σ.
    pub fn new(radius: f32) -> Self {
        let reach = radius as i32;
        let square = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x as f32, y as f32)));
        let squared = |(x, y): &(f32, f32)| x * x + y * y;
        let points: Vec<(f32, f32)> = square.filter(|point| squared(point) <= radius * radius).collect();
        let mut weights: Vec<f32> = points.iter().map(|p| (-2.0 * squared(p) / (radius * radius)).exp()).collect();
        let sum: f32 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        let padded = |mut values: Vec<f32>| {
            values.resize(values.len().next_multiple_of(LANES), 0.0);
            values
        };
        // The prior weighs against the noise of a mean over the window's independent values.
        let noise = NOISE / (INDEPENDENT * radius * radius);
        let (shift, matrix) = (noise / SHIFT_SIGMA.powi(2), noise / (MATRIX_SIGMA * radius).powi(2));
        let along = |of: fn(&(f32, f32)) -> f32| padded(points.iter().map(of).collect());
        let prior = [shift, shift, matrix, matrix, matrix, matrix];
        let (x, y) = (along(|point| point.0), along(|point| point.1));
        Self { radius, x, y, weights: padded(weights), prior, least_at_start: f32::MIN, still_sigmas: 0.0 }
    }

    /// Window for fits that begin near their end: less alike at their start than `least_at_start`, they are given up.
    pub fn near(radius: f32, least_at_start: f32, still_sigmas: f32) -> Self {
        Self { least_at_start, still_sigmas, ..Self::new(radius) }
    }

    fn points(&self) -> Points<'_> {
        Points { x: &self.x, y: &self.y }
    }

    /// Fits the map of the lattice by which `a` becomes `b`, each a grid with the lattice's places, from the shift
    /// `start` on. `None` where too little of either is seen or the window has no contrast.
    pub fn fit(&self, a: OnLattice, b: OnLattice, start: [f32; 2], scratch: &mut FitScratch) -> Option<Fit> {
        // Inverse composition: the derivatives are of `a` alone, so the normal equations are made once.
        let (hessian, begin) = (self.prepare(a, scratch)?, Affine::shifted(start));
        let (mut map, mut best) = (begin, None::<Fit>);
        for round in 0..=ROUNDS {
            b.0.read(&b.1.after(&map), self.points(), &mut scratch.values, &mut scratch.seen);
            let Some(alike) = Likeness::of(moments(scratch)) else { break };
            if round == 0 && alike.correlation < self.least_at_start {
                return None;
            }
            // A step may lead away again, so the best map of all rounds is kept.
            if best.is_none_or(|best| alike.correlation > best.correlation) {
                best = Some(Fit { map, correlation: alike.correlation });
            }
            if round == ROUNDS {
                break;
            }
            // The prior draws the map back to its start.
            let held = self.unknowns(&map, &begin);
            let descent = descent(scratch, &alike);
            let gradient = SVector::<f64, UNKNOWNS>::from_fn(|k, _| f64::from(descent[k] + self.prior[k] * held[k]));
            let Some(next) = self.stepped(&map, &hessian.solve(&gradient)) else { break };
            map = next;
            let moved = self.unknowns(&map, &begin).into_iter().zip(held).map(|(now, before)| (now - before).abs());
            if moved.fold(0.0, f32::max) < self.still_sigmas {
                break;
            }
        }
        best
    }

    /// Reads `a` with its derivatives into `scratch`, and returns the matrix of the normal equations.
    fn prepare(&self, a: OnLattice, scratch: &mut FitScratch) -> Option<Cholesky<f64, Const<UNKNOWNS>>> {
        let count = self.x.len();
        let FitScratch { template, weights, derivatives, values, seen } = scratch;
        for buffer in [&mut *template, weights, values, seen].into_iter().chain(derivatives.iter_mut()) {
            buffer.resize(count, 0.0);
        }
        let [along_x, along_y, ..] = derivatives;
        a.0.read_with_gradient(a.1, self.points(), [template, along_x, along_y, weights]);
        weights.iter_mut().zip(&self.weights).for_each(|(seen, weight)| *seen *= weight);
        let sum: f32 = weights.iter().sum();
        let mean = weighted(weights, template) / sum;
        // Mean 0 and variance 1, since brightness may differ by an offset and a factor.
        template.iter_mut().for_each(|value| *value -= mean);
        let variance = template.iter().zip(&*weights).map(|(t, w)| w * t * t).sum::<f32>() / sum;
        if sum < LEAST_SEEN || variance <= 1e-6 {
            return None;
        }
        let scale = variance.sqrt().recip();
        template.iter_mut().for_each(|value| *value *= scale);
        for k in 0..count {
            let (x, y) = (self.x[k] / self.radius, self.y[k] / self.radius);
            // In units of the radius all unknowns are of one size.
            let (along_x, along_y) = (scale * derivatives[0][k], scale * derivatives[1][k]);
            let all = [along_x, along_y, along_x * x, along_x * y, along_y * x, along_y * y];
            derivatives.iter_mut().zip(all).for_each(|(derivative, value)| derivative[k] = value);
        }
        // Without their means, a change of brightness by an offset has no derivative.
        for derivative in derivatives.iter_mut() {
            let mean = weighted(weights, derivative) / sum;
            derivative.iter_mut().for_each(|value| *value -= mean);
        }
        let products = products(scratch);
        let entry = |i: usize, j: usize| {
            let prior = if i == j { self.prior[i] + 1e-6 } else { 0.0 };
            f64::from(products[i.min(j)][i.max(j)] + prior)
        };
        SMatrix::<f64, UNKNOWNS, UNKNOWNS>::from_fn(entry).cholesky()
    }

    fn unknowns(&self, map: &Affine, begin: &Affine) -> [f32; UNKNOWNS] {
        let [[a, b], [c, d]] = map.matrix;
        let [dx, dy] = [0, 1].map(|i| map.shift[i] - begin.shift[i]);
        let radius = self.radius;
        [dx, dy, (a - 1.0) * radius, b * radius, c * radius, (d - 1.0) * radius]
    }

    /// `map` after the inverse of a step, which is limited. `None` where that makes no sense any more.
    fn stepped(&self, map: &Affine, step: &SVector<f64, UNKNOWNS>) -> Option<Affine> {
        let shift = |k: usize| (step[k] as f32).clamp(-LARGEST_STEP, LARGEST_STEP);
        let turn = |k: usize| (step[k] as f32 / self.radius).clamp(-LARGEST_TURN, LARGEST_TURN);
        let matrix = [[1.0 + turn(2), turn(3)], [turn(4), 1.0 + turn(5)]];
        Some(map.after(&Affine { matrix, shift: [shift(0), shift(1)] }.inverse()?))
    }
}

/// How alike two chips are over the points that both show.
struct Likeness {
    correlation: f32,
    mean: [f32; 2],
    /// One over the standard deviation of template and values.
    scale: [f32; 2],
}

impl Likeness {
    fn of([weight, t, tt, s, ss, ts]: [f32; 6]) -> Option<Self> {
        let mean = [t / weight, s / weight];
        let variance = [tt / weight - mean[0] * mean[0], ss / weight - mean[1] * mean[1]];
        if !(weight >= LEAST_SEEN && variance.iter().all(|variance| *variance > 1e-6)) {
            return None;
        }
        let scale = variance.map(|variance| variance.sqrt().recip());
        Some(Self { correlation: (ts / weight - mean[0] * mean[1]) * scale[0] * scale[1], mean, scale })
    }
}

fn weighted(weights: &[f32], values: &[f32]) -> f32 {
    weights.iter().zip(values).map(|(w, x)| w * x).sum()
}

fn total(lanes: [f32; LANES]) -> f32 {
    lanes.iter().sum()
}

/// Weighted products of the derivatives, the upper triangle.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn products(scratch: &FitScratch) -> [[f32; UNKNOWNS]; UNKNOWNS] {
    let mut products = [[0.0; UNKNOWNS]; UNKNOWNS];
    for (i, row) in products.iter_mut().enumerate() {
        for (j, product) in row.iter_mut().enumerate().skip(i) {
            let mut sums = [0.0; LANES];
            let blocks = scratch.weights.chunks_exact(LANES).zip(scratch.derivatives[i].chunks_exact(LANES));
            for ((w, a), b) in blocks.zip(scratch.derivatives[j].chunks_exact(LANES)) {
                for l in 0..LANES {
                    sums[l] += w[l] * a[l] * b[l];
                }
            }
            *product = total(sums);
        }
    }
    products
}

/// Weighted sums over the points that both show: of 1, template, its square, values, their square, and the product.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn moments(scratch: &FitScratch) -> [f32; 6] {
    let mut sums = [[0.0; LANES]; 6];
    let blocks = scratch.weights.chunks_exact(LANES).zip(scratch.seen.chunks_exact(LANES));
    let pictures = scratch.template.chunks_exact(LANES).zip(scratch.values.chunks_exact(LANES));
    for ((w, m), (t, s)) in blocks.zip(pictures) {
        for l in 0..LANES {
            // All six in one pass: the values of a round are read once.
            let weight = w[l] * m[l];
            sums[0][l] += weight;
            sums[1][l] += weight * t[l];
            sums[2][l] += weight * t[l] * t[l];
            sums[3][l] += weight * s[l];
            sums[4][l] += weight * s[l] * s[l];
            sums[5][l] += weight * t[l] * s[l];
        }
    }
    sums.map(total)
}

/// Weighted sum of the chips' difference times each derivative; noise is made up for by a gain of at most two.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn descent(scratch: &FitScratch, alike: &Likeness) -> [f32; UNKNOWNS] {
    let gain = alike.scale[1] / alike.correlation.max(LEAST_GAIN);
    let (mean, scale) = (alike.mean, alike.scale[0]);
    // One sum a lane: the compiler vectorises the loops, and the order of additions is fixed.
    let mut sums = [[0.0; LANES]; UNKNOWNS];
    let blocks = scratch.weights.chunks_exact(LANES).zip(scratch.seen.chunks_exact(LANES));
    let pictures = scratch.template.chunks_exact(LANES).zip(scratch.values.chunks_exact(LANES));
    for (block, ((w, m), (t, s))) in blocks.zip(pictures).enumerate() {
        // Both chips at mean 0 and equal strength: an exposure differs from burst to burst.
        let mut differences = [0.0; LANES];
        for l in 0..LANES {
            differences[l] = w[l] * m[l] * ((s[l] - mean[1]) * gain - (t[l] - mean[0]) * scale);
        }
        for (sum, derivative) in sums.iter_mut().zip(&scratch.derivatives) {
            let derivative = &derivative[block * LANES..(block + 1) * LANES];
            for l in 0..LANES {
                sum[l] += differences[l] * derivative[l];
            }
        }
    }
    sums.map(total)
}
