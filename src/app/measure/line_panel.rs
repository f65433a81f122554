//! Panel of the values along the line, as curves.

use super::profiles_of;
use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::canvas::number;
use crate::app::inspector::PaneWidgets;
use crate::app::project::Model;
use egui::{Color32, Ui};
use egui_plot::{Corner, Legend, Line, Plot, PlotPoints};

/// Colours of the panes' curves, in the panes' order: the palette of M. Okabe and K. Ito, which colour-blind readers
/// can tell apart.
const CURVES: [Color32; 8] = [
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(230, 159, 0),
    Color32::from_rgb(0, 158, 115),
    Color32::from_rgb(204, 121, 167),
    Color32::from_rgb(240, 228, 66),
    Color32::from_rgb(213, 94, 0),
    Color32::from_rgb(0, 114, 178),
    Color32::from_rgb(150, 150, 150),
];

/// Draws the panel.
pub fn profile_ui(ui: &mut Ui, model: &Model, widgets: &PaneWidgets, queue: &mut Queue) {
    let Some(line) = model.measure.line else {
        ui.horizontal(|ui| {
            ui.weak("Drag a line on a picture to see the values along it.");
            button_ui(ui, model, queue, ActionId::MeasureLine, Some("Draw a line"));
        });
        return;
    };
    let profiles = profiles_of(model, widgets, &line);
    let (from, to) = (line.from_image, line.to_image);
    ui.horizontal(|ui| {
        button_ui(ui, model, queue, ActionId::MeasureLine, Some("Draw a line"));
        button_ui(ui, model, queue, ActionId::ExportProfile, Some("Export as CSV…"));
        button_ui(ui, model, queue, ActionId::ClearMeasure, Some("Clear line"));
        ui.weak(format!("({:.1}, {:.1}) to ({:.1}, {:.1}), {:.1} px", from.x, from.y, to.x, to.y, from.distance(to)));
    });
    let plot = Plot::new("profile")
        .legend(Legend::default().position(Corner::RightTop))
        .allow_scroll(false)
        .allow_zoom(false)
        .allow_drag(false)
        .x_axis_label("Distance along the line, px")
        .y_axis_formatter(|mark, _| number(mark.value as f32, 3))
        .height(ui.available_height().max(60.0));
    let drawn = plot.show(ui, |plot| {
        for profile in &profiles {
            let points: PlotPoints<'_> = profile
                .samples
                .iter()
                .filter(|sample| sample.value.is_finite())
                .map(|sample| [f64::from(sample.distance_px), f64::from(sample.value)])
                .collect();
            let name = format!("{}  {}", profile.number, profile.label);
            let colour = CURVES[(profile.number - 1) % CURVES.len()];
            plot.line(Line::new(name, points).color(colour).width(1.5));
        }
    });
    let text = format!("Profile of {} pictures", profiles.len());
    drawn.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
}
