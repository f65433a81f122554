//! The figures of the paper: asked for from the Help menu, and what is said when they are there.

use crate::app::window::BurstscopeApp;
use crate::figures::{FigureSize, FiguresJob, find_colmap};
use crate::requests::{JobError, Running};
use std::path::PathBuf;

/// What messages are about.
const TITLE: &str = "Figures of the paper";

impl BurstscopeApp {
    /// Remakes the figures of the paper in the folder `out`, in the background, as the command `figures` does it.
    pub(in crate::app) fn make_figures(&mut self, out: PathBuf) {
        self.model.messages.resolved(TITLE);
        let job = FiguresJob { out, only: Vec::new(), size: FigureSize::Full, colmap: find_colmap() };
        self.engine.figures.start(job);
    }

    /// Takes what the worker published, and answers what it does now.
    pub(in crate::app) fn take_figures(&mut self) -> Option<Running> {
        for answer in self.engine.figures.poll() {
            match answer.result {
                Ok(report) => {
                    self.model.messages.resolved(TITLE);
                    self.model.messages.note(format!("The figures are there: open {}", report.page.display()));
                }
                Err(JobError::Cancelled) => {
                    self.model.messages.note("Figures of the paper cancelled; what is finished is kept");
                }
                Err(JobError::Superseded) => {}
                Err(error) => self.model.messages.error(TITLE, error.to_string()),
            }
        }
        self.engine.figures.running()
    }
}
