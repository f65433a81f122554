//! Slopes from the set-up: speed, turning, frame rate, lens and depths give the slopes to search, and slopes read as
//! depths.

use crate::app::project::Model;
use crate::app::project::filter::depth_text;
use crate::app::project::side::Side;
use crate::app::view::signed_slope;
use crate::detector::{Slope, SlopeChoice};
use crate::inspect::set_up::SetUp;
use egui::{Button, CollapsingHeader, DragValue, Grid, Label, RichText, Ui};

/// Slopes of the nearest and the farthest things, while the set-up is in use: unfolded, or read for depths.
pub(super) fn expected(model: &Model) -> Option<[Slope; 2]> {
    let state = &model.set_up;
    let in_use = (state.is_open || state.reads_depths) && state.values.check().is_ok();
    in_use.then(|| state.values.depth_m.map(|metres| state.values.slope_at(metres)))
}

/// Draws a field: its name, help and widget.
fn field_ui(ui: &mut Ui, name: &str, help: &str, widget: DragValue<'_>) {
    let label = ui.label(name).on_hover_text(help);
    ui.add(widget).on_hover_text(help).labelled_by(label.id);
}

/// Draws the fields, the slopes that follow with the button that applies them, and the switch of depths.
pub(super) fn set_up_ui(ui: &mut Ui, model: &mut Model) {
    let header = CollapsingHeader::new("Slopes from the set-up").id_salt("slopes from the set-up");
    let unfolded = header.open(Some(model.set_up.is_open)).show(ui, |ui| {
        fields_ui(ui, &mut model.set_up.values);
        slopes_ui(ui, model);
        depths_ui(ui, model);
    });
    if unfolded.header_response.clicked() {
        model.set_up.is_open ^= true;
    }
}

/// Draws the fields of camera and scene.
fn fields_ui(ui: &mut Ui, values: &mut SetUp) {
    let SetUp { speed_m_s, direction_deg, turn_deg_s, frames_per_second, focal_px, depth_m } = values;
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
}

/// Draws the slopes that follow from the set-up.
fn slopes_ui(ui: &mut Ui, model: &mut Model) {
    let set_up = model.set_up.values;
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
}

/// Draws the switch of depths, and what the slope on show means.
fn depths_ui(ui: &mut Ui, model: &mut Model) {
    let mut reads = model.set_up.reads_depths;
    let tip =
        "Give every feature the depth that its slope means: in the table, in the tips over the picture, and as colours";
    if ui.checkbox(&mut reads, "Read slopes as depths").on_hover_text(tip).changed() {
        model.read_depths(reads);
    }
    let here = model.cursor().slope;
    let depth = model.set_up.values.depth_at(here);
    let means = if depth.is_some() { format!("{} m", depth_text(depth)) } else { "no depth".to_owned() };
    ui.weak(format!("The slope on show, ({}), means {means}", signed_slope(here, 2)));
}
