//! Signals that end the program, and the one sent when a file grows too large.
//!
//! Ctrl-C (SIGINT), SIGTERM, which schedulers and services send, and SIGHUP, sent when the terminal closes, have the
//! same effect. A program started to outlive its terminal (`nohup`) ignores SIGHUP.

use super::failure::{Failure, INTERRUPTED};
use anyhow::Context;

/// Calls `end` at each signal that asks the program to end. A second signal ends the program at once.
///
/// # Errors
/// When the system does not allow a signal handler.
pub(super) fn on_end(end: impl Fn() + Send + 'static) -> Result<(), Failure> {
    listen(end).context("cannot listen for Ctrl-C and other requests to end").map_err(Failure::Failed)
}

#[cfg(unix)]
fn listen(end: impl Fn() + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let hang_up = hang_up_is_heard().then_some(SIGHUP);
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM].into_iter().chain(hang_up))?;
    let listener = move || {
        let mut again = false;
        for _ in signals.forever() {
            if again {
                std::process::exit(INTERRUPTED.into());
            }
            again = true;
            end();
        }
    };
    std::thread::Builder::new().name("burstscope-signals".to_owned()).spawn(listener).map(drop)
}

/// Whether to handle SIGHUP. False where the parent process has it ignored, and where the system does not say: SIGHUP
/// then keeps its default action.
#[cfg(unix)]
fn hang_up_is_heard() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_some_and(|mask| mask & 1 << (signal_hook::consts::SIGHUP - 1) == 0)
}

#[cfg(not(unix))]
fn listen(end: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    let again = std::sync::atomic::AtomicBool::new(false);
    ctrlc::set_handler(move || {
        if again.swap(true, std::sync::atomic::Ordering::Relaxed) {
            std::process::exit(INTERRUPTED.into());
        }
        end();
    })
}

/// Turns writing past the process's file size limit (`ulimit -f`) into a write error instead of the end of the program.
/// Where that is impossible, the program still ends.
pub(super) fn survive_file_size_limit() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}
