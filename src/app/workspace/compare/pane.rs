//! The pane of one method.

use crate::app::canvas::CanvasOutput;
use crate::app::project::compare::Contender;
use crate::app::project::side::Side;
use crate::app::window::BurstscopeApp;
use egui::{Align, Rect, Ui, UiBuilder};

/// Draws into a rectangle, from its top.
pub(crate) fn in_rect<T>(ui: &mut Ui, rect: Rect, draw: impl FnOnce(&mut Ui) -> T) -> T {
    ui.scope_builder(UiBuilder::new().max_rect(rect).layout(egui::Layout::top_down(Align::Min)), draw).inner
}

/// Draws the pane of a method; all of one side share the view of that side's pane.
pub(crate) fn pane_ui(ui: &mut Ui, app: &mut BurstscopeApp, (method, side): (Contender, Side)) -> CanvasOutput {
    let mut view = app.model.panes.of(side).view;
    let output = app.compare_pictures.pane_ui(ui, &app.model, (method, side), &mut view);
    app.model.panes.of_mut(side).view = view;
    output
}
