//! Rows of a comparison: one for each feature of ours or theirs, with its kind.

use crate::app::document::{Compared, Reference};
use crate::detector::{Detection, Feature, Sample, Slope};
use crate::inspect::place::ProbeSubject;
use crate::inspect::result::{AgainstTruth, Changes, Spot};
use crate::inspect::words::slope_text;
use crate::requests::{Differences, ProbeQuestion};
use crate::synth::Truth;

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

pub(super) fn of(with: Reference, detection: &Detection, differences: &Differences) -> (Vec<Row>, String) {
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
        let was = &before[same.before];
        let note =
            format!("by {:.2} px, {:.2} px/frame, scale × {:.2}", same.moved_px, same.slope_moved, same.scale_ratio);
        let moved = same.has_moved();
        Row {
            from_image: moved.then_some(was.pos_image),
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
