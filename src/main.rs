//! The program: the window, or a command. See [`burstscope::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    burstscope::cli::run()
}
