//! The workers for datasets, and for small pictures of their bursts. Events of a request that another has replaced are
//! dropped.

use super::jobs::{JobAnswer, Jobs};
use super::queue::{JobQueue, Priority};
use crate::burst::{BurstSource, OpenOptions};
use crate::dataset::{Thumbnail, thumbnail};
use crate::monitor::Monitor;
use crate::requests::{DatasetAnswer, DatasetEvent, DatasetRequest, Running};
use std::sync::Arc;
use std::time::Duration;

/// Something that was published about datasets since the last poll. Events come before the answer that ends their
/// request.
#[derive(Debug)]
pub enum DatasetUpdate {
    /// On the way.
    Event(DatasetEvent),
    /// A request ended.
    Ended(JobAnswer<DatasetAnswer>),
    /// A burst's small picture, or why there is none.
    Thumbnail {
        /// The burst's first path: places change with the dataset.
        source: BurstSource,
        /// The picture.
        picture: Result<Thumbnail, String>,
    },
}

/// A burst's small picture, or why there is none.
type ThumbnailNews = (BurstSource, Result<Thumbnail, String>);

/// The bursts, the longest side in pixels, and how the bursts are opened.
type ThumbnailsRequest = (Vec<BurstSource>, usize, OpenOptions);

/// The workers for datasets.
pub struct DatasetWorkers {
    work: Jobs<DatasetRequest, DatasetAnswer, DatasetEvent>,
    thumbnails: Jobs<ThumbnailsRequest, (), ThumbnailNews>,
}

impl DatasetWorkers {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        let make =
            |(bursts, side, open): ThumbnailsRequest, tell: &(dyn Fn(ThumbnailNews) + Sync), monitor: &Monitor| {
                for source in bursts {
                    let picture = thumbnail(&source, side, &open, &monitor.silent()).map_err(|e| e.to_string());
                    monitor.check()?;
                    tell((source, picture));
                }
                Ok(())
            };
        Self {
            work: Jobs::telling(queue, Priority::Dataset, Duration::ZERO, DatasetRequest::compute),
            thumbnails: Jobs::telling(queue, Priority::Dataset, Duration::ZERO, make),
        }
    }

    /// Starts a piece of work; the one that runs is cancelled.
    pub fn submit(&self, request: DatasetRequest) {
        self.work.submit(request);
    }

    /// Asks for the small pictures of `bursts`, opened with `open`, no side longer than `max_side_px`, in this order.
    /// What was asked for before and is not there yet is not made.
    pub fn request_thumbnails(&self, bursts: Vec<BurstSource>, max_side_px: usize, open: OpenOptions) {
        self.thumbnails.submit((bursts, max_side_px, open));
    }

    /// Forgets the small pictures that were asked for and are not taken yet.
    pub fn forget_thumbnails(&self) {
        self.thumbnails.cancel();
        drop(self.thumbnails.take_news());
    }

    /// Whether small pictures are being made.
    pub fn makes_thumbnails(&self) -> bool {
        !self.thumbnails.is_idle()
    }

    /// What is being done with a dataset now, if anything.
    pub fn running(&self) -> Option<Running> {
        self.work.running()
    }

    /// Cancels it. What is finished stays finished.
    pub fn cancel(&self) {
        self.work.cancel();
    }

    /// Whether nothing runs and nothing waits.
    pub fn is_idle(&self) -> bool {
        self.work.is_idle() && self.thumbnails.is_idle()
    }

    pub(super) fn poll(&self) -> Vec<DatasetUpdate> {
        let (events, ended) = self.work.take_news();
        let (pictures, _) = self.thumbnails.take_news();
        let mut updates: Vec<DatasetUpdate> = events.into_iter().map(DatasetUpdate::Event).collect();
        updates.extend(pictures.into_iter().map(|(source, picture)| DatasetUpdate::Thumbnail { source, picture }));
        updates.extend(ended.into_iter().map(DatasetUpdate::Ended));
        updates
    }
}
