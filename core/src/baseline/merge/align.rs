//! Shift of each tile of the reference frame in another frame, by a search from coarse to fine.
//!
//! # Cost
//! For a tile with the pixels r of the reference and f(d) of the other frame, shifted by d, the cost is
//!
//! ```text
//! C(d) = Σ (r − f(d))² / (4σ²) · 2P/(2P + σ²)  +  min over predictions p of |d − p|² / (2τ²)
//! ```
//!
//! The first part is minus the log-likelihood of d when both tiles show the same signal of power P (the tile's variance
//! in excess of σ²) under independent noise of variance σ². The second keeps shifts near those of the coarser level. So
//! blank tiles stay with the prediction, and well-lit corners move. A parabola through costs gives parts of a pixel.

use super::tiles::{TILE, TileGrid, first_pixel};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;
use std::ops::Range;

/// Shift in pixels, (u, v): content at x in the reference is at x + shift in the other frame.
pub(super) type Shift = [f32; 2];

/// τ of the finer levels, in their pixels: about the error of a coarser level's shift.
const PRIOR_SIGMA: f32 = 1.0;
/// τ of the coarsest level, in its pixels, around no motion.
const COARSEST_PRIOR_SIGMA: f32 = 2.0;
/// Search radius around a prediction, whole pixels.
const RADIUS: i32 = 1;
/// Search radius around no motion at the coarsest level, whole pixels.
const COARSEST_RADIUS: i32 = 4;
/// Minimum share of a tile's pixels that must lie in both frames for a comparison.
const MIN_SHARE: f32 = 0.25;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct ShiftField {
    pub grid: TileGrid,
    pub shifts: Vec<Shift>,
}

/// Shifts of the reference's tiles at full resolution, from pyramids of equal sizes; `variance` is a frame's noise.
pub(super) fn align(
    reference: &[Plane],
    frame: &[Plane],
    variance: f32,
    monitor: &Monitor,
) -> Result<ShiftField, Cancelled> {
    let mut field: Option<ShiftField> = None;
    for (level, (reference, frame)) in reference.iter().zip(frame).enumerate().rev() {
        // Halving averages four pixels: each level has a quarter of the variance of the finer one.
        let pair = FramePair { reference, frame, variance: variance * 0.25f32.powi(level as i32) };
        field = Some(align_level(&pair, field.as_ref(), monitor)?);
    }
    Ok(field.expect("a pyramid has a level"))
}

fn align_level(pair: &FramePair<'_>, coarser: Option<&ShiftField>, monitor: &Monitor) -> Result<ShiftField, Cancelled> {
    let grid = TileGrid::of(pair.reference.size());
    let rows: Vec<Vec<Shift>> = (0..grid.rows)
        .into_par_iter()
        .map(|j| {
            monitor.check()?;
            let mut predictions = Vec::new();
            Ok((0..grid.columns)
                .map(|i| {
                    predict(coarser, i, j, &mut predictions);
                    // Nothing predicts the coarsest motion: it is searched farther, with less trust in none.
                    let (radius, prior_sigma) = match coarser {
                        Some(_) => (RADIUS, PRIOR_SIGMA),
                        None => (COARSEST_RADIUS, COARSEST_PRIOR_SIGMA),
                    };
                    Tile::new(pair, i, j, &predictions, prior_sigma).best(radius)
                })
                .collect())
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(ShiftField { grid, shifts: rows.concat() })
}

/// Predictions for tile (i, j): the doubled shifts of the tiles around it on the coarser level; else no motion.
fn predict(coarser: Option<&ShiftField>, i: usize, j: usize, predictions: &mut Vec<Shift>) {
    predictions.clear();
    let Some(ShiftField { grid, shifts }) = coarser else {
        predictions.push([0.0; 2]);
        return;
    };
    // Tile centres are at i/2 in the coarser grid: between two tiles, or at one, which then comes with its neighbours.
    let around = |at: usize, count: usize| -> Range<usize> {
        let range = if at.is_multiple_of(2) { (at / 2).saturating_sub(1)..at / 2 + 2 } else { at / 2..at / 2 + 2 };
        range.start.min(count - 1)..range.end.min(count)
    };
    for j in around(j, grid.rows) {
        for i in around(i, grid.columns) {
            let shift = shifts[j * grid.columns + i].map(|x| 2.0 * x);
            // Nearly equal predictions search the same places.
            let near = |other: &Shift| (other[0] - shift[0]).hypot(other[1] - shift[1]) < 0.25;
            if !predictions.iter().any(near) {
                predictions.push(shift);
            }
        }
    }
}

struct FramePair<'a> {
    reference: &'a Plane,
    frame: &'a Plane,
    variance: f32,
}

struct Tile<'a> {
    pair: &'a FramePair<'a>,
    /// Columns and rows of its pixels inside the reference.
    columns: Range<i64>,
    rows: Range<i64>,
    predictions: &'a [Shift],
    /// Cost of a squared difference of 1.
    weight: f32,
    /// Cost of a deviation of one pixel from the prediction.
    prior: f32,
}

impl<'a> Tile<'a> {
    fn new(pair: &'a FramePair<'a>, i: usize, j: usize, predictions: &'a [Shift], prior_sigma: f32) -> Self {
        let (width, height) = pair.reference.size();
        let inside = |first: i64, size: usize| first.max(0)..(first + TILE as i64).min(size as i64);
        let (columns, rows) = (inside(first_pixel(i), width), inside(first_pixel(j), height));
        // Without signal beyond the noise the weight is 0, and the prediction alone decides.
        let power = (variance_of(pair.reference, &columns, &rows) - pair.variance).max(0.0);
        let weight = 0.5 * power / ((2.0 * power + pair.variance) * pair.variance);
        Self { pair, columns, rows, predictions, weight, prior: 0.5 / (prior_sigma * prior_sigma) }
    }

    fn best(&self, radius: i32) -> Shift {
        let mut best = ([0i32; 2], f32::INFINITY);
        let mut seen: Vec<[i32; 2]> = Vec::with_capacity(81);
        // Each prediction has its own neighbourhood, so that a border between two motions can choose either.
        for prediction in self.predictions {
            let centre = prediction.map(|x| x.round() as i32);
            for (dv, du) in (-radius..=radius).flat_map(|dv| (-radius..=radius).map(move |du| (dv, du))) {
                let shift = [centre[0] + du, centre[1] + dv];
                if seen.contains(&shift) {
                    continue;
                }
                seen.push(shift);
                let cost = self.cost(shift);
                if cost < best.1 {
                    best = (shift, cost);
                }
            }
        }
        let (shift, cost) = best;
        if cost.is_infinite() {
            // No shift near the predictions keeps enough of the tile inside the other frame.
            return self.predictions[0];
        }
        let between = |before: f32, after: f32| {
            let curvature = before + after - 2.0 * cost;
            if curvature.is_finite() && curvature > 0.0 {
                (0.5 * (before - after) / curvature).clamp(-0.5, 0.5)
            } else {
                0.0
            }
        };
        let [u, v] = shift;
        [
            u as f32 + between(self.cost([u - 1, v]), self.cost([u + 1, v])),
            v as f32 + between(self.cost([u, v - 1]), self.cost([u, v + 1])),
        ]
    }

    /// C(shift); infinite where the frames overlap too little.
    fn cost(&self, shift: [i32; 2]) -> f32 {
        let [du, dv] = shift.map(i64::from);
        let (width, height) = self.pair.frame.size();
        let both = |own: &Range<i64>, d: i64, size: usize| own.start.max(-d)..own.end.min(size as i64 - d);
        let (columns, rows) = (both(&self.columns, du, width), both(&self.rows, dv, height));
        let count = |columns: &Range<i64>, rows: &Range<i64>| {
            ((columns.end - columns.start).max(0) * (rows.end - rows.start).max(0)) as f32
        };
        let (own, common) = (count(&self.columns, &self.rows), count(&columns, &rows));
        if common < (MIN_SHARE * own).max(1.0) {
            return f32::INFINITY;
        }
        let sum = squared_difference(self.pair.reference, self.pair.frame, columns, rows, (du, dv));
        let off = |p: &Shift| (shift[0] as f32 - p[0]).powi(2) + (shift[1] as f32 - p[1]).powi(2);
        // Scaled to the whole tile: a shift must not win by comparing fewer pixels.
        let deviation = self.predictions.iter().map(off).fold(f32::INFINITY, f32::min);
        self.weight * sum * (own / common) + self.prior * deviation
    }
}

fn variance_of(plane: &Plane, columns: &Range<i64>, rows: &Range<i64>) -> f32 {
    let (mut sum, mut squares, mut count) = (0.0f64, 0.0f64, 0.0f64);
    for v in rows.clone() {
        for &x in &plane.row(v as usize)[columns.start as usize..columns.end as usize] {
            let x = f64::from(x);
            (sum, squares, count) = (sum + x, squares + x * x, count + 1.0);
        }
    }
    if count < 2.0 { 0.0 } else { ((squares - sum * sum / count) / (count - 1.0)).max(0.0) as f32 }
}

/// Σ (reference(x) − frame(x + shift))² over a rectangle of at most [`TILE`] columns inside both.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn squared_difference(
    reference: &Plane,
    frame: &Plane,
    columns: Range<i64>,
    rows: Range<i64>,
    (du, dv): (i64, i64),
) -> f32 {
    let mut sums = [0.0f32; TILE];
    let (from, to) = (columns.start as usize, columns.end as usize);
    let (from_there, to_there) = ((columns.start + du) as usize, (columns.end + du) as usize);
    for v in rows {
        let (a, b) = (&reference.row(v as usize)[from..to], &frame.row((v + dv) as usize)[from_there..to_there]);
        // Whole tiles have a fixed width, which the compiler turns into vectors.
        if let (Ok(a), Ok(b)) = (<&[f32; TILE]>::try_from(a), <&[f32; TILE]>::try_from(b)) {
            for k in 0..TILE {
                let d = a[k] - b[k];
                sums[k] = d.mul_add(d, sums[k]);
            }
        } else {
            for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
                let d = a - b;
                *sum = d.mul_add(d, *sum);
            }
        }
    }
    sums.iter().sum()
}

/// Maximum number of levels, with the image itself: enough to follow motion of up to about 100 pixels.
const MAX_LEVELS: usize = 5;

/// Image and coarser copies, finest first, none smaller than a tile.
pub(super) fn pyramid(image: &Plane) -> Vec<Plane> {
    let coarser = |finer: &Plane| (finer.width().min(finer.height()) >= 2 * TILE).then(|| finer.halved());
    std::iter::successors(Some(image.clone()), coarser).take(MAX_LEVELS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_halve_until_a_tile_is_all_there_is() {
        let sizes = |width, height| pyramid(&Plane::zeros(width, height)).iter().map(Plane::size).collect::<Vec<_>>();
        assert_eq!(sizes(100, 65), [(100, 65), (50, 32), (25, 16)]);
        assert_eq!(sizes(3, 1), [(3, 1)]);
        assert_eq!(sizes(4000, 3000).len(), MAX_LEVELS);
    }
}
