//! Panes in each pass of the window: changes of the set of panes, cursors that follow the one in focus, views, and
//! playing through the slopes.

use crate::app::document::Document;
use crate::app::pane::{Direction, MethodsPreset, Pane, PaneId, Preset, SidesPreset};
use crate::app::project::Model;
use crate::app::project::cursor::{ViewKind, play_step_of, played};
use crate::app::project::side::Side;
use crate::app::view::View;
use crate::detector::{Feature, Slope};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

const PLAY_EVERY: Duration = Duration::from_millis(220);

/// Place to which a pane is moved: what is `None` stays as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Destination {
    pub slope: Option<Slope>,
    /// Octave and level.
    pub scale: Option<(i32, i32)>,
    pub frame: Option<usize>,
    pub kind: Option<ViewKind>,
    /// (u, v) in the middle of the view, image pixels, and the least zoom, points per pixel.
    pub at: Option<([f32; 2], f32)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    Split(PaneId, Direction),
    Close(PaneId),
    LayOut(PaneId, Preset),
    LayOutSides(SidesPreset),
    LayOutMethods(MethodsPreset),
}

#[derive(Debug, Default)]
pub(super) struct Play {
    step: usize,
    due: Option<Instant>,
}

impl Model {
    pub fn change_panes(&mut self, change: Change) {
        match change {
            Change::Split(id, direction) => {
                self.document.panes.split(id, direction);
            }
            Change::Close(id) => self.document.panes.close(id),
            Change::LayOut(id, preset) => {
                self.document.panes.set_focus(id);
                self.lay_out(preset);
            }
            Change::LayOutSides(preset) => self.document.panes.lay_out_sides(preset),
            Change::LayOutMethods(preset) => self.lay_out_methods(preset),
        }
    }

    pub fn go_to_selected(&mut self) {
        let Some(Feature { u, v, sigma, slope, .. }) = self.read().selected_feature().copied() else { return };
        let at = Some(([u, v], 60.0 / sigma.max(1.0)));
        self.document.go_to(Side::A, &Destination { slope: Some(slope), at, ..Destination::default() });
    }

    pub fn toggle_play(&mut self) {
        self.document.playing = !self.document.playing;
        let step = play_step_of(&self.cursor_params().slopes, self.document.cursor().slope);
        self.play = Play { step, due: None };
    }

    /// The next slope, if it is due, while slopes are played, and the time after which to ask again.
    pub(in crate::app) fn step_play(&mut self) -> Option<(Option<Slope>, Duration)> {
        if !self.document.playing {
            return None;
        }
        let now = Instant::now();
        let due = self.play.due.is_none_or(|due| now >= due);
        // The next slope waits for the pictures of this one, so that a slow machine plays slowly and skips none.
        let slope = (due && self.pictures_are_current()).then(|| {
            let step = self.play.step + 1;
            self.play = Play { step, due: Some(now + PLAY_EVERY) };
            played(&self.cursor_params().slopes, step)
        });
        Some((slope, PLAY_EVERY / 4))
    }
}

impl Document {
    /// Changes a pane. The cursors that are linked with that of the pane in focus follow it. It may leave the range of
    /// its burst, into which [`Model::check_params`] brings it.
    pub fn lead(&mut self, id: PaneId, change: impl FnOnce(&mut Pane)) {
        let Some(pane) = self.panes.get_mut(id) else { return };
        let before = pane.cursor;
        change(pane);
        if id == self.focus() {
            self.panes.follow_cursor(id, before);
        }
    }

    pub fn show_slope(&mut self, id: PaneId, slope: Slope) {
        self.lead(id, |pane| {
            pane.cursor.slope = slope;
            pane.show_slope();
        });
    }

    /// Moves the view of a pane as a canvas moved it from `before` to `after`, and those that are linked with it.
    pub fn move_view(&mut self, id: PaneId, before: &View, after: View) {
        let Some(pane) = self.panes.get_mut(id) else { return };
        let from = pane.view;
        pane.view.take(before, after);
        self.panes.follow_view(id, &from);
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

    /// Moves the pane in focus, or the first one on the burst of `side`.
    pub fn go_to(&mut self, side: Side, to: &Destination) {
        self.focus_on_side(side);
        self.playing = false;
        let focus = self.focus();
        self.lead(focus, |pane| {
            if let Some(slope) = to.slope {
                pane.cursor.slope = slope;
                pane.show_slope();
            }
            pane.cursor.frame = to.frame.unwrap_or(pane.cursor.frame);
            if let Some((octave, level)) = to.scale {
                (pane.cursor.octave, pane.cursor.level) = (octave, level);
            }
            to.kind.into_iter().for_each(|kind| pane.show(kind));
        });
        if let (Some((place, zoom)), Some(pane)) = (to.at, self.panes.get_mut(focus)) {
            let before = pane.view;
            pane.view.look_at(place.into(), zoom);
            self.panes.follow_view(focus, &before);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::pane::Link;
    use crate::app::project::cursor::slope_limit;
    use crate::app::project::tests::open;

    #[test]
    fn what_is_linked_moves_with_the_cursor_in_focus_and_nothing_else_does() {
        let mut model = Model::default();
        model.take_burst(open((64, 48), 5));
        let first = model.document.focus();
        let [second, third] =
            [Direction::Right, Direction::Right].map(|to| model.document.panes.split(first, to).expect("room"));
        model.document.panes.get_mut(third).expect("it is there").links.set(Link::Cursor, false);
        model.document.panes.set_focus(first);
        let slopes =
            |model: &Model| [first, second, third].map(|id| model.document.panes.get(id).expect("there").cursor.slope);
        let [start, ..] = slopes(&model);
        let (left, right) = (Slope::new(start.u - 1.0, start.v), Slope::new(start.u + 1.0, start.v));

        model.document.show_slope(first, right);
        assert_eq!(slopes(&model), [right, right, start]);

        // The cursor of another pane was there already when the focus went to it, and one not in focus leads none.
        model.document.panes.set_focus(second);
        model.document.show_slope(second, left);
        assert_eq!(slopes(&model), [left, left, start]);
        model.document.show_slope(first, right);
        assert_eq!(slopes(&model), [right, left, start]);

        // At the end of the range the others keep their distance to the cursor in focus.
        model.document.show_slope(second, Slope::new(100.0, 0.0));
        model.check_params();
        let limit = slope_limit(&model.results.slots.a.usable_params.slopes);
        assert_eq!(slopes(&model), [Slope::new(limit + right.u - left.u, 0.0), Slope::new(limit, 0.0), start]);
    }
}
