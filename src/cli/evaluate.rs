//! `evaluate`: measures the detector against known truth.

use super::evaluate_args::{AccuracyArgs, AdviceArgs, EvaluateChartArgs, NoiseArgs};
use super::evaluate_tables::{
    accuracy_table, accuracy_text, advice_tables, chart_text, methods_table, noise_table, noise_text,
};
use super::study::{StudySearch, chart_study, check_figures, searched, write_figure};
use super::{Both, Console, Failure, document, evaluate_frames, evaluate_matches, evaluate_poses};
use crate::burst::OpenOptions;
use crate::detector::{DetectorParams, Method};
use crate::evaluate::accuracy::discs_apart;
use crate::evaluate::curves::roc_figure;
use crate::evaluate::pure_noise::{NoiseLevel, NoiseSearch};
use crate::evaluate::{AccuracyStudy, NoiseStudy, RowStudy};
use crate::synth::{NoiseCase, NoiseKind};
use clap::Args;

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

pub(super) fn run(args: &EvaluateArgs) -> Result<(), Failure> {
    args.study.run()
}

fn chart(args: &EvaluateChartArgs) -> Result<(), Failure> {
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

fn accuracy(args: &AccuracyArgs) -> Result<(), Failure> {
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

fn noise(args: &NoiseArgs) -> Result<(), Failure> {
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
    let white = args.bits.iter().flat_map(|bits| args.sigma.iter().map(|&sigma| NoiseLevel::white(sigma, bits.0)));
    let of_case = |case: NoiseKind| NoiseLevel { case, sigma: args.case_sigma, bits: None, mean: args.case_level };
    // Named kinds take the place of white noise; without names all kinds are measured.
    let all = NoiseCase::ALL.into_iter().filter(|case| *case != NoiseCase::White).map(NoiseKind::from);
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

fn advice(args: &AdviceArgs) -> Result<(), Failure> {
    let console = Console::new(&args.output)?;
    let report = args.study.run(&console.monitor)?;
    console.say(&advice_tables(&report))?;
    console.say_document("evaluate advice", &report)
}
