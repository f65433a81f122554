//! Comparison of the features of a burst with a reference: an earlier result that was pinned, features of a file, or
//! the truth. All three may be known; one of them is on show. Each of the two bursts has a comparison of its own, in
//! the document, and its results in its slot.

mod rows;

pub use rows::Row;

use crate::app::document::{Compared, Comparison, Reference, Side};
use crate::app::results::Read;
use crate::detector::{Detection, SearchParams};
use crate::engine::Wanted;
use crate::inspect::result::ForeignFeature;
use crate::requests::{BurstId, ComparedWith, ComparisonRequest, Differences, JobError, ReferenceSource};
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Debug, Clone)]
pub struct Shown {
    pub with: Reference,
    pub detection: Arc<Detection>,
    /// One row for each feature of ours or theirs; the most interesting first.
    pub rows: Vec<Row>,
    pub summary: String,
    pub is_whole_truth: bool,
    ours: &'static str,
}

impl Shown {
    pub fn label(&self, kind: Compared) -> &'static str {
        if kind == Compared::Ours { self.ours } else { kind.label(self.with) }
    }

    pub fn count(&self, kind: Compared) -> usize {
        self.rows.iter().filter(|row| row.kind == kind).count()
    }
}

#[derive(Debug, Default)]
pub struct ComparisonResults {
    pub pinned: Option<(SearchParams, Arc<Detection>)>,
    pub file: Option<(PathBuf, Arc<Vec<ForeignFeature>>)>,
    pub truth: Option<(BurstId, bool)>,
    pub shown: Option<Arc<Shown>>,
    pub hovered: Option<usize>,
    pub wanted: Wanted<ComparisonRequest>,
}

impl<'a> Read<'a> {
    pub fn has_reference(self, side: Side, with: Reference) -> bool {
        let set = &self.document.comparisons[side];
        match with {
            Reference::Pinned => set.pinned.is_some(),
            Reference::File => set.file.is_some(),
            Reference::Truth => self.results.slots[side].comparison.truth.is_some_and(|(_, known)| known),
        }
    }

    pub fn missing_comparison(self, side: Side) -> Option<ComparisonRequest> {
        let with = self.document.comparisons[side].with;
        let is_there = self.shown_comparison(side).is_some_and(|shown| Some(shown.with) == with);
        self.wanted_comparison(side).filter(|_| !is_there)
    }

    pub fn wanted_comparison(self, side: Side) -> Option<ComparisonRequest> {
        let (burst, found) = (self.burst_of(side)?.clone(), self.whole_found_of(side)?);
        let (set, known) = (&self.document.comparisons[side], &self.results.slots[side].comparison);
        let with = match set.with? {
            Reference::Pinned => {
                let asked = set.pinned.clone()?;
                let detection = known.pinned.as_ref().filter(|(of, _)| *of == asked).map(|(_, found)| found.clone());
                ReferenceSource::Earlier { burst, asked, detection }
            }
            Reference::File => {
                let path = set.file.clone()?;
                let features = known.file.as_ref().filter(|(of, _)| *of == path).map(|(_, read)| read.clone());
                ReferenceSource::File { path, features }
            }
            Reference::Truth => ReferenceSource::Truth { burst, params: found.params.clone() },
        };
        Some(ComparisonRequest { detection: found.detection.clone(), with })
    }

    /// The comparison of `side` that is drawn over the pictures: that of the features on show.
    pub fn shown_comparison(self, side: Side) -> Option<&'a Arc<Shown>> {
        let found = self.found_of(side)?;
        let shown = self.results.slots[side].comparison.shown.as_ref();
        shown.filter(|shown| Arc::ptr_eq(&shown.detection, &found.detection))
    }
}

impl ComparisonResults {
    /// Why the last comparison that was asked for was not made.
    pub fn problem(&self) -> Option<String> {
        self.wanted.failure().map(|(_, why)| match why {
            JobError::Cancelled => "Cancelled".to_owned(),
            why => why.to_string(),
        })
    }

    pub fn take(&mut self, compared: ComparedWith, set: &mut Comparison) {
        let (ComparedWith { request, differences }, Some(with)) = (compared, set.with) else { return };
        let (is_whole_truth, ours) = match &differences {
            Differences::Truth { against, .. } => (against.is_whole_truth, against.name_of_elsewhere()),
            Differences::Changes { .. } => (true, Compared::Ours.label(with)),
        };
        match request.with {
            ReferenceSource::Earlier { asked, detection, .. } => self.pinned = detection.map(|found| (asked, found)),
            ReferenceSource::File { path, features } => self.file = features.map(|read| (path, read)),
            ReferenceSource::Truth { .. } => {}
        }
        if self.shown.is_none() && !is_whole_truth {
            set.hidden = vec![Compared::Ours];
        }
        let (rows, summary) = rows::of(with, &request.detection, &differences);
        self.shown = Some(Arc::new(Shown { with, detection: request.detection, rows, summary, is_whole_truth, ours }));
        (set.selected, self.hovered) = (None, None);
    }
}
