//! State of the panes' widgets, kept between passes.

use super::menu_place::MenuPlace;
use crate::app::canvas::{Readout, RectTransform};
use crate::app::pane::PaneId;
use crate::app::panel::display::DisplayState;
use crate::app::panel::picture::PictureState;
use crate::app::panel::probe::PlaneTexture;
use egui::{Pos2, Rect};
use std::collections::HashMap;

/// State of one pane's widgets.
#[derive(Default)]
pub struct PaneWidget {
    /// Picture on the card, and the place where it was drawn.
    pub picture: PictureState,
    /// Histogram, while the pane is focused.
    pub display: DisplayState,
    /// Rectangle of the whole pane in the window, if it was drawn in this pass.
    pub rect_ui: Option<Rect>,
    /// Slice, if the pane shows one.
    pub(super) slice: PlaneTexture,
    /// Target of the picture's menu.
    pub(super) menu: MenuPlace,
}

/// Value of one pane at the place under the pointer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceValue {
    /// Pane.
    pub id: PaneId,
    /// Number of the pane, from 1.
    pub number: usize,
    /// Place in that pane, and the value there.
    pub readout: Readout,
}

/// State of the widgets of all panes.
#[derive(Default)]
pub struct PaneWidgets {
    all: HashMap<PaneId, PaneWidget>,
    /// Values at the place under the pointer: first that of the pane under it, then those of the panes linked to it.
    pub values: Vec<PlaceValue>,
}

impl PaneWidgets {
    /// State of `id`, created when needed.
    pub fn of(&mut self, id: PaneId) -> &mut PaneWidget {
        self.all.entry(id).or_default()
    }

    /// State of `id`, if it was drawn.
    pub fn get(&self, id: PaneId) -> Option<&PaneWidget> {
        self.all.get(&id)
    }

    /// Transform from image pixels to points of the window, as `id` was drawn last.
    pub fn ui_from_image(&self, id: PaneId) -> Option<RectTransform> {
        self.get(id)?.picture.ui_from_image
    }

    /// Position of an image place in the window, as `id` was drawn last.
    pub fn pos_ui(&self, id: PaneId, pos_image: Pos2) -> Option<Pos2> {
        self.ui_from_image(id).map(|t| t.pos(pos_image))
    }

    /// Rectangle of pane `id` in the window, if it is visible.
    pub fn rect_ui(&self, id: PaneId) -> Option<Rect> {
        self.get(id)?.rect_ui
    }

    /// Clears the places of panes before they are drawn.
    pub(super) fn begin_pass(&mut self) {
        self.all.values_mut().for_each(|widget| (widget.rect_ui, widget.picture.readout) = (None, None));
    }

    /// Removes the state of all panes that `keep` rejects.
    pub fn retain(&mut self, keep: impl Fn(PaneId) -> bool) {
        self.all.retain(|id, _| keep(*id));
    }
}
