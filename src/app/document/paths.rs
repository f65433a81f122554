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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::document::{Document, Journal};
    use crate::app::project::datasets::DatasetChoice;
    use crate::app::project::side::Side;
    use crate::app::project::trajectories::Which;

    #[test]
    fn what_was_done_and_what_is_set_name_files_from_any_folder() {
        let file = || PathBuf::from("here");
        let source = || BurstSource::Paths(vec![file()]);
        let actions = [
            Action::Open(Side::A, source()),
            Action::OpenGold(Side::B, BurstSource::DarkCopy { of: Box::new(source()), noise: Default::default() }),
            Action::OpenDataset(DatasetSource::of_bursts(vec![file()])),
            Action::UseFeatureFolder(file()),
            Action::OpenFeatures(Side::A, file()),
            Action::OpenTrajectory(Which::Truth, file()),
            Action::Calibrate(OpenOptions { bias: Some(file()), flat: Some(file()), ..OpenOptions::default() }),
        ];
        let here = std::path::absolute("here").expect("a folder").display().to_string();
        for action in actions {
            let mut journal = Journal::default();
            journal.take(&action, false);
            assert!(journal.to_toml().contains(&here), "{action:?}");
        }
        let mut document = Document { gold: Default::default(), ..Document::of_new_window() };
        document.gold.b = Some(source());
        (document.comparisons.a.file, document.trajectories.truth) = (Some(file()), Some(file()));
        let dataset = DatasetSource::of_bursts(vec![file()]);
        document.dataset = Some(DatasetChoice { source: dataset, folder: Some(file()), pair: Default::default() });
        let text = toml::to_string(&document.with_absolute_paths()).expect("plain values");
        assert_eq!(text.matches(&here).count(), 5, "{text}");
    }
}
