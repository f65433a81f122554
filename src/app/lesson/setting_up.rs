//! Sets the window up for a step.

use crate::app::canvas::{View, Zoom};
use crate::app::pane::{Content, PaneId, PaneLinks, Preset};
use crate::app::project::cursor::{Cursor, ViewKind};
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::app::project::{BottomTab, Model, Panels};
use crate::detector::DetectorParams;
use crate::teach::{Layout, Place, Shown, State, Tab};

/// Sets the model up as `state` says; its bursts are open already.
pub(in crate::app) fn set_up(model: &mut Model, state: &State) {
    let place = state.workspace.unwrap_or(Place::Inspect);
    model.workspace = match place {
        Place::Inspect => Workspace::Inspect,
        Place::Pair => Workspace::Pair,
        Place::Methods => Workspace::Methods,
    };
    model.set_search(state.params.clone().unwrap_or_else(|| DetectorParams::default().into()));
    model.pair.params = state.matching.clone().unwrap_or_default();
    let in_pair = place == Place::Pair;
    model.panels =
        Panels { left: true, right: state.select.is_some(), bottom: state.tab.is_some() || in_pair, filmstrip: false };
    model.auto_detect = state.detect.unwrap_or(false);
    model.look.overlay = state.features.unwrap_or(model.auto_detect);
    model.bottom_tab = match state.tab.unwrap_or(Tab::Table) {
        Tab::Table => BottomTab::Table,
        Tab::Tally => BottomTab::Tally,
        Tab::Noise => BottomTab::Noise,
        Tab::Slopes => BottomTab::Slopes,
        Tab::Compared => BottomTab::Compared,
    };
    for side in Side::BOTH {
        if !model.auto_detect || !model.features_are_current(side) {
            model.slots[side].found = None;
        }
    }
    (model.selected, model.hovered, model.reselect) = (None, None, None);
    (model.pair.selected, model.playing, model.filter) = (None, false, Default::default());
    model.measure.clear();
    model.probe.clear();
    model.look.ranges.forget();
    set_up_panes(model, state);
    model.check_params();
    model.check_pair();
    model.refresh_listed();
    if let Some(layout) = state.layout {
        model.lay_out(preset_of(layout));
    }
    if let Some(place) = state.probe {
        model.probe_place(Side::A, place);
        // Slices need the space that the probe's panel would take.
        model.panels.right = state.layout != Some(Layout::Slice);
    }
    model.settle_ranges();
    model.history.clear();
}

fn set_up_panes(model: &mut Model, state: &State) {
    model.panes.show_alone(PaneId::of(Side::A));
    let frame = state.frame.unwrap_or_else(|| model.frame_count() / 2);
    let cursor = Cursor {
        kind: ViewKind::Stack,
        frame,
        slope: state.slope.unwrap_or_default(),
        octave: state.octave.unwrap_or(0),
        level: state.level.unwrap_or(0),
    };
    for side in Side::BOTH {
        let pane = model.panes.of_mut(side);
        (pane.cursor, pane.slope_chosen, pane.content) = (cursor, true, Content::Cursor);
        (pane.own_ranges, pane.links, pane.over) = (None, PaneLinks::default(), None);
        pane.view = match state.view {
            Some([u, v, zoom]) => View::new(Zoom::PointsPerPixel(zoom), [u, v]),
            None => View::fit(),
        };
        pane.show_kind(state.show.unwrap_or(Shown::Stack));
    }
}

fn preset_of(layout: Layout) -> Preset {
    match layout {
        Layout::Single => Preset::Single,
        Layout::FrameAndStack => Preset::FrameAndStack,
        Layout::TwoSlopes => Preset::TwoSlopes,
        Layout::ThreeSlopes => Preset::Slopes(3),
        Layout::FiveSlopes => Preset::Slopes(5),
        Layout::Scales => Preset::Scales,
        Layout::Slice => Preset::Slice,
        Layout::TwoByTwo => Preset::TwoByTwo,
    }
}
