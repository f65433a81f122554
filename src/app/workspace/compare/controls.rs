//! Choice of the compared methods, and of their layout.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::inspector::Change;
use crate::app::pane::{MethodsPreset, Over};
use crate::app::panel::widgets::{progress_text, section_ui};
use crate::app::project::Model;
use crate::app::project::compare::Contender;
use crate::app::project::pair::Side;
use egui::{ProgressBar, Ui};

/// Draws the section. Returns the requested layout.
pub fn controls_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) -> Option<Change> {
    let mut change = None;
    section_ui(ui, "Compare", |ui| {
        change = layout_ui(ui, model);
        if let Some(over) = model.panes.over(model.focus()) {
            two_ui(ui, model, over, queue);
        }
        ui.checkbox(&mut model.compare.look.features, "Features")
            .on_hover_text("Draw the features of each method  (O)");
        gold_ui(ui, model, queue);
        if let Some((method, running)) = model.compare.running() {
            let fraction = running.progress.map_or(0.0, |p| p.fraction);
            let text = format!("{}: {}", method.label(), progress_text(&running));
            ui.add(ProgressBar::new(fraction).text(text));
            button_ui(ui, model, queue, ActionId::Cancel, None);
        } else if Contender::ALL.iter().any(|method| model.compare.problem(*method).is_some()) {
            button_ui(ui, model, queue, ActionId::CompareAgain, Some("Try again"));
        }
    });
    change
}

/// Draws the buttons that lay all panes out anew.
fn layout_ui(ui: &mut Ui, model: &Model) -> Option<Change> {
    let has_second = model.burst_of(Side::B).is_some();
    let mut change = None;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for preset in MethodsPreset::ALL {
            let enabled = preset != MethodsPreset::Matches || has_second;
            let response = ui
                .add_enabled(enabled, egui::Button::new(preset.label()))
                .on_hover_text(preset.help())
                .on_disabled_hover_text("Matches need a second burst: open one as B");
            if response.clicked() {
                change = Some(Change::LayOutMethods(preset));
            }
        }
    });
    change
}

/// Draws the choice of the two methods that lie over one another in the focused pane.
fn two_ui(ui: &mut Ui, model: &mut Model, over: Over, queue: &mut Queue) {
    let contenders = model.contenders();
    for (id, name) in [(model.focus(), "Left"), (over.other(), "Right")] {
        let Some(pane) = model.panes.get_mut(id) else { continue };
        let Some(mut chosen) = pane.method else { continue };
        ui.horizontal(|ui| {
            let label = crate::app::panel::widgets::label_ui(ui, name, 52.0);
            egui::ComboBox::from_id_salt(("method", name))
                .selected_text(chosen.label())
                .width(ui.available_width() - 8.0)
                .show_ui(ui, |ui| {
                    for method in &contenders {
                        ui.selectable_value(&mut chosen, *method, method.label()).on_hover_text(method.help());
                    }
                })
                .response
                .labelled_by(label.id);
        });
        pane.show_method(Some(chosen));
    }
    if matches!(over, Over::Flip { .. }) {
        button_ui(ui, model, queue, ActionId::Flip, None);
    }
}

fn gold_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    ui.horizontal(|ui| {
        ui.weak("Gold standard");
        for (side, id) in [(Side::A, ActionId::OpenGoldA), (Side::B, ActionId::OpenGoldB)] {
            let is_there = model.compare.gold[side as usize].is_some();
            let mark = if is_there { " ✔" } else { "…" };
            button_ui(ui, model, queue, id, Some(&format!("{}{mark}", side.name())));
        }
    });
}
