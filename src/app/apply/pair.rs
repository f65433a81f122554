//! Two bursts: B beside A, their matches and what is selected of them, and why a feature has no match.

use crate::app::apply::{comparison, explained, panes, params, probe};
use crate::app::document::{Comparison, Cursor, Side};
use crate::app::memo::Itself;
use crate::app::pane::{Content, Pane, PaneId};
use crate::app::results::pair::lost::{CANDIDATES, LostFeatures, Why};
use crate::app::results::{Matches, Model, Read, Slot};
use crate::engine::{Ended, Engine};
use crate::requests::{LossesRequest, MatchRequest, OpenBurst, are_stacked};
use std::sync::Arc;

/// Takes newly made matches. The selection is kept where the same pair of features was matched again.
fn take_made_matches(model: &mut Model, matches: Matches) {
    let keep = model.results.pair.reselect.take().or_else(|| Read::of(model).saved_match());
    model.document.selected_match = keep.and_then(|saved| matches.find_again(&saved));
    (model.results.pair.matches, model.results.pair.hovered) = (Some(matches), None);
}

pub(in crate::app) fn forget_matches(model: &mut Model) {
    (model.results.pair.matches, model.results.pair.hovered, model.document.selected_match) = (None, None, None);
    model.results.pair.listed.clear();
}

pub fn refresh_listed_matches(model: &mut Model) {
    let (document, pair) = (&model.document, &mut model.results.pair);
    let Some(matches) = &pair.matches else {
        pair.listed.clear();
        pair.listed_for = None;
        return;
    };
    let (look, order) = (&document.match_look, document.match_order);
    let now = (Itself::from(&matches.result), look.listing(), order);
    if pair.listed_for.as_ref() != Some(&now) {
        pair.listed = matches.listed(look, order);
        pair.listed_for = Some(now);
    }
}

pub fn swap_sides(model: &mut Model) {
    model.results.slots.swap();
    let document = &mut model.document;
    document.calibration_of_b.iter_mut().for_each(|of_b| std::mem::swap(of_b, &mut document.calibration));
    model.document.comparisons.swap();
    forget_requests(model);
    // What is probed stays with its burst, and so do the steps to undo.
    (model.document.probe.side, model.results.probed.pointer) = (model.document.probe.side.other(), None);
    model.shell.history.swap_sides();
    model.document.panes.swap_sides();
    model.results.compare.gold.swap();
    model.document.gold.swap();
    // Where A alone was looked at, nothing of it is selected any more.
    (model.document.selected, model.results.hovered, model.document.playing) = (None, None, false);
    forget_matches(model);
    params::check_params(model);
    explained::refresh_listed(model);
}

pub fn take_second_burst(model: &mut Model, burst: OpenBurst) {
    let Slot { opening, .. } = std::mem::take(&mut model.results.slots.b);
    model.results.slots.b = Slot { burst: Some(burst), opening, ..Slot::default() };
    comparison::begin_comparison(model, Side::B);
    probe::clear_probe_of(model, Side::B);
    forget_matches(model);
    (model.results.compare.gold.b, model.document.gold.b) = (None, None);
    begin_panes_of_b(model);
    params::check_params(model);
}

/// Puts the panes of B where they begin beside those of A, whichever of the two bursts was opened last.
pub(super) fn begin_panes_of_b(model: &mut Model) {
    let Some(middle) = Read::of(model).burst_of(Side::B).map(|open| open.burst.len() / 2) else { return };
    let Pane { cursor, view, .. } = *model.document.panes.of(Side::A);
    let sizes = Side::BOTH.map(|side| Read::of(model).burst_of(side).map_or((1, 1), |open| open.burst.size()));
    model.document.panes.place_by_shape(are_stacked(sizes));
    let linked = model.document.panes.of(Side::B).links.cursor;
    panes::start_panes(model, Side::B, |_| {
        if linked { cursor } else { Cursor { frame: middle, kind: cursor.kind, ..Cursor::default() } }
    });
    let pane = model.document.panes.of_mut(Side::B);
    pane.slope_chosen = linked;
    pane.content = Content::Cursor;
    if pane.links.view {
        pane.view = view;
    }
}

pub(super) fn take_matches(model: &mut Model, ended: Ended<MatchRequest>) {
    if let Some(matched) = model.shell.messages.outcome(ended.result, "Matching") {
        take_made_matches(model, Matches::new(matched, ended.elapsed));
        refresh_listed_matches(model);
    }
}

pub(in crate::app) fn close_second(model: &mut Model, engine: &Engine) {
    model.results.slots.b = Slot::default();
    model.document.calibration_of_b = None;
    model.document.comparisons.b = Comparison::default();
    probe::clear_probe_of(model, Side::B);
    model.document.panes.close_side(Side::B);
    (model.results.compare.gold.b, model.document.gold.b) = (None, None);
    model.results.compare.opening_gold.b.forget();
    forget_matches(model);
    model.results.pair.matching.forget();
    Read::of(model).forget_closed_trails(engine);
}

pub(in crate::app) fn forget_requests(model: &mut Model) {
    for side in Side::BOTH {
        let slot = &mut model.results.slots[side];
        slot.opening.forget();
        slot.detecting.forget();
        slot.comparison.wanted.forget();
    }
    model.results.pair.matching.forget();
    model.results.compare.wanted.cancel();
    model.results.coherence.try_again();
    panes::forget_asked_pictures(model);
}

pub(in crate::app) fn go_to_match(model: &mut Model) {
    let Some(matches) = model.results.pair.matches.clone() else { return };
    let Some(row) = model.document.selected_match.and_then(|index| matches.row(index)) else { return };
    let sigma = row.a.sigma.max(row.b.sigma).max(1.0);
    // Of each burst the pane in focus, or its first; those that are linked to it come along.
    let panes = &mut model.document.panes;
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
    model.document.playing = false;
}

pub(super) fn take_losses(model: &mut Model, ended: Ended<LossesRequest>) {
    if let Ok(found) = ended.result {
        model.results.pair.lost.found = Some(Arc::new(found));
        model.results.pair.lost.fold();
    }
    refresh_why(model);
}

pub fn ask_feature(model: &mut Model, index: Option<usize>) {
    let matches = model.results.pair.matches.as_ref();
    let its_match = index.and_then(|index| matches?.rows().find(|row| row.found.a == index).map(|row| row.index));
    (model.document.selected_match, model.document.asked_about) = (its_match, index);
}

pub fn refresh_why(model: &mut Model) {
    if !model.document.workspace.shows_pair() {
        return;
    }
    if model.results.pair.lost.found.is_some() && Read::of(model).losses().is_none() {
        // Another pair: what was asked about is no feature of it.
        model.document.asked_about = None;
        let LostFeatures { wanted, pricing, .. } = std::mem::take(&mut model.results.pair.lost);
        model.results.pair.lost = LostFeatures { wanted, pricing, ..LostFeatures::default() };
    }
    let why = match (Read::of(model).asked_feature(), Read::of(model).losses()) {
        (Some(feature), Some(found)) if feature < found.lost.len() => {
            let old = model.results.pair.lost.why.as_ref();
            if old.is_some_and(|why| why.feature == feature && why.of == found.request) {
                return;
            }
            let losses = crate::inspect::pair::Losses::again(found.request.pair(), found.nearest.clone());
            Some(Why { feature, of: found.request.clone(), unmatched: Arc::new(losses.of(feature, CANDIDATES)) })
        }
        _ => None,
    };
    model.results.pair.lost.why = why;
}

#[cfg(test)]
pub(in crate::app) mod tests {
    use super::*;
    use crate::app::apply::bench::{detected, feature, open};
    use crate::app::apply::{detection, opening};
    use crate::app::results::pair::*;
    use crate::detector::{Detection, FrameRange, Method};
    use crate::teach::Workspace;
    use std::time::Duration;

    /// A model with two bursts and the features of both; B's are A's, moved by (2, 0).
    pub(in crate::app) fn pair() -> Model {
        let mut model = Model::default();
        model.document.open_workspace(Workspace::Pair);
        let (a, b) = (open((64, 48), 5), open((64, 48), 5));
        opening::take_burst(&mut model, a.clone());
        take_second_burst(&mut model, b.clone());
        let grid = Read::of(&model).grid_of(Side::A);
        let at = |du: f32| -> Vec<_> {
            (0..4).map(|i| feature(8.0 + 12.0 * i as f32 + du, 10.0 + 7.0 * i as f32, i, &grid)).collect()
        };
        for (side, burst, du) in [(Side::A, a, 0.0), (Side::B, b, 2.0)] {
            let mut found = detected(&burst, &model.document.params, at(du));
            let mut detection = Detection::clone(&found.detection);
            for (i, descriptor) in detection.descriptors.iter_mut().enumerate() {
                descriptor[10 * i] = 200;
            }
            found.detection = Arc::new(detection);
            detection::take_detection(&mut model, side, found, Duration::ZERO);
        }
        model
    }

    fn make_matches(model: &mut Model) {
        let request = Read::of(model).wanted_matches().expect("both sides have features");
        let matched = request.matched(&crate::monitor::Monitor::default()).expect("valid");
        take_made_matches(model, Matches::new(matched, Duration::ZERO));
    }

    #[test]
    fn a_second_burst_has_the_parameters_as_far_as_it_can_use_them() {
        let mut model = pair();
        model.document.params.frames = Some(FrameRange { start: 1, end: 5 });
        assert_eq!(Read::of(&model).params_of(Side::B).frames, model.document.params.frames);
        take_second_burst(&mut model, open((64, 48), 3));
        assert_eq!(Read::of(&model).params_of(Side::B).frames, None);
        take_second_burst(&mut model, open((64, 48), 1));
        params::check_params(&mut model);
        assert_eq!(Read::of(&model).params_of(Side::B).method, Method::Sift);
        assert_eq!(model.results.slots.b.param_error, None, "a single sharp image can be B");
        assert_eq!(Read::of(&model).params_of(Side::A).method, Method::Buff);
    }

    #[test]
    fn panes_begin_alike_whichever_burst_is_opened_last() {
        let opened = |last: Side| {
            let mut model = Model::default();
            model.document.open_workspace(Workspace::Pair);
            for side in [last.other(), last] {
                let burst = open((150, 60), 5);
                match side {
                    Side::A => opening::take_burst(&mut model, burst),
                    Side::B => take_second_burst(&mut model, burst),
                }
            }
            model.document.panes.clone()
        };
        assert!(opened(Side::A) == opened(Side::B));
    }

    #[test]
    fn the_same_match_stays_selected_when_it_is_made_again() {
        let mut model = pair();
        make_matches(&mut model);
        model.document.selected_match = Some(2);
        let place = Read::of(&model).saved_match().expect("selected");
        model.document.matching.geometry = crate::matching::Geometry::None;
        make_matches(&mut model);
        assert_eq!(model.document.selected_match, Some(2));
        assert_eq!(Read::of(&model).saved_match(), Some(place));
        let moved = crate::app::document::SavedMatch { a: [place.a[0] + 3.0, place.a[1]], ..place };
        assert_eq!(model.results.pair.matches.as_ref().and_then(|m| m.find_again(&moved)), None);
    }

    #[test]
    fn sides_are_swapped_with_everything_that_is_theirs() {
        let mut model = pair();
        make_matches(&mut model);
        let ids = [Side::A, Side::B].map(|side| Read::of(&model).burst_of(side).expect("open").id);
        let found = Read::of(&model).found_of(Side::B).expect("found").detection.clone();
        swap_sides(&mut model);
        assert_eq!([Side::B, Side::A].map(|side| Read::of(&model).burst_of(side).expect("open").id), ids);
        assert!(Arc::ptr_eq(&Read::of(&model).found_of(Side::A).expect("found").detection, &found));
        assert!(model.results.pair.matches.is_none() && Read::of(&model).needs_matches());
    }
}
