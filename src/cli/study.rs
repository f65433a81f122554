//! Parts that the studies of `evaluate` share: their search parameters, and the study of charts with its plot.

use super::charts_args::{ChartsArgs, ComparedArgs};
use super::console::Console;
use super::failure::Failure;
use super::inputs::check_ending;
use super::search_options::SearchArgs;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, SlopeGrid, Slopes};
use crate::evaluate::{BurstMethod, ChartStudy, Searches};
use crate::export::{OutputRules, write_text};
use crate::files::mark::OutputKind;
use std::path::Path;

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

pub(super) fn searched_by(search: &SearchArgs, methods: &[BurstMethod]) -> Result<StudySearch, Failure> {
    let remedy = "of the methods only buff-auto finds slopes; add it to --methods, or give a range with --slopes-u and --slopes-v";
    checked_slopes(search, methods.contains(&BurstMethod::BuffAuto), remedy)
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

pub(super) fn write_plot(
    console: &Console,
    path: Option<&Path>,
    rules: &OutputRules,
    svg: impl FnOnce() -> String,
) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    rules.check(path)?;
    write_text(path, OutputKind::Drawing, svg())?;
    console.say(&format!("\nwrote {}\n", path.display()))
}

/// Checks that `path` can name an SVG figure: no folder, and an ending of `.svg`.
pub(super) fn check_plot(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        let problem = "--plot: this is a folder; name a file such as roc.svg";
        return Err(Failure::usage(format!("{problem}: {}", path.display())));
    }
    let problem =
        "--plot: the figure is drawn as SVG, which browsers, editors and papers take; name a file that ends in .svg";
    check_ending(path, &["svg"], problem)
}
