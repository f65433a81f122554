//! Line and rectangle drawn on a picture, as plain values.

use crate::app::pane::PaneId;
use egui::{Pos2, Rect};

/// Effect of dragging with the first button on a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tool {
    #[default]
    Pan,
    Line,
    Region,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredLine {
    pub pane: PaneId,
    pub from_image: Pos2,
    pub to_image: Pos2,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredRegion {
    pub pane: PaneId,
    pub rect_image: Rect,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measure {
    pub tool: Tool,
    pub line: Option<MeasuredLine>,
    pub region: Option<MeasuredRegion>,
    /// Start of the drag in progress: the pane, and the place in image pixels.
    pub drag: Option<(PaneId, Pos2)>,
}

impl Measure {
    pub fn toggle(&mut self, tool: Tool) {
        self.tool = if self.tool == tool { Tool::Pan } else { tool };
        self.drag = None;
    }

    pub fn clear(&mut self) {
        *self = Self::default();
    }

    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
