//! Workspaces of the window: each lays out its panels between the toolbar above and the status bar below.

pub mod compare;
pub mod inspect;
pub mod lab;
pub mod matches;
pub mod pair;
pub mod trajectories;

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::inspector::{Change, PaneWidgets};
use crate::app::measure::RegionCache;
use crate::app::panel::probe::{PlaneTexture, ProbePanel};
use crate::app::panel::selection::SelectionState;
use crate::app::project::Model;
use crate::app::project::workspace::Workspace;
use pair::PairPanels;

/// State that a workspace reads and changes: the project, and the widgets' state kept between passes.
pub struct WorkspaceParts<'a> {
    /// Project.
    pub model: &'a mut Model,
    /// State of the panes' widgets.
    pub widgets: &'a mut PaneWidgets,
    /// State of the panels of *Two bursts*.
    pub pair: &'a mut PairPanels,
    /// State of the selected feature's panel.
    pub selection: &'a mut SelectionState,
    /// State of the probe's panel.
    pub probe: &'a mut ProbePanel,
    /// Statistics of the measured rectangle.
    pub regions: &'a mut RegionCache,
    /// Lab's chart as a texture.
    pub lab_picture: &'a mut PlaneTexture,
    /// Requested actions.
    pub queue: &'a mut Queue,
}

/// Requests that a workspace cannot fulfil itself.
#[derive(Debug, Default)]
pub struct WorkspaceWishes {
    /// Changes of the set of panes.
    pub changes: Vec<Change>,
    /// Trajectories are to be compared again.
    pub compare_again: bool,
    /// Camera whose image is to be opened.
    pub camera: Option<String>,
}

/// Actions that open the workspaces, in the order of the switch.
const SWITCHES: [ActionId; 6] = [
    ActionId::WorkspaceInspect,
    ActionId::WorkspacePair,
    ActionId::WorkspaceMethods,
    ActionId::WorkspaceMatches,
    ActionId::WorkspaceTrajectories,
    ActionId::WorkspaceLab,
];

/// Draws the switch between the workspaces, from the right end of a line.
pub fn switch_ui(ui: &mut egui::Ui, model: &Model, queue: &mut Queue) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        let first = ui.cursor().right();
        for action in SWITCHES.into_iter().rev() {
            button_ui(ui, model, queue, action, None);
        }
        let switch = ui.min_rect().intersect(egui::Rect::everything_left_of(first));
        crate::app::parts::mark(ui, crate::teach::Part::Workspaces, switch);
    });
}

/// Draws the open workspace.
pub fn workspace_ui(ui: &mut egui::Ui, parts: &mut WorkspaceParts<'_>) -> WorkspaceWishes {
    let changes = match parts.model.workspace {
        Workspace::Inspect => inspect::inspect_workspace_ui(ui, parts),
        Workspace::Pair => pair::pair_workspace_ui(ui, parts),
        Workspace::Methods => compare::compare_workspace_ui(ui, parts),
        Workspace::Matches => {
            let camera_text = &mut parts.pair.camera_text;
            matches::matches_workspace_ui(ui, parts.model, camera_text, parts.queue);
            Vec::new()
        }
        Workspace::Lab => {
            lab::lab_workspace_ui(ui, parts.model, parts.lab_picture, parts.queue);
            Vec::new()
        }
        Workspace::Trajectories => return trajectories::trajectories_workspace_ui(ui, parts.model, parts.queue),
    };
    WorkspaceWishes { changes, ..WorkspaceWishes::default() }
}

/// Range of the height of a panel below the pictures, in points.
const BOTTOM_HEIGHTS: std::ops::RangeInclusive<f32> = 90.0..=520.0;

/// Height left to the pictures at first, in points; the panel below them gets the rest.
const PICTURES_HEIGHT: f32 = 320.0;

/// Frame of a panel at the side of the window.
fn side_frame(ui: &egui::Ui) -> egui::Frame {
    egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin { left: 8, right: 5, top: 6, bottom: 4 })
}

/// Draws a panel below the pictures, `height` points high until it is dragged, or less in a small window. Its height
/// does not depend on its content, so that nothing moves under the pointer when features come or another tab is opened.
/// Returns whether the pointer is over it.
fn bottom_panel(ui: &mut egui::Ui, id: &'static str, height: f32, show: impl FnOnce(&mut egui::Ui)) -> bool {
    let frame = egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin::symmetric(8, 4));
    let height = height.min(ui.available_height() - PICTURES_HEIGHT).max(*BOTTOM_HEIGHTS.start());
    let panel = egui::Panel::bottom(id).frame(frame).resizable(true).default_size(height).size_range(BOTTOM_HEIGHTS);
    let shown = panel.show(ui, |ui| {
        ui.take_available_height();
        show(ui);
    });
    ui.rect_contains_pointer(shown.response.rect)
}

/// Width of a panel at the side, in points; smaller in a small window, where the picture needs the space more.
fn side_width(ui: &egui::Ui) -> f32 {
    (0.235 * ui.available_width()).clamp(256.0, 300.0)
}
