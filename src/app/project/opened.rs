//! Files from which the open bursts and other data were read: these are never overwritten.

use super::Model;
use crate::burst;
use crate::requests::BurstSource;
use std::path::{Path, PathBuf};

impl Model {
    /// All files that are open: frames of the bursts and datasets, calibration, gold standards, features of others,
    /// trajectories. Parameter and session files are not among them, because they may be saved again after changes.
    pub fn opened_files(&self) -> Vec<PathBuf> {
        let gold = self.compare.gold.iter().flatten();
        let bursts = self.slots.both().into_iter().flat_map(|slot| &slot.burst).chain(gold);
        let mut files: Vec<PathBuf> = bursts.flat_map(|open| files_of(&open.source)).collect();
        for burst in self.datasets.open.iter().flat_map(|dataset| dataset.bursts.iter()) {
            files.extend(files_at(burst.paths.clone()));
        }
        let calibration = [&self.calibration.bias, &self.calibration.flat];
        files.extend(calibration.into_iter().flatten().flat_map(|path| files_at(vec![path.clone()])));
        let others = self.slots.both().into_iter().filter_map(|slot| slot.against.file.as_ref());
        files.extend(others.map(|file| file.path.clone()));
        let trajectories = [&self.trajectories.compared.estimate, &self.trajectories.compared.truth];
        files.extend(trajectories.into_iter().flatten().flat_map(|(path, _)| files_of_model(path)));
        files
    }
}

fn files_of(source: &BurstSource) -> Vec<PathBuf> {
    match source {
        BurstSource::Paths(paths) => files_at(paths.clone()),
        BurstSource::DarkCopy { of, .. } => files_of(of),
        BurstSource::Demo | BurstSource::DemoLater | BurstSource::Example(_) | BurstSource::Chart(_) => Vec::new(),
    }
}

fn files_at(paths: Vec<PathBuf>) -> Vec<PathBuf> {
    let source = burst::BurstSource { name: String::new(), paths };
    source.files().unwrap_or(source.paths)
}

/// A trajectory file, or the files in the folder of a sparse model.
fn files_of_model(path: &Path) -> Vec<PathBuf> {
    let inside = std::fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path());
    inside.chain([path.to_path_buf()]).collect()
}
