//! Reading trajectories and comparing them, away from the window.

use super::Running;
use super::fault::JobError;
use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use crate::evaluate::poses::{PoseReport, PoseStudy, Trajectory, evaluate_poses, read_trajectory};
use crate::monitor::{Monitor, Stage};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// A trajectory: still a file, or read already.
#[derive(Debug, Clone)]
pub enum TrajectorySource {
    /// The folder of a sparse model or a trajectory file.
    Path(PathBuf),
    /// Read from there.
    Read(PathBuf, Arc<Trajectory>),
}

impl TrajectorySource {
    /// Where it is, or was read from.
    pub fn path(&self) -> &PathBuf {
        match self {
            Self::Path(path) | Self::Read(path, _) => path,
        }
    }

    fn read(self) -> Result<(PathBuf, Arc<Trajectory>), JobError> {
        match self {
            Self::Path(path) => match read_trajectory(&path) {
                Ok(trajectory) => Ok((path, Arc::new(trajectory))),
                Err(error) => Err(JobError::Failed(error.to_string())),
            },
            Self::Read(path, trajectory) => Ok((path, trajectory)),
        }
    }
}

/// What is to be read, and compared if both are there.
#[derive(Debug, Clone)]
pub struct PosesRequest {
    /// The estimate.
    pub estimate: Option<TrajectorySource>,
    /// The truth.
    pub truth: Option<TrajectorySource>,
    /// How they are compared.
    pub study: PoseStudy,
}

/// What was read and what came of the comparison.
#[derive(Debug, Clone, Default)]
pub struct ComparedPoses {
    /// The estimate and where it is from.
    pub estimate: Option<(PathBuf, Arc<Trajectory>)>,
    /// The truth and where it is from.
    pub truth: Option<(PathBuf, Arc<Trajectory>)>,
    /// The comparison, or why there is none; `None` as long as one of them is missing.
    pub report: Option<Result<Arc<PoseReport>, String>>,
}

/// The worker that compares trajectories.
pub struct PoseWorker {
    jobs: Jobs<PosesRequest, ComparedPoses>,
}

impl PoseWorker {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        Self { jobs: Jobs::new(queue, Priority::Search, Duration::ZERO, compare) }
    }

    /// Starts a comparison; the one that runs is dropped.
    pub fn submit(&self, request: PosesRequest) {
        self.jobs.submit(request);
    }

    /// What is being done now, if anything.
    pub fn running(&self) -> Option<Running> {
        self.jobs.running()
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        self.jobs.is_idle()
    }

    pub(super) fn poll(&self) -> impl Iterator<Item = JobAnswer<ComparedPoses>> {
        self.jobs.take_answers()
    }
}

fn compare(request: PosesRequest, monitor: &Monitor) -> Result<ComparedPoses, JobError> {
    monitor.report(Stage::Open, 0.0);
    let estimate = request.estimate.map(TrajectorySource::read).transpose()?;
    monitor.check()?;
    monitor.report(Stage::Open, 0.5);
    let truth = request.truth.map(TrajectorySource::read).transpose()?;
    monitor.check()?;
    monitor.report(Stage::Evaluate, 0.8);
    let report = match (&estimate, &truth) {
        (Some((_, estimate)), Some((_, truth))) => {
            Some(evaluate_poses(estimate, truth, &request.study).map(Arc::new).map_err(|e| e.to_string()))
        }
        _ => None,
    };
    Ok(ComparedPoses { estimate, truth, report })
}
