//! Two bursts side by side, and the matches between them: the cursors and the parameters of matching left, the two
//! pictures in the middle with the table of matches below them, the selected match with both its patches right.

mod detail;
mod empty;
mod lines;
mod lost_table;
mod numbers;
mod panes;
pub mod parameters;
mod sides;
mod switches;
mod table;
mod why;

use crate::app::actions::Queue;
use crate::app::panel;
use crate::app::panel::patch::PatchTexture;
use crate::app::project::pair::PATCHES;
use crate::app::window::BurstscopeApp;
use crate::app::workspace::{bottom_frame, side_frame, side_width};
use crate::engine::Patches;
use egui::{CentralPanel, Frame, Panel, Rect, ScrollArea};

/// What the workspace's widgets keep from pass to pass.
#[derive(Default)]
pub struct PairPanels {
    /// Where B's pane was drawn last, in points; files that are dropped there are opened as B.
    pub rect_b: Option<Rect>,
    /// The pictures from which the patches are cut.
    pub patches: Option<Patches>,
    patch_textures: [PatchTexture; 2],
    candidate_textures: [PatchTexture; PATCHES + 1],
    /// The camera as it is being typed.
    pub camera_text: parameters::CameraText,
}

/// Draws the workspace.
pub fn pair_workspace_ui(app: &mut BurstscopeApp, ui: &mut egui::Ui, queue: &mut Queue) {
    let width = side_width(ui);
    if app.model.panels.left {
        Panel::left("pair left").frame(side_frame(ui)).default_size(width).size_range(250.0..=420.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                sides::sides_ui(ui, &mut app.model, queue);
                panel::cursor::cursor_ui(ui, &mut app.model, queue);
                parameters::parameters_ui(ui, &mut app.model, &mut app.pair_panels.camera_text, queue);
                panel::parameters::parameters_ui(ui, &mut app.model, queue);
            });
        });
    }
    if app.model.panels.right {
        Panel::right("pair right").frame(side_frame(ui)).default_size(width).size_range(250.0..=460.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                switches::switches_ui(ui, &mut app.model);
                let (patches, textures) = (app.pair_panels.patches.as_ref(), &mut app.pair_panels.patch_textures);
                detail::detail_ui(ui, &app.model, patches, textures, queue);
                why::why_ui(ui, &app.model, &mut app.pair_panels.candidate_textures, queue);
                panel::display::ranges_ui(ui, &mut app.model, &mut app.widgets);
            });
        });
    }
    let mut in_table = None;
    if app.model.panels.bottom {
        Panel::bottom("pair bottom")
            .frame(bottom_frame(ui))
            .resizable(true)
            .default_size(190.0)
            .size_range(90.0..=500.0)
            .show(ui, |ui| {
                numbers::numbers_ui(ui, &app.model);
                ui.separator();
                lost_table::switch_ui(ui, &mut app.model);
                if app.model.pair.lost.listed {
                    lost_table::lost_table_ui(ui, &mut app.model);
                } else {
                    in_table = table::table_ui(ui, &mut app.model, queue);
                }
            });
    }
    // What is between the two pictures.
    let between = ui.visuals().panel_fill;
    CentralPanel::default().frame(Frame::new().fill(between)).show(ui, |ui| {
        let over_pictures = panes::panes_ui(app, ui, queue);
        app.model.pair.hovered = over_pictures.unwrap_or(in_table);
    });
}
