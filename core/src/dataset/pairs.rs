//! The matching of pairs of bursts.

use super::{BurstFeatures, DatasetError};
use crate::matching::{MatchParams, MatchResult, MatchSide, match_features};
use crate::monitor::{Monitor, Stage};
use rayon::prelude::*;

/// Number of pairs that are matched before their results are passed on: enough for all threads, few enough for memory
/// and for early results.
const PAIRS_AT_ONCE: usize = 16;

/// Callback for the result of one pair, given by its indices.
pub type OnPair<'a> = dyn FnMut((usize, usize), &MatchResult) -> Result<(), DatasetError> + 'a;

/// Matches the bursts of each of `pairs` (indices into `bursts`); `on` receives the results in the order of `pairs`.
///
/// # Errors
/// [`DatasetError::Param`] for parameters that make no sense, [`DatasetError::Cancelled`] once `monitor` was cancelled,
/// and errors of `on`.
///
/// # Panics
/// When a pair has an index outside `bursts`: a mistake of the caller.
pub fn match_pairs(
    bursts: &[BurstFeatures],
    pairs: &[(usize, usize)],
    params: &MatchParams,
    on: &mut OnPair<'_>,
    monitor: &Monitor,
) -> Result<(), DatasetError> {
    params.validate()?;
    let places: Vec<Vec<[f64; 2]>> =
        bursts.iter().map(|b| b.keypoints.iter().map(|k| k.pos_image()).collect()).collect();
    let side = |k: usize| MatchSide { places: &places[k], descriptors: &bursts[k].descriptors };
    let mut done = 0;
    for some in pairs.chunks(PAIRS_AT_ONCE) {
        monitor.report(Stage::Match, done as f32 / pairs.len() as f32);
        let matched: Vec<MatchResult> = some
            .par_iter()
            .map(|&(a, b)| match_features(side(a), side(b), params, &monitor.silent()))
            .collect::<Result<_, _>>()?;
        for (&pair, result) in some.iter().zip(&matched) {
            on(pair, result)?;
        }
        done += some.len();
    }
    monitor.report(Stage::Match, 1.0);
    Ok(())
}
