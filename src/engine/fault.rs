//! Why a piece of work has no result, and how a panic becomes a message with its place.
//!
//! The panic's payload does not know where it happened; only the panic hook does. So a hook, installed once and in
//! front of the one that was there, writes the place down under the thread's name. The threads of the queue and
//! their pools are named so that they can be told apart.

use std::any::Any;
use std::collections::HashMap;
use std::sync::{Mutex, Once, PoisonError};

/// Why there is no result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum JobError {
    /// It was cancelled by whoever asked.
    #[error("cancelled")]
    Cancelled,
    /// A newer request of the same kind, for the same, took its place.
    #[error("a newer request took its place")]
    Superseded,
    /// The input, a parameter or a limit is at fault; the message says which and what would be right.
    #[error("{0}")]
    Failed(String),
    /// There is more than one burst at the place that was to be opened.
    #[error("there are {} bursts here; open one of them", .0.len())]
    Several(Vec<super::BurstSource>),
    /// Our own mistake.
    #[error("this is a mistake in Burstscope, please report it: {message} (at {place})")]
    Panicked {
        /// What the panic said.
        message: String,
        /// File, line and column.
        place: String,
    },
}

/// The engine's error for one of the detector's.
pub(super) fn job_error(error: crate::detector::DetectError) -> JobError {
    match error {
        crate::detector::DetectError::Cancelled(_) => JobError::Cancelled,
        crate::detector::DetectError::Param(error) => JobError::Failed(error.to_string()),
    }
}

impl From<crate::monitor::Cancelled> for JobError {
    fn from(_: crate::monitor::Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Threads whose name begins so have the places of their panics written down.
pub(super) const THREAD_PREFIX: &str = "burstscope-";

static PLACES: Mutex<Option<HashMap<String, String>>> = Mutex::new(None);

/// Installs the hook, once for the whole program.
pub(super) fn install_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            let thread = std::thread::current();
            if let (Some(name), Some(place)) = (thread.name(), info.location())
                && let Some(key) = name.strip_prefix(THREAD_PREFIX)
            {
                let mut places = PLACES.lock().unwrap_or_else(PoisonError::into_inner);
                places.get_or_insert_default().insert(shared_key(key).to_owned(), place.to_string());
            }
            before(info);
        }));
    });
}

/// The part of its name that a thread of the queue and those of its pool share: `7-Search` of `7-Search.3`.
fn shared_key(name: &str) -> &str {
    name.split('.').next().unwrap_or(name)
}

/// Runs `work`; a panic becomes [`JobError::Panicked`]. `key` is the name of the thread without its prefix.
pub(super) fn guard<T>(key: &str, work: impl FnOnce() -> Result<T, JobError>) -> Result<T, JobError> {
    // The work owns what it changes and is dropped with it, so nothing half-changed can be seen afterwards.
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).unwrap_or_else(|payload| {
        let mut places = PLACES.lock().unwrap_or_else(PoisonError::into_inner);
        let place = places.get_or_insert_default().remove(key).unwrap_or_else(|| "an unknown place".to_owned());
        Err(JobError::Panicked { message: message_of(&*payload), place })
    })
}

fn message_of(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|s| (*s).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "a panic without a message".to_owned())
}
