//! Parts that the studies share: search parameters, the study of charts, and files of plots and tables.

use super::{ChartsArgs, ComparedArgs, Console, Failure, OverwriteArgs, SearchArgs};
use crate::burst::OpenOptions;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, SlopeGrid, Slopes};
use crate::evaluate::{BurstMethod, ChartStudy, Searches};
use crate::export::{Figure, FigureFormat, OutputRules};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::path::{Path, PathBuf};

pub(super) struct StudySearch {
    pub detector: DetectorParams,
    pub slopes: Option<SlopeGrid>,
    /// Direction in which slopes are found, degrees from +u towards +v.
    pub direction_deg: Option<f32>,
}

/// Search parameters of a study that compares searches over given ranges of slopes.
pub(super) fn searched(search: &SearchArgs) -> Result<StudySearch, Failure> {
    let remedy = "this command compares searches of known ranges; give them with --slopes-u and --slopes-v";
    checked_slopes(search, false, remedy)
}

/// As [`searched`], for `methods` of which one may find slopes; none stands for those that fit the options.
pub(super) fn searched_by(search: &SearchArgs, methods: &[BurstMethod]) -> Result<StudySearch, Failure> {
    let remedy = "of the methods only buff-auto finds slopes; add it to --methods, or give a range with --slopes-u and --slopes-v";
    checked_slopes(search, methods.is_empty() || methods.contains(&BurstMethod::BuffAuto), remedy)
}

fn checked_slopes(search: &SearchArgs, may_find: bool, remedy: &str) -> Result<StudySearch, Failure> {
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
    let mut once = Vec::with_capacity(list.len());
    for item in list {
        if !once.contains(item) {
            once.push(*item);
        }
    }
    once
}

pub(super) fn chart_study(
    charts: &ChartsArgs,
    compared: &ComparedArgs,
    search: &SearchArgs,
    (snrs, frame_counts): (Vec<f64>, Vec<usize>),
) -> Result<ChartStudy, Failure> {
    if search.gives(&doc::METHOD) {
        return Err(Failure::usage("--method: this command compares several; name them with --methods"));
    }
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
    pub(super) fn checked(&self, search: &SearchArgs) -> Result<OutputRules, Failure> {
        let rules = self.overwrite.rules(&[], &OpenOptions::default(), &[search.file.params.as_ref()]);
        self.table.iter().try_for_each(|path| rules.check(path))?;
        Ok(rules)
    }
}

/// Checks before the work that a plot and a table are two files, and may be written.
pub(super) fn check_figures([plot, table]: [&Option<PathBuf>; 2], rules: &OutputRules) -> Result<(), Failure> {
    if plot.is_some() && plot == table {
        return Err(Failure::usage("--table: --plot names this file too; choose another name"));
    }
    Ok(plot.iter().chain(table).try_for_each(|path| rules.check(path))?)
}

/// Writes a figure that was asked for, and says so.
pub(super) fn write_figure(
    console: &Console,
    path: Option<&Path>,
    rules: &OutputRules,
    figure: impl FnOnce() -> Figure,
) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    rules.check(path)?;
    figure().write(path)?;
    console.say(&format!("\nwrote {}\n", path.display()))
}
