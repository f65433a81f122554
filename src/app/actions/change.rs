//! Actions that only change values of the project: content, selection, links.

use super::ActionId;
use crate::app::canvas::overlay::ColourBy;
use crate::app::measure::Tool;
use crate::app::pane::Link;
use crate::app::project::Model;
use crate::app::project::cursor::{ViewKind, snapped, stepped};
use crate::app::project::workspace::Workspace;
use crate::detector::{Method, SearchParams, Slope, SlopeChoice, SlopeGrid};

/// Runs an action that only changes the project.
pub(super) fn change_model(model: &mut Model, id: ActionId) {
    use ActionId as A;
    match id {
        A::WorkspaceInspect => model.open_workspace(Workspace::Inspect),
        A::WorkspacePair => model.open_workspace(Workspace::Pair),
        A::WorkspaceMatches => model.open_workspace(Workspace::Matches),
        A::WorkspaceTrajectories => model.open_workspace(Workspace::Trajectories),
        A::WorkspaceMethods => model.open_workspace(Workspace::Methods),
        A::WorkspaceLab => model.open_workspace(Workspace::Lab),
        A::KeepCurves => model.lab.keep_current(),
        A::MeasureLine => model.measure.toggle(Tool::Line),
        A::MeasureRegion => model.measure.toggle(Tool::Region),
        A::ClearMeasure => model.measure.clear(),
        A::ClearSelection if model.measure.tool != Tool::Pan => model.measure.toggle(model.measure.tool),
        A::NextPane => model.panes.focus_next(true),
        A::PreviousPane => model.panes.focus_next(false),
        A::NextLayout => model.panes.next_over(),
        A::Flip => model.panes.flip(),
        A::CompareAgain => model.compare.forget_failures(),
        A::ToggleOverlay if model.workspace == Workspace::Methods => model.compare.look.features ^= true,
        A::ToggleOverlay if model.workspace == Workspace::Pair => model.pair.look.features ^= true,
        A::ToggleOverlay => model.look.overlay ^= true,
        A::ToggleMotion => model.look.motion_vectors ^= true,
        A::ToggleOrientation => model.look.orientations ^= true,
        A::ToggleLegend => model.look.legend ^= true,
        A::NextColouring => {
            let place = ColourBy::ALL.iter().position(|c| *c == model.colour_by).unwrap_or(0);
            model.colour_by = ColourBy::ALL[(place + 1) % ColourBy::ALL.len()];
        }
        A::ToggleLeft => model.panels.left ^= true,
        A::ToggleRight => model.panels.right ^= true,
        A::ToggleBottom => model.panels.bottom ^= true,
        A::ToggleFilmstrip => model.panels.filmstrip ^= true,
        A::ThemeSystem => model.theme = egui::ThemePreference::System,
        A::ThemeLight => model.theme = egui::ThemePreference::Light,
        A::ThemeDark => model.theme = egui::ThemePreference::Dark,
        A::AutoDetect => model.auto_detect ^= true,
        A::ResetParams => model.set_search(SearchParams::default()),
        A::Preset1d => {
            (model.params.method, model.slopes) = (Method::Buff, SlopeChoice::Given);
            model.params.slopes = SlopeGrid::line(-3.0..=3.0, 7);
        }
        A::Preset2d => {
            (model.params.method, model.slopes) = (Method::Buff, SlopeChoice::Given);
            model.params.slopes = SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7);
        }
        A::PresetSift => model.params.method = Method::Sift,
        A::NextFeature if model.workspace == Workspace::Pair => model.pair.select_neighbour(true),
        A::PreviousFeature if model.workspace == Workspace::Pair => model.pair.select_neighbour(false),
        A::StrongestFeature if model.workspace == Workspace::Pair => {
            model.pair.selected = model.pair.listed.first().copied();
        }
        A::ClearSelection if model.workspace == Workspace::Pair => model.ask_feature(None),
        A::NextFeature => model.select_neighbour(true),
        A::PreviousFeature => model.select_neighbour(false),
        A::StrongestFeature => model.selected = model.listed.first().copied(),
        A::ClearSelection => (model.selected, model.slots.a.against.selected) = (None, None),
        A::ClearFilter => model.filter = Default::default(),
        A::OtherSide => model.focus_other_side(),
        A::ProbeExpected => model.probe_expected(),
        A::LinkCursors => model.toggle_link(Link::Cursor),
        A::LinkViews => model.toggle_link(Link::View),
        A::LinkRanges => model.toggle_link(Link::Display),
        A::ResetMatching => model.pair.params = Default::default(),
        A::ToggleInliers => model.pair.look.inliers ^= true,
        A::ToggleOutliers => model.pair.look.outliers ^= true,
        A::ToggleAlone => model.pair.look.alone ^= true,
        A::ToggleEpipolar => model.pair.look.geometry ^= true,
        _ => move_cursor(model, id),
    }
}

/// Runs an action that moves the cursor of the focused pane.
fn move_cursor(model: &mut Model, id: ActionId) {
    use ActionId as A;
    let grid = model.cursor_params().slopes;
    let slope = model.cursor().slope;
    let slope = match id {
        A::SlopeULess => Some(stepped(&grid, slope, false, false)),
        A::SlopeUMore => Some(stepped(&grid, slope, false, true)),
        A::SlopeVLess => Some(stepped(&grid, slope, true, false)),
        A::SlopeVMore => Some(stepped(&grid, slope, true, true)),
        A::SlopeZero => Some(Slope::default()),
        A::SnapSlope => Some(snapped(&grid, slope)),
        _ => None,
    };
    if let Some(slope) = slope {
        model.playing = false;
        let pane = model.focused_mut();
        pane.cursor.slope = slope;
        pane.show_slope();
    }
    if id == A::BusiestSlope {
        model.playing = false;
        model.go_to_busiest_slope(model.focus());
        model.focused_mut().show_slope();
    }
    let pane = model.focused_mut();
    let cursor = &mut pane.cursor;
    match id {
        A::FramePrevious => cursor.frame = cursor.frame.saturating_sub(1),
        A::FrameNext => cursor.frame += 1,
        A::OctaveFiner => cursor.octave -= 1,
        A::OctaveCoarser => cursor.octave += 1,
        A::LevelDown => cursor.level -= 1,
        A::LevelUp => cursor.level += 1,
        _ => {}
    }
    // A key that moves through frames or scales also shows a frame or a scale.
    match id {
        A::FramePrevious | A::FrameNext => pane.show(ViewKind::Frame),
        A::OctaveFiner | A::OctaveCoarser | A::LevelDown | A::LevelUp => pane.show_scale(),
        _ => id.shown().into_iter().for_each(|shown| pane.show_kind(shown)),
    }
    model.check_params();
}
