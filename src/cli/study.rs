//! Parts that the studies of `evaluate` share: their search parameters, and the form of their reports.

use super::failure::Failure;
use super::search_options::SearchArgs;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, SearchParams, SlopeChoice, SlopeGrid};
use crate::evaluate::BurstMethod;
use serde::Serialize;

/// JSON document of a report, with version and command.
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

/// Search parameters of a study.
pub(super) struct Searched {
    /// Parameters of the detector.
    pub detector: DetectorParams,
    /// Slopes, if any are given.
    pub slopes: Option<SlopeGrid>,
    /// Direction in which slopes are found, degrees from +u towards +v.
    pub direction_deg: Option<f32>,
}

/// Search parameters of a study that compares searches over given ranges of slopes.
pub(super) fn searched(search: &SearchArgs) -> Result<Searched, Failure> {
    let remedy = "this command compares searches of known ranges; give them with --slopes-u and --slopes-v";
    checked_slopes(search, false, remedy)
}

/// Search parameters of a study of `methods`, of which `buff-auto` finds slopes by itself.
pub(super) fn searched_by(search: &SearchArgs, methods: &[BurstMethod]) -> Result<Searched, Failure> {
    let remedy = "of the methods only buff-auto finds slopes; add it to --methods, or give a range with --slopes-u and --slopes-v";
    checked_slopes(search, methods.contains(&BurstMethod::BuffAuto), remedy)
}

fn checked_slopes(search: &SearchArgs, may_find: bool, remedy: &str) -> Result<Searched, Failure> {
    let SearchParams { detector, slopes } = search.params()?;
    let asked = [doc::SLOPES, doc::SLOPE_DIRECTION];
    if let Some(doc) = asked.iter().find(|record| search.gives(record) && slopes.is_auto() && !may_find) {
        return Err(Failure::usage(format!("--{}: {remedy}", doc.name)));
    }
    let (slopes, direction_deg) = match slopes {
        SlopeChoice::Given => (Some(detector.slopes), None),
        SlopeChoice::Auto { direction_deg } => (None, direction_deg),
    };
    Ok(Searched { detector, slopes, direction_deg })
}

/// Removes repetitions from `list`; keeps its order.
pub(super) fn once_each<T: Copy + PartialEq>(list: &[T]) -> Vec<T> {
    let mut once = Vec::with_capacity(list.len());
    for item in list {
        if !once.contains(item) {
            once.push(*item);
        }
    }
    once
}
