//! The memory of this program, as the operating system counts it. `None` where there is no `/proc`.
#![allow(dead_code)] // Each test program uses a part of it.

/// A number of bytes from `/proc/self/status`.
fn status_bytes(field: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with(field))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

/// What is in use now, bytes.
pub fn resident_bytes() -> Option<u64> {
    status_bytes("VmRSS")
}

/// The most that was in use while `work` was done, bytes.
pub fn peak_bytes(work: impl FnOnce()) -> Option<u64> {
    // Writing 5 makes the system forget the peak so far.
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    work();
    status_bytes("VmHWM")
}
