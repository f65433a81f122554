//! Open bursts, and how they are opened.

use super::error::JobError;
use super::source::{BurstSource, SourceError};
use crate::burst::{Burst, OpenErrorKind, OpenOptions, find_bursts};
use crate::inspect::truth::{TruthError, is_known, truth_of};
use crate::inspect::words::counted;
use crate::monitor::Monitor;
use crate::synth::{Truth, synth_chart};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Identifies one opening of a burst: opening the same files again gives another id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BurstId(u64);

/// A burst that is open. Cheap to clone.
#[derive(Debug, Clone)]
pub struct OpenBurst {
    /// Id of the opening.
    pub id: BurstId,
    /// The frames.
    pub burst: Arc<Burst>,
    /// Source of the frames.
    pub source: BurstSource,
    /// Truth of what is planted in the frames, if anything is.
    planted: Option<Arc<Truth>>,
}

impl OpenBurst {
    /// Wraps `burst` with a new id.
    pub fn new(burst: Burst, source: BurstSource) -> Self {
        static COUNTER: AtomicU64 = AtomicU64::new(1);
        Self { id: BurstId(COUNTER.fetch_add(1, Ordering::Relaxed)), burst: Arc::new(burst), source, planted: None }
    }

    /// Reads or computes the truth of the burst; `None` if it is not known.
    ///
    /// # Errors
    /// When `truth.json` cannot be read, is invalid, or belongs to pictures of another size.
    pub fn truth(&self, monitor: &Monitor) -> Result<Option<Truth>, TruthError> {
        if let Some(truth) = &self.planted {
            return Ok(Some(Truth::clone(truth)));
        }
        match &self.source {
            // The chart was made once, so making it again fails only when cancelled; then the truth is not needed.
            BurstSource::Chart(chart) => Ok(synth_chart(chart, monitor).ok().map(|(_, truth)| truth)),
            _ => truth_of(&self.burst),
        }
    }

    /// Whether the burst may have a truth: a cheap check that reads no file.
    pub fn has_truth(&self) -> bool {
        self.planted.is_some() || matches!(self.source, BurstSource::Chart(_)) || is_known(&self.burst)
    }

    /// Describes the burst: its name, the number of its frames, and their size.
    pub fn describe(&self) -> String {
        let (width, height) = self.burst.size();
        format!("{}: {} of {width} × {height}", self.burst.name, counted(self.burst.len(), "frame"))
    }
}

impl BurstSource {
    /// Opens the burst on the calling thread, with the calibration in `options`; built-in bursts need none.
    ///
    /// # Errors
    /// [`JobError::Several`] for a folder of bursts, [`JobError::Failed`] with a message that names the file,
    /// [`JobError::Cancelled`] once `monitor` was cancelled.
    pub fn open(&self, options: &OpenOptions, monitor: &Monitor) -> Result<OpenBurst, JobError> {
        match self.burst_and_planted(options, monitor) {
            Ok((burst, planted)) => {
                Ok(OpenBurst { planted: planted.map(Arc::new), ..OpenBurst::new(burst, self.clone()) })
            }
            Err(error) if error.is_cancelled() || monitor.is_cancelled() => Err(JobError::Cancelled),
            Err(SourceError::Open(error)) if error.kind == OpenErrorKind::SeveralBursts => {
                Err(JobError::Several(bursts_at(self.paths())))
            }
            Err(error) => Err(JobError::failed(error)),
        }
    }
}

/// The bursts at `paths`, when there are any.
fn bursts_at(paths: &[PathBuf]) -> Vec<BurstSource> {
    find_bursts(paths).unwrap_or_default().into_iter().map(|found| BurstSource::Paths(found.paths)).collect()
}
