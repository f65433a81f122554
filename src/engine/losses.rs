//! The workers that find where the features of a pair were lost, and make the pictures of what they were compared with.

use super::jobs::{JobAnswer, Jobs};
use super::picture_jobs::{PICTURE_GRACE, SharedCache};
use super::queue::{JobQueue, Priority};
use crate::requests::{FoundLosses, JobError, LossesRequest, Picture, PictureRequest, Running};
use std::sync::Arc;
use std::time::Duration;

/// The workers.
pub struct LossWorkers {
    losses: Jobs<LossesRequest, FoundLosses>,
    pictures: Jobs<Vec<PictureRequest>, Vec<Picture>>,
}

impl LossWorkers {
    pub(super) fn new(queue: &Arc<JobQueue>, cache: &SharedCache) -> Self {
        let its = cache.clone();
        Self {
            losses: Jobs::new(queue, Priority::Search, Duration::ZERO, LossesRequest::compute),
            pictures: Jobs::new(
                queue,
                Priority::Picture,
                PICTURE_GRACE,
                move |requests: Vec<PictureRequest>, monitor| {
                    requests.iter().map(|request| its.get_or_make(request, monitor)).collect::<Result<_, JobError>>()
                },
            ),
        }
    }

    /// Asks where features were lost.
    pub fn start(&self, request: LossesRequest) {
        self.losses.submit(request);
    }

    /// Asks for the pictures from which patches are cut.
    pub fn request_pictures(&self, requests: Vec<PictureRequest>) {
        self.pictures.submit(requests);
    }

    /// Where they were lost, if that is known since the last call. Never waits.
    pub fn poll(&self) -> impl Iterator<Item = JobAnswer<FoundLosses>> {
        self.losses.take_answers()
    }

    /// The pictures, if they are there since the last call. Never waits.
    pub fn poll_pictures(&self) -> impl Iterator<Item = JobAnswer<Vec<Picture>>> {
        self.pictures.take_answers()
    }

    /// How far it is, if anything is done.
    pub fn running(&self) -> Option<Running> {
        self.losses.running()
    }
}
