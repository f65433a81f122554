//! Losses on the way to a match: the step at which each feature of A was lost, and the details of one feature.

use crate::app::results::pair::{MatchRow, Matches};
use crate::app::{document::Side, results::Read};
use crate::detector::{Feature, Slope};
use crate::engine::Wanted;
use crate::inspect::pair::{Lost, Unmatched};
use crate::inspect::words::counted;
use crate::matching::MatchParams;
use crate::requests::{FoundLosses, LossesRequest, MatchRequest, Matched};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

pub const CANDIDATES: usize = 5;
pub const PATCHES: usize = 3;
/// Largest factor by which a remedy raises the max error.
const MOST_FACTOR: f32 = 8.0;

#[derive(Debug, Default)]
pub struct LostFeatures {
    pub found: Option<Arc<FoundLosses>>,
    pub why: Option<Why>,
    pub wanted: Wanted<LossesRequest>,
    pub priced: Option<Matched>,
    pub pricing: Wanted<MatchRequest>,
    /// For each feature of A the first one of its keypoint that has no match, if it is another one or has a match.
    pub folded: Vec<Option<usize>>,
}

#[derive(Debug, Clone)]
pub struct Why {
    pub feature: usize,
    pub of: LossesRequest,
    pub unmatched: Arc<Unmatched>,
}

impl LostFeatures {
    pub fn count(&self, lost: Lost) -> usize {
        let all = self.found.iter().flat_map(|found| found.lost.iter().enumerate());
        all.filter(|(index, at)| **at == lost && self.twin(*index).is_none()).count()
    }

    /// Feature that stands for `index`, as another orientation of its keypoint.
    pub fn twin(&self, index: usize) -> Option<usize> {
        self.folded.get(index).copied().flatten()
    }

    /// Number of features for which `index` stands.
    pub fn others(&self, index: usize) -> usize {
        self.folded.iter().filter(|folded| **folded == Some(index)).count()
    }

    pub fn fold(&mut self) {
        let Some(found) = &self.found else { return };
        let features = &found.request.request.a.features;
        let has_match = |index: usize| matches!(found.lost[index], Lost::Not | Lost::Geometry);
        let mut first: HashMap<[u32; 3], usize> = HashMap::new();
        // Those with a match come first, and are never folded: each match counts.
        for matched in [true, false] {
            for (index, f) in features.iter().enumerate().filter(|(index, _)| has_match(*index) == matched) {
                first.entry([f.u, f.v, f.sigma].map(f32::to_bits)).or_insert(index);
            }
        }
        let stands = |(index, f): (usize, &Feature)| {
            let first = first[&[f.u, f.v, f.sigma].map(f32::to_bits)];
            (first != index && !has_match(index)).then_some(first)
        };
        self.folded = features.iter().enumerate().map(stands).collect();
    }
}

pub fn lost_words(lost: Lost) -> [&'static str; 2] {
    match lost {
        Lost::Not => ["matched", "Inliers"],
        Lost::NoKeypoint => ["no keypoint", "B has no keypoint of its size where the geometry expects it"],
        Lost::RatioTest => ["ratio test", "The second nearest descriptor is almost as near as the nearest"],
        Lost::MutualCheck => ["mutual check", "The nearest in B is nearer to another feature of A"],
        Lost::Geometry => ["geometry", "Matched, but the match does not fit the geometry"],
        Lost::Motion => ["motion", "The descriptors match, but another feature lies where the motion puts it"],
    }
}

impl<'a> Read<'a> {
    /// A request that failed is repeated with the next matches.
    pub fn missing_losses(self) -> Option<LossesRequest> {
        self.wanted_losses().filter(|_| self.document.workspace.shows_pair() && self.losses().is_none())
    }

    /// Parameters that could keep the feature in question, from the step where its match was lost.
    pub fn remedy(self) -> Option<MatchParams> {
        let why = self.results.pair.lost.why.as_ref()?;
        let matches = self.results.pair.matches.as_ref()?;
        let params = &matches.request.params;
        let changed = match why.unmatched.lost {
            Lost::RatioTest => MatchParams { ratio: (100.0 * why.unmatched.ratio?).ceil() / 100.0, ..params.clone() },
            Lost::MutualCheck => MatchParams { mutual: false, ..params.clone() },
            Lost::Geometry => {
                let factor = matches.rows().find(|row| row.found.a == why.feature)?.error_px? / matches.max_error_px();
                let max_error_px = (10.0 * factor * params.max_error_px).ceil() / 10.0;
                if !(1.0..MOST_FACTOR).contains(&factor) {
                    return None;
                }
                MatchParams { max_error_px, ..params.clone() }
            }
            Lost::Not | Lost::NoKeypoint | Lost::Motion => return None,
        };
        (changed != *params && changed.ratio <= 1.0).then_some(changed)
    }

    pub fn missing_price(self) -> Option<MatchRequest> {
        if !self.document.workspace.shows_pair() {
            return None;
        }
        let wanted = MatchRequest { params: self.remedy()?, ..self.results.pair.matches.as_ref()?.request.clone() };
        let is_there = self.results.pair.lost.priced.as_ref().is_some_and(|priced| priced.request == wanted);
        (!is_there && !self.results.pair.lost.pricing.has_failed(&wanted)).then_some(wanted)
    }

    /// Effect of the remedy: "matches it and 23 others"; `None` until it was tried.
    pub fn price_of_remedy(self, params: &MatchParams) -> Option<String> {
        let (priced, matches) = (self.results.pair.lost.priced.as_ref()?, self.results.pair.matches.as_ref()?);
        let (why, then) = (self.results.pair.lost.why.as_ref()?, Matches::new(priced.clone(), Duration::ZERO));
        if priced.request.params != *params || !then.is_of(Side::A, matches.detection(Side::A)) {
            return None;
        }
        let is_inlier = |row: &MatchRow<'_>| row.inlier != Some(false);
        let own = then.rows().find(|row| row.found.a == why.feature);
        if !own.as_ref().is_some_and(is_inlier) {
            return Some(if own.is_some() { "makes it an outlier" } else { "does not match it" }.to_owned());
        }
        let inliers = |of: &Matches| of.rows().filter(is_inlier).count();
        let (now, before) = (inliers(&then), inliers(matches));
        Some(match now.checked_sub(before + 1) {
            Some(others) => format!("matches it and {}", counted(others, "other")),
            None => format!("matches it, and loses {}", counted(before + 1 - now, "other")),
        })
    }

    pub fn wanted_losses(self) -> Option<LossesRequest> {
        let matches = self.results.pair.matches.as_ref()?;
        let size_b = self.burst_of(Side::B)?.burst.size();
        Some(LossesRequest { request: matches.request.clone(), result: matches.result.clone(), size_b })
    }

    pub fn losses(self) -> Option<&'a Arc<FoundLosses>> {
        let wanted = self.wanted_losses()?;
        self.results.pair.lost.found.as_ref().filter(|found| found.request == wanted)
    }

    pub fn asked_feature(self) -> Option<usize> {
        self.selected_match().map(|row| row.found.a).or(self.document.asked_about)
    }

    /// Pixels at mid-burst: of an epipolar line the point nearest to its place in A, as features mostly move little
    /// from burst to burst. `None` where no geometry is known, and where the place lies outside B.
    pub fn expected_place(self) -> Option<[f32; 2]> {
        let (why, found) = self.results.pair.lost.why.as_ref().zip(self.losses())?;
        let own = found.request.request.a.features.get(why.feature)?;
        nearest_on(&why.unmatched.expected, [f64::from(own.u), f64::from(own.v)]).map(|place| place.map(|x| x as f32))
    }

    pub(super) fn patches_of_candidates(self) -> Vec<(Side, Slope)> {
        let Some((why, found)) = self.results.pair.lost.why.as_ref().zip(self.losses()) else { return Vec::new() };
        let MatchRequest { a, b, .. } = &found.request.request;
        let own = a.features.get(why.feature).map(|f| (Side::A, f.slope));
        let candidates = why.unmatched.candidates.iter().take(PATCHES);
        own.into_iter().chain(candidates.filter_map(|c| Some((Side::B, b.features.get(c.feature)?.slope)))).collect()
    }
}

fn nearest_on(points: &[[f64; 2]], [u, v]: [f64; 2]) -> Option<[f64; 2]> {
    let on_part = |part: &[[f64; 2]]| {
        let ([from_u, from_v], [to_u, to_v]) = (part[0], part[1]);
        let (du, dv) = (to_u - from_u, to_v - from_v);
        let length2 = du * du + dv * dv;
        let along = if length2 > 0.0 { ((u - from_u) * du + (v - from_v) * dv) / length2 } else { 0.0 };
        let along = along.clamp(0.0, 1.0);
        [from_u + along * du, from_v + along * dv]
    };
    let apart = |point: &[f64; 2]| (point[0] - u).hypot(point[1] - v);
    let on_line = points.windows(2).map(on_part);
    points.first().copied().into_iter().chain(on_line).min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_line_the_nearest_point_is_taken() {
        assert_eq!(nearest_on(&[], [1.0, 2.0]), None);
        assert_eq!(nearest_on(&[[7.0, 8.0]], [1.0, 2.0]), Some([7.0, 8.0]));
        let line = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]];
        assert_eq!(nearest_on(&line, [4.0, 3.0]), Some([4.0, 0.0]));
        assert_eq!(nearest_on(&line, [12.0, 7.0]), Some([10.0, 7.0]));
        assert_eq!(nearest_on(&line, [-3.0, -3.0]), Some([0.0, 0.0]));
        assert_eq!(nearest_on(&[[2.0, 2.0], [2.0, 2.0]], [0.0, 0.0]), Some([2.0, 2.0]));
    }
}
