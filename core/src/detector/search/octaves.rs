//! The search through the octaves: each is cut into tiles, which run in parallel.
//!
//! Octaves come in turn, each starting from planes that the one before has written for every slope. A tile visits the
//! slopes in order, holding only those that its undecided candidates still need. Its height is chosen so that the
//! threads' memory together stays bounded (at least eight rows are held, whatever that takes). Tiles return their
//! keypoints in order, so threads cannot change the result. The first levels of all octaves are kept for the steps
//! after the search; where memory does not allow that for all slopes, groups of slopes go through all octaves one after
//! the other.

use crate::detector::feature::Tally;
use crate::detector::keypoint::Keypoint;
use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::levels::octave_size;
use crate::detector::scale_space::octave::{Base, OctaveFilters};
use crate::detector::search::groups::{FirstLevels, SlopeGroup};
use crate::detector::search::setup::{HELD, Search, TileScratch};
use crate::detector::search::slope_window::{OtherSlopes, SlopeWindow, capacity};
use crate::detector::search::tile::Octave;
use crate::kernel::gaussian_bank::FilterScratch;
use crate::kernel::machine::{STACKED_SLOPES, TILE_COLUMNS, TILE_ROWS, WINDOW_BYTES, WINDOWS_BYTES};
use crate::kernel::stack::FrameOffset;
use crate::monitor::{Cancelled, Stage};
use crate::plane::Plane;
use crate::plane::tile::{Region, Tile, cuts, split_mut};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Result of the search.
pub(crate) struct Searched {
    /// Keypoints in order of octaves, and within them of tiles and slopes.
    pub(crate) keypoints: Vec<Keypoint>,
    /// First levels of each octave; none for the first octave, which is made from the frames. `None` where the slopes
    /// were searched in groups, which keep none.
    pub(crate) bases: Option<Vec<FirstLevels>>,
}

/// Part of a detection's time that the search takes, about; describing takes the rest.
pub(crate) const SEARCH_PART: f32 = 0.7;

/// Keypoints by octave and tile.
type ByTile = Vec<Vec<Vec<Keypoint>>>;

impl Search<'_> {
    /// Searches all octaves, one of the `groups` of slopes after the other; together they own every slope of the grid.
    pub(crate) fn octaves(
        &self,
        octaves: &Range<i32>,
        groups: &[SlopeGroup],
        tally: &mut Tally,
    ) -> Result<Searched, Cancelled> {
        let mut found: ByTile = octaves.clone().map(|_| Vec::new()).collect();
        let visited: usize = groups.iter().map(|group| group.visited.len()).sum();
        let (mut bases, mut done) = (None, 0.0);
        for group in groups {
            let share = SEARCH_PART * group.visited.len() as f32 / visited as f32;
            let keeps = groups.len() == 1;
            bases = self.group(octaves, group, (keeps, &mut found), tally, (done, share))?;
            done += share;
        }
        Ok(Searched { keypoints: found.into_iter().flatten().flatten().collect(), bases })
    }

    /// Searches all octaves for the keypoints of one group of slopes, and appends them to those `found` at the slopes
    /// before. Returns the first levels of all octaves if it `keeps` them; otherwise each is freed as soon as it is no
    /// longer needed. For the progress, `done` is the finished part of the detection, and `share` the group's.
    fn group(
        &self,
        octaves: &Range<i32>,
        group: &SlopeGroup,
        (keeps, found): (bool, &mut ByTile),
        tally: &mut Tally,
        (mut done, share): (f32, f32),
    ) -> Result<Option<Vec<FirstLevels>>, Cancelled> {
        let pixels = |octave: i32| {
            let (width, height) = octave_size(self.size_image, octave);
            width as f32 * height as f32
        };
        let all_pixels: f32 = octaves.clone().map(pixels).sum();
        let mut bases = vec![FirstLevels::default()];
        for (octave, found) in octaves.clone().zip(found) {
            let share = share * pixels(octave) / all_pixels;
            let progress = |part: f32| self.monitor.report(Stage::Search { octave }, done + share * part);
            let last = bases.last().expect("the first octave's is there");
            let (tiles, next) = self.octave(octave, (group, last), octave + 1 < octaves.end, tally, &progress)?;
            found.resize_with(tiles.len(), Vec::new);
            found.iter_mut().zip(tiles).for_each(|(found, tile)| found.extend(tile));
            if !keeps {
                bases.clear();
            }
            bases.push(next);
            done += share;
        }
        Ok(keeps.then_some(bases))
    }

    /// Source of the first level of an octave at a slope of the grid: the frames, or `bases`.
    pub(crate) fn base<'s>(&'s self, octave: i32, bases: &'s FirstLevels, slope_index: usize) -> Base<'s> {
        if octave == self.space.first_octave {
            Base::Frames { frames: self.frames, offsets: &self.offsets[slope_index], octave }
        } else {
            Base::Level(bases.at(slope_index))
        }
    }

    /// Number of slopes of the first octave that are stacked together.
    pub(crate) fn slopes_together(&self) -> usize {
        match self.grid.u.count {
            row @ 1..=STACKED_SLOPES => STACKED_SLOPES / row * row,
            _ => STACKED_SLOPES,
        }
    }

    /// σ_D at `octave` and DoG level index `level_index` for each slope, at the place of least noise.
    pub(crate) fn sigma_d(&self, octave: i32, level_index: usize) -> Vec<f32> {
        let sigma = |(slope, offsets): (Slope, &Vec<FrameOffset>)| {
            self.noise.sigma_d(&self.space, (octave, level_index as i32 - 1), (slope, offsets), self.gate_factor)
        };
        self.grid.slopes().zip(&self.offsets).map(sigma).collect()
    }

    /// Buffers for a thread: unused ones, or new ones. Allocating memory anew costs as much as a good part of the
    /// search, so buffers are reused.
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

    /// Ranges of columns and of rows that are the tiles of an octave of `size`.
    pub(crate) fn tile_cuts(&self, (width, height): (usize, usize)) -> (Vec<Range<usize>>, Vec<Range<usize>>) {
        let slopes = capacity(&self.grid, OtherSlopes::of(self.params));
        let window_bytes = (WINDOWS_BYTES / rayon::current_num_threads().max(1)).min(WINDOW_BYTES);
        let row_bytes = slopes * (self.space.levels + 2) * (TILE_COLUMNS + 2 * HELD) * size_of::<f32>();
        let rows = (window_bytes / row_bytes.max(1)).saturating_sub(2 * HELD);
        (cuts(width, TILE_COLUMNS), cuts(height, rows.clamp(8, TILE_ROWS)))
    }

    /// Searches one octave for the keypoints of a group of slopes, whose first levels are `bases`. Returns the
    /// keypoints by tile, and the first levels of the next octave if `wants_next`.
    fn octave(
        &self,
        octave: i32,
        (group, bases): (&SlopeGroup, &FirstLevels),
        wants_next: bool,
        tally: &mut Tally,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(Vec<Vec<Keypoint>>, FirstLevels), Cancelled> {
        let size = octave_size(self.size_image, octave);
        let (columns, rows) = self.tile_cuts(size);
        let sigma_d: Vec<Vec<f32>> =
            (0..self.space.levels + 2).map(|level_index| self.sigma_d(octave, level_index)).collect();
        let bank = if octave == self.space.first_octave { &self.banks.0 } else { &self.banks.1 };
        let job = Octave {
            octave,
            size,
            group,
            bases,
            filters: OctaveFilters::new(&self.space, bank, &self.space.all_levels(), size),
            sigma_d,
        };
        let mut next: Vec<Plane> = (0..if wants_next { group.visited.len() } else { 0 })
            .map(|_| Plane::zeros(size.0 / 2, size.1 / 2))
            .collect();
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
        let steps = regions.len() * group.visited.len();
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
        results.iter().for_each(|(_, of_tile)| tally.merge(of_tile));
        let found = results.into_iter().map(|(found, _)| found).collect();
        Ok((found, FirstLevels::new(group.visited.start, next)))
    }
}
