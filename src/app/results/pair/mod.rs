//! Two bursts and the matches between them, as plain values. A is the burst that was opened first; B is opened beside
//! it. Each has a pane that is always there.

pub mod lost;

mod matches;

pub use lost::{LostFeatures, PATCHES, lost_words};

pub use matches::{MatchRow, Matches, PAIR_NUMBERS};

use crate::app::document::{MatchColumn, MatchLook, MethodId, Order, SavedMatch, Side};
use crate::app::{memo::Itself, results::Read};
use crate::detector::{DetectorParams, Method, SearchParams, Slope, SlopeGrid};
use crate::engine::Wanted;
use crate::error::Error;
use crate::requests::MatchRequest;

/// Lines of the method with the most inliers, where no number is set.
const LINES_OF_METHODS: usize = 40;

#[derive(Debug, Default)]
pub struct PairState {
    pub param_error: Option<Error>,
    pub matches: Option<Matches>,
    pub lost: LostFeatures,
    pub listed: Vec<usize>,
    pub hovered: Option<usize>,
    /// Numbers of match lines that are drawn, and of those that could be, as last drawn.
    pub lines_drawn: (usize, usize),
    pub reselect: Option<SavedMatch>,
    pub matching: Wanted<MatchRequest>,
    pub listed_for: Option<(Itself, MatchLook, Order<MatchColumn>)>,
}

impl<'a> Read<'a> {
    pub fn selected_match(self) -> Option<MatchRow<'a>> {
        self.results.pair.matches.as_ref()?.row(self.document.selected_match?)
    }

    pub fn saved_match(self) -> Option<SavedMatch> {
        let MatchRow { a, b, .. } = self.selected_match()?;
        Some(SavedMatch { a: [a.u, a.v], b: [b.u, b.v] })
    }

    /// Index of the match in focus: the selected one, or while none is selected, the one under the pointer.
    pub fn match_in_focus(self) -> Option<usize> {
        self.document.selected_match.or(self.results.pair.hovered)
    }

    /// Listed matches, or the selected match alone if so set, even where its kind is hidden.
    pub fn drawn_matches(self) -> Vec<usize> {
        let listed = &self.results.pair.listed;
        match self.document.selected_match {
            Some(one) if self.document.match_look.alone => vec![one],
            Some(one) if !listed.contains(&one) => listed.iter().copied().chain([one]).collect(),
            _ => listed.clone(),
        }
    }

    /// Largest number of lines that are drawn, if one is set; those of a `method` are in proportion to its inliers, so
    /// that methods side by side compare.
    pub fn most_lines(self, method: Option<MethodId>) -> Option<usize> {
        let most = self.document.match_look.most;
        let Some(method) = method else { return most };
        let agreed = |of: MethodId| {
            let counts = self.method_matches(of).map(|matches| matches.result.counts);
            counts.map_or(0, |counts| counts.inliers.unwrap_or(counts.putative))
        };
        let largest = MethodId::ALL.into_iter().map(agreed).max().unwrap_or(0).max(1);
        Some((most.unwrap_or(LINES_OF_METHODS) * agreed(method)).div_ceil(largest))
    }

    /// Largest difference of the motions of a listed match, px/frame.
    pub fn largest_motion(self) -> f32 {
        let pair = &self.results.pair;
        let rows = pair.matches.iter().flat_map(|matches| pair.listed.iter().filter_map(|&index| matches.row(index)));
        rows.map(|row| row.motion_apart()).fold(0.0, f32::max)
    }

    /// Slopes of a side: the given ones; where they are found, those found last, in B for its own burst.
    pub fn grid_of(self, side: Side) -> SlopeGrid {
        let found = || match side {
            Side::A => self.results.slots.a.usable_params.slopes,
            Side::B => self.found_of(Side::B).map_or(SlopeGrid::default(), |found| found.params.slopes),
        };
        self.document.params.slopes.given().unwrap_or_else(found)
    }

    /// Whether the slopes of a side are given, or were found as they are asked for now.
    pub fn knows_slopes(self, side: Side) -> bool {
        let asked = self.document.params.slopes;
        !asked.is_auto() || self.found_of(side).is_some_and(|found| found.asked.slopes == asked)
    }

    /// Parameters of a search of [`Self::grid_of`] a side.
    pub fn params_of(self, side: Side) -> DetectorParams {
        self.asked_of(side).at(self.grid_of(side))
    }

    /// Parameters that a detection on `side` would be asked for now. B has A's, as far as they can be used: a single
    /// frame is searched by SIFT, frames that it lacks mean all.
    pub fn asked_of(self, side: Side) -> SearchParams {
        let mut params = self.document.params.clone();
        if let (Side::B, Some(b)) = (side, &self.results.slots.b.burst) {
            let frames = b.burst.len();
            if params.frames.is_some_and(|range| range.end > frames) {
                params.frames = None;
            }
            if frames == 1 {
                params.method = Method::Sift;
            }
        }
        params
    }

    pub fn wanted_matches(self) -> Option<MatchRequest> {
        if self.results.pair.param_error.is_some() {
            return None;
        }
        let (a, b) = (self.whole_found_of(Side::A)?, self.whole_found_of(Side::B)?);
        let bursts =
            [(self.burst_of(Side::A)?.clone(), a.params.clone()), (self.burst_of(Side::B)?.clone(), b.params.clone())];
        let params = self.document.matching.clone();
        Some(MatchRequest { a: a.detection.clone(), b: b.detection.clone(), bursts, params })
    }

    pub fn needs_matches(self) -> bool {
        self.wanted_matches()
            .is_some_and(|wanted| !self.results.pair.matches.as_ref().is_some_and(|m| m.request == wanted))
    }

    fn shows_pair(self) -> bool {
        self.document.workspace.shows_pair() && self.results.slots.b.burst.is_some()
    }

    /// Sides and slopes of the features whose patches are shown: of the match in focus, and of what could be matched.
    pub fn patches_of_pair(self) -> Vec<(Side, Slope)> {
        let matches = self.results.pair.matches.as_ref().filter(|_| self.shows_pair());
        let row = matches.and_then(|matches| matches.row(self.match_in_focus()?));
        let of_match = row.map(|row| [(Side::A, row.a.slope), (Side::B, row.b.slope)]);
        of_match.into_iter().flatten().chain(self.patches_of_candidates()).collect()
    }

    /// While features are still being found, matches would be out of date at once.
    pub fn missing_matches(self, dragging: bool) -> Option<MatchRequest> {
        let detecting = self.results.slots.both().into_iter().any(|slot| slot.detecting.is_pending());
        self.wanted_matches().filter(|_| self.shows_pair() && !dragging && !detecting && self.needs_matches())
    }

    pub fn stale_matches(self) -> Option<&'static str> {
        let matches = self.results.pair.matches.as_ref()?;
        let current = |side| self.found_of(side).filter(|_| self.features_are_current(side));
        let is_of = |side| current(side).is_some_and(|found| matches.is_of(side, &found.detection));
        if !Side::BOTH.into_iter().all(is_of) {
            return Some("Stale matches: the detector's parameters changed");
        }
        (matches.request.params != self.document.matching)
            .then_some("Stale matches: the parameters of matching changed")
    }

    pub fn active_side(self) -> Side {
        if self.shows_pair() { self.document.focused().side } else { Side::A }
    }
}
