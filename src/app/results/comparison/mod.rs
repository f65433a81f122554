//! Comparison of the features of a burst with a reference: an earlier result that was pinned, features of a file, or
//! the truth. All three may be known; one of them is on show. Each of the two bursts has a comparison of its own, in
//! the document, and its results in its slot.

mod rows;

pub use rows::Row;

use crate::app::document::comparison::{Comparison, Kind, Reference};
use crate::app::document::look::FeaturesShown;
use crate::app::document::side::Side;
use crate::app::results::Model;
use crate::detector::{Detection, SearchParams};
use crate::engine::{Ended, Wanted};
use crate::inspect::changes::ForeignFeature;
use crate::requests::{BurstId, ComparedWith, ComparisonRequest, Differences, JobError, OthersSource, ReferenceSource};
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
    pub fn label(&self, kind: Kind) -> &'static str {
        if kind == Kind::Ours { self.ours } else { kind.label(self.with) }
    }

    pub fn count(&self, kind: Kind) -> usize {
        self.rows.iter().filter(|row| row.kind == kind).count()
    }
}

#[derive(Debug, Default)]
pub struct ComparisonResults {
    pinned: Option<(SearchParams, Arc<Detection>)>,
    file: Option<(PathBuf, Arc<Vec<ForeignFeature>>)>,
    truth: Option<(BurstId, bool)>,
    pub shown: Option<Arc<Shown>>,
    pub hovered: Option<usize>,
    pub wanted: Wanted<ComparisonRequest>,
    pub problem: Option<String>,
}

impl Model {
    pub fn has_reference(&self, side: Side, with: Reference) -> bool {
        let set = &self.document.comparisons[side];
        match with {
            Reference::Pinned => set.pinned.is_some(),
            Reference::File => set.file.is_some(),
            Reference::Truth => self.results.slots[side].comparison.truth.is_some_and(|(_, known)| known),
        }
    }

    pub(super) fn compare_with(&mut self, side: Side, with: Option<Reference>) {
        let (set, results) = (&mut self.document.comparisons[side], &mut self.results.slots[side].comparison);
        if set.with != with {
            // Unchanged features are hidden, so that the changes stand out.
            let hidden = if with == Some(Reference::Pinned) { vec![Kind::Same] } else { Vec::new() };
            (set.with, set.selected, set.hidden) = (with, None, hidden);
            (results.shown, results.hovered, results.problem) = (None, None, None);
            results.wanted.forget();
            // What is compared is of all slopes, until one is asked for.
            let overlay = &mut self.document.look.overlay;
            if *overlay != FeaturesShown::None {
                *overlay = if with.is_some() { FeaturesShown::All } else { FeaturesShown::ThisSlope };
            }
        }
    }

    pub fn pin_result(&mut self, side: Side) {
        let slot = &mut self.results.slots[side];
        if let Some(found) = &slot.found {
            slot.comparison.pinned = Some((found.asked.clone(), found.detection.clone()));
            self.document.comparisons[side].pinned = Some(found.asked.clone());
            // The comparison with an earlier pin is dropped.
            self.compare_with(side, None);
            self.show_comparison(side, Some(Reference::Pinned));
        }
    }

    pub fn lay_over(&mut self, side: Side, path: PathBuf) {
        if self.results.slots[side].burst.is_some() {
            self.results.slots[side].comparison.file = None;
            self.document.comparisons[side].file = Some(path);
            self.compare_with(side, None);
            self.show_comparison(side, Some(Reference::File));
        }
    }

    pub fn forget_reference(&mut self, side: Side, with: Reference) {
        let set = &mut self.document.comparisons[side];
        match with {
            Reference::Pinned => set.pinned = None,
            Reference::File => set.file = None,
            Reference::Truth => {}
        }
        if set.with == Some(with) {
            self.compare_with(side, None);
        }
    }

    /// Selects a row of the comparison of `side`, and of A its feature.
    pub fn select_row(&mut self, side: Side, row: Option<usize>) {
        self.document.comparisons[side].selected = row;
        if side == Side::A {
            let shown = &self.results.slots.a.comparison.shown;
            self.document.selected = row.and_then(|row| shown.as_ref()?.rows.get(row)?.feature);
        }
    }

    pub(super) fn take_comparison(&mut self, side: Side, ended: Ended<ComparisonRequest>) {
        let is_wanted = self.wanted_comparison(side).is_some_and(|wanted| wanted == ended.request);
        let (set, results) = (&mut self.document.comparisons[side], &mut self.results.slots[side].comparison);
        match ended.result {
            Ok(compared) if is_wanted => results.take(compared, set),
            Ok(_) => {}
            Err(JobError::Cancelled) => results.problem = Some("Cancelled".to_owned()),
            Err(error) => results.problem = Some(error.to_string()),
        }
    }

    /// Ends comparisons with a reference that is not there any more, and forgets why the one before was not made.
    pub(super) fn check_references(&mut self) {
        for side in Side::BOTH {
            let slot = &mut self.results.slots[side];
            let (open, comparison) = (slot.burst.as_ref(), &mut slot.comparison);
            if comparison.truth.map(|(burst, _)| burst) != open.map(|open| open.id) {
                comparison.truth = open.map(|open| (open.id, open.has_truth()));
            }
            if self.document.comparisons[side].with.is_some_and(|with| !self.has_reference(side, with)) {
                self.compare_with(side, None);
            }
            let missing = self.missing_comparison(side);
            let results = &mut self.results.slots[side].comparison;
            if missing.is_some_and(|missing| !results.wanted.has_failed(&missing)) {
                results.problem = None;
            }
        }
    }

    pub(super) fn missing_comparison(&self, side: Side) -> Option<ComparisonRequest> {
        let with = self.document.comparisons[side].with;
        let is_there = self.shown_comparison(side).is_some_and(|shown| Some(shown.with) == with);
        self.wanted_comparison(side).filter(|_| !is_there)
    }

    fn wanted_comparison(&self, side: Side) -> Option<ComparisonRequest> {
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
    pub fn shown_comparison(&self, side: Side) -> Option<&Arc<Shown>> {
        let found = self.found_of(side)?;
        self.results.slots[side]
            .comparison
            .shown
            .as_ref()
            .filter(|shown| Arc::ptr_eq(&shown.detection, &found.detection))
    }

    pub(in crate::app) fn begin_comparison(&mut self, side: Side) {
        let set = self.document.comparisons[side].of_next_burst();
        self.restore_comparison(side, set);
    }

    pub fn restore_comparison(&mut self, side: Side, set: Comparison) {
        self.results.slots[side].comparison = ComparisonResults::default();
        self.document.comparisons[side] = set;
    }
}

impl ComparisonResults {
    /// Takes the answer that is wanted now.
    fn take(&mut self, compared: ComparedWith, set: &mut Comparison) {
        let (ComparedWith { request, differences }, Some(with)) = (compared, set.with) else { return };
        let (is_whole_truth, ours) = match &differences {
            Differences::Truth { against, .. } => (against.is_whole_truth, against.name_of_elsewhere()),
            Differences::Changes { source, .. } => {
                match (&request.with, source) {
                    (ReferenceSource::Earlier { asked, .. }, OthersSource::Earlier(found)) => {
                        self.pinned = Some((asked.clone(), found.clone()));
                    }
                    (ReferenceSource::File { path, .. }, OthersSource::File(read)) => {
                        self.file = Some((path.clone(), read.clone()));
                    }
                    _ => {}
                }
                (true, Kind::Ours.label(with))
            }
        };
        if self.shown.is_none() && !is_whole_truth {
            set.hidden = vec![Kind::Ours];
        }
        let (rows, summary) = rows::of(with, &request.detection, &differences);
        self.shown = Some(Arc::new(Shown { with, detection: request.detection, rows, summary, is_whole_truth, ours }));
        (set.selected, self.hovered, self.problem) = (None, None, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::results::tests::Bench;

    #[test]
    fn either_burst_is_compared_with_its_own_truth_and_takes_the_comparison_along() {
        let mut bench = Bench::with_two_charts();
        bench.model.show_comparison(Side::B, Some(Reference::Truth));
        assert!(bench.model.document.match_look.features, "the comparison is seen");
        bench.run_until(|model, _| model.shown_comparison(Side::B).is_some());
        assert!(bench.model.shown_comparison(Side::A).is_none());
        bench.model.show_comparison(Side::A, Some(Reference::Truth));
        bench.run_until(|model, _| model.shown_comparison(Side::A).is_some());
        let summaries = |model: &Model| Side::BOTH.map(|side| model.shown_comparison(side).map(|s| s.summary.clone()));
        for side in Side::BOTH {
            let (slot, shown) =
                (&bench.model.results.slots[side], bench.model.shown_comparison(side).expect("there").clone());
            assert!(Arc::ptr_eq(&shown.detection, &slot.found.as_ref().expect("found").detection));
            // All discs of the side's own chart are found or missed.
            let discs = shown.count(Kind::Same) + shown.count(Kind::Theirs);
            let truth = slot.burst.as_ref().expect("open").truth(&crate::Monitor::default()).expect("valid");
            assert_eq!(discs, truth.expect("a chart").features.len());
            assert!(shown.count(Kind::Same) > 0, "{}", shown.summary);
        }
        let before = summaries(&bench.model);
        bench.model.swap_sides();
        bench.settle();
        let [a, b] = summaries(&bench.model);
        assert_eq!([b, a], before);
    }
}
