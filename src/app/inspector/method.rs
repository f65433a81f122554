//! Method of a pane and its number of features, in a corner of the picture.

use super::pane_ui::{Drawn, chip_ui};
use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::inspect::words::counted;
use egui::{Align2, Ui};

/// Draws it for pane `id`, if methods are compared. A pane under another one has its name drawn there already.
pub(super) fn method_ui(ui: &Ui, model: &Model, id: PaneId, drawn: &Drawn) {
    let Some(pane) = model.panes.get(id) else { return };
    let Some(method) = pane.method.filter(|_| model.panes.over(id).is_none()) else { return };
    let count = model.method_found(method, pane.side).map_or_else(
        || if model.compare.problem(method).is_some() { "not searched".to_owned() } else { "…".to_owned() },
        |found| counted(found.detection.features.len(), "feature"),
    );
    let text = format!("{}  ·  {count}", method.label());
    chip_ui(ui, &drawn.output, Align2::LEFT_TOP, &text, ("method", id));
}
