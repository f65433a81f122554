//! Panels that are shown, by what is set, what is found and the width of the window, and the clock of playing.

use crate::app::{document::Visibility, document::workspace::Right, results::Read};
use std::time::Instant;

#[derive(Debug, Default)]
pub struct Play {
    pub step: usize,
    pub due: Option<Instant>,
}

pub const MIN_WIDTH_WITH_LEFT: f32 = 1100.0;

const MIN_WIDTH_WITH_BOTH: f32 = 900.0;

/// Width with room for two pictures of 450 points between both side panels.
const MIN_WIDTH_WITH_PAIR: f32 = 1500.0;

impl Read<'_> {
    pub fn shows_left(self) -> bool {
        let has_pictures = self.document.workspace.needs_burst();
        let is_wide = |width: f32| self.shell.window_width_points >= width;
        self.document.panels.left.or(!has_pictures || is_wide(MIN_WIDTH_WITH_LEFT))
            && !(has_pictures && self.shows_right() && !is_wide(MIN_WIDTH_WITH_BOTH))
    }

    /// Whether a match or a probe of two bursts takes the place of the left panel, so that no picture moves or narrows.
    pub fn match_is_left(self) -> bool {
        let is_auto = [self.document.panels.left, self.document.panels.right] == [Visibility::Auto; 2];
        self.document.workspace.shows_pair()
            && is_auto
            && (MIN_WIDTH_WITH_LEFT..MIN_WIDTH_WITH_PAIR).contains(&self.shell.window_width_points)
            && self.shows_right()
    }

    pub fn folds_left(self) -> bool {
        self.document.panels.left != Visibility::Closed && !self.shows_left() && !self.document.panels.hall
    }

    /// Whether the panel of a match would take the room of two pictures, so that it is opened on demand.
    fn is_narrow_pair(self) -> bool {
        self.document.workspace.shows_pair() && self.shell.window_width_points < MIN_WIDTH_WITH_LEFT
    }

    pub fn folds_right(self) -> bool {
        self.is_narrow_pair()
            && self.document.panels.right == Visibility::Auto
            && !self.shows_right()
            && !self.document.panels.hall
    }

    pub fn shows_right(self) -> bool {
        self.document.panels.right.or(match self.document.workspace.record().right {
            // The selection of a session waits for the session's features.
            Right::WithFeature => {
                self.document.selected.is_some() || self.results.reselect.is_some() || self.document.probe.is_open
            }
            Right::WithMatch => {
                let is_asked = self.asked_feature().is_some() && !self.is_narrow_pair();
                is_asked || self.document.probe.is_open || self.shell.window_width_points >= MIN_WIDTH_WITH_PAIR
            }
            Right::Always => true,
        })
    }

    pub fn shows_bottom(self) -> bool {
        self.document.panels.bottom.or(!self.document.workspace.probes() || self.document.compares_methods())
    }
}
