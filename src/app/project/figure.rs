//! Figures: contents and style of those of the window, and the request for those of the paper.

use crate::app::project::{Effect, Model};
use crate::engine::{Ended, Engine};
use crate::export::{FigureAmount, FigureFormat, FigureOptions, FigureWidth};
use crate::figures::{FigureSize, FiguresJob, find_colmap};
use crate::requests::JobError;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FigureChoice {
    pub format: FigureFormat,
    pub all_panes: bool,
    pub whole_picture: bool,
    pub width: FigureWidth,
    /// In the unit of the width, as the height of letters.
    pub stroke_width: f32,
    pub font_size: f32,
    pub features: FigureAmount,
    pub matches: FigureAmount,
    pub titles: bool,
    pub letters: bool,
    pub legend: bool,
    pub colour_bar: bool,
    pub scale_bar: bool,
}

impl Default for FigureChoice {
    fn default() -> Self {
        Self {
            format: FigureFormat::Pdf,
            all_panes: true,
            whole_picture: false,
            width: FigureWidth::Millimetres(TWO_COLUMNS_MM),
            stroke_width: 0.75,
            font_size: 8.0,
            features: FigureAmount::All,
            matches: FigureAmount::All,
            titles: true,
            letters: true,
            legend: true,
            colour_bar: true,
            scale_bar: true,
        }
    }
}

/// Widths of one column and of two in journals.
pub const ONE_COLUMN_MM: f32 = 88.0;
pub const TWO_COLUMNS_MM: f32 = 181.0;

impl FigureChoice {
    pub fn options(&self) -> FigureOptions {
        FigureOptions {
            width: self.width,
            stroke_width: self.stroke_width,
            font_size: self.font_size,
            letters: self.letters,
            scale_bar: self.scale_bar,
        }
    }

    /// Choice with another width, its letters and lines in the new unit.
    #[must_use]
    pub fn with_width(self, width: FigureWidth) -> Self {
        if width.unit() == self.width.unit() {
            return Self { width, ..self };
        }
        match width {
            FigureWidth::PxPerPx(_) => Self { width, stroke_width: 1.5, font_size: 14.0, ..self },
            FigureWidth::Millimetres(_) => Self { width, stroke_width: 0.75, font_size: 8.0, ..self },
        }
    }
}

const TITLE: &str = "Figures of the paper";

impl Model {
    pub(in crate::app) fn make_figures(&mut self, out: PathBuf, engine: &Engine) {
        self.messages.resolved(TITLE);
        let job = FiguresJob { out, only: Vec::new(), size: FigureSize::Full, colmap: find_colmap() };
        self.results.figures.ask(engine, job);
    }

    pub(super) fn take_figures(&mut self, ended: Ended<FiguresJob>) -> Vec<Effect> {
        match ended.result {
            Ok(report) => {
                self.messages.resolved(TITLE);
                self.messages.note(format!("The figures are there: open {}", report.page.display()));
            }
            Err(JobError::Cancelled) => {
                self.messages.note("Figures of the paper cancelled; what is finished is kept");
            }
            Err(error) => self.messages.error(TITLE, error.to_string()),
        }
        Vec::new()
    }
}
