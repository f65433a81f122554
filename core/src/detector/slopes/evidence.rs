//! Evidence on the slopes of a burst, from windows of all places and sizes.
//!
//! Each level is covered by half-overlapping windows. Correlations of windows can be summed: over a sixteenth of the
//! image, a quarter, the whole. Small windows separate several depths and small layers; large ones show structures that
//! are too faint for a small one.

use super::peak::{Peak, SearchTable, Track};
use super::spectra::{CrossSpectra, Fourier, SIDE, Scratch};
use crate::detector::params::slope_grid::Slope;
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
    /// Power at that slope, without each frame's own, divided by its standard deviation if the frames had nothing in
    /// common.
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

/// Evidence of all levels.
pub(super) struct Seen {
    /// Evidence of every window that has any signal.
    pub evidence: Vec<SlopeEvidence>,
    /// For each level, the products summed over the whole image.
    pub wholes: Vec<CrossSpectra>,
}

/// Number of blocks along each axis in which windows are summed first.
const BLOCKS: usize = 4;
/// Variance of a sum of half-overlapping windows, which share noise, divided by the sum of their variances.
const SHARED_NOISE: f64 = 1.37;

/// Data shared by the work on all windows.
pub(super) struct Looking<'a> {
    pub fourier: &'a Fourier,
    pub table: &'a SearchTable,
    /// Frames at each level, the finest first.
    pub levels: &'a [Vec<Plane>],
    /// Level of the first of them.
    pub first_level: u32,
}

/// Collects the evidence of every window at every level.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub(super) fn look(
    frames: &[&Plane],
    levels: Range<u32>,
    track: Track,
    fourier: &Fourier,
    monitor: &Monitor,
) -> Result<(Seen, SearchTable), Cancelled> {
    let lag_count = CrossSpectra::zeros(frames.len()).lags.len();
    let table = SearchTable::new(lag_count, track, &fourier.overlap);
    let first_level = levels.start;
    let pyramids = super::pyramid::pyramids(frames, levels, monitor)?;
    let looking = Looking { fourier, table: &table, levels: &pyramids, first_level };
    let seen = looking.all(monitor)?;
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
        let mut seen = Seen { evidence: Vec::new(), wholes: Vec::new() };
        for (level, blocks) in blocks.chunks(BLOCKS * BLOCKS).enumerate() {
            monitor.check()?;
            let frame_count = self.levels[level].len();
            let mut scratch = self.fourier.scratch(frame_count);
            let mut whole = Sum::new(frame_count);
            let mut quarters: Vec<Sum> = (0..4).map(|_| Sum::new(frame_count)).collect();
            for (block, (evidence, sum)) in blocks.iter().enumerate() {
                seen.evidence.extend(evidence);
                quarters[block / BLOCKS / 2 * 2 + block % BLOCKS / 2].add(sum);
                seen.evidence.extend(self.of_sum(level, sum, &mut scratch));
            }
            for quarter in &quarters {
                whole.add(quarter);
                seen.evidence.extend(self.of_sum(level, quarter, &mut scratch));
            }
            seen.evidence.extend(self.of_sum(level, &whole, &mut scratch));
            seen.wholes.push(whole.products);
        }
        Ok(seen)
    }

    /// Evidence of each window of one block, and their sum.
    fn block(&self, level: usize, block: usize, monitor: &Monitor) -> Result<(Vec<SlopeEvidence>, Sum), Cancelled> {
        let frames = &self.levels[level];
        let (width, height) = frames[0].size();
        let belongs = |start: usize, length: usize, part: usize| (2 * start + SIDE) * BLOCKS / (2 * length) == part;
        let mut scratch = self.fourier.scratch(frames.len());
        let (mut evidence, mut sum) = (Vec::new(), Sum::new(frames.len()));
        for v in starts(height).into_iter().filter(|v| belongs(*v, height, block / BLOCKS)) {
            for u in starts(width).into_iter().filter(|u| belongs(*u, width, block % BLOCKS)) {
                monitor.check()?;
                let products = self.fourier.products(frames, (u, v), &mut scratch);
                let peak = self.peak(&products, 1.0, &mut scratch);
                evidence.extend(peak.map(|peak| self.evidence(level, &peak, [u..u + SIDE, v..v + SIDE])));
                sum.take(&products, [u..u + SIDE, v..v + SIDE]);
            }
        }
        Ok((evidence, sum))
    }

    fn of_sum(&self, level: usize, sum: &Sum, scratch: &mut Scratch) -> Option<SlopeEvidence> {
        if sum.windows < 2 {
            return None;
        }
        let peak = self.peak(&sum.products, SHARED_NOISE, scratch)?;
        Some(self.evidence(level, &peak, sum.area.clone()))
    }

    fn peak(&self, products: &CrossSpectra, more_variance: f64, scratch: &mut Scratch) -> Option<Peak> {
        let planes = self.fourier.correlations(&products.lags, scratch);
        let variance: Vec<f64> = products.variance.iter().map(|v| v * more_variance).collect();
        self.table.strongest(&planes, &variance)
    }

    fn evidence(&self, level: usize, peak: &Peak, [columns, rows]: [Range<usize>; 2]) -> SlopeEvidence {
        let level = self.first_level + level as u32;
        let unit = f64::from(1u32 << level);
        let centre = |r: &Range<usize>| (0.5 * (r.start + r.end) as f64 * unit - 0.5) as f32;
        let length = |r: &Range<usize>| (r.len() as f64 * unit) as f32;
        SlopeEvidence {
            slope: Slope::new((peak.slope[0] * unit) as f32, (peak.slope[1] * unit) as f32),
            significance: peak.significance as f32,
            uncertainty: (peak.uncertainty * unit) as f32,
            ambiguity: peak.ambiguity as f32,
            level,
            centre: [centre(&columns), centre(&rows)],
            size: [length(&columns), length(&rows)],
        }
    }
}

/// Starts of half-overlapping windows that cover `length` pixels evenly.
fn starts(length: usize) -> Vec<usize> {
    let room = length.saturating_sub(SIDE);
    let steps = room.div_ceil(SIDE / 2);
    (0..=steps).map(|i| (i * room).checked_div(steps).unwrap_or(0)).collect()
}

/// Sum of several windows.
struct Sum {
    products: CrossSpectra,
    windows: usize,
    /// Columns and rows that the windows cover, level pixels.
    area: [Range<usize>; 2],
}

impl Sum {
    fn new(frame_count: usize) -> Self {
        Self { products: CrossSpectra::zeros(frame_count), windows: 0, area: [0..0, 0..0] }
    }

    fn take(&mut self, products: &CrossSpectra, area: [Range<usize>; 2]) {
        self.products.add(products);
        self.widen(area, 1);
    }

    fn add(&mut self, other: &Self) {
        self.products.add(&other.products);
        if other.windows > 0 {
            self.widen(other.area.clone(), other.windows);
        }
    }

    fn widen(&mut self, area: [Range<usize>; 2], windows: usize) {
        if self.windows == 0 {
            self.area = area;
        } else {
            for (a, b) in self.area.iter_mut().zip(area) {
                *a = a.start.min(b.start)..a.end.max(b.end);
            }
        }
        self.windows += windows;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_cover_a_line_from_end_to_end() {
        for length in [32, 33, 47, 48, 60, 64, 101, 400] {
            let starts = starts(length);
            assert_eq!((starts[0], starts.last().map(|s| s + SIDE)), (0, Some(length)), "{length}");
            assert!(starts.windows(2).all(|w| w[1] > w[0] && w[1] - w[0] <= SIDE / 2), "{length}: {starts:?}");
        }
    }
}
