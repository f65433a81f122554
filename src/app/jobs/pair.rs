//! What the window does for a pair of bursts: takes the engine's answers, and asks for what is wanted and not there.

use crate::app::pane::{PaneId, SavedWorkspaces};
use crate::app::project::pair::{Matches, PairBusy, Side};
use crate::app::project::workspace::Workspace;
use crate::app::session::PairSession;
use crate::app::window::BurstscopeApp;
use crate::detector::SearchParams;
use crate::engine::{JobAnswer, PairJobs, PairUpdate};
use crate::requests::{BurstSource, DetectRequest, JobError, JobId, MatchRequest, OpenBurst, PatchesRequest};
use egui::pos2;

/// What was asked for and has not come, so that it is not asked for again.
#[derive(Default)]
pub(in crate::app) struct PairAsked {
    patches: Option<PatchesRequest>,
    detecting: Option<SearchParams>,
    failed_detection: Option<SearchParams>,
    matching: Option<MatchRequest>,
    failed_matching: Option<MatchRequest>,
    restoring: Option<(JobId, Box<PairSession>, SavedWorkspaces)>,
}

impl BurstscopeApp {
    /// Opens a second burst beside the one that is open, in the background.
    pub fn open_second(&mut self, source: BurstSource) {
        self.pair_asked.restoring = None;
        self.engine.pair().open_with(source, self.model.calibration.clone());
    }

    /// Opens two bursts side by side, in the background.
    pub fn open_pair(&mut self, a: BurstSource, b: BurstSource) {
        self.open(a);
        self.open_second(b);
        self.model.workspace = Workspace::Pair;
    }

    /// Opens the second burst of a session, and then takes over what the session holds of the pair.
    pub(in crate::app) fn restore_pair(&mut self, session: PairSession, panes: SavedWorkspaces) {
        match session.burst.clone() {
            Some(source) => {
                let id = self.engine.pair().open_with(source, self.model.calibration.clone());
                self.pair_asked.restoring = Some((id, Box::new(session), panes));
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
        PairJobs::ALL.into_iter().for_each(|kind| self.engine.pair().cancel(kind));
        self.model.pair.b = Default::default();
        self.forget_closed_trails();
        self.model.panes.close_side(Side::B);
        self.forget_closed_panes();
        self.model.compare.gold[1] = None;
        self.model.pair.forget_matches();
        self.pair_asked = PairAsked::default();
        self.pair_panels.patches = None;
    }

    /// Makes A of B and B of A.
    pub(in crate::app) fn swap_sides(&mut self) {
        // Work that runs is for the side that its burst was on.
        self.cancel_all();
        self.model.swap_sides();
        self.forget_asked();
        // What was probed is a place of the other burst now.
        self.forget_probe();
        self.model.probe.clear();
        self.pair_asked = PairAsked::default();
    }

    /// Probes the place in B where the geometry puts the feature that is asked about. It is A that is probed, so the
    /// two change places.
    pub(in crate::app) fn probe_expected(&mut self) {
        let Some(place) = self.model.expected_place() else { return };
        self.swap_sides();
        self.model.workspace = Workspace::Inspect;
        self.model.probe_place(place);
        self.model.messages.note("B is A now, so that it can be probed; Swap A and B takes that back");
    }

    /// Forgets what detections left behind in bursts that are not open any more.
    pub(in crate::app) fn forget_closed_trails(&self) {
        let open = Side::BOTH.into_iter().filter_map(|side| Some(self.model.burst_of(side)?.id));
        self.engine.keep_trails_of(&open.collect::<Vec<_>>());
    }

    pub(in crate::app) fn take_pair_updates(&mut self) {
        for update in self.engine.pair().poll() {
            match update {
                PairUpdate::Opened(answer) => self.take_opened_second(answer),
                PairUpdate::Patches(answer) => match answer.result {
                    Ok(patches) => self.pair_panels.patches = Some(patches),
                    Err(JobError::Superseded) => {}
                    Err(JobError::Cancelled) => self.pair_asked.patches = None,
                    Err(error) => self.model.messages.error("Patches", error.to_string()),
                },
                PairUpdate::Detected(answer) if answer.is_superseded() => {}
                PairUpdate::Matched(answer) if answer.is_superseded() => {}
                PairUpdate::Detected(answer) => {
                    let asked = self.pair_asked.detecting.take();
                    match answer.result {
                        Ok(detected) => {
                            self.model.messages.resolved("Detection in B");
                            self.model.take_second_detection(detected, answer.elapsed);
                        }
                        Err(error) => {
                            self.pair_asked.failed_detection = asked;
                            self.say_failed("Detection in B", &error);
                        }
                    }
                }
                PairUpdate::Matched(answer) => {
                    let asked = self.pair_asked.matching.take();
                    match answer.result {
                        Ok(matched) => {
                            self.model.messages.resolved("Matching");
                            self.model.pair.take_matches(Matches::new(matched, answer.elapsed));
                        }
                        Err(error) => {
                            self.pair_asked.failed_matching = asked;
                            self.say_failed("Matching", &error);
                        }
                    }
                }
            }
        }
        self.model.pair.busy = PairBusy {
            opening: self.engine.pair().running(PairJobs::Open),
            detecting: self.engine.pair().running(PairJobs::Detect),
            matching: self.engine.pair().running(PairJobs::Match),
        };
    }

    fn say_failed(&mut self, what: &str, error: &JobError) {
        match error {
            JobError::Cancelled => self.model.messages.note(format!("{what} cancelled")),
            error => self.model.messages.error(what, error.to_string()),
        }
    }

    fn take_opened_second(&mut self, answer: JobAnswer<OpenBurst>) {
        let session = match self.pair_asked.restoring.take() {
            Some((id, session, panes)) if id == answer.id => Some((session, panes)),
            other => {
                self.pair_asked.restoring = other;
                None
            }
        };
        match answer.result {
            Ok(mut burst) => {
                self.engine.pair().cancel(PairJobs::Detect);
                self.engine.pair().cancel(PairJobs::Match);
                self.remember(&mut burst);
                self.model.messages.resolved("Open B");
                self.model.messages.note(format!("Opened as B: {}", crate::app::jobs::burst::describe_burst(&burst)));
                self.model.take_second_burst(burst);
                self.forget_closed_trails();
                self.pair_asked = PairAsked::default();
                self.cursors_set = true;
                match session {
                    Some((session, panes)) => {
                        session.apply(&mut self.model);
                        panes.apply(&mut self.model.panes);
                        if let Some(gold) = session.gold {
                            self.open_gold(gold, Side::B);
                        }
                    }
                    None => self.model.workspace = Workspace::Pair,
                }
            }
            Err(JobError::Superseded) => {}
            Err(JobError::Cancelled) => self.model.messages.note("Opening B cancelled"),
            Err(JobError::Several(bursts)) if session.is_none() => self.choose_among(bursts, Side::B),
            Err(error) => {
                if self.model.pair.b.burst.is_none() {
                    // Panes of a session that wait for it would wait for ever.
                    self.model.panes.close_side(Side::B);
                    self.forget_closed_panes();
                }
                self.model.messages.error("Open B", error.to_string());
            }
        }
    }

    /// Starts a detection in B with the present parameters.
    pub(in crate::app) fn start_second_detection(&mut self) {
        if let Some(burst) = self.model.pair.b.burst.clone() {
            let params = self.model.asked_of(Side::B);
            self.pair_asked.detecting = Some(params.clone());
            self.engine.pair().detect(DetectRequest { burst, params });
            self.model.pair.busy.detecting = self.engine.pair().running(PairJobs::Detect);
        }
    }

    /// Starts matching with the present parameters.
    pub(in crate::app) fn start_matching(&mut self) {
        if let Some(wanted) = self.model.wanted_matches() {
            self.pair_asked.matching = Some(wanted.clone());
            self.engine.pair().match_features(wanted);
            self.model.pair.busy.matching = self.engine.pair().running(PairJobs::Match);
        }
    }

    /// Shows both features of the selected match, each in the motion stack at its own slope.
    pub(in crate::app) fn go_to_match(&mut self) {
        let Some(matches) = self.model.pair.matches.clone() else { return };
        let Some(row) = self.model.pair.selected.and_then(|index| matches.row(index)) else { return };
        let sigma = row.a.sigma.max(row.b.sigma).max(1.0);
        // Of each burst the pane in focus, or its first; those that are linked to it come along.
        let panes = &mut self.model.panes;
        let leaders = Side::BOTH.map(|side| {
            let shown = panes.shown_of(side, None);
            let leader = shown.iter().find(|id| **id == panes.focus()).or(shown.first());
            leader.copied().unwrap_or(PaneId::of(side))
        });
        let zooms = leaders.map(|id| panes.get(id).map_or(0.0, |pane| pane.view.points_per_pixel()));
        let zoom = (40.0 / sigma).max(zooms[0]).max(zooms[1]);
        for ((side, feature), leader) in [(Side::A, row.a), (Side::B, row.b)].into_iter().zip(leaders) {
            let links = panes.get(leader).map(|pane| pane.links).unwrap_or_default();
            for id in panes.shown_of(side, None).into_iter().chain([leader]) {
                let Some(pane) = panes.get_mut(id) else { continue };
                if id == leader || (links.cursor && pane.links.cursor) {
                    pane.cursor.slope = feature.slope;
                }
                if id == leader {
                    pane.show_slope();
                }
                if id == leader || (links.view && pane.links.view) {
                    pane.view.look_at(pos2(feature.u, feature.v), zoom);
                }
            }
        }
        (self.cursors_set, self.model.playing) = (true, false);
    }

    fn wants_second_detection(&self) -> bool {
        self.model.needs_second_detection()
            && self.pair_asked.failed_detection.as_ref() != Some(&self.model.asked_of(Side::B))
    }

    fn wants_matching(&self) -> bool {
        let failed = |wanted: &MatchRequest| {
            self.pair_asked.failed_matching.as_ref().is_some_and(|failed| failed.same_matches(wanted))
        };
        self.model.needs_matches() && !self.model.wanted_matches().is_some_and(|wanted| failed(&wanted))
    }

    /// Whether everything that the pair wants is there.
    pub(in crate::app) fn pair_is_settled(&self) -> bool {
        if self.model.burst.is_none() || self.model.pair.b.burst.is_none() {
            return true;
        }
        match self.model.workspace {
            Workspace::Pair => {}
            _ => return true,
        }
        let patches = self.model.wanted_patches().is_none_or(|wanted| {
            self.pair_panels
                .patches
                .as_ref()
                .is_some_and(|p| p.a.request.same_picture(&wanted.a) && p.b.request.same_picture(&wanted.b))
        });
        patches && !(self.model.auto_detect && self.wants_second_detection()) && !self.wants_matching()
    }

    /// Asks the engine for what the pair wants and does not have. `dragging` says whether the pointer still drags
    /// something.
    pub(in crate::app) fn request_for_pair(&mut self, dragging: bool) {
        if self.model.workspace != Workspace::Pair || self.model.pair.b.burst.is_none() {
            return;
        }
        if let Some(wanted) = self.model.wanted_patches()
            && !self.pair_asked.patches.as_ref().is_some_and(|asked| asked.same_pictures(&wanted))
        {
            self.engine.pair().request_patches(wanted.clone());
            self.pair_asked.patches = Some(wanted);
        }
        let asked = self.pair_asked.detecting.as_ref() == Some(&self.model.asked_of(Side::B));
        if self.model.auto_detect && !dragging && !asked && self.wants_second_detection() {
            self.start_second_detection();
        }
        // While features are still being found, what would be matched now would be matched for nothing.
        let detecting = self.model.busy.detecting.is_some() || self.model.pair.busy.detecting.is_some();
        let asked = self
            .model
            .wanted_matches()
            .is_none_or(|wanted| self.pair_asked.matching.as_ref().is_some_and(|asked| asked.same_matches(&wanted)));
        if !dragging && !detecting && !asked && self.wants_matching() {
            self.start_matching();
        }
    }
}
