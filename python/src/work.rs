//! Long work for Python: on a thread of its own, so that Python's other threads run, with progress, and ended by
//! Ctrl-C.

use crate::failure::raised;
use burstscope::cli::Failure;
use burstscope::monitor::{Monitor, Progress};
use burstscope::plane::memory;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

/// Interval between two looks at signals and progress.
const POLL: Duration = Duration::from_millis(25);

/// Runs `work` while the interpreter is free for other threads. `progress`, if there is one, is called with the name of
/// the stage and the finished fraction of the work, 0 to 1.
///
/// # Errors
/// The work's failure, as an exception. What a signal's handler (`KeyboardInterrupt` for Ctrl-C) or `progress` raises
/// cancels the work, and is raised once it has ended. `RuntimeError` in a process that was forked after the first work:
/// it has no threads of its parent's pool, so that the work would wait for ever.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Monitor) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    static PROCESS: OnceLock<u32> = OnceLock::new();
    if *PROCESS.get_or_init(std::process::id) != std::process::id() {
        let problem = "this process was forked after Burstscope had begun to work, and lacks its threads";
        return Err(PyRuntimeError::new_err(format!("{problem}; start processes by multiprocessing's 'spawn'")));
    }
    let latest: Arc<Mutex<Option<Progress>>> = Arc::default();
    let told = latest.clone();
    let monitor = Monitor::with_listener(move |p| *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(p));
    let (outcome, exception) = py.detach(|| {
        std::thread::scope(|scope| {
            let (send, receive) = mpsc::channel();
            let worker_monitor = &monitor;
            let worker = scope.spawn(move || {
                // The receiver waits until this is sent.
                let _ = send.send(memory::refusable(|| work(worker_monitor)));
            });
            let mut exception = None;
            loop {
                match receive.recv_timeout(POLL) {
                    Ok(outcome) => return (outcome, exception),
                    Err(RecvTimeoutError::Timeout) if exception.is_none() => {
                        let latest = latest.lock().unwrap_or_else(PoisonError::into_inner).take();
                        exception = Python::attach(|py| tell(py, progress.as_ref(), latest)).err();
                        if exception.is_some() {
                            monitor.cancel();
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => match worker.join() {
                        Err(panic) => std::panic::resume_unwind(panic),
                        Ok(()) => unreachable!("a thread that ends without a panic has sent its outcome"),
                    },
                }
            }
        })
    });
    match (exception, outcome) {
        (Some(exception), _) => Err(exception),
        (None, Ok(result)) => result.map_err(|failure| raised(&failure)),
        (None, Err(refused)) => Err(raised(&Failure::Failed(refused.into()))),
    }
}

/// Handles signals, and calls `progress` with what is new.
fn tell(py: Python<'_>, progress: Option<&Py<PyAny>>, latest: Option<Progress>) -> PyResult<()> {
    py.check_signals()?;
    if let (Some(progress), Some(latest)) = (progress, latest) {
        progress.call1(py, (latest.stage.to_string(), latest.fraction))?;
    }
    Ok(())
}
