//! The commands: what the window can compute, a command can.
//!
//! Raw arguments are described in [`args`] and turned once into checked values (see [`search_options`]); each command is a module of its own
//! that calls the same functions as the window. Results go to the standard output, progress and errors to the standard error.
//!
//! Exit codes: 0 done, 1 failed, 2 wrong use, 130 interrupted.

pub mod args;
mod choices;
mod colmap;
pub mod colmap_args;
mod console;
mod detect;
mod evaluate;
pub mod evaluate_args;
pub mod evaluate_matches;
pub mod evaluate_poses;
mod evaluate_tables;
mod failure;
mod inputs;
pub mod match_args;
mod match_bursts;
pub mod matching_args;
mod merge;
mod render;
mod report;
pub mod search_options;
mod stack;
mod synth;
pub mod synth_args;
mod table;
pub mod trajectory_args;
mod window;

pub use failure::Failure;

use args::{Cli, Command};
use clap::Parser;
use std::process::ExitCode;

/// Does what the program's arguments ask for, and answers with its exit code.
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are "errors" of clap that go to the standard output with code 0; wrong use is 2.
            let code = if error.use_stderr() { 2 } else { 0 };
            // A closed pipe is no reason to complain about a help page.
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    let result = match &cli.command {
        None => window::open(&cli),
        Some(Command::Detect(args)) => detect::run(args),
        Some(Command::Match(args)) => match_bursts::run(args),
        Some(Command::Merge(args)) => merge::run(args),
        Some(Command::Stack(args)) => stack::run(args),
        Some(Command::Synth(args)) => synth::run(args),
        Some(Command::Evaluate(args)) => evaluate::run(args),
        Some(Command::Colmap(args)) => colmap::run(args),
        Some(Command::Render(args)) => render::run(args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.print();
            failure.exit_code()
        }
    }
}
