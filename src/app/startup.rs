//! Options with which a window starts.

use super::dialogs::{FileDialogs, SystemDialogs};
use super::ending::EndRequest;
use super::recovery::KeptIn;
use super::settings::Settings;
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::requests::BurstSource;
use crate::teach::Lesson;
use std::path::PathBuf;
use std::sync::Arc;

/// Options with which a window starts.
pub struct Startup {
    /// Options with which bursts are opened.
    pub calibration: OpenOptions,
    /// Burst that is opened first; `None` opens nothing and shows how to begin.
    pub source: Option<BurstSource>,
    /// Second burst, opened beside the first.
    pub second: Option<BurstSource>,
    /// A dataset that is opened instead.
    pub dataset: Option<DatasetSource>,
    /// The detector's parameters, and how the slopes are chosen.
    pub params: SearchParams,
    /// A session file that is restored instead.
    pub session: Option<PathBuf>,
    /// The lesson that is begun.
    pub lesson: Option<Arc<Lesson>>,
    /// Lessons beside those that are built in.
    pub lessons: Vec<Lesson>,
    /// Settings remembered from earlier runs.
    pub settings: Settings,
    /// Folder and interval of automatic saving; `None` saves nothing.
    pub kept: Option<KeptIn>,
    /// Dialogs that ask for files.
    pub dialogs: Arc<dyn FileDialogs>,
    /// Request from outside to end the window.
    pub end: EndRequest,
    /// Size of the cache of pictures, bytes.
    pub cache_bytes: usize,
}

impl Default for Startup {
    fn default() -> Self {
        Self {
            source: Some(BurstSource::Demo),
            second: None,
            dataset: None,
            params: SearchParams::default(),
            calibration: OpenOptions::default(),
            session: None,
            lesson: None,
            lessons: Vec::new(),
            settings: Settings::default(),
            kept: None,
            dialogs: Arc::new(SystemDialogs),
            end: EndRequest::default(),
            cache_bytes: crate::engine::DEFAULT_CACHE_BYTES,
        }
    }
}
