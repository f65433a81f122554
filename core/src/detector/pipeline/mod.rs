//! The whole detector: its steps in order, from a burst to features.
//!
//! The inputs give the frames that take part and their noise; the [search](crate::detector::search) goes through
//! octaves, tiles and slopes and finds keypoints; `finish` keeps one keypoint for one blob, localises and describes
//! those that stay. Here the features are ranked, and the data for explaining the detection is gathered in a [`Trail`],
//! which judges single samples ([`Judgement`]).

mod finish;
mod judge;
#[cfg(test)]
mod tests;
mod trail;

pub use crate::detector::search::tile::FIRST_PEAK_PART;
pub use judge::{Judgement, Neighbourhood, Sample, strongest_around};
pub use trail::Trail;

use super::error::DetectError;
use super::feature::{Detection, StageTimes, Tally, Test};
use super::keypoint::Keypoint;
use super::memory::{self, Account, OF_PROCESS, Plan};
use super::params::DetectorParams;
use crate::burst::Burst;
use crate::detector::describe::Described;
use crate::detector::describe::two_motions::FramesOfOctaves;
use crate::detector::search::inputs::Inputs;
use crate::detector::search::octaves::Searched;
use crate::detector::search::setup::Search;
use crate::monitor::{Monitor, Stage};
use std::time::Instant;

/// Finds the features of a burst whose frames are merged already, where the method merges them; callers use
/// [`crate::detect`].
///
/// # Errors
/// [`DetectError::Param`] for parameters that make no sense for the burst, [`DetectError::Cancelled`] once `monitor`
/// was cancelled.
pub(crate) fn search(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Detection, DetectError> {
    Ok(search_all(burst, params, (&OF_PROCESS, memory::budget()), monitor)?.detection)
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
    Ok(search_all(burst, params, (&OF_PROCESS, budget), monitor)?.ready())
}

/// Detects with a trail, within the part of `budget` bytes that other searches of `account` leave.
fn search_all(
    burst: &Burst,
    params: &DetectorParams,
    (account, budget): (&Account, Option<u64>),
    monitor: &Monitor,
) -> Result<Trail, DetectError> {
    let started = Instant::now();
    params.validate_for(burst.len(), burst.size())?;
    let frames = params.used_frames(burst.len()).len();
    let (plan, _share) = account.plan(params, frames, burst.size(), budget)?;
    plan.run(|| search_as_planned(burst, params, &plan, (started, monitor)))
}

/// Detects by `plan`, with parameters that are valid for the burst; `started` is the time of the start.
fn search_as_planned(
    burst: &Burst,
    params: &DetectorParams,
    plan: &Plan,
    (started, monitor): (Instant, &Monitor),
) -> Result<Trail, DetectError> {
    let inputs = Inputs::new(burst, params, monitor)?;
    let mut times = StageTimes { noise_secs: started.elapsed().as_secs_f32(), ..StageTimes::default() };

    let planes = inputs.planes();
    let search = Search::new(&inputs, &planes, monitor);
    let octaves = inputs.octaves();
    let mut tally = Tally::default();
    let started = Instant::now();
    let Searched { keypoints, bases } = search.octaves(&octaves, &plan.search, &mut tally)?;
    let octave_frames = FramesOfOctaves::new(&planes, &inputs.times, octaves.clone());
    let covered_by = search.distinct(&keypoints, &octave_frames)?;
    let kept: Vec<usize> = (0..keypoints.len()).filter(|&index| covered_by[index].is_none()).collect();
    tally.reject(Test::Duplicate, (keypoints.len() - kept.len()) as u64);
    tally.kept = kept.len() as u64;
    times.search_secs = started.elapsed().as_secs_f32();
    let started = Instant::now();
    let described: Vec<Keypoint> = kept.iter().map(|&index| keypoints[index]).collect();
    let mut found = search.describe(&octaves, &described, (bases.as_deref(), &plan.describe), &octave_frames)?;
    monitor.check()?;
    found.sort_by(|Described { feature: a, .. }, Described { feature: b, .. }| {
        let by_place = || a.v.total_cmp(&b.v).then(a.u.total_cmp(&b.u));
        // Features of one keypoint stay in the order of their orientations.
        let by_sample = || (a.octave, a.level, a.slope_index).cmp(&(b.octave, b.level, b.slope_index));
        b.strength().total_cmp(&a.strength()).then_with(by_place).then_with(by_sample)
    });
    let ranked: Vec<usize> = found.iter().map(|one| kept[one.keypoint]).collect();
    if params.max_features > 0 && found.len() > params.max_features {
        tally.reject(Test::MaxFeatures, (found.len() - params.max_features) as u64);
        found.truncate(params.max_features);
    }
    times.describe_secs = started.elapsed().as_secs_f32();
    monitor.report(Stage::Describe, 1.0);
    let gate_factor = search.gate_factor;
    let (features, descriptors) = found.into_iter().map(|one| (one.feature, one.descriptor)).unzip();
    let detection = Detection {
        features,
        descriptors,
        tally,
        frame_noise: inputs.noise.frame_noise,
        noise_gate_factor: gate_factor,
        noise: inputs.noise.clone(),
        slopes: inputs.params.used_slopes(),
        frames_used: inputs.frames_used.clone(),
        octaves,
        times,
    };
    drop(octave_frames);
    drop(planes);
    Ok(Trail::new(inputs, bases, keypoints, covered_by, ranked, detection))
}
