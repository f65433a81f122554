//! Line, rectangle and outlines drawn on a picture, as plain values.

use crate::app::pane::PaneId;
use egui::{Pos2, Rect};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Tool {
    #[default]
    Pan,
    Line,
    Region,
    /// Outlines of what the frames do not show.
    Mask,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeasuredLine {
    pub pane: PaneId,
    pub from_image: Pos2,
    pub to_image: Pos2,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeasuredRegion {
    pub pane: PaneId,
    pub rect_image: Rect,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Measure {
    pub tool: Tool,
    pub line: Option<MeasuredLine>,
    pub region: Option<MeasuredRegion>,
    pub drag: Option<(PaneId, Pos2)>,
    /// Closed outlines around what the frames do not show, image pixels; the last one is being drawn during a drag.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hidden: Vec<Vec<Pos2>>,
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
