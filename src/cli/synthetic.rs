//! Synthetic bursts in memory, from the options of `synth`, for programs that hold this one as a library.

use super::commands::{Cli, Command};
use super::failure::Failure;
use super::synth::{SynthArgs, SynthKind};
use crate::burst::Burst;
use crate::monitor::Monitor;
use crate::synth::{Truth, synth_chart, synth_scene};
use clap::Parser;

/// The burst that `synth` writes with these `arguments` (a chart or a scene and its options), with its mask.
pub fn synthetic_burst(arguments: &[String], monitor: &Monitor) -> Result<(Burst, Truth), Failure> {
    // The folder is not used.
    let line = ["burstscope", "synth"].into_iter().chain(arguments.iter().map(String::as_str)).chain(["--out", "."]);
    let (burst, truth) = match parsed(line)?.command {
        Some(Command::Synth(SynthArgs { kind: SynthKind::Chart(args) })) => synth_chart(&args.params, monitor)?,
        Some(Command::Synth(SynthArgs { kind: SynthKind::Scene(args) })) => synth_scene(&args.params, monitor)?,
        _ => return Err(Failure::usage("this makes no burst; make a chart or a scene")),
    };
    Ok((truth.masked(burst), truth))
}

fn parsed<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Result<Cli, Failure> {
    Cli::try_parse_from(arguments).map_err(|error| {
        let text = error.to_string();
        let message = text.split("\n\n").next().unwrap_or_default();
        Failure::usage(message.trim_start_matches("error: ").replace('\n', " "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(line: &str) -> Result<(Burst, Truth), String> {
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        synthetic_burst(&words, &Monitor::default()).map_err(|failure| format!("{failure:?}"))
    }

    #[test]
    fn a_chart_and_a_scene_are_made_and_nonsense_is_told_in_a_line() {
        let (burst, truth) =
            made("chart --width 64 --height 48 --discs 1 --radius 3.6:6 --frames 2 --max-slope 1").expect("a chart");
        assert_eq!((burst.len(), burst.size(), truth.features.len()), (2, (64, 48), 1));
        assert_eq!(
            made("scene --width 64 --height 48 --frames 3 --layers 1 --max-slope 1").expect("a scene").0.len(),
            3
        );
        for (line, words) in [
            ("chart --width 3", "give 16 to 32768"),
            ("chart --widht 64", "unexpected argument '--widht'"),
            ("trajectory", "make a chart or a scene"),
        ] {
            let error = made(line).expect_err(line);
            assert!(error.contains(words) && !error.contains("\\n"), "{error}");
        }
    }
}
