//! Sources of what is open besides the first burst, by absolute paths.

use crate::app::project::Model;
use crate::app::project::against::SavedAgainst;
use crate::app::project::datasets::Dataset;
use crate::app::project::pair::Side;
use crate::app::project::trajectories::Trajectories;
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::evaluate::poses::Projection;
use crate::requests::BurstSource;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedDataset {
    pub source: DatasetSource,
    pub folder: Option<PathBuf>,
    pub a: Option<usize>,
    pub b: Option<usize>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedTrajectories {
    pub estimate: Option<PathBuf>,
    pub truth: Option<PathBuf>,
    #[serde(default)]
    pub projection: Projection,
}

pub(super) fn gold_source(model: &Model, side: Side) -> Option<BurstSource> {
    model.compare.gold[side as usize].as_ref().map(|gold| absolute(&gold.source))
}

pub(super) fn saved_against(model: &Model, side: Side) -> Option<SavedAgainst> {
    let saved = model.saved_against(side)?;
    Some(SavedAgainst { file: saved.file.as_deref().map(absolute_path), ..saved })
}

/// `source` with absolute paths, so that the session can be opened from any folder.
pub fn absolute(source: &BurstSource) -> BurstSource {
    match source {
        BurstSource::Demo | BurstSource::DemoLater | BurstSource::Example(_) | BurstSource::Chart(_) => source.clone(),
        BurstSource::DarkCopy { of, noise } => BurstSource::DarkCopy { of: Box::new(absolute(of)), noise: *noise },
        BurstSource::Planted { of, study, seed } => {
            BurstSource::Planted { of: Box::new(absolute(of)), study: study.clone(), seed: *seed }
        }
        BurstSource::Paths(paths) => BurstSource::Paths(paths.iter().map(|p| absolute_path(p)).collect()),
    }
}

pub(super) fn absolute_calibration(options: &OpenOptions) -> OpenOptions {
    let absolute = |path: &Option<PathBuf>| path.as_deref().map(absolute_path);
    OpenOptions { bias: absolute(&options.bias), flat: absolute(&options.flat), ..options.clone() }
}

pub(super) fn absolute_path(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

pub(super) fn saved_trajectories(trajectories: &Trajectories) -> Option<SavedTrajectories> {
    let compared = &trajectories.compared;
    let path = |read: &Option<(PathBuf, _)>| read.as_ref().map(|(path, _)| absolute_path(path));
    (!trajectories.is_empty()).then(|| SavedTrajectories {
        estimate: path(&compared.estimate),
        truth: path(&compared.truth),
        projection: trajectories.projection,
    })
}

pub(super) fn saved_dataset(dataset: &Dataset) -> SavedDataset {
    let mut source = dataset.source.clone();
    source.paths.iter_mut().for_each(|p| *p = absolute_path(p));
    let [a, b] = dataset.pair;
    SavedDataset { source, folder: dataset.folder.as_deref().map(absolute_path), a, b }
}
