//! Comparison of the features of a burst with a reference: an earlier result that was pinned, features of a file, or
//! the truth. All three may be known; one of them is on show. Each of the two bursts has a comparison of its own, in
//! its slot.

mod rows;

pub use rows::{Kind, Row};

use crate::app::project::side::Side;
use crate::app::project::{FoundFeatures, Model};
use crate::detector::{Detection, SearchParams};
use crate::engine::{Engine, Wanted};
use crate::inspect::changes::ForeignFeature;
use crate::requests::{Against as Answered, AgainstRequest, BurstId, ComparedWith, JobError, OpenBurst, Reference};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum With {
    Pinned,
    File,
    Truth,
}

impl With {
    pub const ALL: [Self; 3] = [Self::Pinned, Self::File, Self::Truth];

    pub fn label(self) -> &'static str {
        match self {
            Self::Pinned => "Pinned result",
            Self::File => "Opened features",
            Self::Truth => "Truth",
        }
    }

    pub fn help(self) -> &'static str {
        match self {
            Self::Pinned => "Gained, lost and moved features against the pinned result",
            Self::File => "Features of a file: in both, only theirs, only ours. Open them from the Features menu",
            Self::Truth => {
                "Known truth: found, missed, repeated and false features, and those at a wrong motion: more than 0.35 px/frame off, or than smears it by its σ. Synthetic bursts and the demo have one; that of a scene is partial, so features elsewhere may be right"
            }
        }
    }
}

#[derive(Debug, Clone)]
pub struct Shown {
    pub with: With,
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

#[derive(Debug, Clone)]
pub struct Pinned {
    burst: BurstId,
    asked: SearchParams,
    /// `None` after a session was opened, until the detection is repeated.
    detection: Option<Arc<Detection>>,
}

#[derive(Debug, Clone)]
pub struct ForeignFile {
    burst: BurstId,
    pub path: PathBuf,
    features: Option<Arc<Vec<ForeignFeature>>>,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SavedAgainst {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub with: Option<With>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Parameters of the pinned result: the detection is repeated, which gives the same bits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pinned: Option<SearchParams>,
}

#[derive(Debug, Default)]
pub struct Against {
    pub pinned: Option<Pinned>,
    pub file: Option<ForeignFile>,
    truth: Option<(BurstId, bool)>,
    pub with: Option<With>,
    pub shown: Option<Arc<Shown>>,
    pub hidden: Vec<Kind>,
    pub selected: Option<usize>,
    pub hovered: Option<usize>,
    pub wanted: Wanted<AgainstRequest>,
    pub problem: Option<String>,
}

impl Against {
    pub fn has(&self, with: With) -> bool {
        match with {
            With::Pinned => self.pinned.is_some(),
            With::File => self.file.is_some(),
            With::Truth => self.truth.is_some_and(|(_, known)| known),
        }
    }

    pub fn show(&mut self, with: Option<With>) {
        if self.with != with {
            (self.with, self.shown, self.problem) = (with, None, None);
            self.wanted.forget();
            (self.selected, self.hovered) = (None, None);
            // Unchanged features are hidden, so that the changes stand out.
            self.hidden = if with == Some(With::Pinned) { vec![Kind::Same] } else { Vec::new() };
        }
    }

    pub fn shows(&self, kind: Kind) -> bool {
        !self.hidden.contains(&kind)
    }

    fn check(&mut self, open: Option<&OpenBurst>) {
        let id = open.map(|open| open.id);
        self.pinned.take_if(|pinned| Some(pinned.burst) != id);
        self.file.take_if(|file| Some(file.burst) != id);
        if self.truth.map(|(burst, _)| burst) != id {
            self.truth = open.map(|open| (open.id, open.has_truth()));
        }
        if self.with.is_some_and(|with| !self.has(with)) {
            self.show(None);
        }
    }

    fn wanted_for(&self, burst: &OpenBurst, found: &FoundFeatures) -> Option<AgainstRequest> {
        let with = match self.with? {
            With::Pinned => {
                let Pinned { asked, detection, .. } = self.pinned.clone()?;
                Reference::Earlier { burst: burst.clone(), asked, detection }
            }
            With::File => {
                let file = self.file.as_ref()?;
                Reference::File { path: file.path.clone(), features: file.features.clone() }
            }
            With::Truth => Reference::Truth { burst: burst.clone(), params: found.params.clone() },
        };
        Some(AgainstRequest { detection: found.detection.clone(), with })
    }

    fn take(&mut self, compared: ComparedWith, wanted: Option<&AgainstRequest>) {
        let ComparedWith { request, against: answered } = compared;
        let is_wanted = wanted.is_some_and(|wanted| *wanted == request);
        let Some(with) = self.with.filter(|_| is_wanted) else { return };
        if let (Some(pinned), Some(found)) = (&mut self.pinned, answered.found_again()) {
            pinned.detection = Some(found.clone());
        }
        if let (Some(file), Some(read)) = (&mut self.file, answered.read()) {
            file.features = Some(read.clone());
        }
        let (is_whole_truth, ours) = match &answered {
            Answered::Truth { against, .. } => (against.is_whole_truth, against.name_of_elsewhere()),
            Answered::Changes { .. } => (true, Kind::Ours.label(with)),
        };
        if self.shown.is_none() && !is_whole_truth {
            self.hidden = vec![Kind::Ours];
        }
        let (rows, summary) = rows::of(with, &request.detection, &answered);
        self.shown = Some(Arc::new(Shown { with, detection: request.detection, rows, summary, is_whole_truth, ours }));
        (self.selected, self.hovered, self.problem) = (None, None, None);
    }
}

impl Model {
    pub fn pin_result(&mut self, side: Side) {
        let slot = &mut self.slots[side];
        if let (Some(burst), Some(found)) = (&slot.burst, &slot.found) {
            let (asked, detection) = (found.asked.clone(), Some(found.detection.clone()));
            slot.against.pinned = Some(Pinned { burst: burst.id, asked, detection });
            // The comparison with an earlier pin is dropped.
            slot.against.show(None);
            self.show_against(side, Some(With::Pinned));
        }
    }

    pub fn lay_over(&mut self, side: Side, path: PathBuf) {
        let slot = &mut self.slots[side];
        if let Some(burst) = &slot.burst {
            slot.against.file = Some(ForeignFile { burst: burst.id, path, features: None });
            slot.against.show(None);
            self.show_against(side, Some(With::File));
        }
    }

    pub fn forget_reference(&mut self, side: Side, with: With) {
        let against = &mut self.slots[side].against;
        match with {
            With::Pinned => against.pinned = None,
            With::File => against.file = None,
            With::Truth => {}
        }
        if against.with == Some(with) {
            against.show(None);
        }
    }

    /// Selects a row of the comparison of `side`, and of A its feature.
    pub fn select_row(&mut self, side: Side, row: Option<usize>) {
        let against = &mut self.slots[side].against;
        against.selected = row;
        if side == Side::A {
            self.document.selected = row.and_then(|row| against.shown.as_ref()?.rows.get(row)?.feature);
        }
    }

    pub(in crate::app) fn take_comparisons(&mut self) {
        for side in Side::BOTH {
            let wanted = self.wanted_comparison(side);
            let against = &mut self.slots[side].against;
            for ended in against.wanted.take() {
                match ended.result {
                    Ok(compared) => against.take(compared, wanted.as_ref()),
                    Err(JobError::Cancelled) => against.problem = Some("Cancelled".to_owned()),
                    Err(error) => against.problem = Some(error.to_string()),
                }
            }
        }
    }

    pub(in crate::app) fn ask_for_comparisons(&mut self, engine: &Engine) {
        for side in Side::BOTH {
            let slot = &mut self.slots[side];
            slot.against.check(slot.burst.as_ref());
            let with = slot.against.with;
            let is_there = self.shown_comparison(side).is_some_and(|shown| Some(shown.with) == with);
            let missing = self.wanted_comparison(side).filter(|_| !is_there);
            let against = &mut self.slots[side].against;
            if missing.as_ref().is_some_and(|missing| !against.wanted.has_failed(missing)) {
                against.problem = None;
            }
            against.wanted.want(engine, missing);
        }
    }

    fn wanted_comparison(&self, side: Side) -> Option<AgainstRequest> {
        self.slots[side].against.wanted_for(self.burst_of(side)?, self.found_of(side)?)
    }

    /// The comparison of `side` that is drawn over the pictures: that of the features on show.
    pub fn shown_comparison(&self, side: Side) -> Option<&Arc<Shown>> {
        let found = self.found_of(side)?;
        self.slots[side].against.shown.as_ref().filter(|shown| Arc::ptr_eq(&shown.detection, &found.detection))
    }

    pub fn saved_against(&self, side: Side) -> Option<SavedAgainst> {
        let against = &self.slots[side].against;
        let saved = SavedAgainst {
            with: against.with,
            file: against.file.as_ref().map(|file| file.path.clone()),
            pinned: against.pinned.as_ref().map(|pinned| pinned.asked.clone()),
        };
        (saved != SavedAgainst::default()).then_some(saved)
    }

    /// For the burst of `side`, which was just opened. The reference is read or detected when it is needed.
    pub fn restore_against(&mut self, side: Side, saved: Option<SavedAgainst>) {
        let SavedAgainst { with, file, pinned } = saved.unwrap_or_default();
        let slot = &mut self.slots[side];
        let burst = slot.burst.as_ref().map(|burst| burst.id);
        slot.against.pinned = burst.zip(pinned).map(|(burst, asked)| Pinned { burst, asked, detection: None });
        slot.against.file = burst.zip(file).map(|(burst, path)| ForeignFile { burst, path, features: None });
        slot.against.show(None);
        slot.against.show(with);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::tests::Bench;

    #[test]
    fn either_burst_is_compared_with_its_own_truth_and_takes_the_comparison_along() {
        let mut bench = Bench::with_two_charts();
        bench.model.show_against(Side::B, Some(With::Truth));
        assert!(bench.model.match_look.features, "the comparison is seen");
        bench.run_until(|model, _| model.shown_comparison(Side::B).is_some());
        assert!(bench.model.shown_comparison(Side::A).is_none());
        bench.model.show_against(Side::A, Some(With::Truth));
        bench.run_until(|model, _| model.shown_comparison(Side::A).is_some());
        let summaries = |model: &Model| Side::BOTH.map(|side| model.shown_comparison(side).map(|s| s.summary.clone()));
        for side in Side::BOTH {
            let (slot, shown) = (&bench.model.slots[side], bench.model.shown_comparison(side).expect("there").clone());
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
