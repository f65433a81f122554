//! From evidence to motions: windows from large to small, and the peak of their sums between the slopes.
//!
//! The evidence of all cells in a window adds up. A large window knows most but sees only what most of it does; a small
//! one sees small things and is easily led astray. So the largest decides first, and each smaller one overrules it only
//! where another slope has [`OVERRULING_NATS`] more evidence in it: by chance alone odds of e⁵ are rare among the
//! windows of a picture. The decided motions then follow how the scene's motion changes within a window: each cell's
//! evidence is read at its own motion plus a common offset, whose sum over the window has its peak where the window is
//! off on average. The offset is held by a prior, as noise would move each cell where it likes.

use super::evidence::{Evidence, enlarged, means};
use super::{Motion, eigen};
use crate::detector::params::slope_grid::Slope;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use crate::plane::blur::smoothed;
use rayon::prelude::*;

/// Number of places whose evidence is compared at once: as many as the cache holds.
const PLACES_AT_ONCE: usize = 2048;
/// Evidence that a motion needs to be known, nats: the best of all slopes in noise has less.
const KNOWN_NATS: f32 = 6.0;
/// Standard deviations of the windows that decide, cells.
const DECIDING_CELLS: [f64; 4] = [14.0, 7.0, 3.5, 1.75];
/// Standard deviations of the windows whose offsets refine the motions, cells.
const REFINING_CELLS: [f64; 5] = [12.0, 8.0, 6.0, 4.0, 3.0];
/// Evidence that a smaller window needs for another slope than the larger one's, nats.
const OVERRULING_NATS: f32 = 5.0;
/// Steps of the sweep between two slopes that differ.
const OTHER_STEPS: f32 = 0.9;
/// Standard deviation of the peak's distance from the best slope, steps: hardly a constraint.
const PEAK_STEPS: f32 = 2.0;
/// Standard deviation of the offsets, pixels of smear between the first and the last frame.
const OFFSET_SMEAR_PX: f32 = 1.2;

/// Variance of a motion that no evidence describes: structure that moves otherwise within the window, (px/frame)² of a
/// smear of this many pixels.
const FLOOR_SMEAR_PX: f32 = 0.3;

/// Standard deviation of the window in which changes of the motion are looked at, cells.
const CHANGE_WINDOW_CELLS: f64 = 4.0;
/// Cells by which a border between motions is placed wrongly: where the motion changes, it is as uncertain as it changes
/// over so many.
const CHANGE_CELLS: f32 = 0.5;
/// Standard deviation of the second difference of evidence between steps that noise alone gives, as a part of the root
/// of twice the evidence: the noise of stacks a step apart is nearly the same.
const CHANCE: f32 = 0.2;

/// Motion of each cell and the standard deviation of the window that decided on it, pixels.
pub(super) fn motions(evidence: &Evidence, monitor: &Monitor) -> Result<(Vec<Motion>, Vec<f32>), Cancelled> {
    let sweep = Sweep { evidence, active: [evidence.grid.u.count > 1, evidence.grid.v.count > 1] };
    let mut cells = sweep.decided(monitor)?;
    if sweep.active != [false; 2] {
        for cells_sigma in REFINING_CELLS {
            sweep.refine(&mut cells, cells_sigma, monitor)?;
        }
    }
    let cell_px = evidence.cell_px as f32;
    let changes = [sweep.changes(0, &cells, monitor)?, sweep.changes(1, &cells, monitor)?];
    let told = |(place, cell): (usize, &Cell)| {
        let change = [&changes[0], &changes[1]].map(|change| change.data()[place]);
        (sweep.motion(cell, change), cell.window_cells * cell_px)
    };
    Ok(cells.iter().enumerate().map(told).unzip())
}

/// Decision on one cell.
#[derive(Clone, Copy)]
struct Cell {
    /// Swept slope with the most evidence.
    index: usize,
    /// Motion in coordinates of the sweep's grid, steps.
    at: [f32; 2],
    /// Minus the second derivatives of the evidence there: along u, mixed, along v; nats a squared step.
    information: [f32; 3],
    /// Standard deviation of the window that decided, cells.
    window_cells: f32,
    /// Evidence in that window, nats.
    nats: f32,
}

struct Sweep<'a> {
    evidence: &'a Evidence,
    /// Whether the axes of the grid have several slopes.
    active: [bool; 2],
}

impl Sweep<'_> {
    /// Decides on all cells, the largest window first.
    fn decided(&self, monitor: &Monitor) -> Result<Vec<Cell>, Cancelled> {
        let mut decided: Option<Vec<Cell>> = None;
        for sigma_cells in DECIDING_CELLS {
            let sums = self.evidence.nats.par_iter().map(|nats| window_sums(nats, sigma_cells, monitor));
            let sums: Vec<Plane> = sums.collect::<Result<_, _>>()?;
            let most = most(&sums);
            let cell_of = |place: usize| -> Cell {
                let sum = |index: usize| sums[index].data()[place];
                let index = most[place] as usize;
                let own = || self.peak(index, &sum, sigma_cells as f32);
                let Some(larger) = decided.as_ref().map(|cells| cells[place]) else { return own() };
                let [(i, j), (k, l)] = [index, larger.index].map(|index| self.evidence.grid.coordinates(index));
                let apart = (i as f32 - k as f32).hypot(j as f32 - l as f32);
                if apart > OTHER_STEPS && sum(index) - sum(larger.index) > OVERRULING_NATS { own() } else { larger }
            };
            decided = Some((0..self.cell_count()).into_par_iter().map(cell_of).collect());
        }
        Ok(decided.unwrap_or_default())
    }

    fn cell_count(&self) -> usize {
        self.evidence.size.0 * self.evidence.size.1
    }

    /// The peak of the window's sums around the slope `index`, which has the most.
    fn peak(&self, index: usize, sum: &dyn Fn(usize) -> f32, window_cells: f32) -> Cell {
        let grid = &self.evidence.grid;
        let (i, j) = grid.coordinates(index);
        let inside = |at: usize, count: usize| at.clamp(usize::from(count > 1), count.saturating_sub(2));
        let (i, j) = (inside(i, grid.u.count), inside(j, grid.v.count));
        let around = |di: i64, dj: i64| sum((j as i64 + dj) as usize * grid.u.count + (i as i64 + di) as usize);
        let (gradient, information) = self.derivatives(&around);
        let offset = offset(gradient, information, PEAK_STEPS);
        let information = certain(information, sum(index));
        let nats = sum(index);
        Cell { index, at: [i as f32 + offset[0], j as f32 + offset[1]], information, window_cells, nats }
    }

    /// Gradient and information of a function of the offset in steps, by differences of one step.
    fn derivatives(&self, around: &dyn Fn(i64, i64) -> f32) -> ([f32; 2], [f32; 3]) {
        let middle = around(0, 0);
        let along = |axis: usize| {
            if !self.active[axis] {
                return (0.0, 0.0);
            }
            let ends = [-1, 1].map(|step| if axis == 0 { around(step, 0) } else { around(0, step) });
            (0.5 * (ends[1] - ends[0]), 2.0 * middle - ends[0] - ends[1])
        };
        let ((gradient_u, uu), (gradient_v, vv)) = (along(0), along(1));
        let uv = if self.active == [true; 2] {
            -0.25 * (around(1, 1) - around(1, -1) - around(-1, 1) + around(-1, -1))
        } else {
            0.0
        };
        ([gradient_u, gradient_v], [uu, uv, vv])
    }

    /// Moves each cell by the offset that its window of `sigma_cells` asks for.
    fn refine(&self, cells: &mut [Cell], sigma_cells: f64, monitor: &Monitor) -> Result<(), Cancelled> {
        let (width, height) = self.evidence.size;
        let [reach_u, reach_v] = self.active.map(i64::from);
        let steps: Vec<(i64, i64)> =
            (-reach_v..=reach_v).flat_map(|dj| (-reach_u..=reach_u).map(move |di| (di, dj))).collect();
        let sum_of = |&(di, dj): &(i64, i64)| {
            let nats =
                |(place, cell): (usize, &Cell)| self.nats_at(place, [cell.at[0] + di as f32, cell.at[1] + dj as f32]);
            let at_offset = Plane::from_vec(width, height, cells.iter().enumerate().map(nats).collect());
            window_sums(&at_offset, sigma_cells, monitor)
        };
        let sums: Vec<Plane> = steps.par_iter().map(sum_of).collect::<Result<_, _>>()?;
        let row = 2 * reach_u + 1;
        let prior = self.prior_steps();
        for (place, cell) in cells.iter_mut().enumerate() {
            let around = |di: i64, dj: i64| sums[((dj + reach_v) * row + di + reach_u) as usize].data()[place];
            let (gradient, information) = self.derivatives(&around);
            let offset = offset(gradient, information, prior);
            cell.at = [cell.at[0] + offset[0], cell.at[1] + offset[1]];
        }
        Ok(())
    }

    /// Evidence of the cell `place` for the motion `at`, linear between the slopes and constant beyond them.
    fn nats_at(&self, place: usize, at: [f32; 2]) -> f32 {
        let grid = &self.evidence.grid;
        let along = |x: f32, count: usize| {
            let x = x.clamp(0.0, (count - 1) as f32);
            let below = (x as usize).min(count.saturating_sub(2));
            (below, (below + 1).min(count - 1), x - below as f32)
        };
        let (i, i_next, u) = along(at[0], grid.u.count);
        let (j, j_next, v) = along(at[1], grid.v.count);
        let nats = |i: usize, j: usize| self.evidence.nats[j * grid.u.count + i].data()[place];
        let between = |a: f32, b: f32, part: f32| (1.0 - part) * a + part * b;
        let row = |j: usize| between(nats(i, j), nats(i_next, j), u);
        if v == 0.0 { row(j) } else { between(row(j), row(j_next), v) }
    }

    /// Length of a step along the axes, px/frame; that of the other axis where one has no steps.
    fn step_px_per_frame(&self) -> [f32; 2] {
        [self.evidence.grid.u, self.evidence.grid.v].map(|axis| axis.step())
    }

    fn prior_steps(&self) -> f32 {
        let step = self.step_px_per_frame().into_iter().fold(0.0, f32::max);
        OFFSET_SMEAR_PX / self.evidence.last_frame / step.max(f32::MIN_POSITIVE)
    }

    /// Mean square of the change of the motion along an axis of the grid from cell to cell, around each, (px/frame)².
    fn changes(&self, axis: usize, cells: &[Cell], monitor: &Monitor) -> Result<Plane, Cancelled> {
        let (width, height) = self.evidence.size;
        let step = self.step_px_per_frame()[axis];
        let square = |one: &Cell, other: &Cell| (step * (one.at[axis] - other.at[axis])).powi(2);
        let change = Plane::from_fn(width, height, |i, j| {
            let at = |i: usize, j: usize| &cells[j * width + i];
            square(at(i, j), at((i + 1).min(width - 1), j)) + square(at(i, j), at(i, (j + 1).min(height - 1)))
        });
        smoothed(&change, CHANGE_WINDOW_CELLS, monitor)
    }

    /// The motion of a cell in pixels per frame; `change` is the mean square of its change around it along both axes.
    fn motion(&self, cell: &Cell, change: [f32; 2]) -> Motion {
        let grid = &self.evidence.grid;
        let slope: Slope = grid.at(cell.at[0], cell.at[1]);
        let step = self.step_px_per_frame();
        let floor = (FLOOR_SMEAR_PX / self.evidence.last_frame).powi(2);
        // Where nothing is known it is somewhere in the swept range.
        let range = [grid.u, grid.v].map(|axis| 12f32.sqrt() / axis.count as f32);
        let (rotation, values) = eigen(cell.information);
        let known = if self.active == [true; 2] { range[0].max(range[1]) } else { range[usize::from(self.active[1])] };
        let values = if cell.nats < KNOWN_NATS { [0.0; 2] } else { values };
        let variances = values.map(|nats| 1.0 / (nats.max(0.0) + known * known));
        let [mut uu, uv, mut vv] = turned(rotation, variances);
        (uu, vv) = (if self.active[0] { uu } else { 0.0 }, if self.active[1] { vv } else { 0.0 });
        let uv = if self.active == [true; 2] { uv } else { 0.0 };
        let scaled = [uu * step[0] * step[0], uv * step[0] * step[1], vv * step[1] * step[1]];
        let (sin, cos) = grid.direction_deg.to_radians().sin_cos();
        let [a, b, c] = scaled;
        let [a, c] = [a + CHANGE_CELLS * CHANGE_CELLS * change[0], c + CHANGE_CELLS * CHANGE_CELLS * change[1]];
        let covariance = [
            a * cos * cos - 2.0 * b * sin * cos + c * sin * sin,
            (a - c) * sin * cos + b * (cos * cos - sin * sin),
            a * sin * sin + 2.0 * b * sin * cos + c * cos * cos,
        ];
        let covariance = [covariance[0] + floor, covariance[1], covariance[2] + floor];
        Motion { slope, covariance }
    }
}

/// Index of the plane with the largest value, of each place; the first of equal ones.
fn most(planes: &[Plane]) -> Vec<u32> {
    let count = planes.first().map_or(0, |plane| plane.data().len());
    let mut most = vec![0u32; count];
    most.par_chunks_mut(PLACES_AT_ONCE).enumerate().for_each(|(chunk, most)| {
        let start = chunk * PLACES_AT_ONCE;
        let mut largest = vec![f32::NEG_INFINITY; most.len()];
        for (index, plane) in planes.iter().enumerate() {
            let values = &plane.data()[start..start + most.len()];
            // Without branches, for the processor's vectors.
            for ((largest, most), &value) in largest.iter_mut().zip(most.iter_mut()).zip(values) {
                *most = if value > *largest { index as u32 } else { *most };
                *largest = if value > *largest { value } else { *largest };
            }
        }
    });
    most
}

/// The symmetric matrix with these principal axes and eigenvalues.
fn turned((cos, sin): (f32, f32), [first, second]: [f32; 2]) -> [f32; 3] {
    let uv = (first - second) * cos * sin;
    [first * cos * cos + second * sin * sin, uv, first * sin * sin + second * cos * cos]
}

/// The `information` that is no chance: along an edge the stack's noise alone makes evidence rise and fall by about the
/// root of all there is, `nats`.
fn certain(information: [f32; 3], nats: f32) -> [f32; 3] {
    let chance = CHANCE * (2.0 * nats.max(0.0)).sqrt();
    let (rotation, values) = eigen(information);
    turned(rotation, values.map(|value| (value * value.abs() - chance * chance).max(0.0).sqrt()))
}

/// Most likely offset, steps, of at most one step: that of the quadratic with a Gaussian prior of standard deviation
/// `prior_steps`. A direction in which the sum does not fall says nothing.
fn offset([gradient_u, gradient_v]: [f32; 2], information: [f32; 3], prior_steps: f32) -> [f32; 2] {
    let ((cos, sin), values) = eigen(information);
    let held = values.map(|nats| nats.max(0.0) + 1.0 / (prior_steps * prior_steps));
    let along = (cos * gradient_u + sin * gradient_v) / held[0];
    let across = (cos * gradient_v - sin * gradient_u) / held[1];
    let shorter = 1.0 / along.hypot(across).max(1.0);
    [shorter * (cos * along - sin * across), shorter * (sin * along + cos * across)]
}

/// Sums of `plane` over Gaussian windows of standard deviation `sigma_cells` with weight 1 in their middle. Large
/// windows are summed on fewer, larger cells.
fn window_sums(plane: &Plane, sigma_cells: f64, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let by = (sigma_cells / 4.0).floor().max(1.0) as usize;
    let mut sums = if by == 1 {
        summed(plane, sigma_cells, monitor)?
    } else {
        enlarged(&summed(&means(plane, by), sigma_cells / by as f64, monitor)?, by, plane.size())
    };
    let area = (std::f64::consts::TAU * sigma_cells * sigma_cells) as f32;
    sums.data_mut().iter_mut().for_each(|sum| *sum *= area);
    Ok(sums)
}

/// `plane` smoothed by a Gaussian of `sigma_cells`, with nothing beyond its edges: a repeated edge would count as often
/// as all it stands for.
fn summed(plane: &Plane, sigma_cells: f64, monitor: &Monitor) -> Result<Plane, Cancelled> {
    let (width, height) = plane.size();
    let margin = (3.0 * sigma_cells).ceil() as usize;
    let mut wide = Plane::zeros(width + 2 * margin, height + 2 * margin);
    (0..height).for_each(|v| wide.row_mut(v + margin)[margin..margin + width].copy_from_slice(plane.row(v)));
    let wide = smoothed(&wide, sigma_cells, monitor)?;
    let rows = (0..height).flat_map(|v| wide.row(v + margin)[margin..margin + width].iter().copied());
    Ok(Plane::from_vec(width, height, rows.collect()))
}
