//! Slopes from the set-up: speed, turning, frame rate, lens and depths give the slopes to search, and slopes read as
//! depths.

use crate::app::project::Model;
use crate::app::project::side::Side;
use crate::detector::SlopeChoice;
use crate::inspect::set_up::SetUp;
use crate::inspect::words::number;
use egui::{Button, CollapsingHeader, DragValue, Grid, Label, RichText, Ui};

/// Draws a field: its name, help and widget.
fn field_ui(ui: &mut Ui, name: &str, help: &str, widget: DragValue<'_>) {
    let label = ui.label(name).on_hover_text(help);
    ui.add(widget).on_hover_text(help).labelled_by(label.id);
}

/// Draws the fields, the slopes that follow, and the button that applies them.
pub(super) fn set_up_ui(ui: &mut Ui, model: &mut Model) {
    CollapsingHeader::new("Slopes from the set-up").id_salt("slopes from the set-up").show(ui, |ui| {
        let SetUp { speed_m_s, direction_deg, turn_deg_s, frames_per_second, focal_px, depth_m } = &mut model.set_up;
        Grid::new("set-up").num_columns(4).show(ui, |ui| {
            let speed = DragValue::new(speed_m_s).range(0.0..=1000.0).speed(0.01).suffix(" m/s");
            field_ui(ui, "Speed", "Speed of the camera parallel to its picture", speed);
            let direction = DragValue::new(direction_deg).range(-180.0..=180.0).suffix("°");
            field_ui(ui, "Direction of motion", "Direction of that motion, from right towards down", direction);
            ui.end_row();
            let rate = DragValue::new(frames_per_second).range(0.01..=100_000.0).suffix(" /s");
            field_ui(ui, "Frame rate", "Frames per second", rate);
            let turn = DragValue::new(turn_deg_s).range(-1000.0..=1000.0).speed(0.05).suffix("°/s");
            field_ui(ui, "Turning", "Turning of the camera to the right", turn);
            ui.end_row();
            let focal = DragValue::new(focal_px).range(1.0..=1e6).suffix(" px");
            field_ui(ui, "Focal length", "Focal length in pixels", focal);
            let near = DragValue::new(&mut depth_m[0]).range(0.01..=1e6).speed(0.02).suffix(" m");
            field_ui(ui, "Nearest", "Depth of the nearest things", near);
            ui.end_row();
            let far = DragValue::new(&mut depth_m[1]).range(0.01..=1e6).speed(0.05).suffix(" m");
            field_ui(ui, "Farthest", "Depth of the farthest things", far);
            ui.end_row();
        });
        let (set_up, here) = (model.set_up, model.cursor().slope);
        let frames = model.slots.a.burst.as_ref().map_or(10, |open| open.burst.len());
        match set_up.slopes(model.params.used_frames(frames).len(), &model.params) {
            Ok(slopes) => {
                ui.add(Label::new(slopes.sentence(&set_up)).wrap());
                let apply = ui.add_enabled(model.takes_advice(Side::A), Button::new("Apply"));
                apply.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "Apply set-up"));
                if apply.on_hover_text("Search these slopes; Ctrl+Z undoes it").clicked() {
                    (model.params.slopes, model.slopes) = (slopes.grid, SlopeChoice::Given);
                    model.messages.note(format!("Set {}", slopes.options()));
                }
            }
            Err(problem) => {
                ui.add(Label::new(RichText::new(problem).color(ui.visuals().error_fg_color)).wrap());
            }
        }
        let depth =
            set_up.depth_at(here).map_or_else(|| "no depth".to_owned(), |z| format!("{} m", number(z as f32, 2)));
        ui.weak(format!("The slope on show means {depth}"));
    });
}
