//! Signals that end the program, and the one sent when a file grows too large.
//!
//! Ctrl-C (SIGINT), SIGTERM, which schedulers and services send, and SIGHUP, sent when the terminal closes, have the
//! same effect. A program started to outlive its terminal (`nohup`) ignores SIGHUP.

use super::failure::{Failure, INTERRUPTED, Outcome};
use anyhow::Context;
use std::time::{Duration, Instant};

/// Time after the first signal within which others belong to it: `timeout` sends its signal to the program and to its
/// group, and a closed terminal is reported by the system and by the shell.
const SAME_REQUEST: Duration = Duration::from_secs(1);

/// Requests to end the program, made of the signals that it received.
#[derive(Debug, Default)]
struct Requests {
    first: Option<Instant>,
}

impl Requests {
    /// Asks to end with `end`, or ends the program `at_once` if it was asked before.
    fn take(&mut self, at: Instant, end: impl FnOnce(), at_once: impl FnOnce()) {
        match self.first {
            None => {
                self.first = Some(at);
                end();
            }
            Some(first) if at.duration_since(first) < SAME_REQUEST => {}
            Some(_) => at_once(),
        }
    }
}

fn exit() {
    std::process::exit(INTERRUPTED.into());
}

/// Calls `end` at the first signal, so that the program finishes in order; a second request ends it at once.
pub(super) fn on_end(end: impl Fn() + Send + 'static) -> Outcome {
    listen(end).context("cannot listen for Ctrl-C and other requests to end").map_err(Failure::Failed)
}

#[cfg(unix)]
fn listen(end: impl Fn() + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let hang_up = hang_up_is_heard().then_some(SIGHUP);
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM].into_iter().chain(hang_up))?;
    let listener = move || {
        let mut requests = Requests::default();
        for _ in signals.forever() {
            requests.take(Instant::now(), &end, exit);
        }
    };
    std::thread::Builder::new().name("burstscope-signals".to_owned()).spawn(listener).map(drop)
}

/// Not where the parent process has it ignored, or where the system does not say: SIGHUP keeps its default action.
#[cfg(unix)]
fn hang_up_is_heard() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_some_and(|mask| mask & 1 << (signal_hook::consts::SIGHUP - 1) == 0)
}

#[cfg(not(unix))]
fn listen(end: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    let mut requests = Requests::default();
    ctrlc::set_handler(move || requests.take(Instant::now(), &end, exit))
}

/// Writing past the file size limit (`ulimit -f`) becomes an error, where that is possible.
pub(super) fn survive_file_size_limit() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn one_request_that_comes_as_two_signals_is_finished_in_order() {
        let (start, heard) = (Instant::now(), RefCell::new(Vec::new()));
        let mut requests = Requests::default();
        for millis in [0, 0, 20, 900, 1100] {
            let at = start + Duration::from_millis(millis);
            requests.take(at, || heard.borrow_mut().push(("end", millis)), || heard.borrow_mut().push(("now", millis)));
        }
        assert_eq!(heard.into_inner(), [("end", 0), ("now", 1100)]);
    }
}
