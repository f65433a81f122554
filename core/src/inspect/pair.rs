//! Why is this feature of a pair not matched, or matched as it is?
//!
//! A feature of A passes three steps: ratio test, mutual check, and geometry. This module reports the step at which it
//! was lost, and, where a geometry is known, whether B has a keypoint there, and why matching by motion left it.

use crate::detector::{Detection, Feature, Slope};
use crate::matching::putative::{Nearest, distance_squared, nearest_two_both_ways};
use crate::matching::{MatchParams, MatchResult, TwoViewModel};
use crate::monitor::{Cancelled, Monitor};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Step at which a feature of A was lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lost {
    /// The feature is an inlier.
    Not,
    /// B has no feature to compare with, or none of its size where the geometry expects it.
    NoKeypoint,
    /// The second nearest descriptor is almost as near.
    RatioTest,
    /// The nearest feature of B is nearer to another feature of A.
    MutualCheck,
    /// The match does not fit the geometry.
    Geometry,
    /// The descriptors match, but another feature lies where the motion puts it.
    Motion,
}

impl Lost {
    /// All steps, in order.
    pub const ALL: [Self; 6] =
        [Self::Not, Self::NoKeypoint, Self::RatioTest, Self::MutualCheck, Self::Geometry, Self::Motion];
}

/// A feature of B that may match one of A.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rivalry {
    /// Index in B.
    pub feature: usize,
    /// Distance of the descriptors.
    pub distance: f32,
    /// Ratio of that distance to that of the next nearest of all of B; `None` for the last.
    pub ratio: Option<f32>,
    /// Distance, as both were found, from the place that the geometry expects, pixels; `None` where none is known.
    pub error_px: Option<f32>,
    /// Slope, px/frame.
    pub slope: Slope,
    /// Whether it lies on the same blob as the first of the list; then the two count as one.
    pub is_same_blob: bool,
}

/// Explanation of a feature's match or of its absence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unmatched {
    /// Step at which it was lost.
    pub lost: Lost,
    /// Ratio of the ratio test, with the mutual check the larger of both directions; `None` where nothing competes.
    pub ratio: Option<f32>,
    /// Nearest features of B, nearest first.
    pub candidates: Vec<Rivalry>,
    /// The feature of A that B's nearest would choose instead, where the mutual check failed.
    pub preferred: Option<usize>,
    /// Expected place in B by the geometry: one place, or a line through these; empty where none is known or visible.
    pub expected: Vec<[f64; 2]>,
    /// Outline of the place in B that its motion predicts; empty where none is.
    pub predicted: Vec<[f64; 2]>,
    /// Features of B there, nearest descriptor first, with their rank among all of B.
    pub there: Vec<(usize, usize)>,
    /// Explanation as a sentence.
    pub sentence: String,
}

/// Distance, in σ, within which two features of one picture share a blob.
const SAME_BLOB_SIGMAS: f32 = 2.0;
/// Maximum ratio of scales of the same blob in two pictures.
const SAME_SCALE: f32 = 2.0;

/// The pair that is examined: both detections, the result of matching them, and its parameters.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)] // sizes are columns, rows
pub struct ComparedPair<'a> {
    pub a: &'a Detection,
    pub b: &'a Detection,
    pub size_b: (usize, usize),
    pub result: &'a MatchResult,
    pub params: &'a MatchParams,
}

impl ComparedPair<'_> {
    fn model(&self) -> Option<&TwoViewModel> {
        self.result.verification.as_ref()?.model.as_ref()
    }

    fn there(&self, model: &TwoViewModel, index: usize) -> Vec<usize> {
        let own = &self.a.features[index];
        let limit = f64::from(self.params.max_error_px);
        (0..self.b.features.len())
            .filter(|&other| {
                let sigma = self.b.features[other].sigma;
                sigma.max(own.sigma) / sigma.min(own.sigma) <= SAME_SCALE
                    && model.error_px(place(own), place(&self.b.features[other])) <= limit
            })
            .collect()
    }
}

fn place(feature: &Feature) -> [f64; 2] {
    [feature.u, feature.v].map(f64::from)
}

/// For each feature of both sides its nearest ones on the other; kept while the pair is examined.
#[derive(Debug, Clone)]
pub struct NearestOfBoth {
    of_a: Vec<Nearest>,
    of_b: Vec<Nearest>,
}

/// A pair with the nearest descriptors of both sides computed.
#[derive(Debug)]
pub struct Losses<'a> {
    pair: ComparedPair<'a>,
    nearest: Arc<NearestOfBoth>,
}

impl<'a> Losses<'a> {
    /// Compares the descriptors of `pair`, as matching does.
    pub fn new(pair: ComparedPair<'a>, monitor: &Monitor) -> Result<Self, Cancelled> {
        let (a, b) = (&pair.a.descriptors, &pair.b.descriptors);
        let (of_a, of_b) = nearest_two_both_ways(a, b, monitor)?;
        Ok(Self::again(pair, Arc::new(NearestOfBoth { of_a, of_b })))
    }

    /// The losses of `pair` with the nearest features from an earlier computation.
    pub fn again(pair: ComparedPair<'a>, nearest: Arc<NearestOfBoth>) -> Self {
        Self { pair, nearest }
    }

    /// The nearest features, for [`Self::again`].
    pub fn nearest(&self) -> Arc<NearestOfBoth> {
        self.nearest.clone()
    }

    /// The step at which feature `index` of A was lost.
    pub fn lost(&self, index: usize) -> Lost {
        let (pair, NearestOfBoth { of_a, of_b }) = (&self.pair, &*self.nearest);
        if let Ok(number) = pair.result.matches.binary_search_by_key(&index, |m| m.a) {
            let inlier = pair.result.verification.as_ref().is_none_or(|v| v.inlier[number]);
            return if inlier { Lost::Not } else { Lost::Geometry };
        }
        let is_there = || pair.model().is_none_or(|model| !pair.there(model, index).is_empty());
        let Some(nearest) = of_a.get(index).filter(|_| is_there()) else { return Lost::NoKeypoint };
        let back = &of_b[nearest.index];
        if pair.params.mutual && back.index != index {
            return Lost::MutualCheck;
        }
        // One that passes was matched by its descriptor, and its match gave way to another one along the geometry.
        if self.ratio(index).unwrap_or(0.0) <= pair.params.ratio { Lost::Motion } else { Lost::RatioTest }
    }

    fn ratio(&self, index: usize) -> Option<f32> {
        let nearest = self.nearest.of_a.get(index)?;
        let back = self.nearest.of_b[nearest.index].ratio().filter(|_| self.pair.params.mutual);
        [nearest.ratio(), back].into_iter().flatten().reduce(f32::max)
    }

    /// The numbers of features of A lost at each step, in the order of [`Lost::ALL`].
    pub fn counts(&self, monitor: &Monitor) -> Result<[(Lost, usize); 6], Cancelled> {
        let mut counts = Lost::ALL.map(|lost| (lost, 0));
        for index in 0..self.pair.a.features.len() {
            if index % 256 == 0 {
                monitor.check()?;
            }
            counts[self.lost(index) as usize].1 += 1;
        }
        Ok(counts)
    }

    /// Explains the match of feature `index` of A or its absence; lists the `count` nearest of B. Panics
    /// when A has no such feature: a mistake of the caller.
    pub fn of(&self, index: usize, count: usize) -> Unmatched {
        let NearestOfBoth { of_a, of_b } = &*self.nearest;
        let (pair, lost) = (self.pair, self.lost(index));
        let own = place(&pair.a.features[index]);
        let distance = |d| f64::from(distance_squared(&pair.a.descriptors[index], d)).sqrt() as f32;
        let mut order: Vec<(usize, f32)> = pair.b.descriptors.iter().map(distance).enumerate().collect();
        // Of equally near ones the first counts as the nearest, as in matching.
        order.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let model = pair.model();
        let first = order.first().map(|(other, _)| pair.b.features[*other]);
        let candidate = |(rank, &(feature, distance)): (usize, &(usize, f32))| {
            let f = &pair.b.features[feature];
            let next = order.get(rank + 1).map(|(_, next)| *next);
            let apart = |first: &Feature| (f.u - first.u).hypot(f.v - first.v) / first.sigma.max(f.sigma);
            let ratio = next.map(|next| if next > 0.0 { distance / next } else { 1.0 });
            let error_px = model.map(|model| model.error_px(own, place(f)) as f32);
            let is_same_blob = first.is_some_and(|first| apart(&first) < SAME_BLOB_SIGMAS);
            Rivalry { feature, distance, ratio, error_px, slope: f.slope, is_same_blob }
        };
        let candidates: Vec<Rivalry> = order.iter().take(count).enumerate().map(candidate).collect();
        let there = model.map(|model| pair.there(model, index)).unwrap_or_default();
        let ranked = order.iter().enumerate().filter(|(_, (other, _))| there.contains(other));
        let there: Vec<(usize, usize)> = ranked.map(|(rank, (other, _))| (*other, rank)).collect();
        let preferred = of_a.get(index).filter(|_| lost == Lost::MutualCheck).map(|nearest| of_b[nearest.index].index);
        let expected = model.map(|model| model.locus(1, own, pair.size_b)).unwrap_or_default();
        let leaves = model.is_some() && expected.is_empty();
        let sentence = if lost == Lost::NoKeypoint && leaves {
            "the geometry puts it outside the other picture".to_owned()
        } else {
            sentence(&pair, index, lost, &candidates, preferred, &there) + &at_prediction(&pair, index, lost)
        };
        let place = pair.result.prediction.as_ref().and_then(|prediction| prediction.in_b[index].as_ref());
        let predicted = place.zip(model).map(|(place, model)| place.outline(model)).unwrap_or_default();
        Unmatched { lost, ratio: self.ratio(index), candidates, preferred, expected, predicted, there, sentence }
    }
}

/// Reason, from the motions, why a feature that the sure matches left has no match; empty where there is none.
fn at_prediction(pair: &ComparedPair<'_>, index: usize, lost: Lost) -> String {
    let is_lost_before = matches!(lost, Lost::RatioTest | Lost::MutualCheck);
    let Some(prediction) = pair.result.prediction.as_ref().filter(|_| is_lost_before) else { return String::new() };
    if !prediction.is_believed() {
        return "; the motions of the two bursts contradict the geometry of their sure matches".to_owned();
    }
    let Some(expected) = &prediction.in_b[index] else { return "; its motion is not known well enough".to_owned() };
    let model = pair.model();
    let is_there = |f: &&Feature| model.is_some_and(|model| expected.holds(model.straight(1, place(f))));
    match pair.b.features.iter().filter(is_there).count() {
        0 => "; there is no feature where its motion puts it".to_owned(),
        1 => "; the feature where its motion puts it has another scale or descriptor".to_owned(),
        count => format!("; of the {count} features where its motion puts it none is clearly nearest"),
    }
}

/// Why the pictures contradict a match that is no inlier after the alignment, where they were looked at.
fn pictures_of(pair: &ComparedPair<'_>, index: usize) -> Option<String> {
    let alignment = pair.result.alignment.as_ref()?;
    let number = pair.result.matches.binary_search_by_key(&index, |m| m.a).ok()?;
    if !alignment.was_inlier[number] {
        return None;
    }
    Some(match alignment.measured[number] {
        None => alignment.contradicted.get(&number).map_or_else(
            || ": the picture of its place is not found there".to_owned(),
            |off_px| format!(": the matches around put its place {off_px:.1} px from where its picture is found"),
        ),
        Some((measured, residual_px)) => format!(
            ": the pictures of the two (correlation {:.2}) are {residual_px:.1} px from where others put them",
            measured.correlation
        ),
    })
}

fn sentence(
    pair: &ComparedPair<'_>,
    index: usize,
    lost: Lost,
    candidates: &[Rivalry],
    preferred: Option<usize>,
    there: &[(usize, usize)],
) -> String {
    let Some(best) = candidates.first() else { return "the other picture has no feature to compare with".to_owned() };
    let where_it_is = there.first().map_or_else(String::new, |(who, rank)| match rank {
        0 => format!("; the nearest, feature {who}, lies where the geometry expects it"),
        1 => format!("; feature {who} lies where the geometry expects it, but another has a nearer descriptor"),
        _ => format!("; feature {who} lies where the geometry expects it, but {rank} others have nearer descriptors"),
    });
    let (nearest, distance) = (format!("feature {}", best.feature), best.distance);
    let own_match = pair.result.matches.iter().find(|m| m.a == index);
    match lost {
        Lost::Not => {
            let Some(m) = own_match else { return String::new() };
            let at = format!("feature {} at distance {:.0}, ratio {}", m.b, m.distance, m.ratio_words());
            let by_motion = if m.predicted.is_some() { "where its motion puts it, " } else { "" };
            let nearer =
                if m.b == best.feature { String::new() } else { format!("; {nearest} is nearer, at {distance:.0}") };
            format!("matched {by_motion}with {at}{nearer}")
        }
        Lost::NoKeypoint => "the other picture has no keypoint of its size where the geometry expects it".to_owned(),
        Lost::RatioTest => {
            let who = candidates.get(1).map_or_else(String::new, |second| {
                let twin = if second.is_same_blob { ", a duplicate on the same blob" } else { "" };
                format!(" to feature {}{twin}", second.feature)
            });
            format!(
                "ratio test: the nearest is {nearest} at {distance:.0}, {:.2} times the distance{who}; at most {:.2} is allowed{where_it_is}",
                best.ratio.unwrap_or(0.0),
                pair.params.ratio
            )
        }
        Lost::MutualCheck => format!(
            "mutual check: its nearest, {nearest}, is nearer to {} of this picture{where_it_is}",
            preferred.map_or_else(|| "another".to_owned(), |index| format!("feature {index}"))
        ),
        Lost::Geometry | Lost::Motion => match own_match {
            Some(matched) => {
                let error = pair.model().map_or_else(String::new, |model| {
                    let error = model.error_px(place(&pair.a.features[index]), place(&pair.b.features[matched.b]));
                    format!(": {error:.1} px as found from the place it expects")
                });
                let why = pictures_of(pair, index).unwrap_or(error);
                format!("geometry: its match, feature {}, does not fit{why}", matched.b)
            }
            None => match pair.result.matches.iter().find(|m| m.b == best.feature) {
                Some(m) => format!("motion: its match, {nearest}, goes with feature {} where its motion is", m.a),
                None => format!("motion: its match, {nearest}, lies elsewhere than its motion puts it"),
            },
        },
    }
}
