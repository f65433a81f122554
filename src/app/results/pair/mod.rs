//! Two bursts and the matches between them, as plain values. A is the burst that was opened first; B is opened beside
//! it. Each has a pane that is always there.

mod lost;

mod matches;

pub use lost::{LostFeatures, PATCHES, lost_label};

pub use matches::{MatchRow, Matches};

use crate::app::document::comparison::{Comparison, Reference};
use crate::app::document::cursor::Cursor;
use crate::app::document::filter::{Order, SavedMatch, neighbour};
use crate::app::document::pair::{MatchColumn, MatchLook, PairTab};
use crate::app::document::side::Side;
use crate::app::pane::{Content, Pane, PaneId};
use crate::app::results::slot::Slot;
use crate::app::results::{FoundFeatures, Model, Read};
use crate::detector::{DetectorParams, Method, SearchParams, SlopeGrid};
use crate::engine::{Ended, Engine, Wanted};
use crate::error::Error;
use crate::requests::{MatchRequest, OpenBurst, Picture, PictureKind, PictureRequest, PicturesRequest, are_stacked};
use crate::teach::Workspace;

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
    pub patches: Vec<Picture>,
    pub wanted_patches: Wanted<PicturesRequest>,
    listed_for: Option<(usize, MatchLook, Order<MatchColumn>)>,
}

impl Read<'_> {
    pub fn saved_match(self) -> Option<SavedMatch> {
        Some(self.results.pair.matches.as_ref()?.row(self.document.selected_match?)?.saved())
    }
}

impl Model {
    /// Index of the match in focus: the selected one, or while none is selected, the one under the pointer.
    pub fn match_in_focus(&self) -> Option<usize> {
        self.document.selected_match.or(self.results.pair.hovered)
    }

    /// Those that are listed, or the selected one alone if that is set, even where its kind is hidden.
    pub fn drawn_matches(&self) -> Vec<usize> {
        let listed = &self.results.pair.listed;
        match self.document.selected_match {
            Some(one) if self.document.match_look.alone => vec![one],
            Some(one) if !listed.contains(&one) => listed.iter().copied().chain([one]).collect(),
            _ => listed.clone(),
        }
    }

    /// Largest difference of the motions of a listed match, px/frame.
    pub fn largest_motion(&self) -> f32 {
        let pair = &self.results.pair;
        let rows = pair.matches.iter().flat_map(|matches| pair.listed.iter().filter_map(|&index| matches.row(index)));
        rows.map(|row| row.motion_apart()).fold(0.0, f32::max)
    }

    /// Takes newly made matches. The selection is kept where the same pair of features was matched again.
    fn take_made_matches(&mut self, matches: Matches) {
        let keep = self.results.pair.reselect.take().or_else(|| self.read().saved_match());
        self.document.selected_match = keep.and_then(|saved| matches.find_again(&saved));
        (self.results.pair.matches, self.results.pair.hovered) = (Some(matches), None);
    }

    pub(in crate::app) fn forget_matches(&mut self) {
        (self.results.pair.matches, self.results.pair.hovered, self.document.selected_match) = (None, None, None);
        self.results.pair.listed.clear();
    }

    pub fn refresh_listed_matches(&mut self) {
        let (document, pair) = (&self.document, &mut self.results.pair);
        let Some(matches) = &pair.matches else {
            pair.listed.clear();
            pair.listed_for = None;
            return;
        };
        let (look, order) = (&document.match_look, document.match_order);
        let now = (std::sync::Arc::as_ptr(&matches.result) as usize, look.listing(), order);
        if pair.listed_for != Some(now) {
            pair.listed = matches.listed(look, order);
            pair.listed_for = Some(now);
        }
    }

    pub fn select_neighbouring_match(&mut self, forward: bool) {
        self.refresh_listed_matches();
        self.document.selected_match = neighbour(&self.results.pair.listed, self.document.selected_match, forward);
    }

    /// Of two bursts, the features are drawn too, as the comparison is drawn in their place.
    pub fn show_comparison(&mut self, side: Side, with: Option<Reference>) {
        self.compare_with(side, with);
        if self.document.workspace == Workspace::Pair && with.is_some() {
            (self.document.match_look.features, self.document.pair_tab) = (true, PairTab::Compared);
        }
    }

    pub fn swap_sides(&mut self) {
        self.results.slots.swap();
        let document = &mut self.document;
        document.calibration_of_b.iter_mut().for_each(|of_b| std::mem::swap(of_b, &mut document.calibration));
        self.document.comparisons.swap();
        self.forget_requests();
        // What is probed stays with its burst, and so do the steps to undo.
        (self.document.probe.side, self.results.probed.pointer) = (self.document.probe.side.other(), None);
        self.history.swap_sides();
        self.document.panes.swap_sides();
        self.results.compare.gold.swap();
        self.document.gold.swap();
        // Where A alone was looked at, nothing of it is selected any more.
        (self.results.patch, self.document.selected, self.results.hovered, self.document.playing) =
            (None, None, None, false);
        self.forget_matches();
        self.check_params();
        self.refresh_listed();
    }

    /// B has A's, as far as they can be used: a single frame is searched by SIFT, frames that it lacks mean all.
    pub fn params_of(&self, side: Side) -> DetectorParams {
        let mut params = self.document.params.clone();
        if let (Side::B, Some(b)) = (side, &self.results.slots.b.burst) {
            let frames = b.burst.len();
            if params.frames.is_some_and(|range| range.end > frames) {
                params.frames = None;
            }
            if frames == 1 {
                params.method = Method::Sift;
            }
            if self.document.slopes.is_auto() {
                // B's slopes are its own.
                params.slopes =
                    self.results.slots.b.found.as_ref().map_or(SlopeGrid::default(), |found| found.params.slopes);
            }
        }
        params
    }

    /// Parameters that a detection on `side` would be asked for now, with default slopes if they are to be found.
    pub fn asked_of(&self, side: Side) -> SearchParams {
        let mut detector = self.params_of(side);
        if self.document.slopes.is_auto() {
            detector.slopes = SlopeGrid::default();
        }
        SearchParams { detector, slopes: self.document.slopes }
    }

    pub fn take_second_burst(&mut self, burst: OpenBurst) {
        let Slot { opening, .. } = std::mem::take(&mut self.results.slots.b);
        self.results.slots.b = Slot { burst: Some(burst), opening, ..Slot::default() };
        self.begin_comparison(Side::B);
        self.clear_probe_of(Side::B);
        self.forget_matches();
        (self.results.compare.gold.b, self.document.gold.b) = (None, None);
        self.begin_panes_of_b();
        self.check_params();
    }

    /// Puts the panes of B where they begin beside those of A, whichever of the two bursts was opened last.
    pub(in crate::app::results) fn begin_panes_of_b(&mut self) {
        let Some(middle) = self.burst_of(Side::B).map(|open| open.burst.len() / 2) else { return };
        let Pane { cursor, view, .. } = *self.document.panes.of(Side::A);
        let sizes = Side::BOTH.map(|side| self.burst_of(side).map_or((1, 1), |open| open.burst.size()));
        self.document.panes.place_by_shape(are_stacked(sizes));
        let linked = self.document.panes.of(Side::B).links.cursor;
        self.start_panes(Side::B, |_| {
            if linked { cursor } else { Cursor { frame: middle, kind: cursor.kind, ..Cursor::default() } }
        });
        let pane = self.document.panes.of_mut(Side::B);
        pane.slope_chosen = linked;
        pane.content = Content::Cursor;
        if pane.links.view {
            pane.view = view;
        }
    }

    pub fn wanted_matches(&self) -> Option<MatchRequest> {
        if self.results.pair.param_error.is_some() {
            return None;
        }
        let (a, b) = (self.whole_found_of(Side::A)?, self.whole_found_of(Side::B)?);
        let bursts =
            [(self.burst_of(Side::A)?.clone(), a.params.clone()), (self.burst_of(Side::B)?.clone(), b.params.clone())];
        let params = self.document.matching.clone();
        Some(MatchRequest { a: a.detection.clone(), b: b.detection.clone(), bursts, params })
    }

    pub fn needs_matches(&self) -> bool {
        self.wanted_matches()
            .is_some_and(|wanted| !self.results.pair.matches.as_ref().is_some_and(|m| m.request == wanted))
    }

    pub fn patches_request(&self) -> Option<PicturesRequest> {
        let matches = self.results.pair.matches.as_ref()?;
        let row = matches.row(self.match_in_focus()?)?;
        let request = |side: Side, slope| {
            let (burst, found) = (self.burst_of(side)?.clone(), self.found_of(side)?);
            Some(PictureRequest::new(burst, PictureKind::Stack { slope }, found.params.clone()))
        };
        Some(PicturesRequest(vec![request(Side::A, row.a.slope)?, request(Side::B, row.b.slope)?]))
    }

    fn shows_pair(&self) -> bool {
        self.document.workspace == Workspace::Pair && self.results.slots.b.burst.is_some()
    }

    pub(super) fn missing_patches(&self) -> Option<PicturesRequest> {
        let there =
            || PicturesRequest(self.results.pair.patches.iter().map(|picture| picture.request.clone()).collect());
        self.patches_request().filter(|wanted| self.shows_pair() && there() != *wanted)
    }

    /// While features are still being found, matches would be out of date at once.
    pub(super) fn missing_matches(&self, dragging: bool) -> Option<MatchRequest> {
        let detecting = self.results.slots.both().into_iter().any(|slot| slot.detecting.is_pending());
        self.wanted_matches().filter(|_| self.shows_pair() && !dragging && !detecting && self.needs_matches())
    }

    pub(super) fn take_matches(&mut self, ended: Ended<MatchRequest>) {
        match ended.result {
            Ok(matched) => {
                self.messages.resolved("Matching");
                self.take_made_matches(Matches::new(matched, ended.elapsed));
                self.refresh_listed_matches();
            }
            Err(error) => self.say_failed("Matching", &error),
        }
    }

    pub(super) fn take_patches(&mut self, ended: Ended<PicturesRequest>) {
        let before = std::mem::take(&mut self.results.pair.patches);
        self.results.pair.patches = self.answer(ended, "Patches").unwrap_or(before);
    }

    pub(in crate::app) fn close_second(&mut self, engine: &Engine) {
        self.results.slots.b = Slot::default();
        self.document.calibration_of_b = None;
        self.document.comparisons.b = Comparison::default();
        self.clear_probe_of(Side::B);
        self.document.panes.close_side(Side::B);
        (self.results.compare.gold.b, self.document.gold.b) = (None, None);
        self.results.compare.opening_gold.b.forget();
        self.forget_matches();
        self.results.pair.matching.forget();
        self.results.pair.wanted_patches.forget();
        self.results.pair.patches.clear();
        self.forget_closed_trails(engine);
    }

    pub(in crate::app) fn forget_requests(&mut self) {
        for side in Side::BOTH {
            let slot = &mut self.results.slots[side];
            slot.opening.forget();
            slot.detecting.forget();
            slot.comparison.wanted.forget();
        }
        self.results.pair.matching.forget();
        self.results.compare.wanted.cancel();
        self.results.coherence.try_again();
        self.forget_asked_pictures();
    }

    pub fn stale_matches(&self) -> Option<&'static str> {
        let matches = self.results.pair.matches.as_ref()?;
        let features = [Side::A, Side::B].into_iter().any(|side| {
            let same =
                |found: &FoundFeatures| found.asked == self.asked_of(side) && matches.is_of(side, &found.detection);
            !self.found_of(side).is_some_and(same)
        });
        if features {
            return Some("Stale matches: the detector's parameters changed");
        }
        (matches.request.params != self.document.matching)
            .then_some("Stale matches: the parameters of matching changed")
    }
}

#[cfg(test)]
pub(in crate::app::results) mod tests;

impl Model {
    /// Side whose slope and scale the cursor sets now.
    pub fn active_side(&self) -> Side {
        let both = self.document.workspace == Workspace::Pair && self.results.slots.b.burst.is_some();
        if both { self.document.focused().side } else { Side::A }
    }

    pub fn picture_of(&self, side: Side) -> Option<&Picture> {
        self.picture_in(self.document.pane_for(side))
    }

    pub(in crate::app) fn go_to_match(&mut self) {
        let Some(matches) = self.results.pair.matches.clone() else { return };
        let Some(row) = self.document.selected_match.and_then(|index| matches.row(index)) else { return };
        let sigma = row.a.sigma.max(row.b.sigma).max(1.0);
        // Of each burst the pane in focus, or its first; those that are linked to it come along.
        let panes = &mut self.document.panes;
        let leaders = Side::BOTH.map(|side| {
            let shown = panes.shown_of(side, None);
            let leader = shown.iter().find(|id| **id == panes.focus()).or(shown.first());
            leader.copied().unwrap_or(PaneId::of(side))
        });
        let zooms = leaders.map(|id| panes.get(id).map_or(0.0, |pane| pane.view.points_per_pixel()));
        let zoom = (40.0 / sigma).max(zooms[0]).max(zooms[1]);
        for ((side, feature), leader) in [(Side::A, row.a), (Side::B, row.b)].into_iter().zip(leaders) {
            let links = panes.get(leader).map(|pane| pane.links).unwrap_or_default();
            for id in panes.shown_of(side, None).into_iter().chain([leader]) {
                let Some(pane) = panes.get_mut(id) else { continue };
                if id == leader || (links.cursor && pane.links.cursor) {
                    pane.cursor.slope = feature.slope;
                }
                if id == leader {
                    pane.show_slope();
                }
                if id == leader || (links.view && pane.links.view) {
                    pane.view.look_at(egui::pos2(feature.u, feature.v), zoom);
                }
            }
        }
        self.document.playing = false;
    }
}
