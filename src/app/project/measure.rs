//! A line and a rectangle that were drawn on a picture, as plain values.

use crate::app::pane::PaneId;
use egui::{Pos2, Rect};

/// What dragging with the first button does on a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tool {
    /// It moves the picture.
    #[default]
    Pan,
    /// It draws a line.
    Line,
    /// It draws a rectangle.
    Region,
}

/// A line on a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredLine {
    /// On which pane it was drawn.
    pub pane: PaneId,
    /// Its beginning, image pixels.
    pub from_image: Pos2,
    /// Its end, image pixels.
    pub to_image: Pos2,
}

/// A rectangle on a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredRegion {
    /// On which pane it was drawn.
    pub pane: PaneId,
    /// The rectangle, image pixels.
    pub rect_image: Rect,
}

/// What was drawn, and what is being drawn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measure {
    /// What dragging does.
    pub tool: Tool,
    /// The line.
    pub line: Option<MeasuredLine>,
    /// The rectangle.
    pub region: Option<MeasuredRegion>,
    /// Where the drag that goes on began: the pane, and the place in its image.
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
