//! The workers of a second burst, B, and of the matches between the two.
//!
//! They work beside those of the first burst: B is opened and searched while A's pictures
//! follow the sliders.

use super::detect::detect_jobs;
use super::jobs::{JobAnswer, Jobs};
use super::open_jobs;
use super::picture_jobs::{PICTURE_GRACE, SharedCache};
use super::queue::{JobQueue, Priority};
use crate::burst::OpenOptions;
use crate::requests::{
    BurstSource, DetectRequest, Detected, JobId, MatchRequest, Matched, OpenBurst, OpenRequest, Patches,
    PatchesRequest, Running,
};
use std::sync::Arc;
use std::time::Duration;

/// The kinds of work for a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PairJobs {
    /// Opening B.
    Open,
    /// The pictures of the selected match's patches.
    Patches,
    /// B's detection.
    Detect,
    /// The matches.
    Match,
}

impl PairJobs {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Open, Self::Patches, Self::Detect, Self::Match];
}

/// Something that was published since the last [`PairWorkers::poll`].
#[derive(Debug)]
pub enum PairUpdate {
    /// B was opened, or could not be.
    Opened(JobAnswer<OpenBurst>),
    /// The pictures of the patches are there.
    Patches(JobAnswer<Patches>),
    /// B's detection ended.
    Detected(JobAnswer<Detected>),
    /// The matching ended.
    Matched(JobAnswer<Matched>),
}

/// The workers of a second burst and of the matches.
pub struct PairWorkers {
    open: Jobs<OpenRequest, OpenBurst>,
    patches: Jobs<PatchesRequest, Patches>,
    detect: Jobs<DetectRequest, Detected>,
    matching: Jobs<MatchRequest, Matched>,
}

impl PairWorkers {
    pub(super) fn new(queue: &Arc<JobQueue>, cache: &SharedCache) -> Self {
        let its = cache.clone();
        Self {
            open: open_jobs(queue),
            patches: Jobs::new(queue, Priority::Picture, PICTURE_GRACE, move |request: PatchesRequest, monitor| {
                let (a, b) = (its.get_or_make(&request.a, monitor)?, its.get_or_make(&request.b, monitor)?);
                Ok(Patches { a, b })
            }),
            detect: detect_jobs(queue, cache.trails()),
            matching: Jobs::new(queue, Priority::Search, Duration::ZERO, MatchRequest::compute),
        }
    }

    /// Opens B in the background.
    pub fn open(&self, source: BurstSource) -> JobId {
        self.open_with(source, OpenOptions::default())
    }

    /// The same with a calibration.
    pub fn open_with(&self, source: BurstSource, options: OpenOptions) -> JobId {
        self.open.submit(OpenRequest { source, options })
    }

    /// Asks for the pictures from which a match's patches are cut.
    pub fn request_patches(&self, request: PatchesRequest) -> JobId {
        self.patches.submit(request)
    }

    /// Starts B's detection; the one that runs is cancelled.
    pub fn detect(&self, request: DetectRequest) -> JobId {
        self.detect.submit(request)
    }

    /// Starts matching; the one that runs is cancelled.
    pub fn match_features(&self, request: MatchRequest) -> JobId {
        self.matching.submit(request)
    }

    /// What was published since the last call, in no particular order between kinds. Never waits.
    pub fn poll(&self) -> Vec<PairUpdate> {
        let mut updates = Vec::new();
        updates.extend(self.open.take_answers().map(PairUpdate::Opened));
        updates.extend(self.patches.take_answers().map(PairUpdate::Patches));
        updates.extend(self.detect.take_answers().map(PairUpdate::Detected));
        updates.extend(self.matching.take_answers().map(PairUpdate::Matched));
        updates
    }

    /// What is done of a kind now, if anything runs or waits.
    pub fn running(&self, kind: PairJobs) -> Option<Running> {
        match kind {
            PairJobs::Open => self.open.running(),
            PairJobs::Patches => self.patches.running(),
            PairJobs::Detect => self.detect.running(),
            PairJobs::Match => self.matching.running(),
        }
    }

    /// Cancels the work of a kind: its answer is [`JobError::Cancelled`](crate::requests::JobError::Cancelled).
    pub fn cancel(&self, kind: PairJobs) {
        match kind {
            PairJobs::Open => self.open.cancel(),
            PairJobs::Patches => self.patches.cancel(),
            PairJobs::Detect => self.detect.cancel(),
            PairJobs::Match => self.matching.cancel(),
        }
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        PairJobs::ALL.into_iter().all(|kind| self.running(kind).is_none())
    }
}
