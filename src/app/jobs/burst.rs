//! Requests to the engine, and answers from it, for the burst in the inspector: opening, pictures, features. The second
//! burst's are in [`pair`](crate::app::jobs::pair), the compared methods' in [`compare`](crate::app::jobs::compare).

use crate::app::pane::PaneId;
use crate::app::project::Busy;
use crate::app::project::cursor::played;
use crate::app::project::pair::Side;
use crate::app::session::Session;
use crate::app::window::BurstscopeApp;
use crate::dataset::DatasetSource;
use crate::engine::{BurstJobs, JobAnswer, PairJobs, Update};
use crate::requests::{BurstSource, DetectRequest, JobError, OpenBurst};
use std::time::{Duration, Instant};

/// Pauses between slopes while they are played.
const PLAY_EVERY: Duration = Duration::from_millis(220);

impl BurstscopeApp {
    /// Takes what the engine published.
    pub(in crate::app) fn take_updates(&mut self, ctx: &egui::Context) {
        for update in self.engine.poll() {
            match update {
                Update::Opened(answer) => self.take_opened(answer),
                Update::Picture(slot, answer) => self.take_picture(PaneId(slot.0), answer),
                Update::Patch(answer) => match answer.result {
                    Ok(patch) => self.model.patch = Some(patch),
                    Err(JobError::Cancelled | JobError::Superseded) => {}
                    Err(error) => self.model.messages.error("Patch", error.to_string()),
                },
                Update::Detected(answer) if answer.is_superseded() => {}
                Update::Detected(answer) => {
                    let asked = self.asked.detecting.take();
                    match answer.result {
                        Ok(detected) => {
                            self.model.messages.resolved("Detection");
                            self.model.take_detection(detected, answer.elapsed);
                        }
                        Err(JobError::Cancelled) => {
                            self.asked.failed = asked;
                            self.model.messages.note("Detection cancelled");
                        }
                        Err(error) => {
                            self.asked.failed = asked;
                            self.model.messages.error("Detection", error.to_string());
                        }
                    }
                }
                Update::Task(done) if self.has_kept_session(&done) => {}
                Update::Task(done) => match done.result {
                    Ok(text) => self.model.messages.note(text),
                    Err(error) => self.model.messages.error(done.label, error.to_string()),
                },
                Update::Dataset(update) => self.take_dataset_update(ctx, update),
                Update::ComparedPoses(answer) => self.take_compared(answer),
            }
        }
        self.model.busy = Busy {
            opening: self.engine.running(BurstJobs::Open),
            detecting: self.engine.running(BurstJobs::Detect),
            picture: self.engine.makes_pictures(),
            figures: self.take_figures(),
        };
        self.model.datasets.running = self.engine.datasets.running();
        self.model.trajectories.running = self.engine.poses.running();
    }

    fn take_opened(&mut self, answer: JobAnswer<OpenBurst>) {
        let session = match self.asked.restoring.take() {
            Some((id, session)) if id == answer.id => Some(session),
            other => {
                self.asked.restoring = other;
                None
            }
        };
        if let Some(recovery) = &mut self.recovery {
            recovery.restored(answer.id, answer.result.is_ok());
        }
        match answer.result {
            Ok(mut burst) => {
                self.engine.cancel(BurstJobs::Detect);
                self.remember(&mut burst);
                self.model.messages.resolved("Open");
                self.model.messages.note(format!("Opened {}", describe_burst(&burst)));
                for note in burst.burst.notes() {
                    self.model.messages.note(note.for_window());
                }
                let before = self.model.burst.as_ref().map(|open| open.source.clone());
                self.model.take_burst(burst);
                self.forget_probe();
                self.forget_closed_trails();
                self.model.start_probe(before.as_ref());
                self.forget_asked();
                (self.cursors_set, self.history_set) = (true, true);
                self.model.history.clear();
                self.model.measure.clear();
                if let Some(session) = session {
                    session.apply(&mut self.model);
                    self.forget_closed_panes();
                    self.restore_dataset(session.dataset.clone());
                    self.restore_trajectories(session.trajectories.clone());
                    if session.detected && self.model.needs_detection() {
                        self.start_detection();
                    }
                    let panes = session.workspaces();
                    if let Some(gold) = session.gold {
                        self.open_gold(gold, Side::A);
                    }
                    self.restore_pair(session.pair, panes);
                }
            }
            // The one that took its place is being opened.
            Err(JobError::Superseded) => {}
            Err(JobError::Cancelled) => self.model.messages.note("Opening cancelled"),
            Err(JobError::Several(_)) if session.is_none() => {
                if let Some((_, BurstSource::Paths(paths))) = self.asked.opening.take_if(|(id, _)| *id == answer.id) {
                    self.open_dataset(DatasetSource::of_bursts(paths));
                }
            }
            Err(error) => {
                self.model.messages.error("Open", error.to_string());
                if let Some(session) = session {
                    self.restore_without_burst(*session);
                }
            }
        }
    }

    /// Takes over what a session holds besides its burst, which could not be opened; the burst that is open stays.
    fn restore_without_burst(&mut self, session: Session) {
        session.apply_without_burst(&mut self.model);
        self.restore_dataset(session.dataset.clone());
        self.restore_trajectories(session.trajectories.clone());
        let panes = session.workspaces();
        self.restore_pair(session.pair, panes);
        self.model.messages.note("The session was restored without its burst");
    }

    /// Forgets what was asked for the open bursts: another one is open.
    pub(in crate::app) fn forget_asked(&mut self) {
        self.asked.pictures.clear();
        self.asked.patch = None;
        (self.asked.failed, self.asked.detecting) = (None, None);
    }

    /// Stops what is being opened, detected and matched.
    pub(in crate::app) fn cancel_all(&self) {
        self.engine.cancel(BurstJobs::Detect);
        self.engine.cancel(BurstJobs::Open);
        for kind in [PairJobs::Open, PairJobs::Detect, PairJobs::Match] {
            self.engine.pair().cancel(kind);
        }
        self.engine.comparer().cancel();
        self.engine.against.cancel();
        self.engine.coherence.cancel();
        self.engine.probe().cancel();
    }

    /// Whether features of the present parameters are missing, and were not looked for in vain.
    pub(in crate::app) fn wants_detection(&self) -> bool {
        self.model.needs_detection() && self.asked.failed.as_ref() != Some(&self.model.asked())
    }

    /// Starts a detection with the present parameters.
    pub(in crate::app) fn start_detection(&mut self) {
        if let Some(burst) = self.model.burst.clone() {
            let params = self.model.asked();
            self.asked.detecting = Some(params.clone());
            self.engine.detect(DetectRequest { burst, params });
            self.model.busy.detecting = self.engine.running(BurstJobs::Detect);
        }
    }

    /// Goes on to the next slope while slopes are played.
    pub(in crate::app) fn step_play(&mut self, ctx: &egui::Context) {
        if !self.model.playing {
            return;
        }
        let now = Instant::now();
        let due = self.play.due.is_none_or(|due| now >= due);
        // The next slope waits for the pictures of this one, so that a slow machine plays slowly and skips none.
        if due && self.model.pictures_are_current() {
            let step = self.play.step + 1;
            let slope = played(&self.model.cursor_params().slopes, step);
            let pane = self.model.focused_mut();
            pane.cursor.slope = slope;
            pane.show_slope();
            (self.play.step, self.play.due) = (step, Some(now + PLAY_EVERY));
        }
        ctx.request_repaint_after(PLAY_EVERY / 4);
    }

    /// Asks for what is wanted and not there, and was not asked for.
    pub(in crate::app) fn request_what_is_missing(&mut self, ctx: &egui::Context) {
        self.request_pictures();
        match self.model.wanted_patch() {
            Some(wanted) if !self.asked.patch.as_ref().is_some_and(|asked| asked.same_picture(&wanted)) => {
                self.engine.request_patch(wanted.clone());
                self.asked.patch = Some(wanted);
            }
            _ => {}
        }
        // While the pointer still drags a parameter, every value on the way would start a detection for nothing.
        let dragging = ctx.input(|i| i.pointer.any_down());
        let asked = self.asked.detecting.as_ref() == Some(&self.model.asked());
        if self.model.auto_detect && !dragging && !asked && self.wants_detection() {
            self.start_detection();
        }
        self.request_for_probe(dragging);
        self.request_for_pair(dragging);
        self.request_for_compare(dragging);
        self.request_explanations();
        self.request_comparison();
        self.request_coherence();
        self.request_losses();
        self.request_for_lab();
        self.thumbnails.request(&self.engine.datasets, &self.model.calibration);
    }
}

/// A burst in a few words: its name, number of frames and size.
pub(in crate::app) fn describe_burst(open: &OpenBurst) -> String {
    let (width, height) = open.burst.size();
    let count = open.burst.len();
    let frames = if count == 1 { "frame" } else { "frames" };
    format!("{}: {count} {frames} of {width} × {height}", open.burst.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::tests::open;

    #[test]
    fn a_burst_is_described_by_its_frames_and_size() {
        assert_eq!(describe_burst(&open((64, 48), 5)), "test: 5 frames of 64 × 48");
        assert_eq!(describe_burst(&open((64, 48), 1)), "test: 1 frame of 64 × 48");
    }
}
