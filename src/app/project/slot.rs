//! Slot of one of the two bursts: the burst, its features, their comparison with others, and the requests for it.

use crate::app::project::against::Against;
use crate::app::project::side::Side;
use crate::app::project::{FoundFeatures, Model};
use crate::detector::{DetectorParams, ParamError};
use crate::engine::{Engine, Wanted};
use crate::requests::{BurstSource, DetectRequest, JobError, JobId, OpenBurst, OpenRequest};

/// Slot of a burst.
#[derive(Debug, Default)]
pub struct Slot {
    /// The open burst, if any.
    pub burst: Option<OpenBurst>,
    /// The last parameters that were valid for the burst: pictures are made with these.
    pub usable_params: DetectorParams,
    /// Reason why the edited parameters are not valid for the burst, if they are not.
    pub param_error: Option<ParamError>,
    /// The features of the burst.
    pub found: Option<FoundFeatures>,
    /// Comparison of the features with others.
    pub against: Against,
    /// The request that opens a burst here.
    pub opening: Wanted<OpenRequest>,
    /// The request for features.
    pub detecting: Wanted<DetectRequest>,
}

impl Side {
    /// Name of a detection in messages.
    fn detection(self) -> &'static str {
        match self {
            Self::A => "Detection",
            Self::B => "Detection in B",
        }
    }
}

impl Model {
    /// Requests to open a burst for `side`; the open burst stays until the new one is there.
    pub(in crate::app) fn open(&mut self, side: Side, source: BurstSource, engine: &Engine) -> JobId {
        let options = self.calibration.clone();
        self.slots[side].opening.ask(engine, OpenRequest { source, options })
    }

    /// Request for a detection in the burst of `side` with the present parameters.
    fn detect_request(&self, side: Side) -> Option<DetectRequest> {
        Some(DetectRequest { burst: self.burst_of(side)?.clone(), params: self.asked_of(side) })
    }

    /// Whether a detection with the present parameters is missing, could be made, and has not failed already.
    pub fn wants_detection(&self, side: Side) -> bool {
        let failed = |request: &DetectRequest| self.slots[side].detecting.has_failed(request);
        self.needs_detection(side) && !self.detect_request(side).as_ref().is_some_and(failed)
    }

    /// Starts a detection; the running one is cancelled.
    pub fn start_detection(&mut self, side: Side, engine: &Engine) {
        if let Some(request) = self.detect_request(side) {
            self.slots[side].detecting.ask(engine, request);
        }
    }

    /// Requests the features of `side` if they are missing.
    pub(in crate::app) fn ask_for_features(&mut self, side: Side, engine: &Engine) {
        if self.wants_detection(side) {
            let request = self.detect_request(side);
            self.slots[side].detecting.want(engine, request);
        }
    }

    /// Takes the features that were found.
    pub(in crate::app) fn take_features(&mut self) {
        for side in Side::BOTH {
            for ended in self.slots[side].detecting.take() {
                match ended.result {
                    Ok(detected) => {
                        self.messages.resolved(side.detection());
                        self.take_detection(side, detected, ended.elapsed);
                    }
                    Err(error) => self.say_failed(side.detection(), &error),
                }
            }
        }
    }

    /// Shows an error for work that failed, or a note if it was cancelled.
    pub(in crate::app) fn say_failed(&mut self, what: &str, error: &JobError) {
        match error {
            JobError::Cancelled => self.messages.note(format!("{what} cancelled")),
            error => self.messages.error(what, error.to_string()),
        }
    }
}
