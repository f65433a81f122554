//! Likely nature of each feature, from the evenness of the frames' responses and the [suspicions](super::suspicion).

use super::suspicion::{Kind, Suspicion, suspicions_of_feature};
use crate::detector::coherence::{BUMP_COHERENCE, Evenness, Shape};
use crate::detector::{Detection, Trail};
use crate::export::FeatureVerdict;
use crate::monitor::{Cancelled, Monitor, Stage};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Likely nature of a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, strum::IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Verdict {
    /// Every frame shows it, and no stronger feature explains it.
    Real,
    /// A blob of another motion, which shows in this slope's stack.
    Ghost,
    /// A periodic texture, which another slope shows as well.
    Alias,
    /// A blob that has a stronger feature.
    Duplicate,
    /// The evidence does not suffice.
    Unclear,
}

impl Verdict {
    /// All verdicts.
    pub const ALL: [Self; 5] = [Self::Real, Self::Ghost, Self::Alias, Self::Duplicate, Self::Unclear];

    /// Verdict as a word.
    pub fn word(self) -> &'static str {
        self.into()
    }

    /// Verdict as a clause.
    pub fn clause(self) -> &'static str {
        match self {
            Self::Real => "likely a real blob",
            Self::Ghost => "likely a ghost",
            Self::Alias => "likely an alias",
            Self::Duplicate => "likely a duplicate",
            Self::Unclear => "cannot be told",
        }
    }

    /// A ghost comes first: a ghost beside its source is no duplicate of it.
    pub fn of(evenness: &Evenness, suspected: &[Kind]) -> Self {
        let is_suspected = |kind: Kind| suspected.contains(&kind);
        match evenness.shape {
            _ if is_suspected(Kind::Ghost) => Self::Ghost,
            _ if is_suspected(Kind::Duplicate) => Self::Duplicate,
            _ if is_suspected(Kind::Alias) => Self::Alias,
            Shape::Level | Shape::Uneven if evenness.coherence.is_some_and(|c| c >= BUMP_COHERENCE) => Self::Real,
            _ => Self::Unclear,
        }
    }
}

/// Verdict about a feature, with its reason.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// Verdict.
    pub verdict: Verdict,
    /// See [`Evenness::coherence`].
    pub coherence: Option<f32>,
    /// Reason, a clause without a full stop. Features are counted from 0.
    pub why: String,
}

impl Judged {
    /// The verdict that follows from `evenness` and `suspicions`.
    pub fn of(evenness: &Evenness, suspicions: &[Suspicion]) -> Self {
        let kinds: Vec<Kind> = suspicions.iter().map(|suspicion| suspicion.kind).collect();
        let verdict = Verdict::of(evenness, &kinds);
        let because = |kind: Kind| {
            let suspicion = suspicions.iter().find(|suspicion| suspicion.kind == kind);
            suspicion.map_or_else(String::new, |suspicion| suspicion.evidence.clone())
        };
        let coherence = evenness.coherence;
        let why = match (verdict, coherence) {
            (Verdict::Ghost, _) => because(Kind::Ghost),
            (Verdict::Alias, _) => because(Kind::Alias),
            (Verdict::Duplicate, _) => because(Kind::Duplicate),
            (_, None) => "single frames are too noisy to compare".to_owned(),
            (Verdict::Real, Some(c)) => {
                format!("the frames respond alike (coherence {c:.2}), and no stronger feature explains it")
            }
            (Verdict::Unclear, Some(c)) => {
                format!("the frames respond differently (coherence {c:.2}), but not as to a ghost")
            }
        };
        Self { verdict, coherence, why }
    }
}

/// Detection of the features of `trail` on which the verdict is one of `kept`, with their verdicts as files have them.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn kept(trail: &Trail, kept: &[Verdict], monitor: &Monitor) -> Result<(Detection, Vec<FeatureVerdict>), Cancelled> {
    Ok(kept_of(trail.detection(), &judged(trail, monitor)?, kept))
}

/// As [`kept`], of features that were judged already.
pub fn kept_of(detection: &Detection, judged: &[Judged], kept: &[Verdict]) -> (Detection, Vec<FeatureVerdict>) {
    let is_kept = |index: &usize| kept.contains(&judged[*index].verdict);
    let indices: Vec<usize> = (0..judged.len()).filter(is_kept).collect();
    let features = indices.iter().map(|index| detection.features[*index]).collect();
    let descriptors = indices.iter().map(|index| detection.descriptors[*index]).collect();
    let verdict = |index: &usize| {
        let Judged { verdict, coherence, .. } = judged[*index];
        FeatureVerdict { word: verdict.word(), code: verdict as u8, coherence }
    };
    (Detection { features, descriptors, ..detection.clone() }, indices.iter().map(verdict).collect())
}

/// Judges every feature of the detection of `trail`, in their order.
pub fn judged(trail: &Trail, monitor: &Monitor) -> Result<Vec<Judged>, Cancelled> {
    let evenness = trail.evenness_of(&trail.detection().features, &monitor.part(0.0, EVENNESS_SHARE))?;
    let rest = monitor.part(EVENNESS_SHARE, 1.0 - EVENNESS_SHARE);
    let done = AtomicUsize::new(0);
    let judge = |(index, of): (usize, &Evenness)| {
        let suspicions = suspicions_of_feature(trail, index, of, &rest)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        rest.report(Stage::Frames, done as f32 / evenness.len() as f32);
        Ok(Judged::of(of, &suspicions))
    };
    evenness.par_iter().enumerate().map(judge).collect()
}

const EVENNESS_SHARE: f32 = 0.5;
