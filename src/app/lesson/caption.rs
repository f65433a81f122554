//! Texts in CommonMark, with links to the glossary.

use crate::teach::glossary::glossary;
use egui::Ui;
use egui_commonmark::{CommonMarkCache, CommonMarkViewer};

/// Prefix of links to the glossary.
const WORD: &str = "word:";

/// Cache of the text widget, kept between passes.
pub struct Captions {
    cache: CommonMarkCache,
}

impl Default for Captions {
    fn default() -> Self {
        let mut cache = CommonMarkCache::default();
        for word in glossary().words() {
            cache.add_link_hook(format!("{WORD}{}", word.name));
        }
        Self { cache }
    }
}

impl std::fmt::Debug for Captions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Captions").finish_non_exhaustive()
    }
}

impl Captions {
    /// Draws a text. Returns the name of the glossary entry whose link was clicked.
    pub fn ui(&mut self, ui: &mut Ui, text: &str) -> Option<String> {
        CommonMarkViewer::new().indentation_spaces(2).show(ui, &mut self.cache, text);
        let clicked = self.cache.link_hooks().iter().find(|(_, clicked)| **clicked)?.0;
        Some(clicked.strip_prefix(WORD)?.to_owned())
    }
}
