//! Evidence of windows around each cell, beside the posterior.
//!
//! *Small things.* A row of cells on a small thing seldom has enough evidence to pay for two borders, and the posterior
//! does not see the evidence of other rows. A small window overrules it where another motion has much more evidence.
//!
//! *Motions between the swept slopes.* Each cell's evidence is read at its own motion plus a common offset, whose sum
//! over a window has its peak where the window is off on average. A prior holds the offset against noise.
//!
//! *Certainty.* Sums over a wide window fall sharply where structure determines the motion: edges only across.

use super::evidence::Evidence;
use super::posterior::{Candidates, MotionEstimate};
use super::{eigen, turned};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;

/// Standard deviation of the window that overrules, cells.
const SMALL_CELLS: f64 = 1.75;
/// Evidence above which a window gets a second motion, nats.
const OVERRULING_NATS: f32 = 3.0;
/// Steps of the sweep between two motions that differ.
const OTHER_STEPS: f32 = 1.0;
/// Standard deviation of the window that moves motions, cells.
const WINDOW_CELLS: f64 = 3.0;
const ROUNDS: usize = 2;
/// Standard deviation of the offsets, pixels of smear between the first and the last frame.
const OFFSET_SMEAR_PX: f32 = 1.2;
/// Standard deviation of the wide window, cells.
const WIDE_CELLS: f64 = 14.0;
/// Part of the wide window's variance that counts, since errors in real pictures have other variances besides.
const WIDE_PART: f32 = 0.5;
/// Evidence in the wide window that a motion needs to be known, nats.
const KNOWN_NATS: f32 = 6.0;
/// Deviation by noise of the second difference of evidence between steps, as a part of the root of twice the evidence.
const CHANCE: f32 = 0.2;

/// Gives cells the motion of the window around them where it overrules what was `found`.
pub(super) fn overrule(found: &mut [MotionEstimate], evidence: &Evidence, monitor: &Monitor) -> Result<(), Cancelled> {
    let (width, height) = evidence.size;
    let grid = &evidence.grid;
    let sums = evidence.nats.par_iter().map(|nats| window_sums(nats, SMALL_CELLS, monitor));
    let sums: Vec<Plane> = sums.collect::<Result<_, _>>()?;
    let own = (0..found.len()).map(|place| nats_at(evidence, place, found[place].at));
    let own = window_sums(&Plane::from_vec(width, height, own.collect()), SMALL_CELLS, monitor)?;
    let candidates = Candidates { count: [grid.u.count, grid.v.count], per_step: 1 };
    let cells = found.par_iter_mut().zip(own.data()).enumerate();
    cells.for_each_init(Vec::new, |in_window, (place, (found, own))| {
        in_window.clear();
        in_window.extend(sums.iter().map(|sums| sums.data()[place]));
        let larger = |best: usize, (index, x): (usize, &f32)| if *x > in_window[best] { index } else { best };
        let best = in_window.iter().enumerate().fold(0, larger);
        let (i, j) = grid.coordinates(best);
        let apart = (i as f32 - found.at[0]).hypot(j as f32 - found.at[1]);
        let most = in_window[best];
        // Only clear evidence overrules: the posterior has used all cells, the window a few.
        if apart > OTHER_STEPS && most - own > OVERRULING_NATS {
            in_window.iter_mut().for_each(|x| *x = (*x - most).exp());
            *found = candidates.found(in_window);
        }
    });
    Ok(())
}

/// Moves each motion by the offset that its window suggests. Returns the covariances by the wide window, squared steps.
pub(super) fn refine(
    found: &mut [MotionEstimate],
    evidence: &Evidence,
    monitor: &Monitor,
) -> Result<Vec<[f32; 3]>, Cancelled> {
    let grid = &evidence.grid;
    let step = grid.u.step().max(grid.v.step());
    let prior_steps = OFFSET_SMEAR_PX / evidence.last_frame / step.max(f32::MIN_POSITIVE);
    for _ in 0..ROUNDS {
        let around = Around::new(found, evidence, WINDOW_CELLS, monitor)?;
        for (place, found) in found.iter_mut().enumerate() {
            let (_, gradient, information) = around.derivatives(place);
            let offset = offset(gradient, information, prior_steps);
            found.at = [found.at[0] + offset[0], found.at[1] + offset[1]];
        }
    }
    let wide = Around::new(found, evidence, WIDE_CELLS, monitor)?;
    let active = wide.reach.map(|reach| reach > 0);
    // A uniform distribution over n steps has the deviation n/√12.
    let range = [grid.u, grid.v].map(|axis| 12f32.sqrt() / axis.count as f32);
    let least = if active == [true; 2] { range[0].max(range[1]) } else { range[usize::from(active[1])] };
    let covariance = |place: usize| {
        let (nats, _, information) = wide.derivatives(place);
        let chance = if nats < KNOWN_NATS { f32::INFINITY } else { CHANCE * (2.0 * nats).sqrt() };
        let (rotation, values) = eigen(information);
        // Evidence within chance determines nothing.
        let certain = values.map(|value| (value * value.abs() - chance * chance).max(0.0).sqrt());
        let [uu, uv, vv] = turned(rotation, certain.map(|nats| 1.0 / (nats / WIDE_PART + least * least)));
        match active {
            [true, true] => [uu, uv, vv],
            [along_u, _] => [if along_u { uu } else { 0.0 }, 0.0, if along_u { 0.0 } else { vv }],
        }
    };
    Ok((0..found.len()).map(covariance).collect())
}

/// Sums over windows of the evidence for each cell's own motion and those a step beside it.
struct Around {
    /// Steps to each side along u and v: 0 where there is one slope.
    reach: [i64; 2],
    sums: Vec<Plane>,
}

impl Around {
    fn new(
        found: &[MotionEstimate],
        evidence: &Evidence,
        sigma_cells: f64,
        monitor: &Monitor,
    ) -> Result<Self, Cancelled> {
        let (width, height) = evidence.size;
        let reach = [evidence.grid.u, evidence.grid.v].map(|axis| i64::from(axis.count > 1));
        let [reach_u, reach_v] = reach;
        let steps: Vec<(i64, i64)> =
            (-reach_v..=reach_v).flat_map(|dj| (-reach_u..=reach_u).map(move |di| (di, dj))).collect();
        // Each cell is moved beside its own motion, since depths differ within a window.
        let sum_of = |&(di, dj): &(i64, i64)| {
            let nats = |(place, found): (usize, &MotionEstimate)| {
                nats_at(evidence, place, [found.at[0] + di as f32, found.at[1] + dj as f32])
            };
            let at_offset = Plane::from_vec(width, height, found.iter().enumerate().map(nats).collect());
            window_sums(&at_offset, sigma_cells, monitor)
        };
        Ok(Self { reach, sums: steps.par_iter().map(sum_of).collect::<Result<_, _>>()? })
    }

    /// The sum of the cell `place`, its gradient, and minus its second derivatives (of u, of u with v, of v), by steps.
    fn derivatives(&self, place: usize) -> (f32, [f32; 2], [f32; 3]) {
        let [reach_u, reach_v] = self.reach;
        // A step along an axis of one slope changes nothing.
        let at = |di: i64, dj: i64| {
            let (i, j) = (di.clamp(-reach_u, reach_u) + reach_u, dj.clamp(-reach_v, reach_v) + reach_v);
            self.sums[(j * (2 * reach_u + 1) + i) as usize].data()[place]
        };
        let middle = at(0, 0);
        let along = |[before, after]: [f32; 2]| (0.5 * (after - before), 2.0 * middle - before - after);
        let (gradient_u, uu) = along([at(-1, 0), at(1, 0)]);
        let (gradient_v, vv) = along([at(0, -1), at(0, 1)]);
        let uv = -0.25 * (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1));
        (middle, [gradient_u, gradient_v], [uu, uv, vv])
    }
}

/// Most likely offset, at most one step: the peak of the quadratic with a Gaussian prior of standard deviation
/// `prior_steps`. A direction in which the sum does not fall is left to the prior.
fn offset([gradient_u, gradient_v]: [f32; 2], information: [f32; 3], prior_steps: f32) -> [f32; 2] {
    let ((cos, sin), values) = eigen(information);
    let held = values.map(|nats| nats.max(0.0) + 1.0 / (prior_steps * prior_steps));
    let along = (cos * gradient_u + sin * gradient_v) / held[0];
    let across = (cos * gradient_v - sin * gradient_u) / held[1];
    let shorter = 1.0 / along.hypot(across).max(1.0);
    [shorter * (cos * along - sin * across), shorter * (sin * along + cos * across)]
}

/// Evidence of the cell `place` for the motion `at`, steps, linear between the slopes and constant beyond them.
fn nats_at(evidence: &Evidence, place: usize, at: [f32; 2]) -> f32 {
    let grid = &evidence.grid;
    let along = |x: f32, count: usize| {
        let x = x.clamp(0.0, (count - 1) as f32);
        let below = (x as usize).min(count.saturating_sub(2));
        (below, (below + 1).min(count - 1), x - below as f32)
    };
    let (i, i_next, u) = along(at[0], grid.u.count);
    let (j, j_next, v) = along(at[1], grid.v.count);
    let nats = |i: usize, j: usize| evidence.nats[j * grid.u.count + i].data()[place];
    let between = |a: f32, b: f32, part: f32| (1.0 - part) * a + part * b;
    between(between(nats(i, j), nats(i_next, j), u), between(nats(i, j_next), nats(i_next, j_next), u), v)
}

/// Sums of `plane` over Gaussian windows of `sigma_cells` around each cell, with weight 1 in the middle and nothing
/// beyond the edges: a repeated edge would count as often as it is repeated.
fn window_sums(plane: &Plane, sigma_cells: f64, monitor: &Monitor) -> Result<Plane, Cancelled> {
    monitor.check()?;
    let reach = (3.0 * sigma_cells).ceil() as usize;
    let weights: Vec<f32> = (0..=reach).map(|k| (-0.5 * (k as f64 / sigma_cells).powi(2)).exp() as f32).collect();
    Ok(weighted_sums(plane, &weights))
}

/// Sums along rows and columns with `weights` for the cells in the middle, and those beside them on both sides.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn weighted_sums(plane: &Plane, weights: &[f32]) -> Plane {
    let (width, height) = plane.size();
    let (mut columns, mut sums) = (Plane::zeros(width, height), Plane::zeros(width, height));
    for v in 0..height {
        let out = columns.row_mut(v);
        for from in v.saturating_sub(weights.len() - 1)..(v + weights.len()).min(height) {
            let weight = weights[from.abs_diff(v)];
            out.iter_mut().zip(plane.row(from)).for_each(|(sum, x)| *sum += weight * x);
        }
        let (from, out) = (columns.row(v), sums.row_mut(v));
        for (k, weight) in weights.iter().enumerate().take(width) {
            out.iter_mut().zip(&from[k..]).for_each(|(sum, x)| *sum += weight * x);
            // The middle weight has no mirror image.
            if k > 0 {
                out[k..].iter_mut().zip(from).for_each(|(sum, x)| *sum += weight * x);
            }
        }
    }
    sums
}
