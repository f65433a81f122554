//! `evaluate`: measures the detector against known truth.

use super::evaluate_tables::{
    accuracy_table, accuracy_text, advice_tables, chart_text, methods_table, noise_table, noise_text,
};
use super::study::{
    ChartsArgs, ComparedArgs, FIGURE_FILE, StudySearch, TableArgs, chart_study, check_figures, figure_file, searched,
    write_figure,
};
use super::{
    Both, Console, Outcome, OutputArgs, SearchArgs, document, evaluate_frames, evaluate_matches, evaluate_poses,
};
use crate::burst::{OpenOptions, ViewGrid};
use crate::detector::{DetectorParams, Method};
use crate::evaluate::accuracy::discs_apart;
use crate::evaluate::advice::AdviceStudy;
use crate::evaluate::curves::roc_figure;
use crate::evaluate::pure_noise::{NoiseLevel, NoiseSearch};
use crate::evaluate::{AccuracyStudy, NoiseStudy, RowStudy};
use crate::synth::{NoiseCase, NoiseKind};
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;

/// Measure the detector on synthetic bursts whose truth is known, and camera poses against true ones.
#[derive(Debug, Args)]
pub struct EvaluateArgs {
    /// What to measure.
    #[command(subcommand)]
    pub study: EvaluateStudy,
}

commands! {
    /// The studies.
    EvaluateStudy {
        Chart(EvaluateChartArgs) => chart;
        Frames(evaluate_frames::FramesArgs) => evaluate_frames::run;
        Accuracy(AccuracyArgs) => accuracy;
        Noise(NoiseArgs) => noise;
        Advice(AdviceArgs) => advice;
        Matches(evaluate_matches::MatchesArgs) => evaluate_matches::run;
        Poses(evaluate_poses::PosesArgs) => evaluate_poses::run;
    }
}

pub(super) fn run(args: &EvaluateArgs) -> Outcome {
    args.study.run()
}

fn chart(args: &EvaluateChartArgs) -> Outcome {
    let mut study = chart_study(&args.charts, &args.compared, &args.search, (args.snr.clone(), Vec::new()))?;
    study.chart.uneven.views = args.views;
    let console = Console::new(&args.output)?;
    let rules = args.file.overwrite.rules(&[], &OpenOptions::default(), &[args.search.file.params.as_ref()]);
    check_figures([&args.plot, &args.file.table], &rules)?;
    let report = study.run(&console.monitor)?;
    console.say(&chart_text(&report))?;
    write_figure(&console, args.plot.as_deref(), &rules, || roc_figure(&report, 0))?;
    write_figure(&console, args.file.table.as_deref(), &rules, || methods_table(&report).into())?;
    console.say_document("evaluate chart", &report)
}

fn accuracy(args: &AccuracyArgs) -> Outcome {
    let StudySearch { detector, slopes, .. } = searched(&args.search)?;
    let default = AccuracyStudy::with_motion(args.charts.motion);
    let study = AccuracyStudy {
        chart: args.charts.params(args.max_slope),
        snrs: args.snr.clone(),
        first_seed: args.charts.seed,
        seeds: args.charts.seeds,
        detector: DetectorParams { slopes: slopes.unwrap_or(default.detector.slopes), ..detector },
    };
    let console = Console::new(&args.output)?;
    let rules = args.file.checked(&args.search)?;
    let crowded = study.run(&console.monitor)?;
    let apart = match args.apart_discs.unwrap_or_else(|| discs_apart(&study.chart)) {
        0 => None,
        discs => Some(study.standing_apart(discs).run(&console.monitor)?),
    };
    console.say(&accuracy_text(&crowded, apart.as_ref()))?;
    let named = [("crowded", Some(&crowded)), ("apart", apart.as_ref())];
    let named: Vec<_> = named.into_iter().filter_map(|(charts, report)| Some((charts, report?))).collect();
    write_figure(&console, args.file.table.as_deref(), &rules, || accuracy_table(&named).into())?;
    let other = apart.as_ref().map(|apart| document! { apart });
    console.say_document("evaluate accuracy", &Both { one: &crowded, other })
}

fn noise(args: &NoiseArgs) -> Outcome {
    let StudySearch { detector, slopes, .. } = searched(&args.search)?;
    let one = |label: &str| {
        let detector = DetectorParams { slopes: slopes.unwrap_or(detector.slopes), ..detector.clone() };
        vec![NoiseSearch { label: label.to_owned(), detector }]
    };
    let searches = match (detector.method, slopes) {
        (Method::Sift, _) => one("SIFT"),
        (Method::Merge, _) => one("SIFT, merged"),
        (Method::Buff, Some(slopes)) => one(if slopes.is_plane() { "BuFF 2D" } else { "BuFF 1D" }),
        (Method::Buff, None) => NoiseStudy::searches(&detector),
    };
    let white = args.bits.iter().flat_map(|bits| args.sigma.iter().map(|&sigma| NoiseLevel::white(sigma, *bits)));
    let of_case = |case: NoiseKind| NoiseLevel { case, sigma: args.case_sigma, bits: None, mean: args.case_level };
    // Named kinds take the place of white noise; without names all kinds are measured.
    let all = NoiseCase::all().into_iter().filter(|case| *case != NoiseCase::White).map(NoiseKind::from);
    let levels = match (args.study.cases, &args.case[..]) {
        (Some(count), _) => NoiseStudy::drawn_levels(count, args.study.first_seed),
        (None, []) => white.chain(all.map(of_case)).collect(),
        (None, cases) => cases.iter().copied().map(of_case).collect(),
    };
    let study = NoiseStudy { levels, searches, ..args.study.clone() };
    let console = Console::new(&args.output)?;
    let rules = args.file.checked(&args.search)?;
    let mut report = study.run(&console.monitor)?;
    let mut drawn = None;
    if args.study.cases.is_some() {
        // The largest of many is large by chance, so the worst are measured again.
        let again = study.again(&report, 10).run(&console.monitor)?;
        drawn = Some(std::mem::replace(&mut report, again));
    }
    console.say(&noise_text(&report, drawn.as_ref()))?;
    write_figure(&console, args.file.table.as_deref(), &rules, || noise_table(&report).into())?;
    console.say_document("evaluate noise", &Both { one: document! { drawn }, other: &report })
}

fn advice(args: &AdviceArgs) -> Outcome {
    let console = Console::new(&args.output)?;
    let report = args.study.run(&console.monitor)?;
    console.say(&advice_tables(&report))?;
    console.say_document("evaluate advice", &report)
}

/// Count the discs that each method finds in the dark.
///
/// Charts of discs are made for every ratio and seed, and all methods run on them with the same parameters. A feature
/// finds a disc when it lies within half the radius plus 1.5 px of it at mid-burst and its scale is within a factor of
/// 2 of r/√2; repeats are false. The table shows the discs found at the threshold where a tenth of the detections are
/// false, and what is found at the default threshold.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = CHART_HELP)]
pub struct EvaluateChartArgs {
    /// Signal-to-noise ratios of one pixel in one frame, separated by commas; 'inf' makes no noise.
    #[arg(long, value_name = "RATIO,…", value_delimiter = ',', default_value = "0.2,0.35,0.6")]
    pub snr: Vec<f64>,
    /// Rows and columns of the views of a light field, such as 9x9, in the place of the ten frames of a chart.
    #[arg(long, value_name = "ROWSxCOLUMNS")]
    pub views: Option<ViewGrid>,
    #[command(flatten)]
    pub compared: ComparedArgs,
    /// Draw the curves of true against false features, one panel a ratio, or write their points as CSV or LaTeX (.tex).
    #[arg(long, value_name = FIGURE_FILE, value_parser = figure_file())]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    pub charts: ChartsArgs,
    #[command(flatten)]
    pub search: SearchArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub file: TableArgs,
}

const CHART_HELP: &str = "\
Slopes: without --slopes-u and --slopes-v BuFF 1D searches -3:3:13 to the right and BuFF 2D -3:3:7 on both axes. A line of slopes
that is given is BuFF 1D's; a plane is BuFF 2D's, and its u axis BuFF 1D's.

JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"evaluate chart\", \"chart\", \"first_seed\", \"seeds\", \"ranking\", \"false_fraction\", \"detector\": {as in the parameter file},
   \"slopes_1d\", \"slopes_2d\", \"rows\": [{\"snr\", \"methods\": [{\"method\", \"true_positives\": {\"mean\", \"standard_error\"},
     \"default_true_positives\", \"default_false_features\", \"default_false_per_disc\", \"noise_estimate_ratio\", \"roc\": [mean discs found with at most 0, 1, … false features],
     \"charts\": [{\"seed\", \"true_positives\", \"default_true_positives\", \"default_false_features\", \"noise_estimate_ratio\"}]}]}]}";

const ACCURACY_HELP: &str = "\
JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"evaluate accuracy\", \"chart\", \"first_seed\", \"seeds\", \"detector\": {as in the parameter file},
   \"rows\": [{\"snr\", \"within\": {\"discs\", \"found\", \"marked\"}, \"beyond\": {the same}, \"distance\": [median, 95 %], \"apart\", \"distance_apart\",
     \"u\": {\"count\", \"signed\": {\"mean\", \"standard_error\"}, \"median_magnitude\", \"magnitude_95\"}, \"v\", \"scale\", \"slope_u\", \"slope_v\", \"slope_distance\"}],
   \"apart\": {the same, from \"chart\" on, of discs that stand apart}}";

/// Compare places, scales and slopes with the truth.
///
/// Slopes of the discs are drawn from a continuum that reaches beyond the grid searched. For each disc that is found
/// the strongest feature is compared with the truth at mid-burst. Features on the rim of the slope grid are
/// counted and left out of the errors. Scales are compared with the σ at which a difference of Gaussians
/// answers a disc most strongly (0.633 of the radius with 3 levels an octave).
///
/// Two kinds of charts are measured: crowded ones, where neighbours draw features aside, and ones with fewer discs that
/// stand apart in all frames.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = ACCURACY_HELP)]
pub struct AccuracyArgs {
    /// Signal-to-noise ratios of one pixel in one frame, separated by commas; 'inf' makes no noise.
    #[arg(long, value_name = "RATIO,…", value_delimiter = ',', default_value = "5,0.6")]
    pub snr: Vec<f64>,
    /// Largest slope of the discs on each axis that moves, pixels per frame.
    #[arg(long, value_name = "SLOPE", default_value_t = 3.5)]
    pub max_slope: f64,
    /// Number of discs of the charts on which they stand apart; 0 leaves those charts out. Without it 20 on 800×600
    /// pixels, and as many for their area on others.
    #[arg(long, value_name = "N")]
    pub apart_discs: Option<usize>,
    #[command(flatten)]
    pub charts: ChartsArgs,
    #[command(flatten)]
    pub search: SearchArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub file: TableArgs,
}

/// Count what is found on noise alone, where there is nothing.
///
/// Bursts of 10 frames of Gaussian noise around half of full scale are searched by BuFF 1D (13 slopes) and BuFF 2D
/// (7×7), or with the slopes and method given: white noise, and noise as cameras and files make it. The gate strict
/// promises at most one false feature in a million pixels of the image.
#[derive(Debug, Clone, Args)]
pub struct NoiseArgs {
    /// Standard deviations of the noise of one frame, fractions of full scale, separated by commas.
    #[arg(long, value_name = "SIGMA,…", value_delimiter = ',', default_value = "0.002,0.02,0.1")]
    pub sigma: Vec<f64>,
    /// Bits of the converter that rounds the noise, separated by commas; 'none' for numbers that are not rounded.
    #[arg(long, value_name = "BITS,…", value_delimiter = ',', default_value = "none,8", value_parser = parse_bits)]
    pub bits: Vec<Bits>,
    /// Only these kinds of noise, separated by commas: white, doubled (each frame twice), jpeg-QUALITY (grey),
    /// colour-jpeg-QUALITY, correlated, black-frame, noisy-frame, noisy-half, column-stripes, hot-pixels, gain-flicker,
    /// clipped-black, saturated, constant-frame, constant, drifting-stripes-SPEED (px/frame), varying-TIMES (strength
    /// by place), banding, still-banding, smoothed, flickering-pixels, noisy-columns, negative, fading-PERCENT and
    /// breathing-PERCENT (level over time), cosmic-streaks, fixed-pattern-PERCENT (of the noise), bits-PERCENT (of
    /// pixels that are 1, the others 0), growing-stripes. Two are joined by +, and followed by :strength=2 (of
    /// patterns), :period=40 (px) and :phase=0.5 (of it). Without it the white ones of --sigma and --bits, and all
    /// others.
    #[arg(long, value_name = "CASE,…", value_delimiter = ',', value_parser = NoiseKind::from_str)]
    pub case: Vec<NoiseKind>,
    /// Standard deviation of the noise of the kinds of --case, fraction of full scale.
    #[arg(long, value_name = "SIGMA", default_value_t = 0.02)]
    pub case_sigma: f64,
    /// Grey level of the kinds of --case, fraction of full scale, except where they are about black or white.
    #[arg(long, value_name = "LEVEL", default_value_t = NoiseCase::LEVEL)]
    pub case_level: f64,
    #[command(flatten)]
    pub study: NoiseStudy,
    #[command(flatten)]
    pub search: SearchArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub file: TableArgs,
}

/// Bits of a converter; `None` for numbers that are not rounded.
type Bits = Option<u32>;

fn parse_bits(text: &str) -> Result<Bits, String> {
    match text {
        "none" => Ok(None),
        _ => text.parse().map(Some).map_err(|_| format!("'{text}' is neither 'none' nor a number of bits")),
    }
}

/// Count how often the sentence about the slopes is right.
///
/// Layered scenes whose motion is known are searched with slopes that are found (line, plane, layers, masked), with
/// wrong ones (narrow, coarse, beside, wide, still), and with frames that do not fit (exchanged, curved, noise). What
/// 'detect' and 'slopes' say of the slopes is counted against what is true. 'unknown', said where the frames show too
/// little, is never wrong.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = ADVICE_HELP)]
pub struct AdviceArgs {
    #[command(flatten)]
    pub study: AdviceStudy,
    #[command(flatten)]
    pub output: OutputArgs,
}

const ADVICE_HELP: &str = "\
JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"evaluate advice\", \"snrs\", \"seeds\", \"first_seed\",
   \"said\": {statement: {what is true: bursts}}, each of fits, range, step, direction, cost, times, frames and unknown,
   \"wrong_share\" of what is said and not unknown, or null, \"bursts\": [{\"kind\", \"snr\", \"seed\", \"said\", \"true\", \"sentence\"}]}";
