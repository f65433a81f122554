//! Counterpart of [`child`](super::child): the process that decodes one file and sends its pixels.

use super::wire::{DecodeRequest, Part, receive, send_reply};
use super::{Expected, RawFrame, frame, page};
use crate::burst::error::OpenError;
use crate::burst::options::OpenOptions;
use crate::monitor::Monitor;
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::ExitCode;

/// Decodes the file `path` as the request on standard input says, and writes it to standard output: the main function
/// of a program started as a [`DecodeWorker`](super::DecodeWorker). The process limits its own memory and time, and
/// ends when its input does.
pub fn serve_decoding(path: &Path) -> ExitCode {
    // A panic becomes an error about the file, which is sent; its message is dropped.
    std::panic::set_hook(Box::new(|_| {}));
    match serve(path) {
        Ok(()) => ExitCode::SUCCESS,
        // There was no request, or the answer could not be sent.
        Err(_) => ExitCode::FAILURE,
    }
}

fn serve(path: &Path) -> io::Result<()> {
    let request: DecodeRequest = receive(&mut io::stdin().lock())?;
    limit(request.memory_bytes, request.cpu_seconds);
    // Decoders that work in parallel use this thread alone; others would take address space of their own.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
    std::thread::Builder::new().stack_size(64 << 10).spawn(|| {
        // No more input is expected. When it ends, the requesting process is gone.
        let _ = io::stdin().lock().read(&mut [0]);
        std::process::exit(1);
    })?;
    let mut output = io::stdout().lock();
    send_reply(&mut output, answer(path, &request))?;
    output.flush()
}

fn answer(path: &Path, request: &DecodeRequest) -> Result<RawFrame, OpenError> {
    if request.version != env!("CARGO_PKG_VERSION") {
        return Err(OpenError::Read {
            path: path.into(),
            reason: "the program was replaced while it ran; start it again".to_owned(),
        });
    }
    let options = OpenOptions { limits: request.limits, ..request.options.clone() };
    let expected = request.expected.map(|size| Expected { first: path, size });
    match request.part {
        Part::Only => frame(path, expected, &options, &Monitor::default()),
        Part::Page { page: number, frame } => page(path, number, frame, &options),
    }
}

/// Limits this process: memory that it may address (bytes) and processor time (seconds).
#[cfg(unix)]
fn limit(memory_bytes: u64, cpu_seconds: u64) {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    // The soft limit of time sends a signal that tells the cause, the hard one kills.
    let limits = [
        (Resource::As, memory_bytes, memory_bytes),
        (Resource::Cpu, cpu_seconds, cpu_seconds.saturating_add(5)),
        (Resource::Core, 0, 0),
    ];
    for (resource, current, maximum) in limits {
        let now = getrlimit(resource);
        let lower = |limit: Option<u64>, to: u64| Some(limit.map_or(to, |limit| limit.min(to)));
        let lowered = Rlimit { current: lower(now.current, current), maximum: lower(now.maximum, maximum) };
        // Where the system has no such limit, the parent's wall-clock limit remains.
        let _ = setrlimit(resource, lowered);
    }
}

/// Sets no limits: the parent's wall-clock limit remains.
#[cfg(not(unix))]
fn limit(_memory_bytes: u64, _cpu_seconds: u64) {}
