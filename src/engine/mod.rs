//! Background workers: requests in, answers out, so that whoever asks never waits.
//!
//! The [`Engine`] has one [`Lane`] for each kind of work: opening a burst, the patch of the selected feature, a
//! detection; and, beside them, those of a second burst and of the matches between the two, and those of a
//! [dataset](DatasetWorkers). The pictures of all panes share one [`KeyedLane`], in which each pane's latest request
//! wins. A lane is a named thread with a single-slot mailbox: a new request replaces one that still waits, and the one
//! that runs is cancelled. So the latest request wins, and scrubbing stays live while a detection runs. Each request is
//! an immutable snapshot with an id. An answer is published first; only then is `on_update` called, so that whoever
//! wakes up finds it. A panic in the work becomes an error with its place, and the lane lives on.
//!
//! The engine knows no window: anything that can call [`Engine::poll`] can use it.

mod cache;
mod compare;
mod dataset;
mod fault;
mod keyed;
mod lane;
mod pair;
mod picture;
mod picture_lane;
mod poses;
mod probe;
mod source;
mod task;

pub use cache::PictureCache;
pub use compare::{CompareRequest, Compared, Comparer};
pub use dataset::{
    Bursts, DatasetAnswer, DatasetEvent, DatasetRequest, DatasetUpdate, DatasetWorkers, Keeping, OpenDataset,
};
pub use fault::JobError;
pub use keyed::KeyedLane;
pub use lane::{Answer, JobId, Lane};
pub use pair::{MatchRequest, Matched, PairLane, PairUpdate, PairWorkers, Patches, PatchesRequest};
pub use picture::{Picture, PictureKind, PictureRequest};
pub use picture_lane::PictureSlot;
pub use poses::{ComparedPoses, PoseWorker, PosesRequest, TrajectorySource};
pub use probe::{ProbeQuestion, ProbeRequest, ProbeWorker, Probed, Traced};
pub use source::{BurstId, BurstSource, OpenBurst};
pub use task::{TaskDone, TaskId};

use crate::baseline::{Searched, search};
use crate::detector::{Detection, DetectorParams, SearchParams, SlopeFinding};
use crate::monitor::{Monitor, Progress};
use picture_lane::{PictureBoard, PictureLane, SharedCache};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Called after something was published; may come from any thread.
pub type OnUpdate = Arc<dyn Fn() + Send + Sync>;

/// Pictures are kept up to this many bytes unless told otherwise.
pub const DEFAULT_CACHE_BYTES: usize = 256 << 20;

/// A picture that the next one supersedes may still finish and be shown within this time, so that the picture follows
/// the slider; one that takes longer is cancelled, so that what is wanted now does not wait for it.
const PICTURE_GRACE: Duration = Duration::from_millis(250);

/// What to detect: a burst and the parameters, both as they were when it was asked.
#[derive(Debug, Clone)]
pub struct DetectRequest {
    /// The burst.
    pub burst: OpenBurst,
    /// The parameters, and how the slopes are chosen.
    pub params: SearchParams,
}

/// A finished detection with what it was made from.
#[derive(Debug, Clone)]
pub struct Detected {
    /// The burst it belongs to.
    pub burst: BurstId,
    /// What was asked for.
    pub asked: SearchParams,
    /// The parameters it was made with: where slopes were to be found, with those that were.
    pub params: DetectorParams,
    /// What was found of the slopes, if they were to be found.
    pub finding: Option<SlopeFinding>,
    /// The features.
    pub detection: Arc<Detection>,
}

/// The kinds of work, one lane each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LaneKind {
    /// Opening a burst.
    Open,
    /// The motion-stack image for the selected feature's patch.
    Patch,
    /// A detection.
    Detect,
}

/// Something that was published since the last [`Engine::poll`].
#[derive(Debug)]
pub enum Update {
    /// A burst was opened, or could not be.
    Opened(Answer<OpenBurst>),
    /// A pane's picture is there. It may be one that was superseded while it was made: compare [`Picture::request`].
    Picture(PictureSlot, Answer<Picture>),
    /// The picture for the patch is there.
    Patch(Answer<Picture>),
    /// A detection ended.
    Detected(Answer<Detected>),
    /// A task ended.
    Task(TaskDone),
    /// Something about a dataset.
    Dataset(DatasetUpdate),
    /// Trajectories were read and compared.
    ComparedPoses(Answer<ComparedPoses>),
}

/// How far a lane's running request is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Running {
    /// Which request.
    pub id: JobId,
    /// Since when.
    pub started: Instant,
    /// The stage and fraction it last reported.
    pub progress: Option<Progress>,
}

/// The workers of one window.
pub struct Engine {
    open: Lane<BurstSource, OpenBurst>,
    pictures: PictureBoard,
    patch: PictureLane,
    detect: Lane<(DetectRequest, probe::KeepTrail), Detected>,
    probe: ProbeWorker,
    pair: PairWorkers,
    comparer: Comparer,
    /// Work on many bursts.
    pub datasets: DatasetWorkers,
    /// Work on trajectories.
    pub poses: PoseWorker,
    tasks: task::Tasks,
    cache: SharedCache,
}

impl std::fmt::Debug for Engine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Engine").field("idle", &self.is_idle()).finish_non_exhaustive()
    }
}

impl Engine {
    /// Starts the workers. `on_update` is called (from a worker's thread) whenever [`Self::poll`] has news;
    /// pictures are kept up to `cache_bytes`.
    pub fn new(on_update: OnUpdate, cache_bytes: usize) -> Self {
        let cache = SharedCache::new(cache_bytes);
        let probe = ProbeWorker::new(&on_update);
        Self {
            open: open_lane("open", &on_update),
            pictures: PictureBoard::new(&cache, on_update.clone()),
            patch: PictureLane::new("patch", &cache, on_update.clone()),
            detect: probe.detect_lane("detect", &on_update),
            probe,
            pair: PairWorkers::new(&cache, &on_update),
            comparer: Comparer::new(&on_update),
            datasets: DatasetWorkers::new(&on_update),
            poses: PoseWorker::new(&on_update),
            tasks: task::Tasks::new(on_update),
            cache,
        }
    }

    /// The workers of a second burst and of the matches. What they publish is polled there.
    pub fn pair(&self) -> &PairWorkers {
        &self.pair
    }

    /// The worker that compares methods. What it publishes is polled there.
    pub fn comparer(&self) -> &Comparer {
        &self.comparer
    }

    /// Opens a burst in the background.
    pub fn open(&self, source: BurstSource) -> JobId {
        self.open.submit(source)
    }

    /// Asks for the picture of a pane. One that is still in the cache is there at the next [`Self::poll`].
    pub fn request_picture(&self, slot: PictureSlot, request: PictureRequest) -> JobId {
        self.pictures.request(slot, request)
    }

    /// The pane is gone: its picture is not made, and no answer comes.
    pub fn forget_picture(&self, slot: PictureSlot) {
        self.pictures.lane.forget(slot);
    }

    /// Whether pictures are being made.
    pub fn makes_pictures(&self) -> bool {
        !self.pictures.lane.is_idle()
    }

    /// Asks for the motion-stack image from which the selected feature's patch is cut.
    pub fn request_patch(&self, request: PictureRequest) -> JobId {
        self.patch.request(request)
    }

    /// Starts a detection; the one that runs is cancelled.
    pub fn detect(&self, request: DetectRequest) -> JobId {
        self.detect.submit((request, false))
    }

    /// The same with the trail kept, which [`ProbeWorker::poll_trail`] gives once the detection has ended.
    pub fn detect_with_trail(&self, request: DetectRequest) -> JobId {
        self.detect.submit((request, true))
    }

    /// The workers of the probe. What they publish is polled there.
    pub fn probe(&self) -> &ProbeWorker {
        &self.probe
    }

    /// Runs `work` (writing a file, say) on a thread of its own. `label` says what it does, for messages.
    pub fn task(
        &self,
        label: impl Into<String>,
        work: impl FnOnce() -> Result<String, String> + Send + 'static,
    ) -> TaskId {
        self.tasks.start(label.into(), work)
    }

    /// What was published since the last call, in no particular order between lanes. Never waits.
    pub fn poll(&self) -> Vec<Update> {
        self.pictures.lane.enforce_grace();
        self.patch.lane.enforce_grace();
        let mut updates = Vec::new();
        updates.extend(self.open.take_answer().map(Update::Opened));
        updates
            .extend(self.pictures.lane.take_answers().into_iter().map(|(slot, answer)| Update::Picture(slot, answer)));
        updates.extend(self.patch.lane.take_answer().map(Update::Patch));
        updates.extend(self.detect.take_answer().map(Update::Detected));
        updates.extend(self.datasets.poll().into_iter().map(Update::Dataset));
        updates.extend(self.poses.poll().map(Update::ComparedPoses));
        updates.extend(self.tasks.take_done().into_iter().map(Update::Task));
        updates
    }

    /// What a lane is doing now, if anything runs or waits.
    pub fn running(&self, lane: LaneKind) -> Option<Running> {
        match lane {
            LaneKind::Open => self.open.running(),
            LaneKind::Patch => self.patch.lane.running(),
            LaneKind::Detect => self.detect.running(),
        }
    }

    /// Cancels what a lane is doing. If something ran, its answer is [`JobError::Cancelled`].
    pub fn cancel(&self, lane: LaneKind) {
        match lane {
            LaneKind::Open => self.open.cancel(),
            LaneKind::Patch => self.patch.lane.cancel(),
            LaneKind::Detect => self.detect.cancel(),
        }
    }

    /// Whether nothing runs and nothing waits. Answers may still be there to be polled.
    pub fn is_idle(&self) -> bool {
        self.open.is_idle()
            && self.pictures.lane.is_idle()
            && self.patch.lane.is_idle()
            && self.detect.is_idle()
            && self.probe.is_idle()
            && self.pair.is_idle()
            && self.comparer.is_idle()
            && self.datasets.is_idle()
            && self.poses.is_idle()
            && self.tasks.is_idle()
    }

    /// Waits until nothing runs and nothing waits, or until `timeout` has passed. Says whether it is idle.
    pub fn wait_idle(&self, timeout: Duration) -> bool {
        let end = Instant::now() + timeout;
        while !self.is_idle() {
            if Instant::now() >= end {
                return false;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        true
    }

    /// Bytes of pictures that the cache holds now.
    pub fn cache_bytes(&self) -> usize {
        self.cache.lock().bytes()
    }
}

/// A lane that opens bursts.
fn open_lane(name: &str, on_update: &OnUpdate) -> Lane<BurstSource, OpenBurst> {
    Lane::new(name, Duration::ZERO, on_update.clone(), |source: BurstSource, monitor| source.open(monitor))
}

/// A lane that finds features.
fn detect_lane(name: &str, on_update: &OnUpdate) -> Lane<DetectRequest, Detected> {
    Lane::new(name, Duration::ZERO, on_update.clone(), detect_now)
}

fn detect_now(request: DetectRequest, monitor: &Monitor) -> Result<Detected, JobError> {
    let found = search(&request.burst.burst, &request.params, monitor).map_err(picture::job_error)?;
    let Searched { detection, params, finding, .. } = found;
    Ok(Detected { burst: request.burst.id, asked: request.params, params, finding, detection: Arc::new(detection) })
}

#[cfg(test)]
mod tests;
