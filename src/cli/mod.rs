//! Commands: everything that the window computes, a command computes too.
//!
//! [`args`] and its sister modules describe raw arguments, which are turned once into checked values; each command
//! calls the same functions as the window. Results go to the standard output, progress and errors to the standard
//! error. Exit codes: 0 done, 1 failed, 2 wrong use, 130 interrupted.

/// Declares commands, each by its arguments and its function; the help of a command is that of its arguments.
macro_rules! commands {
    ($(#[$about:meta])* $name:ident { $($(#[$when:meta])* $command:ident($($args:ident)::+) => $run:path;)* }) => {
        $(#[$about])*
        #[derive(Debug, clap::Subcommand)]
        pub enum $name {
            $($(#[$when])* $command($($args)::+),)*
        }

        impl $name {
            pub(super) fn run(&self) -> $crate::cli::Outcome {
                match self {
                    $($(#[$when])* Self::$command(args) => $run(args),)*
                }
            }
        }
    };
}

pub mod args;
pub mod burst_report;
pub mod case;
#[cfg(feature = "colmap")]
pub mod colmap;
pub mod commands;
mod console;
mod detect;
mod evaluate;
pub mod evaluate_frames;
pub mod evaluate_matches;
pub mod evaluate_poses;
mod evaluate_tables;
mod failure;
mod figures;
#[cfg(feature = "app")]
pub mod film;
pub mod info;
mod inputs;
pub mod match_bursts;
pub mod matching_args;
#[cfg(feature = "app")]
mod opening;
pub mod probe;
pub mod recover;
#[cfg(feature = "app")]
pub mod render;
mod report;
pub mod search_options;
pub mod set_up;
mod signals;
mod stack;
pub mod study;
pub mod synth;
#[cfg(feature = "app")]
mod window;

pub use commands::synthetic_burst;
pub use failure::{Failure, Outcome};
pub use probe::{probe_document, slopes_document};
pub use report::burst_document;

use crate::burst::{DecodeWorker, serve_decoding};
use crate::files::MAX_INTEGER;
use crate::plane::memory;
use args::{BurstSearchArgs, BurstsArgs, INPUT_HELP, OutputArgs, OverwriteArgs, SequenceArgs};
use clap::{ArgMatches, CommandFactory, FromArgMatches};
use commands::Cli;
use console::{Both, Console, document};
use inputs::{Input, OneBurst, check_ending, open_options, opened, resolve, resolve_bursts, resolve_one, resolve_pair};
use matching_args::MatchingArgs;
use search_options::SearchArgs;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// First argument of a process that decodes one file for another process; it is no command and in no help.
pub const DECODE_WORKER: &str = "--decode-worker";

pub fn run() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let worker = this_program().map(|program| DecodeWorker { program, arguments: vec![DECODE_WORKER.into()] });
    ExitCode::from(run_in(&arguments, worker, Host::Program))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Host {
    Program,
    Other,
}

/// In the process `host`; files are decoded by `worker`. Returns the exit code.
pub fn run_in(arguments: &[OsString], worker: Option<DecodeWorker>, host: Host) -> u8 {
    // Before all else: a worker decodes foreign bytes, and neither parses options nor opens a window.
    if arguments.get(1).is_some_and(|first| first == DECODE_WORKER) {
        return arguments.get(2).map_or(2, |path| serve_decoding(Path::new(path)));
    }
    if let Some(worker) = worker {
        worker.install();
    }
    let parsed = Cli::command().try_get_matches_from(arguments);
    let cli = match parsed.and_then(|matches| kept_integers(&matches).and_then(|()| Cli::from_arg_matches(&matches))) {
        Ok(cli) => cli,
        Err(error) => {
            // A closed pipe is no reason to complain about a help page.
            let _ = error.print();
            // Help and version are "errors" of clap that go to the standard output with code 0; wrong use is 2.
            return if error.use_stderr() { 2 } else { 0 };
        }
    };
    #[cfg(all(feature = "app", target_os = "linux"))]
    if host == Host::Program {
        window::without_messages_on_displays(&cli);
    }
    #[cfg(not(all(feature = "app", target_os = "linux")))]
    let _ = host;
    signals::survive_file_size_limit();
    match memory::refusable(|| done(&cli)).unwrap_or_else(|refused| Err(refused.into())) {
        Ok(()) => 0,
        Err(failure) => {
            failure.print();
            failure.exit_code()
        }
    }
}

/// Refuses numbers that no file could keep; those in texts are refused where these are read.
fn kept_integers(matches: &ArgMatches) -> Result<(), clap::Error> {
    for id in matches.ids().map(clap::Id::as_str) {
        let wide = matches.try_get_many::<u64>(id).ok().flatten().into_iter().flatten().copied();
        let sized = matches.try_get_many::<usize>(id).ok().flatten().into_iter().flatten().map(|number| *number as u64);
        if let Some(number) = wide.chain(sized).find(|number| *number > MAX_INTEGER) {
            let name = id.replace('_', "-");
            let problem = format!("--{name}: {number} is more than {MAX_INTEGER}, the largest number there is here");
            return Err(Cli::command().error(clap::error::ErrorKind::ValueValidation, problem));
        }
    }
    matches.subcommand().map_or(Ok(()), |(_, matches)| kept_integers(matches))
}

fn this_program() -> Option<PathBuf> {
    // On Linux this is the running program even after its file was replaced.
    let running = Path::new("/proc/self/exe");
    if running.exists() { Some(running.to_owned()) } else { std::env::current_exe().ok() }
}

fn done(cli: &Cli) -> Outcome {
    match &cli.command {
        Some(command) => command.run(),
        #[cfg(feature = "app")]
        None => window::open(cli),
        #[cfg(not(feature = "app"))]
        None => Err(Failure::usage("this program was built without its window (the feature 'app'); name a command")),
    }
}
