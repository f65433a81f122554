//! Export of the open dataset for COLMAP: the request, and the message when it is written.

use crate::app::project::datasets::Work;
use crate::app::window::BurstscopeApp;
use crate::inspect::words::counted;
use crate::requests::{ColmapDone, ColmapRequest, DatasetRequest};
use std::path::PathBuf;

impl BurstscopeApp {
    /// Writes the files that COLMAP's mapper reads to the folder `out`, with the present parameters.
    pub(in crate::app) fn export_database(&mut self, out: PathBuf) {
        let Some(dataset) = &self.model.datasets.open else { return };
        let request = ColmapRequest {
            out,
            params: self.model.asked(),
            open: self.model.calibration.clone(),
            matching: self.model.pair.params.clone(),
            pairs: self.model.datasets.choice.selection(),
        };
        let bursts = dataset.bursts.clone();
        self.model.datasets.work = Some(Work::Exporting);
        self.model.messages.resolved(Work::Exporting.title());
        self.model.datasets.wanted.ask(&self.engine, DatasetRequest::Colmap { bursts, request: Box::new(request) });
    }

    /// Shows a message that says which files were written and which bursts were left out.
    pub(in crate::app) fn say_what_was_exported(&mut self, done: &ColmapDone) {
        let report = &done.report;
        let verified = report.pairs.iter().filter(|pair| pair.counts.inliers.is_some_and(|n| n > 0)).count();
        self.model.messages.resolved(Work::Exporting.title());
        self.model.messages.note(format!(
            "Wrote {}: {}, {}, {verified} of them verified",
            report.database.display(),
            counted(report.images.len(), "image"),
            counted(report.pairs.len(), "pair"),
        ));
        if let Some((name, why)) = done.left_out.first() {
            let others = match done.left_out.len() - 1 {
                0 => String::new(),
                more => format!(" (and {} more)", counted(more, "burst")),
            };
            self.model.messages.error(Work::Exporting.title(), format!("{name} was left out{others}: {why}"));
        }
    }
}
