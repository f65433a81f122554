//! Parts that the studies share: search parameters, the charts and the methods compared on them, and files of plots and
//! tables.

use super::{Console, Failure, Outcome, OverwriteArgs, SearchArgs};
use crate::burst::OpenOptions;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, SlopeGrid, Slopes};
use crate::evaluate::{BurstMethod, ChartStudy, Ranking, Searches};
use crate::export::{Figure, FigureFormat, OutputRules};
use crate::synth::options::{motions, parse_range, words};
use crate::synth::{ChartParams, Motion, RadiusLaw};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::str::FromStr;

pub(super) struct StudySearch {
    pub detector: DetectorParams,
    pub slopes: Option<SlopeGrid>,
    /// Direction in which slopes are found, degrees from +u towards +v.
    pub direction_deg: Option<f32>,
}

/// Search parameters of a study that compares searches over given ranges of slopes.
pub(super) fn searched(search: &SearchArgs) -> Outcome<StudySearch> {
    let remedy = "this command compares searches of known ranges; give them with --slopes-u and --slopes-v";
    checked_slopes(search, false, remedy)
}

/// As [`searched`], for a study of `methods`, of which one may find slopes; none stands for those that fit the options.
pub(super) fn searched_by(search: &SearchArgs, methods: &[BurstMethod]) -> Outcome<StudySearch> {
    if search.gives(&doc::METHOD) {
        return Err(Failure::usage("--method: this command compares several; name them with --methods"));
    }
    let remedy = "of the methods only buff-auto finds slopes; add it to --methods, or give a range with --slopes-u and --slopes-v";
    checked_slopes(search, methods.is_empty() || methods.contains(&BurstMethod::BuffAuto), remedy)
}

fn checked_slopes(search: &SearchArgs, may_find: bool, remedy: &str) -> Outcome<StudySearch> {
    let params = search.params()?;
    // Either option asks for slopes to be found, which only some commands and methods do.
    let asked = [doc::SLOPES, doc::SLOPE_DIRECTION];
    if let Some(doc) = asked.iter().find(|record| search.gives(record) && params.slopes.is_auto() && !may_find) {
        return Err(Failure::usage(format!("--{}: {remedy}", doc.name)));
    }
    let (slopes, direction_deg) = match params.slopes {
        Slopes::Given(grid) => (Some(grid), None),
        Slopes::Auto { direction_deg } => (None, direction_deg),
    };
    Ok(StudySearch { detector: params.at(slopes.unwrap_or_default()), slopes, direction_deg })
}

pub(super) fn once_each<T: Copy + PartialEq>(list: &[T]) -> Vec<T> {
    let is_first = |(place, item): &(usize, &T)| !list[..*place].contains(item);
    list.iter().enumerate().filter(is_first).map(|(_, item)| *item).collect()
}

pub(super) fn chart_study(
    charts: &ChartsArgs,
    compared: &ComparedArgs,
    search: &SearchArgs,
    (snrs, frame_counts): (Vec<f64>, Vec<usize>),
) -> Outcome<ChartStudy> {
    let StudySearch { detector, slopes, direction_deg } = searched_by(search, &compared.methods)?;
    Ok(ChartStudy {
        chart: charts.params(compared.max_slope),
        snrs,
        frame_counts,
        first_seed: charts.seed,
        seeds: charts.seeds,
        methods: once_each(&compared.methods),
        searches: Searches { direction_deg, ..Searches::of_charts(detector, slopes) },
        ranking: compared.ranking,
        false_fraction: compared.false_fraction,
    })
}

/// Name of the file in help texts: its ending says what is written.
pub(super) const FIGURE_FILE: &str = "FILE.svg|pdf|png|csv|tex";

/// The name of a figure's file. Other endings are refused before anything is opened.
pub(super) fn figure_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| FigureFormat::of(&path, &FigureFormat::ALL).map(|_| path))
}

/// The file of a command's table.
#[derive(Debug, Clone, Args)]
pub struct TableArgs {
    /// Write the table as CSV or LaTeX (.tex), or drawn as SVG, PDF or PNG.
    #[arg(long, value_name = FIGURE_FILE, value_parser = figure_file())]
    pub table: Option<PathBuf>,
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

impl TableArgs {
    /// The rules for overwriting of a command that opens no burst, once they let the table be written.
    pub(super) fn checked(&self, search: &SearchArgs) -> Outcome<OutputRules> {
        let rules = self.overwrite.rules(&[], &OpenOptions::default(), &[search.file.params.as_ref()]);
        self.table.iter().try_for_each(|path| rules.check(path))?;
        Ok(rules)
    }
}

/// Checks before the work that a plot and a table are two files, and may be written.
pub(super) fn check_figures([plot, table]: [&Option<PathBuf>; 2], rules: &OutputRules) -> Outcome {
    if plot.is_some() && plot == table {
        return Err(Failure::usage("--table: --plot names this file too; choose another name"));
    }
    Ok(plot.iter().chain(table).try_for_each(|path| rules.check(path))?)
}

pub(super) fn write_figure(
    console: &Console,
    path: Option<&Path>,
    rules: &OutputRules,
    figure: impl FnOnce() -> Figure,
) -> Outcome {
    let Some(path) = path else { return Ok(()) };
    rules.check(path)?;
    figure().write(path)?;
    console.say(&format!("\nwrote {}\n", path.display()))
}

fn chart() -> ChartParams {
    ChartParams::default()
}

/// The picture of a chart: its size and its discs.
#[derive(Debug, Clone, Args)]
pub struct DiscsArgs {
    /// Columns.
    #[arg(long, value_name = "PIXELS", default_value_t = chart().width)]
    pub width: usize,
    /// Rows.
    #[arg(long, value_name = "PIXELS", default_value_t = chart().height)]
    pub height: usize,
    /// Number of discs.
    #[arg(long, value_name = "N", default_value_t = chart().discs)]
    pub discs: usize,
    /// Range of the discs' radii, pixels.
    #[arg(long, value_name = "MIN:MAX", default_value = "3.6:19", value_parser = parse_range)]
    pub radius: RangeInclusive<f64>,
    /// Law of the radii: uniform, or log, by which every octave of radii is equally likely.
    #[arg(long, value_name = "LAW", default_value = "uniform", value_parser = words::<RadiusLaw>(&["uniform", "log"]))]
    pub radius_law: RadiusLaw,
}

/// The charts of a study.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Charts")]
pub struct ChartsArgs {
    /// Number of charts for each ratio, with seeds counting up.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub seeds: u64,
    /// The first chart's seed.
    #[arg(long, value_name = "FIRST", default_value_t = 1)]
    pub seed: u64,
    /// Directions of motion: 1d is horizontal, 2d any.
    #[arg(long, value_name = "DIRECTIONS", default_value = "1d", value_parser = motions())]
    pub motion: Motion,
    #[command(flatten)]
    pub discs: DiscsArgs,
}

impl ChartsArgs {
    /// Parameters of the charts; the study sets ratio and seed.
    pub fn params(&self, max_slope: f64) -> ChartParams {
        let DiscsArgs { width, height, discs, radius, radius_law } = self.discs.clone();
        ChartParams { width, height, discs, radius, radius_law, motion: self.motion, max_slope, ..chart() }
    }
}

/// Methods to compare on charts, and how they are ranked.
#[derive(Debug, Clone, Args)]
pub struct ComparedArgs {
    /// Methods, separated by commas: sift-frame (SIFT on the middle frame), sift-mean (SIFT on the plain mean of all
    /// frames), sift-merge (SIFT on the aligned and merged burst), buff-1d, buff-2d, buff-auto (slopes found from each
    /// burst).
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',', default_value = "sift-frame,sift-mean,sift-merge,buff-1d,buff-2d",
        value_parser = BurstMethod::from_str)]
    pub methods: Vec<BurstMethod>,
    /// Quantity that a threshold is put on.
    #[arg(long, value_enum, value_name = "RANKING", default_value_t = Ranking::Strength)]
    pub ranking: Ranking,
    /// The share of false detections at which methods are compared.
    #[arg(long, value_name = "SHARE", default_value_t = 0.1)]
    pub false_fraction: f64,
    /// Largest slope of the discs on each axis that moves, pixels per frame.
    #[arg(long, value_name = "SLOPE", default_value_t = chart().max_slope)]
    pub max_slope: f64,
}
