//! A lane that makes pictures and keeps them: what is still in the cache is answered at once.

use super::cache::PictureCache;
use super::fault::JobError;
use super::lane::{JobId, Lane};
use super::picture::{Picture, PictureRequest};
use super::{OnUpdate, PICTURE_GRACE};
use crate::monitor::Monitor;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The cache that all lanes of an engine share. Cheap to clone.
#[derive(Debug, Clone)]
pub(super) struct SharedCache(Arc<Mutex<PictureCache>>);

impl SharedCache {
    pub(super) fn new(budget_bytes: usize) -> Self {
        Self(Arc::new(Mutex::new(PictureCache::new(budget_bytes))))
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, PictureCache> {
        // Whole values go in and out, so a poisoned lock still guards whole values.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The picture from the cache, or made now and kept.
    pub(super) fn get_or_make(&self, request: &PictureRequest, monitor: &Monitor) -> Result<Picture, JobError> {
        if let Some(picture) = self.lock().get(request) {
            return Ok(picture);
        }
        let picture = request.compute(monitor)?;
        self.lock().insert(&picture);
        Ok(picture)
    }
}

/// One picture at a time, the latest that was asked for.
pub(super) struct PictureLane {
    pub(super) lane: Lane<PictureRequest, Picture>,
    cache: SharedCache,
}

impl PictureLane {
    pub(super) fn new(name: &str, cache: &SharedCache, on_update: OnUpdate) -> Self {
        let its = cache.clone();
        let lane = Lane::new(name, PICTURE_GRACE, on_update, move |request: PictureRequest, monitor| {
            its.get_or_make(&request, monitor)
        });
        Self { lane, cache: cache.clone() }
    }

    pub(super) fn request(&self, request: PictureRequest) -> JobId {
        let hit = self.cache.lock().get(&request);
        match hit {
            Some(picture) => self.lane.publish(picture),
            None => self.lane.submit(request),
        }
    }
}
