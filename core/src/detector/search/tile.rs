//! Search of one tile over its slopes, up to the decision on its candidates.

use super::setup::{HELD, Search, TileScratch};
use crate::detector::feature::Tally;
use crate::detector::keypoint::Keypoint;
use crate::detector::noise_model::NoiseModel;
use crate::detector::params::slope_grid::Slope;
use crate::detector::refine::{Limits, Refined, refine};
use crate::detector::scale_space::levels::octave_pixel;
use crate::detector::scale_space::octave::{OctaveFilters, Pixels, dog_tile, stack_tiles};
use crate::detector::search::extrema::{Candidate, Thresholds, own_slope_extrema};
use crate::detector::search::groups::{FirstLevels, SlopeGroup};
use crate::detector::search::slope_window::SlopeWindow;
use crate::detector::stack::offsets::coverage;
use crate::kernel::stack::FrameOffset;
use crate::monitor::Cancelled;
use crate::plane::tile::{Region, Tile};
use std::ops::Range;

/// Part of the peak threshold that the first test uses: the refinement may add to a sample's value.
pub const FIRST_PEAK_PART: f32 = 0.8;

/// Data that the tiles of an octave share.
pub(crate) struct Octave<'a> {
    pub(crate) octave: i32,
    /// Size (columns, rows) of the octave.
    pub(crate) size: (usize, usize),
    /// Slopes that are searched, and those that are visited for that.
    pub(crate) group: &'a SlopeGroup,
    /// First level of the octave at the slopes that are visited; none for the first octave.
    pub(crate) bases: &'a FirstLevels,
    pub(crate) filters: OctaveFilters,
    /// σ_D by DoG level index and slope of the grid, at the place of least noise.
    pub(crate) sigma_d: Vec<Vec<f32>>,
}

impl Search<'_> {
    /// Searches one tile over the slopes of a group. `next` holds the tile's parts of the next octave's first level,
    /// one for each slope that is visited, or is empty.
    pub(crate) fn tile(
        &self,
        job: &Octave<'_>,
        region: &Region,
        mut next: Vec<Vec<&mut [f32]>>,
        scratch: &mut TileScratch,
        slope_done: &dyn Fn(),
    ) -> Result<(Vec<Keypoint>, Tally), Cancelled> {
        let held = region.widened(HELD, job.size);
        let inputs = job.filters.inputs(&held);
        let first = job.octave == self.space.first_octave;
        let together = self.slopes_together();
        let (mut keypoints, mut tally) = (Vec::new(), Tally::default());
        let SlopeGroup { own, visited } = job.group;
        scratch.window.begin(visited);
        for (place, index) in visited.clone().enumerate() {
            self.monitor.check()?;
            let TileScratch { stacked, filter, next: level, window, .. } = &mut *scratch;
            if first && place % together == 0 {
                let slopes = &self.offsets[index..(index + together).min(visited.end)];
                stack_tiles(self.frames, slopes, job.octave, &inputs, stacked);
            }
            let pixels =
                if first { Pixels::Stacked(&stacked[place % together]) } else { Pixels::Level(job.bases.at(index)) };
            let thresholds = self.thresholds(&job.sigma_d, index);
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
                own_slope_extrema(levels, &part, job.size, &thresholds, &mut tally, candidates);
            };
            let keep = (!next.is_empty()).then_some(&mut *level);
            dog_tile(&job.filters, pixels, &held, filter, dog, keep, &mut search);
            if let Some(out) = next.get_mut(place) {
                let left = region.columns.start - held.columns.start;
                for (v, row) in out.iter_mut().enumerate() {
                    let from = &level.row(region.rows.start + 2 * v)[left..];
                    row.iter_mut().zip(from.chunks(2)).for_each(|(out, pair)| *out = pair[0]);
                }
            }
            self.compare(job, window, index, &mut tally);
            for decided in window.decidable(index) {
                self.decide(job, window, decided, &mut keypoints, &mut tally);
            }
            slope_done();
        }
        Ok((keypoints, tally))
    }

    /// Thresholds for a sample at slope `slope_index`, where σ_D by level index and slope is `sigma_d`.
    pub(crate) fn thresholds(&self, sigma_d: &[Vec<f32>], slope_index: usize) -> Thresholds {
        Thresholds {
            peak: FIRST_PEAK_PART * self.params.peak_threshold,
            gate: sigma_d.iter().map(|by_slope| self.gate_factor * by_slope[slope_index]).collect(),
        }
    }

    /// σ_D of a candidate, for the noise at its place and the number of frames that cover it.
    fn sigma_d_at(&self, job: &Octave<'_>, slope_index: usize, candidate: &Candidate) -> f32 {
        job.sigma_d[candidate.level_index][slope_index]
            * self.place_factor(job.octave, slope_index, candidate.x, candidate.y)
    }

    /// Whether a candidate whose noise is `sigma_d` passes the noise gate.
    pub(crate) fn passes_gate(&self, candidate: &Candidate, sigma_d: f32) -> bool {
        candidate.value.abs() >= self.gate_factor * sigma_d
    }

    /// Limits for a refined candidate.
    pub(crate) fn limits(&self) -> Limits {
        Limits { peak_threshold: self.params.peak_threshold, edge_threshold: self.params.edge_threshold }
    }

    /// Compares the slope that was computed last with the others that are held.
    fn compare(&self, job: &Octave<'_>, window: &mut SlopeWindow, made: usize, tally: &mut Tally) {
        window.compare(
            made,
            |candidate| self.passes_gate(candidate, self.sigma_d_at(job, made, candidate)),
            |dog, candidate| refine(dog, (candidate.x, candidate.y), candidate.level_index, job.size, self.limits()),
            tally,
        );
    }

    /// Appends the keypoints among the unbeaten candidates of one slope, and counts the others.
    fn decide(
        &self,
        job: &Octave<'_>,
        window: &SlopeWindow,
        slope_index: usize,
        keypoints: &mut Vec<Keypoint>,
        tally: &mut Tally,
    ) {
        for undecided in window.undecided(slope_index) {
            match undecided.refined {
                Err(test) => tally.reject(test, 1),
                Ok(refined) => {
                    let candidate = &undecided.candidate;
                    let sigma_d = self.sigma_d_at(job, slope_index, candidate);
                    let slope = window.refined_slope(slope_index, undecided);
                    keypoints.push(self.keypoint(job.octave, candidate, &refined, (slope_index, slope), sigma_d));
                }
            }
        }
    }

    /// Keypoint of a refined candidate whose noise is `sigma_d`.
    pub(crate) fn keypoint(
        &self,
        octave: i32,
        candidate: &Candidate,
        refined: &Refined,
        (slope_index, slope): (usize, Slope),
        sigma_d: f32,
    ) -> Keypoint {
        Keypoint {
            octave,
            x: refined.x_refined as f32,
            y: refined.y_refined as f32,
            sigma_octave: self.space.sigma_octave(refined.level_refined - 1.0) as f32,
            level: candidate.level_index as i32 - 1,
            sample: [candidate.x as u32, candidate.y as u32],
            slope_index,
            slope,
            value: refined.value,
            snr: if sigma_d > 0.0 { refined.value.abs() / sigma_d } else { f32::INFINITY },
        }
    }

    /// See [`place_factor`], at one of the grid's slopes.
    pub(crate) fn place_factor(&self, octave: i32, slope_index: usize, x: usize, y: usize) -> f32 {
        place_factor(self.noise, octave, &self.offsets[slope_index], (x, y), self.size_image)
    }
}

/// √(N / number of frames that cover the octave pixel (x, y) in the stack whose frames are read at `offsets`), times
/// the ratio of the noise there to its smallest value.
pub(crate) fn place_factor(
    noise: &NoiseModel,
    octave: i32,
    offsets: &[FrameOffset],
    (x, y): (usize, usize),
    size_image: (usize, usize),
) -> f32 {
    let pixel = octave_pixel(octave);
    let to_image = |at: usize, n: usize| ((at as f32 * pixel) as usize).min(n - 1);
    let at = (to_image(x, size_image.0), to_image(y, size_image.1));
    let covering = coverage(offsets, at.0, at.1, size_image);
    (offsets.len() as f32 / covering.max(1) as f32).sqrt() * noise.place_factor(octave, offsets, at, size_image)
}
