//! Actions that change the project: its values, and what it asks of the engine.

use super::ActionId;
use crate::app::canvas::View;
use crate::app::canvas::overlay::ColourBy;
use crate::app::document::Document;
use crate::app::inspector::PaneWidgets;
use crate::app::measure::Tool;
use crate::app::pane::{Direction, Link, Pane, Preset};
use crate::app::project::comparison::Reference;
use crate::app::project::cursor::{ViewKind, snapped, stepped};
use crate::app::project::effect::{ExportKind, Purpose};
use crate::app::project::method::plane_of;
use crate::app::project::panes::Change;
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use crate::app::project::{BottomTab, Effect, Model, Visibility};
use crate::detector::{Method, SearchParams, Slope, SlopeChoice, SlopeGrid};
use crate::engine::Engine;
use crate::requests::{BurstSource, ProbeQuestion};
use crate::synth::Example;

pub(super) fn change(id: ActionId, model: &mut Model, engine: &Engine) -> Option<Effect> {
    use ActionId as A;
    if let Some(purpose) = asked_files(id, model.active_side()) {
        return Some(Effect::Ask(purpose));
    }
    if let Some(source) = built_in(id) {
        model.open(Side::A, source, engine);
        return None;
    }
    if let Some(preset) = layout(id) {
        model.change_panes(Change::LayOut(model.focus(), preset));
        return None;
    }
    if let Some(workspace) = workspace(id) {
        model.open_workspace(workspace);
        return None;
    }
    match id {
        A::CloseDataset => return Some(model.close_dataset()),
        A::CutSequence => return model.cut_of_open_burst(),
        A::DetectAll => return model.ask_and_detect_all(engine),
        A::Detect => {
            model.start_detection(Side::A, engine);
            if model.workspace == Workspace::Pair && model.slots.b.param_error.is_none() {
                model.start_detection(Side::B, engine);
            }
        }
        A::Cancel => model.cancel_searches(),
        A::CancelDataset => model.datasets.wanted.cancel(),
        A::CancelStudy => model.studies.wanted.cancel(),
        A::CancelFigures => model.figures.cancel(),
        A::Match => {
            if let Some(wanted) = model.wanted_matches() {
                model.pair.matching.ask(engine, wanted);
            }
        }
        A::MatchPairs => model.match_pairs(engine),
        A::MatchSelected => model.match_selected(engine),
        A::RunStudy => model.run_study(engine),
        A::OpenChart => {
            if let Some(chart) = model.selected_chart().and_then(|chart| chart.params()) {
                model.workspace = Workspace::Inspect;
                model.open(Side::A, BurstSource::Chart(Box::new(chart)), engine);
            }
        }
        A::OpenPlanted => model.open_planted(engine),
        A::OpenDarkCopy => {
            if let Some(burst) = &model.slots.a.burst {
                let of = Box::new(burst.source.clone());
                model.open(Side::A, BurstSource::DarkCopy { of, noise: model.lab.dark_copy }, engine);
            }
        }
        A::PreviousBurst => model.step_burst(-1, engine),
        A::NextBurst => model.step_burst(1, engine),
        A::ShowPair => model.show_selected_pair(engine),
        A::UseFolderParams => model.use_folder_params(engine),
        A::OpenDemoB => {
            model.open(Side::B, BurstSource::DemoLater, engine);
        }
        A::CloseB => {
            model.close_second();
            model.forget_closed_trails(engine);
        }
        _ => change_values(id, model),
    }
    None
}

fn asked_files(id: ActionId, active: Side) -> Option<Purpose> {
    use ActionId as A;
    Some(match id {
        A::OpenFolder => Purpose::OpenFolder,
        A::OpenFiles => Purpose::OpenFiles,
        A::OpenDataset => Purpose::OpenDataset,
        A::OpenFolderB => Purpose::OpenFolderB,
        A::OpenFilesB => Purpose::OpenFilesB,
        A::OpenGoldA => Purpose::OpenGold(Side::A),
        A::OpenGoldB => Purpose::OpenGold(Side::B),
        A::OpenLessons => Purpose::OpenLessons,
        A::OpenFeatures => Purpose::OpenFeatures(active),
        A::OpenEstimate => Purpose::OpenEstimate,
        A::OpenTruth => Purpose::OpenTruth,
        A::FeatureFolder => Purpose::FeatureFolder,
        A::PaperFigures => Purpose::PaperFigures,
        A::ExportDatabase => Purpose::ExportDatabase,
        A::RestoreSession => Purpose::RestoreSession,
        A::SaveSession => Purpose::SaveSession,
        A::LoadParams => Purpose::LoadParams,
        A::SaveParams => Purpose::SaveParams,
        A::ExportCsv => Purpose::Export(ExportKind::Csv),
        A::ExportColmap => Purpose::Export(ExportKind::Colmap),
        A::ExportNpz => Purpose::Export(ExportKind::Npz),
        A::ExportTiff => Purpose::Export(ExportKind::Tiff),
        A::ExportPng => Purpose::Export(ExportKind::Png),
        A::ExportFigure => Purpose::Export(ExportKind::Figure),
        A::ExportMatches => Purpose::Export(ExportKind::Matches),
        A::ExportMethods => Purpose::Export(ExportKind::Methods),
        A::ExportProfile => Purpose::Export(ExportKind::Profile),
        A::ExportSheet => Purpose::Export(ExportKind::Sheet),
        A::SaveCase => Purpose::Export(ExportKind::Case),
        A::ExportFilmGif => Purpose::Export(ExportKind::FilmGif),
        A::ExportCurvesCsv => Purpose::Export(ExportKind::CurvesCsv),
        A::ExportCurvesSvg => Purpose::Export(ExportKind::CurvesSvg),
        _ => return None,
    })
}

fn built_in(id: ActionId) -> Option<BurstSource> {
    use ActionId as A;
    Some(BurstSource::Example(match id {
        A::OpenDemo => return Some(BurstSource::Demo),
        A::OpenDepths => Example::Depths,
        A::OpenCrossing => Example::Crossing,
        A::OpenStreet => Example::Street,
        A::OpenStreetLater => Example::StreetLater,
        A::OpenAliasing => Example::Aliasing,
        A::OpenLowContrast => Example::LowContrast,
        A::OpenTripod => Example::Tripod,
        A::OpenHotPixels => Example::HotPixels,
        _ => return None,
    }))
}

pub(super) fn layout(id: ActionId) -> Option<Preset> {
    use ActionId as A;
    Some(match id {
        A::LayoutSingle => Preset::Single,
        A::LayoutFrameAndStack => Preset::FrameAndStack,
        A::LayoutTwoSlopes => Preset::TwoSlopes,
        A::LayoutThreeSlopes => Preset::ThreeSlopes,
        A::LayoutFiveSlopes => Preset::FiveSlopes,
        A::LayoutSevenSlopes => Preset::SevenSlopes,
        A::LayoutNineSlopes => Preset::NineSlopes,
        A::LayoutSlice => Preset::Slice,
        A::LayoutScales => Preset::Scales,
        A::LayoutTwoByTwo => Preset::TwoByTwo,
        _ => return None,
    })
}

/// The workspaces, in the order of the switch, with the actions that open them.
pub const WORKSPACES: [(ActionId, Workspace); 6] = [
    (ActionId::WorkspaceInspect, Workspace::Inspect),
    (ActionId::WorkspacePair, Workspace::Pair),
    (ActionId::WorkspaceMethods, Workspace::Methods),
    (ActionId::WorkspaceMatches, Workspace::Matches),
    (ActionId::WorkspaceTrajectories, Workspace::Trajectories),
    (ActionId::WorkspaceLab, Workspace::Lab),
];

pub(super) fn workspace(id: ActionId) -> Option<Workspace> {
    WORKSPACES.into_iter().find(|(opens, _)| *opens == id).map(|(_, workspace)| workspace)
}

/// The place under the pointer, or else the middle of what is seen of the picture in focus; with its side.
pub fn place_to_probe(model: &Model, widgets: &PaneWidgets) -> Option<(Side, [f32; 2])> {
    let middle = || {
        let visible = widgets.get(model.focus())?.picture.visible_image?.center();
        let (width, height) = model.focused_size();
        let within = |x: f32, n: usize| x.clamp(0.0, n.saturating_sub(1) as f32);
        Some((model.focused().side, [within(visible.x, width), within(visible.y, height)]))
    };
    model.probed.pointer.or_else(middle)
}

fn change_values(id: ActionId, model: &mut Model) {
    use ActionId as A;
    match id {
        A::Play => model.toggle_play(),
        A::GoToFeature if model.workspace == Workspace::Pair => {
            model.go_to_match();
        }
        A::GoToFeature => model.go_to_selected(),
        A::BurstAsA => model.choose_open_burst(Side::A),
        A::BurstAsB => model.choose_open_burst(Side::B),
        A::CloseTrajectories => model.close_trajectories(),
        A::SwapSides => model.swap_sides(),
        A::ProbeFeature => {
            if let Some((side, index)) = model.feature_to_probe() {
                model.probe_feature(side, index);
            }
        }
        A::ProbeStrongest => model.ask_probe(model.active_side(), ProbeQuestion::Strongest),
        A::ProbeFollow => model.follow_with_probe(),
        A::CloseProbe => model.clear_probe(),
        A::PinResult => {
            model.pin_result(model.active_side());
            model.bottom_tab = BottomTab::Compared;
            model.messages.note("Pinned: later detections are compared with these features");
        }
        A::UnpinResult => model.forget_reference(model.active_side(), Reference::Pinned),
        A::CloseFeatures => model.forget_reference(model.active_side(), Reference::File),
        A::ShowTruth => {
            let side = model.active_side();
            let on = model.comparisons[side].with == Some(Reference::Truth);
            model.show_comparison(side, (!on).then_some(Reference::Truth));
            model.bottom_tab = BottomTab::Compared;
        }
        A::KeepCurves => model.studies.keep_current(),
        A::CompareAgain => model.compare.forget_failures(),
        A::ToggleLeft if model.shows_left() => model.panels.left = Visibility::Closed,
        A::ToggleLeft => model.open_left(),
        A::ToggleRight => model.panels.right = Visibility::from(!model.shows_right()),
        A::ToggleBottom => model.panels.bottom = Visibility::from(!model.shows_bottom()),
        A::NextFeature if model.workspace == Workspace::Pair => model.select_neighbouring_match(true),
        A::PreviousFeature if model.workspace == Workspace::Pair => model.select_neighbouring_match(false),
        A::StrongestFeature if model.workspace == Workspace::Pair => {
            model.selected_match = model.pair.listed.first().copied();
        }
        A::NextFeature => model.select_neighbour(true),
        A::PreviousFeature => model.select_neighbour(false),
        A::StrongestFeature => model.selected = model.listed.first().copied(),
        A::ProbeExpected => {
            if let Some(place) = model.expected_place() {
                model.probe_place(Side::B, place);
            }
        }
        A::BusiestSlope => {
            let focus = model.focus();
            model.playing = false;
            model.go_to_busiest_slope(focus);
            model.lead(focus, Pane::show_slope);
        }
        _ => {
            let grid = model.cursor_params().slopes;
            change_document(id, &grid, &mut model.document);
        }
    }
}

/// Changes the document alone. `grid` has the slopes to go through.
fn change_document(id: ActionId, grid: &SlopeGrid, document: &mut Document) {
    use ActionId as A;
    match id {
        A::Fit => document.change_views(View::set_fit),
        A::ZoomIn => document.change_views(|view| view.zoom_by(1.25)),
        A::ZoomOut => document.change_views(|view| view.zoom_by(0.8)),
        A::SplitRight => drop(document.panes.split(document.focus(), Direction::Right)),
        A::SplitDown => drop(document.panes.split(document.focus(), Direction::Down)),
        A::ClosePane => document.panes.close(document.focus()),
        A::MeasureLine => document.measure.toggle(Tool::Line),
        A::MeasureRegion => document.measure.toggle(Tool::Region),
        A::ClearMeasure => document.measure.clear(),
        A::ClearSelection if document.measure.tool != Tool::Pan => {
            let tool = document.measure.tool;
            document.measure.toggle(tool);
        }
        A::NextPane => document.panes.focus_next(true),
        A::PreviousPane => document.panes.focus_next(false),
        A::NextLayout => document.panes.next_over(),
        A::Flip => document.panes.flip(),
        A::ToggleOverlay if document.workspace == Workspace::Methods => document.methods.features ^= true,
        A::ToggleOverlay if document.workspace == Workspace::Pair => document.match_look.features ^= true,
        A::ToggleOverlay => document.look.overlay = document.look.overlay.next(),
        A::ToggleMotion => document.look.motion_vectors ^= true,
        A::ToggleOrientation => document.look.orientations ^= true,
        A::ToggleLegend => document.look.legend ^= true,
        A::NextColouring => {
            let choices = || ColourBy::choices(document.set_up.reads_depths);
            let next = choices().skip_while(|by| *by != document.colour_by).nth(1);
            document.colour_by = next.unwrap_or_default();
        }
        A::ToggleFilmstrip => document.panels.filmstrip ^= true,
        A::ThemeSystem => document.theme = egui::ThemePreference::System,
        A::ThemeLight => document.theme = egui::ThemePreference::Light,
        A::ThemeDark => document.theme = egui::ThemePreference::Dark,
        A::AutoDetect => document.auto_detect ^= true,
        A::SlopesFromSetUp => document.show_set_up(),
        A::ResetParams => document.set_search(SearchParams::default()),
        A::Preset1d => {
            (document.params.method, document.slopes) = (Method::Buff, SlopeChoice::Given);
            document.params.slopes = SlopeGrid::line(-3.0..=3.0, 7);
        }
        A::Preset2d => {
            (document.params.method, document.slopes) = (Method::Buff, SlopeChoice::Given);
            document.params.slopes = plane_of(document.params.slopes);
        }
        A::PresetSift => document.params.method = Method::Sift,
        A::ClearSelection if document.workspace == Workspace::Pair => {
            (document.selected_match, document.asked_about) = (None, None);
        }
        A::ClearSelection => (document.selected, document.comparisons.a.selected) = (None, None),
        A::ClearFilter => document.filter = Default::default(),
        A::OtherSide => document.focus_other_side(),
        A::LinkCursors => document.toggle_link(Link::Cursor),
        A::LinkViews => document.toggle_link(Link::View),
        A::LinkRanges => document.toggle_link(Link::Display),
        A::ResetMatching => document.matching = Default::default(),
        A::ToggleInliers => document.match_look.inliers ^= true,
        A::ToggleOutliers => document.match_look.outliers ^= true,
        A::ToggleAlone => document.match_look.alone ^= true,
        A::ToggleEpipolar => document.match_look.geometry ^= true,
        _ => move_cursor(id, grid, document),
    }
}

fn move_cursor(id: ActionId, grid: &SlopeGrid, document: &mut Document) {
    use ActionId as A;
    let slope = document.cursor().slope;
    let slope = match id {
        A::SlopeULess => Some(stepped(grid, slope, false, false)),
        A::SlopeUMore => Some(stepped(grid, slope, false, true)),
        A::SlopeVLess => Some(stepped(grid, slope, true, false)),
        A::SlopeVMore => Some(stepped(grid, slope, true, true)),
        A::SlopeZero => Some(Slope::default()),
        A::SnapSlope => Some(snapped(grid, slope)),
        _ => None,
    };
    let focus = document.focus();
    if let Some(slope) = slope {
        document.playing = false;
        document.show_slope(focus, slope);
    }
    document.lead(focus, |pane| {
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
            _ => id.shown().into_iter().for_each(|shown| pane.show(shown)),
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::actions::apply;
    use crate::app::project::tests::Bench;

    #[test]
    fn a_plane_keeps_the_slopes_that_were_found_and_one_step_back_returns_to_them() {
        let Bench { mut model, engine } = Bench::new();
        (model.slopes, model.params.slopes) = (SlopeChoice::AUTO, SlopeGrid::line(-6.0..=-3.0, 4));
        let found = (model.params.clone(), model.slopes);
        assert!(apply(ActionId::Preset2d.into(), &mut model, &engine).is_empty());
        model.close_step(false);
        assert_eq!(model.params.slopes, SlopeGrid::plane(-6.0..=-3.0, 4, -2.0..=2.0, 5));
        assert!(!model.slopes.is_auto());
        model.undo();
        assert!((model.params.clone(), model.slopes) == found && !model.history.can_undo());
        model.redo();
        assert!(model.params.slopes.is_plane() && !model.slopes.is_auto());
    }
}
