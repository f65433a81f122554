//! Which actions can be done now, and which of the switches are on.

use super::registry::ActionId;
use crate::app::state::Model;
use crate::app::state::room::Room;
use crate::app::state::scrub::ViewKind;
use crate::detector::{DetectorParams, Method};
use crate::matching::MatchParams;

/// Whether the action can be done now.
pub fn enabled(id: ActionId, model: &Model) -> bool {
    use ActionId as A;
    let has_burst = model.burst.is_some();
    let in_pair = model.room == Room::Pair;
    let has_second = model.pair.b.burst.is_some();
    match id {
        A::NextFeature | A::PreviousFeature | A::StrongestFeature if in_pair => !model.pair.listed.is_empty(),
        A::GoToFeature | A::ClearSelection if in_pair => model.pair.selected.is_some(),
        A::OpenFolderB | A::OpenFilesB | A::OpenPathB | A::OpenDemoB => has_burst,
        A::CloseB | A::SwapSides => has_burst && has_second,
        A::OtherSide => in_pair && has_second,
        A::LinkHands | A::LinkViews | A::LinkRanges => in_pair,
        A::ToggleInliers | A::ToggleOutliers | A::ToggleAlone | A::ToggleEpipolar => in_pair,
        A::Match => in_pair && model.pair.busy.matching.is_none() && model.wanted_matches().is_some(),
        A::ResetMatching => model.pair.params != MatchParams::default(),
        A::SaveSession | A::ShowFrame | A::ShowStack | A::ShowDog | A::Fit | A::OneToOne | A::ZoomIn | A::ZoomOut => {
            has_burst
        }
        A::ExportCsv | A::ExportColmap | A::ExportNpz | A::BusiestSlope => model.found.is_some(),
        A::ExportTiff | A::ExportPng | A::ExportSvg => model.picture.is_some(),
        A::SlopeULess | A::SlopeUMore | A::SlopeVLess | A::SlopeVMore | A::SlopeZero | A::SnapSlope => has_burst,
        A::Play => has_burst && model.usable_params.slopes.len() > 1,
        A::FramePrevious | A::FrameNext => model.burst_of(model.active_side()).is_some_and(|open| open.burst.len() > 1),
        A::OctaveFiner | A::OctaveCoarser | A::LevelDown | A::LevelUp => has_burst,
        A::Detect => {
            has_burst
                && model.param_error.is_none()
                && model.busy.detecting.is_none()
                && model.pair.busy.detecting.is_none()
        }
        A::Cancel => {
            let (a, b) = (&model.busy, &model.pair.busy);
            [a.detecting, a.opening, b.detecting, b.opening, b.matching].iter().any(Option::is_some)
        }
        A::ResetParams => model.params != DetectorParams::default(),
        A::NextFeature | A::PreviousFeature | A::StrongestFeature => !model.listed.is_empty(),
        A::GoToFeature | A::ClearSelection => model.selected_feature().is_some(),
        A::ClearFilter => !model.filter.is_open(),
        _ => true,
    }
}

/// Whether a switch is on; `None` for what is not a switch.
pub fn checked(id: ActionId, model: &Model) -> Option<bool> {
    use ActionId as A;
    let kind = |kind: ViewKind| Some(model.hand().kind == kind);
    let (links, matches) = (&model.pair.links, &model.pair.look);
    match id {
        A::RoomBurst => Some(model.room == Room::Burst),
        A::RoomPair => Some(model.room == Room::Pair),
        A::ShowFrame => kind(ViewKind::Frame),
        A::ShowStack => kind(ViewKind::Stack),
        A::ShowDog => kind(ViewKind::Dog),
        A::LinkHands => Some(links.hands),
        A::LinkViews => Some(links.views),
        A::LinkRanges => Some(links.ranges),
        A::ToggleInliers => Some(matches.inliers),
        A::ToggleOutliers => Some(matches.outliers),
        A::ToggleAlone => Some(matches.alone),
        A::ToggleEpipolar => Some(matches.geometry),
        A::ToggleOverlay if model.room == Room::Pair => Some(matches.features),
        A::ToggleOverlay => Some(model.look.overlay),
        A::ToggleMotion => Some(model.look.motion_vectors),
        A::ToggleOrientation => Some(model.look.orientations),
        A::ToggleLegend => Some(model.look.legend),
        A::ToggleLeft => Some(model.panels.left),
        A::ToggleRight => Some(model.panels.right),
        A::ToggleBottom => Some(model.panels.bottom),
        A::ThemeSystem => Some(model.theme == egui::ThemePreference::System),
        A::ThemeLight => Some(model.theme == egui::ThemePreference::Light),
        A::ThemeDark => Some(model.theme == egui::ThemePreference::Dark),
        A::Play => Some(model.playing),
        A::AutoDetect => Some(model.auto_detect),
        A::Preset1d => Some(
            model.params.method == Method::Buff && !model.params.slopes.is_plane() && model.params.slopes.len() > 1,
        ),
        A::Preset2d => Some(model.params.method == Method::Buff && model.params.slopes.is_plane()),
        A::PresetSift => Some(model.params.method == Method::Sift),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::actions::ACTIONS;

    #[test]
    fn without_a_burst_one_can_still_open_configure_and_find_help() {
        let model = Model::default();
        let can: Vec<ActionId> = ACTIONS.iter().map(|a| a.id).filter(|id| enabled(*id, &model)).collect();
        for id in [ActionId::OpenFolder, ActionId::OpenDemo, ActionId::LoadParams, ActionId::Palette, ActionId::Quit] {
            assert!(can.contains(&id), "{id:?}");
        }
        for id in [ActionId::Detect, ActionId::ExportCsv, ActionId::Play, ActionId::NextFeature, ActionId::Cancel] {
            assert!(!can.contains(&id), "{id:?}");
        }
    }
}
