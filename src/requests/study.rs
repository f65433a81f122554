//! Measurements: studies of charts or the open burst, their single charts, the paper's figures, camera poses.

use super::{JobError, OpenBurst, Request, Urgency, Work};
use crate::evaluate::poses::{PoseReport, PoseStudy, Trajectory, evaluate_poses, read_trajectory};
use crate::figures::{FiguresJob, FiguresReport};
use crate::monitor::Stage;
use crate::study::{ChartOfStudy, ShownChart, Study, StudyReport};
use std::convert::Infallible;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Debug, Clone, PartialEq)]
pub struct StudyRequest {
    pub study: Study,
    /// The open burst; a study of it uses its truth, if there is one.
    pub open: Option<OpenBurst>,
}

impl Request for StudyRequest {
    type Answer = StudyReport;
    type Partial = StudyReport;
    const URGENCY: Urgency = Urgency::Dataset;

    fn compute(self, work: &Work<'_, StudyReport>) -> Result<StudyReport, JobError> {
        let monitor = work.monitor;
        let Self { mut study, open } = self;
        // Read here and not by the asker: the truth may lie in a file, or its chart has to be made again.
        if let (Study::BurstFrames(_, bursts), Some(open)) = (&mut study, open) {
            bursts.truth = open.truth(monitor)?.map(Arc::new);
        }
        Ok(study.run_telling(monitor, work.tell)?)
    }
}

impl Request for ChartOfStudy {
    type Answer = ShownChart;
    type Partial = Infallible;

    fn compute(self, work: &Work<'_, Infallible>) -> Result<ShownChart, JobError> {
        Ok(self.show(work.monitor)?)
    }
}

/// The figures of the paper, written to a folder. Finished figures stay there, so that a cancelled job can be resumed.
impl Request for FiguresJob {
    type Answer = FiguresReport;
    type Partial = Infallible;
    const URGENCY: Urgency = Urgency::Dataset;

    fn compute(self, work: &Work<'_, Infallible>) -> Result<FiguresReport, JobError> {
        Ok(self.run(&mut |_| {}, work.monitor)?)
    }
}

/// Source of a trajectory: a path, or a trajectory that was read already.
#[derive(Debug, Clone)]
pub enum TrajectorySource {
    Path(PathBuf),
    Read(PathBuf, Arc<Trajectory>),
}

impl TrajectorySource {
    pub fn path(&self) -> &PathBuf {
        match self {
            Self::Path(path) | Self::Read(path, _) => path,
        }
    }

    fn read(self) -> Result<(PathBuf, Arc<Trajectory>), JobError> {
        match self {
            Self::Path(path) => {
                let trajectory = read_trajectory(&path)?;
                Ok((path, Arc::new(trajectory)))
            }
            Self::Read(path, trajectory) => Ok((path, trajectory)),
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct PosesRequest {
    pub estimate: Option<TrajectorySource>,
    pub truth: Option<TrajectorySource>,
    pub study: PoseStudy,
}

impl Request for PosesRequest {
    type Answer = ComparedPoses;
    type Partial = Infallible;

    fn compute(self, work: &Work<'_, Infallible>) -> Result<ComparedPoses, JobError> {
        let monitor = work.monitor;
        monitor.report(Stage::Open, 0.0);
        let estimate = self.estimate.map(TrajectorySource::read).transpose()?;
        monitor.check()?;
        monitor.report(Stage::Open, 0.5);
        let truth = self.truth.map(TrajectorySource::read).transpose()?;
        monitor.check()?;
        monitor.report(Stage::Evaluate, 0.8);
        // A comparison that fails leaves both trajectories on show, with the reason.
        let report = estimate.as_ref().zip(truth.as_ref()).map(|((_, estimate), (_, truth))| {
            evaluate_poses(estimate, truth, &self.study).map(Arc::new).map_err(|e| e.to_string())
        });
        Ok(ComparedPoses { estimate, truth, report })
    }
}

#[derive(Debug, Clone, Default)]
pub struct ComparedPoses {
    pub estimate: Option<(PathBuf, Arc<Trajectory>)>,
    pub truth: Option<(PathBuf, Arc<Trajectory>)>,
    /// The comparison, or why it failed; `None` as long as a trajectory is missing.
    pub report: Option<Result<Arc<PoseReport>, String>>,
}
