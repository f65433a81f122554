//! What the engine answered about what the document opens: a file a part, which says what is missing, as a value of the
//! document and the results, and how an answer is taken.
//!
//! In each pass the window takes the answers that came, and requests what is missing: `asking.rs` has the list.

mod asking;
pub mod compare;
pub mod comparison;
pub mod datasets;
pub mod explained;
pub mod lab;
pub mod listed;
pub mod own;
pub mod pair;
pub mod panes;
mod pictures;
pub mod probe;
pub mod slot;
pub mod staged;
pub mod trajectories;

pub use slot::{FoundFeatures, Stale};

use crate::app::document::export::Purpose;
use crate::app::document::filter::SavedSelection;
use crate::app::document::history::History;
use crate::app::document::side::{Side, Sides};
use crate::app::document::{Document, Pointed};
use crate::app::messages::Messages;
use crate::app::pane::PaneId;
use crate::burst::Positions;
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::engine::{Ended, Engine, Want, Wanted};
use crate::figures::FiguresJob;
use crate::requests::{BurstSource, OpenRequest, Picture, PictureRequest, PossibleShape, Request};
use crate::teach::Lesson;
use compare::Compare;
use datasets::Datasets;
use explained::{CoherenceState, ExplainedState};
use pair::PairState;
use probe::ProbeResults;
use slot::Slot;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use trajectories::TrajectoryResults;

/// All of the window: what the user has set, what was found by it, the steps to undo, and what belongs to no project.
#[derive(Debug, Default)]
pub struct Model {
    pub document: Document,
    pub results: Results,
    pub history: History,
    of_user: Option<Box<staged::UserProject>>,
    pub window_width_points: f32,
    pub messages: Messages,
    play: panes::Play,
}

/// A project to read: what is set, and what was found by it.
#[derive(Debug, Clone, Copy)]
pub struct Read<'a> {
    pub document: &'a Document,
    pub results: &'a Results,
}

/// What the engine answered about what the document opens, what it is asked, and what is pointed at in the answers.
#[derive(Debug, Default)]
pub struct Results {
    pub slots: Sides<Slot>,
    pub pictures: HashMap<PaneId, PanePicture>,
    pub patch: Option<Picture>,
    pub wanted_patch: Wanted<PictureRequest>,
    pub hovered: Option<usize>,
    pub reselect: Option<SavedSelection>,
    /// Indices of the features that pass the filter, in the table's order; see [`Model::refresh_listed`].
    pub listed: Vec<usize>,
    pub pair: PairState,
    pub compare: Compare,
    pub explained: ExplainedState,
    pub coherence: CoherenceState,
    pub probed: ProbeResults,
    pub poses: TrajectoryResults,
    /// What was set for another burst than the open one, until the user decides on it.
    pub left_behind: Option<own::Own>,
    listed_for: Option<listed::ListedFor>,
    pub figures: Wanted<FiguresJob>,
    pub datasets: Datasets,
    pub studies: lab::Studies,
}

/// Picture of a pane: the last one of its burst, why the last request failed, and the request.
#[derive(Debug, Default)]
pub struct PanePicture {
    pub picture: Option<Picture>,
    pub problem: Option<(PictureRequest, String)>,
    pub wanted: Wanted<PictureRequest>,
}

/// Change beyond what is set and found: a value that a part returns, and that the window applies.
#[derive(Debug)]
pub enum Effect {
    /// Opening a burst for a side ended, with or without success; a session may have waited for it.
    Opened(Side, Ended<OpenRequest>),
    Recent(BurstSource),
    RecentDataset(DatasetSource),
    Choose(Side, Vec<BurstSource>),
    /// Asks for the shape of a file without header, which may be one of these.
    AskShape(Side, BurstSource, Vec<PossibleShape>),
    Cut {
        paths: Vec<PathBuf>,
        frames: usize,
    },
    ReplaceFeatures,
    /// The thumbnails are of another dataset, or were made with another calibration.
    ForgetThumbnails,
    Ask(Purpose),
    UseFiles(Purpose, Vec<PathBuf>),
    /// A file is written. The user agreed that it may replace one that is there.
    Write(Purpose, PathBuf),
    StartLesson(Arc<Lesson>),
    ForgetWidgets,
}

impl From<Document> for Model {
    fn from(document: Document) -> Self {
        Self { document, ..Self::default() }
    }
}

impl Model {
    pub fn read(&self) -> Read<'_> {
        Read { document: &self.document, results: &self.results }
    }

    /// (columns, rows) of the open burst's frames; (0, 0) without one.
    pub fn size(&self) -> (usize, usize) {
        self.results.slots.a.burst.as_ref().map_or((0, 0), |b| b.burst.size())
    }

    /// Things under the pointer.
    pub fn pointed(&self) -> impl PartialEq + use<> {
        let probe = (self.results.probed.pointer, self.results.probed.as_dots.clone());
        let rows = self.results.slots.both().map(|slot| slot.comparison.hovered);
        (
            self.results.hovered,
            self.results.explained.pointed,
            rows,
            self.results.pair.hovered,
            self.results.poses.hovered,
            probe,
        )
    }

    pub fn point_at(&mut self, pointed: Pointed) {
        match pointed {
            Pointed::Feature(index) => self.results.hovered = index,
            Pointed::Candidate(index) => self.results.explained.pointed = index,
            Pointed::Row(side, row) => self.results.slots[side].comparison.hovered = row,
            Pointed::Match(index) => self.results.pair.hovered = index,
            Pointed::Camera(index) => self.results.poses.hovered = index,
            Pointed::Place(place) => self.results.probed.pointer = place,
            Pointed::Dots(features) => self.results.probed.as_dots = features,
            Pointed::Lines(drawn, all) => self.results.pair.lines_drawn = (drawn, all),
        }
    }

    pub fn frame_count(&self) -> usize {
        self.results.slots.a.burst.as_ref().map_or(0, |b| b.burst.len())
    }

    /// Positions of the frames of A that are searched; those of ten frames where nothing is open.
    pub fn used_positions(&self) -> Positions {
        let all = self
            .results
            .slots
            .a
            .burst
            .as_ref()
            .map_or_else(|| Positions::even(10), |open| open.burst.positions.clone());
        all.part(self.document.params.used_frames(all.len()))
    }

    pub fn asked(&self) -> SearchParams {
        self.asked_of(Side::A)
    }

    pub fn needs_detection(&self, side: Side) -> bool {
        let slot = &self.results.slots[side];
        let is_made = |found: &FoundFeatures| found.asked == self.asked_of(side);
        slot.burst.is_some() && slot.param_error.is_none() && !slot.found.as_ref().is_some_and(is_made)
    }
}

/// Pass of the window. While the pointer drags a value, long work waits for the final one.
pub(super) struct Pass<'a> {
    pub model: &'a mut Model,
    pub engine: &'a Engine,
    pub dragging: bool,
}

pub(super) trait Part {
    fn wants<'m>(&self, model: &'m Model) -> Vec<&'m dyn Want>;

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect>;

    fn ask(&self, pass: &mut Pass<'_>);

    /// Whether all that this part wants is there, or failed.
    fn is_there(&self, model: &Model) -> bool;
}

/// A part that wants one thing.
pub(super) struct One<R: Request> {
    pub wanted: fn(&Model) -> &Wanted<R>,
    pub wanted_mut: fn(&mut Model) -> &mut Wanted<R>,
    /// Request for what is missing now, with and without a drag.
    pub missing: fn(&Model, bool) -> Option<R>,
    /// Whether a request ends when nothing is missing any more.
    pub ends: bool,
    pub take: fn(&mut Model, Ended<R>, &Engine) -> Vec<Effect>,
    /// Takes what was done of a request that still runs.
    pub take_partial: fn(&mut Model, R::Partial),
}

impl<R: Request> Part for One<R> {
    fn wants<'m>(&self, model: &'m Model) -> Vec<&'m dyn Want> {
        vec![(self.wanted)(model)]
    }

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect> {
        for partial in (self.wanted_mut)(pass.model).take_partial() {
            (self.take_partial)(pass.model, partial);
        }
        let ended = (self.wanted_mut)(pass.model).take();
        ended.into_iter().flat_map(|ended| (self.take)(pass.model, ended, pass.engine)).collect()
    }

    fn ask(&self, pass: &mut Pass<'_>) {
        let missing = (self.missing)(pass.model, pass.dragging);
        if self.ends || missing.is_some() {
            (self.wanted_mut)(pass.model).want(pass.engine, missing);
        }
    }

    fn is_there(&self, model: &Model) -> bool {
        (self.missing)(model, false).is_none_or(|missing| (self.wanted)(model).has_failed(&missing))
    }
}

#[cfg(test)]
pub(in crate::app) mod tests;
