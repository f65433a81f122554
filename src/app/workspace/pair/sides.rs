//! Choice of the burst whose cursor moves, and of the links.

use crate::app::actions::{ActionId, Queue, button_ui, menu::item_ui};
use crate::app::panel::widgets::{label_ui, section_ui};
use crate::app::project::Model;
use crate::app::project::pair::Side;
use egui::Ui;

/// Draws the section.
pub fn sides_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    section_ui(ui, "A and B", |ui| {
        let both = model.burst_of(Side::B).is_some();
        ui.add_enabled_ui(both, |ui| {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                label_ui(ui, "Cursor of", 60.0)
                    .on_hover_text("Burst whose frame, slope, octave and level the sliders and keys move");
                let active = model.active_side();
                for side in Side::BOTH {
                    let tip = format!("Move the frame, slope, octave and level of {}  (T)", side.name());
                    let button = egui::Button::selectable(active == side, side.name()).frame_when_inactive(true);
                    let response = ui.add(button).on_hover_text(tip);
                    let name = format!("Cursor of {}", side.name());
                    response
                        .widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, both, active == side, &name));
                    if response.clicked() && active != side {
                        model.focus_other_side();
                    }
                }
                button_ui(ui, model, queue, ActionId::SwapSides, Some("Swap"));
            });
        });
        open_menu_ui(ui, model, queue);
        let links = [
            (ActionId::LinkCursors, "Slope and scale together"),
            (ActionId::LinkViews, "Zoom and pan together"),
            (ActionId::LinkRanges, "One value range"),
        ];
        for (id, label) in links {
            let mut on = crate::app::actions::checked(id, model).unwrap_or(false);
            let tip = crate::app::actions::tooltip(ui.ctx(), id.action());
            if ui.checkbox(&mut on, label).on_hover_text(tip).clicked() {
                queue.push(id);
            }
        }
        if let Some(error) = model.slots.b.param_error.as_ref().filter(|_| model.slots.a.param_error.is_none()) {
            let text = format!("The parameters do not fit B: {error}");
            let text = egui::RichText::new(text).small().color(ui.visuals().error_fg_color);
            ui.add(egui::Label::new(text).wrap());
        }
    });
}

/// Draws the menu that opens another second burst.
fn open_menu_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    ui.menu_button("Open B…", |ui| {
        ui.set_min_width(180.0);
        for id in [ActionId::OpenFolderB, ActionId::OpenFilesB, ActionId::OpenPathB, ActionId::OpenDemoB] {
            item_ui(ui, model, queue, id);
        }
        ui.separator();
        item_ui(ui, model, queue, ActionId::CloseB);
    });
}
