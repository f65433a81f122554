//! The whole detector: its steps in order, from a burst to features.
//!
//! The inputs give the frames that take part and their noise; the [search](crate::detector::search) goes through
//! octaves, tiles and slopes and finds keypoints. Then features are chosen: of the keypoints on one blob the
//! strongest stays; those that stay are localised and described, tested for their
//! [coherence](crate::detector::coherence) if requested, and ranked. The data for explaining the detection is gathered
//! in a [`Trail`], which judges single samples ([`Judgement`]).

mod choice;
mod judgement;
mod left;
#[cfg(test)]
mod tests;
mod trail;

pub use crate::detector::search::FIRST_PEAK_PART;
pub use judgement::{Judgement, Neighbourhood, Sample, compared_slopes};
pub use left::follows;
pub use trail::Trail;

use super::feature::{DetectError, Detection, Keypoint, StageTimes, Tally};
use super::memory::{self, Account, OF_PROCESS, Plan};
use super::params::DetectorParams;
use crate::burst::Burst;
use crate::detector::describe::patch::{Describing, FramesOfOctaves};
use crate::detector::describe::{self, Described};
use crate::detector::limit::Limit;
use crate::detector::params::DescribeSlope;
use crate::detector::pipeline::choice::{Choice, Choosing};
use crate::detector::pipeline::left::{Left, Passing, sigma_d};
use crate::detector::scale_space::octave_size;
use crate::detector::search::SEARCH_PART;
use crate::detector::search::setup::{FirstLevels, Inputs, Search, SlopeGroup};
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Finds the features of a burst whose frames are merged already, where the method merges them; callers use
/// [`crate::detect`].
///
/// # Errors
/// [`DetectError::Param`] for parameters that make no sense for the burst, [`DetectError::Cancelled`] once `monitor`
/// was cancelled.
pub(crate) fn search(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Detection, DetectError> {
    Ok(search_all(burst, params, (&OF_PROCESS, memory::budget()), false, monitor)?.detection)
}

/// Finds the features of a burst and keeps the data that explains them: the coarser octaves, if there is memory for
/// them, and the keypoints that were removed.
///
/// # Errors
/// As [`search`].
pub(crate) fn search_with_trail(
    burst: &Burst,
    params: &DetectorParams,
    monitor: &Monitor,
) -> Result<Trail, DetectError> {
    // Trails that are kept already have their part of the budget.
    let budget = memory::budget().map(|bytes| bytes.saturating_sub(memory::kept_bytes()));
    Ok(search_all(burst, params, (&OF_PROCESS, budget), true, monitor)?.ready())
}

/// Detects with a trail, within the part of `budget` bytes that other searches of `account` leave. If the trail `keeps`
/// what is computed about single keypoints, it can be judged again.
fn search_all(
    burst: &Burst,
    params: &DetectorParams,
    (account, budget): (&Account, Option<u64>),
    keeps: bool,
    monitor: &Monitor,
) -> Result<Trail, DetectError> {
    let started = Instant::now();
    params.validate_for(burst.len(), burst.size())?;
    let frames = params.used_frames(burst.len()).len();
    let (plan, _share) = account.plan(params, frames, burst.size(), budget)?;
    plan.run(|| search_as_planned(burst, params, (&plan, keeps), (started, monitor)))
}

/// Detects by `plan`, with parameters that are valid for the burst; `started` is the time of the start.
fn search_as_planned(
    burst: &Burst,
    params: &DetectorParams,
    (plan, keeps): (&Plan, bool),
    (started, monitor): (Instant, &Monitor),
) -> Result<Trail, DetectError> {
    let inputs = Inputs::new(burst, params, monitor)?;
    let mut times = StageTimes { noise_secs: started.elapsed().as_secs_f32(), ..StageTimes::default() };

    let planes = inputs.planes();
    let search = Search::new(&inputs, &planes, monitor);
    let octaves = inputs.octaves();
    let mut tally = Tally::default();
    let started = Instant::now();
    let searched = search.octaves(&octaves, &plan.search, &mut tally)?;
    times.search_secs = started.elapsed().as_secs_f32();
    let left = Left::new(&search, searched, &plan.describe, tally, keeps);
    let octave_frames = FramesOfOctaves::new(&planes, &inputs.times, octaves);
    let chosen = chosen(&search, &inputs, (&left, None), &octave_frames, times)?;
    drop(octave_frames);
    drop(planes);
    Ok(Trail::new(inputs, Arc::new(left), None, chosen))
}

/// Chooses the features among the keypoints that a search `left`, or those of them that pass other thresholds. `times`
/// are those of the steps before.
fn chosen(
    search: &Search<'_>,
    inputs: &Inputs,
    (left, passing): (&Left, Option<&Passing>),
    frames: &FramesOfOctaves<'_>,
    mut times: StageTimes,
) -> Result<(Choice, Detection), Cancelled> {
    let started = Instant::now();
    let keypoints = passing.map_or(&left.keypoints[..], |passing| &passing.keypoints);
    let numbers = passing.map(|passing| &passing.numbers[..]);
    let choosing = Choosing { search, inputs, keypoints, numbers, left, frames };
    let mut choice = choosing.choose(search.params.max_features)?;
    let mut tally = passing.map_or(left.tally, |passing| passing.tally);
    choice.count(&mut tally);
    choosing.mark(&mut choice.found)?;
    times.search_secs += choice.distinct_secs;
    times.describe_secs = started.elapsed().as_secs_f32() - choice.distinct_secs;
    search.monitor.report(Stage::Describe, 1.0);
    let (features, descriptors) = choice.found.iter().map(|one| (one.feature, one.descriptor)).unzip();
    let detection = Detection {
        features,
        descriptors,
        tally,
        frame_noise: inputs.noise.frame_noise,
        noise_gate_factor: search.gate_factor,
        noise: inputs.noise.clone(),
        slopes: inputs.params.used_slopes(),
        frames_used: inputs.frames_used.clone(),
        octaves: inputs.octaves(),
        times,
    };
    Ok((choice, detection))
}

impl Trail {
    /// Trail of a search of the same burst with `params`, without that search; `None` where it needs one. That is so
    /// unless the parameters differ only in noise gate, peak threshold, edge threshold, the rule for distinct keypoints
    /// and the number of features, and unless the first three are at least as strict as those of the search
    /// that this trail goes back to.
    ///
    /// Keypoints, features and descriptors are those of the search to the bit. In the tally, samples that are no
    /// keypoints are counted as that earlier search rejected them.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` was cancelled.
    pub fn rejudged(&self, params: &DetectorParams, monitor: &Monitor) -> Result<Option<Self>, Cancelled> {
        if !follows(params, self.left.params()) {
            return Ok(None);
        }
        let started = Instant::now();
        let inputs = Inputs { params: params.clone(), ..self.inputs.clone() };
        let planes = inputs.planes();
        let search = Search::new(&inputs, &planes, monitor);
        let Some(passing) = self.left.passing(&search, &sigma_d(&search)) else { return Ok(None) };
        let frames = FramesOfOctaves::new(&planes, &inputs.times, inputs.octaves()).with_means(&self.left.means);
        let times = StageTimes { search_secs: started.elapsed().as_secs_f32(), ..StageTimes::default() };
        let chosen = chosen(&search, &inputs, (&self.left, Some(&passing)), &frames, times)?;
        drop(frames);
        drop(planes);
        let mut judged = Self::new(inputs, self.left.clone(), Some(passing), chosen).ready();
        judged.search_secs = self.search_secs;
        Ok(Some(judged))
    }
}

impl Search<'_> {
    /// Inputs for marking the features at the limit of the slopes.
    fn limit<'a, 'f>(&'a self, frames: &'a FramesOfOctaves<'f>) -> Limit<'a, 'f> {
        Limit {
            grid: self.grid,
            frames,
            times: self.times,
            size_image: self.size_image,
            space: &self.space,
            interpolation: self.params.rules.interpolation,
            monitor: self.monitor,
        }
    }

    /// Localises and describes `keypoints`, which are in order of octaves. The first levels are taken from `bases`;
    /// where they were not kept, they are computed again for one of the `groups` of slopes after the other. `part` is
    /// the part of the description's progress that this takes.
    fn describe(
        &self,
        octaves: &Range<i32>,
        keypoints: &[Keypoint],
        (bases, groups): (Option<&[FirstLevels]>, &[SlopeGroup]),
        frames: &FramesOfOctaves<'_>,
        part: Range<f32>,
    ) -> Result<Vec<Described>, Cancelled> {
        let report = |done: f32| self.monitor.report(Stage::Describe, SEARCH_PART + (1.0 - SEARCH_PART) * done);
        let finished = AtomicUsize::new(0);
        let described = |count: usize| {
            let done = (finished.fetch_add(count, Ordering::Relaxed) + count) as f32 / keypoints.len() as f32;
            report(part.start + (part.end - part.start) * done);
        };
        report(part.start);
        if let Some(bases) = bases {
            return self.describe_with(octaves, keypoints, bases, (frames, &described));
        }
        let mut found = Vec::with_capacity(keypoints.len() + keypoints.len() / 2);
        for group in groups {
            let numbers: Vec<usize> =
                (0..keypoints.len()).filter(|&number| group.own.contains(&keypoints[number].slope_index)).collect();
            let of_group: Vec<Keypoint> = numbers.iter().map(|&number| keypoints[number]).collect();
            let Some(last) = of_group.last().map(|keypoint| keypoint.octave) else { continue };
            let bases = self.first_levels(octaves.start..last + 1, &group.visited)?;
            let features = self.describe_with(octaves, &of_group, &bases, (frames, &described))?;
            found.extend(features.into_iter().map(|one| Described { keypoint: numbers[one.keypoint], ..one }));
        }
        Ok(found)
    }

    /// First levels of each octave at consecutive slopes; none for the first octave.
    fn first_levels(&self, octaves: Range<i32>, slopes: &Range<usize>) -> Result<Vec<FirstLevels>, Cancelled> {
        let mut planes: Vec<Vec<Plane>> = octaves.clone().map(|_| Vec::new()).collect();
        for slope_index in slopes.clone() {
            let of_slope = self.stack(slope_index).first_levels(octaves.end - 1, self.monitor)?;
            planes[1..].iter_mut().zip(of_slope).for_each(|(planes, plane)| planes.push(plane));
        }
        Ok(planes.into_iter().map(|planes| FirstLevels::new(slopes.start, planes)).collect())
    }

    /// Localises and describes `keypoints` with the first levels `bases`; `described` is called with the number of
    /// further keypoints that are finished.
    fn describe_with(
        &self,
        octaves: &Range<i32>,
        keypoints: &[Keypoint],
        bases: &[FirstLevels],
        (frames, described): (&FramesOfOctaves<'_>, &(dyn Fn(usize) + Sync)),
    ) -> Result<Vec<Described>, Cancelled> {
        let mut found = Vec::with_capacity(keypoints.len() + keypoints.len() / 2);
        let of_octave = |octave: i32| &bases[(octave - octaves.start) as usize];
        let mut first = 0;
        for in_octave in keypoints.chunk_by(|a, b| a.octave == b.octave) {
            let octave = in_octave[0].octave;
            let base = |slope_index: usize| self.base(octave, of_octave(octave), slope_index);
            let finer = |slope_index: usize| self.base(octave - 1, of_octave(octave - 1), slope_index);
            let own_slopes = self.describes_own_slopes(octave).then(|| {
                frames.make(in_octave.iter());
                frames.of(octave)
            });
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
                described,
            };
            found.extend(describing.describe(in_octave, first)?);
            first += in_octave.len();
        }
        Ok(found)
    }

    /// Whether features of `octave` are described at their own slopes: the octave is fine enough to show the
    /// difference.
    fn describes_own_slopes(&self, octave: i32) -> bool {
        let step = [self.grid.u.step(), self.grid.v.step()].into_iter().fold(0.0, f32::max);
        let outermost_px = step * 0.5 * (self.times.frame_count as f32 - 1.0);
        self.params.rules.describe_slope == DescribeSlope::Refined
            && describe::misaligned(outermost_px, self.space.sigma_image(octave, 0.0) as f32)
    }
}
