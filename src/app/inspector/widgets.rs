//! What the panes' widgets keep from pass to pass.

use super::menu_place::MenuPlace;
use crate::app::canvas::{Readout, RectTransform};
use crate::app::pane::PaneId;
use crate::app::panel::display::DisplayState;
use crate::app::panel::picture::PictureState;
use crate::app::panel::probe::PlaneTexture;
use egui::{Pos2, Rect};
use std::collections::HashMap;

/// What one pane's widgets keep.
#[derive(Default)]
pub struct PaneWidget {
    /// The picture as the card knows it, and where it was drawn.
    pub picture: PictureState,
    /// The histogram while the pane is in focus.
    pub display: DisplayState,
    /// Where the whole pane is in the window, if it was drawn in this pass.
    pub rect_ui: Option<Rect>,
    /// The slice, if it shows one.
    pub(super) slice: PlaneTexture,
    /// What the menu of its picture is about.
    pub(super) menu: MenuPlace,
}

/// The value of one pane at the place that is pointed at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceValue {
    /// Which pane.
    pub id: PaneId,
    /// Its number, from 1.
    pub number: usize,
    /// The place in that pane, and the value there.
    pub readout: Readout,
}

/// What the widgets of all panes keep.
#[derive(Default)]
pub struct PaneWidgets {
    all: HashMap<PaneId, PaneWidget>,
    /// The values at the place that is pointed at: of the pane under the pointer first, then of those that are linked
    /// to it.
    pub values: Vec<PlaceValue>,
}

impl PaneWidgets {
    /// Those of `id`, made when they are asked for first.
    pub fn of(&mut self, id: PaneId) -> &mut PaneWidget {
        self.all.entry(id).or_default()
    }

    /// Those of `id`, if it was drawn.
    pub fn get(&self, id: PaneId) -> Option<&PaneWidget> {
        self.all.get(&id)
    }

    /// From image pixels to points of the window, as `id` was drawn last.
    pub fn ui_from_image(&self, id: PaneId) -> Option<RectTransform> {
        self.get(id)?.picture.ui_from_image
    }

    /// Where a place of the image is in the window, as `id` was drawn last.
    pub fn pos_ui(&self, id: PaneId, pos_image: Pos2) -> Option<Pos2> {
        self.ui_from_image(id).map(|t| t.pos(pos_image))
    }

    /// Where pane `id` is in the window, if it is to be seen.
    pub fn rect_ui(&self, id: PaneId) -> Option<Rect> {
        self.get(id)?.rect_ui
    }

    /// Forgets where panes are: they are about to be drawn.
    pub(super) fn begin_pass(&mut self) {
        self.all.values_mut().for_each(|widget| (widget.rect_ui, widget.picture.readout) = (None, None));
    }

    /// Forgets all panes but those that `keep` knows.
    pub fn retain(&mut self, keep: impl Fn(PaneId) -> bool) {
        self.all.retain(|id, _| keep(*id));
    }
}
