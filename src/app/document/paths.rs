//! Absolute paths: documents and lists of actions can be opened from any folder.

use super::Action;
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::requests::BurstSource;
use std::path::PathBuf;

pub fn make_absolute(path: &mut PathBuf) {
    if let Ok(absolute) = std::path::absolute(&*path) {
        *path = absolute;
    }
}

impl Action {
    #[must_use]
    pub fn with_absolute_paths(mut self) -> Self {
        match &mut self {
            Self::Open(_, source) | Self::OpenGold(_, source) => *source = absolute(source),
            Self::OpenDataset(DatasetSource { paths, .. }) => paths.iter_mut().for_each(make_absolute),
            Self::UseFeatureFolder(path) | Self::OpenFeatures(_, path) | Self::OpenTrajectory(_, path) => {
                make_absolute(path);
            }
            Self::Calibrate(OpenOptions { bias, flat, .. }) => bias.iter_mut().chain(flat).for_each(make_absolute),
            _ => {}
        }
        self
    }
}

pub fn absolute(source: &BurstSource) -> BurstSource {
    let mut source = source.clone();
    let mut inner = &mut source;
    while let BurstSource::DarkCopy { of, .. } | BurstSource::Planted { of, .. } = inner {
        inner = of;
    }
    if let BurstSource::Paths(paths) = inner {
        paths.iter_mut().for_each(make_absolute);
    }
    source
}
