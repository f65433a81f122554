//! One chip found in another: normalised correlation at all whole shifts, and its peak between them.

use super::grid::{OnLattice, Points};
use multiversion::multiversion;

/// Lattice points from the middle of the window to each side, σ.
const RADIUS: usize = 8;
/// Largest shift along each axis, σ.
const SHIFT: usize = 3;
/// Points on a side of the window, and of all that is searched.
const WINDOW: usize = 2 * RADIUS + 1;
const WIDE: usize = WINDOW + 2 * SHIFT;
/// Shifts along one axis; the last of `LANES` is computed and dropped.
const SHIFTS: usize = 2 * SHIFT + 1;
const LANES: usize = 8;
/// Values from row to row of what is searched: all lanes of the last shift are held.
const STRIDE: usize = WINDOW + LANES;
/// Least share of the window, by weight, that both chips show.
const LEAST_SEEN: f32 = 0.5;

#[derive(Debug)]
pub(super) struct Search {
    weights: Vec<f32>,
    window: [Vec<f32>; 2],
    wide: [Vec<f32>; 2],
}

#[derive(Debug)]
pub(super) struct SearchScratch {
    template: Vec<f32>,
    template_seen: Vec<f32>,
    searched: Vec<f32>,
    searched_seen: Vec<f32>,
}

impl Default for SearchScratch {
    fn default() -> Self {
        let (window, wide) = (vec![0.0; WINDOW * WINDOW], vec![0.0; WIDE * STRIDE]);
        Self { template: window.clone(), template_seen: window, searched: wide.clone(), searched_seen: wide }
    }
}

impl Search {
    pub fn new() -> Self {
        let square = |side: usize, stride: usize| {
            let around = |index: usize| index as f32 - (side / 2) as f32;
            let all = 0..side * stride;
            [all.clone().map(|k| around(k % stride)).collect::<Vec<f32>>(), all.map(|k| around(k / stride)).collect()]
        };
        let window = square(WINDOW, WINDOW);
        let radius = RADIUS as f32;
        let weight = |(x, y): (&f32, &f32)| {
            let squared = x * x + y * y;
            // Round, so that a rotation between the chips changes no weight.
            if squared <= radius * radius { (-2.0 * squared / (radius * radius)).exp() } else { 0.0 }
        };
        let weights: Vec<f32> = window[0].iter().zip(&window[1]).map(weight).collect();
        let sum: f32 = weights.iter().sum();
        Self { weights: weights.iter().map(|w| w / sum).collect(), window, wide: square(WIDE, STRIDE) }
    }

    /// Shift along the lattice's axes, σ, at which `b` is most like `a`, each a grid with the lattice's places. `None`
    /// for a shift on the rim, beyond which the true one may lie, and where too little of either is seen.
    pub fn peak(&self, a: OnLattice, b: OnLattice, scratch: &mut SearchScratch) -> Option<[f32; 2]> {
        let window = Points { x: &self.window[0], y: &self.window[1] };
        let wide = Points { x: &self.wide[0], y: &self.wide[1] };
        a.0.read(a.1, window, &mut scratch.template, &mut scratch.template_seen);
        b.0.read(b.1, wide, &mut scratch.searched, &mut scratch.searched_seen);
        peak_of(&correlations(&self.weights, scratch))
    }
}

/// Sums for each shift over points seen in both: of weights, template, its square, searched, its square, the product.
type Sums = [[f32; LANES]; 6];

/// Correlation at each shift, rows of shifts along y; −1 where too little is seen.
fn correlations(weights: &[f32], scratch: &SearchScratch) -> [[f32; SHIFTS]; SHIFTS] {
    let mut found = [[-1.0; SHIFTS]; SHIFTS];
    for (y, found) in found.iter_mut().enumerate() {
        let mut sums = [[0.0; LANES]; 6];
        add(weights, scratch, y, &mut sums);
        for (x, found) in found.iter_mut().enumerate() {
            let [weight, t, tt, s, ss, ts] = [0, 1, 2, 3, 4, 5].map(|k| sums[k][x]);
            let (variance_t, variance_s) = (tt - t * t / weight, ss - s * s / weight);
            // Each shift has its own means: near a chip's rim different samples are seen.
            if weight >= LEAST_SEEN && variance_t > 1e-6 && variance_s > 1e-6 {
                *found = (ts - t * s / weight) / (variance_t * variance_s).sqrt();
            }
        }
    }
    found
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn add(weights: &[f32], scratch: &SearchScratch, y: usize, out: &mut Sums) {
    let mut sums = *out;
    for j in 0..WINDOW {
        let row = (j + y) * STRIDE..(j + y + 1) * STRIDE;
        let (searched, seen) = (&scratch.searched[row.clone()], &scratch.searched_seen[row]);
        for i in 0..WINDOW {
            let k = j * WINDOW + i;
            let weight = weights[k] * scratch.template_seen[k];
            if weight == 0.0 {
                continue;
            }
            let (t, s, m) = (scratch.template[k], &searched[i..i + LANES], &seen[i..i + LANES]);
            let (weight_t, weight_tt) = (weight * t, weight * t * t);
            // All shifts along x at once, one a lane.
            for l in 0..LANES {
                sums[0][l] += weight * m[l];
                sums[1][l] += weight_t * m[l];
                sums[2][l] += weight_tt * m[l];
                sums[3][l] += weight * s[l];
                sums[4][l] += weight * s[l] * s[l];
                sums[5][l] += weight_t * s[l];
            }
        }
    }
    *out = sums;
}

/// Place of the peak of the quadratic function through the nine correlations around the largest.
fn peak_of(correlations: &[[f32; SHIFTS]; SHIFTS]) -> Option<[f32; 2]> {
    let of = |(x, y): (usize, usize)| correlations[y][x];
    let all = (0..SHIFTS * SHIFTS).map(|k| (k % SHIFTS, k / SHIFTS));
    let (x, y) = all.reduce(|best, other| if of(other) > of(best) { other } else { best })?;
    let inner = 1..SHIFTS - 1;
    let around = |dx: usize, dy: usize| correlations[y + dy - 1][x + dx - 1];
    let known = |k: usize| around(k % 3, k / 3) > -1.0;
    // On the rim, or beside shifts without a correlation, no peak can be fitted.
    if !inner.contains(&x) || !inner.contains(&y) || !(0..9).all(known) {
        return None;
    }
    let middle = around(1, 1);
    let gradient = [(around(2, 1) - around(0, 1)) / 2.0, (around(1, 2) - around(1, 0)) / 2.0];
    let (xx, yy) = (around(2, 1) + around(0, 1) - 2.0 * middle, around(1, 2) + around(1, 0) - 2.0 * middle);
    let xy = (around(2, 2) + around(0, 0) - around(2, 0) - around(0, 2)) / 4.0;
    let determinant = xx * yy - xy * xy;
    // Without a maximum in between, the largest correlation stands.
    let between = if determinant > 1e-12 && xx < 0.0 && yy < 0.0 {
        let solved = [yy * gradient[0] - xy * gradient[1], xx * gradient[1] - xy * gradient[0]];
        solved.map(|s| (-s / determinant).clamp(-1.0, 1.0))
    } else {
        [0.0; 2]
    };
    let at = |index: usize, between: f32| index as f32 - SHIFT as f32 + between;
    Some([at(x, between[0]), at(y, between[1])])
}
