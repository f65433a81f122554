//! State of the actions: which are enabled, and which switches are on.

use super::registry::{ActionId, Does};
use crate::app::document::comparison::Reference;
use crate::app::document::look::FeaturesShown;
use crate::app::measure::Tool;
use crate::app::pane::{Link, MAX_PANES, Over};
use crate::app::results::Model;
use crate::detector::{Method, SearchParams};
use crate::matching::MatchParams;
use crate::requests::BurstSource;
use crate::teach::Workspace;

pub fn enabled(id: ActionId, model: &Model) -> bool {
    use ActionId as A;
    let has_burst = model.results.slots.a.burst.is_some();
    let in_pair = model.document.workspace == Workspace::Pair;
    let in_methods = model.document.workspace == Workspace::Methods;
    let (in_inspect, has_panes) =
        (model.document.workspace == Workspace::Inspect, model.document.workspace.needs_burst());
    let many_panes = has_panes && model.document.panes.are_many();
    let has_second = model.results.slots.b.burst.is_some();
    let active = &model.results.slots[model.active_side()];
    match id {
        A::NextFeature | A::PreviousFeature | A::StrongestFeature if in_pair => !model.results.pair.listed.is_empty(),
        A::ClearSelection if in_pair => model.asked_feature().is_some(),
        A::GoToFeature if in_pair => model.document.selected_match.is_some(),
        A::Undo => model.history.can_undo(),
        A::Redo => model.history.can_redo(),
        A::CopyCommand => has_burst && active.param_error.is_none(),
        A::UnpinResult => model.has_reference(model.active_side(), Reference::Pinned),
        A::CloseFeatures => model.has_reference(model.active_side(), Reference::File),
        A::ShowTruth => model.has_reference(model.active_side(), Reference::Truth),
        A::CopyPicture => model.picture().is_some(),
        A::MeasureLine | A::MeasureRegion | A::DrawMask => has_burst && in_inspect,
        A::ClearMeasure => !model.document.measure.is_empty(),
        A::UseMask => !model.document.measure.hidden.is_empty() && in_inspect,
        A::ExportProfile => model.document.measure.line.is_some() && in_inspect,
        A::ClearSelection if in_inspect && model.document.measure.tool != Tool::Pan => true,
        A::NextLayout => many_panes,
        A::Flip => matches!(model.document.panes.over(model.document.focus()), Some(Over::Flip { .. })),
        A::SplitRight | A::SplitDown => has_burst && has_panes && model.document.panes.shown().len() < MAX_PANES,
        A::ClosePane | A::NextPane | A::PreviousPane => has_burst && many_panes,
        A::CompareAgain => in_methods,
        A::RunStudy => !model.results.studies.wanted.is_pending() && model.lab_study().is_ok(),
        A::CancelStudy => model.results.studies.wanted.is_pending(),
        A::KeepCurves => model.results.studies.current.is_some() && !model.results.studies.wanted.is_pending(),
        A::OpenPlanted => model.selected_thing().is_some() && has_burst,
        A::OpenChart => model.selected_chart().is_some(),
        A::ExportCurvesCsv | A::ExportCurvesSvg => !model.lab_results().is_empty(),
        A::OpenGoldB => has_burst && has_second,
        A::CloseB | A::SwapSides => has_burst && has_second,
        A::OtherSide => in_pair && has_second,
        A::LinkCursors | A::LinkViews | A::LinkRanges => in_pair || many_panes,
        A::ToggleInliers | A::ToggleOutliers | A::ToggleAlone | A::ToggleEpipolar => in_pair,
        A::Match => in_pair && !model.results.pair.matching.is_pending() && model.wanted_matches().is_some(),
        A::ProbeExpected => in_pair && model.expected_place().is_some(),
        A::ResetMatching => model.document.matching != MatchParams::default(),
        A::CopyRow
        | A::OpenFeatures
        | A::OpenDarkCopy
        | A::OpenGoldA
        | A::OpenFolderB
        | A::OpenFilesB
        | A::OpenPathB
        | A::OpenDemoB
        | A::SaveSession
        | A::SaveCase
        | A::FilmOptions
        | A::ExportFilmGif
        | A::Fit
        | A::OneToOne
        | A::ZoomIn
        | A::ZoomOut => has_burst,
        A::PinResult | A::ExportCsv | A::ExportColmap | A::ExportNpz | A::BusiestSlope => active.found.is_some(),
        A::ExportMatches => model.results.pair.matches.is_some(),
        A::ExportMethods => model.document.workspace == Workspace::Methods && !model.methods_shown().is_empty(),
        A::ExportTiff | A::ExportPng | A::ExportFigure | A::FigureOptions => model.picture().is_some(),
        A::SlopeULess | A::SlopeUMore | A::SlopeVLess | A::SlopeVMore | A::SlopeZero | A::SnapSlope => has_burst,
        A::Play => has_burst && model.cursor_params().slopes.len() > 1,
        A::FramePrevious | A::FrameNext => has_burst && model.focused_frame_count() > 1,
        A::OctaveFiner | A::OctaveCoarser | A::LevelDown | A::LevelUp => has_burst,
        A::Detect => {
            has_burst
                && model.results.slots.a.param_error.is_none()
                && model.results.slots.both().into_iter().all(|slot| !slot.detecting.is_pending())
        }
        A::Cancel => model.is_searching(),
        A::ResetParams => model.asked() != SearchParams::default(),
        A::NextFeature | A::PreviousFeature | A::StrongestFeature => !model.results.listed.is_empty(),
        A::ClearSelection => {
            model.read().selected_feature().is_some() || model.document.comparisons.a.selected.is_some()
        }
        A::GoToFeature => model.read().selected_feature().is_some(),
        A::ProbePlace | A::ProbeFollow | A::ProbeStrongest => {
            let can_search = active.found.is_some() || active.param_error.is_none();
            has_burst && (in_inspect || in_pair) && can_search
        }
        A::ProbeFeature => (in_inspect || in_pair) && model.feature_to_probe().is_some(),
        A::CloseProbe => model.document.probe.is_on() || model.results.probed.answer.is_some(),
        A::ClearFilter => !model.document.filter.is_open(),
        A::DetectAll => model.results.datasets.can_detect(model.asked().validate().is_ok()),
        A::CancelDataset => model.results.datasets.work.is_some(),
        A::ToggleFilmstrip | A::PreviousBurst | A::NextBurst | A::FeatureFolder | A::CloseDataset => {
            model.results.datasets.open.is_some()
        }
        A::BurstAsA | A::BurstAsB => model
            .results
            .datasets
            .open
            .as_ref()
            .is_some_and(|d| d.place_of(model.results.slots.a.burst.as_ref()).is_some()),
        A::MatchPairs => model.results.datasets.can_match(model.document.matching.validate().is_ok()),
        A::MatchSelected => {
            let chosen = model.document.dataset.as_ref().is_some_and(|set| set.selected().is_some());
            chosen && model.results.datasets.can_match(model.document.matching.validate().is_ok())
        }
        A::ExportDatabase => {
            let several = model.results.datasets.open.as_ref().is_some_and(|d| d.bursts.len() > 1);
            cfg!(feature = "colmap") && several && model.results.datasets.work.is_none()
        }
        A::PaperFigures => !model.results.figures.is_pending(),
        A::CancelFigures => model.results.figures.is_pending(),
        A::ShowPair => model.document.dataset.as_ref().is_some_and(|set| set.selected().is_some()),
        A::CloseTrajectories => !model.results.poses.is_empty(),
        A::UseFolderParams => model.results.datasets.open.as_ref().is_some_and(|d| d.other_params.is_some()),
        A::LeaveLesson | A::Hall | A::ExportSheet => model.is_in_lesson(),
        A::CutSequence => {
            let in_files =
                model.results.slots.a.burst.as_ref().is_some_and(|b| matches!(b.source, BurstSource::Paths(_)));
            in_files && model.frame_count() > 1
        }
        _ => match id.action().does {
            Some(Does::LayOut(_)) => has_burst && in_inspect,
            Some(Does::Show(_)) => has_burst,
            _ => true,
        },
    }
}

pub fn checked(id: ActionId, model: &Model) -> Option<bool> {
    use ActionId as A;
    match id {
        A::ToggleOverlay if model.document.workspace == Workspace::Methods => Some(model.document.methods.features),
        A::LinkCursors => Some(model.document.panes.all_share(Link::Cursor)),
        A::LinkViews => Some(model.document.panes.all_share(Link::View)),
        A::LinkRanges => Some(model.document.panes.all_share(Link::Display)),
        A::ToggleOverlay if model.document.workspace == Workspace::Pair => Some(model.document.match_look.features),
        A::ToggleOverlay => Some(model.document.look.overlay != FeaturesShown::None),
        A::ToggleLeft => Some(model.shows_left()),
        A::ToggleRight => Some(model.shows_right()),
        A::ToggleBottom => Some(model.shows_bottom()),
        A::Hall => Some(model.document.panels.hall),
        A::ThemeSystem => Some(model.document.theme == egui::ThemePreference::System),
        A::ThemeLight => Some(model.document.theme == egui::ThemePreference::Light),
        A::ThemeDark => Some(model.document.theme == egui::ThemePreference::Dark),
        A::ShowTruth => Some(model.document.comparisons[model.active_side()].with == Some(Reference::Truth)),
        A::ProbeFollow => Some(model.document.probe.follows),
        A::Play => Some(model.document.playing),
        A::MeasureLine => Some(model.document.measure.tool == Tool::Line),
        A::DrawMask => Some(model.document.measure.tool == Tool::Mask),
        A::MeasureRegion => Some(model.document.measure.tool == Tool::Region),
        A::Preset1d => Some(
            !model.document.slopes.is_auto()
                && model.document.params.method == Method::Buff
                && !model.document.params.slopes.is_plane()
                && model.document.params.slopes.len() > 1,
        ),
        A::Preset2d => Some(
            !model.document.slopes.is_auto()
                && model.document.params.method == Method::Buff
                && model.document.params.slopes.is_plane(),
        ),
        A::PresetSift => Some(model.document.params.method == Method::Sift),
        _ => match id.action().does? {
            Does::Workspace(workspace) => Some(model.document.workspace == workspace),
            Does::Show(kind) => Some(model.document.focused().shown() == Some(kind)),
            Does::Switch { is_on, .. } => Some(is_on(&model.document)),
            _ => None,
        },
    }
}
