//! The rooms of the window: each lays out its panels between the toolbar above and the status bar below.

pub mod burst;
pub mod compare;
pub mod matches;
pub mod pair;
pub mod trajectories;

use super::actions::{ActionId, Queue, button_ui};
use super::state::Model;
use super::state::room::Room;
use super::window::BurstscopeApp;

/// The actions that lead to the rooms, in the order of the switch.
const DOORS: [ActionId; 5] =
    [ActionId::RoomBurst, ActionId::RoomPair, ActionId::RoomMethods, ActionId::RoomMatches, ActionId::RoomTrajectories];

/// Draws the switch between the rooms, from the right end of a line.
pub fn switch_ui(ui: &mut egui::Ui, model: &Model, queue: &mut Queue) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for door in DOORS.into_iter().rev() {
            button_ui(ui, model, queue, door, None);
        }
    });
}

/// Draws the room that is open.
pub fn room_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui, queue: &mut Queue) {
    match app.model.room {
        Room::Burst => burst::burst_room_ui(app, ui, queue),
        Room::Pair => pair::pair_room_ui(app, ui, queue),
        Room::Methods => compare::compare_room_ui(app, ui, queue),
        Room::Matches => matches::matches_room_ui(app, ui, queue),
        Room::Trajectories => trajectories::trajectories_room_ui(app, ui, queue),
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
