//! Why features of A have no match, or the one that they have: what is known of all of them, and of the one that is
//! asked about.

use crate::app::project::Model;
use crate::app::project::pair::Side;
use crate::engine::{FoundLosses, LossesRequest, Picture, PictureKind, PictureRequest, Running};
use crate::inspect::unmatched::{Losses, Lost, Unmatched};
use std::sync::Arc;

/// Candidates of a feature that are listed.
pub const CANDIDATES: usize = 5;
/// Of these this many are shown with their patches.
pub const PATCHES: usize = 3;

/// What is known of the features of A on the way to a match.
#[derive(Debug, Default)]
pub struct LostFeatures {
    /// Where each was lost.
    pub found: Option<Arc<FoundLosses>>,
    /// The feature of A that is asked about while no match is selected.
    pub selected: Option<usize>,
    /// Why the feature in focus is matched as it is.
    pub why: Option<Why>,
    /// Whether the table lists features without a match, and not the matches.
    pub listed: bool,
    /// Where the features were lost that are not listed.
    pub hidden: Vec<Lost>,
    /// The pictures from which the patches are cut: A's feature, then its candidates.
    pub pictures: Vec<Picture>,
    /// What the engine is doing.
    pub busy: Option<Running>,
}

/// Why a feature of A is matched as it is.
#[derive(Debug, Clone)]
pub struct Why {
    /// The feature.
    pub feature: usize,
    /// The pair that was asked about.
    of: LossesRequest,
    /// Why.
    pub unmatched: Arc<Unmatched>,
}

impl LostFeatures {
    /// How many were lost at `lost`.
    pub fn count(&self, lost: Lost) -> usize {
        let counts = self.found.as_ref().map(|found| found.counts);
        counts.into_iter().flatten().find(|(at, _)| *at == lost).map_or(0, |(_, count)| count)
    }
}

/// What it is called where a feature was lost.
pub fn lost_label(lost: Lost) -> &'static str {
    match lost {
        Lost::Not => "matched",
        Lost::NoKeypoint => "no keypoint",
        Lost::RatioTest => "ratio test",
        Lost::MutualCheck => "mutual check",
        Lost::Geometry => "geometry",
    }
}

impl Model {
    /// The pair that can be asked about now.
    pub fn wanted_losses(&self) -> Option<LossesRequest> {
        let matches = self.pair.matches.as_ref()?;
        let size_b = self.burst_of(Side::B)?.burst.size();
        Some(LossesRequest { request: matches.request.clone(), result: matches.result.clone(), size_b })
    }

    /// What is known of the pair on show.
    pub fn losses(&self) -> Option<&Arc<FoundLosses>> {
        let wanted = self.wanted_losses()?;
        self.pair.lost.found.as_ref().filter(|found| found.request.same_pair(&wanted))
    }

    /// The feature of A that is asked about: that of the match in focus, or the one that was selected.
    pub fn asked_feature(&self) -> Option<usize> {
        let of_match = || {
            let matches = self.pair.matches.as_ref()?;
            Some(matches.row(self.pair.selected?)?.found.a)
        };
        of_match().or(self.pair.lost.selected)
    }

    /// Asks why feature `index` of A is matched as it is. One with a match selects that match.
    pub fn ask_feature(&mut self, index: Option<usize>) {
        let matches = self.pair.matches.as_ref();
        let its_match = index.and_then(|index| matches?.rows().find(|row| row.found.a == index).map(|row| row.index));
        (self.pair.selected, self.pair.lost.selected) = (its_match, index);
    }

    /// Brings [`LostFeatures::why`] up to date. Cheap when nothing changed.
    pub fn refresh_why(&mut self) {
        if self.pair.lost.found.is_some() && self.losses().is_none() {
            // Another pair: what was asked about is no feature of it.
            self.pair.lost = LostFeatures { listed: self.pair.lost.listed, ..LostFeatures::default() };
        }
        let asked = self.asked_feature();
        let why = match (asked, self.losses()) {
            (Some(feature), Some(found)) if feature < found.lost.len() => {
                let old = self.pair.lost.why.as_ref();
                if old.is_some_and(|why| why.feature == feature && why.of.same_pair(&found.request)) {
                    return;
                }
                let losses = Losses::again(found.request.pair(), found.nearest.clone());
                let unmatched = Arc::new(losses.of(feature, CANDIDATES));
                Some(Why { feature, of: found.request.clone(), unmatched })
            }
            _ => None,
        };
        self.pair.lost.why = why;
    }

    /// The motion-stack images from which the patches of the feature that is asked about and of its candidates are cut.
    pub fn wanted_candidate_pictures(&self) -> Vec<PictureRequest> {
        let Some((why, found)) = self.pair.lost.why.as_ref().zip(self.losses()) else { return Vec::new() };
        let MatchSides { a, b } = MatchSides::of(found);
        let own = a.features.get(why.feature).map(|f| (Side::A, f.slope));
        let candidates = why.unmatched.candidates.iter().take(PATCHES);
        let others = candidates.filter_map(|c| b.features.get(c.feature).map(|f| (Side::B, f.slope)));
        own.into_iter()
            .chain(others)
            .filter_map(|(side, slope)| {
                let (burst, found) = (self.burst_of(side)?.clone(), self.found_of(side)?);
                Some(PictureRequest::new(burst, PictureKind::Stack { slope }, found.params.clone()))
            })
            .collect()
    }
}

/// Both detections of a pair.
pub struct MatchSides<'a> {
    /// A.
    pub a: &'a crate::detector::Detection,
    /// B.
    pub b: &'a crate::detector::Detection,
}

impl<'a> MatchSides<'a> {
    /// Those of `found`.
    pub fn of(found: &'a FoundLosses) -> Self {
        Self { a: &found.request.request.a, b: &found.request.request.b }
    }
}
