//! Start of a window, with its options, and the request from outside to end it, such as the signal of a system that
//! shuts down.

use super::dialogs::{FileDialogs, SystemDialogs};
use super::recovery::KeptIn;
use super::settings::Settings;
use crate::app::defaults::with_defaults;
use crate::app::document::{Action, Queue, Side, Steps};
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::requests::BurstSource;
use crate::teach::Lesson;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

with_defaults! {
    #[derive(Clone)]
    pub struct Startup {
        pub calibration: OpenOptions,
        /// Burst that is opened first; `None` opens nothing and shows how to begin.
        pub source: Option<BurstSource> = Some(BurstSource::Demo),
        pub second: Option<BurstSource>,
        pub dataset: Option<DatasetSource>,
        pub params: SearchParams,
        pub session: Option<PathBuf>,
        pub play: Option<Steps>,
        pub lesson: Option<Arc<Lesson>>,
        pub lessons: Vec<Lesson>,
        pub settings: Settings,
        /// Folder and interval of automatic saving; `None` saves nothing.
        pub kept: Option<KeptIn>,
        pub dialogs: Arc<dyn FileDialogs> = Arc::new(SystemDialogs),
        pub end: EndRequest,
    }
}

impl Startup {
    pub fn actions(&self) -> Queue {
        let mut actions = self.settings.actions();
        actions.set(&SearchParams::default(), self.params.clone(), |params| Action::SetSearch(Box::new(params)));
        actions.set(&OpenOptions::default(), self.calibration.clone(), Action::Calibrate);
        if self.session.is_none() {
            let burst = || self.source.clone().map(|source| Action::Open(Side::A, source));
            let open = self.dataset.clone().map(Action::OpenDataset).or_else(burst);
            open.into_iter().for_each(|open| actions.push(open));
        }
        self.second.iter().for_each(|source| actions.push(Action::Open(Side::B, source.clone())));
        actions
    }
}

/// The user was not asked, so nothing may be lost: the window saves its session, closes, finishes the files that it is
/// writing, and leaves the session to be offered at the next start. All clones refer to the same window.
#[derive(Debug, Clone, Default)]
pub struct EndRequest {
    is_made: Arc<AtomicBool>,
    window: Arc<OnceLock<egui::Context>>,
}

impl EndRequest {
    pub fn make(&self) {
        self.is_made.store(true, Ordering::SeqCst);
        if let Some(window) = self.window.get() {
            window.request_repaint();
        }
    }

    pub fn is_made(&self) -> bool {
        self.is_made.load(Ordering::SeqCst)
    }

    /// Sets the window that a request wakes. An earlier request is seen in the window's first pass.
    pub(super) fn wakes(&self, window: &egui::Context) {
        let _ = self.window.set(window.clone());
    }
}
