//! Measurements: studies of charts or the open burst, their single charts, the paper's figures, camera poses.

use super::{JobError, OpenBurst};
use crate::evaluate::poses::{PoseReport, PoseStudy, Trajectory, evaluate_poses, read_trajectory};
use crate::figures::{FiguresJob, FiguresReport};
use crate::monitor::Stage;
use crate::study::{ChartOfStudy, ShownChart, Study, StudyReport};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Debug, Clone, PartialEq)]
pub struct StudyRequest {
    pub study: Study,
    /// The open burst; a study of it uses its truth, if there is one.
    pub open: Option<OpenBurst>,
}

request! {
    StudyRequest => StudyReport; StudyReport, Dataset: |self, work| {
        let monitor = work.monitor;
        let Self { mut study, open } = self;
        // Read here and not by the asker: the truth may lie in a file, or its chart has to be made again.
        if let (Study::BurstFrames(_, bursts), Some(open)) = (&mut study, open) {
            bursts.truth = open.truth(monitor)?.map(Arc::new);
        }
        Ok(study.run_telling(monitor, work.tell)?)
    }
}

request! {
    ChartOfStudy => ShownChart: |self, work| {
        Ok(self.show(work.monitor)?)
    }
}

// The figures of the paper, written to a folder. Finished figures stay there, so that a cancelled job can be resumed.
request! {
    FiguresJob => FiguresReport, Dataset: |self, work| {
        Ok(self.run(&mut |_| {}, work.monitor)?)
    }
}

/// A trajectory by its path, with what was read there already.
#[derive(Debug, Clone)]
pub struct TrajectorySource {
    pub path: PathBuf,
    pub read: Option<Arc<Trajectory>>,
}

impl TrajectorySource {
    fn read(self) -> Result<(PathBuf, Arc<Trajectory>), JobError> {
        let read = self.read.map_or_else(|| read_trajectory(&self.path).map(Arc::new), Ok)?;
        Ok((self.path, read))
    }
}

/// Place of a trajectory among those that are compared: of the estimate, of a second one, or of the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Which {
    Estimate,
    Second,
    Truth,
}

impl Which {
    pub const ALL: [Self; 3] = [Self::Estimate, Self::Second, Self::Truth];
    pub const ESTIMATES: [Self; 2] = [Self::Estimate, Self::Second];
}

#[derive(Debug, Clone, PartialEq)]
pub struct PosesRequest {
    /// In the order of [`Which::ALL`].
    pub sources: [Option<TrajectorySource>; 3],
    pub study: PoseStudy,
}

request! {
    PosesRequest => ComparedPoses: |self, work| {
        let (monitor, mut read) = (work.monitor, [const { None }; 3]);
        for (which, source) in self.sources.into_iter().enumerate() {
            monitor.report(Stage::Open, 0.25 * which as f32);
            read[which] = source.map(TrajectorySource::read).transpose()?;
            monitor.check()?;
        }
        monitor.report(Stage::Evaluate, 0.8);
        Ok(ComparedPoses::of(read, &self.study))
    }
}

pub type ReadTrajectory = Option<(PathBuf, Arc<Trajectory>)>;

#[derive(Debug, Clone, Default)]
pub struct ComparedPoses {
    /// In the order of [`Which::ALL`].
    pub read: [ReadTrajectory; 3],
    /// Comparison of each estimate with the truth, or why it failed; `None` as long as one of the two is missing.
    pub reports: [Option<Result<Arc<PoseReport>, String>>; 2],
    /// For each true camera the index of its pair in the report of each estimate; empty without a comparison.
    pub pairs: Vec<[Option<usize>; 2]>,
}

impl ComparedPoses {
    /// Compares what was read. A comparison that fails leaves its trajectories on show, with the reason.
    pub fn of(read: [ReadTrajectory; 3], study: &PoseStudy) -> Self {
        let [first, second, truth] = read.each_ref().map(|read| read.as_ref().map(|(_, trajectory)| trajectory));
        let reports = [first, second].map(|estimate| {
            let compared = evaluate_poses(estimate?, truth?, study);
            Some(compared.map(Arc::new).map_err(|error| error.to_string()))
        });
        let mut pairs = Vec::new();
        for (of, report) in reports.iter().enumerate() {
            let Some(Ok(report)) = report else { continue };
            pairs.resize(truth.map_or(0, |truth| truth.poses.len()), [None; 2]);
            report.pairs.iter().enumerate().for_each(|(index, pair)| pairs[pair.truth][of] = Some(index));
        }
        Self { read, reports, pairs }
    }
}
