//! Search: extrema of D over place and scale, at each slope for itself or jointly over slope.
//!
//! Octaves come in turn, each starting from planes that the one before has written for every slope. Tiles run in
//! parallel; each visits the slopes in order, holding only those that its undecided candidates still need. Tiles return
//! their keypoints in order, so threads cannot change the result. The first levels of all octaves are kept for later
//! steps; where memory does not allow that for all slopes, groups of slopes go through all octaves in turn.

pub(super) mod around_field;
pub mod extrema;
pub(super) mod setup;
pub mod slope_window;

use crate::detector::feature::{Keypoint, Tally, Test};
use crate::detector::params::{DetectorParams, Localisation, Slope, SlopeNeighbours};
use crate::detector::refine::ascent::FirstLevel;
use crate::detector::refine::{Fit, Limits, refine};
use crate::detector::scale_space::planes::next_level;
use crate::detector::scale_space::{DogTile, OctaveFilters, Pixels, SIGMA_BASE, dog_tile, octave_size, stack_tiles};
use crate::detector::search::extrema::{Candidate, Thresholds, own_slope_extrema, scale_ease};
use crate::detector::search::setup::{FirstLevels, HELD, KnownSlopes, Search, SlopeGroup, TileScratch};
use crate::detector::search::slope_window::{OtherSlopes, SlopeWindow, capacity};
use crate::kernel::compact_kernel::PixelView;
use crate::kernel::gaussian_bank::FilterScratch;
use crate::kernel::machine::{STACKED_SLOPES, TILE_COLUMNS, TILE_ROWS, WINDOW_BYTES, WINDOWS_BYTES};
use crate::monitor::{Cancelled, Stage};
use crate::plane::Plane;
use crate::plane::tile::{Region, Tile, cuts, split_mut};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Rows of a tile at most where not all slopes are searched everywhere: smaller tiles need fewer slopes.
const TILE_ROWS_AROUND: usize = 100;

pub(crate) struct SearchedSlopes {
    /// In order of octaves, and within them of tiles and slopes.
    pub(crate) keypoints: Vec<Keypoint>,
    pub(crate) evidence: Vec<Evidence>,
    /// First levels of each octave; none for the first octave. `None` where slopes were searched in groups.
    pub(crate) bases: Option<Vec<FirstLevels>>,
}

/// Part of a detection's time that the search takes, about; describing takes the rest.
pub(crate) const SEARCH_PART: f32 = 0.7;

/// Values of a keypoint that the search's thresholds compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Evidence {
    /// D at the sample, fraction of full scale.
    pub(crate) sample_value: f32,
    /// Ratio of σ_D at its place to that at the place of least noise.
    pub(crate) place_factor: f32,
    pub(crate) edge_quotient: f64,
}

pub(crate) type FoundKeypoint = (Keypoint, Evidence);

impl Search<'_> {
    /// Searches the `groups` of slopes in turn; together they own every slope of the grid. With `known` there is one
    /// group, and known slopes are not searched. `tallies` has one entry per slope.
    pub(crate) fn octaves(
        &self,
        octaves: &Range<i32>,
        groups: &[SlopeGroup],
        known: Option<&KnownSlopes<'_>>,
        tallies: &mut [Tally],
    ) -> Result<SearchedSlopes, Cancelled> {
        // By octave and tile.
        let mut found: Vec<Vec<Vec<FoundKeypoint>>> = octaves.clone().map(|_| Vec::new()).collect();
        let visited: usize = groups.iter().map(|group| group.visited.len()).sum();
        let (mut bases, mut done) = (None, 0.0);
        for group in groups {
            let share = SEARCH_PART * group.visited.len() as f32 / visited as f32;
            let keeps = groups.len() == 1;
            bases = self.group(octaves, group, known, keeps, &mut found, tallies, done, share)?;
            done += share;
        }
        if let Some(known) = known {
            for (octave, tiles) in octaves.clone().zip(&mut found) {
                known.merge_into(tiles, octave, self.tile_cuts(octave_size(self.inputs.size_image, octave)));
            }
        }
        let (keypoints, evidence) = found.into_iter().flatten().flatten().unzip();
        Ok(SearchedSlopes { keypoints, evidence, bases })
    }

    /// Searches all octaves for the keypoints of one group of slopes, and appends them to those `found` before. Returns
    /// the first levels of all octaves if it `keeps` them. Of the progress `done` is finished and `share` the group's.
    fn group(
        &self,
        octaves: &Range<i32>,
        group: &SlopeGroup,
        known: Option<&KnownSlopes<'_>>,
        keeps: bool,
        found: &mut [Vec<Vec<FoundKeypoint>>],
        tallies: &mut [Tally],
        mut done: f32,
        share: f32,
    ) -> Result<Option<Vec<FirstLevels>>, Cancelled> {
        let pixels = |octave: i32| {
            let (width, height) = octave_size(self.inputs.size_image, octave);
            width as f32 * height as f32
        };
        let all_pixels: f32 = octaves.clone().map(pixels).sum();
        let mut bases = vec![FirstLevels::default()];
        for (octave, found) in octaves.clone().zip(found) {
            // The time of an octave goes with its number of pixels.
            let share = share * pixels(octave) / all_pixels;
            let progress = |part: f32| self.monitor.report(Stage::Search { octave }, done + share * part);
            let last = bases.last().expect("the first octave's is there");
            let wants_next = octave + 1 < octaves.end;
            let (tiles, next) = self.octave(octave, group, known, last, wants_next, tallies, &progress)?;
            found.resize_with(tiles.len(), Vec::new);
            found.iter_mut().zip(tiles).for_each(|(found, tile)| found.extend(tile));
            // Groups exist because memory is short: only the last octave's levels are held, for the next one.
            if !keeps {
                bases.clear();
            }
            bases.push(next);
            done += share;
        }
        Ok(keeps.then_some(bases))
    }

    /// σ_D at `octave` by DoG level index and slope, at the place of least noise.
    pub(crate) fn sigma_d(&self, octave: i32) -> Vec<Vec<f32>> {
        let slopes: Vec<Slope> = self.grid.slopes().collect();
        let of_level = |level: i32| {
            let slopes = slopes.iter().zip(&self.offsets);
            slopes.map(|(&slope, offsets)| self.inputs.sigma_d(octave, level, slope, offsets)).collect()
        };
        (-1..=self.space.levels as i32).map(of_level).collect()
    }

    /// Unused buffers, or new ones: allocating anew costs as much as a good part of the search.
    fn take_scratch(&self) -> TileScratch {
        self.unused.lock().ok().and_then(|mut unused| unused.pop()).unwrap_or_else(|| TileScratch {
            stacked: Vec::new(),
            filter: FilterScratch::default(),
            next: Tile::default(),
            window: SlopeWindow::new(self.grid, OtherSlopes::of(self.params)),
        })
    }

    /// Columns and rows of an octave's tiles: as high as all threads' windows allow, at least eight rows.
    fn tile_cuts(&self, (width, height): (usize, usize)) -> (Vec<Range<usize>>, Vec<Range<usize>>) {
        let slopes = capacity(&self.grid, OtherSlopes::of(self.params));
        let window_bytes = (WINDOWS_BYTES / rayon::current_num_threads().max(1)).min(WINDOW_BYTES);
        let row_bytes = slopes * (self.space.levels + 2) * (TILE_COLUMNS + 2 * HELD) * size_of::<f32>();
        let rows = (window_bytes / row_bytes.max(1)).saturating_sub(2 * HELD);
        let most = if self.inputs.around.is_some() { TILE_ROWS_AROUND } else { TILE_ROWS };
        (cuts(width, TILE_COLUMNS), cuts(height, rows.clamp(8, most)))
    }

    /// Searches one octave for the keypoints of a group of slopes, whose first levels are `bases`. Returns the
    /// keypoints by tile, and the first levels of the next octave if `wants_next`.
    fn octave(
        &self,
        octave: i32,
        group: &SlopeGroup,
        known: Option<&KnownSlopes<'_>>,
        bases: &FirstLevels,
        wants_next: bool,
        tallies: &mut [Tally],
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(Vec<Vec<FoundKeypoint>>, FirstLevels), Cancelled> {
        let size = octave_size(self.inputs.size_image, octave);
        let (columns, rows) = self.tile_cuts(size);
        let bank = if octave == self.space.first_octave { &self.banks.0 } else { &self.banks.1 };
        // A slope searched only elsewhere needs one level, from which the next octave starts.
        let next_only = self.inputs.around.as_ref().filter(|_| wants_next).map(|_| {
            let levels = next_level(self.space);
            let bank = self.space.bank(octave == self.space.first_octave, levels.clone());
            OctaveFilters::new(self.space, &bank, &levels, size)
        });
        let tallies = Mutex::new(tallies);
        let filters = OctaveFilters::new(self.space, bank, &self.space.all_levels(), size);
        let sigma_d = self.sigma_d(octave);
        let job = Octave { octave, size, group, known, tallies: &tallies, bases, filters, next_only, sigma_d };
        let of_next = if wants_next { group.visited.clone() } else { 0..0 };
        let known_next = |index: usize| {
            known.and_then(|known| known.first_level((octave + 1 - self.space.first_octave) as usize, index))
        };
        // Planes of known slopes are shared with the earlier search instead of being made.
        let made = of_next.clone().filter(|&index| known_next(index).is_none());
        let mut next: Vec<Plane> = made.map(|_| Plane::zeros(size.0 / 2, size.1 / 2)).collect();
        let regions: Vec<Region> = rows
            .iter()
            .flat_map(|rows| columns.iter().map(|columns| Region { columns: columns.clone(), rows: rows.clone() }))
            .collect();
        // Each tile gets its own parts of the next octave's planes, so that threads write without a lock.
        let mut next_parts: Vec<Vec<Vec<&mut [f32]>>> = regions.iter().map(|_| Vec::new()).collect();
        let halved = |parts: &[Range<usize>]| -> Vec<Range<usize>> {
            parts.iter().map(|part| part.start / 2..part.end / 2).collect()
        };
        let (half_columns, half_rows) = (halved(&columns), halved(&rows));
        for plane in &mut next {
            let parts = split_mut(plane, &half_columns, &half_rows);
            next_parts.iter_mut().zip(parts).for_each(|(tile, part)| tile.push(part));
        }
        let finished = AtomicUsize::new(0);
        let steps = regions.len() * group.visited.len();
        let found: Vec<Vec<FoundKeypoint>> = regions
            .par_iter()
            .zip(next_parts)
            .map(|(region, next)| {
                let mut scratch = self.take_scratch();
                let found = self.tile(&job, region, next, &mut scratch, &|| {
                    progress(finished.fetch_add(1, Ordering::Relaxed) as f32 / steps as f32);
                })?;
                if let Ok(mut unused) = self.unused.lock() {
                    unused.push(scratch);
                }
                Ok(found)
            })
            .collect::<Result<_, Cancelled>>()?;
        // Made planes fill the gaps between known ones, so that planes and slopes are in step.
        let mut next = next.into_iter().map(Arc::new);
        let planes = of_next.filter_map(|index| known_next(index).or_else(|| next.next())).collect();
        Ok((found, FirstLevels { first_slope: group.visited.start, planes }))
    }
}

/// Smallest share of the samples of a feature's disc that are seen, in the frames that cover its place.
pub const MIN_SEEN: f32 = 0.8;
/// Part of the peak threshold that the first test uses: the refinement may add to a sample's value.
pub const FIRST_PEAK_PART: f32 = 0.8;
/// Part of the noise gate that a sample is compared with; the refined value is compared with the whole.
const FIRST_GATE_PART: f32 = 0.93;

/// Part of the noise gate that samples of a search with `params` are compared with. With the quadratic fit alone, as in
/// the published codes, it is the whole gate, and the refined value is not compared.
pub fn first_gate_part(params: &DetectorParams) -> f32 {
    match params.rules.localisation {
        Localisation::Quadratic => 1.0,
        Localisation::Continuous => FIRST_GATE_PART,
    }
}

/// Whether a search with `params` refines the extrema of `octave` by ascents.
pub fn ascends(params: &DetectorParams, octave: i32) -> bool {
    octave != params.first_octave && params.rules.localisation == Localisation::Continuous
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Makes {
    /// Samples of D, and the pixels from which the next octave starts.
    Samples,
    /// The pixels from which the next octave starts, alone.
    NextLevel,
    Nothing,
}

struct Octave<'a> {
    octave: i32,
    size: (usize, usize),
    group: &'a SlopeGroup,
    known: Option<&'a KnownSlopes<'a>>,
    /// Numbers of samples by slope of the grid, to which each tile adds its own.
    tallies: &'a Mutex<&'a mut [Tally]>,
    /// First level of the octave at the slopes that are visited; none for the first octave.
    bases: &'a FirstLevels,
    filters: OctaveFilters,
    /// Filters for the level alone from which the next octave starts, where not all slopes are searched everywhere.
    next_only: Option<OctaveFilters>,
    /// σ_D by DoG level index and slope of the grid, at the place of least noise.
    sigma_d: Vec<Vec<f32>>,
}

impl Search<'_> {
    /// Searches a tile. `next` holds its parts of the next octave's first level by unknown slope, or is empty.
    fn tile(
        &self,
        job: &Octave<'_>,
        region: &Region,
        next: Vec<Vec<&mut [f32]>>,
        scratch: &mut TileScratch,
        slope_done: &dyn Fn(),
    ) -> Result<Vec<FoundKeypoint>, Cancelled> {
        let held = region.widened(HELD, job.size);
        let inputs = job.filters.inputs(&held);
        let first = job.octave == self.space.first_octave;
        // Slopes that are stacked together: of whole rows of the grid if possible.
        let row = match self.grid.u.count {
            row @ 1..=STACKED_SLOPES => STACKED_SLOPES / row * row,
            _ => STACKED_SLOPES,
        };
        let mut together = 0..0;
        let (mut keypoints, mut tallies) = (Vec::new(), vec![Tally::default(); self.grid.len()]);
        let (wants_next, mut next) = (!next.is_empty(), next.into_iter());
        let is_known = |index: usize| job.known.is_some_and(|known| known.slopes[index].is_some());
        let SlopeGroup { own, visited } = job.group;
        scratch.window.begin(visited);
        let makes = self.makes(job, region);
        for (place, index) in visited.clone().enumerate() {
            self.monitor.check()?;
            let TileScratch { stacked, filter, next: level, window, .. } = &mut *scratch;
            if first && makes[index] != Makes::Nothing && index >= together.end {
                let row_end = index + row - place % row;
                let last = (index..row_end.min(visited.end)).rfind(|other| makes[*other] != Makes::Nothing);
                together = index..last.unwrap_or(index) + 1;
                stack_tiles(&self.planes, &self.offsets[together.clone()], job.octave, &inputs, stacked);
            }
            let pixels = || match first {
                true => Pixels::Stacked(&stacked[index - together.start]),
                false => Pixels::Level(job.bases.at(index)),
            };
            let thresholds = self.thresholds(job.octave, &job.sigma_d, index);
            let (dog, candidates) = window.slot_mut(index);
            // Rows are searched while they are still in the cache, as soon as the row below them is finished.
            let mut searched = region.rows.start;
            let mut search = |levels: &[Tile], finished: Range<usize>| {
                if !own.contains(&index) {
                    return;
                }
                let end = if finished.end == held.rows.end { region.rows.end } else { finished.end - 1 };
                let rows = searched..end.min(region.rows.end).max(searched);
                searched = rows.end;
                let part = Region { columns: region.columns.clone(), rows };
                for part in self.parts_searched(job.octave, part, index) {
                    own_slope_extrema(levels, &part, job.size, &thresholds, &mut tallies[index], candidates);
                }
            };
            let keep = wants_next.then_some(&mut *level);
            // The next octave reads whole planes, so a slope held but not searched here still gets its next level.
            match (makes[index], &job.next_only) {
                (Makes::Nothing, _) => window.leave_out(index),
                (Makes::NextLevel, Some(filters)) => {
                    dog_tile(filters, pixels(), region, filter, &mut DogTile::default(), keep, &mut |_, _| ());
                    window.leave_out(index);
                }
                _ => {
                    dog_tile(&job.filters, pixels(), &held, filter, dog, keep, &mut search);
                    self.compare(job, window, index, &mut tallies[index]);
                }
            }
            // Taken even where nothing is made, so that parts and slopes stay in step.
            let out = if is_known(index) { None } else { next.next() };
            if let Some(mut out) = out.filter(|_| makes[index] != Makes::Nothing) {
                let left = region.columns.start - level.region().columns.start;
                for (v, row) in out.iter_mut().enumerate() {
                    let from = &level.row(region.rows.start + 2 * v)[left..];
                    // As in SIFT, the next octave takes every second pixel without further smoothing.
                    row.iter_mut().zip(from.as_chunks::<2>().0).for_each(|(out, pair)| *out = pair[0]);
                }
            }
            for decided in window.decidable(index) {
                self.decide(job, window, decided, &mut keypoints, &mut tallies[decided]);
            }
            slope_done();
        }
        // Samples in blocks that do not search a slope are counted too, so that the tally covers the octave.
        let inner = |range: &Range<usize>, n: usize| range.end.min(n - 1).saturating_sub(range.start.max(1));
        let of_slope = inner(&region.columns, job.size.0) * inner(&region.rows, job.size.1) * self.space.levels;
        let mut of_all = job.tallies.lock().unwrap_or_else(PoisonError::into_inner);
        for index in own.clone().filter(|&index| !is_known(index)) {
            tallies[index].not_searched = of_slope as u64 - tallies[index].samples;
        }
        of_all.iter_mut().zip(&tallies).for_each(|(all, of_tile)| all.merge(of_tile));
        Ok(keypoints)
    }

    fn makes(&self, job: &Octave<'_>, region: &Region) -> Vec<Makes> {
        let Some(around) = &self.inputs.around else {
            let is_known = |index: usize| job.known.is_some_and(|known| known.slopes[index].is_some());
            let makes = |index: usize| if is_known(index) { Makes::Nothing } else { Makes::Samples };
            return (0..self.grid.len()).map(makes).collect();
        };
        let others = OtherSlopes::of(self.params);
        // If a candidate is compared with every slope, D of all slopes is needed everywhere.
        let all = others == OtherSlopes::Beaten(SlopeNeighbours::All);
        let searched = around.in_region(job.octave, region, others != OtherSlopes::Unseen);
        let makes = |(index, searched): (usize, bool)| match searched || all {
            true => Makes::Samples,
            false if job.next_only.is_some() && around.holds(index) => Makes::NextLevel,
            false => Makes::Nothing,
        };
        searched.into_iter().enumerate().map(makes).collect()
    }

    fn parts_searched(&self, octave: i32, region: Region, index: usize) -> Vec<Region> {
        if let Some(around) = &self.inputs.around { around.parts(octave, &region, index) } else { vec![region] }
    }

    /// Thresholds for a sample of `octave` at slope `slope_index`, where σ_D by level index and slope is `sigma_d`.
    pub(crate) fn thresholds(&self, octave: i32, sigma_d: &[Vec<f32>], slope_index: usize) -> Thresholds {
        let first_part = first_gate_part(self.params);
        Thresholds {
            peak: FIRST_PEAK_PART * self.params.peak_threshold,
            scale_ease: scale_ease(ascends(self.params, octave)),
            gate: sigma_d.iter().map(|by_slope| first_part * self.inputs.gate_factor * by_slope[slope_index]).collect(),
        }
    }

    /// Whether a sample whose noise is `sigma_d` passes the noise gate's first test.
    pub(crate) fn passes_gate(&self, candidate: &Candidate, sigma_d: f32) -> bool {
        candidate.value.abs() >= first_gate_part(self.params) * (self.inputs.gate_factor * sigma_d)
    }

    pub(crate) fn limits(&self, sigma_d: f32) -> Limits {
        Limits {
            // With the quadratic fit alone the whole gate was applied to the sample, and the refined value is free.
            gate: if first_gate_part(self.params) < 1.0 { self.inputs.gate_factor * sigma_d } else { 0.0 },
            peak_threshold: self.params.peak_threshold,
            edge_threshold: self.params.edge_threshold,
        }
    }

    /// Compares the slope that was computed last with the others that are held.
    fn compare(&self, job: &Octave<'_>, window: &mut SlopeWindow, made: usize, tally: &mut Tally) {
        let first = ascends(self.params, job.octave).then(|| self.first_level(PixelView::of(job.bases.at(made))));
        let sigma_d_at = |candidate: &Candidate| {
            job.sigma_d[candidate.level_index][made] * self.place_factor(job.octave, made, candidate.x, candidate.y)
        };
        let refined = |dog: &DogTile, candidate: &Candidate| {
            self.refined((dog, first.as_ref()), candidate, (job.octave, job.size), made, sigma_d_at(candidate))
        };
        let passes = |candidate: &Candidate| self.passes_gate(candidate, sigma_d_at(candidate));
        window.compare(made, passes, refined, tally);
    }

    /// Refines a candidate at slope `slope_index` with noise `sigma_d`, and applies the tests that follow, masks last.
    pub(crate) fn refined(
        &self,
        samples: (&DogTile, Option<&FirstLevel<'_>>),
        candidate: &Candidate,
        (octave, size): (i32, (usize, usize)),
        slope_index: usize,
        sigma_d: f32,
    ) -> Result<Fit, Test> {
        let Candidate { x, y, level_index, .. } = *candidate;
        let fit = refine(samples, (x, y), level_index, size, self.limits(sigma_d))?;
        // Only place and σ are read here, so any slope does.
        let (u, v, sigma) = self.keypoint(octave, candidate, &fit, (slope_index, Slope::default()), sigma_d).in_image();
        let seen = self.inputs.seen_share(&self.offsets[slope_index], (u, v), sigma);
        if seen.is_some_and(|seen| seen < MIN_SEEN) { Err(Test::Seen) } else { Ok(fit) }
    }

    /// Source of exact values of D in an octave after the first, whose first level is `pixels`.
    pub(crate) fn first_level<'p>(&'p self, pixels: PixelView<'p>) -> FirstLevel<'p> {
        FirstLevel { pixels, sigma: SIGMA_BASE, space: self.space }
    }

    /// Appends the keypoints among the unbeaten candidates of one slope, and counts the others.
    fn decide(
        &self,
        job: &Octave<'_>,
        window: &SlopeWindow,
        slope_index: usize,
        keypoints: &mut Vec<FoundKeypoint>,
        tally: &mut Tally,
    ) {
        for undecided in window.undecided(slope_index) {
            match undecided.refined {
                Err(test) => tally.reject(test, 1),
                Ok(fit) => {
                    let candidate = &undecided.candidate;
                    let place_factor = self.place_factor(job.octave, slope_index, candidate.x, candidate.y);
                    let sigma_d = job.sigma_d[candidate.level_index][slope_index] * place_factor;
                    let slope = window.refined_slope(slope_index, undecided);
                    let keypoint = self.keypoint(job.octave, candidate, &fit, (slope_index, slope), sigma_d);
                    let (sample_value, edge_quotient) = (candidate.value, fit.edge_quotient());
                    keypoints.push((keypoint, Evidence { sample_value, place_factor, edge_quotient }));
                }
            }
        }
    }

    pub(crate) fn keypoint(
        &self,
        octave: i32,
        candidate: &Candidate,
        fit: &Fit,
        (slope_index, slope): (usize, Slope),
        sigma_d: f32,
    ) -> Keypoint {
        let (x, y) = fit.place();
        let (x, y, value, snr) = (x as f32, y as f32, fit.value as f32, f32::INFINITY);
        // Index 0 is level −1.
        let sigma_octave = self.space.sigma_octave(fit.level_refined - 1.0) as f32;
        let (level, sample) = (candidate.level_index as i32 - 1, [candidate.x as u32, candidate.y as u32]);
        let found = Keypoint { octave, x, y, sigma_octave, level, sample, slope_index, slope, value, snr };
        found.with_noise(sigma_d)
    }

    pub(crate) fn place_factor(&self, octave: i32, slope_index: usize, x: usize, y: usize) -> f32 {
        self.inputs.place_factor(octave, &self.offsets[slope_index], (x, y))
    }
}
