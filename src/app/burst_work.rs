//! What the window asks the engine for and takes from it, for the burst in the inspector: opening, pictures, features. The second burst's part is in
//! [`pair_work`](super::pair_work), the compared methods' in [`compare_work`](super::compare_work).

use super::canvas::View;
use super::state::Busy;
use super::state::pair::Side;
use super::state::scrub::{ViewKind, played};
use super::window::BurstscopeApp;
use crate::dataset::DatasetSource;
use crate::engine::{Answer as JobAnswer, BurstSource, DetectRequest, JobError, LaneKind, OpenBurst, PairLane, Update};
use std::time::{Duration, Instant};

/// Pauses between slopes while they are played.
const PLAY_EVERY: Duration = Duration::from_millis(220);

impl BurstscopeApp {
    /// Takes what the engine published.
    pub(super) fn take_updates(&mut self, ctx: &egui::Context) {
        for update in self.engine.poll() {
            match update {
                Update::Opened(answer) => self.take_opened(answer),
                Update::Picture(answer) => match answer.result {
                    Ok(picture) => self.model.take_picture(picture),
                    Err(JobError::Cancelled) => self.asked_picture = None,
                    Err(error) => self.model.messages.error("Picture", error.to_string()),
                },
                Update::Patch(answer) => match answer.result {
                    Ok(patch) => self.model.patch = Some(patch),
                    Err(JobError::Cancelled) => {}
                    Err(error) => self.model.messages.error("Patch", error.to_string()),
                },
                Update::Detected(answer) => {
                    let asked = self.detecting_params.take();
                    match answer.result {
                        Ok(detected) => {
                            self.model.messages.resolved("Detection");
                            self.model.take_detection(detected, answer.elapsed);
                        }
                        Err(JobError::Cancelled) => {
                            self.failed_params = asked;
                            self.model.messages.note("Detection cancelled");
                        }
                        Err(error) => {
                            self.failed_params = asked;
                            self.model.messages.error("Detection", error.to_string());
                        }
                    }
                }
                Update::Task(done) => match done.result {
                    Ok(text) => self.model.messages.note(text),
                    Err(error) => self.model.messages.error(done.label, error.to_string()),
                },
                Update::Dataset(update) => self.take_dataset_update(ctx, update),
                Update::ComparedPoses(answer) => self.take_compared(answer),
            }
        }
        self.model.busy = Busy {
            opening: self.engine.running(LaneKind::Open),
            detecting: self.engine.running(LaneKind::Detect),
            picture: self.engine.running(LaneKind::Picture).is_some(),
        };
        self.model.datasets.running = self.engine.datasets.running();
        self.model.trajectories.running = self.engine.poses.running();
    }

    fn take_opened(&mut self, answer: JobAnswer<OpenBurst>) {
        let session = match self.restoring.take() {
            Some((id, session)) if id == answer.id => Some(session),
            other => {
                self.restoring = other;
                None
            }
        };
        match answer.result {
            Ok(mut burst) => {
                self.engine.cancel(LaneKind::Detect);
                self.remember(&mut burst);
                self.model.messages.resolved("Open");
                self.model.messages.note(format!("Opened {}", describe_burst(&burst)));
                self.model.take_burst(burst);
                self.view = View::fit();
                self.forget_asked();
                if let Some(session) = session {
                    self.view = session.apply(&mut self.model);
                    self.restore_dataset(session.dataset.clone());
                    self.restore_trajectories(session.trajectories.clone());
                    if session.detected && self.model.needs_detection() {
                        self.start_detection();
                    }
                    if let Some(gold) = session.gold {
                        self.open_gold(gold, Side::A);
                    }
                    self.restore_pair(session.pair);
                }
            }
            Err(JobError::Cancelled) => self.model.messages.note("Opening cancelled"),
            Err(JobError::Several(_)) if session.is_none() => {
                if let Some((_, BurstSource::Paths(paths))) = self.opening.take_if(|(id, _)| *id == answer.id) {
                    self.open_dataset(DatasetSource::of_bursts(paths));
                }
            }
            Err(error) => self.model.messages.error("Open", error.to_string()),
        }
    }

    /// Forgets what was asked for A's burst: another one is open.
    pub(super) fn forget_asked(&mut self) {
        (self.asked_picture, self.asked_patch) = (None, None);
        (self.failed_params, self.detecting_params) = (None, None);
    }

    /// Stops what is being opened, detected and matched.
    pub(super) fn cancel_all(&self) {
        self.engine.cancel(LaneKind::Detect);
        self.engine.cancel(LaneKind::Open);
        for lane in [PairLane::Open, PairLane::Detect, PairLane::Match] {
            self.engine.pair().cancel(lane);
        }
        self.engine.comparer().cancel();
    }

    /// Whether features of the present parameters are missing, and were not looked for in vain.
    pub(super) fn wants_detection(&self) -> bool {
        self.model.needs_detection() && self.failed_params.as_ref() != Some(&self.model.asked())
    }

    /// Starts a detection with the present parameters.
    pub(super) fn start_detection(&mut self) {
        if let Some(burst) = self.model.burst.clone() {
            let params = self.model.asked();
            self.detecting_params = Some(params.clone());
            self.engine.detect(DetectRequest { burst, params });
            self.model.busy.detecting = self.engine.running(LaneKind::Detect);
        }
    }

    /// Goes on to the next slope while slopes are played.
    pub(super) fn step_play(&mut self, ctx: &egui::Context) {
        if !self.model.playing {
            return;
        }
        let now = Instant::now();
        let due = self.play_due.is_none_or(|due| now >= due);
        let (side, step) = (self.model.active_side(), self.play_step + 1);
        // The next slope waits for the picture of this one, so that a slow machine plays slowly and skips none.
        let stepped = self.model.on_side(side, |model| {
            let ready = due && model.picture_is_current();
            if ready {
                model.scrub.slope = played(&model.usable_params.slopes, step);
                model.slope_chosen = true;
                if model.scrub.kind == ViewKind::Frame {
                    model.scrub.kind = ViewKind::Stack;
                }
            }
            ready
        });
        if stepped {
            (self.play_step, self.play_due) = (step, Some(now + PLAY_EVERY));
        }
        ctx.request_repaint_after(PLAY_EVERY / 4);
    }

    /// Asks for what is wanted and not there, and was not asked for.
    pub(super) fn request_what_is_missing(&mut self, ctx: &egui::Context) {
        if let Some(wanted) = self.model.wanted_picture()
            && !self.asked_picture.as_ref().is_some_and(|asked| asked.same_picture(&wanted))
        {
            self.engine.request_picture(wanted.clone());
            self.asked_picture = Some(wanted);
        }
        match self.model.wanted_patch() {
            Some(wanted) if !self.asked_patch.as_ref().is_some_and(|asked| asked.same_picture(&wanted)) => {
                self.engine.request_patch(wanted.clone());
                self.asked_patch = Some(wanted);
            }
            _ => {}
        }
        // While the hand still drags a parameter, every value on the way would start a detection for nothing.
        let dragging = ctx.input(|i| i.pointer.any_down());
        let asked = self.detecting_params.as_ref() == Some(&self.model.asked());
        if self.model.auto_detect && !dragging && !asked && self.wants_detection() {
            self.start_detection();
        }
        self.request_for_pair(dragging);
        self.request_for_compare(dragging);
        self.thumbnails.request(&self.engine.datasets);
    }
}

/// A burst in a few words: its name, number of frames and size.
pub(super) fn describe_burst(open: &OpenBurst) -> String {
    let (width, height) = open.burst.size();
    let count = open.burst.len();
    let frames = if count == 1 { "frame" } else { "frames" };
    format!("{}: {count} {frames} of {width} × {height}", open.burst.name)
}
