//! The matches of a dataset's pairs in numbers, and in which order they are listed.

use crate::app::document::{BurstPair, Order, PairColumn};
use crate::matching::{MatchCounts, MatchParams};
use std::collections::BTreeMap;

impl PairColumn {
    pub const ALL: [Self; 6] = [Self::Pair, Self::Putative, Self::Inliers, Self::Ratio, Self::Score, Self::InlierRatio];

    /// Its heading, and help.
    pub fn words(self) -> [&'static str; 2] {
        match self {
            Self::Pair => ["pair", "The two bursts"],
            Self::Putative => ["putative", "Matches by descriptors alone"],
            Self::Inliers => ["inliers", "Matches that a common geometry explains"],
            Self::Ratio => ["ratio", "Match ratio: putative matches over keypoints, mean of both bursts"],
            Self::Score => ["score", "Match score: inliers over keypoints, mean of both bursts"],
            Self::InlierRatio => ["inlier ratio", "Inlier ratio: inliers over putative matches"],
        }
    }

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
        let again = self.order.column == column;
        let descending = if again { !self.order.descending } else { column != PairColumn::Pair };
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
