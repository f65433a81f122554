//! Opening of bursts, restoring of sessions, and the window's part of the answers.

use crate::app::pane::SavedWorkspaces;
use crate::app::project::Effect;
use crate::app::project::cursor::played;
use crate::app::project::side::Side;
use crate::app::project::trajectories::Which;
use crate::app::project::workspace::Workspace;
use crate::app::session::{PairSession, Session};
use crate::app::window::BurstscopeApp;
use crate::dataset::DatasetSource;
use crate::engine::Ended;
use crate::requests::{BurstSource, JobError, JobId, OpenRequest};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Minimum time for which each slope is shown while slopes are played.
const PLAY_EVERY: Duration = Duration::from_millis(220);

/// Sessions that wait for their burst to be opened.
#[derive(Default)]
pub(in crate::app) struct Restoring {
    /// Id of the request that opens the first burst, and the session.
    pub session: Option<(JobId, Box<Session>)>,
    /// Id of the request that opens the second burst, and the session's state of the pair.
    pub pair: Option<(JobId, Box<PairSession>, SavedWorkspaces)>,
}

impl BurstscopeApp {
    /// Opens a burst in the background; the one that is open stays until the new one is there.
    pub fn open(&mut self, source: BurstSource) {
        let given_up = self.restoring.session.take();
        if let (Some(recovery), Some((id, _))) = (&mut self.recovery, given_up) {
            recovery.restored(id, false);
        }
        self.model.open(Side::A, source, &self.engine);
    }

    /// Opens the second burst in the background.
    pub fn open_second(&mut self, source: BurstSource) {
        self.restoring.pair = None;
        self.model.open(Side::B, source, &self.engine);
    }

    /// Opens two bursts to be matched with one another.
    pub fn open_pair(&mut self, a: BurstSource, b: BurstSource) {
        self.open(a);
        self.open_second(b);
        self.model.workspace = Workspace::Pair;
    }

    /// Opens a trajectory beside the other one.
    pub fn open_trajectory(&mut self, which: Which, path: PathBuf) {
        self.model.open_trajectory(which, path, &self.engine);
    }

    /// Opens a burst for `side`.
    pub(in crate::app) fn open_for(&mut self, side: Side, source: BurstSource) {
        match side {
            Side::A => self.open(source),
            Side::B => self.open_second(source),
        }
    }

    /// Takes the engine's answers.
    pub(in crate::app) fn take_updates(&mut self, ctx: &egui::Context) {
        for effect in self.model.take_answers(&self.engine) {
            match effect {
                Effect::Opened(Side::A, ended) => self.take_opened(ended),
                Effect::Opened(Side::B, ended) => self.take_opened_second(ended),
                Effect::Dataset(ended) => self.take_dataset_answer(ended),
            }
        }
        if let Some(dataset) = &self.model.datasets.open {
            self.thumbnails.take_made(ctx, &dataset.bursts);
        }
        for done in self.engine.take_tasks() {
            if self.has_kept_session(&done) {
                continue;
            }
            match done.result {
                Ok(text) => self.model.messages.note(text),
                Err(error) => self.model.messages.error(done.label, error.to_string()),
            }
        }
    }

    fn take_opened(&mut self, ended: Ended<OpenRequest>) {
        let session = self.restoring.session.take_if(|(id, _)| *id == ended.id).map(|(_, session)| session);
        if let Some(recovery) = &mut self.recovery {
            recovery.restored(ended.id, ended.result.is_ok());
        }
        match ended.result {
            Ok(mut burst) => {
                self.remember(&mut burst);
                self.model.messages.resolved("Open");
                self.model.messages.note(format!("Opened {}", burst.describe()));
                for note in burst.burst.notes() {
                    self.model.messages.note(note.for_window());
                }
                let before = self.model.slots.a.burst.as_ref().map(|open| open.source.clone());
                self.model.take_burst(burst);
                self.forget_closed_trails();
                self.model.start_probe(before.as_ref());
                (self.cursors_set, self.history_set) = (true, true);
                self.model.history.clear();
                self.model.measure.clear();
                if let Some(session) = session {
                    self.restore_with_burst(*session);
                }
            }
            Err(JobError::Cancelled) => self.model.messages.note("Opening cancelled"),
            Err(JobError::Several(_)) if session.is_none() => {
                if let BurstSource::Paths(paths) = ended.request.source {
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

    /// Restores a session whose burst has just been opened.
    fn restore_with_burst(&mut self, session: Session) {
        session.apply(&mut self.model);
        self.forget_closed_panes();
        self.restore_dataset(session.dataset.clone());
        self.model.restore_trajectories(session.trajectories.clone(), &self.engine);
        if session.detected && self.model.needs_detection(Side::A) {
            self.model.start_detection(Side::A, &self.engine);
        }
        let panes = session.workspaces();
        if let Some(gold) = session.gold {
            self.model.open_gold(Side::A, gold, &self.engine);
        }
        self.restore_pair(session.pair, panes);
    }

    /// Restores a session without its burst, which could not be opened; the open burst stays.
    fn restore_without_burst(&mut self, session: Session) {
        session.apply_without_burst(&mut self.model);
        self.restore_dataset(session.dataset.clone());
        self.model.restore_trajectories(session.trajectories.clone(), &self.engine);
        let panes = session.workspaces();
        self.restore_pair(session.pair, panes);
        self.model.messages.note("The session was restored without its burst");
    }

    /// Opens the second burst of a session, and then restores the session's state of the pair.
    pub(in crate::app) fn restore_pair(&mut self, session: PairSession, panes: SavedWorkspaces) {
        match session.burst.clone() {
            Some(source) => {
                let id = self.model.open(Side::B, source, &self.engine);
                self.restoring.pair = Some((id, Box::new(session), panes));
            }
            None => {
                self.close_second();
                session.apply(&mut self.model);
                // Of the panes that were closed only those of both bursts wait for one that is opened later.
                let [_, of_both, _] = &panes.placed;
                of_both.iter().for_each(|saved| saved.apply(&mut self.model.panes, Workspace::Pair));
                self.cursors_set = true;
            }
        }
    }

    /// Closes the second burst.
    pub(in crate::app) fn close_second(&mut self) {
        self.model.close_second();
        self.restoring.pair = None;
        self.forget_closed_trails();
        self.forget_closed_panes();
    }

    /// Swaps A and B.
    pub(in crate::app) fn swap_sides(&mut self) {
        self.model.swap_sides();
        self.restoring = Restoring::default();
    }

    /// Probes the place in B where the geometry expects the feature that is asked about. Only A can be probed, so A and
    /// B are swapped.
    pub(in crate::app) fn probe_expected(&mut self) {
        let Some(place) = self.model.expected_place() else { return };
        self.swap_sides();
        self.model.workspace = Workspace::Inspect;
        self.model.probe_place(place);
        self.model.messages.note("B is now A, so that it can be probed; Swap A and B undoes this");
    }

    /// Drops the trails of bursts that are not open any more.
    pub(in crate::app) fn forget_closed_trails(&self) {
        let open = Side::BOTH.into_iter().filter_map(|side| Some(self.model.burst_of(side)?.id));
        self.engine.keep_trails_of(&open.collect::<Vec<_>>());
    }

    fn take_opened_second(&mut self, ended: Ended<OpenRequest>) {
        let session =
            self.restoring.pair.take_if(|(id, ..)| *id == ended.id).map(|(_, session, panes)| (session, panes));
        match ended.result {
            Ok(mut burst) => {
                self.remember(&mut burst);
                self.model.messages.resolved("Open B");
                self.model.messages.note(format!("Opened as B: {}", burst.describe()));
                self.model.take_second_burst(burst);
                self.forget_closed_trails();
                self.cursors_set = true;
                match session {
                    Some((session, panes)) => {
                        session.apply(&mut self.model);
                        panes.apply(&mut self.model.panes);
                        if let Some(gold) = session.gold {
                            self.model.open_gold(Side::B, gold, &self.engine);
                        }
                    }
                    None => self.model.workspace = Workspace::Pair,
                }
            }
            Err(JobError::Cancelled) => self.model.messages.note("Opening B cancelled"),
            Err(JobError::Several(bursts)) if session.is_none() => self.choose_among(bursts, Side::B),
            Err(error) => {
                if self.model.slots.b.burst.is_none() {
                    // Panes of a session that wait for it would wait for ever.
                    self.model.panes.close_side(Side::B);
                    self.forget_closed_panes();
                }
                self.model.messages.error("Open B", error.to_string());
            }
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

    /// Requests each missing result that the window shows.
    pub(in crate::app) fn request_what_is_missing(&mut self, ctx: &egui::Context) {
        let dragging = ctx.input(|i| i.pointer.any_down());
        self.model.ask(&self.engine, dragging);
        self.thumbnails.request(&self.engine, &self.model.calibration);
    }
}
