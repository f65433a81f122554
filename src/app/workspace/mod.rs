//! The workspaces of the window: each lays out its panels between the toolbar above and the status bar below.

pub mod compare;
pub mod inspect;
pub mod matches;
pub mod pair;
pub mod trajectories;

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::project::Model;
use crate::app::project::workspace::Workspace;
use crate::app::window::BurstscopeApp;

/// The actions that lead to the workspaces, in the order of the switch.
const SWITCHES: [ActionId; 5] = [
    ActionId::WorkspaceInspect,
    ActionId::WorkspacePair,
    ActionId::WorkspaceMethods,
    ActionId::WorkspaceMatches,
    ActionId::WorkspaceTrajectories,
];

/// Draws the switch between the workspaces, from the right end of a line.
pub fn switch_ui(ui: &mut egui::Ui, model: &Model, queue: &mut Queue) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for action in SWITCHES.into_iter().rev() {
            button_ui(ui, model, queue, action, None);
        }
    });
}

/// Draws the workspace that is open.
pub fn workspace_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui, queue: &mut Queue) {
    match app.model.workspace {
        Workspace::Inspect => inspect::inspect_workspace_ui(app, ui, queue),
        Workspace::Pair => pair::pair_workspace_ui(app, ui, queue),
        Workspace::Methods => compare::compare_workspace_ui(app, ui, queue),
        Workspace::Matches => matches::matches_workspace_ui(app, ui, queue),
        Workspace::Trajectories => trajectories::trajectories_workspace_ui(app, ui, queue),
    }
}

/// The frame of a panel at the side of the window.
fn side_frame(ui: &egui::Ui) -> egui::Frame {
    egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin { left: 8, right: 5, top: 6, bottom: 4 })
}

/// The frame of a panel at the bottom of the window.
fn bottom_frame(ui: &egui::Ui) -> egui::Frame {
    egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin::symmetric(8, 4))
}

/// Width of a panel at the side, in points: on a small screen the picture needs the room more than the panels do.
fn side_width(ui: &egui::Ui) -> f32 {
    (0.235 * ui.available_width()).clamp(256.0, 300.0)
}
