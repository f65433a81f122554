//! Where a burst comes from, and a burst that is open.

use super::fault::JobError;
use crate::burst::{Burst, find_bursts};
use crate::monitor::Monitor;
use crate::synth::Example;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Where a burst comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BurstSource {
    /// The demo burst that is built into the program.
    Demo,
    /// The demo street a little later: another burst that is built into the program.
    DemoLater,
    /// A failure to look at, built into the program.
    Example(Example),
    /// A folder of frames, image files, a multi-page TIFF, or a `.npy` stack.
    Paths(Vec<PathBuf>),
}

/// Tells one opening of a burst from another, also of the same files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BurstId(u64);

/// A burst that is open. Cheap to clone.
#[derive(Debug, Clone)]
pub struct OpenBurst {
    /// Which opening.
    pub id: BurstId,
    /// The frames.
    pub burst: Arc<Burst>,
    /// Where they came from.
    pub source: BurstSource,
}

impl OpenBurst {
    /// Gives `burst` an identity of its own.
    pub fn new(burst: Burst, source: BurstSource) -> Self {
        static COUNTER: AtomicU64 = AtomicU64::new(1);
        Self { id: BurstId(COUNTER.fetch_add(1, Ordering::Relaxed)), burst: Arc::new(burst), source }
    }
}

impl BurstSource {
    /// Opens it, on the calling thread.
    ///
    /// # Errors
    /// [`JobError::Several`] for a folder of bursts, [`JobError::Failed`] with a message that names the file,
    /// [`JobError::Cancelled`] once `monitor` was cancelled.
    pub fn open(&self, monitor: &Monitor) -> Result<OpenBurst, JobError> {
        let burst = match self {
            Self::Demo => crate::synth::demo::demo_burst(),
            Self::DemoLater => crate::synth::demo::later_demo_burst(),
            Self::Example(example) => example.burst(),
            Self::Paths(paths) => {
                let found = bursts_at(paths);
                if found.len() > 1 {
                    return Err(JobError::Several(found));
                }
                Burst::open_with(paths, &crate::burst::OpenOptions::default(), monitor)
                    .map_err(|error| open_error(&error, monitor))?
            }
        };
        monitor.check()?;
        Ok(OpenBurst::new(burst, self.clone()))
    }

    /// A name for menus and messages: the last part of the (first) path.
    pub fn label(&self) -> String {
        match self {
            Self::Demo => "Demo burst".to_owned(),
            Self::DemoLater => "Later demo burst".to_owned(),
            Self::Example(example) => example.label().to_owned(),
            Self::Paths(paths) => match paths.as_slice() {
                [] => "nothing".to_owned(),
                [one] => one.file_name().unwrap_or(one.as_os_str()).to_string_lossy().into_owned(),
                [first, rest @ ..] => {
                    let name = first.file_name().unwrap_or(first.as_os_str()).to_string_lossy();
                    format!("{name} and {} more", rest.len())
                }
            },
        }
    }
}

/// The bursts at `paths`, when there are any.
fn bursts_at(paths: &[PathBuf]) -> Vec<BurstSource> {
    // What is wrong with the paths is said by the opener.
    find_bursts(paths).unwrap_or_default().into_iter().map(|found| BurstSource::Paths(found.paths)).collect()
}

fn open_error(error: &impl std::fmt::Display, monitor: &Monitor) -> JobError {
    if monitor.is_cancelled() { JobError::Cancelled } else { JobError::Failed(error.to_string()) }
}
