//! A study of charts, or of the burst that is open.

use super::error::JobError;
use super::open::OpenBurst;
use crate::evaluate::{Study, StudyReport};
use crate::monitor::Monitor;
use std::sync::Arc;

/// What is to be studied.
#[derive(Debug, Clone)]
pub struct StudyRequest {
    /// The study.
    pub study: Study,
    /// The burst that is open: of a study of it, the truth is looked for.
    pub open: Option<OpenBurst>,
}

impl StudyRequest {
    /// Makes the study. `tell` hears of the report as it grows from chart to chart.
    ///
    /// # Errors
    /// [`JobError::Failed`] for a study that makes no sense, or a truth that cannot be read; [`JobError::Cancelled`].
    pub fn compute(self, tell: &(dyn Fn(StudyReport) + Sync), monitor: &Monitor) -> Result<StudyReport, JobError> {
        let Self { mut study, open } = self;
        if let (Study::BurstFrames(_, bursts), Some(open)) = (&mut study, open) {
            let truth = open.truth(monitor).map_err(JobError::failed)?;
            bursts.truth = truth.map(Arc::new);
        }
        Ok(study.run_telling(monitor, tell)?)
    }
}
