//! Slopes from the set-up (speed, turning, frame rate, lens and depths), and slopes read as depths.

use crate::app::document::{Action, Queue, Side};
use crate::app::panel::widgets::error_ui;
use crate::app::results::Read;
use crate::app::view::{number, signed_slope};
use crate::detector::Slope;
use crate::inspect::slopes::{SetUp, set_up_bounds};
use egui::{Button, CollapsingHeader, DragValue, Grid, Label, Role, Ui, WidgetInfo};

/// Slopes of the nearest and the farthest things, while the set-up is in use: unfolded, or read for depths.
pub(super) fn expected(model: Read<'_>) -> Option<[Slope; 2]> {
    let state = &model.document.set_up;
    let in_use = (state.is_open || state.reads_depths) && state.values.check().is_ok();
    in_use.then(|| state.values.depth_m.map(|metres| state.values.slope_at(metres)))
}

pub(super) fn set_up_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let mut state = model.document.set_up;
    let header = CollapsingHeader::new("Slopes from the set-up").id_salt("slopes from the set-up");
    let unfolded = header.open(Some(model.document.set_up.is_open)).show(ui, |ui| {
        fields_ui(ui, &mut state.values);
        slopes_ui(ui, model, queue);
    });
    if unfolded.header_response.clicked() {
        state.is_open ^= true;
    }
    queue.edit(model.document, Action::SetSetUp(state));
}

fn fields_ui(ui: &mut Ui, values: &mut SetUp) {
    let SetUp { speed_m_s, direction_deg, turn_deg_s, frames_per_second, focal_px, depth_m } = values;
    let [near, far] = depth_m;
    let field = |ui: &mut Ui, name: &str, help: &str, widget: DragValue<'_>| {
        let response = ui.add(widget).on_hover_text(help);
        response.widget_info(|| WidgetInfo::labeled(Role::SpinButton, true, name));
    };
    Grid::new("set-up").num_columns(3).show(ui, |ui| {
        ui.label("Motion");
        let speed = DragValue::new(speed_m_s).range(set_up_bounds::SPEED.span()).speed(0.01).suffix(" m/s");
        field(ui, "Speed", "Speed of the camera parallel to its picture", speed);
        let direction = DragValue::new(direction_deg).range(set_up_bounds::DIRECTION.span()).suffix("°");
        field(ui, "Direction of motion", "Direction of that motion, from right towards down", direction);
        ui.end_row();
        ui.label("Turning");
        let turn = DragValue::new(turn_deg_s).range(set_up_bounds::TURN.span()).speed(0.05).suffix("°/s");
        field(ui, "Turning", "Turning of the camera to the right", turn);
        ui.end_row();
        ui.label("Camera");
        let rate = DragValue::new(frames_per_second).range(set_up_bounds::RATE.span()).suffix(" /s");
        field(ui, "Frame rate", "Frames per second", rate);
        let focal = DragValue::new(focal_px).range(set_up_bounds::FOCAL.span()).suffix(" px");
        field(ui, "Focal length", "Focal length in pixels", focal);
        ui.end_row();
        ui.label("Depths");
        field(ui, "Nearest", "Depth of the nearest things", depth_field(near));
        field(ui, "Farthest", "Depth of the farthest things", depth_field(far));
        ui.end_row();
    });
}

fn depth_field(metres: &mut f64) -> DragValue<'_> {
    DragValue::new(metres).range(set_up_bounds::DEPTH.span()).speed(0.02).suffix(" m")
}

fn slopes_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let set_up = model.document.set_up.values;
    let slopes = set_up.slopes(&model.used_positions(), &model.params_of(Side::A));
    ui.horizontal(|ui| {
        let can_apply = slopes.is_ok() && model.takes_advice(Side::A);
        let apply = ui.add_enabled(can_apply, Button::new("Apply"));
        apply.widget_info(|| WidgetInfo::labeled(Role::Button, can_apply, "Apply set-up"));
        queue.push_if(apply.on_hover_text("Search these slopes; Ctrl+Z undoes it").clicked(), Action::ApplySetUp);
        let mut reads = model.document.set_up.reads_depths;
        let tip =
            "Give every feature the depth that its motion means, with its error: in the table, in the tips over the picture, and as colours";
        let response = ui.checkbox(&mut reads, "Read slopes as depths").on_hover_text(tip);
        queue.push_if(response.changed(), Action::ReadDepths(reads));
    });
    match slopes {
        Ok(slopes) => ui.add(Label::new(slopes.sentence(&set_up)).wrap()),
        Err(problem) => error_ui(ui, problem),
    };
    let here = model.document.cursor().slope;
    let depth = set_up.depth_at(here);
    let means = depth.map_or_else(|| "no depth".to_owned(), |metres| format!("{} m", number(metres as f32, 3)));
    ui.weak(format!("The slope on show, ({}), means {means}", signed_slope(here, 2)));
}
