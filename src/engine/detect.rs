//! Finding features in the background.
//!
//! What a detection leaves behind is kept ([`super::trails`]): whoever asks afterwards why finds
//! it, and the same detection, asked for again, is there at once.

use super::jobs::Jobs;
use super::queue::{JobQueue, Priority};
use super::trails::Trails;
use crate::monitor::Monitor;
use crate::requests::{DetectRequest, Detected};
use std::sync::Arc;
use std::time::Duration;

/// Finding features, and keeping what that leaves behind.
pub(super) fn detect_jobs(queue: &Arc<JobQueue>, trails: &Trails) -> Jobs<DetectRequest, Detected> {
    let trails = trails.clone();
    let work = move |request: DetectRequest, monitor: &Monitor| request.compute(&trails, monitor);
    Jobs::new(queue, Priority::Search, Duration::ZERO, work)
}
