//! The whole detector: octave by octave, strip by strip, slope by slope.
//!
//! Octaves come in turn, each starting from planes that the one before left for every slope. Within an octave the strips of rows run in parallel; a
//! strip visits all slopes in order, holding only those that its undecided candidates still need. The strip's height is chosen so that
//! what it holds stays within [`WINDOW_BYTES`] per thread. Strips return their keypoints in order, so threads cannot change the result.

use super::describing::{Describing, Keypoint};
use super::feature::{Descriptor, Detection, Feature, StageTimes, Tally, Test};
use super::motion::{FrameOffset, coverage, frame_offsets};
use super::noise::{dog_noise_variance, frame_noise, gate_factor};
use super::octave::{Base, StripScratch, widened};
use super::params::{DetectorParams, ParamError};
use super::refine::{Limits, MAX_MOVES, refine};
use super::scale_space::{ScaleSpace, octave_pixel, octave_size};
use super::search::{Thresholds, own_slope_extrema};
use super::slope_grid::SlopeGrid;
use super::slope_window::{SlopeWindow, capacity};
use super::view::searched_octaves;
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Bytes of DoG strips that one thread's window of slopes may hold (at least eight rows are held, whatever that takes).
pub const WINDOW_BYTES: usize = 32 << 20;
/// Rows of a strip where memory does not ask for fewer: enough that the rows its blurs need around it do not matter.
const MAX_STRIP_ROWS: usize = 128;

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
    params: &'a DetectorParams,
    frame_noise: f32,
    gate_factor: f32,
    monitor: &'a Monitor,
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
    let search = Search {
        frames: &frames,
        size_image: burst.size(),
        grid,
        offsets: grid.slopes().map(|slope| frame_offsets(frames.len(), slope, params.interpolation)).collect(),
        space: ScaleSpace::of(params),
        params,
        frame_noise: noise,
        gate_factor: gate_factor(params),
        monitor,
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
        let (keypoints, next_bases) = search.octave(octave, &bases, octave + 1 < octaves.end, &mut tally, &progress)?;
        times.search_secs += searching.elapsed().as_secs_f32();
        let started = Instant::now();
        monitor.report(Stage::Describe, done + share * 0.95);
        let finer = |slope_index: usize| search.base(octave - 1, &finer_bases, slope_index);
        let describing = Describing {
            base: &|slope_index| search.base(octave, &bases, slope_index),
            finer: (octave > octaves.start).then_some(&finer as _),
            offsets: &search.offsets,
            octave,
            size: octave_size(burst.size(), octave),
            size_image: burst.size(),
            grid,
            space: &search.space,
            params,
            monitor,
        };
        found.extend(describing.describe(&keypoints)?);
        times.describe_secs += started.elapsed().as_secs_f32();
        finer_bases = std::mem::replace(&mut bases, next_bases);
        done += share;
    }
    monitor.check()?;
    found.sort_by(|(a, _), (b, _)| {
        b.strength().total_cmp(&a.strength()).then(a.v.total_cmp(&b.v)).then(a.u.total_cmp(&b.u))
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
            Base::Frames { frames: self.frames, offsets: &self.offsets[slope_index], octave }
        } else {
            Base::Level(&bases[slope_index])
        }
    }

    /// σ_D at `octave` and DoG level index `level_index` for each slope.
    fn sigma_d(&self, octave: i32, level_index: usize) -> Vec<f32> {
        let sigma = |offsets: &Vec<FrameOffset>| {
            self.frame_noise * dog_noise_variance(&self.space, octave, level_index as f64 - 1.0, offsets).sqrt() as f32
        };
        self.offsets.iter().map(sigma).collect()
    }

    /// Rows of a strip of an octave `width` pixels wide; even, so that the next octave's rows split with the strips.
    fn strip_rows(&self, width: usize) -> usize {
        let slopes = capacity(&self.grid, self.params.slope_neighbours);
        let row_bytes = slopes * (self.space.levels + 2) * width * size_of::<f32>();
        let rows = (WINDOW_BYTES / row_bytes.max(1)).saturating_sub(2 * (MAX_MOVES + 1));
        (rows.clamp(8, MAX_STRIP_ROWS) / 2) * 2
    }

    /// Searches one octave. Returns its keypoints, in order of strips, and the first levels of the next octave, one a slope, if asked for.
    fn octave(
        &self,
        octave: i32,
        bases: &[Plane],
        wants_next: bool,
        tally: &mut Tally,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<(Vec<Keypoint>, Vec<Plane>), Cancelled> {
        let (width, height) = octave_size(self.size_image, octave);
        let strip_rows = self.strip_rows(width);
        let sigma_d: Vec<Vec<f32>> =
            (0..self.space.levels + 2).map(|level_index| self.sigma_d(octave, level_index)).collect();
        let (next_width, next_height) = (width / 2, height / 2);
        let mut next: Vec<Plane> = if wants_next {
            (0..self.grid.len()).map(|_| Plane::zeros(next_width, next_height)).collect()
        } else {
            Vec::new()
        };
        let strips: Vec<Range<usize>> =
            (0..height).step_by(strip_rows).map(|start| start..(start + strip_rows).min(height)).collect();
        // For each strip, its rows of the next octave's planes.
        let mut next_rows: Vec<Vec<&mut [f32]>> = strips.iter().map(|_| Vec::new()).collect();
        for plane in &mut next {
            let mut rest = plane.data_mut();
            for (strip, rows) in strips.iter().zip(&mut next_rows) {
                let count = strip.end / 2 - strip.start / 2;
                let (mine, others) = rest.split_at_mut((count * next_width).min(rest.len()));
                rows.push(mine);
                rest = others;
            }
        }
        let finished = AtomicUsize::new(0);
        let steps = strips.len() * self.grid.len();
        let results: Vec<(Vec<Keypoint>, Tally)> = strips
            .par_iter()
            .zip(next_rows)
            .map_init(
                || (StripScratch::default(), SlopeWindow::new(self.grid, self.params.slope_neighbours)),
                |(scratch, window), (strip, next_rows)| {
                    let job = Strip { octave, size: (width, height), bases, sigma_d: &sigma_d, rows: strip.clone() };
                    self.strip(&job, next_rows, scratch, window, &|| {
                        progress(0.95 * finished.fetch_add(1, Ordering::Relaxed) as f32 / steps as f32);
                    })
                },
            )
            .collect::<Result<_, Cancelled>>()?;
        let mut keypoints = Vec::new();
        for (strip_keypoints, strip_tally) in results {
            keypoints.extend(strip_keypoints);
            tally.merge(&strip_tally);
        }
        Ok((keypoints, next))
    }

    /// Searches one strip over all slopes.
    fn strip(
        &self,
        job: &Strip<'_>,
        mut next_rows: Vec<&mut [f32]>,
        scratch: &mut StripScratch,
        window: &mut SlopeWindow,
        slope_done: &dyn Fn(),
    ) -> Result<(Vec<Keypoint>, Tally), Cancelled> {
        let (width, height) = job.size;
        let next_width = width / 2;
        let held = widened(&job.rows, MAX_MOVES + 1, height);
        let (mut keypoints, mut tally) = (Vec::new(), Tally::default());
        for index in 0..self.grid.len() {
            self.monitor.check()?;
            let (dog, candidates) = window.slot_mut(index);
            let top = self.base(job.octave, job.bases, index).dog_strip(&self.space, job.size, &held, scratch, dog);
            if let Some(out) = next_rows.get_mut(index) {
                for (v, row) in out.chunks_mut(next_width.max(1)).enumerate() {
                    let from = top.row(job.rows.start + 2 * v);
                    row.iter_mut().zip(from.chunks(2)).for_each(|(out, pair)| *out = pair[0]);
                }
            }
            let thresholds = Thresholds {
                peak: 0.8 * self.params.peak_threshold,
                gate: job.sigma_d.iter().map(|by_slope| self.gate_factor * by_slope[index]).collect(),
            };
            own_slope_extrema(dog, &job.rows, job.size, &thresholds, &mut tally, candidates);
            for decided in window.decidable(index) {
                self.decide(job, window, decided, &mut keypoints, &mut tally);
            }
            slope_done();
        }
        Ok((keypoints, tally))
    }

    /// Puts the candidates of one slope through the tests that remain.
    fn decide(
        &self,
        job: &Strip<'_>,
        window: &SlopeWindow,
        slope_index: usize,
        keypoints: &mut Vec<Keypoint>,
        tally: &mut Tally,
    ) {
        let limits = Limits { peak_threshold: self.params.peak_threshold, edge_threshold: self.params.edge_threshold };
        for candidate in window.candidates(slope_index) {
            // Where fewer frames cover a place the mean is noisier, by the square root.
            let sigma_d = job.sigma_d[candidate.level_index][slope_index]
                * self.coverage_factor(job.octave, slope_index, candidate.x, candidate.y);
            if candidate.value.abs() < self.gate_factor * sigma_d {
                tally.reject(Test::NoiseGate, 1);
                continue;
            }
            if !window.is_slope_extremum(slope_index, candidate) {
                tally.reject(Test::SlopeExtremum, 1);
                continue;
            }
            let at = (candidate.x, candidate.y);
            match refine(window.strip(slope_index), at, candidate.level_index, job.size, limits) {
                Err(test) => tally.reject(test, 1),
                Ok(refined) => {
                    tally.kept += 1;
                    let slope = window.refined_slope(slope_index, refined.x, refined.y, candidate.level_index);
                    keypoints.push(Keypoint {
                        x: refined.x_refined as f32,
                        y: refined.y_refined as f32,
                        sigma_octave: self.space.sigma_octave(refined.level_refined - 1.0) as f32,
                        level: candidate.level_index as i32 - 1,
                        slope_index,
                        slope,
                        value: refined.value,
                        snr: if sigma_d > 0.0 { refined.value.abs() / sigma_d } else { f32::INFINITY },
                    });
                }
            }
        }
    }

    /// √(N / frames that cover the octave pixel (x, y) at the slope).
    fn coverage_factor(&self, octave: i32, slope_index: usize, x: usize, y: usize) -> f32 {
        let pixel = octave_pixel(octave);
        let to_image = |at: usize, n: usize| ((at as f32 * pixel) as usize).min(n - 1);
        let at = (to_image(x, self.size_image.0), to_image(y, self.size_image.1));
        let covering = coverage(&self.offsets[slope_index], at.0, at.1, self.size_image);
        (self.frames.len() as f32 / covering.max(1) as f32).sqrt()
    }
}

/// One strip's share of an octave.
struct Strip<'a> {
    octave: i32,
    /// The octave's size.
    size: (usize, usize),
    bases: &'a [Plane],
    /// σ_D by DoG level index and slope.
    sigma_d: &'a [Vec<f32>],
    rows: Range<usize>,
}
