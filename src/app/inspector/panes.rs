//! All panes of the open workspace, as `egui_tiles` draws them, or a page that says how to open a pane's burst.

use super::header::header_ui;
use super::marks::{focus_ui, marks_ui, probe_ui};
use super::menu::picture_menu_ui;
use super::pane_ui::{Drawn, method_ui, over_names_ui, over_ui, picture_ui, scrub_ui, slice_ui};
use super::widgets::{PaneWidgets, short_description};
use crate::app::actions::{ActionId, Queue, tooltip};
use crate::app::document::{Action, MethodId, Side};
use crate::app::measure::{draw_ui, hidden_ui, measure_ui};
use crate::app::pane::{Content, PaneId, arrangement_of, tree_of};
use crate::app::panel::widgets::{progress_ui, weak_ui};
use crate::app::results::Read;
use crate::app::{panel::display::colour_bar_ui, panel::features::features_ui};
use crate::app::{panel::picture::stale_ui, panel::tally::candidates_ui};
use egui::{Response, RichText, Stroke, StrokeKind, Ui, WidgetText, vec2};
use egui_tiles::{Behavior, SimplificationOptions, TileId, UiResponse};

/// Draws the panes; returns those with a picture, in the order of drawing.
pub fn inspector_ui(ui: &mut Ui, model: Read<'_>, widgets: &mut PaneWidgets, queue: &mut Queue) -> Vec<Drawn> {
    widgets.all.values_mut().for_each(|widget| (widget.rect_ui, widget.picture.readout) = (None, None));
    let mut tree = tree_of(model.document.panes.arrangement());
    let mut inspector = Inspector { model, widgets, queue, drawn: Vec::new() };
    tree.ui(&mut inspector, ui);
    let Inspector { drawn, .. } = inspector;
    // The tree is made anew in each pass: a drag is found by comparing it with the document.
    if let Some(arrangement) = arrangement_of(&tree) {
        queue.set(model.document.panes.arrangement(), arrangement, Action::Rearrange);
    }
    // After all panes, because a mark in one may come from the pointer in any other.
    marks_ui(model, widgets, &drawn);
    if model.document.workspace.probes() {
        probe_ui(ui, model, widgets, &drawn, queue);
        focus_ui(ui, model, &drawn, queue);
    }
    drawn
}

fn gold_ui(ui: &mut Ui, side: Side, queue: &mut Queue) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.2).max(12.0));
        weak_ui(ui, format!("Open a sharp image of {}'s view, taken with enough light", side.name()));
        let id = if side == Side::A { ActionId::OpenGoldA } else { ActionId::OpenGoldB };
        queue.push_if(ui.button(id.action().label).on_hover_text(tooltip(ui.ctx(), id.action())).clicked(), id);
    });
}

fn second_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.2).max(12.0));
        ui.label(RichText::new("Open a second burst").size(18.0).strong());
        weak_ui(ui, "of the same place: its features are matched with those of the first");
        ui.add_space(12.0);
        if let Some(running) = model.results.slots.b.opening.running {
            progress_ui(ui, &running, Some(220.0), "Opening B…");
            return;
        }
        for id in [ActionId::OpenFolderB, ActionId::OpenFilesB, ActionId::OpenPathB, ActionId::OpenDemoB] {
            let button = egui::Button::new(id.action().label).min_size(vec2(220.0, 26.0));
            queue.push_if(ui.add(button).on_hover_text(tooltip(ui.ctx(), id.action())).clicked(), id);
        }
        ui.add_space(8.0);
        ui.weak("or drop it here");
    });
}

const LEGEND_ROOM: egui::Vec2 = vec2(250.0, 170.0);

struct Inspector<'a> {
    model: Read<'a>,
    widgets: &'a mut PaneWidgets,
    queue: &'a mut Queue,
    drawn: Vec<Drawn>,
}

impl Behavior<PaneId> for Inspector<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, id: &mut PaneId) -> UiResponse {
        let id = *id;
        let Some(pane) = self.model.pane(id) else { return UiResponse::None };
        let whole = ui.max_rect();
        self.widgets.of(id).rect_ui = Some(whole);
        ui.spacing_mut().item_spacing.y = 0.0;
        let name = header_ui(ui, self.model, id, self.widgets, self.queue);
        let mut touched = false;
        match (pane.content, pane.method) {
            (Content::Slice(axis), _) => touched = slice_ui(ui, self.model, id, axis, self.queue),
            _ if self.model.burst_in(pane).is_some() => touched = self.picture_ui(ui, id),
            (_, Some(MethodId::Gold)) => gold_ui(ui, pane.side, self.queue),
            _ => second_ui(ui, self.model, self.queue),
        }
        let is_clicked = name.as_ref().is_some_and(Response::clicked);
        self.queue.push_if((is_clicked || touched) && self.model.document.focus() != id, Action::Focus(id));
        // After the content, which would cover the frame.
        if self.model.document.panes.are_many() && self.model.document.focus() == id {
            ui.painter().rect_stroke(whole, 0.0, Stroke::new(1.0, crate::app::style::ACCENT), StrokeKind::Inside);
        }
        if name.is_some_and(|name| name.drag_started()) { UiResponse::DragStarted } else { UiResponse::None }
    }

    fn tab_title_for_pane(&mut self, id: &PaneId) -> WidgetText {
        let number = self.model.document.panes.number(*id).map_or_else(String::new, |number| format!("{number}  "));
        format!("{number}{}", short_description(self.model, *id, false)).into()
    }

    fn gap_width(&self, _: &egui::Style) -> f32 {
        4.0
    }

    fn min_size(&self) -> f32 {
        64.0
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: false, ..SimplificationOptions::default() }
    }
}

impl Inspector<'_> {
    /// Draws the picture of a pane with its overlays; returns whether the pointer touched it.
    fn picture_ui(&mut self, ui: &mut Ui, id: PaneId) -> bool {
        let mut drawn = picture_ui(ui, self.model, id, self.widgets, self.queue);
        over_ui(ui, self.model, self.widgets, &mut drawn, self.queue);
        let rect = drawn.output.response.rect;
        let (inspected, in_focus) = (self.model.document.workspace.inspects(), self.model.document.focus() == id);
        // One legend in the window is enough, and in a small pane it would cover the picture.
        let has_legend = in_focus && rect.width() > LEGEND_ROOM.x && rect.height() > LEGEND_ROOM.y;
        let state = &mut self.widgets.of(drawn.shown).picture;
        features_ui(ui, self.model, drawn.shown, state, &drawn.output, has_legend, self.queue);
        colour_bar_ui(ui, self.model, drawn.shown, rect);
        let of_method = self.model.pane(drawn.shown).is_some_and(|pane| pane.method.is_some());
        if inspected && !of_method {
            candidates_ui(ui, self.model, drawn.shown, &drawn.output, self.queue);
        }
        over_names_ui(ui, self.model, &drawn, self.queue);
        method_ui(ui, self.model, &drawn);
        if inspected {
            draw_ui(self.model, id, &drawn.output, self.queue);
            measure_ui(self.model, id, &drawn.output);
            if in_focus && !of_method {
                stale_ui(ui, self.model, rect, self.queue);
                hidden_ui(ui, self.model, rect, self.queue);
            }
        }
        picture_menu_ui(&drawn, self.model, self.widgets, self.queue);
        scrub_ui(ui, self.model, &drawn, self.queue);
        let touched = drawn.is_touched(ui);
        self.drawn.push(drawn);
        touched
    }
}
