//! Actions that change the project: its values, and what it asks of the engine.

use super::ActionId;
use super::registry::Does;
use crate::app::canvas::overlay::ColourBy;
use crate::app::document::comparison::Reference;
use crate::app::document::export::Purpose;
use crate::app::document::method::plane_of;
use crate::app::document::panes::Change;
use crate::app::document::panes::Visibility;
use crate::app::document::side::Side;
use crate::app::inspector::PaneWidgets;
use crate::app::measure::Tool;
use crate::app::pane::Pane;
use crate::app::results::{Effect, Model};
use crate::detector::{Method, SlopeChoice, SlopeGrid};
use crate::engine::Engine;
use crate::requests::{BurstSource, ViewKind};
use crate::teach::{BottomTab, Workspace};

pub(super) fn change(id: ActionId, model: &mut Model, engine: &Engine) -> Option<Effect> {
    let focus = model.document.focus();
    match id.action().does {
        Some(Does::Ask(purpose)) => return Some(Effect::Ask(purpose)),
        Some(Does::Open(source)) => _ = model.open(Side::A, source(), engine),
        Some(Does::LayOut(preset)) => model.change_panes(Change::LayOut(focus, preset)),
        Some(Does::Workspace(workspace)) => model.document.open_workspace(workspace),
        Some(Does::Switch { turn: set, .. } | Does::Set(set)) => set(&mut model.document),
        Some(Does::Slope(of)) => {
            let slope = of(&model.cursor_params().slopes, model.document.cursor().slope);
            model.document.playing = false;
            model.document.show_slope(focus, slope);
        }
        Some(Does::Frame(go)) => model.document.lead(focus, |pane| {
            go(&mut pane.cursor);
            pane.show(ViewKind::Frame);
        }),
        Some(Does::Scale(go)) => model.document.lead(focus, |pane| {
            go(&mut pane.cursor);
            pane.show_scale();
        }),
        Some(Does::Show(kind)) => model.document.lead(focus, |pane| pane.show(kind)),
        Some(Does::Run(run)) => run(model, engine),
        None => return change_by_hand(id, model, engine),
    }
    None
}

/// Changes that depend on what is open, or that take several steps.
fn change_by_hand(id: ActionId, model: &mut Model, engine: &Engine) -> Option<Effect> {
    use ActionId as A;
    match id {
        A::OpenFeatures => return Some(Effect::Ask(Purpose::OpenFeatures(model.active_side()))),
        A::CloseDataset => return Some(model.close_dataset()),
        A::CutSequence => return model.cut_of_open_burst(),
        A::DetectAll => return model.ask_and_detect_all(engine),
        A::Detect => {
            model.start_detection(Side::A, engine);
            if model.document.workspace == Workspace::Pair {
                model.start_detection(Side::B, engine);
            }
        }
        A::Match => {
            if let Some(wanted) = model.wanted_matches() {
                model.results.pair.matching.ask(engine, wanted);
            }
        }
        A::OpenChart => {
            if let Some(chart) = model.selected_chart().and_then(|chart| chart.params()) {
                model.document.workspace = Workspace::Inspect;
                model.open(Side::A, BurstSource::Chart(Box::new(chart)), engine);
            }
        }
        A::OpenDarkCopy => {
            if let Some(burst) = &model.results.slots.a.burst {
                let of = Box::new(burst.source.clone());
                model.open(Side::A, BurstSource::DarkCopy { of, noise: model.document.lab.dark_copy }, engine);
            }
        }
        A::GoToFeature if model.document.workspace == Workspace::Pair => {
            model.go_to_match();
        }
        A::GoToFeature => model.go_to_selected(),
        A::ProbeFeature => {
            if let Some((side, index)) = model.feature_to_probe() {
                model.probe_feature(side, index);
            }
        }
        A::PinResult => {
            model.pin_result(model.active_side());
            model.document.bottom_tab = BottomTab::Compared;
            model.messages.note("Pinned: later detections are compared with these features");
        }
        A::ShowTruth => {
            let side = model.active_side();
            let on = model.document.comparisons[side].with == Some(Reference::Truth);
            model.show_comparison(side, (!on).then_some(Reference::Truth));
            model.document.bottom_tab = BottomTab::Compared;
        }
        A::ToggleLeft if model.shows_left() => model.document.panels.left = Visibility::Closed,
        A::ToggleLeft => model.open_left(),
        A::ToggleRight => model.document.panels.right = Visibility::from(!model.shows_right()),
        A::ToggleBottom => model.document.panels.bottom = Visibility::from(!model.shows_bottom()),
        A::NextFeature if model.document.workspace == Workspace::Pair => model.select_neighbouring_match(true),
        A::PreviousFeature if model.document.workspace == Workspace::Pair => model.select_neighbouring_match(false),
        A::StrongestFeature if model.document.workspace == Workspace::Pair => {
            model.document.selected_match = model.results.pair.listed.first().copied();
        }
        A::NextFeature => model.select_neighbour(true),
        A::PreviousFeature => model.select_neighbour(false),
        A::StrongestFeature => model.document.selected = model.results.listed.first().copied(),
        A::ProbeExpected => {
            if let Some(place) = model.expected_place() {
                model.probe_place(Side::B, place);
            }
        }
        A::BusiestSlope => {
            let focus = model.document.focus();
            model.document.playing = false;
            model.go_to_busiest_slope(focus);
            model.document.lead(focus, Pane::show_slope);
        }
        A::ClearSelection if model.document.measure.tool != Tool::Pan => {
            let tool = model.document.measure.tool;
            model.document.measure.toggle(tool);
        }
        A::ToggleOverlay if model.document.workspace == Workspace::Methods => model.document.methods.features ^= true,
        A::ToggleOverlay if model.document.workspace == Workspace::Pair => model.document.match_look.features ^= true,
        A::ToggleOverlay => model.document.look.overlay = model.document.look.overlay.next(),
        A::NextColouring => {
            let choices = || ColourBy::choices(model.document.set_up.reads_depths);
            let next = choices().skip_while(|by| *by != model.document.colour_by).nth(1);
            model.document.colour_by = next.unwrap_or_default();
        }
        A::Preset1d => {
            (model.document.params.method, model.document.slopes) = (Method::Buff, SlopeChoice::Given);
            model.document.params.slopes = SlopeGrid::line(-3.0..=3.0, 7);
        }
        A::Preset2d => {
            (model.document.params.method, model.document.slopes) = (Method::Buff, SlopeChoice::Given);
            model.document.params.slopes = plane_of(model.document.params.slopes);
        }
        A::ClearSelection if model.document.workspace == Workspace::Pair => {
            (model.document.selected_match, model.document.asked_about) = (None, None);
        }
        A::ClearSelection => (model.document.selected, model.document.comparisons.a.selected) = (None, None),
        _ => {}
    }
    None
}

/// The place under the pointer, or else the middle of what is seen of the picture in focus; with its side.
pub fn place_to_probe(model: &Model, widgets: &PaneWidgets) -> Option<(Side, [f32; 2])> {
    let middle = || {
        let visible = widgets.get(model.document.focus())?.picture.visible_image?.center();
        let (width, height) = model.focused_size();
        let within = |x: f32, n: usize| x.clamp(0.0, n.saturating_sub(1) as f32);
        Some((model.document.focused().side, [within(visible.x, width), within(visible.y, height)]))
    };
    model.results.probed.pointer.or_else(middle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::actions::apply;
    use crate::app::results::tests::Bench;

    #[test]
    fn a_plane_keeps_the_slopes_that_were_found_and_one_step_back_returns_to_them() {
        let Bench { mut model, engine } = Bench::new();
        (model.document.slopes, model.document.params.slopes) = (SlopeChoice::AUTO, SlopeGrid::line(-6.0..=-3.0, 4));
        let found = (model.document.params.clone(), model.document.slopes);
        assert!(apply(ActionId::Preset2d.into(), &mut model, &engine).is_empty());
        model.close_step(false);
        assert_eq!(model.document.params.slopes, SlopeGrid::plane(-6.0..=-3.0, 4, -2.0..=2.0, 5));
        assert!(!model.document.slopes.is_auto());
        model.undo(&engine);
        assert!((model.document.params.clone(), model.document.slopes) == found && !model.history.can_undo());
        model.redo(&engine);
        assert!(model.document.params.slopes.is_plane() && !model.document.slopes.is_auto());
    }
}
