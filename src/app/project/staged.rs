//! A lesson's project beside the user's, and documents that sessions and lessons put in place of the one on show.

use super::comparison::ComparisonResults;
use super::datasets::DatasetChoice;
use super::own::Own;
use super::pair::SavedMatch;
use super::probe::ProbeResults;
use super::side::{Side, Sides};
use super::workspace::Workspace;
use super::{Effect, Model, Project, SavedSelection};
use crate::app::document::Document;
use crate::app::pane::Preset;
use crate::burst::OpenOptions;
use crate::engine::Engine;
use crate::requests::{BurstSource, OpenRequest};

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
    project: Project,
    opening: Option<(OpenRequest, Option<Own>)>,
}

impl Model {
    pub fn is_in_lesson(&self) -> bool {
        self.of_user.is_some()
    }

    /// The one before the open lesson, or without one that on show.
    pub fn project_of_user(&self) -> &Project {
        self.of_user.as_ref().map_or(&self.project, |of_user| &of_user.project)
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
            Staged::SelectFirst if self.workspace == Workspace::Pair => {
                self.selected_match = self.pair.listed.first().copied();
            }
            Staged::SelectFirst => self.selected = self.listed.first().copied(),
            Staged::Show(document, reselect) => self.show_document(*document, reselect),
            Staged::ReadNamed => return self.read_named(engine),
            Staged::ProbeWhenOpen(source, place) => self.studies.probe_when_open = Some((source, place)),
        }
        None
    }

    fn begin_lesson(&mut self) -> Effect {
        let slot = &mut self.slots.a;
        let opening = slot.opening.pending().map(|request| (request.clone(), slot.leaves.take()));
        self.slots.a.opening.forget();
        let of_lesson =
            Project { document: Document { figure: self.figure, ..Document::default() }, ..Project::default() };
        let project = self.show(of_lesson);
        self.of_user = Some(Box::new(UserProject { project, opening }));
        Effect::ForgetWidgets
    }

    fn end_lesson(&mut self, keeps_opening: bool, engine: &Engine) -> Option<Effect> {
        let UserProject { project, opening } = *self.of_user.take()?;
        let of_lesson = self.show(project);
        if self.poses.reading.pending().is_some() {
            // What was read meanwhile was not taken.
            self.read_trajectories(engine);
        }
        if keeps_opening {
            self.slots.a.opening = of_lesson.slots.a.opening;
        } else if let Some((request, leaves)) = opening {
            self.open_with(Side::A, request, leaves, engine);
        }
        Some(Effect::ForgetWidgets)
    }

    /// Shows another project, and returns the one on show until now. The dataset, the Lab and the colours of the window
    /// stay, so that their work goes on.
    fn show(&mut self, project: Project) -> Project {
        let before = std::mem::replace(&mut self.project, project);
        let Document { theme, dataset, pairs, lab, .. } = before.document.clone();
        let shown = std::mem::take(&mut self.document);
        self.document = Document { theme, dataset, pairs, lab, ..shown };
        self.messages.forget_note();
        before
    }

    fn open_for_step(&mut self, bursts: Sides<Option<BurstSource>>, cameras: bool, engine: &Engine) {
        // The burst that another step requested is not needed any more.
        self.slots.a.opening.forget();
        // Which of two bursts was opened last says nothing.
        self.messages.forget_note();
        for (side, source) in [(Side::A, bursts.a), (Side::B, bursts.b)] {
            let is_open = self.burst_of(side).is_some_and(|burst| Some(&burst.source) == source.as_ref());
            let Some(source) = source.filter(|_| !is_open) else { continue };
            // A burst that was open before the lesson need not be opened again.
            let of_user = self.project_of_user().slots.both().map(|slot| slot.burst.clone());
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
        } else if self.poses.is_empty() {
            self.show_demo_cameras(engine);
        }
    }

    fn begin_with(&mut self, document: Document, layout: Option<Preset>, probe: Option<[f32; 2]>) {
        self.document = document;
        for side in Side::BOTH {
            if !self.auto_detect || !self.features_are_current(side) {
                self.slots[side].found = None;
            }
        }
        (self.hovered, self.reselect, self.probed) = Default::default();
        self.check_params();
        self.refresh_listed();
        if let Some(layout) = layout {
            self.lay_out(layout);
        }
        if let Some(place) = probe {
            let panels = self.panels;
            self.probe_place(Side::A, place);
            // A probe opens its panel.
            self.panels = panels;
        }
        self.settle_ranges();
        self.history.clear();
    }

    pub fn show_document(&mut self, document: Document, reselect: Reselect) {
        for side in Side::BOTH {
            if document.comparisons[side] != self.comparisons[side] {
                self.slots[side].comparison = ComparisonResults::default();
            }
        }
        if document.probe != self.probe {
            self.probed = ProbeResults::default();
        }
        self.document = document;
        match reselect {
            Reselect::Feature(feature) => self.reselect = feature,
            Reselect::Match(of_match) => self.pair.reselect = of_match,
        }
        self.keep_methods_arranged();
        self.check_params();
    }

    fn read_named(&mut self, engine: &Engine) -> Option<Effect> {
        self.read_trajectories(engine);
        match self.document.dataset.clone() {
            Some(DatasetChoice { source, folder, .. }) => {
                self.look_at_dataset(source, folder, self.calibration.clone(), engine);
                None
            }
            None => Some(self.close_dataset()),
        }
    }
}
