//! The workspaces of the window: each lays out its panels between the toolbar above and the status bar below.

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

/// What a workspace reads and changes: the project, and what its widgets keep from pass to pass.
pub struct WorkspaceParts<'a> {
    /// What is open.
    pub model: &'a mut Model,
    /// What the panes' widgets keep.
    pub widgets: &'a mut PaneWidgets,
    /// What the panels of two bursts keep.
    pub pair: &'a mut PairPanels,
    /// What the panel of the selected feature keeps.
    pub selection: &'a mut SelectionState,
    /// What the panel of the probe keeps.
    pub probe: &'a mut ProbePanel,
    /// What was computed of the rectangle that is measured.
    pub regions: &'a mut RegionCache,
    /// The Lab's chart as a texture.
    pub lab_picture: &'a mut PlaneTexture,
    /// The actions that were asked for.
    pub queue: &'a mut Queue,
}

/// What a workspace asks for that it cannot do itself.
#[derive(Debug, Default)]
pub struct WorkspaceWishes {
    /// Panes that come, go or are laid out anew.
    pub changes: Vec<Change>,
    /// Trajectories are to be compared again.
    pub compare_again: bool,
    /// The image of this camera is to be opened.
    pub camera: Option<String>,
}

/// The actions that lead to the workspaces, in the order of the switch.
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

/// Draws the workspace that is open.
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

/// How high a panel below the pictures can be dragged, in points.
const BOTTOM_HEIGHTS: std::ops::RangeInclusive<f32> = 90.0..=520.0;

/// The pictures have so much height at first, in points, and what is below them what is left.
const PICTURES_HEIGHT: f32 = 320.0;

/// The frame of a panel at the side of the window.
fn side_frame(ui: &egui::Ui) -> egui::Frame {
    egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin { left: 8, right: 5, top: 6, bottom: 4 })
}

/// A panel below the pictures, `height` points high until it is dragged, or less in a small window. It keeps its height
/// whatever it holds, so that nothing moves under the pointer when features come or another tab is opened. Answers
/// whether the pointer is over it.
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

/// Width of a panel at the side, in points: on a small screen the picture needs the room more than the panels do.
fn side_width(ui: &egui::Ui) -> f32 {
    (0.235 * ui.available_width()).clamp(256.0, 300.0)
}
