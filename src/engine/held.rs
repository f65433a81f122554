//! Memory that an engine keeps from one request to the next: never more than its budgets.

use super::Engine;

/// Pictures, trails and requests that an engine holds now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Held {
    /// Bytes of pictures that are kept; never above the cache's budget.
    pub picture_bytes: usize,
    /// Number of trails of detections that are kept.
    pub trails: usize,
    /// Bytes of the trails, without the open bursts.
    pub trail_bytes: usize,
    /// Number of requests that wait or run.
    pub requests: usize,
}

impl Engine {
    /// Measures what is held now, without news that was not polled yet.
    pub fn held(&self) -> Held {
        let (trails, trail_bytes) = self.stores.trails.held();
        Held { picture_bytes: self.stores.pictures.lock().bytes(), trails, trail_bytes, requests: self.queue.len() }
    }
}
