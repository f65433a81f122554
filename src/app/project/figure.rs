//! Figures: contents and style of those of the window, and the request for those of the paper.

use crate::app::project::{Effect, Model};
use crate::engine::{Ended, Engine};
use crate::export::FigureOptions;
use crate::figures::{FigureSize, FiguresJob, find_colmap};
use crate::requests::JobError;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FigureChoice {
    pub all_panes: bool,
    pub whole_picture: bool,
    pub scale: f32,
    pub stroke_width_px: f32,
    pub font_size_px: f32,
    pub titles: bool,
    pub letters: bool,
    pub legend: bool,
    pub colour_bar: bool,
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

const TITLE: &str = "Figures of the paper";

impl Model {
    pub(in crate::app) fn make_figures(&mut self, out: PathBuf, engine: &Engine) {
        self.messages.resolved(TITLE);
        let job = FiguresJob { out, only: Vec::new(), size: FigureSize::Full, colmap: find_colmap() };
        self.figures.ask(engine, job);
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
