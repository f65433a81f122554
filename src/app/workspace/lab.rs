//! Lab: settings of the study on the left, the curves in the centre, the chart behind a point on the right.

use crate::app::actions::Queue;
use crate::app::panel::lab::{chart, curves, settings};
use crate::app::panel::probe::PlaneTexture;
use crate::app::panel::widgets::section_ui;
use crate::app::project::Model;
use crate::app::workspace::{side_frame, side_width};
use egui::{CentralPanel, Panel, ScrollArea, Ui};

/// Draws the workspace.
pub(super) fn lab_workspace_ui(ui: &mut Ui, model: &mut Model, picture: &mut PlaneTexture, queue: &mut Queue) {
    let width = side_width(ui);
    if model.panels.left {
        Panel::left("lab left").frame(side_frame(ui)).default_size(width).size_range(250.0..=420.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                settings::lab_settings_ui(ui, model, queue);
            });
        });
    }
    if model.panels.right {
        Panel::right("lab right").frame(side_frame(ui)).default_size(width * 1.3).size_range(250.0..=900.0).show(
            ui,
            |ui| {
                section_ui(ui, "Chart", |ui| {
                    chart::lab_chart_ui(ui, model, picture, queue);
                });
            },
        );
    }
    CentralPanel::default().show(ui, |ui| curves::curves_ui(ui, &mut model.lab));
}
