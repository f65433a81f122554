//! Background work: requests in, answers out, so that whoever asks never waits. What can be asked for and how it is
//! answered is in [`crate::requests`]; here is when, and on which thread.
//!
//! The [`Engine`] has one [queue](JobQueue) for everything. A kind of work is a value of [`Jobs`]: opening a burst, the
//! pictures of panes, a detection, and beside them those of a second burst, of the matches between the two, of
//! [datasets](DatasetWorkers). Of what is asked for under one key (a kind, and a pane, say) the latest request wins, so
//! scrubbing stays live while a detection runs. Each request is an immutable snapshot with an id, and ends in exactly
//! one answer, which is published before `on_update` is called. A panic in the work becomes an error with its place.
//!
//! The engine knows no window: anything that can call [`Engine::poll`] can use it.

mod against;
mod cache;
mod coherence;
mod compare;
mod dataset;
mod detect;
mod explain;
mod fault;
mod figures;
mod held;
mod jobs;
mod lab;
mod losses;
mod pair;
mod picture_jobs;
mod poses;
mod probe;
mod queue;
mod task;
mod trails;

pub use against::AgainstWorker;
pub use cache::PictureCache;
pub use coherence::CoherenceWorker;
pub use compare::Comparer;
pub use dataset::{DatasetUpdate, DatasetWorkers};
pub use explain::Explainer;
pub use figures::FigureWorker;
pub use held::Held;
pub use jobs::{JobAnswer, Jobs};
pub use lab::LabWorkers;
pub use losses::LossWorkers;
pub use pair::{PairJobs, PairUpdate, PairWorkers};
pub use poses::PoseWorker;
pub use probe::ProbeWorker;
pub use queue::{JobKey, JobQueue, Priority};
pub use task::{TaskDone, TaskId};

use crate::burst::OpenOptions;
use crate::requests::{
    BurstId, BurstSource, ComparedPoses, DetectRequest, Detected, JobId, OpenBurst, OpenRequest, Picture,
    PictureRequest, PictureSlot, Running,
};
use picture_jobs::{PictureJobs, SharedCache};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Called after something was published; may come from any thread.
pub type OnUpdate = Arc<dyn Fn() + Send + Sync>;

/// Pictures are kept up to this many bytes unless told otherwise.
pub const DEFAULT_CACHE_BYTES: usize = 256 << 20;

/// The kinds of work for one burst.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BurstJobs {
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
    Opened(JobAnswer<OpenBurst>),
    /// A pane's picture is there. It may be one that was superseded while it was made: compare [`Picture::request`].
    Picture(PictureSlot, JobAnswer<Picture>),
    /// The picture for the patch is there.
    Patch(JobAnswer<Picture>),
    /// A detection ended.
    Detected(JobAnswer<Detected>),
    /// A task ended.
    Task(TaskDone),
    /// Something about a dataset.
    Dataset(DatasetUpdate),
    /// Trajectories were read and compared.
    ComparedPoses(JobAnswer<ComparedPoses>),
}

/// The workers of one window. Dropping it cancels what runs, finishes the files that are being written, and returns
/// when all threads have ended.
pub struct Engine {
    open: Jobs<OpenRequest, OpenBurst>,
    pictures: PictureJobs,
    patch: PictureJobs,
    detect: Jobs<DetectRequest, Detected>,
    probe: ProbeWorker,
    pair: PairWorkers,
    comparer: Comparer,
    explainer: Explainer,
    /// Where features of a pair were lost.
    pub losses: LossWorkers,
    /// Comparisons of features with others.
    pub against: AgainstWorker,
    /// How evenly the frames answer for each feature.
    pub coherence: CoherenceWorker,
    /// The figures of the paper.
    pub figures: FigureWorker,
    /// Work on many bursts.
    pub datasets: DatasetWorkers,
    /// Studies of charts.
    pub lab: LabWorkers,
    /// Work on trajectories.
    pub poses: PoseWorker,
    tasks: task::Tasks,
    cache: SharedCache,
    queue: Arc<JobQueue>,
}

impl std::fmt::Debug for Engine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Engine").field("idle", &self.is_idle()).finish_non_exhaustive()
    }
}

/// The only asker of the selected feature's patch.
const PATCH: PictureSlot = PictureSlot(0);

impl Engine {
    /// Starts the workers. `on_update` is called (from a worker's thread) whenever [`Self::poll`] has news;
    /// pictures are kept up to `cache_bytes`.
    pub fn new(on_update: OnUpdate, cache_bytes: usize) -> Self {
        let cache = SharedCache::new(cache_bytes);
        let queue = Arc::new(JobQueue::new(on_update));
        Self {
            explainer: Explainer::new(&queue, cache.trails()),
            open: open_jobs(&queue),
            pictures: PictureJobs::new(&queue, &cache),
            patch: PictureJobs::new(&queue, &cache),
            detect: detect::detect_jobs(&queue, cache.trails()),
            probe: ProbeWorker::new(&queue, cache.trails()),
            pair: PairWorkers::new(&queue, &cache),
            comparer: Comparer::new(&queue),
            losses: LossWorkers::new(&queue, &cache),
            against: AgainstWorker::new(&queue, cache.trails()),
            coherence: CoherenceWorker::new(&queue, cache.trails()),
            figures: FigureWorker::new(&queue),
            datasets: DatasetWorkers::new(&queue),
            lab: LabWorkers::new(&queue),
            poses: PoseWorker::new(&queue),
            tasks: task::Tasks::new(&queue),
            cache,
            queue,
        }
    }

    /// The queue, for further kinds of work: [`Jobs::new`].
    pub fn queue(&self) -> &Arc<JobQueue> {
        &self.queue
    }

    /// The workers of a second burst and of the matches. What they publish is polled there.
    pub fn pair(&self) -> &PairWorkers {
        &self.pair
    }

    /// The worker that compares methods. What it publishes is polled there.
    pub fn comparer(&self) -> &Comparer {
        &self.comparer
    }

    /// The worker that explains a detection as a whole. What it publishes is polled there.
    pub fn explainer(&self) -> &Explainer {
        &self.explainer
    }

    /// Opens a burst in the background.
    pub fn open(&self, source: BurstSource) -> JobId {
        self.open_with(source, OpenOptions::default())
    }

    /// The same with a calibration.
    pub fn open_with(&self, source: BurstSource, options: OpenOptions) -> JobId {
        self.open.submit(OpenRequest { source, options })
    }

    /// Asks for the picture of a pane. One that is still in the cache is there at the next [`Self::poll`].
    pub fn request_picture(&self, slot: PictureSlot, request: PictureRequest) -> JobId {
        self.pictures.request(slot, request)
    }

    /// The pane is gone: its picture is not made.
    pub fn forget_picture(&self, slot: PictureSlot) {
        self.pictures.jobs.cancel_for(slot.0);
    }

    /// Whether pictures are being made.
    pub fn makes_pictures(&self) -> bool {
        !self.pictures.jobs.is_idle()
    }

    /// Asks for the motion-stack image from which the selected feature's patch is cut.
    pub fn request_patch(&self, request: PictureRequest) -> JobId {
        self.patch.request(PATCH, request)
    }

    /// Starts a detection; the one that runs is cancelled. What it leaves behind is kept for whoever asks why.
    pub fn detect(&self, request: DetectRequest) -> JobId {
        self.detect.submit(request)
    }

    /// Forgets what detections left behind, but in these bursts: others are not open any more.
    pub fn keep_trails_of(&self, open: &[BurstId]) {
        self.cache.trails().keep_only(open);
    }

    /// The workers of the probe. What they publish is polled there.
    pub fn probe(&self) -> &ProbeWorker {
        &self.probe
    }

    /// Runs `work` (writing a file, say). `label` says what it does, for messages. It is finished even when the window
    /// closes.
    pub fn task(
        &self,
        label: impl Into<String>,
        work: impl FnOnce() -> Result<String, String> + Send + 'static,
    ) -> TaskId {
        self.tasks.start(label.into(), work)
    }

    /// What was published since the last call, in no particular order between kinds. Never waits.
    pub fn poll(&self) -> Vec<Update> {
        self.queue.enforce_grace();
        let mut updates = Vec::new();
        updates.extend(self.open.take_answers().map(Update::Opened));
        let pictures = self.pictures.jobs.take_answers_for().into_iter();
        updates.extend(pictures.map(|(slot, answer)| Update::Picture(PictureSlot(slot), answer)));
        updates.extend(self.patch.jobs.take_answers().map(Update::Patch));
        updates.extend(self.detect.take_answers().map(Update::Detected));
        updates.extend(self.datasets.poll().into_iter().map(Update::Dataset));
        updates.extend(self.poses.poll().map(Update::ComparedPoses));
        updates.extend(self.tasks.take_done().into_iter().map(Update::Task));
        updates
    }

    /// What is done of a kind now, if anything runs or waits.
    pub fn running(&self, kind: BurstJobs) -> Option<Running> {
        match kind {
            BurstJobs::Open => self.open.running(),
            BurstJobs::Patch => self.patch.jobs.running(),
            BurstJobs::Detect => self.detect.running(),
        }
    }

    /// Cancels the work of a kind: its answer is [`JobError::Cancelled`](crate::requests::JobError::Cancelled).
    pub fn cancel(&self, kind: BurstJobs) {
        match kind {
            BurstJobs::Open => self.open.cancel(),
            BurstJobs::Patch => self.patch.jobs.cancel(),
            BurstJobs::Detect => self.detect.cancel(),
        }
    }

    /// Whether nothing runs and nothing waits. Answers may still be there to be polled.
    pub fn is_idle(&self) -> bool {
        self.queue.is_all_idle()
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
}

/// Opening bursts.
fn open_jobs(queue: &Arc<JobQueue>) -> Jobs<OpenRequest, OpenBurst> {
    Jobs::new(queue, Priority::Search, Duration::ZERO, OpenRequest::compute)
}

#[cfg(test)]
mod tests;
