//! `evaluate frames`: measures how results depend on the number of frames, on charts or in a given burst.

use super::evaluate_tables::{burst_frames_table, burst_frames_text, chart_text, methods_table};
use super::study::{
    ChartsArgs, ComparedArgs, FIGURE_FILE, TableArgs, chart_study, check_figures, figure_file, write_figure,
};
use super::{BurstSearchArgs, Console, Failure, INPUT_HELP, Input, Outcome, open_options, resolve_one, resolve_pair};
use crate::burst::Burst;
use crate::detector::params::doc;
use crate::evaluate::chart::FRAME_COUNTS;
use crate::evaluate::curves::{burst_frames_figure, frames_figure};
use crate::evaluate::{BurstFramesStudy, RowStudy};
use crate::export::OutputRules;
use crate::inspect::result::truth_of;
use clap::Args;
use std::path::{Path, PathBuf};

/// Count what is found with few frames and with many, on charts or in a burst.
///
/// Without INPUT every method runs on charts of discs with each number of frames, as in 'evaluate chart'. With INPUT
/// its middle frames are taken as a burst: 2 of them, 3, … all. The table has the number of features, how many the
/// search of all frames confirms, how many are false by its truth.json, and, with SECOND, the matches with as many of
/// its middle frames.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = FRAMES_HELP)]
pub struct FramesArgs {
    // clap gives no group to a struct that flattens another, so the arguments of ChartsArgs are named one by one.
    #[arg(value_name = "INPUT", help = INPUT_HELP, conflicts_with_all = ["seeds", "seed", "motion", "DiscsArgs", "ComparedArgs", "snr"])]
    pub input: Option<PathBuf>,
    /// A second burst of the same scene, to be matched with INPUT by the parameters that 'match' has without options.
    #[arg(value_name = "SECOND")]
    pub second: Option<PathBuf>,
    /// Numbers of frames, separated by commas [default: 2,3,4,5,6,8,10,12,15 for charts, 2 to all for INPUT].
    #[arg(long, value_name = "N,…", value_delimiter = ',')]
    pub frame_counts: Vec<usize>,
    /// Signal-to-noise ratio of one pixel in one frame of a chart; 'inf' makes no noise.
    #[arg(long, value_name = "RATIO", default_value_t = 0.6)]
    pub snr: f64,
    #[command(flatten)]
    pub compared: ComparedArgs,
    /// Draw what was found over the number of frames, or write its points as CSV or LaTeX (.tex).
    #[arg(long, value_name = FIGURE_FILE, value_parser = figure_file())]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    pub charts: ChartsArgs,
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[command(flatten)]
    pub file: TableArgs,
}

const FRAMES_HELP: &str = "\
JSON (--json) of charts: that of 'evaluate chart' with
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"evaluate frames\", \"snr\", …, \"rows\": [{\"frames\", \"methods\": [{as there}]}]}
JSON (--json) of INPUT:
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"evaluate frames\", \"burst\", \"second\", \"detector\": {as in the parameter file}, \"second_slopes\", \"features\", \"discs\",
   \"rows\": [{\"frames\", \"first_frame\", \"features\", \"confirmed\", \"unconfirmed\", \"discs_found\", \"false_features\",
     \"matches\": null or {\"keypoints_a\", \"keypoints_b\", \"putative\", \"inliers\"}}]}";

pub(super) fn run(args: &FramesArgs) -> Outcome {
    args.input.as_ref().map_or_else(|| charts(args), |input| burst(args, input))
}

fn rules(args: &FramesArgs, inputs: &[Input]) -> OutputRules {
    args.file.overwrite.rules(inputs, &args.run.calibration, &[args.run.search.file.params.as_ref()])
}

fn charts(args: &FramesArgs) -> Outcome {
    if args.run.search.gives(&doc::FRAMES) {
        let problem = "charts have as many frames as --frame-counts says; leave it out";
        return Err(Failure::usage(format!("--{}: {problem}", doc::FRAMES.name)));
    }
    if !args.run.calibration.is_plain() {
        return Err(Failure::usage(
            "--bias and what else calibrates files: charts have none; leave it out, or name a burst",
        ));
    }
    let counts = if args.frame_counts.is_empty() { FRAME_COUNTS.to_vec() } else { args.frame_counts.clone() };
    let study = chart_study(&args.charts, &args.compared, &args.run.search, (vec![args.snr], counts))?;
    let console = Console::new(&args.run.output)?;
    let rules = rules(args, &[]);
    check_figures([&args.plot, &args.file.table], &rules)?;
    let report = study.run(&console.monitor)?;
    console.say(&chart_text(&report))?;
    write_figure(&console, args.plot.as_deref(), &rules, || frames_figure(&report))?;
    write_figure(&console, args.file.table.as_deref(), &rules, || methods_table(&report).into())?;
    console.say_document("evaluate frames", &report)
}

fn burst(args: &FramesArgs, input: &Path) -> Outcome {
    let study = BurstFramesStudy {
        search: args.run.search.params()?,
        frame_counts: args.frame_counts.clone(),
        ..BurstFramesStudy::default()
    };
    let console = Console::new(&args.run.output)?;
    let options = args.run.calibration.clone();
    let inputs = match &args.second {
        Some(second) => resolve_pair(input, second, &options)?,
        None => vec![resolve_one(&[input.to_owned()], "evaluate frames", &options)?],
    };
    let options = open_options(&inputs, &args.run.calibration)?;
    let rules = rules(args, &inputs);
    check_figures([&args.plot, &args.file.table], &rules)?;
    let silent = console.monitor.silent();
    let bursts = inputs.iter().map(|i| i.open(&options, &silent)).collect::<Result<Vec<Burst>, _>>()?;
    let truth = truth_of(&bursts[0]).map_err(|e| Failure::Failed(e.into()))?;
    let report = study.run(&bursts[0], bursts.get(1), truth.as_ref(), &console.monitor)?;
    console.say(&burst_frames_text(&report))?;
    write_figure(&console, args.plot.as_deref(), &rules, || burst_frames_figure(&report))?;
    write_figure(&console, args.file.table.as_deref(), &rules, || burst_frames_table(&report).into())?;
    console.say_document("evaluate frames", &report)
}
