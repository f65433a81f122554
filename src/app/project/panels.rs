//! Parts of the window that are open. At the first start the picture has most of the window: the panel on the right
//! comes with a selection or a probe. A panel that the user opens or closes stays so.

use super::Model;
use super::workspace::Workspace;
use crate::app::pane::Content;
use serde::{Deserialize, Serialize};

pub const MIN_WIDTH_WITH_LEFT: f32 = 1100.0;

const MIN_WIDTH_WITH_BOTH: f32 = 900.0;

/// Width with room for two pictures of 450 points between both side panels.
const MIN_WIDTH_WITH_PAIR: f32 = 1500.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Visibility {
    /// Where there is room and something to show in it.
    #[default]
    Auto,
    Open,
    /// Only where something is asked of it.
    Closed,
}

impl Visibility {
    /// Whether the panel is shown if `auto` says so for [`Visibility::Auto`].
    fn or(self, auto: bool) -> bool {
        match self {
            Self::Auto => auto,
            Self::Open => true,
            Self::Closed => false,
        }
    }
}

impl From<bool> for Visibility {
    fn from(is_open: bool) -> Self {
        if is_open { Self::Open } else { Self::Closed }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Panels {
    /// Cursor and parameters; by itself where the window is wide enough.
    pub left: Visibility,
    /// Display, selection and probe; by itself with a selection or a probe.
    pub right: Visibility,
    /// Table, tally and measurements; by itself in workspaces other than *One burst* and *Two bursts*.
    pub bottom: Visibility,
    pub filmstrip: bool,
    pub advanced: bool,
    pub welcome: bool,
    /// A lesson is shown to a hall: large pictures, large letters, and only the panels that a step points at.
    pub hall: bool,
}

impl Default for Panels {
    fn default() -> Self {
        let auto = Visibility::Auto;
        Self { left: auto, right: auto, bottom: auto, filmstrip: true, advanced: false, welcome: true, hall: false }
    }
}

impl Panels {
    pub fn all() -> Self {
        let open = Visibility::Open;
        Self { left: open, right: open, bottom: open, filmstrip: true, advanced: true, welcome: false, hall: false }
    }
}

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
