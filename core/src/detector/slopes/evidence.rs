//! What windows of all places and sizes say about the slopes of a burst.
//!
//! Each level is covered by half-overlapping windows. Correlations of windows can be added up: over a sixteenth of the
//! image, a quarter, the whole. Small windows see several depths and small layers apart; large ones see what is too
//! faint for a small one.

use super::peak::{Peak, SearchTable, Track};
use super::spectra::{CrossSpectra, Fourier, SIDE, Scratch};
use crate::detector::params::slope_grid::Slope;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What one window, or several added up, say about the slope there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlopeEvidence {
    /// The slope at which the motion stack has the most power, pixels per frame.
    pub slope: Slope,
    /// That power, without what each frame has alone, over its standard deviation if the frames had nothing in common.
    pub significance: f32,
    /// How far off the slope may be, pixels per frame, in the direction in which it is least certain (along an edge).
    pub uncertainty: f32,
    /// The power at the strongest other slope over that at this one: near 1 on periodic texture.
    pub ambiguity: f32,
    /// Level of the pyramid: pixels of 2^level image pixels.
    pub level: u32,
    /// Centre of the window, image pixels.
    pub centre: [f32; 2],
    /// Columns and rows of the window, image pixels.
    pub size: [f32; 2],
}

/// What was seen at all levels.
pub(super) struct Seen {
    /// Of every window that has any signal at all.
    pub evidence: Vec<SlopeEvidence>,
    /// For each level, the products summed over the whole image.
    pub wholes: Vec<CrossSpectra>,
}

/// Blocks along each axis in which windows are added up first.
const BLOCKS: usize = 4;
/// Half-overlapping windows share noise: the variance of their sum over the sum of their variances.
const SHARED_NOISE: f64 = 1.37;

/// What the same work on all windows needs.
pub(super) struct Looking<'a> {
    pub fourier: &'a Fourier,
    pub table: &'a SearchTable,
    /// Frames at each level, the finest first.
    pub levels: &'a [Vec<Plane>],
    /// Which level the first of them is.
    pub first_level: u32,
}

/// Looks at every window at every level.
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

    /// The windows of one block: what each of them says, and their sum.
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

/// Where half-overlapping windows begin that cover `length` pixels evenly.
fn starts(length: usize) -> Vec<usize> {
    let room = length.saturating_sub(SIDE);
    let steps = room.div_ceil(SIDE / 2);
    (0..=steps).map(|i| (i * room).checked_div(steps).unwrap_or(0)).collect()
}

/// Windows added up.
struct Sum {
    products: CrossSpectra,
    windows: usize,
    /// Columns and rows that they cover, level pixels.
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
