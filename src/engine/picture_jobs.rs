//! Making pictures and keeping them: what is still in the cache is answered at once.

use super::cache::PictureCache;
use super::jobs::Jobs;
use super::queue::{JobQueue, Priority};
use super::trails::Trails;
use crate::monitor::Monitor;
use crate::requests::{JobError, JobId, Picture, PictureRequest, PictureSlot};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A picture that the next one supersedes may still finish and be shown within this time, so that the picture follows
/// the slider; one that takes longer is cancelled, so that what is wanted now does not wait for it.
pub(super) const PICTURE_GRACE: Duration = Duration::from_millis(250);

/// The cache that all pictures of an engine share. Cheap to clone.
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

/// The pictures of all who want one, of each the latest that was asked for.
pub(super) struct PictureJobs {
    pub(super) jobs: Jobs<PictureRequest, Picture>,
    cache: SharedCache,
}

impl PictureJobs {
    pub(super) fn new(queue: &Arc<JobQueue>, cache: &SharedCache) -> Self {
        let its = cache.clone();
        let make = move |request: PictureRequest, monitor: &Monitor| its.get_or_make(&request, monitor);
        Self { jobs: Jobs::new(queue, Priority::Picture, PICTURE_GRACE, make), cache: cache.clone() }
    }

    pub(super) fn request(&self, slot: PictureSlot, request: PictureRequest) -> JobId {
        let hit = self.cache.lock().get(&request);
        match hit {
            Some(picture) => self.jobs.publish_for(slot.0, picture),
            None => self.jobs.submit_for(slot.0, request),
        }
    }
}
