//! `completions`: writes a shell's completions of commands and options.

use super::commands::{Cli, CompletionsArgs};
use super::failure::Failure;
use super::terminal::print;
use clap::CommandFactory;

/// Name of the program, as typed.
const NAME: &str = "burstscope";

pub(super) fn run(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), NAME, &mut text);
    print(&String::from_utf8_lossy(&text)).map_err(Failure::output)
}
