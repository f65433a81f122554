//! Settings that the window remembers from one start to the next.

use super::actions::ActionId;
use super::lesson::Progress;
use crate::app::defaults::with_defaults;
use crate::app::document::{Action, Document, FigureChoice, MatchLook, Panels, Purpose, Queue};
use crate::app::pane::PaneLinks;
use crate::dataset::DatasetSource;
use crate::engine::DEFAULT_CACHE_BYTES;
use crate::requests::BurstSource;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

pub const STORAGE_KEY: &str = "burstscope settings";

pub const MAX_RECENT: usize = 12;

with_defaults! {
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct Settings {
        pub recent: Vec<BurstSource>,
        pub datasets: Vec<DatasetSource>,
        pub burst_length: usize = 10,
        /// Memory of pictures kept for scrubbing, MB (2²⁰ bytes).
        pub cache_mb: usize = DEFAULT_CACHE_BYTES >> 20,
        pub theme: egui::ThemePreference = egui::ThemePreference::Dark,
        pub panels: Panels,
        pub auto_detect: bool = true,
        pub links: PaneLinks,
        pub match_look: MatchLook,
        pub figure: FigureChoice,
        pub lessons: BTreeMap<String, Progress>,
    }
}

impl Settings {
    /// Limits of the memory for pictures, MB.
    pub const CACHE_MB: std::ops::RangeInclusive<usize> = 16..=16_384;

    pub fn cache_bytes(&self) -> usize {
        self.cache_mb.clamp(*Self::CACHE_MB.start(), *Self::CACHE_MB.end()) << 20
    }

    /// Reads the stored settings; an unreadable value becomes the default.
    pub fn load(storage: &dyn eframe::Storage) -> Self {
        storage.get_string(STORAGE_KEY).and_then(|text| toml::from_str(&text).ok()).unwrap_or_default()
    }

    pub fn store(&self, storage: &mut dyn eframe::Storage) {
        if let Ok(text) = toml::to_string(self) {
            storage.set_string(STORAGE_KEY, text);
        }
    }

    /// Puts `source` at the top of the recent list. The demo has a menu item of its own.
    pub fn remember(&mut self, source: &BurstSource) {
        if matches!(source, BurstSource::Paths(_)) {
            put_first(&mut self.recent, source);
        }
    }

    /// Paths that were opened for such a purpose, the last one first.
    pub fn recent_paths(&self, purpose: Purpose) -> Vec<String> {
        let one = |paths: &[PathBuf]| if let [path] = paths { Some(path.display().to_string()) } else { None };
        match purpose {
            Purpose::OpenDataset => self.datasets.iter().filter_map(|source| one(&source.paths)).collect(),
            _ if purpose.opens_burst() => self.recent.iter().filter_map(|source| one(source.paths())).collect(),
            _ => Vec::new(),
        }
    }

    pub fn remember_dataset(&mut self, source: &DatasetSource) {
        put_first(&mut self.datasets, source);
        self.burst_length = source.burst_length.unwrap_or(self.burst_length);
    }

    pub fn actions(&self) -> Queue {
        let (mut actions, plain) = (Queue::default(), Self::default());
        actions.set(&plain.panels, self.panels, Action::SetPanels);
        actions.set(&plain.figure, self.figure, Action::SetFigure);
        actions.set(&plain.match_look, self.match_look.sanitised(), Action::SetMatchLook);
        actions.set(&plain.links, self.links, Action::SetPairLinks);
        let theme = match self.theme {
            egui::ThemePreference::System => ActionId::ThemeSystem,
            egui::ThemePreference::Light => ActionId::ThemeLight,
            egui::ThemePreference::Dark => ActionId::ThemeDark,
        };
        actions.set(&plain.theme, self.theme, |_| theme.into());
        actions.set(&plain.auto_detect, self.auto_detect, |_| ActionId::AutoDetect.into());
        actions
    }

    pub fn take_from(&mut self, document: &Document) {
        (self.theme, self.panels, self.auto_detect) = (document.theme, document.panels, document.auto_detect);
        (self.links, self.match_look, self.figure) = (document.pair_links(), document.match_look, document.figure);
    }
}

fn put_first<T: Clone + PartialEq>(list: &mut Vec<T>, item: &T) {
    list.retain(|other| other != item);
    list.insert(0, item.clone());
    list.truncate(MAX_RECENT);
}
