//! The workers of a second burst, B, and of the matches between the two.
//!
//! They are lanes as those of the first burst are, and work beside them: B is opened and searched while A's pictures
//! follow the sliders.

use super::fault::JobError;
use super::lane::{Answer, JobId, Lane};
use super::picture::{Picture, PictureRequest};
use super::picture_lane::SharedCache;
use super::source::{BurstSource, OpenBurst};
use super::{DetectRequest, Detected, OnUpdate, PICTURE_GRACE, Running, detect_lane, open_lane};
use crate::detector::Detection;
use crate::matching::{MatchError, MatchParams, MatchResult, match_detections};
use crate::monitor::Monitor;
use std::sync::Arc;
use std::time::Duration;

/// What to match: the features of two bursts and the parameters, as they were when it was asked.
#[derive(Debug, Clone)]
pub struct MatchRequest {
    /// The features of A.
    pub a: Arc<Detection>,
    /// The features of B.
    pub b: Arc<Detection>,
    /// The parameters.
    pub params: MatchParams,
}

impl MatchRequest {
    /// Whether both ask for the same matches: of the same two detections, with the same parameters.
    pub fn same_matches(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.a, &other.a) && Arc::ptr_eq(&self.b, &other.b) && self.params == other.params
    }
}

/// Matches with what they were made from.
#[derive(Debug, Clone)]
pub struct Matched {
    /// What was asked for.
    pub request: MatchRequest,
    /// The matches, and what they agree on.
    pub result: Arc<MatchResult>,
}

/// The two motion-stack images from which a match's patches are cut, or any other two pictures that are wanted
/// together.
#[derive(Debug, Clone)]
pub struct PatchesRequest {
    /// The picture of A.
    pub a: PictureRequest,
    /// The picture of B.
    pub b: PictureRequest,
}

impl PatchesRequest {
    /// Whether both ask for the same pixels.
    pub fn same_pictures(&self, other: &Self) -> bool {
        self.a.same_picture(&other.a) && self.b.same_picture(&other.b)
    }
}

/// The pictures that a [`PatchesRequest`] asked for.
#[derive(Debug, Clone)]
pub struct Patches {
    /// The picture of A.
    pub a: Picture,
    /// The picture of B.
    pub b: Picture,
}

/// The kinds of work for a pair, one lane each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PairLane {
    /// Opening B.
    Open,
    /// The pictures of the selected match's patches.
    Patches,
    /// B's detection.
    Detect,
    /// The matches.
    Match,
}

impl PairLane {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Open, Self::Patches, Self::Detect, Self::Match];
}

/// Something that was published since the last [`PairWorkers::poll`].
#[derive(Debug)]
pub enum PairUpdate {
    /// B was opened, or could not be.
    Opened(Answer<OpenBurst>),
    /// The pictures of the patches are there.
    Patches(Answer<Patches>),
    /// B's detection ended.
    Detected(Answer<Detected>),
    /// The matching ended.
    Matched(Answer<Matched>),
}

/// The workers of a second burst and of the matches.
pub struct PairWorkers {
    open: Lane<BurstSource, OpenBurst>,
    patches: Lane<PatchesRequest, Patches>,
    detect: Lane<DetectRequest, Detected>,
    matching: Lane<MatchRequest, Matched>,
}

impl PairWorkers {
    pub(super) fn new(cache: &SharedCache, on_update: &OnUpdate) -> Self {
        let its = cache.clone();
        Self {
            open: open_lane("open-b", on_update),
            patches: Lane::new("patches", PICTURE_GRACE, on_update.clone(), move |request: PatchesRequest, monitor| {
                let (a, b) = (its.get_or_make(&request.a, monitor)?, its.get_or_make(&request.b, monitor)?);
                Ok(Patches { a, b })
            }),
            detect: detect_lane("detect-b", on_update),
            matching: Lane::new("match", Duration::ZERO, on_update.clone(), match_now),
        }
    }

    /// Opens B in the background.
    pub fn open(&self, source: BurstSource) -> JobId {
        self.open.submit(source)
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

    /// What was published since the last call, in no particular order between lanes. Never waits.
    pub fn poll(&self) -> Vec<PairUpdate> {
        self.patches.enforce_grace();
        let mut updates = Vec::new();
        updates.extend(self.open.take_answer().map(PairUpdate::Opened));
        updates.extend(self.patches.take_answer().map(PairUpdate::Patches));
        updates.extend(self.detect.take_answer().map(PairUpdate::Detected));
        updates.extend(self.matching.take_answer().map(PairUpdate::Matched));
        updates
    }

    /// What a lane is doing now, if anything runs or waits.
    pub fn running(&self, lane: PairLane) -> Option<Running> {
        match lane {
            PairLane::Open => self.open.running(),
            PairLane::Patches => self.patches.running(),
            PairLane::Detect => self.detect.running(),
            PairLane::Match => self.matching.running(),
        }
    }

    /// Cancels what a lane is doing. If something ran, its answer is [`JobError::Cancelled`].
    pub fn cancel(&self, lane: PairLane) {
        match lane {
            PairLane::Open => self.open.cancel(),
            PairLane::Patches => self.patches.cancel(),
            PairLane::Detect => self.detect.cancel(),
            PairLane::Match => self.matching.cancel(),
        }
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        PairLane::ALL.into_iter().all(|lane| self.running(lane).is_none())
    }
}

/// Matches on the calling thread and its pool.
pub(super) fn match_now(request: MatchRequest, monitor: &Monitor) -> Result<Matched, JobError> {
    let result = match_detections(&request.a, &request.b, &request.params, monitor).map_err(job_error)?;
    Ok(Matched { request, result: Arc::new(result) })
}

fn job_error(error: MatchError) -> JobError {
    match error {
        MatchError::Cancelled(_) => JobError::Cancelled,
        MatchError::Param(error) => JobError::Failed(error.to_string()),
    }
}
