//! Steps and the project: sets it up as a step begins, and reads from it what the goals of tasks ask about.

use crate::app::canvas::{View, Zoom};
use crate::app::document::cursor::ViewKind;
use crate::app::document::{Cursor, Document, FeaturesShown, Panels, SetUpState, Side, Staged, Trajectories};
use crate::app::pane::{Content, PaneId, PaneLinks, Panes};
use crate::app::results::Read;
use crate::detector::{SearchParams, SlopeGrid};
use crate::teach::{InView, Layout, Part, Situation, State, Step, Workspace};

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

/// The step as it begins; its bursts are open already.
pub(super) fn begin(step: &Step, model: Read<'_>) -> Staged {
    let document = Box::new(document_of(step, model.frame_count(), model.document));
    Staged::Begin { document, layout: step.state.layout, probe: step.state.probe }
}

/// The document of a step whose burst A has this many `frames`: what the step leaves open is as in a new window, and
/// how the window looks as it was `before`.
fn document_of(step: &Step, frames: usize, before: &Document) -> Document {
    let state = step.state.clone();
    let auto_detect = state.detect.unwrap_or(false);
    let has_features = state.features.unwrap_or(auto_detect);
    let set_up = SetUpState {
        values: state.set_up.unwrap_or_default(),
        is_open: state.set_up.is_some(),
        ..SetUpState::default()
    };
    let (selected, selected_match, playing) = (None, None, false);
    let trajectories = Trajectories { selected: None, view: View::fit(), ..before.trajectories.clone() };
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
        trajectories,
        ..Document { selected, selected_match, playing, ..before.clone() }
    };
    document.read_depths(false);
    document.params = state
        .params
        .clone()
        .unwrap_or_else(|| SearchParams { slopes: SlopeGrid::default().into(), ..SearchParams::default() });
    document.look.overlay = if has_features { FeaturesShown::ThisSlope } else { FeaturesShown::None };
    document.look.ranges.forget();
    set_panes(&mut document.panes, &state, frames);
    document
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

pub(super) fn seen(model: Read<'_>) -> Situation<'_> {
    let cursor = model.document.cursor();
    let current = model.results.slots.a.found.is_some() && model.stale().is_none();
    let matches = model.results.pair.matches.as_ref().filter(|_| !model.needs_matches());
    Situation {
        slope: cursor.slope,
        show: model.document.focused().shown(),
        layout: layout(model),
        frame: cursor.frame,
        octave: cursor.octave,
        level: cursor.level,
        frames_used: model.document.params.used_frames(model.frame_count()).len(),
        features: current.then(|| model.features().len()),
        selected: model.selected_feature().is_some(),
        probe: model.probed_place().filter(|_| model.document.probe.side == Side::A && model.probe_is_current()),
        params: model.params_of(Side::A),
        matching: &model.document.matching,
        tab: model.shows_bottom().then_some(model.document.bottom_tab),
        workspace: model.document.workspace,
        inliers: matches.and_then(|matches| matches.result.counts.inliers),
        selected_match: model.document.selected_match.is_some(),
        camera: model.document.trajectories.selected.is_some(),
        reads_depths: model.document.set_up.reads_depths,
        detects: model.document.auto_detect,
        finds_slopes: model.document.params.slopes.is_auto(),
    }
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
    fn every_layout_is_seen_as_what_it_is() {
        let mut model = Model::default();
        // The search has seven slopes.
        for (layout_made, ..) in Layout::ALL.into_iter().filter(|(made, ..)| *made != Layout::NineSlopes) {
            panes::lay_out(&mut model, layout_made);
            assert_eq!(layout(Read::of(&model)), Some(layout_made));
        }
    }
}
