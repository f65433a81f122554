//! Answers of the engine about what the document opens, a file a part, and the requests for those that are missing.
//!
//! Nothing in this room changes what is set. Panels and panes get `Read`, whose methods are values of the document and
//! the results; `app/apply` takes the answers and requests what is missing.

use crate::app::document::{Document, Filter, History, Order, Purpose, SavedSelection, Side, Sides};
use crate::app::{memo::Itself, messages::Messages, pane::PaneId};
use crate::burst::Positions;
use crate::dataset::DatasetSource;
use crate::detector::{Quantity, SearchParams, Slope};
use crate::engine::{Ended, Wanted};
use crate::figures::FiguresJob;
use crate::inspect::{result::DecoyReport, slopes::SetUp};
use crate::requests::{
    BurstSource, FigurePreview, FigureRequest, FolderRequest, OpenRequest, PictureAnswer, PictureRequest,
    PossibleShape, ShapeRequest,
};
use crate::teach::Lesson;
use compare::Compare;
use explained::{CoherenceState, ExplainedState};
use pair::PairState;
use pictures::{PatchResults, Preview};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use studies::TrajectoryResults;

pub mod compare;
pub mod comparison;
pub mod datasets;
pub mod explained;
pub mod own;
pub mod pair;
pub mod panes;
pub mod pictures;
pub mod probe;
pub mod slot;
pub mod studies;

pub use compare::MethodFound;
pub use comparison::ComparisonResults;
pub use datasets::{BurstState, Dataset, Datasets, Work};
pub use explained::{coherence_words, verdict_words};
pub use own::Own;
pub use pair::{MatchRow, Matches, PAIR_NUMBERS, PATCHES, lost_words};
pub use probe::ProbeResults;
pub use slot::{FoundFeatures, Slot, Stale};
pub use studies::{LabResult, PlaneScene, Spot};

/// All of the window: what the user has set, what was found by it, and what belongs to no project.
#[derive(Debug, Default)]
pub struct Model {
    pub document: Document,
    pub results: Results,
    pub shell: Shell,
}

/// State of the window that is of no project: steps to undo, messages, width, and during a lesson the user's project.
#[derive(Debug, Default)]
pub struct Shell {
    pub history: History,
    pub of_user: Option<Box<UserProject>>,
    pub window_width_points: f32,
    pub messages: Messages,
    pub play: panes::Play,
}

/// All of the window to read, which is what panels and panes get.
#[derive(Debug, Clone, Copy)]
pub struct Read<'a> {
    pub document: &'a Document,
    pub results: &'a Results,
    pub shell: &'a Shell,
}

/// What the engine answered about what the document opens, what it is asked, and what is pointed at in the answers.
#[derive(Debug, Default)]
pub struct Results {
    pub slots: Sides<Slot>,
    pub pictures: HashMap<PaneId, PanePicture>,
    pub patches: PatchResults,
    pub preview: Preview<FigureRequest, FigurePreview>,
    pub shape: Preview<ShapeRequest, PossibleShape>,
    pub folder: Preview<FolderRequest, Vec<String>>,
    pub hovered: Option<usize>,
    pub reselect: Option<SavedSelection>,
    /// Indices of the features that pass the filter, in the table's order; see `explained::refresh_listed`.
    pub listed: Vec<usize>,
    /// Rate of the listed features, against those that the filter lets through of the decoys.
    pub listed_decoys: Option<DecoyReport>,
    pub pair: PairState,
    pub compare: Compare,
    pub explained: ExplainedState,
    pub coherence: CoherenceState,
    pub probed: ProbeResults,
    pub poses: TrajectoryResults,
    /// What was set for another burst than the open one, until the user decides on it.
    pub left_behind: Option<own::Own>,
    pub listed_for: Option<ListedFor>,
    pub figures: Wanted<FiguresJob>,
    pub datasets: Datasets,
    pub studies: studies::Studies,
}

/// The detection, its verdicts and decoys, filter, order, slope and set-up by which features are listed.
type ListedFor = (Itself, [Option<Itself>; 2], Filter, Order<Quantity>, Slope, Option<SetUp>);

impl Results {
    pub fn pointed(&self) -> impl PartialEq + use<> {
        let probe = (self.probed.pointer, self.probed.as_dots.clone());
        let rows = self.slots.both().map(|slot| slot.comparison.hovered);
        (self.hovered, self.explained.pointed, rows, self.pair.hovered, self.poses.hovered, probe, self.patches.loupe)
    }
}

/// Picture of a pane: the last one of its burst, and the request.
#[derive(Debug, Default)]
pub struct PanePicture {
    pub picture: Option<PictureAnswer>,
    /// Later picture on coarse pixels, which is drawn until it is there whole.
    pub preview: Option<PictureAnswer>,
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
    /// Asks how to cut the files of a burst with this many frames.
    Cut(Vec<PathBuf>, usize),
    ReplaceFeatures,
    /// The thumbnails are of another dataset, or were made with another calibration.
    ForgetThumbnails,
    Ask(Purpose),
    UseFiles(Purpose, Vec<PathBuf>),
    /// A file is being written, in place of an older file where the user agreed.
    Write(Purpose, PathBuf),
    StartLesson(Arc<Lesson>),
    ForgetWidgets,
}

/// Project of the user while a lesson is open, and the burst that was being opened in it.
#[derive(Debug)]
pub struct UserProject {
    pub document: Document,
    pub results: Results,
    pub history: History,
    pub opening: Option<(OpenRequest, Option<Own>)>,
}

impl From<Document> for Model {
    fn from(document: Document) -> Self {
        Self { document, ..Self::default() }
    }
}

impl<'a> Read<'a> {
    pub fn of(model: &'a Model) -> Self {
        let Model { document, results, shell } = model;
        Self { document, results, shell }
    }

    pub fn frame_count(self) -> usize {
        self.burst_of(Side::A).map_or(0, |b| b.burst.len())
    }

    /// Positions of the frames of A that are searched; those of ten frames where nothing is open.
    pub fn used_positions(self) -> Positions {
        let all = self.burst_of(Side::A).map_or_else(|| Positions::even(10), |open| open.burst.positions.clone());
        all.part(self.document.params.used_frames(all.len()))
    }

    /// Indices of the matches of two bursts, or else of A's features, as their table lists them.
    pub fn listed(self) -> &'a [usize] {
        if self.document.workspace.shows_pair() { &self.results.pair.listed } else { &self.results.listed }
    }

    pub fn asked(self) -> SearchParams {
        self.asked_of(Side::A)
    }

    pub fn needs_detection(self, side: Side) -> bool {
        let slot = &self.results.slots[side];
        slot.burst.is_some() && slot.param_error.is_none() && !self.features_are_current(side)
    }

    pub fn is_in_lesson(self) -> bool {
        self.shell.of_user.is_some()
    }

    /// The project before the open lesson, or the project on show.
    pub fn project_of_user(self) -> Read<'a> {
        let of_user = self.shell.of_user.as_deref();
        of_user.map_or(self, |of_user| Read { document: &of_user.document, results: &of_user.results, ..self })
    }
}
