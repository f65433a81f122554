//! Settings that the window remembers from one start to the next.

use super::actions::ActionId;
use super::document::{Action, Queue};
use super::lesson::Progress;
use crate::app::project::figure::FigureChoice;
use crate::app::project::pair::{Links, MatchLook};
use crate::app::project::{Model, Panels};
use crate::dataset::DatasetSource;
use crate::requests::BurstSource;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub const STORAGE_KEY: &str = "burstscope settings";

const MAX_RECENT: usize = 12;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    pub recent: Vec<BurstSource>,
    pub datasets: Vec<DatasetSource>,
    pub burst_length: usize,
    pub theme: egui::ThemePreference,
    pub panels: Panels,
    pub auto_detect: bool,
    pub links: Links,
    pub match_look: MatchLook,
    pub figure: FigureChoice,
    pub lessons: BTreeMap<String, Progress>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            recent: Vec::new(),
            datasets: Vec::new(),
            burst_length: 10,
            theme: egui::ThemePreference::Dark,
            panels: Panels::default(),
            auto_detect: true,
            links: Links::default(),
            match_look: MatchLook::default(),
            figure: FigureChoice::default(),
            lessons: BTreeMap::new(),
        }
    }
}

impl Settings {
    /// Reads what was stored; anything that cannot be read has its default.
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

    pub fn remember_dataset(&mut self, source: &DatasetSource) {
        put_first(&mut self.datasets, source);
        self.burst_length = source.burst_length.unwrap_or(self.burst_length);
    }

    /// What makes a window of the defaults one of these.
    pub fn actions(&self) -> Vec<Action> {
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
        actions.into_iter().collect()
    }

    pub fn take_from(&mut self, model: &Model) {
        (self.theme, self.panels, self.auto_detect) = (model.theme, model.panels, model.auto_detect);
        (self.links, self.match_look) = (model.pair_links(), model.match_look);
        self.figure = model.figure;
    }
}

fn put_first<T: Clone + PartialEq>(list: &mut Vec<T>, item: &T) {
    list.retain(|other| other != item);
    list.insert(0, item.clone());
    list.truncate(MAX_RECENT);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[derive(Default)]
    struct Memory(HashMap<String, String>);

    impl eframe::Storage for Memory {
        fn get_string(&self, key: &str) -> Option<String> {
            self.0.get(key).cloned()
        }
        fn set_string(&mut self, key: &str, value: String) {
            self.0.insert(key.to_owned(), value);
        }
        fn remove_string(&mut self, key: &str) {
            self.0.remove(key);
        }
        fn flush(&mut self) {}
    }

    #[test]
    fn settings_come_back_and_rubbish_gives_defaults() {
        let mut memory = Memory::default();
        let mut settings = Settings { auto_detect: false, ..Settings::default() };
        settings.remember(&BurstSource::Paths(vec!["/a".into()]));
        settings.store(&mut memory);
        assert_eq!(Settings::load(&memory), settings);
        memory.0.insert(STORAGE_KEY.to_owned(), "[[[".to_owned());
        assert_eq!(Settings::load(&memory), Settings::default());
    }

    #[test]
    fn the_recent_list_has_each_burst_once_the_latest_first() {
        let source = |i: usize| BurstSource::Paths(vec![format!("/burst{i}").into()]);
        let mut settings = Settings::default();
        for i in 0..20 {
            settings.remember(&source(i));
        }
        settings.remember(&source(15));
        settings.remember(&BurstSource::Demo);
        assert_eq!(settings.recent.len(), MAX_RECENT);
        assert_eq!((&settings.recent[0], &settings.recent[1]), (&source(15), &source(19)));
    }
}
