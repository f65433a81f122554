//! Parts that the studies of `evaluate` share: their search parameters, and the study of charts.

use super::charts_args::{ChartsArgs, ComparedArgs};
use super::failure::Failure;
use super::search_options::SearchArgs;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, SlopeGrid, Slopes};
use crate::evaluate::{BurstMethod, ChartStudy, Searches};

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
