//! With what a window starts.

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

/// With what a window starts.
pub struct Startup {
    /// How bursts are opened.
    pub calibration: OpenOptions,
    /// What is opened first; `None` opens nothing and shows how to begin.
    pub source: Option<BurstSource>,
    /// What is opened beside it, as the second burst.
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
    /// What was remembered from the last time.
    pub settings: Settings,
    /// Where the session is saved by itself; `None` saves none.
    pub kept: Option<KeptIn>,
    /// Asks for files.
    pub dialogs: Arc<dyn FileDialogs>,
    /// Asks the window to end from outside.
    pub end: EndRequest,
    /// Bytes of pictures that are kept.
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
