//! Which methods are compared, and how they are laid beside one another.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::panel::widgets::{progress_text, section_ui};
use crate::app::project::Model;
use crate::app::project::compare::{Contender, Layout};
use crate::app::project::pair::Side;
use egui::{ProgressBar, Ui};

/// Draws the section.
pub fn controls_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    section_ui(ui, "Compare", |ui| {
        layout_ui(ui, model);
        match model.compare.look.layout {
            Layout::Wipe | Layout::Flip => two_ui(ui, model, queue),
            Layout::Panes | Layout::Matches => {}
        }
        ui.checkbox(&mut model.compare.look.features, "Features").on_hover_text("Draw what each method found  (O)");
        gold_ui(ui, model, queue);
        if let Some(busy) = model.compare.busy {
            let fraction = busy.running.progress.map_or(0.0, |p| p.fraction);
            let text = format!("{}: {}", busy.method.label(), progress_text(&busy.running));
            ui.add(ProgressBar::new(fraction).text(text));
            button_ui(ui, model, queue, ActionId::Cancel, None);
        } else if Contender::ALL.iter().any(|method| model.compare.problem(*method).is_some()) {
            button_ui(ui, model, queue, ActionId::CompareAgain, Some("Try again"));
        }
    });
}

fn layout_ui(ui: &mut Ui, model: &mut Model) {
    let has_second = model.burst_of(Side::B).is_some();
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for layout in Layout::ALL {
            let on = model.compare.look.layout == layout;
            let enabled = layout != Layout::Matches || has_second;
            let button = egui::Button::selectable(on, layout.label()).frame_when_inactive(true);
            let response = ui
                .add_enabled(enabled, button)
                .on_hover_text(format!("{}  (W: the next one)", layout.help()))
                .on_disabled_hover_text("Matches need a second burst: open one as B");
            if response.clicked() {
                model.compare.look.layout = layout;
            }
        }
    });
}

fn two_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    let contenders = model.contenders();
    for (place, name) in ["Left", "Right"].into_iter().enumerate() {
        ui.horizontal(|ui| {
            let label = crate::app::panel::widgets::label_ui(ui, name, 52.0);
            let chosen = &mut model.compare.look.two[place];
            egui::ComboBox::from_id_salt(("method", place))
                .selected_text(chosen.label())
                .width(ui.available_width() - 8.0)
                .show_ui(ui, |ui| {
                    for method in &contenders {
                        ui.selectable_value(chosen, *method, method.label()).on_hover_text(method.help());
                    }
                })
                .response
                .labelled_by(label.id);
        });
    }
    if model.compare.look.layout == Layout::Flip {
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
