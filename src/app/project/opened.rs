//! Files from which the open bursts and other data were read: these are never overwritten.

use super::Model;
use crate::requests::BurstSource;
use std::path::{Path, PathBuf};

impl Model {
    /// All files that are open: frames of the bursts and datasets, calibration, gold standards, features of others,
    /// trajectories. Parameter and session files are not among them, because they may be saved again after changes.
    pub fn opened_files(&self) -> Vec<PathBuf> {
        let gold = self.compare.gold.iter().flatten();
        let bursts = self.slots.a.burst.iter().chain(&self.slots.b.burst).chain(gold);
        let mut files: Vec<PathBuf> = bursts.flat_map(|open| open.source.files()).collect();
        for burst in self.datasets.open.iter().flat_map(|dataset| dataset.bursts.iter()) {
            files.extend(BurstSource::Paths(burst.paths.clone()).files());
        }
        let calibration = [&self.calibration.bias, &self.calibration.flat];
        files.extend(calibration.into_iter().flatten().flat_map(|path| BurstSource::Paths(vec![path.clone()]).files()));
        files.extend(self.against.file.as_ref().map(|file| file.path.clone()));
        let trajectories = [&self.trajectories.compared.estimate, &self.trajectories.compared.truth];
        files.extend(trajectories.into_iter().flatten().flat_map(|(path, _)| files_of_model(path)));
        files
    }
}

/// A trajectory file, or the files in the folder of a sparse model.
fn files_of_model(path: &Path) -> Vec<PathBuf> {
    let inside = std::fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path());
    inside.chain([path.to_path_buf()]).collect()
}
