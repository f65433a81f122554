//! Results of earlier requests that later ones share: trails of detections, and pictures.

use super::trail::Trails;
use super::{PictureAnswer, PictureKey, PictureRequest};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Results of earlier requests; clones share them.
#[derive(Debug, Clone)]
pub struct Caches {
    pub(crate) trails: Trails,
    pub(crate) pictures: Arc<Mutex<PictureCache>>,
}

impl Caches {
    /// Caches without results, with memory for pictures that are not on show, bytes.
    pub fn new(picture_bytes: usize) -> Self {
        Self { trails: Trails::default(), pictures: Arc::new(Mutex::new(PictureCache::new(picture_bytes))) }
    }
}

/// Changes of what threads share are whole values, and work runs outside the locks with its panics caught: the data are
/// valid even if the lock is poisoned.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Debug)]
pub struct PictureCache {
    budget_bytes: usize,
    bytes: usize,
    clock: u64,
    entries: HashMap<PictureKey, (PictureAnswer, u64)>,
}

impl PictureCache {
    pub fn new(budget_bytes: usize) -> Self {
        Self { budget_bytes, bytes: 0, clock: 0, entries: HashMap::new() }
    }

    pub fn bytes(&self) -> usize {
        self.bytes
    }

    pub fn get(&mut self, request: &PictureRequest) -> Option<PictureAnswer> {
        self.clock += 1;
        let (picture, used) = self.entries.get_mut(&request.key())?;
        *used = self.clock;
        Some(picture.clone())
    }

    /// Frames are not kept: the burst holds them. Nor is a picture that exceeds the budget.
    pub fn insert(&mut self, picture: &PictureAnswer) {
        let size = picture.bytes();
        if picture.is_frame() || size > self.budget_bytes {
            return;
        }
        self.clock += 1;
        // Two requests may compute the same picture at once.
        if let Some((old, _)) = self.entries.insert(picture.request.key(), (picture.clone(), self.clock)) {
            self.bytes -= old.bytes();
        }
        self.bytes += size;
        self.set_budget(self.budget_bytes);
    }

    /// Drops pictures beyond the budget, those first that were unused for longest.
    pub fn set_budget(&mut self, budget_bytes: usize) {
        self.budget_bytes = budget_bytes;
        while self.bytes > self.budget_bytes {
            let oldest = self.entries.iter().min_by_key(|(_, (_, used))| *used).map(|(key, _)| *key);
            let Some((old, _)) = oldest.and_then(|key| self.entries.remove(&key)) else { break };
            self.bytes -= old.bytes();
        }
    }
}
