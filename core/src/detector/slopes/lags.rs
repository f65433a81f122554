//! Pairs of frames by their lag: the distance in time, whole frame intervals, or of views in columns and rows.

use crate::burst::{Offset, Positions};
use std::collections::BTreeMap;

/// Largest lag that is used, and number of lags: pairs of frames further apart add little new information.
pub(super) const MAX_LAG: usize = 12;
/// Largest distance, frames, of pairs with products of their own.
const MAX_NEAR: usize = 6;

/// Frames s and t, s before t.
type Pairs = Vec<(usize, usize)>;

/// Pairs of frames by their lag: the whole number of frame intervals that is nearest to their distance in time.
pub(super) struct Lags {
    pub frames: usize,
    /// Pairs of lag 1, 2, …, without pairs closer than half an interval or too far apart.
    pub by_lag: Vec<Pairs>,
    /// Mean distance of the pairs of each lag; the lag itself where it has no pair.
    pub distances: Vec<Offset>,
    /// Pairs of frames 1, 2, … apart in their order, nearest first; none for views, which follow no time.
    pub near: Pairs,
}

impl Lags {
    pub fn of(positions: &Positions) -> Self {
        if positions.are_views() { Self::of_views(positions) } else { Self::of_times(positions) }
    }

    /// Pairs of views by their distance in columns and rows: those of one row or column first, nearest first.
    fn of_views(positions: &Positions) -> Self {
        let mut by_distance: BTreeMap<[i64; 2], Pairs> = BTreeMap::new();
        for pair in pairs_of(positions.len()) {
            let apart = positions.offset(pair.1) - positions.offset(pair.0);
            let [u, v] = [apart.u, apart.v].map(|x| x.round() as i64);
            if [u, v] != [0, 0] && u.abs().max(v.abs()) <= MAX_LAG as i64 {
                by_distance.entry([u, v]).or_default().push(pair);
            }
        }
        let mut lags: Vec<([i64; 2], Pairs)> = by_distance.into_iter().collect();
        let square = |[u, v]: [i64; 2]| u * u + v * v;
        lags.sort_by_key(|([u, v], _)| (u * v != 0, square([*u, *v]), *v));
        lags.truncate(MAX_LAG);
        // The search of the slope grid reads the first lags alone, so the nearest come first.
        lags.sort_by_key(|(apart, _)| square(*apart));
        let distance = |([u, v], _): &([i64; 2], Pairs)| Offset { u: *u as f64, v: *v as f64 };
        let distances = lags.iter().map(distance).collect();
        let pairs = lags.into_iter().map(|(_, pairs)| pairs).collect();
        Self { frames: positions.len(), by_lag: pairs, distances, near: Vec::new() }
    }

    fn of_times(positions: &Positions) -> Self {
        let count =
            (positions.span().round().max(1.0) as usize).min(MAX_LAG).min(positions.len().saturating_sub(1) * MAX_LAG);
        let mut pairs = vec![Vec::new(); count];
        let apart = |(s, t): (usize, usize)| positions.offset(t).u - positions.offset(s).u;
        for pair in pairs_of(positions.len()) {
            let lag = apart(pair).round();
            if (1.0..=count as f64).contains(&lag) {
                pairs[lag as usize - 1].push(pair);
            }
        }
        let distance = |(of, lag): (&Pairs, usize)| match of.len() {
            // A lag without pairs keeps its place, so that distances and lags stay in step.
            0 => lag as f64,
            n => of.iter().map(|pair| apart(*pair)).sum::<f64>() / n as f64,
        };
        let distances = pairs.iter().zip(1..).map(distance).map(Offset::from).collect();
        let frames = positions.len();
        let near = (1..frames.min(MAX_NEAR + 1)).flat_map(|apart| (apart..frames).map(move |t| (t - apart, t)));
        Self { frames, by_lag: pairs, distances, near: near.collect() }
    }

    /// Number of pairs of frames that follow one another, which come first in `near`.
    pub fn neighbours(&self) -> usize {
        self.frames.saturating_sub(1)
    }

    /// Number of pairs of `lag`, from 1.
    pub fn pairs(&self, lag: usize) -> usize {
        self.by_lag[lag - 1].len()
    }
}

fn pairs_of(frames: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..frames).flat_map(move |s| (s + 1..frames).map(move |t| (s, t)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_paired_along_rows_and_columns_first() {
        let apart = |rows: usize, columns: usize| -> Vec<([f64; 2], usize)> {
            let lags = Lags::of(&Positions::grid(rows, columns));
            assert!(lags.near.is_empty());
            lags.distances.iter().zip(&lags.by_lag).map(|(at, pairs)| ([at.u, at.v], pairs.len())).collect()
        };
        let wide = apart(9, 9);
        assert_eq!(wide[..3], [([1.0, 0.0], 72), ([0.0, 1.0], 72), ([2.0, 0.0], 63)]);
        assert!(wide.len() == MAX_LAG && wide.iter().all(|([u, v], _)| u * v == 0.0), "{wide:?}");
        assert_eq!(apart(2, 2), [([1.0, 0.0], 2), ([0.0, 1.0], 2), ([-1.0, 1.0], 1), ([1.0, 1.0], 1)]);
        let of_row = Lags::of(&Positions::even(4));
        assert_eq!((of_row.distances, of_row.near.len()), ([1.0, 2.0, 3.0].map(Offset::from).to_vec(), 6));
    }
}
