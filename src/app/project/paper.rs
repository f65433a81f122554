//! The figures of the paper, requested from the Help menu.

use crate::app::project::Model;
use crate::engine::Engine;
use crate::figures::{FigureSize, FiguresJob, find_colmap};
use crate::requests::JobError;
use std::path::PathBuf;

const TITLE: &str = "Figures of the paper";

impl Model {
    /// Requests all figures of the paper, written into the folder `out`.
    pub(in crate::app) fn make_figures(&mut self, out: PathBuf, engine: &Engine) {
        self.messages.resolved(TITLE);
        let job = FiguresJob { out, only: Vec::new(), size: FigureSize::Full, colmap: find_colmap() };
        self.figures.ask(engine, job);
    }

    /// Takes the result: a message says where the figures are, or why there are none.
    pub(in crate::app) fn take_figures(&mut self) {
        for ended in self.figures.take() {
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
        }
    }
}
