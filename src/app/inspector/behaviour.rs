//! What `egui_tiles` asks of the inspector.

use super::header::header_ui;
use super::menu::Change;
use super::pane_ui::{Drawn, over_names_ui, over_ui, picture_ui};
use super::slice_ui::slice_ui;
use super::widgets::PaneWidgets;
use crate::app::actions::Queue;
use crate::app::measure::{draw_ui, measure_ui};
use crate::app::pane::{Content, PaneId};
use crate::app::panel::candidates::candidates_ui;
use crate::app::panel::colour_bar::colour_bar_ui;
use crate::app::panel::features::{FeatureOptions, features_ui};
use crate::app::panel::picture::stale_ui;
use crate::app::project::Model;
use egui::{Sense, Stroke, StrokeKind, Ui, WidgetText};
use egui_tiles::{Behavior, SimplificationOptions, TileId, UiResponse};

/// A picture that is at least this large, in points, has room for the legend.
const LEGEND_ROOM: egui::Vec2 = egui::vec2(250.0, 170.0);

/// Draws panes for `egui_tiles`.
pub(super) struct Inspector<'a> {
    pub model: &'a mut Model,
    pub widgets: &'a mut PaneWidgets,
    pub queue: &'a mut Queue,
    /// What was drawn, in the order of drawing.
    pub drawn: Vec<(PaneId, Drawn)>,
    pub changes: Vec<Change>,
}

impl Behavior<PaneId> for Inspector<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, id: &mut PaneId) -> UiResponse {
        let id = *id;
        let Some(number) = self.model.panes.number(id) else { return UiResponse::None };
        let many = self.model.panes.are_many();
        let whole = ui.max_rect();
        ui.spacing_mut().item_spacing.y = 0.0;
        let header = header_ui(ui, self.model, id, self.widgets, &mut self.changes, self.queue);
        if let Some(Content::Slice(axis)) = self.model.panes.get(id).map(|pane| pane.content) {
            if slice_ui(ui, self.model, id, axis, self.widgets) || header.clicked {
                self.model.panes.set_focus(id);
            }
            self.frame_ui(ui, id, whole);
            return if header.dragged { UiResponse::DragStarted } else { UiResponse::None };
        }
        let name = if many { format!("Picture {number}") } else { "Picture".to_owned() };
        let before = self.model.panes.get(id).map(|pane| pane.view);
        let mut drawn = picture_ui(ui, self.model, id, self.widgets, &name);
        over_ui(ui, self.model, id, self.widgets, &mut drawn);
        let size = drawn.output.response.rect.size();
        let in_focus = self.model.focus() == id;
        let options = FeatureOptions { legend: in_focus && size.x > LEGEND_ROOM.x && size.y > LEGEND_ROOM.y };
        features_ui(ui, self.model, drawn.shown, &mut self.widgets.of(drawn.shown).picture, &drawn.output, options);
        colour_bar_ui(ui, self.model, drawn.shown, drawn.output.response.rect);
        candidates_ui(ui, self.model, drawn.shown, &drawn.output);
        over_names_ui(ui, self.model, id, &drawn);
        draw_ui(self.model, id, &drawn.output);
        measure_ui(self.model, id, &drawn.output);
        if in_focus {
            stale_ui(ui, self.model, drawn.output.response.rect, self.queue);
        }
        super::picture_menu::picture_menu_ui(&drawn, self.model, id, self.widgets, &mut self.changes, self.queue);
        if let Some(before) = before {
            self.model.panes.follow_view(id, &before);
        }
        if header.clicked || drawn.is_touched(ui) {
            self.model.panes.set_focus(id);
        }
        self.frame_ui(ui, id, whole);
        self.drawn.push((id, drawn));
        if header.dragged { UiResponse::DragStarted } else { UiResponse::None }
    }

    fn tab_title_for_pane(&mut self, id: &PaneId) -> WidgetText {
        let number = self.model.panes.number(*id).map_or_else(String::new, |number| format!("{number}  "));
        format!("{number}{}", super::compact_description(self.model, *id)).into()
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
    /// The pane in focus has a frame.
    fn frame_ui(&self, ui: &Ui, id: PaneId, whole: egui::Rect) {
        if self.model.panes.are_many() && self.model.focus() == id {
            let stroke = Stroke::new(1.0, crate::app::style::ACCENT);
            ui.painter().rect_stroke(whole, 0.0, stroke, StrokeKind::Inside);
        }
    }
}

/// A part of a header by which the pane is dragged.
pub(super) fn grip_sense(many: bool) -> Sense {
    if many { Sense::click_and_drag() } else { Sense::click() }
}
