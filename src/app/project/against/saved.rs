//! Comparison in a session file: the parameters of the pinned result, and the path of the opened features.

use super::{ForeignFile, Pinned, With};
use crate::app::project::Model;
use crate::detector::SearchParams;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Comparison in a session file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SavedAgainst {
    /// Reference of the comparison.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub with: Option<With>,
    /// Path of the file of other features.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Parameters of the pinned result: the detection is repeated, which gives the same bits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pinned: Option<SearchParams>,
}

impl Model {
    /// Comparison to save in a session; `None` where nothing is compared.
    pub fn saved_against(&self) -> Option<SavedAgainst> {
        let saved = SavedAgainst {
            with: self.against.with,
            file: self.against.file.as_ref().map(|file| file.path.clone()),
            pinned: self.against.pinned.as_ref().map(|pinned| pinned.asked.clone()),
        };
        (saved != SavedAgainst::default()).then_some(saved)
    }

    /// Restores the comparison of a session for the burst that was just opened. The reference is read or detected when
    /// it is needed.
    pub fn restore_against(&mut self, saved: Option<SavedAgainst>) {
        let SavedAgainst { with, file, pinned } = saved.unwrap_or_default();
        let burst = self.slots.a.burst.as_ref().map(|burst| burst.id);
        self.against.pinned = burst.zip(pinned).map(|(burst, asked)| Pinned { burst, asked, detection: None });
        self.against.file = burst.zip(file).map(|(burst, path)| ForeignFile { burst, path, features: None });
        self.against.show(None);
        self.against.show(with);
    }
}
