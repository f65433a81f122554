//! Results that all requests of an engine share: pictures and trails of detections.

use super::trails::Trails;
use super::{Engine, locked};
use crate::requests::{Caches, PictureAnswer, PictureKey, PictureRequest, PictureStore};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

#[derive(Debug, Clone)]
pub(super) struct Stores {
    pub(super) pictures: Pictures,
    pub(super) trails: Trails,
}

impl Stores {
    pub(super) fn new(cache_bytes: usize) -> Self {
        let pictures = Pictures(Arc::new(Mutex::new(PictureCache::new(cache_bytes))));
        Self { pictures, trails: Trails::default() }
    }

    pub(super) fn caches(&self) -> Caches<'_> {
        Caches { trails: &self.trails, pictures: &self.pictures }
    }
}

#[derive(Debug, Clone)]
pub(super) struct Pictures(Arc<Mutex<PictureCache>>);

impl PictureStore for Pictures {
    fn get(&self, request: &PictureRequest) -> Option<PictureAnswer> {
        locked(&self.0).get(request)
    }

    fn put(&self, picture: &PictureAnswer) {
        locked(&self.0).insert(picture);
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Held {
    pub picture_bytes: usize,
    pub trails: usize,
    /// Bytes of the trails, without the open bursts.
    pub trail_bytes: usize,
    pub requests: usize,
}

impl Engine {
    /// Sets the memory for pictures that are not on show, bytes.
    pub fn set_cache_bytes(&self, bytes: usize) {
        locked(&self.stores.pictures.0).set_budget(bytes);
    }

    pub fn held(&self) -> Held {
        let (trails, trail_bytes) = self.stores.trails.held();
        Held { picture_bytes: locked(&self.stores.pictures.0).bytes(), trails, trail_bytes, requests: self.queue.len() }
    }
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
