//! Two bursts and the matches between them, as plain values. A is the burst that was opened first; B is opened beside
//! it. Each has a pane that is always there.

mod columns;
mod found;
mod look;
mod lost;
mod sides;

pub use columns::MatchColumn;
pub use found::{MatchRow, Matches, SavedMatch};
pub use look::MatchLook;
pub use lost::{LostFeatures, MatchSides, PATCHES, lost_label};
pub use sides::Links;

use crate::app::pane::{Content, Pane};
use crate::app::project::cursor::Cursor;
use crate::app::project::order::Order;
use crate::app::project::{FoundFeatures, Model};
use crate::detector::{DetectorParams, Method, ParamError, SearchParams, SlopeGrid};
use crate::matching::MatchParams;
use crate::requests::{Detected, MatchRequest, OpenBurst, PatchesRequest, PictureKind, PictureRequest, Running};
use std::time::Duration;

pub use crate::app::project::side::Side;

/// The second burst with everything that belongs to it alone.
#[derive(Debug, Default)]
pub struct SecondBurst {
    /// The open burst, if any.
    pub burst: Option<OpenBurst>,
    /// The last parameters that made sense for it.
    pub usable_params: DetectorParams,
    /// Why the parameters as they are edited make no sense for it.
    pub param_error: Option<ParamError>,
    /// Its features.
    pub found: Option<FoundFeatures>,
}

/// What the engine is doing for the pair, as of this pass.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PairBusy {
    /// B is being opened.
    pub opening: Option<Running>,
    /// B's features are being found.
    pub detecting: Option<Running>,
    /// Features are being matched.
    pub matching: Option<Running>,
}

/// The second burst and the matches.
#[derive(Debug, Default)]
pub struct PairState {
    /// The second burst.
    pub b: SecondBurst,
    /// The parameters of matching, as they are being edited.
    pub params: MatchParams,
    /// Why they make no sense.
    pub param_error: Option<ParamError>,
    /// The matches, with what they were made from.
    pub matches: Option<Matches>,
    /// Features of A on the way to a match.
    pub lost: LostFeatures,
    /// How matches look, and which are shown.
    pub look: MatchLook,
    /// The table's order.
    pub order: Order<MatchColumn>,
    /// Indices of the matches that are shown, in the table's order; see [`PairState::refresh_listed`].
    pub listed: Vec<usize>,
    /// Index of the selected match.
    pub selected: Option<usize>,
    /// Index of the match under the pointer, between the pictures or in the table.
    pub hovered: Option<usize>,
    /// To be selected when the next matching ends.
    pub reselect: Option<SavedMatch>,
    /// What the engine is doing.
    pub busy: PairBusy,
    listed_for: Option<(usize, MatchLook, Order<MatchColumn>)>,
}

impl PairState {
    /// The match that is looked at: the selected one, or while none is, the one that is pointed at.
    pub fn focus(&self) -> Option<usize> {
        self.selected.or(self.hovered)
    }

    /// Indices of the matches that are drawn: those that are listed, or the selected one alone. One that is selected
    /// stays, even where its kind is hidden.
    pub fn drawn(&self) -> Vec<usize> {
        match self.selected {
            Some(one) if self.look.alone => vec![one],
            Some(one) if !self.listed.contains(&one) => self.listed.iter().copied().chain([one]).collect(),
            _ => self.listed.clone(),
        }
    }

    /// Takes newly made matches. The selection is kept where the same pair of features was matched again.
    pub fn take_matches(&mut self, matches: Matches) {
        let keep = self.reselect.take().or_else(|| self.saved_match());
        self.matches = Some(matches);
        self.hovered = None;
        self.selected = keep.and_then(|saved| self.matches.as_ref()?.find_again(&saved));
        self.refresh_listed();
    }

    /// Forgets the matches: they are of bursts that are not open any more.
    pub fn forget_matches(&mut self) {
        (self.matches, self.selected, self.hovered) = (None, None, None);
        self.refresh_listed();
    }

    /// The selection as it is kept in a session.
    pub fn saved_match(&self) -> Option<SavedMatch> {
        Some(self.matches.as_ref()?.row(self.selected?)?.saved())
    }

    /// Brings [`PairState::listed`] up to date. Cheap when nothing changed.
    pub fn refresh_listed(&mut self) {
        let Some(matches) = &self.matches else {
            self.listed.clear();
            self.listed_for = None;
            return;
        };
        let now = (std::sync::Arc::as_ptr(&matches.result) as usize, self.look.listing(), self.order);
        if self.listed_for != Some(now) {
            self.listed = matches.listed(&self.look, self.order);
            self.listed_for = Some(now);
        }
    }

    /// Selects the match after (or before) the selected one in the table's order.
    pub fn select_neighbour(&mut self, forward: bool) {
        self.refresh_listed();
        self.selected = crate::app::project::listing::neighbour(&self.listed, self.selected, forward);
    }
}

impl Model {
    /// Makes A of B and B of A. The matches are made anew.
    pub fn swap_sides(&mut self) {
        let b = &mut self.pair.b;
        std::mem::swap(&mut self.burst, &mut b.burst);
        std::mem::swap(&mut self.usable_params, &mut b.usable_params);
        std::mem::swap(&mut self.param_error, &mut b.param_error);
        std::mem::swap(&mut self.found, &mut b.found);
        self.panes.swap_sides();
        self.compare.gold.swap(0, 1);
        // Where A alone was looked at, nothing of it is selected any more.
        (self.patch, self.selected, self.hovered, self.playing) = (None, None, None, false);
        self.pair.forget_matches();
        self.check_params();
        self.refresh_listed();
    }

    /// The detector's parameters for `side`. B has A's, as far as they can be used: a single frame is searched by SIFT,
    /// and a range of frames that B does not have means all of them.
    pub fn params_of(&self, side: Side) -> DetectorParams {
        let mut params = self.params.clone();
        if let (Side::B, Some(b)) = (side, &self.pair.b.burst) {
            let frames = b.burst.len();
            if params.frames.is_some_and(|range| range.end > frames) {
                params.frames = None;
            }
            if frames == 1 {
                params.method = Method::Sift;
            }
            if self.slopes.is_auto() {
                // B's slopes are its own.
                params.slopes = self.pair.b.found.as_ref().map_or(SlopeGrid::default(), |found| found.params.slopes);
            }
        }
        params
    }

    /// What a detection on `side` is asked for now. Slopes that are to be found are not part of it.
    pub fn asked_of(&self, side: Side) -> SearchParams {
        let mut detector = self.params_of(side);
        if self.slopes.is_auto() {
            detector.slopes = SlopeGrid::default();
        }
        SearchParams { detector, slopes: self.slopes }
    }

    /// Whether a detection in B with the present parameters is missing and could be made.
    pub fn needs_second_detection(&self) -> bool {
        let b = &self.pair.b;
        b.burst.is_some()
            && b.param_error.is_none()
            && b.found.as_ref().is_none_or(|found| found.asked != self.asked_of(Side::B))
    }

    /// Takes B's features, unless they are of another burst.
    pub fn take_second_detection(&mut self, detected: Detected, elapsed: Duration) {
        let Some(burst) = self.pair.b.burst.as_ref().filter(|open| open.id == detected.burst) else { return };
        self.pair.b.found = Some(FoundFeatures::new(detected, burst, elapsed));
        self.check_pair();
        self.go_to_first_slope(Side::B);
    }

    /// Takes a newly opened burst as B.
    pub fn take_second_burst(&mut self, burst: OpenBurst) {
        let middle = burst.burst.len() / 2;
        self.pair.b = SecondBurst { burst: Some(burst), ..SecondBurst::default() };
        self.pair.forget_matches();
        self.compare.gold[1] = None;
        let Pane { cursor, view, .. } = *self.panes.of(Side::A);
        let linked = self.panes.of(Side::B).links.cursor;
        self.start_panes(Side::B, |_| {
            if linked { cursor } else { Cursor { frame: middle, kind: cursor.kind, ..Cursor::default() } }
        });
        let pane = self.panes.of_mut(Side::B);
        pane.slope_chosen = linked;
        pane.content = Content::Cursor;
        if pane.links.view {
            pane.view = view;
        }
        self.check_pair();
    }

    /// The matches that are wanted now; `None` while the features of a side are missing or the parameters make no
    /// sense.
    pub fn wanted_matches(&self) -> Option<MatchRequest> {
        if self.pair.param_error.is_some() {
            return None;
        }
        let (a, b) = (self.found.as_ref()?, self.pair.b.found.as_ref()?);
        Some(MatchRequest { a: a.detection.clone(), b: b.detection.clone(), params: self.pair.params.clone() })
    }

    /// Whether matches are missing that could be made.
    pub fn needs_matches(&self) -> bool {
        self.wanted_matches()
            .is_some_and(|wanted| !self.pair.matches.as_ref().is_some_and(|m| m.request.same_matches(&wanted)))
    }

    /// The motion-stack images that the patches of the match in focus are cut from, each at its own feature's slope.
    pub fn wanted_patches(&self) -> Option<PatchesRequest> {
        let matches = self.pair.matches.as_ref()?;
        let row = matches.row(self.pair.focus()?)?;
        let request = |side: Side, slope| {
            let (burst, found) = (self.burst_of(side)?.clone(), self.found_of(side)?);
            Some(PictureRequest::new(burst, PictureKind::Stack { slope }, found.params.clone()))
        };
        Some(PatchesRequest { a: request(Side::A, row.a.slope)?, b: request(Side::B, row.b.slope)? })
    }

    /// Why the matches on show are not those of what is set now; `None` when they are.
    pub fn stale_matches(&self) -> Option<&'static str> {
        let matches = self.pair.matches.as_ref()?;
        let features = [Side::A, Side::B].into_iter().any(|side| {
            let same =
                |found: &FoundFeatures| found.asked == self.asked_of(side) && matches.is_of(side, &found.detection);
            !self.found_of(side).is_some_and(same)
        });
        if features {
            return Some("Stale matches: the detector's parameters changed");
        }
        (matches.request.params != self.pair.params).then_some("Stale matches: the parameters of matching changed")
    }
}

#[cfg(test)]
pub(in crate::app::project) mod tests;
