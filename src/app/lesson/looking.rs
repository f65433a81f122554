//! State of the window, as a lesson's goals see it.

use crate::app::pane::Content;
use crate::app::project::cursor::ViewKind;
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use crate::app::project::{BottomTab, Model};
use crate::teach::{Holds, Layout, Place, Tab};

/// Reads the present state of the window.
pub(in crate::app) fn seen(model: &Model) -> Holds<'_> {
    let cursor = model.cursor();
    let current = model.slots.a.found.is_some() && model.stale().is_none();
    let matches = model.pair.matches.as_ref().filter(|_| !model.needs_matches());
    Holds {
        slope: cursor.slope,
        show: model.focused().shown(),
        layout: layout(model),
        frame: cursor.frame,
        octave: cursor.octave,
        level: cursor.level,
        frames_used: model.params.used_frames(model.frame_count()).len(),
        features: current.then(|| model.features().len()),
        selected: model.selected_feature().is_some(),
        probe: model.probe.place().filter(|_| model.probe.side == Side::A && model.probe.is_current()),
        params: &model.params,
        matching: &model.pair.params,
        tab: tab(model.bottom_tab).filter(|_| model.panels.bottom),
        workspace: place(model.workspace),
        inliers: matches.and_then(|matches| matches.result.counts.inliers),
        selected_match: model.pair.selected.is_some(),
    }
}

/// Layout of the panes, as far as their contents determine it.
fn layout(model: &Model) -> Option<Layout> {
    let panes: Vec<_> = model.panes.shown().into_iter().filter_map(|id| model.panes.get(id)).collect();
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
        1 => Some(Layout::Single),
        _ if slices > 0 => Some(Layout::Slice),
        2 if kinds(ViewKind::Frame) == 1 => Some(Layout::FrameAndStack),
        2 if slopes => Some(Layout::TwoSlopes),
        3 if slopes => Some(Layout::ThreeSlopes),
        4 if merges == 1 => Some(Layout::TwoByTwo),
        5 if slopes => Some(Layout::FiveSlopes),
        n if levels && kinds(ViewKind::Dog) == n => Some(Layout::Scales),
        _ => None,
    }
}

fn tab(tab: BottomTab) -> Option<Tab> {
    match tab {
        BottomTab::Table => Some(Tab::Table),
        BottomTab::Tally => Some(Tab::Tally),
        BottomTab::Noise => Some(Tab::Noise),
        BottomTab::Slopes => Some(Tab::Slopes),
        BottomTab::Compared => Some(Tab::Compared),
        BottomTab::Profile | BottomTab::Region => None,
    }
}

fn place(workspace: Workspace) -> Option<Place> {
    match workspace {
        Workspace::Inspect => Some(Place::Inspect),
        Workspace::Pair => Some(Place::Pair),
        Workspace::Methods => Some(Place::Methods),
        Workspace::Matches | Workspace::Trajectories | Workspace::Lab => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::pane::Preset;

    #[test]
    fn every_layout_is_seen_as_what_it_is() {
        let mut model = Model::default();
        for (preset, expected) in [
            (Preset::FrameAndStack, Layout::FrameAndStack),
            (Preset::Single, Layout::Single),
            (Preset::TwoSlopes, Layout::TwoSlopes),
            (Preset::Slopes(3), Layout::ThreeSlopes),
            (Preset::Slopes(5), Layout::FiveSlopes),
            (Preset::Slice, Layout::Slice),
            (Preset::TwoByTwo, Layout::TwoByTwo),
            (Preset::Scales, Layout::Scales),
        ] {
            model.lay_out(preset);
            assert_eq!(layout(&model), Some(expected), "{preset:?}");
        }
    }
}
