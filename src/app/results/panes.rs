//! Panes in each pass of the window: changes of the set of panes, cursors that follow the one in focus, views, and
//! playing through the slopes.

use crate::app::document::cursor::{play_step_of, played};
use crate::app::document::panes::Visibility;
use crate::app::document::panes::{Change, Destination};
use crate::app::document::side::Side;
use crate::app::pane::Content;
use crate::app::results::Model;
use crate::detector::{Feature, Slope};
use crate::teach::Workspace;
use std::time::{Duration, Instant};

const PLAY_EVERY: Duration = Duration::from_millis(220);

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

pub const MIN_WIDTH_WITH_LEFT: f32 = 1100.0;

const MIN_WIDTH_WITH_BOTH: f32 = 900.0;

/// Width with room for two pictures of 450 points between both side panels.
const MIN_WIDTH_WITH_PAIR: f32 = 1500.0;

impl Model {
    pub fn shows_left(&self) -> bool {
        let has_pictures = matches!(self.document.workspace, Workspace::Inspect | Workspace::Pair | Workspace::Methods);
        let is_wide = |width: f32| self.window_width_points >= width;
        self.document.panels.left.or(!has_pictures || is_wide(MIN_WIDTH_WITH_LEFT))
            && !(has_pictures && self.shows_right() && !is_wide(MIN_WIDTH_WITH_BOTH))
    }

    /// Whether a match or a probe of two bursts takes the place of the panel on the left, so that no picture moves or
    /// becomes narrow.
    pub fn match_is_left(&self) -> bool {
        let is_auto = [self.document.panels.left, self.document.panels.right] == [Visibility::Auto; 2];
        let widths = MIN_WIDTH_WITH_LEFT..MIN_WIDTH_WITH_PAIR;
        self.document.workspace == Workspace::Pair
            && is_auto
            && widths.contains(&self.window_width_points)
            && self.shows_right()
    }

    pub fn folds_left(&self) -> bool {
        self.document.panels.left != Visibility::Closed && !self.shows_left() && !self.document.panels.hall
    }

    /// Whether the panel of a match would take the room of two pictures, so that it is opened on demand.
    fn is_narrow_pair(&self) -> bool {
        self.document.workspace == Workspace::Pair && self.window_width_points < MIN_WIDTH_WITH_LEFT
    }

    pub fn folds_right(&self) -> bool {
        self.is_narrow_pair()
            && self.document.panels.right == Visibility::Auto
            && !self.shows_right()
            && !self.document.panels.hall
    }

    pub fn shows_right(&self) -> bool {
        self.document.panels.right.or(match self.document.workspace {
            // That of a session comes with its features.
            Workspace::Inspect => {
                self.document.selected.is_some() || self.results.reselect.is_some() || self.document.probe.is_open
            }
            Workspace::Pair => {
                let is_asked = self.asked_feature().is_some() && !self.is_narrow_pair();
                is_asked || self.document.probe.is_open || self.window_width_points >= MIN_WIDTH_WITH_PAIR
            }
            Workspace::Methods => false,
            Workspace::Matches | Workspace::Trajectories | Workspace::Lab => true,
        })
    }

    pub fn shows_bottom(&self) -> bool {
        self.document.panels.bottom.or(!matches!(self.document.workspace, Workspace::Inspect | Workspace::Pair))
    }

    pub fn open_left(&mut self) {
        self.document.panels.left = Visibility::Open;
        if !self.shows_left() {
            self.document.panels.right = Visibility::Closed;
        }
    }

    fn shows_slice(&self) -> bool {
        let is_slice = |id| self.document.panes.get(id).is_some_and(|pane| matches!(pane.content, Content::Slice(_)));
        self.document.panes.shown().into_iter().any(is_slice)
    }

    pub fn open_probe(&mut self) {
        (self.document.probe.is_open, self.results.probed.problem) = (true, None);
        // Slices show the place themselves, and need the space.
        if self.document.panels.right == Visibility::Closed && !self.shows_slice() {
            self.document.panels.right = Visibility::Auto;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::document::cursor::slope_limit;
    use crate::app::pane::Direction;
    use crate::app::pane::Link;
    use crate::app::results::tests::open;

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

    fn model(width: f32) -> Model {
        Model { window_width_points: width, ..Model::default() }
    }

    #[test]
    fn in_a_very_narrow_window_one_side_panel_is_open_at_a_time() {
        let mut model = model(720.0);
        model.open_left();
        assert!(model.shows_left() && !model.folds_left());
        model.document.panels.right = Visibility::Auto;
        model.document.selected = Some(0);
        assert!(!model.shows_left() && model.folds_left() && model.shows_right());
        model.open_left();
        assert!(model.shows_left() && !model.shows_right());
    }
}
