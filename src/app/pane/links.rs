//! Links between panes: a pane with a link moves, and is moved by, every other pane with that link.

use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Link {
    View,
    Display,
    /// Frame, slope, octave and level: they move by equal steps, so that differences between panes stay.
    Cursor,
    Place,
}

impl Link {
    pub const ALL: [Self; 4] = [Self::View, Self::Display, Self::Cursor, Self::Place];

    pub fn label(self) -> &'static str {
        match self {
            Self::View => "Link view",
            Self::Display => "Link display",
            Self::Cursor => "Link cursor",
            Self::Place => "Link place",
        }
    }

    pub fn word(self) -> &'static str {
        match self {
            Self::View => "View",
            Self::Display => "Display",
            Self::Cursor => "Cursor",
            Self::Place => "Place",
        }
    }

    pub fn letter(self) -> &'static str {
        &self.word()[..1]
    }

    pub fn help(self) -> &'static str {
        match self {
            Self::View => "Zoom and pan together with the other panes that have this link",
            Self::Display => "Share the value range and the colour map; without it this pane has its own",
            Self::Cursor => {
                "Move frame, slope, octave and level together, by the same steps; other bursts and methods also change the kind of picture"
            }
            Self::Place => "Mark the place under the pointer, moved along the slope in frames, with its value",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct PaneLinks {
    pub view: bool,
    pub display: bool,
    pub cursor: bool,
    pub place: bool,
}

impl Default for PaneLinks {
    fn default() -> Self {
        Self { view: true, display: true, cursor: true, place: true }
    }
}

impl PaneLinks {
    fn field(&mut self, link: Link) -> &mut bool {
        match link {
            Link::View => &mut self.view,
            Link::Display => &mut self.display,
            Link::Cursor => &mut self.cursor,
            Link::Place => &mut self.place,
        }
    }

    pub fn has(mut self, link: Link) -> bool {
        *self.field(link)
    }

    pub fn set(&mut self, link: Link, on: bool) {
        *self.field(link) = on;
    }
}
