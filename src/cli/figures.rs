//! `figures`: remakes every figure and table of the paper.

use super::study::once_each;
use super::{Console, Failure, Outcome, OutputArgs};
use crate::figures::{FigureSize, FiguresEvent, FiguresJob, PaperFigure, find_colmap};
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;

/// Remake every figure and table of the paper, from our own material.
///
/// Charts, scenes and trajectories of our own making, whose truth is known exactly, take the place of the paper's
/// photographs. Each figure is a picture (SVG) with its numbers beside it (CSV), and index.html shows all of them.
/// Where COLMAP is not installed, reconstructions (columns of tables 1 to 3, fig8) are marked as missing. Finished
/// figures are kept: run the command again to go on after an interruption.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = FIGURES_HELP)]
pub struct FiguresArgs {
    /// Folder for the figures, made if it is missing.
    #[arg(long, short, value_name = "DIR")]
    pub out: PathBuf,
    /// Only these, separated by commas: fig1 to fig9, table1 to table3.
    #[arg(long, value_name = "FIGURE,…", value_delimiter = ',', value_parser = PaperFigure::from_str)]
    pub only: Vec<PaperFigure>,
    /// Use very little material, for a quick look at all figures and not to measure.
    #[arg(long)]
    pub quick: bool,
    /// Leave COLMAP out even where it is installed.
    #[arg(long)]
    pub no_colmap: bool,
    #[command(flatten)]
    pub output: OutputArgs,
}

const FIGURES_HELP: &str = "\
Files: NAME.svg and NAME.csv for each figure, index.html, and records/, by which finished figures are known again. About two minutes on two cores without COLMAP.

JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"figures\", \"page\", \"size\": full or quick, \"figures\": [{\"figure\", \"files\": [path], \"notes\": [sentence], \"resumed\", \"seconds\"}]}";

pub(super) fn run(args: &FiguresArgs) -> Outcome {
    if args.out.exists() && !args.out.is_dir() {
        let problem = "--out: this is not a folder; name a folder for the figures";
        return Err(Failure::usage(format!("{problem}: {}", args.out.display())));
    }
    let job = FiguresJob {
        out: args.out.clone(),
        only: once_each(&args.only),
        size: if args.quick { FigureSize::Quick } else { FigureSize::Full },
        colmap: if args.no_colmap { None } else { find_colmap() },
    };
    let console = Console::new(&args.output)?;
    console.show_time_left();
    // An event returns no error: a closed output is kept until the work is done.
    let mut said = Ok(());
    let mut on = |event: FiguresEvent<'_>| match event {
        FiguresEvent::Begin { figure, index, count } => {
            console.go_on(format!("[{}/{count}] {}: ", index + 1, figure.name()));
        }
        FiguresEvent::Done(report) => {
            let how =
                if report.resumed { "from an earlier run".to_owned() } else { format!("{:.0} s", report.seconds) };
            let notes: String = report.notes.iter().map(|note| format!("    {note}\n")).collect();
            let line = format!("{} ({how})\n{notes}", report.figure.title());
            said = std::mem::replace(&mut said, Ok(())).and_then(|()| console.say(&line));
        }
    };
    let report = job.run(&mut on, &console.monitor)?;
    said?;
    console.say(&format!("\nwrote {}\n", report.page.display()))?;
    console.say_document("figures", &report)
}
