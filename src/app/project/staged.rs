//! A lesson's project beside the user's, and documents that sessions and lessons put in place of the one on show.

use super::comparison::ComparisonResults;
use super::datasets::DatasetChoice;
use super::own::Own;
use super::pair::SavedMatch;
use super::probe::ProbeResults;
use super::side::{Side, Sides};
use super::workspace::Workspace;
use super::{Effect, Model, Read, Results, SavedSelection};
use crate::app::document::Document;
use crate::app::pane::Preset;
use crate::app::project::history::History;
use crate::burst::OpenOptions;
use crate::engine::Engine;
use crate::requests::{BurstSource, OpenRequest};
use std::mem::{replace, take};

/// Changes that a session or a lesson asks for, of values that are not written.
#[derive(Debug, Clone, PartialEq)]
pub enum Staged {
    /// Puts the project aside, and shows an empty one.
    BeginLesson,
    /// Shows the project that was put aside; a burst that is being opened is opened in it, if it `keeps_opening`.
    EndLesson { keeps_opening: bool },
    /// Opens the second burst of a session, with the options of the document.
    Reopen(Side, BurstSource),
    /// Opens the bursts of a lesson's step unless they are open, and the cameras that it speaks of.
    Open { bursts: Sides<Option<BurstSource>>, cameras: bool },
    /// Shows the document of a lesson's step as if nothing had been done before.
    Begin {
        document: Box<Document>,
        layout: Option<Preset>,
        /// Place in A that is probed, pixels at mid-burst.
        probe: Option<[f32; 2]>,
    },
    /// Selects the first of the listed features or matches.
    SelectFirst,
    /// Shows a document of the bursts that are open.
    Show(Box<Document>, Reselect),
    /// Opens the dataset and the trajectories that the document names.
    ReadNamed,
    /// Probes a place as soon as this burst is open.
    ProbeWhenOpen(BurstSource, [f32; 2]),
}

/// Feature or match that is selected as soon as it is found again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reselect {
    Feature(Option<SavedSelection>),
    Match(Option<SavedMatch>),
}

/// Project of the user while a lesson is open, and the burst that was being opened in it.
#[derive(Debug)]
pub struct UserProject {
    document: Document,
    results: Results,
    history: History,
    opening: Option<(OpenRequest, Option<Own>)>,
}

impl Model {
    pub fn is_in_lesson(&self) -> bool {
        self.of_user.is_some()
    }

    /// The one before the open lesson, or without one that on show.
    pub fn project_of_user(&self) -> Read<'_> {
        let of_user = self.of_user.as_deref().map(|UserProject { document, results, .. }| Read { document, results });
        of_user.unwrap_or(self.read())
    }

    pub(in crate::app) fn take_staged(&mut self, staged: Staged, engine: &Engine) -> Option<Effect> {
        match staged {
            Staged::BeginLesson => return Some(self.begin_lesson()),
            Staged::EndLesson { keeps_opening } => return self.end_lesson(keeps_opening, engine),
            Staged::Reopen(side, source) => {
                let options = self.calibration_of(side).clone();
                self.open_with(side, OpenRequest { source, options }, None, engine);
            }
            Staged::Open { bursts, cameras } => self.open_for_step(bursts, cameras, engine),
            Staged::Begin { document, layout, probe } => self.begin_with(*document, layout, probe),
            Staged::SelectFirst if self.document.workspace == Workspace::Pair => {
                self.document.selected_match = self.results.pair.listed.first().copied();
            }
            Staged::SelectFirst => self.document.selected = self.results.listed.first().copied(),
            Staged::Show(document, reselect) => self.show_document(*document, reselect),
            Staged::ReadNamed => return self.read_named(engine),
            Staged::ProbeWhenOpen(source, place) => self.results.studies.probe_when_open = Some((source, place)),
        }
        None
    }

    fn begin_lesson(&mut self) -> Effect {
        let slot = &mut self.results.slots.a;
        let opening = slot.opening.pending().map(|request| (request.clone(), slot.leaves.take()));
        self.results.slots.a.opening.forget();
        let of_lesson = Document { figure: self.document.figure, ..Document::default() };
        let (document, results, history) = self.show(of_lesson, Results::default(), History::default());
        self.of_user = Some(Box::new(UserProject { document, results, history, opening }));
        Effect::ForgetWidgets
    }

    fn end_lesson(&mut self, keeps_opening: bool, engine: &Engine) -> Option<Effect> {
        let UserProject { document, results, history, opening } = *self.of_user.take()?;
        let (_, of_lesson, _) = self.show(document, results, history);
        if self.results.poses.reading.pending().is_some() {
            // What was read meanwhile was not taken.
            self.read_trajectories(engine);
        }
        if keeps_opening {
            self.results.slots.a.opening = of_lesson.slots.a.opening;
        } else if let Some((request, leaves)) = opening {
            self.open_with(Side::A, request, leaves, engine);
        }
        Some(Effect::ForgetWidgets)
    }

    /// Shows another project, and returns the one on show until now. The dataset, the Lab and the colours of the window
    /// stay, so that their work goes on.
    fn show(&mut self, document: Document, results: Results, history: History) -> (Document, Results, History) {
        let Document { theme, dataset, pairs, lab, .. } = self.document.clone();
        let document = Document { theme, dataset, pairs, lab, ..document };
        let Results { figures, datasets, studies, .. } = &mut self.results;
        let (figures, datasets, studies) = (take(figures), take(datasets), take(studies));
        let results = Results { figures, datasets, studies, ..results };
        self.messages.forget_note();
        (
            replace(&mut self.document, document),
            replace(&mut self.results, results),
            replace(&mut self.history, history),
        )
    }

    fn open_for_step(&mut self, bursts: Sides<Option<BurstSource>>, cameras: bool, engine: &Engine) {
        // The burst that another step requested is not needed any more.
        self.results.slots.a.opening.forget();
        // Which of two bursts was opened last says nothing.
        self.messages.forget_note();
        for (side, source) in [(Side::A, bursts.a), (Side::B, bursts.b)] {
            let is_open = self.burst_of(side).is_some_and(|burst| Some(&burst.source) == source.as_ref());
            let Some(source) = source.filter(|_| !is_open) else { continue };
            // A burst that was open before the lesson need not be opened again.
            let of_user = self.project_of_user().results.slots.both().map(|slot| slot.burst.clone());
            match (side, of_user.into_iter().flatten().find(|burst| burst.source == source)) {
                (Side::A, Some(burst)) => self.take_burst(burst),
                (Side::B, Some(burst)) => self.take_second_burst(burst),
                (side, None) => {
                    let options = OpenOptions::default();
                    self.open_with(side, OpenRequest { source, options }, None, engine);
                }
            }
        }
        if !cameras {
            self.close_trajectories();
        } else if self.results.poses.is_empty() {
            self.show_demo_cameras(engine);
        }
    }

    fn begin_with(&mut self, document: Document, layout: Option<Preset>, probe: Option<[f32; 2]>) {
        self.document = document;
        for side in Side::BOTH {
            if !self.document.auto_detect || !self.features_are_current(side) {
                self.results.slots[side].found = None;
            }
        }
        (self.results.hovered, self.results.reselect, self.results.probed) = Default::default();
        self.check_params();
        self.refresh_listed();
        if let Some(layout) = layout {
            self.lay_out(layout);
        }
        if let Some(place) = probe {
            let panels = self.document.panels;
            self.probe_place(Side::A, place);
            // A probe opens its panel.
            self.document.panels = panels;
        }
        self.settle_ranges();
        self.history.clear();
    }

    pub fn show_document(&mut self, document: Document, reselect: Reselect) {
        for side in Side::BOTH {
            if document.comparisons[side] != self.document.comparisons[side] {
                self.results.slots[side].comparison = ComparisonResults::default();
            }
        }
        if document.probe != self.document.probe {
            self.results.probed = ProbeResults::default();
        }
        self.document = document;
        match reselect {
            Reselect::Feature(feature) => self.results.reselect = feature,
            Reselect::Match(of_match) => self.results.pair.reselect = of_match,
        }
        self.keep_methods_arranged();
        self.check_params();
    }

    fn read_named(&mut self, engine: &Engine) -> Option<Effect> {
        self.read_trajectories(engine);
        match self.document.dataset.clone() {
            Some(DatasetChoice { source, folder, .. }) => {
                self.look_at_dataset(source, folder, self.document.calibration.clone(), engine);
                None
            }
            None => Some(self.close_dataset()),
        }
    }
}
