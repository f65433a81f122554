//! Trail of a detection: all that its search left behind, found in a store or made again.

use super::{JobError, OpenBurst};
use crate::detector::{DetectorParams, SearchParams, SlopeFinding};
use crate::inspect::ProbeCache;
use crate::monitor::Monitor;
use std::sync::Arc;

/// Source of a detection: its burst, and the parameters that were asked for and used.
#[derive(Debug, Clone)]
pub struct DetectionSource {
    pub burst: OpenBurst,
    pub asked: SearchParams,
    pub params: DetectorParams,
    pub finding: Option<SlopeFinding>,
}

impl DetectionSource {
    /// The slopes are known: they are not searched for again.
    pub fn trail(&self, monitor: &Monitor) -> Result<ProbeCache, JobError> {
        Ok(trail_of(&self.burst, &self.params, monitor)?.asked_as(&self.asked, self.finding.as_ref()))
    }
}

pub fn trail_of(burst: &OpenBurst, params: &DetectorParams, monitor: &Monitor) -> Result<ProbeCache, JobError> {
    Ok(ProbeCache::new(&burst.burst, &params.clone().into(), monitor)?)
}

/// Keeps nothing by default. Any store gives the same answers, but for the tally of what was judged again or went on.
pub trait TrailStore {
    fn put(&self, _: &OpenBurst, _: &Arc<ProbeCache>) {}

    /// Drops trails above the budget, before another one is made.
    fn make_room(&self) {}

    fn asked(&self, _: &OpenBurst, _: &SearchParams) -> Option<Arc<ProbeCache>> {
        None
    }

    /// Trails of a burst, from which searches may [go on](ProbeCache::after), last used first.
    fn of_burst(&self, _: &OpenBurst) -> Vec<Arc<ProbeCache>> {
        Vec::new()
    }

    /// Trail judged again from a kept search, see [`ProbeCache::rejudged`]; replaces the kept trail.
    fn rejudged(&self, _: &OpenBurst, _: &SearchParams, _: &Monitor) -> Result<Option<Arc<ProbeCache>>, JobError> {
        Ok(None)
    }

    fn get(&self, _: &DetectionSource) -> Option<Arc<ProbeCache>> {
        None
    }

    fn get_or_make(&self, source: &DetectionSource, monitor: &Monitor) -> Result<Arc<ProbeCache>, JobError> {
        source.trail(monitor).map(Arc::new)
    }

    fn get_or_make_for(
        &self,
        burst: &OpenBurst,
        params: &DetectorParams,
        monitor: &Monitor,
    ) -> Result<Arc<ProbeCache>, JobError> {
        trail_of(burst, params, monitor).map(Arc::new)
    }
}

/// Fraction of the progress that making a trail takes, where it is not kept.
const TRAIL_SHARE: f32 = 0.6;

pub(super) fn trail_and_rest(
    trails: &dyn TrailStore,
    source: &DetectionSource,
    monitor: &Monitor,
) -> Result<(Arc<ProbeCache>, Monitor), JobError> {
    let (trail, share) = match trails.get(source) {
        Some(kept) => (kept, 0.0),
        None => (trails.get_or_make(source, &monitor.part(0.0, TRAIL_SHARE))?, TRAIL_SHARE),
    };
    Ok((trail, monitor.part(share, 1.0 - share)))
}

#[derive(Debug, Clone, Copy, Default)]
pub struct NothingKept;

impl TrailStore for NothingKept {}
