//! Memory, counted at this program's allocator. The tests run one at a time, so that nothing else is counted.

mod allocated;
mod bounds;
#[cfg(feature = "colmap")]
mod colmap;
mod groups;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Lock that blocks all other tests of this program until it is dropped.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}
