//! Steps and the project: sets it up as a step begins, and checks in it what the goals of tasks ask about.

use crate::app::canvas::{View, Zoom};
use crate::app::document::cursor::ViewKind;
use crate::app::document::{Cursor, Document, FeaturesShown, Panels, SetUpState, Side, Staged, Trajectories};
use crate::app::pane::{Content, PaneId, PaneLinks, Panes};
use crate::app::results::Read;
use crate::detector::{SearchParams, SlopeGrid};
use crate::teach::{Between, Goal, InView, Layout, Part, State, Step, Workspace};

/// Panels of a step; in a hall only those with something that the step points at.
pub(super) fn panels_of(step: &Step, hall: bool) -> Panels {
    let Step { state, highlight, .. } = step;
    let points_at = |parts: &[Part]| highlight.iter().any(|part| parts.contains(part));
    let in_probe = points_at(&[Part::Probe, Part::Response, Part::Shares]);
    let on_left = |part: &Part| {
        matches!(part, Part::Frame | Part::SlopeU | Part::SlopeV | Part::Octave | Part::Level | Part::Parameter(_))
    };
    let has_slice = state.layout == Some(Layout::Slice);
    Panels {
        left: (!hall || highlight.iter().any(on_left)).into(),
        // Slices need the space that the probe's panel would take.
        right: (in_probe || (!hall && (state.select.is_some() || (state.probe.is_some() && !has_slice)))).into(),
        bottom: (state.tab.is_some()
            || matches!(state.workspace, Some(Workspace::Pair | Workspace::Trajectories))
            || points_at(&[Part::Tabs, Part::Below]))
        .into(),
        filmstrip: false,
        welcome: false,
        hall,
        ..Panels::default()
    }
}

/// The step as it begins; its bursts are open already. In its document, what the step leaves open is as in a new
/// window, and how the window looks as it was `before`.
pub(super) fn begin(step: &Step, model: Read<'_>) -> Staged {
    let (state, before) = (step.state.clone(), model.document);
    let auto_detect = state.detect.unwrap_or(false);
    let has_features = state.features.unwrap_or(auto_detect);
    let (values, is_open) = (state.set_up.unwrap_or_default(), state.set_up.is_some());
    let set_up = SetUpState { values, is_open, ..SetUpState::default() };
    let mut document = Document {
        workspace: state.workspace.unwrap_or_default(),
        matching: state.matching.clone().unwrap_or_default(),
        auto_detect,
        bottom_tab: state.tab.unwrap_or_default(),
        panels: panels_of(step, before.panels.hall),
        filter: Default::default(),
        comparisons: Default::default(),
        shown_test: None,
        measure: Default::default(),
        probe: Default::default(),
        set_up,
        trajectories: Trajectories { selected: None, view: View::fit(), ..before.trajectories.clone() },
        selected: None,
        selected_match: None,
        playing: false,
        ..before.clone()
    };
    document.read_depths(false);
    let given = || SearchParams { slopes: SlopeGrid::default().into(), ..SearchParams::default() };
    document.params = state.params.clone().unwrap_or_else(given);
    document.look.overlay = if has_features { FeaturesShown::ThisSlope } else { FeaturesShown::None };
    document.look.ranges.forget();
    set_panes(&mut document.panes, &state, model.frame_count());
    Staged::Begin { document: Box::new(document), layout: state.layout, probe: state.probe }
}

fn set_panes(panes: &mut Panes, state: &State, frames: usize) {
    panes.show_alone(PaneId::of(Side::A));
    let (frame, slope) = (state.frame.unwrap_or(frames / 2), state.slope.unwrap_or_default());
    let (octave, level) = (state.octave.unwrap_or(0), state.level.unwrap_or(0));
    let cursor = Cursor { kind: ViewKind::Stack, frame, slope, octave, level };
    for side in Side::BOTH {
        let pane = panes.of_mut(side);
        (pane.cursor, pane.slope_chosen, pane.content) = (cursor, true, Content::Cursor);
        (pane.own_ranges, pane.links, pane.over) = (None, PaneLinks::default(), None);
        pane.view = match state.view {
            Some(InView::Centre([u, v, zoom])) => View::new(Zoom::PointsPerPixel(zoom), [u, v]),
            Some(InView::Region([left, top, right, bottom])) => View::region([left, top], [right, bottom]),
            None => View::fit(),
        };
        pane.show(state.show.unwrap_or_default());
    }
}

/// Whether all conditions of a goal hold; an absent one always does.
pub(super) fn is_met(goal: &Goal, model: Read<'_>) -> bool {
    let (document, cursor, params) = (model.document, model.document.cursor(), model.params_of(Side::A));
    let frames_used = document.params.used_frames(model.frame_count()).len();
    let is_current = model.results.slots.a.found.is_some() && model.stale().is_none();
    let matches = model.results.pair.matches.as_ref().filter(|_| !model.needs_matches());
    let inliers = matches.and_then(|matches| matches.result.counts.inliers);
    let probe = model.probed_place().filter(|_| document.probe.side == Side::A && model.probe_is_current());
    let grid = params.used_slopes();
    let within = |wanted: Option<Between>, value: f32| wanted.is_none_or(|wanted| wanted.contains(value));
    // As long as features or inliers are not counted, no number of them is reached.
    let counted = |wanted: Option<Between>, value: Option<usize>| {
        wanted.is_none_or(|wanted| value.is_some_and(|value| wanted.contains(value as f32)))
    };
    within(goal.slope_u, cursor.slope.u)
        && within(goal.slope_v, cursor.slope.v)
        && same(goal.show, document.focused().shown())
        && same(goal.layout, layout(model))
        && within(goal.frame, cursor.frame as f32)
        && within(goal.octave, cursor.octave as f32)
        && within(goal.level, cursor.level as f32)
        && within(goal.frames_used, frames_used as f32)
        && counted(goal.features, is_current.then(|| model.features().len()))
        && same(goal.selected, Some(model.selected_feature().is_some()))
        && goal.probe.is_none_or(|near| probe.is_some_and(|place| near.contains(place)))
        && goal.params_are_met(&params, &document.matching)
        && goal.searches_u.is_none_or(|wanted| grid.u.min <= wanted.min && wanted.max <= grid.u.max)
        && within(goal.slopes, grid.len() as f32)
        && same(goal.tab, model.shows_bottom().then_some(document.bottom_tab))
        && same(goal.workspace, Some(document.workspace))
        && counted(goal.inliers, inliers)
        && same(goal.selected_match, Some(document.selected_match.is_some()))
        && same(goal.camera, Some(document.trajectories.selected.is_some()))
        && same(goal.reads_depths, Some(document.set_up.reads_depths))
        && same(goal.detects, Some(document.auto_detect))
        && same(goal.finds_slopes, Some(document.params.slopes.is_auto()))
}

fn same<T: PartialEq>(wanted: Option<T>, now: Option<T>) -> bool {
    wanted.is_none() || wanted == now
}

/// Layout of the panes, as far as their contents determine it.
fn layout(model: Read<'_>) -> Option<Layout> {
    let panes: Vec<_> = model.document.panes.each_shown().collect();
    let count = |content: fn(&Content) -> bool| panes.iter().filter(|pane| content(&pane.content)).count();
    let kinds = |kind: ViewKind| panes.iter().filter(|pane| pane.shows(kind)).count();
    let (slices, merges) = (count(|c| matches!(c, Content::Slice(_))), count(|c| *c == Content::Merge));
    let differ = |of: fn(&crate::app::pane::Pane) -> (i64, i64)| {
        let mut values: Vec<_> = panes.iter().map(|pane| of(pane)).collect();
        values.sort_unstable();
        values.dedup();
        values.len() == panes.len()
    };
    let slopes = differ(|pane| {
        let slope = pane.cursor.slope;
        ((1e4 * slope.u) as i64, (1e4 * slope.v) as i64)
    });
    let levels = differ(|pane| (i64::from(pane.cursor.octave), i64::from(pane.cursor.level)));
    match panes.len() {
        _ if model.document.compares_methods() => Some(Layout::Methods),
        1 => Some(Layout::Single),
        _ if slices > 0 => Some(Layout::Slice),
        2 if kinds(ViewKind::Frame) == 1 => Some(Layout::FrameAndStack),
        2 if slopes => Some(Layout::TwoSlopes),
        3 if slopes => Some(Layout::ThreeSlopes),
        4 if merges == 1 => Some(Layout::TwoByTwo),
        5 if slopes => Some(Layout::FiveSlopes),
        7 if slopes => Some(Layout::SevenSlopes),
        9 if slopes => Some(Layout::NineSlopes),
        n if levels && kinds(ViewKind::Dog) == n => Some(Layout::Scales),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::panes;
    use crate::app::results::Model;

    #[test]
    fn conditions_hold_within_their_bounds() {
        let mut model = Model::default();
        model.document.params.slopes = SlopeGrid::line(-3.0..=3.0, 7).into();
        for (text, met) in [
            ("", true),
            ("slope_v = [0, 0.6]\nslope_u = [1, 2]", false),
            ("level = [1, 2]", false),
            ("features = [0, 100]", false),
            ("inliers = [0, 9]", false),
            ("probe = [100, 50, 9]", false),
            ("searches_u = [-3, 2]", true),
            ("searches_u = [-4, 2]", false),
            ("slopes = [7, 7]", true),
        ] {
            let goal: Goal = toml::from_str(text).expect(text);
            assert_eq!(is_met(&goal, Read::of(&model)), met, "{text}");
        }
    }

    #[test]
    fn every_layout_is_seen_as_what_it_is() {
        let mut model = Model::default();
        // The search has seven slopes.
        for (layout_made, ..) in Layout::ALL.into_iter().filter(|(made, ..)| *made != Layout::NineSlopes) {
            panes::lay_out(&mut model, layout_made);
            assert_eq!(layout(Read::of(&model)), Some(layout_made));
        }
    }
}
