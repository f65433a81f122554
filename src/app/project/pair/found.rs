//! The matches of two bursts with what they were made from.

use crate::app::project::order::Order;
use crate::app::project::pair::{MatchColumn, MatchLook, Side};
use crate::detector::{Detection, Feature};
use crate::matching::{Match, MatchResult, TwoViewModel};
use crate::requests::{MatchRequest, Matched};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

/// The matches of two bursts with what they were made from.
#[derive(Debug, Clone)]
pub struct Matches {
    /// The features and parameters that they were made from.
    pub request: MatchRequest,
    /// The matches, their geometry and counts.
    pub result: Arc<MatchResult>,
    /// Wall-clock time of the matching.
    pub elapsed: Duration,
}

/// One match with its features.
#[derive(Debug, Clone, Copy)]
pub struct MatchRow<'a> {
    /// Its index among the matches.
    pub index: usize,
    /// The match itself.
    pub found: &'a Match,
    /// Its feature in A.
    pub a: &'a Feature,
    /// Its feature in B.
    pub b: &'a Feature,
    /// Whether it agrees with the geometry; `None` where it was not verified.
    pub inlier: Option<bool>,
    /// Distance from the geometry, pixels; `None` where there is no geometry, infinite where the distance is
    /// undefined.
    pub error_px: Option<f32>,
}

/// Places of a match's features, with which it is selected again after the next matching.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SavedMatch {
    /// (u, v) in A, pixels.
    pub a: [f32; 2],
    /// (u, v) in B, pixels.
    pub b: [f32; 2],
}

/// Maximum distance of both features from those of a saved match that counts as the same, pixels.
const SAME_PLACE_PX: f32 = 1.0;

impl Matches {
    /// Wraps the engine's answer.
    pub fn new(matched: Matched, elapsed: Duration) -> Self {
        Self { request: matched.request, result: matched.result, elapsed }
    }

    /// Number of matches.
    pub fn len(&self) -> usize {
        self.result.matches.len()
    }

    /// Whether there are no matches.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The detection of one side.
    pub fn detection(&self, side: Side) -> &Detection {
        match side {
            Side::A => &self.request.a,
            Side::B => &self.request.b,
        }
    }

    /// Whether these are the features of `side` that were matched.
    pub fn is_of(&self, side: Side, detection: &Arc<Detection>) -> bool {
        match side {
            Side::A => Arc::ptr_eq(&self.request.a, detection),
            Side::B => Arc::ptr_eq(&self.request.b, detection),
        }
    }

    /// Geometry that most matches agree on.
    pub fn model(&self) -> Option<&TwoViewModel> {
        self.result.verification.as_ref()?.model.as_ref()
    }

    /// The match of this index.
    pub fn row(&self, index: usize) -> Option<MatchRow<'_>> {
        let found = self.result.matches.get(index)?;
        let (a, b) = (self.request.a.features.get(found.a)?, self.request.b.features.get(found.b)?);
        let verified = self.result.verification.as_ref();
        let inlier = verified.and_then(|v| v.inlier.get(index).copied());
        let error_px = verified.filter(|v| v.model.is_some()).and_then(|v| v.error_px.get(index).copied());
        Some(MatchRow { index, found, a, b, inlier, error_px })
    }

    /// All matches.
    pub fn rows(&self) -> impl Iterator<Item = MatchRow<'_>> {
        (0..self.len()).filter_map(|index| self.row(index))
    }

    /// Indices of the matches that are shown, in the table's order.
    pub fn listed(&self, look: &MatchLook, order: Order<MatchColumn>) -> Vec<usize> {
        let mut rows: Vec<MatchRow<'_>> = self.rows().filter(|row| look.shows(row.inlier)).collect();
        rows.sort_by(|a, b| {
            let by = order.column.value(a).total_cmp(&order.column.value(b));
            let by = if order.descending { by.reverse() } else { by };
            by.then(a.index.cmp(&b.index))
        });
        rows.iter().map(|row| row.index).collect()
    }

    /// Index of the match at the places of `saved`, if there is one.
    pub fn find_again(&self, saved: &SavedMatch) -> Option<usize> {
        let apart = |row: &MatchRow<'_>| {
            let of = |f: &Feature, at: [f32; 2]| (f.u - at[0]).hypot(f.v - at[1]);
            of(row.a, saved.a).max(of(row.b, saved.b))
        };
        let nearest = self.rows().min_by(|x, y| apart(x).total_cmp(&apart(y)))?;
        (apart(&nearest) <= SAME_PLACE_PX).then_some(nearest.index)
    }
}

impl MatchRow<'_> {
    /// Places with which the match is found again.
    pub fn saved(&self) -> SavedMatch {
        SavedMatch { a: [self.a.u, self.a.v], b: [self.b.u, self.b.v] }
    }
}
