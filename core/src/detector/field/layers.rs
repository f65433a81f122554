//! Motion layers: the motions that exist in a burst.
//!
//! The motions of all known cells are counted on a fine grid of slopes. Each hill of the smoothed count is a layer; two
//! hills are one unless the saddle between them is lower than half of the lower one: a floor that comes nearer is one
//! layer with a spread, and two things before one another are two.
//!
//! Layers come in the order of depth, which all motions together determine ([`super::depth`]); own motions come last.

use super::depth::inverse_depths;
use crate::detector::params::slope_grid::Slope;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::{Plane, blur::smoothed, statistics::upper_median};
use serde::Serialize;

/// Smear between the first and the last frame that a step of the grid stands for, pixels.
const STEP_SMEAR_PX: f32 = 0.5;
/// Standard deviation by which the count is smoothed, steps.
const SMOOTHING_STEPS: f64 = 2.0;
const MARGIN_STEPS: usize = 7;
const MAX_STEPS: f32 = 400.0;
/// Height of a saddle, as a part of the lower hill, from which the two hills are one.
const ONE_HILL: f32 = 0.5;
/// Share of the known cells that a layer needs.
const MIN_SHARE: f32 = 0.004;

/// A motion that exists in a burst.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MotionLayer {
    /// Mean motion of its cells, pixels per frame.
    pub slope: Slope,
    /// Standard deviation of the cells' motions (root mean variance of both directions), pixels per frame.
    pub spread: f32,
    /// Part (0 … 1) of the cells with known motion that belong to the layer.
    pub share: f32,
    /// Inverse depth relative to the nearest layer; negative for opposite motion, `None` for motion of its own.
    pub inverse_depth: Option<f32>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct KnownCell {
    pub pos_image: [f64; 2],
    /// Motion, pixels per frame, and its largest standard deviation.
    pub motion: (Slope, f32),
}

/// Layers of the motions of all cells (`None` where unknown), nearest first, then those that move by themselves,
/// fastest first; and the number of each cell's layer, from 1, or 0. `last_frame` is the number of frames less one.
pub(super) fn layers(
    known: &[Option<KnownCell>],
    last_frame: f32,
    monitor: &Monitor,
) -> Result<(Vec<MotionLayer>, Vec<u8>), Cancelled> {
    let cells: Vec<KnownCell> = known.iter().flatten().copied().collect();
    let slopes: Vec<Slope> = cells.iter().map(|cell| cell.motion.0).collect();
    let Some(hills) = Hills::new(&slopes, STEP_SMEAR_PX / last_frame, monitor)? else {
        return Ok((Vec::new(), vec![0; known.len()]));
    };
    let hill_of = |slope: &Slope| hills.of_bin[hills.bin(*slope)];
    let mut sums = vec![[0.0f64; 5]; hills.of_bin.len()];
    for slope in &slopes {
        let (u, v) = (f64::from(slope.u), f64::from(slope.v));
        sums[hill_of(slope)].iter_mut().zip([1.0, u, v, u * u, v * v]).for_each(|(sum, x)| *sum += x);
    }
    // Smaller hills are cells at borders, which show two motions at once.
    let enough = f64::from(MIN_SHARE) * slopes.len() as f64;
    let mut found: Vec<(usize, MotionLayer)> = Vec::new();
    for (hill, [count, u, v, uu, vv]) in sums.iter().copied().enumerate().filter(|(_, sums)| sums[0] > enough) {
        let (u, v) = (u / count, v / count);
        let variance = 0.5 * (uu / count - u * u + vv / count - v * v);
        let spread = variance.max(0.0).sqrt() as f32;
        let share = (count / slopes.len() as f64) as f32;
        found.push((hill, MotionLayer { slope: Slope::new(u as f32, v as f32), spread, share, inverse_depth: None }));
    }
    let places: Vec<[f64; 2]> = cells.iter().map(|cell| cell.pos_image).collect();
    let motions: Vec<(Slope, f32)> = cells.iter().map(|cell| cell.motion).collect();
    let depths = inverse_depths(&places, &motions);
    let of_cells: Vec<(usize, Option<f32>)> =
        slopes.iter().map(hill_of).zip(depths.iter().map(|depth| depth.map(|depth| depth.value as f32))).collect();
    for (hill, layer) in &mut found {
        layer.inverse_depth = middle_depth(of_cells.iter().filter(|(of, _)| of == hill).map(|(_, depth)| *depth));
    }
    // Numbers come after the order: a cell's number is the place of its layer.
    order(&mut found);
    let number = |cell: &KnownCell| {
        found.iter().position(|(hill, _)| *hill == hill_of(&cell.motion.0)).map_or(0, |at| at as u8 + 1)
    };
    let of_cells = known.iter().map(|cell| cell.as_ref().map_or(0, number)).collect();
    Ok((found.into_iter().map(|(_, layer)| layer).collect(), of_cells))
}

/// Median of the inverse depths of a layer's cells; `None` where fewer than half of them have one.
fn middle_depth(depths: impl Iterator<Item = Option<f32>>) -> Option<f32> {
    let all: Vec<Option<f32>> = depths.collect();
    let known: Vec<f32> = all.iter().flatten().copied().collect();
    if 2 * known.len() > all.len() { upper_median(known) } else { None }
}

/// Orders layers and makes inverse depths relative to the first, with the sign that puts the fastest first.
fn order(found: &mut Vec<(usize, MotionLayer)>) {
    let depths = found.iter().filter_map(|(_, layer)| layer.inverse_depth);
    let largest = depths.reduce(|a, b| if b.abs() > a.abs() { b } else { a }).filter(|depth| *depth != 0.0);
    for (_, layer) in found.iter_mut() {
        layer.inverse_depth = layer.inverse_depth.zip(largest).map(|(depth, largest)| depth / largest);
    }
    let key = |layer: &MotionLayer| (layer.inverse_depth.unwrap_or(f32::NEG_INFINITY), layer.slope.magnitude());
    found.sort_by(|(a, one), (b, other)| {
        let (one, other) = (key(one), key(other));
        other.0.total_cmp(&one.0).then(other.1.total_cmp(&one.1)).then(a.cmp(b))
    });
    // A cell keeps the number of its layer in a byte; the last ones are given up.
    found.truncate(usize::from(u8::MAX));
}

struct Hills {
    first: Slope,
    step: f32,
    width: usize,
    /// Bin at the top of each bin's hill.
    of_bin: Vec<usize>,
}

impl Hills {
    fn new(slopes: &[Slope], step: f32, monitor: &Monitor) -> Result<Option<Self>, Cancelled> {
        let ends = |of: fn(&Slope) -> f32| {
            let both = |(min, max): (f32, f32), x: f32| (min.min(x), max.max(x));
            slopes.iter().map(of).fold((f32::INFINITY, f32::NEG_INFINITY), both)
        };
        let (u, v) = (ends(|slope| slope.u), ends(|slope| slope.v));
        if slopes.is_empty() {
            return Ok(None);
        }
        // A wide range of motions gets a coarser grid, so that memory stays bounded.
        let step = step.max((u.1 - u.0).max(v.1 - v.0) / MAX_STEPS);
        let count = |(min, max): (f32, f32)| ((max - min) / step).ceil() as usize + 1 + 2 * MARGIN_STEPS;
        let first = Slope::new(u.0 - MARGIN_STEPS as f32 * step, v.0 - MARGIN_STEPS as f32 * step);
        let mut hills = Self { first, step, width: count(u), of_bin: Vec::new() };
        let mut counts = Plane::zeros(count(u), count(v));
        slopes.iter().for_each(|&slope| counts.data_mut()[hills.bin(slope)] += 1.0);
        let counts = smoothed(&counts, SMOOTHING_STEPS, monitor)?;
        hills.of_bin = hills.climbed(counts.data());
        hills.join(counts.data());
        Ok(Some(hills))
    }

    fn bin(&self, slope: Slope) -> usize {
        let along = |x: f32, first: f32| ((x - first) / self.step).round() as usize;
        along(slope.v, self.first.v) * self.width + along(slope.u, self.first.u)
    }

    fn around(&self, bin: usize, count: usize) -> impl Iterator<Item = usize> {
        let (i, j, width) = ((bin % self.width) as i64, (bin / self.width) as i64, self.width as i64);
        let inside = move |(di, dj): (i64, i64)| {
            let (i, j) = (i + di, j + dj);
            ((0..width).contains(&i) && (0..count as i64 / width).contains(&j)).then_some((j * width + i) as usize)
        };
        (-1..=1).flat_map(|dj| (-1..=1).map(move |di| (di, dj))).filter_map(inside)
    }

    /// Top above each bin, by steepest ascent.
    fn climbed(&self, counts: &[f32]) -> Vec<usize> {
        // Ties go to the first bin, or a plateau would lead round in a circle.
        let higher = |a: usize, b: usize| if (counts[b], a) > (counts[a], b) { b } else { a };
        let next: Vec<usize> =
            (0..counts.len()).map(|bin| self.around(bin, counts.len()).reduce(higher).unwrap_or(bin)).collect();
        let top = |mut bin: usize| {
            while next[bin] != bin {
                bin = next[bin];
            }
            bin
        };
        (0..counts.len()).map(top).collect()
    }

    /// Joins hills with high saddles between them, the highest saddle first.
    fn join(&mut self, counts: &[f32]) {
        let mut saddles: Vec<(f32, usize, usize)> = Vec::new();
        for bin in 0..counts.len() {
            for other in self.around(bin, counts.len()).filter(|other| self.of_bin[*other] < self.of_bin[bin]) {
                saddles.push((counts[bin].min(counts[other]), self.of_bin[bin], self.of_bin[other]));
            }
        }
        // Equal saddles go by their hills, so that the result has one order.
        saddles.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut joined: Vec<usize> = (0..counts.len()).collect();
        for (height, one, other) in saddles {
            let (one, other) = (root(&joined, one), root(&joined, other));
            let (low, high) = if counts[one] < counts[other] { (one, other) } else { (other, one) };
            // The peak of the lower hill rises little above the saddle: a bump of the higher one.
            if low != high && height > ONE_HILL * counts[low] {
                joined[low] = high;
            }
        }
        self.of_bin.iter_mut().for_each(|top| *top = root(&joined, *top));
    }
}

fn root(joined: &[usize], mut top: usize) -> usize {
    while joined[top] != top {
        top = joined[top];
    }
    top
}
