//! All commands. The program's arguments are one of them, or what the window opens.
//! `completions` writes them for a shell, `man` as manual pages.

use super::args::SequenceArgs;
use super::failure::{Failure, Outcome, print};
use super::search_options::{DEFAULTS_PLACE, ParamsFileArg};
use super::synth::{SynthArgs, SynthKind};
use crate::burst::{Burst, OpenOptions};
use crate::detector::REVISION;
use crate::monitor::Monitor;
use crate::synth::{Truth, synth_chart, synth_scene};
use clap::{Args, CommandFactory, Parser};
use std::path::PathBuf;
use std::sync::LazyLock;

/// Version, and what decides on the features: the revision of the detector. A build that is given its commit names it.
static VERSION: LazyLock<String> = LazyLock::new(|| {
    let commit = burstscope_core::COMMIT.map_or_else(String::new, |commit| format!("{commit}, "));
    format!("{} ({commit}detector {REVISION})", env!("CARGO_PKG_VERSION"))
});

/// Finds and shows burst features: what a burst of dark, noisy frames shows at every slope and scale.
///
/// Without a command the window opens, on INPUT or on the built-in demo burst. Where there is no display it is drawn
/// into a PNG file instead, and the strongest features are printed.
#[derive(Debug, Parser)]
#[command(
    version = VERSION.as_str(),
    args_conflicts_with_subcommands = true,
    after_long_help = format!("Examples:\n  burstscope                                       open the window on the demo burst\n  \
        burstscope night/                                open the window on a folder of frames\n  \
        burstscope night/ later/                         two bursts side by side, with their matches\n  \
        burstscope nights/                               a folder of bursts: a dataset\n  \
        burstscope film/ --burst-length 7                a long sequence, cut into bursts\n  \
        burstscope info night.ser                        what a file is: frames, size, bits, times\n  \
        burstscope detect night/ --out found             features of a burst as CSV\n  \
        burstscope detect nights/ --slopes-u -6:6:25 --out found --format csv,npz\n  \
        burstscope stack night/ --slope -2.1,0 --out sign.tiff\n  \
        burstscope slopes night/                         which slopes this burst needs\n  \
        burstscope probe night/ --at 412,230             why there is a feature there, or none\n  \
        burstscope report night/ --out night.pdf         all of that on one page\n  \
        burstscope match night/a night/b --out matched      two bursts, their matches, and a picture of them\n  \
        burstscope figures --out paper                   every figure of the paper, remade\n\n\
        Commands that search read your own defaults from {DEFAULTS_PLACE},\n\
        a parameter file that comes before --params. BURSTSCOPE_DEFAULTS names another one; if it is empty there is none.\n\n\
        Exit codes: 0 done, 1 failed, 2 wrong use, 130 interrupted.")
)]
pub struct Cli {
    /// What to open in the window: a folder of frames, image files, a multi-page TIFF, a .npy stack, or 'demo'; two of
    /// them side by side; or a folder of bursts, or several, as a dataset.
    #[arg(value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub sequence: SequenceArgs,
    /// Begin a lesson: one of out-of-the-dark, slope-is-depth, the-aperture, blobs-at-every-scale, what-noise-does,
    /// what-a-burst-costs, ghosts, when-it-fails, from-features-to-cameras, from-light-fields-to-bursts, or a
    /// lesson's file (or a folder of them, whose first is begun).
    #[cfg(feature = "app")]
    #[arg(long, value_name = "NAME", conflicts_with = "inputs")]
    pub lesson: Option<PathBuf>,
    /// The parameter file to begin with.
    #[command(flatten)]
    pub params: ParamsFileArg,
    #[command(flatten)]
    pub calibration: OpenOptions,
    /// The command.
    #[command(subcommand)]
    pub command: Option<Command>,
}

commands! {
    /// The commands.
    Command {
        Detect(super::args::DetectArgs) => super::detect::run;
        Info(super::info::InfoArgs) => super::info::run;
        Match(super::match_bursts::MatchArgs) => super::match_bursts::run;
        Stack(super::args::StackArgs) => super::stack::run;
        Merge(super::args::MergeArgs) => super::stack::run_merge;
        Slopes(super::probe::SlopesArgs) => super::probe::run_slopes;
        Probe(super::probe::ProbeArgs) => super::probe::run;
        Recover(super::recover::RecoverArgs) => super::recover::run;
        Decoys(super::probe::DecoysArgs) => super::probe::run_decoys;
        Report(super::burst_report::ReportArgs) => super::burst_report::run;
        #[cfg(feature = "app")]
        Film(super::film::FilmArgs) => super::film::run;
        Case(super::case::CaseArgs) => super::case::run;
        Synth(SynthArgs) => super::synth::run;
        Evaluate(super::evaluate::EvaluateArgs) => super::evaluate::run;
        Figures(super::figures::FiguresArgs) => super::figures::run;
        #[cfg(feature = "colmap")]
        Colmap(super::colmap::ColmapArgs) => super::colmap::run;
        #[cfg(feature = "app")]
        Render(super::render::RenderArgs) => super::render::run;
        Completions(CompletionsArgs) => run;
        Man(ManArgs) => run_man;
    }
}

/// Write what a shell needs to complete this program's commands and options.
///
/// It goes to the standard output. For bash, say, into a file that it reads at its start: burstscope completions bash >
/// ~/.local/share/bash-completion/completions/burstscope
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

const NAME: &str = "burstscope";

fn run(args: &CompletionsArgs) -> Outcome {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), NAME, &mut text);
    print(&String::from_utf8_lossy(&text)).map_err(Failure::output)
}

/// Write the manual page of the program or of a command.
///
/// It goes to the standard output, as man reads it. To read one: burstscope man detect | man -l -
#[derive(Debug, Args)]
pub struct ManArgs {
    /// The command, such as detect, or evaluate chart [default: the program].
    #[arg(value_name = "COMMAND")]
    pub command: Vec<String>,
}

fn run_man(args: &ManArgs) -> Outcome {
    let mut command = Cli::command().disable_help_subcommand(true);
    // A page names the command by the words before it too, which this fills in.
    command.build();
    for word in &args.command {
        let unknown = || format!("there is no command '{}'; 'burstscope --help' lists them", args.command.join(" "));
        command = command.find_subcommand(word).cloned().ok_or_else(|| Failure::usage(unknown()))?;
    }
    let mut page = Vec::new();
    let source = format!("{NAME} {}", env!("CARGO_PKG_VERSION"));
    clap_mangen::Man::new(command).source(source).render(&mut page).map_err(Failure::output)?;
    print(&String::from_utf8_lossy(&page)).map_err(Failure::output)
}

/// The burst that `synth` writes with these `arguments` (a chart or a scene and its options), with its mask.
pub fn synthetic_burst(arguments: &[String], monitor: &Monitor) -> Outcome<(Burst, Truth)> {
    // The folder is not used.
    let line = ["burstscope", "synth"].into_iter().chain(arguments.iter().map(String::as_str)).chain(["--out", "."]);
    let cli = Cli::try_parse_from(line).map_err(|error| {
        let text = error.to_string();
        let message = text.split("\n\n").next().unwrap_or_default();
        Failure::usage(message.trim_start_matches("error: ").replace('\n', " "))
    })?;
    let (burst, truth) = match cli.command {
        Some(Command::Synth(SynthArgs { kind: SynthKind::Chart(args) })) => synth_chart(&args.params, monitor)?,
        Some(Command::Synth(SynthArgs { kind: SynthKind::Scene(args) })) => synth_scene(&args.params, monitor)?,
        _ => return Err(Failure::usage("this makes no burst; make a chart or a scene")),
    };
    Ok((truth.masked(burst), truth))
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
        let scene = made("scene --width 64 --height 48 --frames 3 --layers 1 --max-slope 1").expect("a scene");
        assert_eq!(scene.0.len(), 3);
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
