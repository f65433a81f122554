//! Memory for pixels, with allocations that may fail without ending the program, and buffers that suit its vectors.
//!
//! The user's input decides the size of frames and planes, which may exceed the machine's memory. A refusal unwinds as
//! an [`Error`], without a panic's message, up to [`refusable`] around a file, a command or a job. A system may promise
//! memory that it lacks; [`crate::detector`] checks a limit well below before a search.

use crate::error::{Error, ErrorKind, Result};
use bytemuck::Zeroable;
use std::ops::{Deref, DerefMut};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::LazyLock;

fn no_memory(bytes: u64) -> Error {
    let problem = format!("there is no memory for {} MiB more", bytes.div_ceil(1 << 20));
    let remedy = "take fewer frames or slopes, smaller pictures or a coarser first octave, or close other programs";
    Error::new(ErrorKind::NoMemory, problem, remedy)
}

fn refused<T>(count: usize) -> ! {
    let error = no_memory((count as u64).saturating_mul(size_of::<T>() as u64));
    // Not a panic: there is no bug, and the hook that prints panics is not called.
    resume_unwind(Box::new(error))
}

/// `count` zeros. Unwinds with [`ErrorKind::NoMemory`] where the system refuses them.
pub fn zeroed<T: Zeroable>(count: usize) -> Vec<T> {
    bytemuck::try_zeroed_vec(count).unwrap_or_else(|()| refused::<T>(count))
}

/// Empty vector with room for `count` values. Unwinds as [`zeroed`] where the system refuses it.
pub fn with_capacity<T>(count: usize) -> Vec<T> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_or_else(|_| refused::<T>(count), |()| values)
}

/// Unwinds as [`zeroed`] where the system refuses `bytes`: to call before code that cannot be refused memory itself.
pub fn check_room(bytes: u64) {
    drop(with_capacity::<u8>(usize::try_from(bytes).unwrap_or(usize::MAX)));
}

/// Memory available to this process, bytes: the minimum of the machine's, its control group's and its own limit of
/// address space. `None` where the system does not report it (anything but Linux). Read once.
pub fn machine_bytes() -> Option<u64> {
    static BYTES: LazyLock<Option<u64>> = LazyLock::new(|| {
        let read = |path: &str| std::fs::read_to_string(path).ok();
        let total = machine_bytes_of(&read("/proc/meminfo")?)?;
        let group = read("/sys/fs/cgroup/memory.max").and_then(|text| text.trim().parse().ok());
        let own = read("/proc/self/limits").and_then(|text| address_space_of(&text));
        Some([group, own].into_iter().flatten().fold(total, u64::min))
    });
    *BYTES
}

fn machine_bytes_of(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find(|line| line.starts_with("MemTotal:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? << 10)
}

/// Limit of the address space in bytes, from the text of `/proc/self/limits`; `None` without a limit.
fn address_space_of(limits: &str) -> Option<u64> {
    limits.lines().find_map(|line| line.strip_prefix("Max address space"))?.split_whitespace().next()?.parse().ok()
}

/// Runs `work`; turns a refused allocation into an error.
///
/// # Errors
/// Refusal by the system, as [`ErrorKind::NoMemory`]; panics go on.
pub fn refusable<T>(work: impl FnOnce() -> T) -> Result<T> {
    // State that the work left halfway is its own, and dropped with it.
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| match payload.downcast::<Error>() {
        Ok(refused) => *refused,
        Err(panic) => resume_unwind(panic),
    })
}

#[derive(Debug, Clone, Copy, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Line([f32; 16]);

/// Growing buffer of `f32` whose first value lies at the start of a cache line, as long as the widest vector: no vector
/// straddles two lines, which would take twice as long.
#[derive(Debug, Clone, Default)]
pub(crate) struct Aligned {
    lines: Vec<Line>,
}

impl Aligned {
    /// Makes room for at least `len` numbers; existing ones keep their values, new ones are 0.
    pub fn grow(&mut self, len: usize) {
        let lines = len.div_ceil(16);
        if self.lines.len() < lines {
            self.lines.resize(lines, Line::default());
        }
    }
}

impl Deref for Aligned {
    type Target = [f32];

    #[inline]
    fn deref(&self) -> &[f32] {
        bytemuck::cast_slice(&self.lines)
    }
}

impl DerefMut for Aligned {
    #[inline]
    fn deref_mut(&mut self) -> &mut [f32] {
        bytemuck::cast_slice_mut(&mut self.lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Plane;
    use rayon::prelude::*;

    #[test]
    fn what_is_refused_is_an_error_with_its_size() {
        // 2^40 pixels of 4 bytes are more than a process may address on any machine of today; so is what overflows.
        let side = 1 << 30;
        assert_eq!(refusable(|| Plane::zeros(side, side)), Err(no_memory(1 << 62)));
        assert!(refusable(|| Plane::from_fn(side, side, |_, _| 0.0)).is_err());
        assert_eq!(refusable(|| Plane::zeros(usize::MAX, usize::MAX)), Err(no_memory(u64::MAX)));
        assert!(refusable(|| with_capacity::<u64>(usize::MAX)).is_err());
        assert_eq!(refusable(|| zeroed::<f32>(3)), Ok(vec![0.0; 3]));
        assert!(refusable(|| with_capacity::<u8>(9)).is_ok_and(|room| room.capacity() >= 9));
        let words = no_memory(3 << 20).to_string();
        assert!(words.contains("3 MiB"), "{words}");
    }

    #[test]
    fn the_system_says_how_much_there_is_where_it_can() {
        assert!(machine_bytes().is_none_or(|bytes| bytes > 1 << 28));
        assert_eq!(machine_bytes_of("MemTotal:       2048 kB\nMemFree: 1 kB\n"), Some(2 << 20));
        let limits = |soft: &str| {
            format!("Limit   Soft Limit  Hard Limit  Units\nMax address space   {soft}   unlimited   bytes\n")
        };
        assert_eq!(address_space_of(&limits("4294967296")), Some(1 << 32));
        assert_eq!((address_space_of(&limits("unlimited")), address_space_of("")), (None, None));
    }

    #[test]
    fn it_comes_through_parallel_loops_and_panics_stay_panics() {
        let work = || (0..64usize).into_par_iter().map(|i| zeroed::<u8>(if i == 40 { 1 << 62 } else { i }).len()).sum();
        assert_eq!(refusable::<usize>(work), Err(no_memory(1 << 62)));
        let panic = catch_unwind(|| refusable(|| panic!("a mistake")));
        assert_eq!(panic.expect_err("a panic").downcast_ref::<&str>(), Some(&"a mistake"));
    }

    #[test]
    fn buffers_begin_at_cache_lines_and_keep_what_they_hold() {
        let mut buffer = Aligned::default();
        for len in [1, 16, 17, 5000, 3] {
            buffer.grow(len);
            assert!(buffer.len() >= len);
            assert_eq!(buffer.as_ptr() as usize % 64, 0);
            buffer[0] = 7.0;
        }
        assert_eq!(buffer[0], 7.0);
        assert_eq!(buffer[4999], 0.0);
    }
}
