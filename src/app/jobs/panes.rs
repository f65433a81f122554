//! What the window does for its panes: changes them as a pane asked for, lets linked ones follow, and asks the engine
//! for the pictures that they want.

use crate::app::inspector::Change;
use crate::app::pane::{PaneId, Panes};
use crate::app::project::Model;
use crate::app::project::cursor::Cursor;
use crate::app::window::BurstscopeApp;
use crate::engine::JobAnswer;
use crate::requests::{JobError, Picture};

/// Where the cursor in focus was at the beginning of a pass.
pub(in crate::app) struct CursorBefore {
    focus: PaneId,
    cursor: Cursor,
}

impl CursorBefore {
    /// Where it is now.
    pub(in crate::app) fn of(model: &Model) -> Self {
        Self { focus: model.focus(), cursor: *model.cursor() }
    }

    /// Lets what is linked to it follow if it has moved since.
    pub(in crate::app) fn lead(self, model: &mut Model) {
        if self.focus == model.focus() && self.cursor != *model.cursor() {
            model.panes.follow_cursor(self.focus, self.cursor);
            model.check_params();
            model.check_pair();
        }
    }
}

impl BurstscopeApp {
    /// Does what a pane asked for, and forgets what was kept of panes that are gone.
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
        // Panes that were laid out each in its own place do not follow one another for it.
        self.cursors_set = true;
        self.forget_closed_panes();
    }

    /// Forgets what was kept and asked for of panes that are gone.
    pub(in crate::app) fn forget_closed_panes(&mut self) {
        let panes: &Panes = &self.model.panes;
        self.widgets.retain(|id| panes.get(id).is_some());
        let engine = &self.engine;
        self.asked.pictures.retain(|id, _| {
            let is_there = panes.get(*id).is_some();
            if !is_there {
                engine.forget_picture(id.slot());
            }
            is_there
        });
    }

    /// Takes a pane's picture, or why there is none.
    pub(in crate::app) fn take_picture(&mut self, id: PaneId, answer: JobAnswer<Picture>) {
        match answer.result {
            Ok(picture) => {
                self.asked.pictures.retain(|asked_id, asked| *asked_id != id || !asked.same_picture(&picture.request));
                self.model.take_picture(id, picture);
            }
            Err(JobError::Superseded) => {}
            Err(JobError::Cancelled) => {
                self.asked.pictures.remove(&id);
            }
            Err(error) => {
                if let Some(asked) = self.asked.pictures.remove(&id) {
                    self.model.take_problem(id, asked, &error);
                }
            }
        }
    }

    /// Asks for the pictures that panes on the screen want, have not, and were not asked for.
    pub(in crate::app) fn request_pictures(&mut self) {
        let focus = self.model.focus();
        let mut ids = self.model.visible_panes();
        // The pane in focus comes first.
        ids.sort_by_key(|id| *id != focus);
        for id in ids {
            let Some(wanted) = self.model.wanted(id) else { continue };
            let is_under_way = self.asked.pictures.get(&id).is_some_and(|asked| asked.same_picture(&wanted));
            if !is_under_way && !self.model.is_current(id) {
                self.engine.request_picture(id.slot(), wanted.clone());
                self.asked.pictures.insert(id, wanted);
            }
        }
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
