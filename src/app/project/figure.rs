//! What figures show, and how.

use crate::export::FigureOptions;
use serde::{Deserialize, Serialize};

/// What a figure shows, and how.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FigureChoice {
    /// All panes of the inspector, or the one in focus alone.
    pub all_panes: bool,
    /// The whole picture, or the part of it that can be seen.
    pub whole_picture: bool,
    /// Figure pixels for each image pixel.
    pub scale: f32,
    /// Width of strokes, figure pixels.
    pub stroke_width_px: f32,
    /// Height of letters, figure pixels.
    pub font_size_px: f32,
    /// A line above each picture.
    pub titles: bool,
    /// (a), (b), … where there are several.
    pub letters: bool,
    /// What the features' colours mean.
    pub legend: bool,
    /// What the pictures' colours mean.
    pub colour_bar: bool,
    /// A bar of known length.
    pub scale_bar: bool,
}

impl Default for FigureChoice {
    fn default() -> Self {
        Self {
            all_panes: true,
            whole_picture: false,
            scale: 2.0,
            stroke_width_px: 1.5,
            font_size_px: 14.0,
            titles: true,
            letters: true,
            legend: true,
            colour_bar: true,
            scale_bar: true,
        }
    }
}

impl FigureChoice {
    /// How the figure is drawn.
    pub fn options(&self) -> FigureOptions {
        FigureOptions {
            scale: self.scale,
            stroke_width_px: self.stroke_width_px,
            font_size_px: self.font_size_px,
            letters: self.letters,
            scale_bar: self.scale_bar,
        }
    }
}
