//! Comparison of the features of the open burst with a reference: an earlier result that was pinned, features of a
//! file, or the truth. All three may be known; one of them is on show.

mod rows;
mod saved;

pub use rows::{Kind, Row};
pub use saved::SavedAgainst;

use crate::app::project::Model;
use crate::detector::{Detection, SearchParams};
use crate::engine::{Engine, Wanted};
use crate::inspect::foreign::ForeignFeature;
use crate::requests::{Against as Answered, AgainstRequest, BurstId, ComparedWith, JobError, Reference, Request};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// Reference of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum With {
    /// An earlier result.
    Pinned,
    /// Features of a file.
    File,
    /// The truth of the burst.
    Truth,
}

impl With {
    /// All of them, in the order of the switch.
    pub const ALL: [Self; 3] = [Self::Pinned, Self::File, Self::Truth];

    /// Name of the reference.
    pub fn label(self) -> &'static str {
        match self {
            Self::Pinned => "Pinned result",
            Self::File => "Opened features",
            Self::Truth => "Truth",
        }
    }

    /// Explanation of the reference, and how to load it.
    pub fn help(self) -> &'static str {
        match self {
            Self::Pinned => "Gained, lost and moved features against the pinned result",
            Self::File => "Features of a file: in both, only theirs, only ours. Open them from the Features menu",
            Self::Truth => {
                "Known truth: found, missed, repeated and false features. Synthetic bursts and the demo have one; that of a scene is partial, so features elsewhere may be right"
            }
        }
    }
}

/// A comparison as it is shown.
#[derive(Debug, Clone)]
pub struct Shown {
    /// The reference.
    pub with: With,
    /// The features that were compared.
    pub detection: Arc<Detection>,
    /// One row for each feature of ours or theirs; the most interesting first.
    pub rows: Vec<Row>,
    /// The counts in a line.
    pub summary: String,
    /// Whether the truth, if it is the reference, is complete.
    pub is_whole_truth: bool,
    /// Label of rows of ours alone.
    ours: &'static str,
}

impl Shown {
    /// Label of rows of `kind`.
    pub fn label(&self, kind: Kind) -> &'static str {
        if kind == Kind::Ours { self.ours } else { kind.label(self.with) }
    }

    /// Number of rows of `kind`.
    pub fn count(&self, kind: Kind) -> usize {
        self.rows.iter().filter(|row| row.kind == kind).count()
    }
}

/// A result that was pinned.
#[derive(Debug, Clone)]
pub struct Pinned {
    burst: BurstId,
    asked: SearchParams,
    /// `None` after a session was opened, until the detection is repeated.
    detection: Option<Arc<Detection>>,
}

/// Features of a file.
#[derive(Debug, Clone)]
pub struct ForeignFile {
    burst: BurstId,
    /// The file.
    pub path: PathBuf,
    features: Option<Arc<Vec<ForeignFeature>>>,
}

/// The comparison of the features.
#[derive(Debug, Default)]
pub struct Against {
    /// The pinned result.
    pub pinned: Option<Pinned>,
    /// The opened features of a file.
    pub file: Option<ForeignFile>,
    /// Burst that was checked for a truth, and whether it has one.
    truth: Option<(BurstId, bool)>,
    /// Reference of the comparison on show.
    pub with: Option<With>,
    /// The comparison, once it was made.
    pub shown: Option<Arc<Shown>>,
    /// Kinds that are not drawn and not listed.
    pub hidden: Vec<Kind>,
    /// The selected row.
    pub selected: Option<usize>,
    /// The row under the pointer.
    pub hovered: Option<usize>,
    /// The request for the comparison.
    pub wanted: Wanted<AgainstRequest>,
    /// Error for which there is no comparison.
    pub problem: Option<String>,
}

impl Against {
    /// Whether the reference `with` is loaded or known.
    pub fn has(&self, with: With) -> bool {
        match with {
            With::Pinned => self.pinned.is_some(),
            With::File => self.file.is_some(),
            With::Truth => self.truth.is_some_and(|(_, known)| known),
        }
    }

    /// Shows the comparison with `with`, or none.
    pub fn show(&mut self, with: Option<With>) {
        if self.with != with {
            (self.with, self.shown, self.problem) = (with, None, None);
            self.wanted.forget();
            (self.selected, self.hovered) = (None, None);
            // Unchanged features are hidden, so that the changes stand out.
            self.hidden = if with == Some(With::Pinned) { vec![Kind::Same] } else { Vec::new() };
        }
    }

    /// Whether rows of `kind` are drawn and listed.
    pub fn shows(&self, kind: Kind) -> bool {
        !self.hidden.contains(&kind)
    }
}

impl Model {
    /// Pins the features on show: later results are compared with them.
    pub fn pin_result(&mut self) {
        if let (Some(burst), Some(found)) = (&self.slots.a.burst, &self.slots.a.found) {
            let (asked, detection) = (found.asked.clone(), Some(found.detection.clone()));
            self.against.pinned = Some(Pinned { burst: burst.id, asked, detection });
            // The comparison with an earlier pin is dropped.
            self.against.show(None);
            self.against.show(Some(With::Pinned));
        }
    }

    /// Forgets the pinned result.
    pub fn unpin_result(&mut self) {
        self.against.pinned = None;
        if self.against.with == Some(With::Pinned) {
            self.against.show(None);
        }
    }

    /// Compares with the features of the file at `path`.
    pub fn lay_over(&mut self, path: PathBuf) {
        if let Some(burst) = &self.slots.a.burst {
            self.against.file = Some(ForeignFile { burst: burst.id, path, features: None });
            self.against.show(None);
            self.against.show(Some(With::File));
        }
    }

    /// Forgets the opened features.
    pub fn forget_foreign(&mut self) {
        self.against.file = None;
        if self.against.with == Some(With::File) {
            self.against.show(None);
        }
    }

    /// Forgets the references of a burst that is not open any more.
    pub fn check_against(&mut self) {
        let open = self.slots.a.burst.as_ref().map(|burst| burst.id);
        self.against.pinned.take_if(|pinned| Some(pinned.burst) != open);
        self.against.file.take_if(|file| Some(file.burst) != open);
        if self.against.truth.map(|(burst, _)| burst) != open {
            self.against.truth = self.slots.a.burst.as_ref().map(|b| (b.id, b.has_truth()));
        }
        if self.against.with.is_some_and(|with| !self.against.has(with)) {
            self.against.show(None);
        }
    }

    /// Takes the comparison, or its error.
    pub(in crate::app) fn take_comparisons(&mut self) {
        for ended in self.against.wanted.take() {
            match ended.result {
                Ok(compared) => self.take_comparison(compared),
                Err(JobError::Cancelled) => self.against.problem = Some("Cancelled".to_owned()),
                Err(error) => self.against.problem = Some(error.to_string()),
            }
        }
    }

    /// Requests the comparison if it is missing.
    pub(in crate::app) fn ask_for_comparison(&mut self, engine: &Engine) {
        self.check_against();
        let is_there = self.shown_comparison().is_some_and(|shown| Some(shown.with) == self.against.with);
        let missing = self.wanted_comparison().filter(|_| !is_there);
        if missing.as_ref().is_some_and(|missing| !self.against.wanted.has_failed(missing)) {
            self.against.problem = None;
        }
        self.against.wanted.want(engine, missing);
    }

    /// The comparison that is wanted now.
    pub fn wanted_comparison(&self) -> Option<AgainstRequest> {
        let (found, burst) = (self.slots.a.found.as_ref()?, self.slots.a.burst.as_ref()?);
        let with = match self.against.with? {
            With::Pinned => {
                let Pinned { asked, detection, .. } = self.against.pinned.clone()?;
                Reference::Earlier { burst: burst.clone(), asked, detection }
            }
            With::File => {
                let file = self.against.file.as_ref()?;
                Reference::File { path: file.path.clone(), features: file.features.clone() }
            }
            With::Truth => Reference::Truth { burst: burst.clone(), params: found.params.clone() },
        };
        Some(AgainstRequest { detection: found.detection.clone(), with })
    }

    /// Takes a comparison, unless another one is wanted by now.
    pub fn take_comparison(&mut self, compared: ComparedWith) {
        let ComparedWith { request, against } = compared;
        let Some(with) = self.against.with else { return };
        if !self.wanted_comparison().is_some_and(|wanted| wanted.is_same(&request)) {
            return;
        }
        if let (Some(pinned), Some(found)) = (&mut self.against.pinned, against.found_again()) {
            pinned.detection = Some(found.clone());
        }
        if let (Some(file), Some(read)) = (&mut self.against.file, against.read()) {
            file.features = Some(read.clone());
        }
        let (is_whole_truth, ours) = match &against {
            Answered::Truth { against, .. } => (against.is_whole_truth, against.name_of_elsewhere()),
            Answered::Changes { .. } => (true, Kind::Ours.label(with)),
        };
        if self.against.shown.is_none() && !is_whole_truth {
            self.against.hidden = vec![Kind::Ours];
        }
        let (rows, summary) = rows::of(with, &request.detection, &against);
        self.against.shown =
            Some(Arc::new(Shown { with, detection: request.detection, rows, summary, is_whole_truth, ours }));
        (self.against.selected, self.against.hovered, self.against.problem) = (None, None, None);
    }

    /// The comparison that is drawn over the pictures of A: that of the features on show.
    pub fn shown_comparison(&self) -> Option<&Arc<Shown>> {
        let found = self.slots.a.found.as_ref()?;
        self.against.shown.as_ref().filter(|shown| Arc::ptr_eq(&shown.detection, &found.detection))
    }
}
