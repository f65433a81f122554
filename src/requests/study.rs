//! Studies of charts or of the open burst, single charts of a study, and the figures of the paper.

use super::error::JobError;
use super::open::OpenBurst;
use super::request::{Request, Urgency, Work};
use crate::evaluate::{ChartOfStudy, ShownChart, Study, StudyReport};
use crate::figures::{FiguresJob, FiguresReport};
use std::convert::Infallible;
use std::sync::Arc;

/// Request for a study.
#[derive(Debug, Clone)]
pub struct StudyRequest {
    /// The study.
    pub study: Study,
    /// The open burst; a study of it uses its truth, if there is one.
    pub open: Option<OpenBurst>,
}

impl Request for StudyRequest {
    type Answer = StudyReport;
    type Told = StudyReport;

    fn urgency(&self) -> Urgency {
        Urgency::Dataset
    }

    fn is_same(&self, other: &Self) -> bool {
        let open = |request: &Self| request.open.as_ref().map(|open| open.id);
        self.study == other.study && open(self) == open(other)
    }

    fn compute(self, work: &Work<'_, StudyReport>) -> Result<StudyReport, JobError> {
        let monitor = work.monitor;
        let Self { mut study, open } = self;
        if let (Study::BurstFrames(_, bursts), Some(open)) = (&mut study, open) {
            let truth = open.truth(monitor).map_err(JobError::failed)?;
            bursts.truth = truth.map(Arc::new);
        }
        Ok(study.run_telling(monitor, work.tell)?)
    }
}

impl Request for ChartOfStudy {
    type Answer = ShownChart;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Search
    }

    fn is_same(&self, other: &Self) -> bool {
        self == other
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<ShownChart, JobError> {
        Ok(self.show(work.monitor)?)
    }
}

/// The figures of the paper, written to a folder. Finished figures stay there, so that a cancelled job can be resumed.
impl Request for FiguresJob {
    type Answer = FiguresReport;
    type Told = Infallible;

    fn urgency(&self) -> Urgency {
        Urgency::Dataset
    }

    fn is_same(&self, other: &Self) -> bool {
        self == other
    }

    fn compute(self, work: &Work<'_, Infallible>) -> Result<FiguresReport, JobError> {
        Ok(self.run(&mut |_| {}, work.monitor)?)
    }
}
