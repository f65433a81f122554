//! The whole detector: octave by octave, tile by tile, slope by slope.
//!
//! Octaves come in turn, each starting from planes that the one before left for every slope. Within an octave the tiles run in parallel; a
//! tile visits all slopes in order, holding only those that its undecided candidates still need. Its height is chosen so that
//! what the threads hold together stays bounded (at least eight rows are held, whatever that takes). Tiles return their keypoints in order, so threads cannot change the result.
//!
//! What the tiles found goes through three more steps: of keypoints on one blob the strongest stays ([`distinct`]), those that stay are localised and described,
//! and the features are ranked. The first levels of all octaves are kept until then.

mod tile;

use super::describing::{self, Describing};
use super::distinct::{self, Blob};
use super::feature::{Descriptor, Detection, Feature, StageTimes, Tally, Test};
use super::keypoint::Keypoint;
use super::motion::{FrameOffset, FrameTimes, frame_offsets};
use super::noise::gate_factor;
use super::noise_estimate::frame_noise;
use super::noise_model::{Examined, NoiseModel, examine};
use super::octave::{Base, OctaveFilters};
use super::params::{DescribeSlope, DetectorParams, Distinct, NoiseModelKind, ParamError};
use super::refine::MAX_MOVES;
use super::scale_space::{ScaleSpace, octave_size};
use super::slope_grid::{Slope, SlopeGrid};
use super::slope_window::{OtherSlopes, SlopeWindow, capacity};
use super::two_motions::{FramesOfOctaves, Motions};
use super::view::searched_octaves;
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use crate::plane::bank::{FilterBank, FilterScratch};
use crate::plane::tile::{Region, Tile, cuts, split_mut};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;
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
    times: &'a FrameTimes,
    size_image: (usize, usize),
    grid: SlopeGrid,
    /// For each slope, where its frames are read.
    offsets: Vec<Vec<FrameOffset>>,
    space: ScaleSpace,
    /// The filters of the first octave and of the later ones.
    banks: (FilterBank, FilterBank),
    params: &'a DetectorParams,
    noise: &'a NoiseModel,
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
    let space = ScaleSpace::of(params);
    let Examined { model: noise, frames, kept } = known_noise(burst, params, &space, monitor)?;
    let mut times = StageTimes { noise_secs: started.elapsed().as_secs_f32(), ..StageTimes::default() };

    let frames: Vec<&Plane> = frames.iter().map(|f| &**f).collect();
    let frame_times = FrameTimes { frame_count: frames_used.len(), kept };
    let grid = params.used_slopes();
    let offsets = |slope| frame_times.of(frame_offsets(frame_times.frame_count, slope, params.interpolation));
    let search = Search {
        frames: &frames,
        times: &frame_times,
        size_image: burst.size(),
        grid,
        offsets: grid.slopes().map(offsets).collect(),
        banks: (space.bank(true, space.all_levels()), space.bank(false, space.all_levels())),
        space,
        params,
        noise: &noise,
        gate_factor: gate_factor(params),
        monitor,
        unused: Mutex::new(Vec::new()),
    };
    let octaves = searched_octaves(params, burst.size());
    let mut tally = Tally::default();
    let started = Instant::now();
    let found = search.octaves(&octaves, &mut tally)?;
    let octave_frames = FramesOfOctaves::new(&frames, &frame_times, octaves.clone());
    let keypoints = search.distinct(found.keypoints, &octave_frames, &mut tally);
    tally.kept = keypoints.len() as u64;
    times.search_secs = started.elapsed().as_secs_f32();
    let started = Instant::now();
    let mut found = search.describe(&octaves, &keypoints, &found.bases, &octave_frames)?;
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
    times.describe_secs = started.elapsed().as_secs_f32();
    monitor.report(Stage::Describe, 1.0);
    let (features, descriptors) = found.into_iter().unzip();
    Ok(Detection {
        features,
        descriptors,
        tally,
        frame_noise: noise.frame_noise,
        noise_gate_factor: search.gate_factor,
        noise: Arc::new(noise),
        slopes: grid,
        frames_used,
        octaves,
        times,
    })
}

/// The noise of the burst as the parameters want it known, and the frames that are searched: with [`NoiseModelKind::White`], or where there is too little to know
/// more, all that are used, as they are.
fn known_noise(
    burst: &Burst,
    params: &DetectorParams,
    space: &ScaleSpace,
    monitor: &Monitor,
) -> Result<Examined, Cancelled> {
    let used = params.used_frames(burst.len());
    let frames = &burst.frames[used.clone()];
    let local = match params.noise_model {
        NoiseModelKind::Local => {
            examine(frames, burst.quantisation_step, space, searched_octaves(params, burst.size()), monitor)?
        }
        NoiseModelKind::White => None,
    };
    match local {
        Some(examined) => Ok(examined),
        None => {
            let model = NoiseModel::white(frame_noise(burst, used, monitor)?);
            Ok(Examined { model, frames: frames.to_vec(), kept: (0..frames.len()).collect() })
        }
    }
}

/// What the search leaves.
struct Searched {
    /// In order of octaves, and within them of tiles and slopes.
    keypoints: Vec<Keypoint>,
    /// For each octave the first levels, one a slope; none for the first octave, which is made from the frames.
    bases: Vec<Vec<Plane>>,
}

/// The part of a detection's time that the search takes, about; describing takes the rest.
const SEARCH_PART: f32 = 0.7;

impl Search<'_> {
    /// Searches all octaves.
    fn octaves(&self, octaves: &Range<i32>, tally: &mut Tally) -> Result<Searched, Cancelled> {
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

    /// The keypoints that stay when each blob keeps one.
    fn distinct(&self, keypoints: Vec<Keypoint>, frames: &FramesOfOctaves<'_>, tally: &mut Tally) -> Vec<Keypoint> {
        let Distinct::Radius(radius) = self.params.distinct else {
            return keypoints;
        };
        let blobs: Vec<Blob> = keypoints.iter().map(Blob::from).collect();
        let rule = distinct::Rule { radius, scale_ratio: self.params.distinct_scale };
        let motions = Motions {
            frames,
            times: self.times,
            size_image: self.size_image,
            space: &self.space,
            interpolation: self.params.interpolation,
        };
        let are_two = |a: usize, b: usize| motions.are_two(&keypoints[a], &keypoints[b]);
        let covered = distinct::covered_by(&blobs, rule, are_two);
        let before = keypoints.len();
        let stay = keypoints.into_iter().zip(covered).filter(|(_, by)| by.is_none());
        let keypoints: Vec<Keypoint> = stay.map(|(keypoint, _)| keypoint).collect();
        tally.reject(Test::Duplicate, (before - keypoints.len()) as u64);
        keypoints
    }

    /// The features of `keypoints`, which are in order of octaves.
    fn describe(
        &self,
        octaves: &Range<i32>,
        keypoints: &[Keypoint],
        bases: &[Vec<Plane>],
        frames: &FramesOfOctaves<'_>,
    ) -> Result<Vec<(Feature, Descriptor)>, Cancelled> {
        let mut found = Vec::with_capacity(keypoints.len() + keypoints.len() / 2);
        let of_octave = |octave: i32| &bases[(octave - octaves.start) as usize];
        let finished = AtomicUsize::new(0);
        let described = |count: usize| {
            let done = (finished.fetch_add(count, Ordering::Relaxed) + count) as f32 / keypoints.len() as f32;
            self.monitor.report(Stage::Describe, SEARCH_PART + (1.0 - SEARCH_PART) * done);
        };
        self.monitor.report(Stage::Describe, SEARCH_PART);
        for in_octave in keypoints.chunk_by(|a, b| a.octave == b.octave) {
            let octave = in_octave[0].octave;
            let base = |slope_index: usize| self.base(octave, of_octave(octave), slope_index);
            let finer = |slope_index: usize| self.base(octave - 1, of_octave(octave - 1), slope_index);
            let own_slopes = self.describes_own_slopes(octave).then(|| frames.of(octave));
            let describing = Describing {
                base: &base,
                finer: (octave > octaves.start).then_some(&finer as _),
                offsets: &self.offsets,
                octave,
                size: octave_size(self.size_image, octave),
                size_image: self.size_image,
                grid: self.grid,
                space: &self.space,
                params: self.params,
                own_slopes,
                monitor: self.monitor,
                described: &described,
            };
            found.extend(describing.describe(in_octave)?);
        }
        Ok(found)
    }

    /// Whether features of `octave` are described at their own slopes, so far as the octave can show the difference.
    fn describes_own_slopes(&self, octave: i32) -> bool {
        let step = [self.grid.u.step(), self.grid.v.step()].into_iter().fold(0.0, f32::max);
        let outermost_px = step * 0.5 * (self.times.frame_count as f32 - 1.0);
        self.params.describe_slope == DescribeSlope::Refined
            && describing::misaligned(outermost_px, self.space.sigma_image(octave, 0.0) as f32)
    }

    fn base<'s>(&'s self, octave: i32, bases: &'s [Plane], slope_index: usize) -> Base<'s> {
        if octave == self.space.first_octave {
            Base::Frames { frames: self.frames, offsets: &self.offsets[slope_index], octave }
        } else {
            Base::Level(&bases[slope_index])
        }
    }

    /// How many slopes of the first octave are stacked together.
    fn slopes_together(&self) -> usize {
        match self.grid.u.count {
            row @ 1..=STACKED_SLOPES => STACKED_SLOPES / row * row,
            _ => STACKED_SLOPES,
        }
    }

    /// σ_D at `octave` and DoG level index `level_index` for each slope, where the noise is least.
    fn sigma_d(&self, octave: i32, level_index: usize) -> Vec<f32> {
        let sigma = |(slope, offsets): (Slope, &Vec<FrameOffset>)| {
            self.noise.sigma_d(&self.space, (octave, level_index as i32 - 1), (slope, offsets), self.gate_factor)
        };
        self.grid.slopes().zip(&self.offsets).map(sigma).collect()
    }

    /// A thread's space: one that lies unused, or a new one. Fresh memory costs as much as a good part of the search, so it goes round.
    fn take_scratch(&self) -> TileScratch {
        self.unused.lock().ok().and_then(|mut unused| unused.pop()).unwrap_or_else(|| TileScratch {
            stacked: Vec::new(),
            filter: FilterScratch::default(),
            next: Tile::default(),
            window: SlopeWindow::new(self.grid, OtherSlopes::of(self.params)),
        })
    }

    fn put_back(&self, scratch: TileScratch) {
        if let Ok(mut unused) = self.unused.lock() {
            unused.push(scratch);
        }
    }

    /// The tiles of an octave of `size`: where its columns and its rows are cut.
    fn tile_cuts(&self, (width, height): (usize, usize)) -> (Vec<Range<usize>>, Vec<Range<usize>>) {
        let slopes = capacity(&self.grid, OtherSlopes::of(self.params));
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
