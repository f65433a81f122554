//! The matches of a dataset's pairs in numbers, and in which order they are listed.

use crate::app::document::{BurstPair, Order, PairColumn, Side};
use crate::app::{results::Read, results::pair::lost_words};
use crate::dataset::INLIERS_TO_START;
use crate::inspect::pair::Lost;
use crate::matching::{MatchCounts, MatchParams};
use std::collections::BTreeMap;

impl PairColumn {
    /// The number in this column; `None` where there is none. Pairs have none: they stand in their own order.
    pub fn value(self, counts: &MatchCounts) -> Option<f64> {
        match self {
            Self::Pair => None,
            Self::Putative => Some(counts.putative as f64),
            Self::Inliers => counts.inliers.map(|n| n as f64),
            Self::Ratio => Some(counts.match_ratio()),
            Self::Score => counts.match_score(),
            Self::InlierRatio => counts.inlier_ratio(),
        }
    }

    pub fn text(self, counts: &MatchCounts) -> String {
        match (self, self.value(counts)) {
            (_, None) => "–".to_owned(),
            (Self::Putative | Self::Inliers, Some(value)) => format!("{value:.0}"),
            (_, Some(value)) => format!("{value:.3}"),
        }
    }
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct PairTable {
    pub counts: BTreeMap<BurstPair, MatchCounts>,
    /// Parameters of matching that gave all counts.
    pub params: MatchParams,
    pub order: Order<PairColumn>,
}

impl PairTable {
    /// Numbers begin with the largest; a second click reverses the order.
    pub fn sort_by(&mut self, column: PairColumn) {
        let descending = if self.order.column == column { !self.order.descending } else { column != PairColumn::Pair };
        self.order = Order { column, descending };
    }

    /// Prepares for matches made with `params`; forgets those made with other parameters.
    pub fn begin(&mut self, params: &MatchParams) {
        if self.params != *params {
            self.counts.clear();
            self.params = params.clone();
        }
    }

    /// Number that a cell of the matrix shows: inliers, or putative matches where no geometry was estimated.
    pub fn strength(counts: &MatchCounts) -> usize {
        counts.inliers.unwrap_or(counts.putative)
    }

    pub fn strongest(&self) -> usize {
        self.counts.values().map(Self::strength).max().unwrap_or(0)
    }

    /// Of the pairs of a burst that have a match, that with the most inliers, or else with the fewest.
    pub fn of_burst(&self, place: usize, strongest: bool) -> Option<(BurstPair, MatchCounts)> {
        let own = |((a, b), counts): &(&BurstPair, &MatchCounts)| (*a == place || *b == place) && counts.putative > 0;
        let own = self.counts.iter().filter(own);
        let by = |(_, counts): &(&BurstPair, &MatchCounts)| (Self::strength(counts), counts.putative);
        let found = if strongest { own.max_by_key(by) } else { own.min_by_key(by) };
        found.map(|(pair, counts)| (*pair, *counts))
    }

    pub fn listed(&self) -> Vec<(BurstPair, MatchCounts)> {
        let mut rows: Vec<(BurstPair, MatchCounts)> = self.counts.iter().map(|(p, c)| (*p, *c)).collect();
        let Order { column, descending } = self.order;
        let by_value = |a: &MatchCounts, b: &MatchCounts| match (column.value(a), column.value(b)) {
            (Some(a), Some(b)) => a.total_cmp(&b),
            (a, b) => a.is_some().cmp(&b.is_some()),
        };
        // Pairs of equal values stay in the order of the bursts.
        rows.sort_by(|a, b| {
            let order = if column == PairColumn::Pair { a.0.cmp(&b.0) } else { by_value(&a.1, &b.1) };
            if descending { order.reverse() } else { order }
        });
        rows
    }
}

/// Inliers of a pair beside those that a mapper needs, and the step at which most of the features of its first burst
/// were lost, as far as it is known: without the `steps` of each feature the counts alone tell.
pub fn lost_text(counts: &MatchCounts, steps: Option<&[(Lost, usize); 6]>) -> (String, Lost) {
    let MatchCounts { keypoints_a, putative, inliers, refused, not_mutual, .. } = *counts;
    let by_descriptor = keypoints_a.saturating_sub(putative + not_mutual.unwrap_or(0));
    let first = if not_mutual.is_some() { "ratio test" } else { "ratio test or mutual check" };
    let lost = match steps {
        Some(steps) => steps.iter().skip(1).map(|&(lost, count)| (lost, count, lost_words(lost)[0])).collect(),
        None => vec![
            (Lost::RatioTest, by_descriptor, first),
            (Lost::MutualCheck, not_mutual.unwrap_or(0), "mutual check"),
            (Lost::Geometry, putative.saturating_sub(inliers.unwrap_or(putative)), "geometry"),
        ],
    };
    let all: usize = steps.map_or(keypoints_a, |steps| steps.iter().map(|(_, count)| count).sum());
    // Of equal ones the earlier step.
    let (lost, count, step) = lost.into_iter().rev().max_by_key(|(_, count, _)| *count).expect("there are steps");
    let percent = 100.0 * count as f64 / all.max(1) as f64;
    let refused = refused.map_or_else(String::new, |why| format!("; refused: {}", why.words()));
    let text = format!("{} inliers of about {INLIERS_TO_START} needed{refused}", inliers.unwrap_or(0));
    (format!("{text}; {percent:.0} % of {all} keypoints lost: {step}"), lost)
}

impl<'a> Read<'a> {
    /// Numbers of features lost at each step in a pair of the dataset, where its bursts are open and matched.
    pub fn losses_of(self, (a, b): BurstPair) -> Option<&'a [(Lost, usize); 6]> {
        let are_open = self.place_of(Side::A) == Some(a) && self.place_of(Side::B) == Some(b);
        self.losses().filter(|_| are_open).map(|found| &found.counts)
    }
}
