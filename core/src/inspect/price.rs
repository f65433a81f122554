//! Price of a change of one setting, before it is made: the number of features with it, whether the candidate in
//! question is then kept, and the time of the search.
//!
//! Numbers are counted: from what the search left where that suffices, otherwise by a search with the changed setting.

use super::ProbeCache;
use super::words::counted;
use crate::burst::Burst;
use crate::detector::advice::grouped;
use crate::detector::scale_space::{octave_size, searched_octaves};
use crate::detector::{DetectorParams, ParamChange, Sample, SearchParams, Trail};
use crate::error::Result;
use crate::monitor::{Cancelled, Monitor};
use serde::Serialize;
use std::cmp::Ordering;

/// Effect of a change on the features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Price {
    /// Number of features now.
    pub now: usize,
    /// Number of features after the change.
    pub then: usize,
    /// Number of features of the candidate in question, now and after the change; `None` where none is in question.
    pub own: Option<(usize, usize)>,
}

impl Price {
    /// Sentence without a capital at its start or a full stop at its end.
    pub fn sentence(&self) -> String {
        let (own_now, own_then) = self.own.unwrap_or_default();
        let (now, then) = (self.now - own_now.min(self.now), self.then - own_then.min(self.then));
        let more = match (then.cmp(&now), self.own) {
            (Ordering::Equal, _) => None,
            (Ordering::Greater, None) => Some(counted(then - now, "more feature")),
            (Ordering::Greater, Some(_)) => Some(format!("{} more", grouped((then - now) as u64))),
            (Ordering::Less, None) => Some(counted(now - then, "fewer feature")),
            (Ordering::Less, Some((1.., 0))) => Some(counted(now - then, "other")),
            (Ordering::Less, Some(_)) => Some(counted(now - then, "fewer other")),
        };
        let own = match self.own {
            None => return more.unwrap_or_else(|| "the number of features stays".to_owned()),
            Some((0, 0)) => "does not keep this one",
            Some((0, _)) => "keeps this one",
            Some((_, 0)) => "removes this one",
            Some(_) => "leaves this one",
        };
        format!("{own}, and {}", more.unwrap_or_else(|| "as many others as now".to_owned()))
    }
}

/// Price of `change` from what the search of `trail` left, if that suffices; `sample` is the candidate in question.
pub fn price_at_once(
    trail: &Trail,
    change: &ParamChange,
    sample: Option<Sample>,
    monitor: &Monitor,
) -> Result<Option<Price>, Cancelled> {
    let Ok(params) = change.applied(trail.params()) else { return Ok(None) };
    Ok(trail.rejudged(&params, monitor)?.map(|changed| between(trail, &changed, sample)))
}

/// Price of `change` to the detection of `cache` in `burst`, as it was opened; with a search where it takes one.
pub fn price(
    cache: &ProbeCache,
    burst: &Burst,
    change: &ParamChange,
    sample: Option<Sample>,
    monitor: &Monitor,
) -> Result<Price> {
    if let Some(price) = price_at_once(&cache.trail, change, sample, monitor)? {
        return Ok(price);
    }
    let params = change.applied(&cache.made_with())?;
    let changed = ProbeCache::new(burst, &SearchParams::from(params), monitor)?;
    // On another grid of slopes the sample is another one.
    let same_samples = changed.params().used_slopes() == cache.params().used_slopes();
    Ok(between(&cache.trail, &changed.trail, sample.filter(|_| same_samples)))
}

fn between(before: &Trail, after: &Trail, sample: Option<Sample>) -> Price {
    let [now, then] = [before, after].map(|trail| trail.detection().features.len());
    Price { now, then, own: sample.map(|sample| (own(before, &sample), own(after, &sample))) }
}

fn own(trail: &Trail, sample: &Sample) -> usize {
    let at = [sample.x as u32, sample.y as u32];
    let keypoint = trail.keypoint_at(sample.octave, sample.level, sample.slope_index, at);
    keypoint.map_or(0, |keypoint| trail.ranks_of(keypoint).count())
}

/// Ratio of the samples that searches with `then` and with `now` examine in frames of `size` (columns, rows).
pub fn time_factor(now: &DetectorParams, then: &DetectorParams, size: (usize, usize)) -> f32 {
    let samples = |params: &DetectorParams| {
        let pixels = |octave: i32| {
            let (width, height) = octave_size(size, octave);
            width as f64 * height as f64
        };
        let of_slope: f64 = searched_octaves(params, size).map(pixels).sum();
        of_slope * f64::from(params.levels) * params.used_slopes().len() as f64
    };
    (samples(then) / samples(now).max(1.0)) as f32
}
