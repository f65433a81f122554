//! Results that all requests of an engine share: pictures and trails of detections.

use super::Engine;
use super::cache::PictureCache;
use super::trails::Trails;
use crate::requests::{Caches, Picture, PictureRequest, PictureStore};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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

impl Pictures {
    pub(super) fn lock(&self) -> MutexGuard<'_, PictureCache> {
        // Each change is one whole value, so the data are valid even if the lock is poisoned.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl PictureStore for Pictures {
    fn get(&self, request: &PictureRequest) -> Option<Picture> {
        self.lock().get(request)
    }

    fn put(&self, picture: &Picture) {
        self.lock().insert(picture);
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
    /// Sets the memory that pictures may take which are not on show, bytes.
    pub fn set_cache_bytes(&self, bytes: usize) {
        self.stores.pictures.lock().set_budget(bytes);
    }

    pub fn held(&self) -> Held {
        let (trails, trail_bytes) = self.stores.trails.held();
        Held { picture_bytes: self.stores.pictures.lock().bytes(), trails, trail_bytes, requests: self.queue.len() }
    }
}
