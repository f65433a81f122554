//! Slot of one of the two bursts: the burst, its features, and the requests for it.

use crate::app::project::side::Side;
use crate::app::project::{Effect, FoundFeatures, Model};
use crate::burst::OpenOptions;
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
    /// The request that opens a burst here.
    pub opening: Wanted<OpenRequest>,
    /// The request for features.
    pub detecting: Wanted<DetectRequest>,
}

impl Side {
    /// Title of messages about opening a burst.
    pub(in crate::app) fn opening(self) -> &'static str {
        match self {
            Self::A => "Open",
            Self::B => "Open B",
        }
    }

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

    /// Shows a burst that was opened for `side`. It goes to the recent list, unless it is one of the open dataset; that
    /// gives it its name in the dataset.
    pub(in crate::app) fn take_opened(&mut self, side: Side, mut burst: OpenBurst, engine: &Engine) -> Option<Effect> {
        let dataset = self.datasets.open.as_ref().filter(|dataset| dataset.place_of(Some(&burst)).is_some());
        let recent = match dataset {
            Some(dataset) => {
                dataset.name_as_here(&mut burst);
                None
            }
            None => Some(Effect::Recent(burst.source.clone())),
        };
        self.messages.resolved(side.opening());
        match side {
            Side::A => {
                self.messages.note(format!("Opened {}", burst.describe()));
                for note in burst.burst.notes() {
                    self.messages.note(note.for_window());
                }
                let before = self.slots.a.burst.as_ref().map(|open| open.source.clone());
                self.take_burst(burst);
                self.start_probe(before.as_ref());
                self.settings_are_set();
                self.history.clear();
                self.measure.clear();
            }
            Side::B => {
                self.messages.note(format!("Opened as B: {}", burst.describe()));
                self.take_second_burst(burst);
                self.cursors_are_set();
            }
        }
        self.forget_closed_trails(engine);
        recent
    }

    /// Drops the trails of bursts that are not open any more.
    pub(in crate::app) fn forget_closed_trails(&self, engine: &Engine) {
        let open = Side::BOTH.into_iter().filter_map(|side| Some(self.burst_of(side)?.id));
        engine.keep_trails_of(&open.collect::<Vec<_>>());
    }

    /// Opens the bursts and the dataset again, with this calibration.
    pub(in crate::app) fn calibrate(&mut self, options: OpenOptions, engine: &Engine) -> Effect {
        self.calibration = options;
        for side in Side::BOTH {
            if let Some(source) = self.burst_of(side).map(|open| open.source.clone()) {
                self.open(side, source, engine);
            }
        }
        self.look_at_dataset_again(engine);
        Effect::ForgetThumbnails
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
