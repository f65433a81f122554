//! What the system sends to end the program, and what would end it over a file that grows too large.
//!
//! Ctrl-C, the signal by which schedulers and services end a program (SIGTERM), and that of a terminal that is closed
//! (SIGHUP) all ask for the same. A program that was started so that it outlives its terminal (`nohup`) goes on.

use super::failure::{Failure, INTERRUPTED};
use anyhow::Context;

/// Calls `end` when the program is asked to end. Asked a second time, it ends at once.
///
/// # Errors
/// When the system lets nobody listen.
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

/// Whether a closed terminal is to be heard of: not where whoever started the program had it ignored. Where the system
/// does not tell, it ends programs as it does by itself.
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

/// Makes a file that grows beyond the limit of the process (`ulimit -f`) an error of its writing, in place of the end of
/// the program. Where that cannot be had, it ends as it would have.
pub(super) fn survive_file_size_limit() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}
