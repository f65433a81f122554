//! The whole detector: its steps in order, from a burst to features.
//!
//! The inputs give the kept frames and their noise; the [search](crate::detector::search) finds keypoints. The
//! strongest on each blob is localised, described and ranked. A [`Trail`] explains the detection, sample by sample.

mod choice;
mod earlier;
mod judgement;
mod outcome;
#[cfg(test)]
mod tests;
mod trail;

pub use crate::detector::search::FIRST_PEAK_PART;
pub use earlier::shared_slopes;
pub use judgement::{Judgement, Neighbourhood, Sample, compared_slopes};
pub use outcome::follows;
pub use trail::Trail;

use super::feature::{Detection, Keypoint, StageTimes, Tally};
use super::memory::{self, Account, OF_PROCESS, Plan, SearchSize};
use super::params::{DescribeSlope, DetectorParams, NoiseGate, SearchSlopes, SlopeGrid};
use crate::burst::Burst;
use crate::detector::along::Along;
use crate::detector::describe::{self, Described, Describing};
use crate::detector::field::{MotionField, motion_field};
use crate::detector::pipeline::choice::{Choice, Chooser};
use crate::detector::pipeline::outcome::{Outcome, PassingKeypoints, sigma_d};
use crate::detector::search::SEARCH_PART;
use crate::detector::search::around_field::SlopesAround;
use crate::detector::search::setup::{FirstLevels, Inputs, Search, SlopeGroup};
use crate::error::Result;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Finds the features of a burst whose frames are merged already; callers use [`crate::detect`].
pub(crate) fn search(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Detection> {
    Ok(search_all(burst, params, &OF_PROCESS, memory::budget(), None, monitor)?.detection)
}

/// Finds the features of a burst and keeps the data that explains them. Results of an `earlier` search at shared slopes
/// are taken over; the result is the same to the bit, but its tally counts rejections as the earlier search did.
pub(crate) fn search_with_trail(
    burst: &Burst,
    params: &DetectorParams,
    keeping: Keeping<'_>,
    monitor: &Monitor,
) -> Result<Trail> {
    Ok(search_all(burst, params, &OF_PROCESS, budget_beside_kept(), Some(keeping), monitor)?.ready())
}

/// Callback that shows the features of the first slope while a long search goes on.
pub type FirstFeatures<'a> = &'a (dyn Fn(Detection) + Sync);

/// Search whose trail is kept: its keypoints can be judged again, and another search can go on from it.
#[derive(Clone, Copy)]
pub(crate) struct Keeping<'a> {
    /// Trail that this search continues.
    pub earlier: Option<&'a Trail>,
    /// Called with the features of the slope by which most places move, before the others are searched, if the search
    /// is long and has no `earlier` one. The gate is that of all slopes.
    pub first: FirstFeatures<'a>,
}

impl Keeping<'_> {
    #[cfg(test)]
    pub const ANEW: Self = Self { earlier: None, first: &|_| {} };
}

/// Pixels of an image times slopes above which a search is long: more than about 0.2 s.
const LONG_SEARCH_PX: usize = 5_000_000;
/// Least number of slopes of a long search: the first one is then a small part of it.
const LONG_SEARCH_SLOPES: usize = 16;

/// Memory of a search while trails are kept, which already hold their part of the budget; bytes.
fn budget_beside_kept() -> Option<u64> {
    memory::budget().map(|bytes| bytes.saturating_sub(memory::kept_bytes()))
}

/// Detects with a trail, within the part of `budget` bytes that other searches of `account` leave.
fn search_all(
    burst: &Burst,
    params: &DetectorParams,
    account: &Account,
    budget: Option<u64>,
    keeping: Option<Keeping<'_>>,
    monitor: &Monitor,
) -> Result<Trail> {
    let started = Instant::now();
    params.validate_for(&burst.positions, burst.size())?;
    let frames = params.used_frames(burst.len()).len();
    let (plan, _share) = account.plan(SearchSize { params, frames, size: burst.size() }, budget)?;
    plan.run(|| {
        // Noise and cleaned frames of an earlier search are taken over, so that only slopes remain to be searched.
        let earlier = keeping.and_then(|keeping| keeping.earlier);
        let earlier = earlier.filter(|earlier| earlier.known_slopes(burst, params) > 0);
        let mut inputs = match earlier {
            Some(earlier) => earlier.inputs.judged_with(params),
            None => Inputs::new(burst, params, monitor)?,
        };
        let grid = params.used_slopes();
        let field = motion_field(&inputs.planes(), &inputs.times, &grid, monitor)?.map(Arc::new);
        if let (SearchSlopes::Field, Some(field)) = (params.search, &field) {
            inputs.around = Some(Arc::new(SlopesAround::new(field, grid, burst.size())));
        }
        let times = StageTimes { noise_secs: started.elapsed().as_secs_f32(), ..StageTimes::default() };
        let shows_first = keeping.filter(|_| earlier.is_none() && is_long(params, burst.size()));
        let begun = shows_first.map(|keeping| search_first(&inputs, field.as_ref(), keeping.first, monitor));
        let begun = begun.transpose()?;
        search_inputs(inputs, field, &plan, keeping.is_some(), earlier.or(begun.as_ref()), times, monitor)
    })
}

/// Whether a search takes so long that its first slope is shown before; only a sum of searches can go on from one.
fn is_long(params: &DetectorParams, size: (usize, usize)) -> bool {
    let slopes = params.used_slopes().len();
    slopes >= LONG_SEARCH_SLOPES && slopes.saturating_mul(size.0 * size.1) >= LONG_SEARCH_PX && earlier::is_sum(params)
}

fn search_first(
    inputs: &Inputs,
    field: Option<&Arc<MotionField>>,
    first: FirstFeatures<'_>,
    monitor: &Monitor,
) -> Result<Trail> {
    let grid = inputs.params.used_slopes();
    let slope = field.and_then(|field| field.commonest_of(&grid)).unwrap_or_else(|| grid.slope(grid.len() / 2));
    // With the gate of all slopes its features stay, and the tally counts its samples as the whole search would.
    let noise_gate = NoiseGate::Factor(inputs.gate_factor);
    let params = DetectorParams { slopes: SlopeGrid::single(slope), noise_gate, ..inputs.params.clone() };
    let whole = vec![SlopeGroup::whole(1)];
    let plan = Plan { search: whole.clone(), describe: whole, threads: rayon::current_num_threads(), bytes: 0 };
    let (inputs, times) = (inputs.judged_with(&params), StageTimes::default());
    let trail = search_inputs(inputs, field.cloned(), &plan, true, None, times, &monitor.silent())?;
    first(trail.detection.clone());
    Ok(trail)
}

/// Detects in frames whose noise is known, continuing an `earlier` search. `times` holds the steps so far.
fn search_inputs(
    inputs: Inputs,
    field: Option<Arc<MotionField>>,
    plan: &Plan,
    keeps: bool,
    earlier: Option<&Trail>,
    mut times: StageTimes,
    monitor: &Monitor,
) -> Result<Trail> {
    let search = Search::new(&inputs, monitor);
    let started = Instant::now();
    // Taking over needs all slopes in one group; groups are searched anew.
    let known = earlier.filter(|_| plan.search.len() == 1).and_then(|earlier| earlier.known(&search));
    let mut tallies =
        known.as_ref().map_or_else(|| vec![Tally::default(); search.grid.len()], |known| known.tallies.clone());
    let searched = search.octaves(&inputs.octaves(), &plan.search, known.as_ref(), &mut tallies)?;
    times.search_secs = started.elapsed().as_secs_f32();
    let mut outcome = Outcome::new(&search, searched, &plan.describe, tallies, keeps, field);
    if let (Some(earlier), Some(known)) = (earlier, &known) {
        earlier.lend_features(&search.grid, known, &mut outcome);
    }
    let passing = outcome.all();
    let (choice, detection) = choose(&search, &outcome, &passing, &Along::new(&inputs), times)?;
    drop(search);
    Ok(Trail::new(inputs, Arc::new(outcome), passing, choice, detection))
}

/// Chooses the features among the `passing` keypoints of a search. `times` holds the steps so far.
fn choose(
    search: &Search<'_>,
    outcome: &Outcome,
    passing: &PassingKeypoints,
    along: &Along<'_>,
    mut times: StageTimes,
) -> Result<(Choice, Detection), Cancelled> {
    let started = Instant::now();
    let chooser = Chooser { search, outcome, passing, along };
    let (mut found, choice) = chooser.choose(search.params.max_features)?;
    let mut tally = passing.tally;
    choice.count(&mut tally);
    chooser.mark(&mut found)?;
    // Comparing keypoints belongs to the search, although it takes turns with describing.
    times.search_secs += choice.distinct_secs;
    times.describe_secs = started.elapsed().as_secs_f32() - choice.distinct_secs;
    search.monitor.report(Stage::Describe, 1.0);
    let (features, descriptors) = found.into_iter().map(|one| (one.feature, one.descriptor)).unzip();
    let inputs = search.inputs;
    let detection = Detection {
        features,
        descriptors,
        tally,
        frame_noise: inputs.noise.frame_noise,
        field: outcome.field.clone(),
        noise_gate_factor: inputs.gate_factor,
        noise: inputs.noise.clone(),
        slopes: inputs.params.used_slopes(),
        frames_used: inputs.frames_used.clone(),
        positions: inputs.times.positions.clone(),
        octaves: inputs.octaves(),
        times,
    };
    Ok((choice, detection))
}

impl Trail {
    /// Trail that a search of the same burst with `params` would leave, without the search; `None` unless `params`
    /// [follow](follows). Keypoints, features and descriptors equal those of the search to the bit; samples that are no
    /// keypoints are tallied as the earlier search rejected them.
    pub fn rejudged(&self, params: &DetectorParams, monitor: &Monitor) -> Result<Option<Self>, Cancelled> {
        if !follows(params, &self.outcome.params) {
            return Ok(None);
        }
        let started = Instant::now();
        let inputs = self.inputs.judged_with(params);
        let search = Search::new(&inputs, monitor);
        let Some(passing) = self.outcome.passing(&search, &sigma_d(&search)) else { return Ok(None) };
        let along = Along::with_means(&inputs, &self.outcome.means);
        let times = StageTimes { search_secs: started.elapsed().as_secs_f32(), ..StageTimes::default() };
        let (choice, detection) = choose(&search, &self.outcome, &passing, &along, times)?;
        drop((search, along));
        let mut judged = Self::new(inputs, self.outcome.clone(), passing, choice, detection).ready();
        judged.search_secs = self.search_secs;
        Ok(Some(judged))
    }

    /// Searches the same frames in another order: the frame at place i among the kept ones gets the time of the frame
    /// at place `order[i]`, for questions about that copy. Noise model, gates, slopes and field stay; none is cut.
    ///
    /// # Panics
    /// If `order` is no permutation of the places of the frames that took part.
    pub fn reordered(&self, order: &[usize], monitor: &Monitor) -> Result<Self> {
        let mut inputs = self.inputs.clone();
        inputs.params.max_features = 0;
        inputs.times = inputs.times.reordered(order);
        let params = inputs.params.clone();
        let wanted = SearchSize { params: &params, frames: inputs.times.positions.len(), size: inputs.size_image };
        let (plan, _share) = OF_PROCESS.plan(wanted, budget_beside_kept())?;
        plan.run(|| {
            let field = self.outcome.field.clone();
            Ok(search_inputs(inputs, field, &plan, false, None, StageTimes::default(), monitor)?.ready())
        })
    }
}

impl Search<'_> {
    /// Localises and describes `keypoints`, which are in order of octaves. First levels that were not kept are made
    /// again, one group of slopes after the other. `part` is this step's part of the description's progress.
    fn describe(
        &self,
        keypoints: &[Keypoint],
        outcome: &Outcome,
        along: &Along<'_>,
        part: Range<f32>,
    ) -> Result<Vec<Described>, Cancelled> {
        let report = |done: f32| self.monitor.report(Stage::Describe, SEARCH_PART + (1.0 - SEARCH_PART) * done);
        let finished = AtomicUsize::new(0);
        let described = |count: usize| {
            let done = (finished.fetch_add(count, Ordering::Relaxed) + count) as f32 / keypoints.len() as f32;
            report(part.start + (part.end - part.start) * done);
        };
        report(part.start);
        if let Some(bases) = &outcome.bases {
            return self.describe_with(keypoints, bases, along, &described);
        }
        let mut found = Vec::with_capacity(keypoints.len() + keypoints.len() / 2);
        // A group's levels serve its own keypoints alone, so that one group is held at a time.
        for group in &outcome.groups {
            let numbers: Vec<usize> =
                (0..keypoints.len()).filter(|&number| group.own.contains(&keypoints[number].slope_index)).collect();
            let of_group: Vec<Keypoint> = numbers.iter().map(|&number| keypoints[number]).collect();
            let Some(last) = of_group.last().map(|keypoint| keypoint.octave) else { continue };
            let bases = self.first_levels(last, &group.visited)?;
            let features = self.describe_with(&of_group, &bases, along, &described)?;
            found.extend(features.into_iter().map(|one| Described { keypoint: numbers[one.keypoint], ..one }));
        }
        Ok(found)
    }

    /// First levels of each octave up to `last` at consecutive slopes; none for the first octave.
    fn first_levels(&self, last: i32, slopes: &Range<usize>) -> Result<Vec<FirstLevels>, Cancelled> {
        let mut planes: Vec<Vec<Arc<Plane>>> = (self.space.first_octave..=last).map(|_| Vec::new()).collect();
        for slope_index in slopes.clone() {
            let of_slope = self.stack(slope_index).first_levels(last, self.monitor)?;
            planes[1..].iter_mut().zip(of_slope).for_each(|(planes, plane)| planes.push(Arc::new(plane)));
        }
        Ok(planes.into_iter().map(|planes| FirstLevels { first_slope: slopes.start, planes }).collect())
    }

    /// `described` is called with the number of further keypoints that are finished.
    fn describe_with(
        &self,
        keypoints: &[Keypoint],
        bases: &[FirstLevels],
        along: &Along<'_>,
        described: &(dyn Fn(usize) + Sync),
    ) -> Result<Vec<Described>, Cancelled> {
        let mut found = Vec::with_capacity(keypoints.len() + keypoints.len() / 2);
        let mut first = 0;
        for in_octave in keypoints.chunk_by(|a, b| a.octave == b.octave) {
            let octave = in_octave[0].octave;
            // Made on all threads at once, before keypoints ask for the octave's frames one by one.
            let own_slopes = self.describes_own_slopes(octave).then(|| {
                along.make(octave);
                along.of(octave)
            });
            let describing = Describing { search: self, bases, octave, own_slopes, described };
            found.extend(describing.describe(in_octave, first)?);
            first += in_octave.len();
        }
        Ok(found)
    }

    /// Whether features of `octave` are described at their own slopes: it is fine enough to show the difference.
    fn describes_own_slopes(&self, octave: i32) -> bool {
        let step = self.grid.u.step().max(self.grid.v.step()).max(0.0);
        let outermost_px = step * self.inputs.times.positions.reach() as f32;
        self.params.rules.describe_slope == DescribeSlope::Refined
            && describe::misaligned(outermost_px, self.space.sigma_image(octave, 0.0) as f32)
    }
}
