//! Comparison of the features of a burst with a reference: an earlier result that was pinned, features of a file, or
//! the truth. All three may be known; one of them is on show. Each of the two bursts has a comparison of its own, in
//! the document, and its results in its slot.

use crate::app::document::{Compared, Comparison, Reference, Side};
use crate::app::results::Read;
use crate::detector::{Detection, Feature, Sample, SearchParams, Slope};
use crate::engine::Wanted;
use crate::inspect::place::ProbeSubject;
use crate::inspect::result::{AgainstTruth, Changes, ForeignFeature, Spot};
use crate::inspect::words::slope_text;
use crate::requests::{
    BurstId, ComparedWith, ComparisonRequest, Differences, JobError, ProbeQuestion, ReferenceSource,
};
use crate::synth::Truth;
use std::path::PathBuf;
use std::sync::Arc;

/// A feature of ours or theirs, with its kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub kind: Compared,
    /// Place (u, v) at mid-burst, input pixels: ours where both have it.
    pub pos_image: [f32; 2],
    /// Scale σ, input pixels.
    pub sigma: f32,
    pub slope: Option<Slope>,
    pub from_image: Option<[f32; 2]>,
    pub feature: Option<usize>,
    /// The candidate of ours that was to become it, where one is known.
    pub candidate: Option<Sample>,
    pub note: String,
}

impl Row {
    pub fn question(&self) -> ProbeQuestion {
        let wanted = match (self.feature, self.candidate) {
            (Some(index), _) => ProbeSubject::Feature(index),
            (None, Some(sample)) => ProbeSubject::Candidate(sample),
            (None, None) => ProbeSubject::Best,
        };
        ProbeQuestion::At { place: self.pos_image, wanted }
    }
}

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
        let (rows, summary) = rows_of(with, &request.detection, &differences);
        self.shown = Some(Arc::new(Shown { with, detection: request.detection, rows, summary, is_whole_truth, ours }));
        (set.selected, self.hovered) = (None, None);
    }
}

fn rows_of(with: Reference, detection: &Detection, differences: &Differences) -> (Vec<Row>, String) {
    let features = &detection.features;
    let (mut rows, summary) = match differences {
        Differences::Changes { changes, before, .. } => {
            let summary = match with {
                Reference::File => {
                    let (moved, both) = (changes.moved().count(), changes.same.len());
                    let (theirs, ours) = (changes.lost.len(), changes.gained.len());
                    format!("{both} in both ({moved} of them moved), {theirs} only theirs, {ours} only ours")
                }
                Reference::Pinned | Reference::Truth => changes.summary(),
            };
            (rows_of_changes(with, changes, before, features), summary)
        }
        Differences::Truth { against, truth } => (rows_of_truth(against, truth, features), against.summary()),
    };
    rows.sort_by_key(|row| row.kind);
    (rows, summary)
}

fn theirs(pos_image: [f32; 2], sigma: f32, slope: Option<Slope>, note: String) -> Row {
    Row { kind: Compared::Theirs, pos_image, sigma, slope, from_image: None, feature: None, candidate: None, note }
}

fn ours(kind: Compared, index: usize, f: &Feature) -> Row {
    Row { kind, feature: Some(index), ..theirs([f.u, f.v], f.sigma, Some(f.slope), String::new()) }
}

fn rows_of_changes(with: Reference, changes: &Changes, before: &[Spot], features: &[Feature]) -> Vec<Row> {
    // Pinned features are our own.
    let whose = if with == Reference::File { "of theirs" } else { "of the pinned result" };
    let lost = changes.lost.iter().map(|&index| {
        let spot = &before[index];
        theirs(spot.pos_image, spot.sigma, spot.slope, format!("number {index} {whose}"))
    });
    let same = changes.same.iter().map(|same| {
        let note =
            format!("by {:.2} px, {:.2} px/frame, scale × {:.2}", same.moved_px, same.slope_moved, same.scale_ratio);
        let moved = same.has_moved();
        Row {
            from_image: moved.then_some(before[same.before].pos_image),
            note: if moved { note } else { String::new() },
            ..ours(if moved { Compared::Moved } else { Compared::Same }, same.after, &features[same.after])
        }
    });
    let gained = changes.gained.iter().map(|&index| ours(Compared::Ours, index, &features[index]));
    lost.chain(gained).chain(same).collect()
}

fn rows_of_truth(against: &AgainstTruth, truth: &Truth, features: &[Feature]) -> Vec<Row> {
    let missed = against.missed.iter().map(|miss| {
        let disc = &truth.features[miss.disc];
        let slope = Slope::new(disc.slope_u as f32, disc.slope_v as f32);
        let row = theirs([disc.u as f32, disc.v as f32], disc.sigma as f32, Some(slope), miss.why.clone());
        Row { candidate: miss.fate.as_ref().map(|fate| fate.of_sample()), ..row }
    });
    let found = against.found.iter().map(|&(index, disc)| {
        let (f, disc) = (&features[index], &truth.features[disc]);
        let off = (f64::from(f.u) - disc.u).hypot(f64::from(f.v) - disc.v);
        Row { note: format!("{off:.2} px off"), ..ours(Compared::Same, index, f) }
    });
    let otherwise = against.at_wrong_motion.iter().map(|&(index, disc)| {
        let (f, disc) = (&features[index], &truth.features[disc]);
        let true_slope = Slope::new(disc.slope_u as f32, disc.slope_v as f32);
        let note = format!("slope {} instead of {}", slope_text(f.slope), slope_text(true_slope));
        Row { note, ..ours(Compared::WrongMotion, index, f) }
    });
    let repeated = against.repeated.iter().map(|&index| ours(Compared::Repeated, index, &features[index]));
    let wrong = against.elsewhere.iter().map(|&index| ours(Compared::Ours, index, &features[index]));
    missed.chain(otherwise).chain(wrong).chain(repeated).chain(found).collect()
}
