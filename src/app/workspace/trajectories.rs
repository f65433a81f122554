//! Two trajectories: the plane in the centre, the points and errors of each image below it, files and errors on the
//! right.

use crate::app::actions::Queue;
use crate::app::dataset::{cameras, errors_panel};
use crate::app::project::Model;
use crate::app::workspace::{WorkspaceWishes, bottom_panel, side_frame, side_width};
use egui::{CentralPanel, Frame, Panel, ScrollArea, Ui, vec2};

/// Height of the strip of points, in points of the window.
const STRIP_HEIGHT: f32 = 84.0;

/// Draws the workspace. Returns its requests.
pub(super) fn trajectories_workspace_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) -> WorkspaceWishes {
    let width = side_width(ui).max(330.0);
    let mut again = false;
    if model.panels.right {
        Panel::right("trajectories right").frame(side_frame(ui)).default_size(width).size_range(280.0..=520.0).show(
            ui,
            |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    again = errors_panel::errors_panel_ui(ui, model, queue);
                });
            },
        );
    }
    if model.panels.bottom {
        bottom_panel(ui, "trajectories bottom", 331.0, |ui| {
            ui.allocate_ui(vec2(ui.available_width(), STRIP_HEIGHT), |ui| {
                cameras::points_strip_ui(ui, &mut model.trajectories);
            });
            ui.separator();
            cameras::camera_list_ui(ui, &mut model.trajectories);
        });
    }
    CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
        cameras::plane_ui(ui, &mut model.trajectories);
    });
    let camera = model.trajectories.wanted.take();
    WorkspaceWishes { compare_again: again, camera, ..WorkspaceWishes::default() }
}
