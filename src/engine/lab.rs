//! The Lab's workers: one makes studies, whose report grows from chart to chart, the other a single chart of a study,
//! to be looked at.

use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use crate::evaluate::{ChartOfStudy, ShownChart, StudyReport};
use crate::requests::{JobId, Running, StudyRequest};
use std::sync::Arc;
use std::time::Duration;

/// The workers.
pub struct LabWorkers {
    studies: Jobs<StudyRequest, StudyReport, StudyReport>,
    charts: Jobs<ChartOfStudy, ShownChart>,
}

impl LabWorkers {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        Self {
            studies: Jobs::telling(queue, Priority::Dataset, Duration::ZERO, StudyRequest::compute),
            charts: Jobs::new(queue, Priority::Search, Duration::ZERO, |chart: ChartOfStudy, monitor| {
                Ok(chart.show(monitor)?)
            }),
        }
    }

    /// Starts a study; the one that runs is cancelled.
    pub fn start(&self, request: StudyRequest) -> JobId {
        self.studies.submit(request)
    }

    /// Asks for a chart; the one that is being made is given up.
    pub fn show(&self, chart: ChartOfStudy) -> JobId {
        self.charts.submit(chart)
    }

    /// The newest report of a study that runs, and the answers of those that ended. Never waits.
    pub fn poll(&self) -> (Option<StudyReport>, Vec<JobAnswer<StudyReport>>) {
        let (mut reports, answers) = self.studies.take_news();
        (reports.pop(), answers)
    }

    /// The charts that were made. Never waits.
    pub fn poll_charts(&self) -> impl Iterator<Item = JobAnswer<ShownChart>> {
        self.charts.take_answers()
    }

    /// What is done of a study, if one runs.
    pub fn running(&self) -> Option<Running> {
        self.studies.running()
    }

    /// Whether a chart is being made.
    pub fn makes_chart(&self) -> bool {
        !self.charts.is_idle()
    }

    /// Cancels the study; its answer is [`JobError::Cancelled`](crate::requests::JobError::Cancelled).
    pub fn cancel(&self) {
        self.studies.cancel();
    }
}
