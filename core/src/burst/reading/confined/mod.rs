//! Decoding in a separate process, so that a faulty third-party decoder cannot end the program.
//!
//! A decoder that asks for more memory than there is ends its whole process. So raw files, and pictures whose decoding
//! takes much memory, are decoded by a child process ([`serve_decoding`](crate::burst::serve_decoding)), with a limit
//! of memory and of time, which may read this file and nothing else. A failure of the child is an error about the file.

pub mod serve;
pub mod wire;

use super::{RawFrame, Reading};
use crate::error::{Error, ErrorKind, Result};
use crate::{burst::options::OpenOptions, monitor::Monitor};
use std::ffi::OsString;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};
use wire::{DecodeRequest, Part, receive_reply, send};

/// The program that decodes files in a separate process. It gets the arguments and a file's path, and must call
/// [`serve_decoding`](crate::burst::serve_decoding). Without one, decoding in this process may exhaust memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DecodeWorker {
    /// The program.
    pub program: PathBuf,
    /// Arguments before the path.
    pub arguments: Vec<OsString>,
}

static WORKER: OnceLock<DecodeWorker> = OnceLock::new();

impl DecodeWorker {
    /// Sets this program as the decoder for the whole process. False if one was set already, which stays.
    pub fn install(self) -> bool {
        WORKER.set(self).is_ok()
    }
}

/// Memory above which decoding is done in a child process, bytes. Raw files are decoded there in any case.
const LARGE_BYTES: u64 = 512 << 20;
/// Address space of a process before it decodes anything (code, libraries, stacks), bytes.
const BASE_BYTES: u64 = 512 << 20;
/// Processor time allowed for any file, seconds. The two rates below add to it. Far more than decoding takes.
const BASE_SECONDS: u64 = 10;
const PIXELS_A_SECOND: u64 = 250_000;
const FILE_BYTES_A_SECOND: u64 = 1_000_000;
/// Wall-clock time allowed, as a multiple of the allowed processor time: machines are busy.
const CLOCK_FACTOR: u64 = 4;
const POLL: Duration = Duration::from_millis(10);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    memory_bytes: u64,
    cpu_seconds: u64,
}

impl Budget {
    pub fn new(file_bytes: u64, pixels: u64, decoder_bytes: u64) -> Self {
        Self {
            memory_bytes: BASE_BYTES.saturating_add(decoder_bytes).saturating_add(file_bytes.saturating_mul(4)),
            cpu_seconds: BASE_SECONDS + file_bytes / FILE_BYTES_A_SECOND + pixels / PIXELS_A_SECOND,
        }
    }
}

/// Whether decoding that takes `bytes` is to be done in a child process, and a program for it is set.
pub fn takes(bytes: u64) -> bool {
    bytes > LARGE_BYTES && is_installed()
}

pub fn is_installed() -> bool {
    WORKER.get().is_some()
}

/// Decodes `part` of a file in a child process. An end without an answer is damage, unless others ended the child.
pub fn decode(reading: Reading<'_>, kind: &'static str, part: Part, budget: Budget) -> Result<RawFrame> {
    let Reading { path, expected, options, ticker } = reading;
    let monitor = ticker.monitor();
    monitor.check()?;
    let worker = WORKER.get().ok_or_else(|| Error::unread(path, "no program is set that decodes it"))?;
    let mut running = Running::start(worker, path)?;
    let request = DecodeRequest {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        part,
        expected: expected.map(|expected| (expected.first.to_string_lossy().into_owned(), expected.size)),
        // This process calibrates, so the child needs no other file.
        options: OpenOptions { bias: None, flat: None, ..options.clone() },
        limits: options.limits,
        memory_bytes: budget.memory_bytes,
        cpu_seconds: budget.cpu_seconds,
    };
    let (mut stdin, mut stdout, stderr) = running.pipes();
    let until = Instant::now() + Duration::from_secs(budget.cpu_seconds.saturating_mul(CLOCK_FACTOR));
    // Writing to a child that has already ended fails; its last output is read below.
    let ask = || send(&mut stdin, &request).and_then(|()| receive_reply(&mut stdout, path, &options.limits));
    let answer = running.watched(path, monitor, Some(until), ask)?;
    // The child ends when its input is closed.
    drop(stdin);
    monitor.check()?;
    let is_overdue = Instant::now() >= until;
    match answer {
        Ok(answer) => answer,
        Err(error) => Err(match running.last_words(&error, stderr, is_overdue, budget) {
            Ending::OfFile(reason) => Error::corrupt(path, kind, reason),
            Ending::FromOutside(signal) => {
                let problem = format!(
                    "the decoder of this {kind} file was ended by signal {signal}, from outside or because the machine \
                     has no memory left"
                );
                Error::new(ErrorKind::System, problem, "open it again").about(path)
            }
        }),
    }
}

enum Ending {
    /// The file is the cause, as the end of a sentence about it.
    OfFile(String),
    /// A signal that no decoder sends itself.
    FromOutside(i32),
}

/// A child process, which is killed when it is dropped.
pub struct Running {
    child: Mutex<Child>,
}

impl Running {
    fn start(worker: &DecodeWorker, path: &Path) -> Result<Self> {
        let mut command = Command::new(&worker.program);
        command.args(&worker.arguments).arg(path);
        // One thread, and one arena of the allocator: more would take address space that the file needs.
        command.env("RAYON_NUM_THREADS", "1").env("MALLOC_ARENA_MAX", "1").env("RUST_BACKTRACE", "0");
        Self::spawn(command, path)
    }

    pub fn spawn(mut command: Command, path: &Path) -> Result<Self> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // Signals from the terminal (Ctrl-C) are for the program, which ends its children itself.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        #[cfg(windows)]
        {
            // Without it a program that has no console would show one for each file.
            const CREATE_NO_WINDOW: u32 = 0x0800_0000;
            std::os::windows::process::CommandExt::creation_flags(&mut command, CREATE_NO_WINDOW);
        }
        let failed = |e| Error::unread(path, format!("the process for it could not be started: {e}"));
        Ok(Self { child: Mutex::new(command.spawn().map_err(failed)?) })
    }

    /// Does `work`; another thread kills the child at a cancellation, or at the time `until`.
    pub fn watched<T>(
        &self,
        path: &Path,
        monitor: &Monitor,
        until: Option<Instant>,
        work: impl FnOnce() -> T,
    ) -> Result<T> {
        // The watch ends when `over` is dropped.
        let (over, is_over) = mpsc::channel::<()>();
        let watch = move || {
            while is_over.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
                if monitor.is_cancelled() || until.is_some_and(|until| Instant::now() >= until) {
                    self.kill();
                    return;
                }
            }
        };
        std::thread::scope(|scope| {
            let _over = over; // also when the work unwinds
            let watching = std::thread::Builder::new().spawn_scoped(scope, watch);
            watching.map_err(|e| Error::unread(path, format!("a thread could not be started: {e}")))?;
            Ok(work())
        })
    }

    pub fn kill(&self) {
        let mut child = self.child.lock().unwrap_or_else(PoisonError::into_inner);
        // The child's own processes hold the pipes open; they belong to the child's process group.
        #[cfg(unix)]
        if matches!(child.try_wait(), Ok(None)) {
            use rustix::process::{Pid, Signal, kill_process_group};
            let group = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
            let _ = group.map(|group| kill_process_group(group, Signal::KILL));
        }
        // Fails for a child that has ended.
        let _ = child.kill();
    }

    pub fn ends_well(&mut self) -> bool {
        self.child.get_mut().unwrap_or_else(PoisonError::into_inner).wait().is_ok_and(|status| status.success())
    }

    pub fn pipes(&mut self) -> (ChildStdin, ChildStdout, ChildStderr) {
        let child = self.child.get_mut().unwrap_or_else(PoisonError::into_inner);
        let pipes = child.stdin.take().zip(child.stdout.take()).zip(child.stderr.take());
        let ((stdin, stdout), stderr) = pipes.expect("it was started with these pipes, and nobody took them");
        (stdin, stdout, stderr)
    }

    fn last_words(&mut self, error: &io::Error, stderr: ChildStderr, is_overdue: bool, budget: Budget) -> Ending {
        let child = self.child.get_mut().unwrap_or_else(PoisonError::into_inner);
        // The child is ending by itself, or it sent something else than an answer and is killed.
        let is_ending = matches!(error.kind(), io::ErrorKind::UnexpectedEof | io::ErrorKind::BrokenPipe);
        if !is_ending {
            let _ = child.kill();
        }
        let mut words = String::new();
        let _ = stderr.take(4096).read_to_string(&mut words);
        let status = child.wait();
        if is_overdue || status.as_ref().is_ok_and(is_out_of_time) {
            return Ending::OfFile(format!("its decoder was not done after {} seconds", budget.cpu_seconds));
        }
        // The standard library prints this before it aborts.
        let asked = words.split("memory allocation of ").nth(1);
        if let Some(bytes) = asked.and_then(|rest| rest.split(' ').next()?.parse::<u64>().ok()) {
            let (asked, all) = (bytes.div_ceil(1 << 20), budget.memory_bytes >> 20);
            return Ending::OfFile(format!(
                "its decoder asked for {asked} MiB of memory, and may have {all} MiB in all"
            ));
        }
        match status {
            Ok(status) => match signal_from_outside(&status).filter(|_| is_ending) {
                Some(signal) => Ending::FromOutside(signal),
                None => Ending::OfFile(format!("its decoder failed unexpectedly ({status})")),
            },
            Err(_) => Ending::OfFile("its decoder failed unexpectedly".to_owned()),
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.kill();
        self.ends_well();
    }
}

#[cfg(unix)]
fn is_out_of_time(status: &ExitStatus) -> bool {
    use std::os::unix::process::ExitStatusExt;
    status.signal() == Some(rustix::process::Signal::XCPU.as_raw())
}

#[cfg(not(unix))]
fn is_out_of_time(_: &ExitStatus) -> bool {
    false
}

/// Number of the signal that ended the process, unless the process raises such a signal by what it does.
#[cfg(unix)]
fn signal_from_outside(status: &ExitStatus) -> Option<i32> {
    use rustix::process::Signal;
    use std::os::unix::process::ExitStatusExt;
    let own = [Signal::ABORT, Signal::BUS, Signal::FPE, Signal::ILL, Signal::SEGV, Signal::SYS, Signal::TRAP];
    status.signal().filter(|signal| !own.iter().any(|own| own.as_raw() == *signal))
}

#[cfg(not(unix))]
fn signal_from_outside(_: &ExitStatus) -> Option<i32> {
    None
}
