//! The search through the octaves: each is cut into tiles, which run in parallel.
//!
//! Octaves come in turn, each starting from planes that the one before left for every slope. A tile visits all slopes
//! in order, holding only those that its undecided candidates still need. Its height is chosen so that what the threads
//! hold together stays bounded (at least eight rows are held, whatever that takes). Tiles return their keypoints in
//! order, so threads cannot change the result. The first levels of all octaves are kept, for what follows.

use crate::detector::feature::Tally;
use crate::detector::keypoint::Keypoint;
use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::levels::octave_size;
use crate::detector::scale_space::octave::{Base, OctaveFilters};
use crate::detector::search::setup::{HELD, Search, TileScratch};
use crate::detector::search::slope_window::{OtherSlopes, SlopeWindow, capacity};
use crate::detector::search::tile::Octave;
use crate::kernel::gaussian_bank::FilterScratch;
use crate::kernel::machine::{STACKED_SLOPES, TILE_COLUMNS, TILE_ROWS, WINDOW_BYTES, WINDOWS_BYTES};
use crate::kernel::offset::FrameOffset;
use crate::monitor::{Cancelled, Stage};
use crate::plane::Plane;
use crate::plane::tile::{Region, Tile, cuts, split_mut};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What the search leaves.
pub(crate) struct Searched {
    /// In order of octaves, and within them of tiles and slopes.
    pub(crate) keypoints: Vec<Keypoint>,
    /// For each octave the first levels, one a slope; none for the first octave, which is made from the frames.
    pub(crate) bases: Vec<Vec<Plane>>,
}

/// The part of a detection's time that the search takes, about; describing takes the rest.
pub(crate) const SEARCH_PART: f32 = 0.7;

impl Search<'_> {
    /// Searches all octaves.
    pub(crate) fn octaves(&self, octaves: &Range<i32>, tally: &mut Tally) -> Result<Searched, Cancelled> {
        let pixels = |octave: i32| {
            let (width, height) = octave_size(self.size_image, octave);
            width as f32 * height as f32
        };
        let all_pixels: f32 = octaves.clone().map(pixels).sum();
        let (mut keypoints, mut bases) = (Vec::new(), vec![Vec::new()]);
        let mut done = 0.0;
        for octave in octaves.clone() {
            let share = SEARCH_PART * pixels(octave) / all_pixels;
            let progress = |part: f32| self.monitor.report(Stage::Search { octave }, done + share * part);
            let last = bases.last().expect("the first octave's is there");
            let (in_octave, next) = self.octave(octave, last, octave + 1 < octaves.end, tally, &progress)?;
            keypoints.extend(in_octave);
            bases.push(next);
            done += share;
        }
        Ok(Searched { keypoints, bases })
    }

    pub(crate) fn base<'s>(&'s self, octave: i32, bases: &'s [Plane], slope_index: usize) -> Base<'s> {
        if octave == self.space.first_octave {
            Base::Frames { frames: self.frames, offsets: &self.offsets[slope_index], octave }
        } else {
            Base::Level(&bases[slope_index])
        }
    }

    /// How many slopes of the first octave are stacked together.
    pub(crate) fn slopes_together(&self) -> usize {
        match self.grid.u.count {
            row @ 1..=STACKED_SLOPES => STACKED_SLOPES / row * row,
            _ => STACKED_SLOPES,
        }
    }

    /// σ_D at `octave` and DoG level index `level_index` for each slope, where the noise is least.
    pub(crate) fn sigma_d(&self, octave: i32, level_index: usize) -> Vec<f32> {
        let sigma = |(slope, offsets): (Slope, &Vec<FrameOffset>)| {
            self.noise.sigma_d(&self.space, (octave, level_index as i32 - 1), (slope, offsets), self.gate_factor)
        };
        self.grid.slopes().zip(&self.offsets).map(sigma).collect()
    }

    /// A thread's space: one that lies unused, or a new one. Fresh memory costs as much as a good part of the search,
    /// so it goes round.
    pub(crate) fn take_scratch(&self) -> TileScratch {
        self.unused.lock().ok().and_then(|mut unused| unused.pop()).unwrap_or_else(|| TileScratch {
            stacked: Vec::new(),
            filter: FilterScratch::default(),
            next: Tile::default(),
            window: SlopeWindow::new(self.grid, OtherSlopes::of(self.params)),
        })
    }

    pub(crate) fn put_back(&self, scratch: TileScratch) {
        if let Ok(mut unused) = self.unused.lock() {
            unused.push(scratch);
        }
    }

    /// The tiles of an octave of `size`: where its columns and its rows are cut.
    pub(crate) fn tile_cuts(&self, (width, height): (usize, usize)) -> (Vec<Range<usize>>, Vec<Range<usize>>) {
        let slopes = capacity(&self.grid, OtherSlopes::of(self.params));
        let window_bytes = (WINDOWS_BYTES / rayon::current_num_threads().max(1)).min(WINDOW_BYTES);
        let row_bytes = slopes * (self.space.levels + 2) * (TILE_COLUMNS + 2 * HELD) * size_of::<f32>();
        let rows = (window_bytes / row_bytes.max(1)).saturating_sub(2 * HELD);
        (cuts(width, TILE_COLUMNS), cuts(height, rows.clamp(8, TILE_ROWS)))
    }

    /// Searches one octave. Returns what was found and the first levels of the next octave, one a slope, if asked for.
    pub(crate) fn octave(
        &self,
        octave: i32,
        bases: &[Plane],
        wants_next: bool,
        tally: &mut Tally,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(Vec<Keypoint>, Vec<Plane>), Cancelled> {
        let size = octave_size(self.size_image, octave);
        let (columns, rows) = self.tile_cuts(size);
        let sigma_d: Vec<Vec<f32>> =
            (0..self.space.levels + 2).map(|level_index| self.sigma_d(octave, level_index)).collect();
        let bank = if octave == self.space.first_octave { &self.banks.0 } else { &self.banks.1 };
        let job = Octave {
            octave,
            size,
            bases,
            filters: OctaveFilters::new(&self.space, bank, &self.space.all_levels(), size),
            sigma_d,
        };
        let mut next: Vec<Plane> =
            (0..if wants_next { self.grid.len() } else { 0 }).map(|_| Plane::zeros(size.0 / 2, size.1 / 2)).collect();
        let regions: Vec<Region> = rows
            .iter()
            .flat_map(|rows| columns.iter().map(|columns| Region { columns: columns.clone(), rows: rows.clone() }))
            .collect();
        // For each tile, its part of the next octave's planes.
        let mut next_parts: Vec<Vec<Vec<&mut [f32]>>> = regions.iter().map(|_| Vec::new()).collect();
        let halved = |parts: &[Range<usize>]| -> Vec<Range<usize>> {
            parts.iter().map(|part| part.start / 2..part.end / 2).collect()
        };
        let (half_columns, half_rows) = (halved(&columns), halved(&rows));
        for plane in &mut next {
            for (tile, part) in next_parts.iter_mut().zip(split_mut(plane, &half_columns, &half_rows)) {
                tile.push(part);
            }
        }
        let finished = AtomicUsize::new(0);
        let steps = regions.len() * self.grid.len();
        let results: Vec<(Vec<Keypoint>, Tally)> = regions
            .par_iter()
            .zip(next_parts)
            .map(|(region, next)| {
                let mut scratch = self.take_scratch();
                let found = self.tile(&job, region, next, &mut scratch, &|| {
                    progress(finished.fetch_add(1, Ordering::Relaxed) as f32 / steps as f32);
                })?;
                self.put_back(scratch);
                Ok(found)
            })
            .collect::<Result<_, Cancelled>>()?;
        let mut keypoints = Vec::with_capacity(results.iter().map(|(found, _)| found.len()).sum());
        for (found, tile_tally) in results {
            keypoints.extend(found);
            tally.merge(&tile_tally);
        }
        Ok((keypoints, next))
    }
}
