//! Lanes that make pictures and keep them: what is still in the cache is answered at once.

use super::cache::PictureCache;
use super::explain::Trails;
use super::fault::JobError;
use super::keyed::KeyedLane;
use super::lane::{JobId, Lane};
use super::picture::{Picture, PictureRequest};
use super::{OnUpdate, PICTURE_GRACE};
use crate::monitor::Monitor;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The cache that all lanes of an engine share. Cheap to clone.
#[derive(Debug, Clone)]
pub(super) struct SharedCache(Arc<Mutex<PictureCache>>, Trails);

impl SharedCache {
    pub(super) fn new(budget_bytes: usize) -> Self {
        Self(Arc::new(Mutex::new(PictureCache::new(budget_bytes))), Trails::default())
    }

    /// The trail from which some pictures are made.
    pub(super) fn trails(&self) -> &Trails {
        &self.1
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
        let picture = match request.minus() {
            None => request.compute_with(&self.1, monitor)?,
            // Both pictures are kept too: they are mostly on show beside their difference.
            Some(minus) => {
                let picture = self.get_or_make(&request.alone(), monitor)?;
                picture.minus(&self.get_or_make(minus, monitor)?)
            }
        };
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

/// Who wants a picture: each pane has a number of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PictureSlot(pub u32);

/// The pictures of many panes, of each the latest that was asked for.
pub(super) struct PictureBoard {
    pub(super) lane: KeyedLane<PictureSlot, PictureRequest, Picture>,
    cache: SharedCache,
}

impl PictureBoard {
    pub(super) fn new(cache: &SharedCache, on_update: OnUpdate) -> Self {
        let its = cache.clone();
        let lane = KeyedLane::new("picture", PICTURE_GRACE, on_update, move |request: PictureRequest, monitor| {
            its.get_or_make(&request, monitor)
        });
        Self { lane, cache: cache.clone() }
    }

    pub(super) fn request(&self, slot: PictureSlot, request: PictureRequest) -> JobId {
        let hit = self.cache.lock().get(&request);
        match hit {
            Some(picture) => self.lane.publish(slot, picture),
            None => self.lane.submit(slot, request),
        }
    }
}
