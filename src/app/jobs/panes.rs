//! Work of the window for its panes: applies the changes that a pane asked for, updates linked panes, and requests the
//! pictures that they show.

use crate::app::inspector::Change;
use crate::app::pane::{PaneId, Panes};
use crate::app::project::Model;
use crate::app::project::cursor::Cursor;
use crate::app::window::BurstscopeApp;

/// Cursor in focus at the beginning of a pass.
pub(in crate::app) struct CursorBefore {
    focus: PaneId,
    cursor: Cursor,
}

impl CursorBefore {
    /// Records the cursor in focus.
    pub(in crate::app) fn of(model: &Model) -> Self {
        Self { focus: model.focus(), cursor: *model.cursor() }
    }

    /// Moves the cursors that are linked to it if it has moved since.
    pub(in crate::app) fn lead(self, model: &mut Model) {
        if self.focus == model.focus() && self.cursor != *model.cursor() {
            model.panes.follow_cursor(self.focus, self.cursor);
            model.check_params();
            model.check_pair();
        }
    }
}

impl BurstscopeApp {
    /// Applies the change that a pane asked for, and drops the state of closed panes.
    pub(in crate::app) fn change_panes(&mut self, change: Change) {
        let panes = &mut self.model.panes;
        match change {
            Change::Split(id, direction) => {
                panes.split(id, direction);
            }
            Change::Close(id) => panes.close(id),
            Change::LayOut(id, preset) => {
                panes.set_focus(id);
                self.model.lay_out(preset);
            }
            Change::LayOutSides(preset) => panes.lay_out_sides(preset),
            Change::LayOutMethods(preset) => self.model.lay_out_methods(preset),
        }
        // Cursors that a change of the layout sets do not make linked cursors follow.
        self.cursors_set = true;
        self.forget_closed_panes();
    }

    /// Drops the state and the requests of closed panes.
    pub(in crate::app) fn forget_closed_panes(&mut self) {
        let panes: &Panes = &self.model.panes;
        self.widgets.retain(|id| panes.get(id).is_some());
        self.model.forget_closed_pictures();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::pane::{Direction, Link};
    use crate::app::project::tests::open;
    use crate::detector::Slope;

    #[test]
    fn what_is_linked_moves_with_the_cursor_in_focus_and_nothing_else_does() {
        let mut model = Model::default();
        model.take_burst(open((64, 48), 5));
        let first = model.focus();
        let [second, third] =
            [Direction::Right, Direction::Right].map(|to| model.panes.split(first, to).expect("room"));
        model.panes.get_mut(third).expect("it is there").links.set(Link::Cursor, false);
        model.panes.set_focus(first);
        let slopes = |model: &Model| [first, second, third].map(|id| model.panes.get(id).expect("there").cursor.slope);
        let [start, ..] = slopes(&model);
        let (left, right) = (Slope::new(start.u - 1.0, start.v), Slope::new(start.u + 1.0, start.v));

        let before = CursorBefore::of(&model);
        model.focused_mut().cursor.slope = right;
        before.lead(&mut model);
        assert_eq!(slopes(&model), [right, right, start]);

        // The cursor of another pane was there already when the focus went to it.
        let before = CursorBefore::of(&model);
        model.panes.set_focus(second);
        model.focused_mut().cursor.slope = left;
        before.lead(&mut model);
        assert_eq!(slopes(&model), [right, left, start]);
    }
}
