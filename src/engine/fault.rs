//! Conversion of a panic into a message with its place in the source.
//!
//! Only the panic hook gets the place. So a hook, in front of the existing one, records it under the thread's name;
//! the threads of the queue and their pools have distinct names.

use super::locked;
use crate::plane::memory;
use crate::requests::JobError;
use std::any::Any;
use std::collections::HashMap;
use std::sync::{Mutex, Once};

pub(super) const THREAD_PREFIX: &str = "burstscope-";

static PLACES: Mutex<Option<HashMap<String, String>>> = Mutex::new(None);

pub(super) fn install_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            let thread = std::thread::current();
            if let (Some(name), Some(place)) = (thread.name(), info.location())
                && let Some(key) = name.strip_prefix(THREAD_PREFIX)
            {
                let mut places = locked(&PLACES);
                // A panic in a pool surfaces in the thread that waits for the pool: `7-Search.3` is kept as `7-Search`.
                let shared = key.split('.').next().unwrap_or(key);
                places.get_or_insert_default().insert(shared.to_owned(), place.to_string());
            }
            before(info);
        }));
    });
}

/// `key` is the name of the thread without its prefix.
pub(super) fn guard<T>(key: &str, work: impl FnOnce() -> Result<T, JobError>) -> Result<T, JobError> {
    // The work owns what it changes and is dropped with it, so nothing half-changed can be seen afterwards.
    let work = || memory::refusable(work).unwrap_or_else(|refused| Err(refused.into()));
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).unwrap_or_else(|payload| {
        let mut places = locked(&PLACES);
        let place = places.get_or_insert_default().remove(key).unwrap_or_else(|| "an unknown place".to_owned());
        Err(JobError::Panicked { message: message_of(&*payload), place })
    })
}

fn message_of(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "a panic without a message".to_owned())
}
