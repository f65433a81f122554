//! Memory allocated by this program, counted at its allocator: the same on every system, whereas the operating system's
//! count depends on memory that an allocator keeps for later.

use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes allocated now.
fn allocated_bytes() -> u64 {
    ALLOCATOR.current_usage() as u64
}

/// Peak of the bytes allocated during `work`, beyond those allocated before it.
pub fn peak_over(work: impl FnOnce()) -> u64 {
    let before = allocated_bytes();
    ALLOCATOR.reset_peak_usage();
    work();
    (ALLOCATOR.peak_usage() as u64).saturating_sub(before)
}
