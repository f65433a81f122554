//! Request from outside to end the window, such as the signal of a system that shuts down.
//!
//! The user was not asked, so nothing may be lost: the window saves its session, closes, finishes the files that it is
//! writing, and leaves the session to be offered at the next start.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// Request to end a window. All clones refer to the same window.
#[derive(Debug, Clone, Default)]
pub struct EndRequest(Arc<Shared>);

#[derive(Default)]
struct Shared {
    is_made: AtomicBool,
    window: OnceLock<egui::Context>,
}

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shared").field("is_made", &self.is_made).finish_non_exhaustive()
    }
}

impl EndRequest {
    /// Asks the window to end, from any thread.
    pub fn make(&self) {
        self.0.is_made.store(true, Ordering::SeqCst);
        if let Some(window) = self.0.window.get() {
            window.request_repaint();
        }
    }

    /// Whether the window was asked to end.
    pub fn is_made(&self) -> bool {
        self.0.is_made.load(Ordering::SeqCst)
    }

    /// Sets the window that a request wakes. An earlier request is seen in the window's first pass.
    pub(super) fn wakes(&self, window: &egui::Context) {
        let _ = self.0.window.set(window.clone());
    }
}
