//! What an engine holds from one piece of work to the next: however much it has done, no more than its budgets.

use super::Engine;

/// What an engine holds now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Held {
    /// Bytes of pictures that are kept; never above the cache's budget.
    pub picture_bytes: usize,
    /// How many detections are kept with what they left behind.
    pub trails: usize,
    /// Bytes that these take beside the bursts that are open.
    pub trail_bytes: usize,
    /// Requests that wait or run.
    pub requests: usize,
}

impl Engine {
    /// What is held now. News that was not polled yet comes on top.
    pub fn held(&self) -> Held {
        let (trails, trail_bytes) = self.stores.trails.held();
        Held { picture_bytes: self.stores.pictures.lock().bytes(), trails, trail_bytes, requests: self.queue.len() }
    }
}
