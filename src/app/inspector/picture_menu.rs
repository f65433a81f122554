//! Menu that the secondary button opens on a picture: items for the feature or match and the place there, and for the
//! pane.

use super::menu::{Change, pane_menu_ui};
use super::menu_place::MenuPlace;
use super::pane_ui::Drawn;
use super::probe_marks::mid_burst;
use super::widgets::PaneWidgets;
use crate::app::actions::{ActionId, Queue};
use crate::app::canvas::number;
use crate::app::clipboard;
use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::pair::{MatchRow, Side};
use crate::app::project::workspace::Workspace;
use egui::{RichText, Ui};

/// Shows the menu where the secondary button was pressed on the picture of pane `id`.
pub(super) fn picture_menu_ui(
    drawn: &Drawn,
    model: &mut Model,
    id: PaneId,
    widgets: &mut PaneWidgets,
    changes: &mut Vec<Change>,
    queue: &mut Queue,
) {
    let response = &drawn.output.response;
    if response.secondary_clicked() {
        let readout = widgets.get(drawn.shown).and_then(|widget| widget.picture.readout);
        let mid_burst = drawn.output.hover_image.and_then(|pos| mid_burst(model, drawn.shown, pos));
        let inspected = model.workspace == Workspace::Inspect;
        let can_probe = inspected || model.workspace == Workspace::Pair;
        widgets.of(id).menu = MenuPlace {
            feature: model.hovered.filter(|_| inspected),
            matched: model.pair.hovered.filter(|_| model.workspace == Workspace::Pair),
            readout,
            mid_burst: mid_burst.filter(|_| can_probe),
        };
    }
    let place = widgets.get(id).map(|widget| widget.menu).unwrap_or_default();
    response.context_menu(|ui| {
        ui.set_min_width(190.0);
        if let Some(index) = place.feature {
            feature_menu_ui(ui, model, index, queue);
            ui.separator();
        }
        if let Some(matches) = model.pair.matches.clone()
            && let Some(row) = place.matched.and_then(|index| matches.row(index))
        {
            if match_menu_ui(ui, &row) {
                model.pair.selected = Some(row.index);
                queue.push(ActionId::GoToFeature);
            }
            ui.separator();
        }
        if let Some((side, place)) = place.mid_burst {
            let button = ui.button("Probe this place").on_hover_text(ActionId::ProbePlace.action().help);
            if button.clicked() {
                model.probe_place(side, place);
            }
        }
        if let Some(readout) = &place.readout {
            let value = format!("Copy value {}", number(readout.value, 4));
            copy_ui(ui, &value, || clipboard::value_text(readout));
            let at = format!("Copy place ({})", clipboard::place_text(readout));
            copy_ui(ui, &at, || clipboard::place_text(readout));
        }
        if ui.button("Copy picture").on_hover_text("As it is shown, in its range and colours").clicked()
            && let Some(image) = clipboard::picture_of(model, drawn.shown)
        {
            ui.ctx().copy_image(image);
            model.messages.note("Copied the picture");
        }
        ui.separator();
        pane_menu_ui(ui, model, id, changes, queue);
    });
}

/// Draws the items for one of A's features.
fn feature_menu_ui(ui: &mut Ui, model: &mut Model, index: usize, queue: &mut Queue) {
    let Some(feature) = model.features().get(index).copied() else { return };
    ui.label(RichText::new(format!("Feature {}", index + 1)).small().weak());
    if ui.button("Select").clicked() {
        model.selected = Some(index);
    }
    if ui.button("Go to feature").on_hover_text("Show the motion stack at its slope, with it in the middle").clicked() {
        model.selected = Some(index);
        queue.push(ActionId::GoToFeature);
    }
    if ui.button("Why this feature?").on_hover_text(ActionId::ProbeFeature.action().help).clicked() {
        model.probe_feature(Side::A, index);
    }
    copy_ui(ui, "Copy row", || clipboard::feature_text(&feature));
}

/// Draws an item that copies a text.
pub(in crate::app) fn copy_ui(ui: &mut Ui, label: &str, text: impl FnOnce() -> String) {
    if ui.button(label).clicked() {
        ui.ctx().copy_text(text());
    }
}

/// Draws the items for one match; returns whether to go to it.
pub(in crate::app) fn match_menu_ui(ui: &mut Ui, row: &MatchRow<'_>) -> bool {
    ui.set_min_width(150.0);
    ui.label(RichText::new(format!("Match {}", row.index + 1)).small().weak());
    let go = ui
        .button("Go to match")
        .on_hover_text("Show both features, each in the motion stack at its own slope")
        .clicked();
    copy_ui(ui, "Copy row", || clipboard::match_text(row));
    go
}
