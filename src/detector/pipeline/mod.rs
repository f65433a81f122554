//! The whole detector: octave by octave, tile by tile, slope by slope.
//!
//! Octaves come in turn, each starting from planes that the one before left for every slope. Within an octave the tiles run in parallel; a
//! tile visits all slopes in order, holding only those that its undecided candidates still need. Its height is chosen so that
//! what the threads hold together stays bounded (at least eight rows are held, whatever that takes). Tiles return their keypoints in order, so threads cannot change the result.
//!
//! Keypoints are described when their octave is finished, or, where a tile of the first octave still holds the stacked images of all slopes, at the end of that
//! tile, which saves stacking them again. The pixels have the same bits either way, and so have the features.

mod tile;

use super::describing::{DescribeScratch, Describing, Keypoint};
use super::feature::{Descriptor, Detection, Feature, StageTimes, Tally, Test};
use super::motion::{FrameOffset, frame_offsets};
use super::noise::{dog_noise_variance, gate_factor};
use super::noise_estimate::frame_noise;
use super::octave::{Base, OctaveFilters};
use super::params::{DetectorParams, ParamError};
use super::refine::MAX_MOVES;
use super::scale_space::{ScaleSpace, octave_size};
use super::slope_grid::SlopeGrid;
use super::slope_window::{SlopeWindow, capacity};
use super::view::searched_octaves;
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use crate::plane::bank::{FilterBank, FilterScratch};
use crate::plane::tile::{Region, Tile, cuts, split_mut};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use tile::{Octave, TileScratch};

/// Bytes of DoG tiles that the threads' windows of slopes may hold together.
const WINDOWS_BYTES: usize = 128 << 20;
/// Bytes that one of them holds at most: as much as stays in a thread's share of the third cache. Fewer rows than that repeat too much of what the filters
/// need around a tile.
const WINDOW_BYTES: usize = 6 << 20;
/// Columns of a tile. With those held around it for the moves of the refinement it is five blocks of vectors wide, and what lies between the two
/// passes of its filters stays in the second cache.
const TILE_COLUMNS: usize = 148;
/// Rows of a tile where the window does not ask for fewer: enough that the rows its filters need around it matter little.
const TILE_ROWS: usize = 548;
/// Slopes whose frames are stacked together, at most: whole rows of the grid where it has two axes, which share the mixing of rows.
const STACKED_SLOPES: usize = 16;
/// Pixels held around a tile: the refinement moves this far and looks at a neighbour there.
const HELD: usize = MAX_MOVES + 1;

/// Why there is no detection.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DetectError {
    /// A parameter makes no sense for this burst.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// It was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What does not change during a detection.
struct Search<'a> {
    frames: &'a [&'a Plane],
    size_image: (usize, usize),
    grid: SlopeGrid,
    /// For each slope, where its frames are read.
    offsets: Vec<Vec<FrameOffset>>,
    space: ScaleSpace,
    /// The filters of the first octave and of the later ones.
    banks: (FilterBank, FilterBank),
    params: &'a DetectorParams,
    frame_noise: f32,
    gate_factor: f32,
    monitor: &'a Monitor,
    /// Space that no thread is using.
    unused: Mutex<Vec<TileScratch>>,
}

/// Finds the features of a burst.
///
/// # Errors
/// [`DetectError::Param`] for parameters that make no sense for the burst, [`DetectError::Cancelled`] once `monitor` was cancelled.
pub fn detect(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Detection, DetectError> {
    params.validate_for(burst.len(), burst.size())?;
    let frames_used = params.used_frames(burst.len());
    let started = Instant::now();
    monitor.report(Stage::Noise, 0.0);
    let noise = frame_noise(burst, frames_used.clone(), monitor)?;
    let mut times = StageTimes { noise_secs: started.elapsed().as_secs_f32(), ..StageTimes::default() };

    let frames: Vec<&Plane> = burst.frames[frames_used.clone()].iter().map(|f| &**f).collect();
    let grid = params.used_slopes();
    let space = ScaleSpace::of(params);
    let search = Search {
        frames: &frames,
        size_image: burst.size(),
        grid,
        offsets: grid.slopes().map(|slope| frame_offsets(frames.len(), slope, params.interpolation)).collect(),
        banks: (space.bank(true, space.all_levels()), space.bank(false, space.all_levels())),
        space,
        params,
        frame_noise: noise,
        gate_factor: gate_factor(params),
        monitor,
        unused: Mutex::new(Vec::new()),
    };
    let octaves = searched_octaves(params, burst.size());
    let mut tally = Tally::default();
    let mut found: Vec<(Feature, Descriptor)> = Vec::new();
    // The first levels of an octave and of the one before, one a slope.
    let (mut bases, mut finer_bases): (Vec<Plane>, Vec<Plane>) = (Vec::new(), Vec::new());
    let pixels = |octave: i32| octave_size(burst.size(), octave).0 as f32 * octave_size(burst.size(), octave).1 as f32;
    let all_pixels: f32 = octaves.clone().map(pixels).sum();
    let mut done = 0.0;
    for octave in octaves.clone() {
        let share = pixels(octave) / all_pixels;
        let progress = |part: f32| monitor.report(Stage::Search { octave }, done + share * part);
        let searching = Instant::now();
        let (in_tiles, next_bases) = search.octave(octave, &bases, octave + 1 < octaves.end, &mut tally, &progress)?;
        let (secs, describing_part) = (searching.elapsed().as_secs_f32(), in_tiles.describing_part());
        times.search_secs += secs * (1.0 - describing_part);
        times.describe_secs += secs * describing_part;
        let started = Instant::now();
        monitor.report(Stage::Describe, done + share * 0.95);
        let finer = |slope_index: usize| search.base(octave - 1, &finer_bases, slope_index);
        let base = |slope_index: usize| search.base(octave, &bases, slope_index);
        let describing = search.describing(octave, &base, (octave > octaves.start).then_some(&finer as _));
        found.extend(in_tiles.described);
        found.extend(describing.describe(&in_tiles.keypoints)?);
        times.describe_secs += started.elapsed().as_secs_f32();
        finer_bases = std::mem::replace(&mut bases, next_bases);
        done += share;
    }
    monitor.check()?;
    found.sort_by(|(a, _), (b, _)| {
        let by_place = || a.v.total_cmp(&b.v).then(a.u.total_cmp(&b.u));
        // Features of one keypoint stay in the order of their orientations.
        let by_sample = || (a.octave, a.level, a.slope_index).cmp(&(b.octave, b.level, b.slope_index));
        b.strength().total_cmp(&a.strength()).then_with(by_place).then_with(by_sample)
    });
    if params.max_features > 0 && found.len() > params.max_features {
        tally.reject(Test::MaxFeatures, (found.len() - params.max_features) as u64);
        found.truncate(params.max_features);
    }
    monitor.report(Stage::Describe, 1.0);
    let (features, descriptors) = found.into_iter().unzip();
    Ok(Detection {
        features,
        descriptors,
        tally,
        frame_noise: noise,
        noise_gate_factor: search.gate_factor,
        slopes: grid,
        frames_used,
        octaves,
        times,
    })
}

impl Search<'_> {
    fn base<'s>(&'s self, octave: i32, bases: &'s [Plane], slope_index: usize) -> Base<'s> {
        if octave == self.space.first_octave {
            Base::Frames { frames: self.frames, offsets: &self.offsets[slope_index], octave, made: None }
        } else {
            Base::Level(&bases[slope_index])
        }
    }

    fn describing<'s>(
        &'s self,
        octave: i32,
        base: &'s (dyn Fn(usize) -> Base<'s> + Sync),
        finer: Option<&'s (dyn Fn(usize) -> Base<'s> + Sync)>,
    ) -> Describing<'s> {
        Describing {
            base,
            finer,
            offsets: &self.offsets,
            octave,
            size: octave_size(self.size_image, octave),
            size_image: self.size_image,
            grid: self.grid,
            space: &self.space,
            params: self.params,
            monitor: self.monitor,
        }
    }

    /// How many slopes of the first octave are stacked together.
    fn slopes_together(&self) -> usize {
        match self.grid.u.count {
            row @ 1..=STACKED_SLOPES => STACKED_SLOPES / row * row,
            _ => STACKED_SLOPES,
        }
    }

    /// Whether the keypoints of an octave of `tiles` tiles are described at the end of their tile, from its pixels: where it still holds all slopes, those have
    /// the bits of pixels made anew, and there are enough tiles that threads do not wait for one with many keypoints. The features are the same.
    fn describes_tiles(&self, octave: i32, tiles: usize) -> bool {
        octave == 0
            && octave == self.space.first_octave
            && self.grid.len() <= self.slopes_together()
            && self.offsets.iter().flatten().all(|offset| offset.part_v == 0.0)
            && tiles >= 2 * rayon::current_num_threads()
    }

    /// σ_D at `octave` and DoG level index `level_index` for each slope.
    fn sigma_d(&self, octave: i32, level_index: usize) -> Vec<f32> {
        let sigma = |offsets: &Vec<FrameOffset>| {
            self.frame_noise * dog_noise_variance(&self.space, octave, level_index as f64 - 1.0, offsets).sqrt() as f32
        };
        self.offsets.iter().map(sigma).collect()
    }

    /// A thread's space: one that lies unused, or a new one. Fresh memory costs as much as a good part of the search, so it goes round.
    fn take_scratch(&self) -> TileScratch {
        self.unused.lock().ok().and_then(|mut unused| unused.pop()).unwrap_or_else(|| TileScratch {
            stacked: Vec::new(),
            filter: FilterScratch::default(),
            next: Tile::default(),
            describe: DescribeScratch::default(),
            window: SlopeWindow::new(self.grid, self.params.slope_neighbours),
        })
    }

    fn put_back(&self, scratch: TileScratch) {
        if let Ok(mut unused) = self.unused.lock() {
            unused.push(scratch);
        }
    }

    /// The tiles of an octave of `size`: where its columns and its rows are cut.
    fn tile_cuts(&self, (width, height): (usize, usize)) -> (Vec<Range<usize>>, Vec<Range<usize>>) {
        let slopes = capacity(&self.grid, self.params.slope_neighbours);
        let window_bytes = (WINDOWS_BYTES / rayon::current_num_threads().max(1)).min(WINDOW_BYTES);
        let row_bytes = slopes * (self.space.levels + 2) * (TILE_COLUMNS + 2 * HELD) * size_of::<f32>();
        let rows = (window_bytes / row_bytes.max(1)).saturating_sub(2 * HELD);
        (cuts(width, TILE_COLUMNS), cuts(height, rows.clamp(8, TILE_ROWS)))
    }

    /// Searches one octave. Returns what was found and the first levels of the next octave, one a slope, if asked for.
    fn octave(
        &self,
        octave: i32,
        bases: &[Plane],
        wants_next: bool,
        tally: &mut Tally,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(Found, Vec<Plane>), Cancelled> {
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
        let describes = self.describes_tiles(octave, regions.len());
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
        let results: Vec<(Found, Tally)> = regions
            .par_iter()
            .zip(next_parts)
            .map(|(region, next)| {
                let (mut scratch, started) = (self.take_scratch(), Instant::now());
                let (keypoints, tally) = self.tile(&job, region, next, &mut scratch, &|| {
                    progress(0.95 * finished.fetch_add(1, Ordering::Relaxed) as f32 / steps as f32);
                })?;
                let searched = started.elapsed();
                let mut found = Found { keypoints, ..Found::default() };
                if describes {
                    found.described = self.describe_tile(&found.keypoints, &mut scratch)?;
                    found.keypoints.clear();
                }
                found.spent = started.elapsed();
                found.describing = found.spent - searched;
                self.put_back(scratch);
                Ok((found, tally))
            })
            .collect::<Result<_, Cancelled>>()?;
        let mut all = Found::default();
        for (found, tile_tally) in results {
            all.keypoints.extend(found.keypoints);
            all.described.extend(found.described);
            all.spent += found.spent;
            all.describing += found.describing;
            tally.merge(&tile_tally);
        }
        Ok((all, next))
    }
}

/// What was found in a tile or an octave.
#[derive(Default)]
struct Found {
    /// What is left to be described, in order of tiles.
    keypoints: Vec<Keypoint>,
    described: Vec<(Feature, Descriptor)>,
    /// Time that threads spent on all of it, and on describing.
    spent: Duration,
    describing: Duration,
}

impl Found {
    /// The part of the time that was spent on describing.
    fn describing_part(&self) -> f32 {
        self.describing.as_secs_f32() / self.spent.as_secs_f32().max(f32::MIN_POSITIVE)
    }
}
