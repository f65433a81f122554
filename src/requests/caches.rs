//! Results of earlier requests that later ones share: trails of detections, and pictures.

use super::trail::Trails;
use super::{PictureAnswer, PictureKey, PictureRequest};
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
    /// Least recently used first.
    entries: Vec<(PictureKey, PictureAnswer)>,
}

impl PictureCache {
    pub fn new(budget_bytes: usize) -> Self {
        Self { budget_bytes, entries: Vec::new() }
    }

    pub fn bytes(&self) -> usize {
        self.entries.iter().map(|(_, picture)| picture.bytes()).sum()
    }

    pub fn get(&mut self, request: &PictureRequest) -> Option<PictureAnswer> {
        let key = request.key();
        let entry = self.entries.remove(self.entries.iter().position(|(of, _)| *of == key)?);
        self.entries.push(entry.clone());
        Some(entry.1)
    }

    /// Frames are not kept: the burst holds them. Nor is a picture that exceeds the budget.
    pub fn insert(&mut self, picture: &PictureAnswer) {
        if picture.is_frame() || picture.bytes() > self.budget_bytes {
            return;
        }
        // Two requests may compute the same picture at once.
        let key = picture.request.key();
        self.entries.retain(|(of, _)| *of != key);
        self.entries.push((key, picture.clone()));
        self.set_budget(self.budget_bytes);
    }

    /// Drops pictures beyond the budget, those first that were unused for longest.
    pub fn set_budget(&mut self, budget_bytes: usize) {
        self.budget_bytes = budget_bytes;
        while self.bytes() > self.budget_bytes {
            self.entries.remove(0);
        }
    }
}
