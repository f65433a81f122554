//! Line and rectangle drawn on a picture, as plain values.

use crate::app::pane::PaneId;
use egui::{Pos2, Rect};

/// Effect of dragging with the first button on a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tool {
    /// Moves the picture.
    #[default]
    Pan,
    /// Draws a line.
    Line,
    /// Draws a rectangle.
    Region,
}

/// A line on a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredLine {
    /// Pane on which it was drawn.
    pub pane: PaneId,
    /// Start of the line, image pixels.
    pub from_image: Pos2,
    /// End of the line, image pixels.
    pub to_image: Pos2,
}

/// A rectangle on a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredRegion {
    /// Pane on which it was drawn.
    pub pane: PaneId,
    /// The rectangle, image pixels.
    pub rect_image: Rect,
}

/// The measured line and rectangle, the tool, and the drag in progress.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measure {
    /// The tool for dragging.
    pub tool: Tool,
    /// The line.
    pub line: Option<MeasuredLine>,
    /// The rectangle.
    pub region: Option<MeasuredRegion>,
    /// Start of the drag in progress: the pane, and the place in image pixels.
    pub drag: Option<(PaneId, Pos2)>,
}

impl Measure {
    /// Takes a tool, or puts it away again.
    pub fn toggle(&mut self, tool: Tool) {
        self.tool = if self.tool == tool { Tool::Pan } else { tool };
        self.drag = None;
    }

    /// Forgets what was drawn and puts the tool away.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Whether nothing was drawn and no tool is taken.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
