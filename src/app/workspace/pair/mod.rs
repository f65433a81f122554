//! Two bursts, and the matches between them: cursor and matching parameters on the left, panes of both bursts in the
//! centre with the table of matches below them, the selected match with both its patches on the right.

mod detail;
pub(super) mod lines;
mod lost_table;
mod numbers;
pub mod parameters;
mod sides;
mod switches;
mod table;
pub(super) mod views;
mod why;

use crate::app::inspector::{Change, Drawn, inspector_ui};
use crate::app::pane::PaneId;
use crate::app::panel;
use crate::app::panel::patch::PatchTexture;
use crate::app::parts::mark;
use crate::app::project::pair::{PATCHES, PairTab, Side};
use crate::app::workspace::{WorkspaceParts, bottom_panel, side_frame, side_width};
use crate::teach::Part;
use egui::{CentralPanel, Frame, Panel, ScrollArea};

/// State of the workspace's widgets, kept between passes.
#[derive(Default)]
pub struct PairPanels {
    patch_textures: [PatchTexture; 2],
    candidate_textures: [PatchTexture; PATCHES + 1],
    /// Camera as typed.
    pub camera_text: parameters::CameraText,
}

/// Draws the workspace. Returns the panes' requests.
pub(super) fn pair_workspace_ui(ui: &mut egui::Ui, parts: &mut WorkspaceParts<'_>) -> Vec<Change> {
    let WorkspaceParts { model, widgets, pair, probe, queue, .. } = parts;
    let width = side_width(ui);
    if model.panels.left {
        Panel::left("pair left").frame(side_frame(ui)).default_size(width).size_range(250.0..=420.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                sides::sides_ui(ui, model, queue);
                panel::cursor::cursor_ui(ui, model, queue);
                parameters::parameters_ui(ui, model, &mut pair.camera_text, queue);
                panel::parameters::parameters_ui(ui, model, queue);
            });
        });
    }
    if model.panels.right {
        Panel::right("pair right").frame(side_frame(ui)).default_size(width).size_range(250.0..=460.0).show(ui, |ui| {
            let other = ("Match and display", "The selected match, and how matches and pictures are drawn");
            if panel::probe::probe_tab_ui(ui, model, probe, other, queue) {
                return;
            }
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                switches::switches_ui(ui, model);
                detail::detail_ui(ui, model, &mut pair.patch_textures, queue);
                why::why_ui(ui, model, &mut pair.candidate_textures, queue);
                panel::display::ranges_ui(ui, model, widgets);
            });
        });
    }
    let (mut in_table, mut over_list) = (None, false);
    if model.panels.bottom {
        let is_over = bottom_panel(ui, "pair bottom", 300.0, |ui| {
            mark(ui, Part::Below, ui.max_rect());
            numbers::numbers_ui(ui, model);
            ui.separator();
            lost_table::switch_ui(ui, model);
            match model.pair.tab {
                PairTab::Matches => in_table = table::table_ui(ui, model, queue),
                PairTab::Unmatched => lost_table::lost_table_ui(ui, model),
                PairTab::Compared => panel::against::against_ui(ui, model, widgets, queue),
            }
        });
        over_list = is_over && model.pair.tab == PairTab::Compared;
    }
    // Background between the pictures.
    let between = ui.visuals().panel_fill;
    CentralPanel::default()
        .frame(Frame::new().fill(between))
        .show(ui, |ui| {
            mark(ui, Part::Pictures, ui.max_rect());
            let inspected = inspector_ui(ui, model, widgets, queue);
            let over_pictures = lines::lines_ui(ui, model, &inspected.drawn);
            model.pair.hovered = over_pictures.unwrap_or(in_table);
            for side in Side::BOTH {
                let is_over = |(id, drawn): &(PaneId, Drawn)| {
                    drawn.output.pointer_ui.is_some() && model.panes.get(*id).is_some_and(|pane| pane.side == side)
                };
                if !(inspected.drawn.iter().any(is_over) || (over_list && model.active_side() == side)) {
                    model.slots[side].against.hovered = None;
                }
            }
            inspected.changes
        })
        .inner
}
