//! Evidence on the slopes of a burst, from windows of all places and sizes, and the grid that is chosen from it.
//!
//! Each level is covered by half-overlapping windows; their correlations are also summed, over a sixteenth of the
//! image, a quarter, the whole. Small windows separate depths and small layers; large ones show faint structures. A
//! window counts when it is significant, determines its slope, is not ambiguous, and is certain by itself or confirmed
//! by another. If those that count lie on a line through slope 0, the grid is this line, otherwise a plane, turned if
//! that makes it much smaller. Its slopes are multiples of the step and end one to two steps beyond the evidence, so
//! that grids of a burst and of a part of it share points.

use super::lags::Lags;
use super::peak::{SearchTable, Track};
use super::spectra::{CrossSpectra, Fourier, SIDE, Scratch, Sum};
use crate::detector::params::{Slope, SlopeAxis, SlopeGrid};
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Evidence of one window, or of the sum of several, on the slope there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlopeEvidence {
    /// Slope at which the motion stack has the most power, pixels per frame.
    pub slope: Slope,
    /// Power at that slope over its standard deviation if the frames had nothing in common.
    pub significance: f32,
    /// Possible error of the slope, pixels per frame, in the direction in which it is least certain (along an edge).
    pub uncertainty: f32,
    /// Power at the strongest other slope divided by that at this one: near 1 on periodic texture.
    pub ambiguity: f32,
    /// Level of the pyramid: pixels of 2^level image pixels.
    pub level: u32,
    /// Centre of the window, image pixels.
    pub centre: [f32; 2],
    /// Size (columns, rows) of the window, image pixels.
    pub size: [f32; 2],
}

pub(super) struct Seen {
    /// Evidence of every window that has any signal.
    pub evidence: Vec<SlopeEvidence>,
    /// For each level, the products summed over the whole image.
    pub wholes: Vec<Sum>,
    /// For each level, the products and the evidence of the blocks with any signal.
    pub blocks: Vec<Vec<(Sum, SlopeEvidence)>>,
}

/// Number of blocks along each axis in which windows are summed first.
const BLOCKS: usize = 4;
/// Variance of a sum of half-overlapping windows, which share noise, divided by the sum of their variances.
pub(super) const SHARED_NOISE: f64 = 1.37;

pub(super) struct Looking<'a> {
    pub fourier: &'a Fourier,
    pub table: &'a SearchTable,
    pub lags: &'a Lags,
    pub levels: &'a [Vec<Plane>],
    pub first_level: u32,
    /// Number of lags, from 1 on, at which frames share noise and which do not count.
    pub ignored_lags: usize,
}

pub(super) fn look(
    (levels, lags): (&[Vec<Plane>], &Lags),
    (first_level, ignored_lags): (u32, usize),
    track: Track,
    fourier: &Fourier,
    monitor: &Monitor,
) -> Result<(Seen, SearchTable), Cancelled> {
    let table = SearchTable::new(&lags.distances, track, &fourier.overlap);
    let seen = Looking { fourier, table: &table, lags, levels, first_level, ignored_lags }.all(monitor)?;
    Ok((seen, table))
}

impl Looking<'_> {
    fn all(&self, monitor: &Monitor) -> Result<Seen, Cancelled> {
        let jobs: Vec<(usize, usize)> =
            (0..self.levels.len()).flat_map(|level| (0..BLOCKS * BLOCKS).map(move |block| (level, block))).collect();
        let done = AtomicUsize::new(0);
        let blocks: Vec<(Vec<SlopeEvidence>, Sum)> = jobs
            .par_iter()
            .map(|&(level, block)| {
                let answer = self.block(level, block, monitor)?;
                let fraction = done.fetch_add(1, Ordering::Relaxed) as f32 / jobs.len() as f32;
                monitor.report(Stage::Slopes, fraction);
                Ok(answer)
            })
            .collect::<Result<_, Cancelled>>()?;
        // The blocks come level by level: one pass sums them to quarters and to the whole.
        let mut seen = Seen { evidence: Vec::new(), wholes: Vec::new(), blocks: Vec::new() };
        let mut blocks = blocks.into_iter();
        for level in 0..self.levels.len() {
            monitor.check()?;
            let mut shown = Vec::new();
            let mut scratch = self.fourier.scratch(self.levels[level].len());
            let mut whole = Sum::new(self.lags);
            let mut quarters: Vec<Sum> = (0..4).map(|_| Sum::new(self.lags)).collect();
            for (block, (evidence, sum)) in blocks.by_ref().take(BLOCKS * BLOCKS).enumerate() {
                seen.evidence.extend(&evidence);
                quarters[block / BLOCKS / 2 * 2 + block % BLOCKS / 2].add(&sum);
                // A sum shows fainter structure than its windows, which separate depths: both are evidence.
                let of_sum = self.of_sum(level, &sum, &mut scratch);
                seen.evidence.extend(of_sum);
                // A block of one window has no sum; the window's evidence stands for it.
                shown.extend(of_sum.or(evidence.last().copied()).map(|evidence| (sum, evidence)));
            }
            for quarter in &quarters {
                whole.add(quarter);
                seen.evidence.extend(self.of_sum(level, quarter, &mut scratch));
            }
            seen.evidence.extend(self.of_sum(level, &whole, &mut scratch));
            seen.wholes.push(whole);
            seen.blocks.push(shown);
        }
        Ok(seen)
    }

    fn block(&self, level: usize, block: usize, monitor: &Monitor) -> Result<(Vec<SlopeEvidence>, Sum), Cancelled> {
        let frames = &self.levels[level];
        let (width, height) = frames[0].size();
        // A window belongs to the block that holds its centre.
        let belongs = |start: usize, length: usize, part: usize| (2 * start + SIDE) * BLOCKS / (2 * length) == part;
        let mut scratch = self.fourier.scratch(frames.len());
        let (mut evidence, mut sum) = (Vec::new(), Sum::new(self.lags));
        for v in starts(height).into_iter().filter(|v| belongs(*v, height, block / BLOCKS)) {
            for u in starts(width).into_iter().filter(|u| belongs(*u, width, block % BLOCKS)) {
                monitor.check()?;
                let mut products = self.fourier.products(frames, self.lags, (u, v), &mut scratch);
                products.forget_lags(self.ignored_lags);
                let area = [u..u + SIDE, v..v + SIDE];
                evidence.extend(self.evidence(level, &products, 1.0, &area, &mut scratch));
                sum.lags.add(&products);
                self.fourier.add_pairs(&mut sum.pairs, self.lags, &scratch);
                sum.widen(area, 1);
            }
        }
        Ok((evidence, sum))
    }

    fn of_sum(&self, level: usize, sum: &Sum, scratch: &mut Scratch) -> Option<SlopeEvidence> {
        let is_of_several = sum.windows > 1;
        is_of_several.then(|| self.evidence(level, &sum.lags, SHARED_NOISE, &sum.area, scratch))?
    }

    fn evidence(
        &self,
        level: usize,
        products: &CrossSpectra,
        more_variance: f64,
        [columns, rows]: &[Range<usize>; 2],
        scratch: &mut Scratch,
    ) -> Option<SlopeEvidence> {
        // What a codec leaves of noise is rare and alike: two frames that share it would show any motion.
        let pairs = self.lags.by_lag.iter().map(Vec::len).sum::<usize>() as f64;
        if products.pairs_behind() < PAIRS_BEHIND.min(pairs * SHARE_BEHIND) {
            return None;
        }
        let planes = self.fourier.correlations(&products.products, scratch);
        let variance: Vec<f64> = products.variance.iter().map(|v| v * more_variance).collect();
        let peak = self.table.strongest(&planes, &variance)?;
        let level = self.first_level + level as u32;
        let unit = f64::from(1u32 << level);
        // The centre of the first image pixel is 0, so its edge is at −0.5.
        let centre = |r: &Range<usize>| (0.5 * (r.start + r.end) as f64 * unit - 0.5) as f32;
        let length = |r: &Range<usize>| (r.len() as f64 * unit) as f32;
        let slope = Slope::new((peak.slope[0] * unit) as f32, (peak.slope[1] * unit) as f32);
        let (significance, ambiguity) = (peak.significance as f32, peak.ambiguity as f32);
        let uncertainty = (peak.uncertainty * unit) as f32;
        let (centre, size) = ([centre(columns), centre(rows)], [length(columns), length(rows)]);
        Some(SlopeEvidence { slope, significance, uncertainty, ambiguity, level, centre, size })
    }
}

fn starts(length: usize) -> Vec<usize> {
    let room = length.saturating_sub(SIDE);
    let steps = room.div_ceil(SIDE / 2);
    (0..=steps).map(|i| (i * room).checked_div(steps).unwrap_or(0)).collect()
}

/// Least number of pairs of frames that evidence has to come from, and, of few frames, least part of their pairs.
const PAIRS_BEHIND: f64 = 6.0;
const SHARE_BEHIND: f64 = 0.5;
const LARGE_SIGNIFICANCE: f32 = 6.5;
/// Additional significance for a window of the smallest size to count: the largest of 28 bursts of pure noise had 9.8.
const SMALL_SIGNIFICANCE: f32 = 5.0;
const MAX_AMBIGUITY: f32 = 0.85;
/// Uncertainty up to which one of the smallest windows counts, in steps that smear the finest features.
const SMALL_UNCERTAINTY: f64 = 0.8;
/// Uncertainty up to which a larger window counts, in such steps; noise matters less there.
const LARGE_UNCERTAINTY: f64 = 1.2;
/// Significance from which on, and ambiguity up to which, a window is certain by itself.
const SURE_SIGNIFICANCE: f32 = 13.0;
const SURE_AMBIGUITY: f32 = 0.6;
/// Minimum number of windows beside a line that make the grid a plane.
const MIN_BESIDE: usize = 3;
/// Maximum number of slopes on a line, unless the step would exceed [`COARSEST`] times the right one.
pub(super) const LINE_SLOPES: usize = 27;
/// Maximum number of slopes along each axis of a plane, with that exception.
pub(super) const PLANE_SLOPES: usize = 11;
const COARSEST: f64 = 2.0;
/// Steps to choose from, as multiples of the right one: few, so that the choice rarely changes.
const COARSER: [f64; 4] = [1.0, 4.0 / 3.0, 5.0 / 3.0, COARSEST];
/// Angle from an axis below which a direction is taken as the axis: whole pixels are searched faster.
const SNAP_DEG: f64 = 5.0;
/// Multiples, in degrees, to which a direction is rounded, as coarsely as the evidence allows.
const ROUND_DEG: [f64; 3] = [15.0, 5.0, 1.0];
/// Multiples, in degrees, to which the direction of a turned plane is rounded.
const TURNED_DEG: f64 = 15.0;
/// Area that a turned plane may have at most, as a part of that of the plane along u and v.
const MUCH_SMALLER: f64 = 0.6;

/// Steps that define near and far slopes, pixels per frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    pub search: f64,
    /// Step that smears the outermost frames by 1.9 px: evidence of slopes within it is of one slope.
    pub same: f64,
}

pub(super) fn is_significant(evidence: &SlopeEvidence) -> bool {
    evidence.significance >= least_significance(evidence)
}

/// Lowest significance at which a window as large as that of `evidence` counts.
pub(super) fn least_significance(evidence: &SlopeEvidence) -> f32 {
    LARGE_SIGNIFICANCE + SMALL_SIGNIFICANCE / side_in_smallest(evidence)
}

/// Side of a square as large as the window, in sides of the smallest window at its level.
fn side_in_smallest(evidence: &SlopeEvidence) -> f32 {
    (evidence.size[0] * evidence.size[1]).sqrt() / (SIDE << evidence.level) as f32
}

pub(super) fn is_clear(evidence: &SlopeEvidence, steps: Steps) -> bool {
    let limit = if side_in_smallest(evidence) > 1.2 { LARGE_UNCERTAINTY } else { SMALL_UNCERTAINTY };
    is_significant(evidence)
        && f64::from(evidence.uncertainty) <= limit * steps.same
        && evidence.ambiguity < MAX_AMBIGUITY
}

/// Members of `evidence` that are certain by themselves or confirmed by another one.
pub(super) fn confirmed(evidence: &[SlopeEvidence], steps: Steps) -> Vec<SlopeEvidence> {
    let is_sure = |e: &SlopeEvidence| e.significance >= SURE_SIGNIFICANCE && e.ambiguity <= SURE_AMBIGUITY;
    let confirms = |a: &SlopeEvidence, b: &SlopeEvidence| {
        let distance = (a.slope.u - b.slope.u).hypot(a.slope.v - b.slope.v);
        f64::from(distance) <= 0.5 * steps.same
    };
    let counts = |i: &usize| {
        let one = &evidence[*i];
        is_sure(one) || evidence.iter().enumerate().any(|(j, other)| j != *i && confirms(one, other))
    };
    (0..evidence.len()).filter(counts).map(|i| evidence[i]).collect()
}

/// Grid for confirmed evidence; `line_deg` is a direction that the user gave. `None` without evidence.
pub(super) fn grid_for(evidence: &[SlopeEvidence], steps: Steps, line_deg: Option<f32>) -> Option<SlopeGrid> {
    if evidence.is_empty() {
        return None;
    }
    let line = line_deg.map(f64::from).or_else(|| line_through(evidence, steps));
    if let Some(degrees) = line {
        let (range, _) = ranges(evidence, degrees);
        let u = axis(range, steps.search, LINE_SLOPES);
        return Some(SlopeGrid { u, v: SlopeAxis::ZERO, direction_deg: degrees as f32 });
    }
    let plane = |degrees: f64| {
        let (along, across) = ranges(evidence, degrees);
        let [u, v] = [along, across].map(|range| axis(range, steps.search, PLANE_SLOPES));
        SlopeGrid { u, v, direction_deg: degrees as f32 }
    };
    // About the mean, not about slope 0: unlike a line, a plane need not pass through 0.
    let mean = |axis: fn(&Slope) -> f32| {
        evidence.iter().map(|e| f64::from(axis(&e.slope))).sum::<f64>() / evidence.len() as f64
    };
    let spread_deg = principal_deg(evidence, [mean(|s| s.u), mean(|s| s.v)]);
    let (straight, turned) = (plane(0.0), plane((spread_deg / TURNED_DEG).round() * TURNED_DEG));
    let area = |grid: &SlopeGrid| f64::from(grid.u.max - grid.u.min) * f64::from(grid.v.max - grid.v.min);
    Some(if area(&turned) <= MUCH_SMALLER * area(&straight) { turned } else { straight })
}

/// Direction, in degrees, of the line through slope 0 on which the evidence lies; `None` where it does not.
fn line_through(evidence: &[SlopeEvidence], steps: Steps) -> Option<f64> {
    let degrees = direction_deg(evidence);
    let near = |axis: f64| {
        let off = (degrees - axis).rem_euclid(180.0);
        off.min(180.0 - off) <= SNAP_DEG
    };
    let snapped = [0.0, 90.0].into_iter().filter(|a| near(*a));
    let rounded = ROUND_DEG.map(|round| (degrees / round).round() * round);
    // Axes first, then ever finer roundings, until the evidence lies on the line.
    snapped.chain(rounded).find(|d| off_line(evidence, *d, steps).len() < MIN_BESIDE)
}

/// Confirmed evidence for slopes that are not on the line through 0 in direction `degrees`.
fn off_line(evidence: &[SlopeEvidence], degrees: f64, steps: Steps) -> Vec<SlopeEvidence> {
    // The less certain a slope, the farther it must lie from the line to speak against it.
    let is_off =
        |e: &&SlopeEvidence| turned(e.slope, degrees)[1].abs() > (0.5 * steps.same).max(2.0 * f64::from(e.uncertainty));
    let off: Vec<SlopeEvidence> = evidence.iter().filter(is_off).copied().collect();
    confirmed(&off, steps)
}

/// Direction, degrees from +u towards +v, −180 … 180, of the line through slope 0 that fits the evidence best.
pub(super) fn direction_deg(evidence: &[SlopeEvidence]) -> f64 {
    let degrees = principal_deg(evidence, [0.0, 0.0]);
    let forward: f64 = evidence.iter().map(|e| f64::from(e.significance) * turned(e.slope, degrees)[0]).sum();
    match degrees {
        d if forward >= 0.0 => d,
        d if d > 0.0 => d - 180.0,
        d => d + 180.0,
    }
}

/// Principal direction of the evidence about `centre`, −90 … 90°.
fn principal_deg(evidence: &[SlopeEvidence], centre: [f64; 2]) -> f64 {
    let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
    for e in evidence {
        let (u, v, w) = (f64::from(e.slope.u) - centre[0], f64::from(e.slope.v) - centre[1], f64::from(e.significance));
        (uu, uv, vv) = (uu + w * u * u, uv + w * u * v, vv + w * v * v);
    }
    (0.5 * (2.0 * uv).atan2(uu - vv)).to_degrees()
}

/// Components of a slope along and across a direction.
pub(super) fn turned(slope: Slope, degrees: f64) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (u, v) = (f64::from(slope.u), f64::from(slope.v));
    [u * cos + v * sin, v * cos - u * sin]
}

pub(super) fn ranges(evidence: &[SlopeEvidence], degrees: f64) -> ([f64; 2], [f64; 2]) {
    let mut out = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for e in evidence {
        out.iter_mut().zip(turned(e.slope, degrees)).for_each(|(range, x)| *range = [range[0].min(x), range[1].max(x)]);
    }
    (out[0], out[1])
}

pub(super) fn count([min, max]: [f64; 2], step: f64, slopes: usize) -> usize {
    // A range hardly longer than a multiple of the step needs no slope more.
    let with_step = |step: f64| ((max - min) / step - 0.05).ceil().max(2.0) as usize + 1;
    with_step(step).min(slopes.max(with_step(COARSEST * step)))
}

/// Axis of slopes at multiples of the step, which end one to two steps beyond `range`.
pub(super) fn axis([min, max]: [f64; 2], step: f64, slopes: usize) -> SlopeAxis {
    // Multiples of a rounded step: the grids of a burst and of a part of it share their points.
    let of = |coarser: f64| {
        let step = readable(coarser * step);
        ((min / step + ON_A_POINT).floor() - 1.0, (max / step - ON_A_POINT).ceil() + 1.0, step)
    };
    let count = |(first, last, _): (f64, f64, f64)| (last - first) as usize + 1;
    let fits = |coarser: &&f64| count(of(**coarser)) <= slopes;
    let ends = of(*COARSER.iter().find(fits).unwrap_or(&COARSEST));
    let (first, last, step) = ends;
    SlopeAxis { min: (first * step) as f32, max: (last * step) as f32, count: count(ends) }
}

/// Distance beyond a point of the grid, in steps, up to which a slope lies on it.
const ON_A_POINT: f64 = 0.05;

/// Largest number that is not above `step` and has two digits, or is a multiple of a hundredth.
fn readable(step: f64) -> f64 {
    let digit = 10f64.powf(step.log10().floor() - 1.0).min(0.01);
    // A step that has two digits already stays as it is.
    (step / digit + 1e-6).floor() * digit
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    #[test]
    fn windows_cover_a_line_from_end_to_end() {
        for length in [32, 33, 47, 48, 60, 64, 101, 400] {
            let starts = starts(length);
            assert_eq!((starts[0], starts.last().map(|s| s + SIDE)), (0, Some(length)), "{length}");
            assert!(starts.windows(2).all(|w| w[1] > w[0] && w[1] - w[0] <= SIDE / 2), "{length}: {starts:?}");
        }
    }

    const STEPS: Steps = Steps { search: 0.4, same: 0.4 };

    /// Evidence of a small window at level 1 that is clear, but not certain by itself.
    pub fn window(slope: Slope, centre: [f32; 2]) -> SlopeEvidence {
        let (significance, uncertainty, ambiguity, size) = (12.0, 0.05, 0.3, [64.0, 64.0]);
        SlopeEvidence { slope, significance, uncertainty, ambiguity, level: 1, centre, size }
    }

    fn seen(slopes: &[(f32, f32)]) -> Vec<SlopeEvidence> {
        slopes.iter().flat_map(|&(u, v)| [window(Slope::new(u, v), [0.0, 0.0]); 3]).collect()
    }

    #[test]
    fn several_directions_are_a_plane_which_is_turned_if_that_helps() {
        let grid = grid_for(&seen(&[(1.6, -1.2), (-2.1, 0.0), (0.95, 0.0)]), STEPS, None).expect("evidence");
        assert!(grid.is_plane() && grid.direction_deg == 0.0, "{grid:?}");
        assert!((grid.v.min + 1.6).abs() < 1e-5 && (grid.v.max - 0.4).abs() < 1e-5, "{grid:?}");
        assert!(grid.u.count <= 11 && grid.v.count <= 11);
        let slanted = seen(&[(3.0, 3.5), (-2.0, -1.5), (0.5, 1.0), (1.8, 2.3)]);
        let grid = grid_for(&slanted, STEPS, None).expect("evidence");
        assert!(grid.is_plane() && (grid.direction_deg - 45.0).abs() < 3.0, "{grid:?}");
        for e in &slanted {
            let [along, across] = turned(e.slope, f64::from(grid.direction_deg)).map(|x| x as f32);
            assert!((grid.u.min..=grid.u.max).contains(&along) && (grid.v.min..=grid.v.max).contains(&across));
        }
    }

    #[test]
    fn one_window_alone_widens_nothing() {
        let mut evidence = seen(&[(2.0, 0.0), (2.2, 0.0)]);
        evidence.push(SlopeEvidence { slope: Slope::new(-7.0, 3.0), ..evidence[0] });
        assert_eq!(confirmed(&evidence, STEPS).len(), 6);
    }

    #[test]
    fn long_ranges_have_a_coarser_step_but_not_any() {
        let line = grid_for(&seen(&[(-6.0, 0.0), (6.0, 0.0)]), STEPS, None).expect("evidence");
        assert!(line.u.count <= 27 && line.u.step() < 0.6, "{line:?}");
        let long = grid_for(&seen(&[(-20.0, 0.0), (20.0, 0.0)]), STEPS, None).expect("evidence");
        assert!(long.u.step() <= 0.8 + 1e-6 && long.u.count > 25, "{long:?}");
    }
}
