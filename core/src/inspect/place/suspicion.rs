//! Kept features that look wrong, with the evidence in numbers (people decide whether a suspicion is right), and the
//! likely nature of each feature, from its suspicions and the evenness of the frames' responses.

use super::fate::{Fate, apart_sigmas};
use super::pixels::{Around, Period, around, period_along};
use super::response::{covering, snr_at};
use super::{remedy::widened_towards, shares::directions};
use crate::detector::coherence::{BUMP_COHERENCE, Evenness, Shape};
use crate::detector::noise::false_keypoints;
use crate::detector::{Detection, Distinct, Feature, ParamChange, Slope, Trail};
use crate::inspect::words::{number, rounded_up, slope_text};
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::tile::Region;
use crate::{detector::params::doc, export::FeatureVerdict};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Possible fault of a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SuspicionKind {
    /// Another feature lies on the same blob, just beyond the radius of distinct keypoints.
    Duplicate,
    /// A blob of another motion that shows in this slope's stack.
    Ghost,
    /// The slope is on the rim of the grid and the response rises beyond.
    AtLimit,
    /// The texture is periodic, and another slope, whole periods away, responds nearly as strongly, or more.
    Alias,
    /// The picture around the feature changes along the feature's motion.
    Changing,
    /// The picture around the feature moves by another slope as well, as along an edge.
    Edge,
}

impl SuspicionKind {
    fn verdict(self) -> Option<Verdict> {
        match self {
            Self::Duplicate => Some(Verdict::Duplicate),
            Self::Ghost => Some(Verdict::Ghost),
            Self::Alias => Some(Verdict::Alias),
            Self::Changing | Self::Edge => Some(Verdict::Unclear),
            Self::AtLimit => None,
        }
    }

    /// Name of the fault and its meaning, without a capital at the start or a full stop at the end.
    pub fn words(self) -> [&'static str; 2] {
        match self {
            Self::Duplicate => ["duplicate", "another feature lies on the same blob"],
            Self::Ghost => ["ghost", "a blob with another motion shows in this slope's motion stack"],
            Self::AtLimit => {
                ["at the limit", "its slope is at the end of the searched range, and its response rises beyond"]
            }
            Self::Alias => ["alias", "the texture repeats, and another slope shows it as well"],
            Self::Changing => ["another motion", "the picture around it does not move by its slope"],
            Self::Edge => ["edge", "the picture around it moves by another slope as well"],
        }
    }
}

/// Suspicion about a feature.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suspicion {
    /// Possible fault.
    pub kind: SuspicionKind,
    /// Evidence, as a sentence.
    pub evidence: String,
    /// σ apart, coherence, rise beyond the rim, or the other slope's response over this one's.
    pub number: f32,
    /// The other feature, where there is one.
    pub other: Option<usize>,
    /// The other slope, px/frame, where there is one.
    pub other_slope: Option<Slope>,
    /// Change that would correct it.
    pub change: Option<ParamChange>,
}

impl Suspicion {
    fn new(kind: SuspicionKind, number: f32, evidence: String) -> Self {
        Self { kind, evidence, number, other: None, other_slope: None, change: None }
    }
}

/// Distance, in σ of the stronger one, within which two features are suspected to share a blob.
const NEAR_SIGMAS: f32 = 2.0;
const NEAR_SCALES: f32 = 2.0;
/// Distance, in σ, within which the paths of a ghost and of its source cross.
const CROSSES_SIGMAS: f32 = 2.0;
/// Tolerance of a whole number of periods between slopes, as a part of a period.
const PERIOD_PART: f32 = 0.2;
/// Minimum response of another slope, as a part of the feature's, for an alias.
const ALIAS_RESPONSE: f32 = 0.7;
/// Pixels to each side in which a period is searched: in σ, at least, and at most, as slopes differ by no more.
const TEXTURE_SIGMAS: f32 = 8.0;
/// Distance of slopes, pixels per frame, below which none is a period away, allowing for [`PERIOD_PART`].
const SHORTEST_PERIOD_PX: f32 = 2.0;
const TEXTURE_LEAST_PX: usize = 24;
const TEXTURE_MOST_PX: usize = 64;

/// Suspicions about a kept candidate whose frames respond with `evenness`, each with a change that would correct it.
pub fn suspicions(
    trail: &Trail,
    fate: &Fate,
    evenness: &Evenness,
    monitor: &Monitor,
) -> Result<Vec<Suspicion>, Cancelled> {
    let Some(&index) = fate.features.first() else { return Ok(Vec::new()) };
    let mut found = suspicions_of_feature(trail, index, evenness, monitor)?;
    for suspicion in found.iter_mut().filter(|suspicion| suspicion.kind == SuspicionKind::Duplicate) {
        suspicion.change = suspicion.other.and_then(|other| wider_distinct(trail, index, other));
    }
    found.extend(at_limit(trail, fate, &trail.detection().features[index]));
    Ok(found)
}

/// Suspicions about feature `index` of the detection, except that of a slope beyond the range, and without changes.
pub fn suspicions_of_feature(
    trail: &Trail,
    index: usize,
    evenness: &Evenness,
    monitor: &Monitor,
) -> Result<Vec<Suspicion>, Cancelled> {
    let feature = trail.detection().features[index];
    let found = [duplicate(trail, index, &feature), ghost(trail, index, &feature, evenness)];
    let mut found: Vec<Suspicion> = found.into_iter().flatten().chain(alias(trail, &feature, monitor)?).collect();
    // The picture takes longer to compare, and changes no other verdict.
    if found.is_empty() {
        found.extend(around(trail, &feature, monitor)?.map(|(motion, coherence, evidence)| {
            let (kind, other_slope) = match motion {
                Around::Changes => (SuspicionKind::Changing, None),
                Around::MovesBy(slope) => (SuspicionKind::Ghost, Some(slope)),
                Around::MovesAlsoBy(slope) => (SuspicionKind::Edge, Some(slope)),
            };
            Suspicion { other_slope, ..Suspicion::new(kind, coherence, evidence) }
        }));
    }
    Ok(found)
}

fn wider_distinct(trail: &Trail, index: usize, other: usize) -> Option<ParamChange> {
    let params = trail.params();
    let (own, stronger) = (trail.keypoint_of_feature(index), trail.keypoint_of_feature(other));
    let Distinct::Radius(radius) = params.distinct else {
        return Some(ParamChange::new(doc::DISTINCT, Distinct::default()));
    };
    let (a, b) = (trail.keypoints()[stronger], trail.keypoints()[own]);
    let (apart, scales) = (apart_sigmas(&a, &b), (a.in_image().2, b.in_image().2));
    let wider = rounded_up(1.001 * f64::from(apart), 2);
    let ratio = rounded_up(1.001 * f64::from((scales.0 / scales.1).max(scales.1 / scales.0)), 3);
    let by_radius = wider > f64::from(radius) && !trail.would_stay(own, wider as f32, params.distinct_scale);
    let by_ratio = || ratio > f64::from(params.distinct_scale) && !trail.would_stay(own, radius, ratio as f32);
    if by_radius {
        return Some(ParamChange::new(doc::DISTINCT, wider));
    }
    by_ratio().then(|| ParamChange::new(doc::DISTINCT_SCALE, ratio))
}

/// Distance, in input pixels, of the paths of two features in each frame that took part.
fn path_distances<'t>(trail: &'t Trail, a: &Feature, b: &Feature) -> impl Iterator<Item = f32> + 't {
    let (_, kept, positions) = trail.frames();
    let (du, dv) = (b.u - a.u, b.v - a.v);
    let slope = Slope::new(b.slope.u - a.slope.u, b.slope.v - a.slope.v);
    kept.iter().map(move |&t| {
        let (moved_u, moved_v) = slope.displacement(positions.offset(t).to_f32());
        (du + moved_u).hypot(dv + moved_v)
    })
}

fn duplicate(trail: &Trail, index: usize, feature: &Feature) -> Option<Suspicion> {
    let (own, features) = (trail.keypoint_of_feature(index), &trail.detection().features);
    let on_it = |other: &Feature| {
        let distances = path_distances(trail, other, feature);
        2 * distances.filter(|px| *px < NEAR_SIGMAS * other.sigma).count() > trail.frames().1.len()
    };
    let (other, apart, _) = features[..index]
        .iter()
        .enumerate()
        .map(|(other, f)| (other, (f.u - feature.u).hypot(f.v - feature.v) / f.sigma, f.sigma / feature.sigma))
        .filter(|(_, apart, ratio)| *apart < NEAR_SIGMAS && ratio.max(ratio.recip()) < NEAR_SCALES)
        .filter(|(other, ..)| {
            let f = &features[*other];
            f.response.signum() == feature.response.signum() && trail.keypoint_of_feature(*other) != own && on_it(f)
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    let stronger = &features[other];
    let suspicion = Suspicion::new(SuspicionKind::Duplicate, apart, same_blob(other, stronger, feature, apart));
    Some(Suspicion { other: Some(other), other_slope: Some(stronger.slope), ..suspicion })
}

/// Says by which number `other` is stronger: by SNR, or else by response.
fn same_blob(other: usize, stronger: &Feature, feature: &Feature, apart_sigmas: f32) -> String {
    let by = if stronger.snr.is_finite() && stronger.snr > feature.snr {
        format!("SNR {} against {}", number(stronger.snr, 1), number(feature.snr, 1))
    } else {
        format!("|D| {:.2e} against {:.2e}", stronger.response.abs(), feature.response.abs())
    };
    format!(
        "feature {other}, which is stronger ({by}), lies {} σ away, has {} times the scale of this one, and slope {}",
        number(apart_sigmas, 2),
        number(stronger.sigma / feature.sigma, 2),
        slope_text(stronger.slope)
    )
}

/// Where only a part of the frames responds, it is a ghost of a stronger feature whose path crosses its own.
fn ghost(trail: &Trail, index: usize, feature: &Feature, evenness: &Evenness) -> Option<Suspicion> {
    if evenness.shape != Shape::Bump {
        return None;
    }
    let features = &trail.detection().features;
    let span = trail.frames().2.span() as f32;
    let crosses = |other: &Feature| {
        path_distances(trail, feature, other).any(|px| px < CROSSES_SIGMAS * other.sigma.max(feature.sigma))
    };
    let of = (0..index).find(|&other| {
        let f = &features[other];
        let differ = (f.slope.u - feature.slope.u).hypot(f.slope.v - feature.slope.v) * span;
        differ > f.sigma && crosses(f)
    });
    let coherence = evenness.coherence.unwrap_or(0.0);
    let of_what = of.map_or_else(
        || "no stronger feature crosses its path".to_owned(),
        |other| {
            let f = &features[other];
            let (u, v, slope) = (number(f.u, 1), number(f.v, 1), slope_text(f.slope));
            format!("feature {other} at ({u}, {v}) with slope {slope} crosses its path")
        },
    );
    let evidence = format!("only some of the frames respond (coherence {coherence:.2}); {of_what}");
    let other_slope = of.map(|other| features[other].slope);
    Some(Suspicion { other: of, other_slope, ..Suspicion::new(SuspicionKind::Ghost, coherence, evidence) })
}

fn at_limit(trail: &Trail, fate: &Fate, feature: &Feature) -> Option<Suspicion> {
    if !feature.at_slope_limit {
        return None;
    }
    let rise = trail.along().rises(feature).into_iter().map(|rise| rise.ratio).reduce(f32::max)?;
    let change = widened_towards(&trail.params().used_slopes(), fate)?;
    let evidence = format!(
        "it lies at the limit of the slopes, and beyond it the response is {} times as strong: widen them to {}",
        number(rise, 2),
        change.value
    );
    Some(Suspicion { change: Some(change), ..Suspicion::new(SuspicionKind::AtLimit, rise, evidence) })
}

fn alias(trail: &Trail, feature: &Feature, monitor: &Monitor) -> Result<Option<Suspicion>, Cancelled> {
    let Some((period, direction)) = period_at(trail, feature, monitor)? else { return Ok(None) };
    monitor.check()?;
    let grid = trail.params().used_slopes();
    let scale = (feature.octave, feature.level..feature.level + 1);
    let snr = |slope: Slope| snr_at(trail, scale.clone(), [feature.u, feature.v], slope)[0];
    let along = |s: Slope| s.u * direction[0] + s.v * direction[1];
    let reach = grid.slopes().map(|slope| (along(slope) - along(feature.slope)).abs()).fold(0.0, f32::max);
    let most = (reach / period.px + PERIOD_PART) as i32;
    let away = |periods: i32| {
        let by = periods as f32 * period.px;
        Slope::new(feature.slope.u + by * direction[0], feature.slope.v + by * direction[1])
    };
    let is_searched =
        |slope: &Slope| (along(*slope) - along(grid.slope(grid.nearest(*slope)))).abs() <= PERIOD_PART * period.px;
    let aliases = (-most..=most).filter(|periods| *periods != 0).map(away).filter(is_searched);
    let best = aliases.map(|slope| (slope, snr(slope) / snr(feature.slope))).max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((slope, ratio)) = best.filter(|(_, ratio)| *ratio > ALIAS_RESPONSE) else { return Ok(None) };
    let (px, correlation, at, times) = (number(period.px, 1), period.correlation, slope_text(slope), number(ratio, 2));
    let evidence = format!(
        "the texture repeats every {px} px (correlation {correlation:.2}), so slopes {px} px/frame apart look alike: slope {at} responds {times} times as strongly"
    );
    Ok(Some(Suspicion { other_slope: Some(slope), ..Suspicion::new(SuspicionKind::Alias, ratio, evidence) }))
}

/// The clearest period around a feature, in the stack at its own slope, and the direction of the grid that has it.
fn period_at(trail: &Trail, feature: &Feature, monitor: &Monitor) -> Result<Option<(Period, [f32; 2])>, Cancelled> {
    let grid = trail.params().used_slopes();
    // No other slope is a period away where the searched range is shorter than any period.
    let along = |[du, dv]: [f32; 2], slope: Slope| (slope.u - feature.slope.u) * du + (slope.v - feature.slope.v) * dv;
    let reaches = |direction: &[f32; 2]| grid.slopes().any(|slope| along(*direction, slope).abs() > SHORTEST_PERIOD_PX);
    let directions: Vec<[f32; 2]> = directions(&grid).filter(reaches).collect();
    if directions.is_empty() {
        return Ok(None);
    }
    let half_px = ((TEXTURE_SIGMAS * feature.sigma) as usize).clamp(TEXTURE_LEAST_PX, TEXTURE_MOST_PX);
    monitor.check()?;
    let region = Region::around([feature.u, feature.v], half_px + 8, trail.size_image());
    let stack = trail.stack_part(&region, feature.slope, &covering(trail, [feature.u, feature.v], feature.slope));
    let centre = [feature.u - region.columns.start as f32, feature.v - region.rows.start as f32];
    let found = directions.into_iter().filter_map(|d| Some((period_along(&stack, centre, d, half_px)?, d)));
    Ok(found.max_by(|a, b| a.0.correlation.total_cmp(&b.0.correlation)))
}

/// Likely nature of a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, strum::IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Verdict {
    /// Every frame shows it, no stronger feature explains it, and nothing around it speaks against its slope.
    Real,
    /// A blob of another motion, which shows in this slope's stack.
    Ghost,
    /// A periodic texture, which another slope shows as well.
    Alias,
    /// A blob that has a stronger feature.
    Duplicate,
    /// The evidence does not suffice.
    Unclear,
}

impl Verdict {
    /// All verdicts.
    pub const ALL: [Self; 5] = [Self::Real, Self::Ghost, Self::Alias, Self::Duplicate, Self::Unclear];

    /// Verdict as a word.
    pub fn word(self) -> &'static str {
        self.into()
    }

    /// Verdict as a clause.
    pub fn clause(self) -> &'static str {
        match self {
            Self::Real => "likely a real blob",
            Self::Ghost => "likely a ghost",
            Self::Alias => "likely an alias",
            Self::Duplicate => "likely a duplicate",
            Self::Unclear => "cannot be told",
        }
    }

    /// A ghost comes first: a ghost beside its source is no duplicate of it.
    fn of(evenness: &Evenness, suspicions: &[Suspicion]) -> Self {
        let is_suspected = |verdict: &Self| suspicions.iter().any(|one| one.kind.verdict() == Some(*verdict));
        let suspected = [Self::Ghost, Self::Duplicate, Self::Alias, Self::Unclear].into_iter().find(is_suspected);
        let is_coherent = evenness.coherence.is_some_and(|c| c >= BUMP_COHERENCE);
        let unsuspected = match evenness.shape {
            Shape::Level | Shape::Uneven if is_coherent => Self::Real,
            _ => Self::Unclear,
        };
        suspected.unwrap_or(unsuspected)
    }
}

/// Verdict about a feature, with its reason.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// Verdict.
    pub verdict: Verdict,
    /// See [`Evenness::coherence`].
    pub coherence: Option<f32>,
    /// Reason, a clause without a full stop. Features are counted from 0.
    pub why: String,
}

impl Judged {
    /// The verdict that follows from `evenness` and `suspicions` of a feature of this `snr`.
    pub(super) fn of(evenness: &Evenness, suspicions: &[Suspicion], snr: f32, strengths: &Strengths) -> Self {
        let (verdict, coherence) = (Verdict::of(evenness, suspicions), evenness.coherence);
        // A sum of noise that exceeds the gate is shared by the frames as evenly as a faint blob.
        if let Some([found, by_noise]) = strengths.by_noise(snr).filter(|_| verdict == Verdict::Real) {
            let as_strong = format!("some {:.0} keypoints about as strong (SNR {snr:.1})", by_noise.ceil());
            let why = format!("noise alone gives {as_strong}, and {found:.0} were found");
            return Self { verdict: Verdict::Unclear, coherence, why };
        }
        let suspicion = suspicions.iter().find(|suspicion| suspicion.kind.verdict() == Some(verdict));
        let why = match (verdict, coherence) {
            _ if let Some(suspicion) = suspicion => suspicion.evidence.clone(),
            (_, None) => "single frames are too noisy to compare".to_owned(),
            (Verdict::Real, Some(c)) => {
                format!("the frames respond alike (coherence {c:.2}), and nothing around it speaks against its slope")
            }
            (_, Some(c)) => format!("the frames respond differently (coherence {c:.2}), but not as to a ghost"),
        };
        Self { verdict, coherence, why }
    }
}

/// SNRs of the keypoints of a search, beside which noise gives some of its own.
pub(super) struct Strengths<'a> {
    trail: &'a Trail,
    /// From the weakest to the strongest.
    snrs: Vec<f32>,
}

/// Half of the range of SNRs that count as about as strong.
const ALIKE_SNR: f32 = 0.25;
/// Keypoints of SNR 3, 3.5, … on 5 Mpx of white noise for one that passes that gate: fits find peaks between samples.
const OF_SNR: [f64; 4] = [3.2, 2.4, 1.4, 1.1];
/// Share of the keypoints of a strength that noise explains from which none of them is told from it.
const EXPLAINED: f64 = 0.3;

impl<'a> Strengths<'a> {
    pub(super) fn of(trail: &'a Trail) -> Self {
        let mut snrs: Vec<f32> = trail.detection().features.iter().map(|feature| feature.snr).collect();
        snrs.sort_by(f32::total_cmp);
        // The features of a keypoint, one for each orientation, have its SNR.
        snrs.dedup();
        Self { trail, snrs }
    }

    /// Number of keypoints about as strong as `snr`, and how many of them noise alone gives, if it may explain them.
    fn by_noise(&self, snr: f32) -> Option<[f64; 2]> {
        let [low, high] = [snr - ALIKE_SNR, snr + ALIKE_SNR];
        let place = |end: f32| self.snrs.partition_point(|x| *x < end);
        let (width, height) = self.trail.size_image();
        let a_megapixel = |gate: f32| false_keypoints(self.trail.params(), f64::from(gate));
        let gate = self.trail.detection().noise_gate_factor;
        let keypoints = 1e-6 * (width * height) as f64 * (a_megapixel(low.max(gate)) - a_megapixel(high.max(gate)));
        let at = (2.0 * (snr - 3.0)).round().clamp(0.0, 3.0) as usize;
        let (found, by_noise) = ((place(high) - place(low)) as f64, OF_SNR[at] * keypoints);
        // As many, and what chance adds.
        let explained = by_noise / EXPLAINED;
        (found <= explained + 3.0 * explained.sqrt() && by_noise > 0.0).then_some([found, by_noise])
    }
}

/// Detection of the features on which the verdict is one of `kept`, with their verdicts as files have them.
pub fn kept(detection: &Detection, judged: &[Judged], kept: &[Verdict]) -> (Detection, Vec<FeatureVerdict>) {
    let is_kept = |index: &usize| kept.contains(&judged[*index].verdict);
    let indices: Vec<usize> = (0..judged.len()).filter(is_kept).collect();
    let features = indices.iter().map(|index| detection.features[*index]).collect();
    let descriptors = indices.iter().map(|index| detection.descriptors[*index]).collect();
    let verdict = |index: &usize| {
        let Judged { verdict, coherence, .. } = judged[*index];
        FeatureVerdict { word: verdict.word(), code: verdict as u8, coherence }
    };
    (Detection { features, descriptors, ..detection.clone() }, indices.iter().map(verdict).collect())
}

/// Judges every feature of the detection of `trail`, in their order.
pub fn judged(trail: &Trail, monitor: &Monitor) -> Result<Vec<Judged>, Cancelled> {
    let (features, strengths) = (&trail.detection().features, Strengths::of(trail));
    let indices: Vec<usize> = (0..features.len()).collect();
    let keypoint = |index: &usize| trail.keypoint_of_feature(*index);
    // The features of a keypoint, one after the other, differ in their orientation alone.
    let keypoints: Vec<&[usize]> = indices.chunk_by(|a, b| keypoint(a) == keypoint(b)).collect();
    let firsts: Vec<Feature> = keypoints.iter().map(|same| features[same[0]]).collect();
    let evenness = trail.evenness_of(&firsts, &monitor.part(0.0, EVENNESS_SHARE))?;
    let rest = monitor.part(EVENNESS_SHARE, 1.0 - EVENNESS_SHARE);
    let done = AtomicUsize::new(0);
    let judge = |(same, of): (&&[usize], &Evenness)| {
        let (suspicions, snr) = (suspicions_of_feature(trail, same[0], of, &rest)?, features[same[0]].snr);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        rest.report(Stage::Frames, done as f32 / firsts.len() as f32);
        Ok(vec![Judged::of(of, &suspicions, snr, &strengths); same.len()])
    };
    Ok(keypoints.par_iter().zip(&evenness).map(judge).collect::<Result<Vec<_>, Cancelled>>()?.concat())
}

const EVENNESS_SHARE: f32 = 0.3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stronger_one_has_the_larger_of_the_numbers_and_its_scale_is_compared_with_this_ones() {
        for (stronger, other, says) in [
            ((2.0, -0.02, 9.0), (3.6, -0.01, 8.0), "has 0.56 times the scale"),
            ((3.6, -0.01, 8.0), (2.0, -0.02, 9.0), "has 1.8 times the scale"),
            ((2.0, -0.02, 9.0), (2.0, -0.03, 8.0), "feature 3, which is stronger (SNR 9 against 8), lies 1.4 σ away"),
            // Features rank by |D|·√SNR: with less SNR, its |D| is the larger.
            ((2.0, -0.04, 7.0), (2.0, 0.03, 8.0), "stronger (|D| 4.00e-2 against 3.00e-2)"),
        ] {
            let [stronger, other] =
                [stronger, other].map(|(sigma, response, snr)| Feature { sigma, response, snr, ..Feature::default() });
            let text = same_blob(3, &stronger, &other, 1.4);
            assert!(text.contains(says), "{text}");
        }
    }
}
