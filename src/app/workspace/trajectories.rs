//! Two trajectories: the plane in the middle, the points and errors of each image below it, files and errors right.

use crate::app::actions::Queue;
use crate::app::dataset::{camera_list, errors_panel, plane_view, points_strip};
use crate::app::window::BurstscopeApp;
use crate::app::workspace::{bottom_frame, side_frame, side_width};
use egui::{CentralPanel, Frame, Panel, ScrollArea, Ui, vec2};

/// Height of the strip of points, in points of the window.
const STRIP_HEIGHT: f32 = 84.0;

/// Draws the workspace.
pub fn trajectories_workspace_ui(app: &mut BurstscopeApp, ui: &mut Ui, queue: &mut Queue) {
    let width = side_width(ui).max(330.0);
    let mut again = false;
    if app.model.panels.right {
        Panel::right("trajectories right").frame(side_frame(ui)).default_size(width).size_range(280.0..=520.0).show(
            ui,
            |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    again = errors_panel::errors_panel_ui(ui, &mut app.model, queue);
                });
            },
        );
    }
    if again {
        app.compare_again();
    }
    if app.model.panels.bottom {
        Panel::bottom("trajectories bottom")
            .frame(bottom_frame(ui))
            .resizable(true)
            .default_size(240.0)
            .size_range(120.0..=520.0)
            .show(ui, |ui| {
                ui.allocate_ui(vec2(ui.available_width(), STRIP_HEIGHT), |ui| {
                    points_strip::points_strip_ui(ui, &mut app.model.trajectories);
                });
                ui.separator();
                camera_list::camera_list_ui(ui, &mut app.model.trajectories);
            });
    }
    CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
        plane_view::plane_ui(ui, &mut app.model.trajectories);
    });
    if let Some(label) = app.model.trajectories.wanted.take() {
        app.look_at_camera(&label);
    }
}
