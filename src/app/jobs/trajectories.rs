//! What the window asks the engine to do with two trajectories, and what it does with the answers.

use crate::app::project::trajectories::Which;
use crate::app::project::workspace::Workspace;
use crate::app::session::SavedTrajectories;
use crate::app::window::BurstscopeApp;
use crate::engine::JobAnswer;
use crate::requests::{ComparedPoses, PosesRequest, TrajectorySource};
use std::path::PathBuf;

impl BurstscopeApp {
    /// Reads a trajectory in the background, and compares it with the other one if that is there.
    pub fn open_trajectory(&mut self, which: Which, path: PathBuf) {
        self.engine.poses.submit(self.model.trajectories.request_with(which, path));
        self.model.workspace = Workspace::Trajectories;
    }

    /// Compares the trajectories that are open as the study now says.
    pub(in crate::app) fn compare_again(&self) {
        self.engine.poses.submit(self.model.trajectories.request());
    }

    pub(in crate::app) fn take_compared(&mut self, answer: JobAnswer<ComparedPoses>) {
        const TITLE: &str = "Trajectories";
        if answer.is_superseded() {
            return;
        }
        match answer.result {
            Ok(compared) => {
                self.model.messages.resolved(TITLE);
                self.model.trajectories.take(compared);
            }
            Err(error) => {
                self.model.trajectories.fail();
                self.model.messages.error(TITLE, error.to_string());
            }
        }
    }

    /// Opens the trajectories of a session, or none.
    pub(in crate::app) fn restore_trajectories(&mut self, saved: Option<SavedTrajectories>) {
        self.model.trajectories.clear();
        if let Some(SavedTrajectories { estimate, truth, projection }) = saved {
            self.model.trajectories.projection = projection;
            let study = self.model.trajectories.study;
            let (estimate, truth) = (estimate.map(TrajectorySource::Path), truth.map(TrajectorySource::Path));
            self.engine.poses.submit(PosesRequest { estimate, truth, study });
        }
    }
}
