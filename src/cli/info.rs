//! `info`: what an input is, from the headers of its files.

use super::report::FailureReport;
use super::{Both, Console, Failure, INPUT_HELP, Outcome, OutputArgs, document, open_options, resolve};
use crate::burst::{Info, OpenOptions};
use clap::Args;
use std::path::PathBuf;

/// Say what an input is: frames, size, bits, times, and what was guessed.
///
/// Only headers are read, and of a raw file, which declares little, the frame. Files are opened with the options of the
/// other commands.
#[derive(Debug, Args)]
#[command(after_long_help = INFO_HELP)]
pub struct InfoArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    pub inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub calibration: OpenOptions,
    #[command(flatten)]
    pub output: OutputArgs,
}

const INFO_HELP: &str = "\
JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"info\", \"bursts\": [{\"inputs\": [path], \"name\", \"kind\", \"files\", \"frames\", \"width\", \"height\", \"samples\", \"is_colour\",
     \"binning\", \"times_s\": [s from the first frame] and \"begins\" (UTC) where the files say it,
     \"positions\": [frame intervals from the first frame] and \"interval_s\" where files, names or a list say it, \"are_times_used\",
     \"views\": [rows, columns] of a light field, \"taken\": [what was guessed or chosen]}],
   \"failures\": [{\"name\", \"error\"}]}";

pub(super) fn run(args: &InfoArgs) -> Outcome {
    let console = Console::new(&args.output)?;
    let inputs = resolve(&args.inputs, &args.calibration);
    let mut options = open_options(&inputs, &args.calibration)?;
    // Headers alone are read, also of recordings of which only a part can be opened.
    options.limits.max_frames = usize::MAX;
    let (mut bursts, mut failures) = (Vec::new(), Vec::new());
    for input in inputs {
        let name = input.name.clone();
        match input.source.clone().and_then(|source| source.info(&options, &console.monitor)) {
            Ok(info) => {
                let info = Info { name, ..info };
                console.say(&info.text())?;
                bursts.push(Both { one: document! { inputs: input.path_texts() }, other: info });
            }
            Err(error) if error.is_cancelled() => return Err(Failure::Interrupted),
            Err(error) => {
                console.complain(&format!("{name}: {error}"));
                failures.push(FailureReport { name, error: error.to_string() });
            }
        }
    }
    console.say_document("info", &document! { bursts, failures: &failures })?;
    if failures.is_empty() { Ok(()) } else { Err(Failure::Reported) }
}
