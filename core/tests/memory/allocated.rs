//! The memory that this program has asked for, counted at its allocator: the same on every system, where what the
//! operating system counts depends on what an allocator keeps for later.

use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// What is held now, bytes.
fn allocated_bytes() -> u64 {
    ALLOCATOR.current_usage() as u64
}

/// The most that was held while `work` was done beyond what was held before it, bytes.
pub fn peak_over(work: impl FnOnce()) -> u64 {
    let before = allocated_bytes();
    ALLOCATOR.reset_peak_usage();
    work();
    (ALLOCATOR.peak_usage() as u64).saturating_sub(before)
}
