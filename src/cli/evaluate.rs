//! `evaluate`: the detector measured against known truth.

use super::console::Console;
use super::evaluate_args::{AccuracyArgs, EvaluateArgs, EvaluateChartArgs, EvaluateStudy, NoiseArgs};
use super::evaluate_matches;
use super::evaluate_poses;
use super::evaluate_tables::{accuracy_tables, chart_table, noise_table};
use super::failure::Failure;
use super::search_options::SearchArgs;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, Method, SearchParams, SlopeAxis, SlopeChoice, SlopeGrid};
use crate::evaluate::accuracy::{AccuracyReport, discs_apart};
use crate::evaluate::figure::roc_svg;
use crate::evaluate::pure_noise::{NoiseLevel, NoiseSearch};
use crate::evaluate::{AccuracyStudy, BurstMethod, ChartStudy, NoiseStudy};
use crate::export::write_whole;
use crate::synth::NoiseCase;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

pub(super) fn run(args: &EvaluateArgs) -> Result<(), Failure> {
    match &args.study {
        EvaluateStudy::Chart(args) => chart(args),
        EvaluateStudy::Accuracy(args) => accuracy(args),
        EvaluateStudy::Noise(args) => noise(args),
        EvaluateStudy::Matches(args) => evaluate_matches::run(args),
        EvaluateStudy::Poses(args) => evaluate_poses::run(args),
    }
}

/// A report as a JSON document that says what it is.
#[derive(Serialize)]
pub(super) struct Document<'a, R> {
    version: &'static str,
    command: &'static str,
    #[serde(flatten)]
    report: &'a R,
}

impl<'a, R> Document<'a, R> {
    pub fn new(command: &'static str, report: &'a R) -> Self {
        Self { version: env!("CARGO_PKG_VERSION"), command, report }
    }
}

/// What a study searches with.
pub(super) struct Searched {
    /// The detector's parameters.
    pub detector: DetectorParams,
    /// The slopes, if any were given.
    pub slopes: Option<SlopeGrid>,
    /// The direction in which slopes are to be found, degrees from +u towards +v.
    pub direction_deg: Option<f32>,
}

/// What a study searches with that compares searches of known ranges of slopes.
pub(super) fn searched(search: &SearchArgs) -> Result<Searched, Failure> {
    let remedy = "this command compares searches of known ranges; give them with --slopes-u and --slopes-v";
    checked_slopes(search, false, remedy)
}

/// What a study of `methods` searches with. One of them may find slopes by itself.
pub(super) fn searched_by(search: &SearchArgs, methods: &[BurstMethod]) -> Result<Searched, Failure> {
    let remedy = "of the methods only buff-auto finds slopes; add it to --methods, or give a range with --slopes-u and --slopes-v";
    checked_slopes(search, methods.contains(&BurstMethod::BuffAuto), remedy)
}

fn checked_slopes(search: &SearchArgs, may_find: bool, remedy: &str) -> Result<Searched, Failure> {
    let SearchParams { detector, slopes } = search.params()?;
    let asked = [(search.slopes.is_some(), doc::SLOPES), (search.slope_direction.is_some(), doc::SLOPE_DIRECTION)];
    if let Some((_, doc)) = asked.iter().find(|(given, _)| *given && slopes.is_auto() && !may_find) {
        return Err(Failure::usage(format!("--{}: {remedy}", doc.name)));
    }
    let (slopes, direction_deg) = match slopes {
        SlopeChoice::Given => (Some(detector.slopes), None),
        SlopeChoice::Auto { direction_deg } => (None, direction_deg),
    };
    Ok(Searched { detector, slopes, direction_deg })
}

/// The slopes of BuFF 1D and of BuFF 2D: a plane is BuFF 2D's, and its u axis BuFF 1D's; a line is BuFF 1D's, and BuFF
/// 2D has it on both axes.
pub(super) fn slopes_of(slopes: SlopeGrid) -> (SlopeGrid, SlopeGrid) {
    if slopes.is_plane() {
        return (SlopeGrid { v: SlopeAxis::ZERO, ..slopes }, slopes);
    }
    let axis = if slopes.u.count > 1 { slopes.u } else { slopes.v };
    (slopes, SlopeGrid { u: axis, v: axis, ..slopes })
}

/// The list without repetitions, in its order.
pub(super) fn once_each<T: Copy + PartialEq>(list: &[T]) -> Vec<T> {
    let mut once = Vec::with_capacity(list.len());
    for item in list {
        if !once.contains(item) {
            once.push(*item);
        }
    }
    once
}

fn chart(args: &EvaluateChartArgs) -> Result<(), Failure> {
    if args.search.method.is_some() {
        return Err(Failure::usage("--method: this command compares several; name them with --methods"));
    }
    if let Some(path) = &args.plot {
        check_plot(path)?;
    }
    let Searched { detector, slopes, direction_deg } = searched_by(&args.search, &args.methods)?;
    let default = ChartStudy::default();
    let (slopes_1d, slopes_2d) = match slopes {
        Some(plane) if plane.is_plane() => slopes_of(plane),
        Some(line) => (line, default.slopes_2d),
        None => (default.slopes_1d, default.slopes_2d),
    };
    let study = ChartStudy {
        chart: args.charts.params(args.max_slope),
        snrs: args.snr.clone(),
        first_seed: args.charts.seed,
        seeds: args.charts.seeds,
        methods: once_each(&args.methods),
        detector,
        slopes_1d,
        slopes_2d,
        direction_deg,
        ranking: args.ranking,
        false_fraction: args.false_fraction,
    };
    let console = Console::new(&args.output)?;
    let report = study.run(&console.monitor)?;
    console.say(&chart_table(&report))?;
    if let Some(path) = &args.plot {
        write_whole(path, |out| out.write_all(roc_svg(&report).as_bytes()))?;
        console.say(&format!("\nwrote {}\n", path.display()))?;
    }
    console.say_json(&Document::new("evaluate chart", &report))
}

fn check_plot(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(Failure::usage(format!(
            "--plot: this is a folder; name a file such as roc.svg: {}",
            path.display()
        )));
    }
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
        return Err(Failure::usage(format!(
            "--plot: the figure is drawn as SVG, which browsers, editors and papers take; name a file that ends in .svg: {}",
            path.display()
        )));
    }
    Ok(())
}

fn accuracy(args: &AccuracyArgs) -> Result<(), Failure> {
    let Searched { detector, slopes, .. } = searched(&args.search)?;
    let default = AccuracyStudy::with_motion(args.charts.motion);
    let study = AccuracyStudy {
        chart: args.charts.params(args.max_slope),
        snrs: args.snr.clone(),
        first_seed: args.charts.seed,
        seeds: args.charts.seeds,
        detector: DetectorParams { slopes: slopes.unwrap_or(default.detector.slopes), ..detector },
    };
    let console = Console::new(&args.output)?;
    let crowded = study.run(&console.monitor)?;
    let apart = match args.apart_discs.unwrap_or_else(|| discs_apart(&study.chart)) {
        0 => None,
        discs => Some(study.standing_apart(discs).run(&console.monitor)?),
    };
    let report = AccuracyDocument { crowded, apart };
    console.say(&accuracy_tables(&report.crowded, report.apart.as_ref()))?;
    console.say_json(&Document::new("evaluate accuracy", &report))
}

/// What `evaluate accuracy` reports.
#[derive(Serialize)]
struct AccuracyDocument {
    #[serde(flatten)]
    crowded: AccuracyReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    apart: Option<AccuracyReport>,
}

fn noise(args: &NoiseArgs) -> Result<(), Failure> {
    let Searched { detector, slopes, .. } = searched(&args.search)?;
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
    let of_case = |&case: &NoiseCase| NoiseLevel { case, sigma: args.case_sigma, bits: None };
    let levels = match &args.case[..] {
        [] => white.chain(NoiseCase::ALL.iter().filter(|&&case| case != NoiseCase::White).map(of_case)).collect(),
        cases => cases.iter().map(of_case).collect(),
    };
    let study = NoiseStudy {
        levels,
        searches,
        width: args.width,
        height: args.height,
        megapixels: args.megapixels,
        first_seed: args.seed,
        ..NoiseStudy::default()
    };
    let console = Console::new(&args.output)?;
    let report = study.run(&console.monitor)?;
    console.say(&noise_table(&report))?;
    console.say_json(&Document::new("evaluate noise", &report))
}
