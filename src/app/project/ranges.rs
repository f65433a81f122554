//! Value ranges of pictures: a pane's own or those that panes share, and the picture that sets them.
//!
//! A shared range is set by the pane in focus, or if that shows another class of picture by the first in reading order,
//! once its wanted picture is there. So the result does not depend on the order in which the pictures are made: the
//! same panes always get the same range.

use crate::app::pane::{Pane, PaneId};
use crate::app::project::Model;
use crate::app::project::look::{RangeClass, Ranges};
use crate::plane::display::Display;

impl Model {
    /// Class of the value range in which the picture of `id` is shown.
    pub fn range_class(&self, id: PaneId) -> RangeClass {
        let picture = self.panes.get(id).and_then(|pane| pane.picture.as_ref());
        let wanted = || self.wanted(id).map_or(RangeClass::Intensity, |wanted| RangeClass::of(&wanted));
        picture.map_or_else(wanted, |picture| RangeClass::of(&picture.request))
    }

    /// Value ranges of `pane`: its own, or those that panes share.
    pub fn ranges_of<'a>(&'a self, pane: &'a Pane) -> &'a Ranges {
        pane.own_ranges.as_ref().unwrap_or(&self.look.ranges)
    }

    /// Value ranges of the pane in focus, for changing: its own, or those that panes share.
    pub fn focused_ranges_mut(&mut self) -> &mut Ranges {
        let focus = self.focus();
        match self.panes.get_mut(focus).and_then(|pane| pane.own_ranges.as_mut()) {
            Some(own) => own,
            None => &mut self.look.ranges,
        }
    }

    /// Display of the picture of `id`: range, gamma and colours.
    pub fn display_of(&self, id: PaneId) -> Display {
        let ranges = self.panes.get(id).map_or(&self.look.ranges, |pane| self.ranges_of(pane));
        ranges.display(self.range_class(id))
    }

    /// Sets the ranges that are not set yet: a pane's own range from its picture, a shared one from the pane in focus
    /// or the first in reading order that shows this class.
    pub fn settle_ranges(&mut self) {
        let mut led = Vec::new();
        let focus = self.focus();
        let mut ids = self.visible_panes();
        ids.sort_by_key(|id| *id != focus);
        for id in ids {
            let Some(wanted) = self.wanted(id) else { continue };
            let class = RangeClass::of(&wanted);
            let is_current = self.is_current(id);
            let Some(pane) = self.panes.get_mut(id) else { continue };
            let own = pane.own_ranges.as_mut();
            if pane.problem.is_some() || (own.is_none() && led.contains(&class)) {
                continue;
            }
            if own.is_none() {
                led.push(class);
            }
            if let Some(picture) = pane.picture.as_ref().filter(|_| is_current) {
                own.unwrap_or(&mut self.look.ranges).fix_once(picture);
            }
        }
    }
}
