//! Losses on the way to a match: the step at which each feature of A was lost, and the details of one feature.

use crate::app::project::Model;
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::engine::{Ended, Wanted};
use crate::inspect::unmatched::{Losses, Lost, Unmatched};
use crate::requests::{
    FoundLosses, LossesRequest, MatchRequest, Picture, PictureKind, PictureRequest, PicturesRequest,
};
use std::sync::Arc;

pub const CANDIDATES: usize = 5;
pub const PATCHES: usize = 3;

#[derive(Debug, Default)]
pub struct LostFeatures {
    pub found: Option<Arc<FoundLosses>>,
    pub why: Option<Why>,
    pub pictures: Vec<Picture>,
    pub wanted: Wanted<LossesRequest>,
    pub wanted_pictures: Wanted<PicturesRequest>,
}

#[derive(Debug, Clone)]
pub struct Why {
    pub feature: usize,
    of: LossesRequest,
    pub unmatched: Arc<Unmatched>,
}

impl LostFeatures {
    pub fn count(&self, lost: Lost) -> usize {
        let counts = self.found.as_ref().map(|found| found.counts);
        counts.into_iter().flatten().find(|(at, _)| *at == lost).map_or(0, |(_, count)| count)
    }
}

pub fn lost_label(lost: Lost) -> &'static str {
    match lost {
        Lost::Not => "matched",
        Lost::NoKeypoint => "no keypoint",
        Lost::RatioTest => "ratio test",
        Lost::MutualCheck => "mutual check",
        Lost::Geometry => "geometry",
    }
}

impl Model {
    /// A request that failed is repeated with the next matches.
    pub(in crate::app::project) fn missing_losses(&self) -> Option<LossesRequest> {
        self.wanted_losses().filter(|_| self.workspace == Workspace::Pair && self.losses().is_none())
    }

    pub(in crate::app::project) fn take_losses(&mut self, ended: Ended<LossesRequest>) {
        self.pair.lost.found = ended.result.ok().map(Arc::new).or_else(|| self.pair.lost.found.take());
        self.refresh_why();
    }

    pub(in crate::app::project) fn missing_candidate_pictures(&self) -> Option<PicturesRequest> {
        let pictures = self.wanted_candidate_pictures();
        let shown = self.pair.lost.pictures.iter().map(|picture| &picture.request);
        (self.workspace == Workspace::Pair && !shown.eq(&pictures)).then_some(PicturesRequest(pictures))
    }

    pub(in crate::app::project) fn take_lost_pictures(&mut self, ended: Ended<PicturesRequest>) {
        if let Ok(pictures) = ended.result {
            self.pair.lost.pictures = pictures;
        }
    }

    pub fn wanted_losses(&self) -> Option<LossesRequest> {
        let matches = self.pair.matches.as_ref()?;
        let size_b = self.burst_of(Side::B)?.burst.size();
        Some(LossesRequest { request: matches.request.clone(), result: matches.result.clone(), size_b })
    }

    pub fn losses(&self) -> Option<&Arc<FoundLosses>> {
        let wanted = self.wanted_losses()?;
        self.pair.lost.found.as_ref().filter(|found| found.request == wanted)
    }

    pub fn asked_feature(&self) -> Option<usize> {
        let of_match = || {
            let matches = self.pair.matches.as_ref()?;
            Some(matches.row(self.selected_match?)?.found.a)
        };
        of_match().or(self.asked_about)
    }

    pub fn ask_feature(&mut self, index: Option<usize>) {
        let matches = self.pair.matches.as_ref();
        let its_match = index.and_then(|index| matches?.rows().find(|row| row.found.a == index).map(|row| row.index));
        (self.selected_match, self.asked_about) = (its_match, index);
    }

    pub fn refresh_why(&mut self) {
        if self.workspace != Workspace::Pair {
            return;
        }
        if self.pair.lost.found.is_some() && self.losses().is_none() {
            // Another pair: what was asked about is no feature of it.
            self.asked_about = None;
            let LostFeatures { wanted, wanted_pictures, .. } = std::mem::take(&mut self.pair.lost);
            self.pair.lost = LostFeatures { wanted, wanted_pictures, ..LostFeatures::default() };
        }
        let asked = self.asked_feature();
        let why = match (asked, self.losses()) {
            (Some(feature), Some(found)) if feature < found.lost.len() => {
                let old = self.pair.lost.why.as_ref();
                if old.is_some_and(|why| why.feature == feature && why.of == found.request) {
                    return;
                }
                let losses = Losses::again(found.request.pair(), found.nearest.clone());
                let unmatched = Arc::new(losses.of(feature, CANDIDATES));
                Some(Why { feature, of: found.request.clone(), unmatched })
            }
            _ => None,
        };
        self.pair.lost.why = why;
    }

    /// Pixels at mid-burst: of an epipolar line the point nearest to its place in A, as features mostly move little
    /// from burst to burst. `None` where no geometry is known, and where the place lies outside B.
    pub fn expected_place(&self) -> Option<[f32; 2]> {
        let (why, found) = self.pair.lost.why.as_ref().zip(self.losses())?;
        let own = found.request.request.a.features.get(why.feature)?;
        nearest_on(&why.unmatched.expected, [f64::from(own.u), f64::from(own.v)]).map(|place| place.map(|x| x as f32))
    }

    pub fn wanted_candidate_pictures(&self) -> Vec<PictureRequest> {
        let Some((why, found)) = self.pair.lost.why.as_ref().zip(self.losses()) else { return Vec::new() };
        let MatchRequest { a, b, .. } = &found.request.request;
        let own = a.features.get(why.feature).map(|f| (Side::A, f.slope));
        let candidates = why.unmatched.candidates.iter().take(PATCHES);
        let others = candidates.filter_map(|c| b.features.get(c.feature).map(|f| (Side::B, f.slope)));
        own.into_iter()
            .chain(others)
            .filter_map(|(side, slope)| {
                let (burst, found) = (self.burst_of(side)?.clone(), self.found_of(side)?);
                Some(PictureRequest::new(burst, PictureKind::Stack { slope }, found.params.clone()))
            })
            .collect()
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
