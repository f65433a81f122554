//! Panes in each pass of the window: changes of the set of panes, cursors that follow the one in focus, views, and
//! playing through the slopes.

use crate::app::pane::{Direction, MethodsPreset, PaneId, Preset, SidesPreset};
use crate::app::project::Model;
use crate::app::project::cursor::{Cursor, play_step_of, played};
use crate::app::project::side::Side;
use crate::app::view::View;
use std::time::{Duration, Instant};

const PLAY_EVERY: Duration = Duration::from_millis(220);

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    Split(PaneId, Direction),
    Close(PaneId),
    LayOut(PaneId, Preset),
    LayOutSides(SidesPreset),
    LayOutMethods(MethodsPreset),
}

/// Changes of this pass that were set explicitly, so that nothing follows from them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SetExplicitly {
    pub cursors: bool,
    pub history: bool,
}

#[derive(Debug, Default)]
pub(super) struct Play {
    step: usize,
    due: Option<Instant>,
}

#[derive(Debug, Clone, Copy)]
pub struct CursorBefore {
    focus: PaneId,
    cursor: Cursor,
}

impl CursorBefore {
    pub fn of(model: &Model) -> Self {
        Self { focus: model.focus(), cursor: *model.cursor() }
    }
}

impl Model {
    pub fn change_panes(&mut self, change: Change) {
        match change {
            Change::Split(id, direction) => {
                self.panes.split(id, direction);
            }
            Change::Close(id) => self.panes.close(id),
            Change::LayOut(id, preset) => {
                self.panes.set_focus(id);
                self.lay_out(preset);
            }
            Change::LayOutSides(preset) => self.panes.lay_out_sides(preset),
            Change::LayOutMethods(preset) => self.lay_out_methods(preset),
        }
        self.cursors_are_set();
    }

    /// Keeps linked cursors where they are in this pass: each was set to its own place.
    pub(in crate::app) fn cursors_are_set(&mut self) {
        self.set_explicitly.cursors = true;
    }

    /// As [`Self::cursors_are_set`]; nor are the changes of this pass a step to undo.
    pub(in crate::app) fn settings_are_set(&mut self) {
        (self.set_explicitly.cursors, self.set_explicitly.history) = (true, true);
    }

    pub(in crate::app) fn lead_cursors(&mut self, before: CursorBefore) {
        let are_set = std::mem::take(&mut self.set_explicitly.cursors);
        if !are_set && before.focus == self.focus() && before.cursor != *self.cursor() {
            self.panes.follow_cursor(before.focus, before.cursor);
            self.check_params();
            self.check_pair();
        }
    }

    pub fn change_views(&mut self, change: impl Fn(&mut View)) {
        let (focus, shown) = (self.focus(), self.panes.shown());
        let is_linked = self.focused().links.view;
        for (id, pane) in self.panes.iter_mut() {
            if id == focus || (is_linked && pane.links.view && shown.contains(&id)) {
                change(&mut pane.view);
            }
        }
    }

    pub fn go_to_selected(&mut self) {
        let Some(feature) = self.selected_feature().copied() else { return };
        self.focus_on_side(Side::A);
        self.playing = false;
        let pane = self.focused_mut();
        pane.cursor.slope = feature.slope;
        pane.show_slope();
        let before = pane.view;
        pane.view.look_at(egui::pos2(feature.u, feature.v), 60.0 / feature.sigma.max(1.0));
        let focus = self.focus();
        self.panes.follow_view(focus, &before);
    }

    pub fn toggle_play(&mut self) {
        self.playing = !self.playing;
        let step = play_step_of(&self.cursor_params().slopes, self.cursor().slope);
        self.play = Play { step, due: None };
    }

    /// Goes on to the next slope while slopes are played. Returns the time after which it is to be called again.
    pub(in crate::app) fn step_play(&mut self) -> Option<Duration> {
        if !self.playing {
            return None;
        }
        let now = Instant::now();
        let due = self.play.due.is_none_or(|due| now >= due);
        // The next slope waits for the pictures of this one, so that a slow machine plays slowly and skips none.
        if due && self.pictures_are_current() {
            let step = self.play.step + 1;
            let slope = played(&self.cursor_params().slopes, step);
            let pane = self.focused_mut();
            pane.cursor.slope = slope;
            pane.show_slope();
            self.play = Play { step, due: Some(now + PLAY_EVERY) };
        }
        Some(PLAY_EVERY / 4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::pane::Link;
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
        model.lead_cursors(before);
        assert_eq!(slopes(&model), [right, right, start]);

        // The cursor of another pane was there already when the focus went to it.
        let before = CursorBefore::of(&model);
        model.panes.set_focus(second);
        model.focused_mut().cursor.slope = left;
        model.lead_cursors(before);
        assert_eq!(slopes(&model), [right, left, start]);

        // Cursors that were set explicitly do not lead in this pass; in the next they do again.
        let before = CursorBefore::of(&model);
        model.focused_mut().cursor.slope = right;
        model.cursors_are_set();
        model.lead_cursors(before);
        assert_eq!(slopes(&model), [right, right, start]);
        let before = CursorBefore::of(&model);
        model.focused_mut().cursor.slope = left;
        model.lead_cursors(before);
        assert_eq!(slopes(&model), [left, left, start]);
    }
}
