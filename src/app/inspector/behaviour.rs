//! Callbacks of `egui_tiles` for the inspector.

use super::empty::empty_ui;
use super::header::header_ui;
use super::menu::Change;
use super::method::method_ui;
use super::names::canvas_name;
use super::pane_ui::{Drawn, over_names_ui, over_ui, picture_ui};
use super::slice_ui::slice_ui;
use super::widgets::PaneWidgets;
use crate::app::actions::Queue;
use crate::app::measure::{draw_ui, measure_ui};
use crate::app::pane::{Content, PaneId};
use crate::app::panel::display::colour_bar_ui;
use crate::app::panel::features::{FeatureOptions, features_ui};
use crate::app::panel::picture::stale_ui;
use crate::app::panel::tally::candidates_ui;
use crate::app::project::Model;
use crate::app::project::workspace::Workspace;
use egui::{Stroke, StrokeKind, Ui, WidgetText};
use egui_tiles::{Behavior, SimplificationOptions, TileId, UiResponse};

/// Minimum size of a picture with a legend, in points.
const LEGEND_ROOM: egui::Vec2 = egui::vec2(250.0, 170.0);

/// Draws panes for `egui_tiles`.
pub(super) struct Inspector<'a> {
    pub model: &'a mut Model,
    pub widgets: &'a mut PaneWidgets,
    pub queue: &'a mut Queue,
    /// Drawn panes, in the order of drawing.
    pub drawn: Vec<(PaneId, Drawn)>,
    pub changes: Vec<Change>,
}

impl Behavior<PaneId> for Inspector<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, id: &mut PaneId) -> UiResponse {
        let id = *id;
        let Some(pane) = self.model.panes.get(id) else { return UiResponse::None };
        let (content, side, method, before) = (pane.content, pane.side, pane.method, pane.view);
        let is_open = self.model.burst_in(pane).is_some();
        let whole = ui.max_rect();
        self.widgets.of(id).rect_ui = Some(whole);
        ui.spacing_mut().item_spacing.y = 0.0;
        let header = header_ui(ui, self.model, id, self.widgets, &mut self.changes, self.queue);
        let touched = match content {
            Content::Slice(axis) => slice_ui(ui, self.model, id, axis, self.widgets),
            _ if !is_open => {
                empty_ui(ui, self.model, side, method, self.queue);
                false
            }
            _ => self.picture_ui(ui, id),
        };
        self.model.panes.follow_view(id, &before);
        if header.clicked || touched {
            self.model.panes.set_focus(id);
        }
        self.frame_ui(ui, id, whole);
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
    /// Draws the picture of a pane with its overlays; returns whether the pointer touched it.
    fn picture_ui(&mut self, ui: &mut Ui, id: PaneId) -> bool {
        let name = canvas_name(self.model, id);
        let mut drawn = picture_ui(ui, self.model, id, self.widgets, &name);
        over_ui(ui, self.model, id, self.widgets, &mut drawn);
        let rect = drawn.output.response.rect;
        let (inspected, in_focus) = (self.model.workspace == Workspace::Inspect, self.model.focus() == id);
        let options =
            FeatureOptions { legend: in_focus && rect.width() > LEGEND_ROOM.x && rect.height() > LEGEND_ROOM.y };
        features_ui(ui, self.model, drawn.shown, &mut self.widgets.of(drawn.shown).picture, &drawn.output, options);
        colour_bar_ui(ui, self.model, drawn.shown, rect);
        if inspected {
            candidates_ui(ui, self.model, drawn.shown, &drawn.output);
        }
        over_names_ui(ui, self.model, id, &drawn);
        method_ui(ui, self.model, id, &drawn);
        if inspected {
            draw_ui(self.model, id, &drawn.output);
            measure_ui(self.model, id, &drawn.output);
            if in_focus {
                stale_ui(ui, self.model, rect, self.queue);
            }
        }
        super::picture_menu::picture_menu_ui(&drawn, self.model, id, self.widgets, &mut self.changes, self.queue);
        let touched = drawn.is_touched(ui);
        self.drawn.push((id, drawn));
        touched
    }

    /// Draws a frame around the focused pane.
    fn frame_ui(&self, ui: &Ui, id: PaneId, whole: egui::Rect) {
        if self.model.panes.are_many() && self.model.focus() == id {
            let stroke = Stroke::new(1.0, crate::app::style::ACCENT);
            ui.painter().rect_stroke(whole, 0.0, stroke, StrokeKind::Inside);
        }
    }
}
