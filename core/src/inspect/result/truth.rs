//! The features of a burst compared with its truth by the rule of [`finds`], with the reason of each
//! miss. A disc of which all features move otherwise than it does ([`motion_limit`]) is not found, but found at a wrong
//! motion.

use super::score::{Ranking, finds, is_of_disc, judge};
use crate::error::{Error, ErrorKind, Result};
use crate::export::case::{self, is_case};
use crate::files::{MAX_TABLE_BYTES, read_text};
use crate::inspect::place::{Fate, Near, is_same_motion, motion_limit, near, sorted_by_stage, too_small};
use crate::monitor::{Cancelled, Monitor};
use crate::synth::{Example, FeatureTruth, Truth, TruthKind, demo_truth};
use crate::{burst::Burst, detector::Slope, inspect::ProbeCache};
use serde::Serialize;
use std::path::Path;

const DEMO: &str = "demo";

fn wrong(path: &Path, problem: String, remedy: &str) -> Error {
    Error::new(ErrorKind::Content, problem, remedy).about(path)
}

fn no_truth(path: &Path, reason: &str) -> Error {
    let problem = format!("not the truth of a synthetic burst: {reason}");
    wrong(path, problem, "give a truth.json written by 'burstscope synth'")
}

/// Reads a `truth.json`.
pub fn read_truth(path: &Path) -> Result<Truth> {
    let text = read_text(path, MAX_TABLE_BYTES).map_err(|e| wrong(path, format!("cannot be read: {e}"), ""))?;
    let invalid = |reason: String| no_truth(path, &reason);
    let truth: Truth = serde_json::from_str(&text).map_err(|e| invalid(e.to_string()))?;
    truth.check().map_err(invalid)?;
    Ok(truth)
}

/// The truth of a burst, if it has one: the `truth.json` in its folder or case, or that of a built-in burst.
pub fn truth_of(burst: &Burst) -> Result<Option<Truth>> {
    let [source] = &burst.sources[..] else {
        let name = Some(&burst.name).filter(|_| burst.sources.is_empty());
        let demo = name.filter(|name| *name == DEMO).map(|_| demo_truth());
        return Ok(demo.or_else(|| name.and_then(|name| Example::named(name)).map(Example::truth)));
    };
    let (path, truth) = if is_case(source) {
        let unread = |error: Error| no_truth(source, &error.to_string());
        (source.clone(), case::read_truth(source).map_err(unread)?)
    } else {
        let path = source.join("truth.json");
        let truth = path.is_file().then(|| read_truth(&path)).transpose()?;
        (path, truth)
    };
    let Some(truth) = truth else { return Ok(None) };
    let size = (truth.width, truth.height);
    if size != burst.size() {
        let problem = format!("made for {size:?} pixels, but the burst has {:?}", burst.size());
        return Err(wrong(&path, problem, "give the truth of this burst"));
    }
    Ok(Some(truth))
}

/// Whether a burst has a truth, without reading it.
pub fn has_truth(burst: &Burst) -> bool {
    match &burst.sources[..] {
        [source] if is_case(source) => case::has_truth(source),
        [source] => source.join("truth.json").is_file(),
        _ => burst.sources.is_empty() && (burst.name == DEMO || Example::named(&burst.name).is_some()),
    }
}

/// A disc that no feature found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Miss {
    /// Index in the truth.
    pub disc: usize,
    /// The candidate that would have found it and came farthest, the strongest of several; `None` where there is none.
    pub fate: Option<Fate>,
    /// Reason of the miss, as a clause.
    pub why: String,
}

/// Comparison of features with the truth.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct AgainstTruth {
    /// (feature, disc) for each disc found: the strongest feature on it that moves as it does.
    pub found: Vec<(usize, usize)>,
    /// (feature, disc) for each disc that only features of another motion lie on: the strongest of them.
    pub at_wrong_motion: Vec<(usize, usize)>,
    /// Discs that were not found.
    pub missed: Vec<Miss>,
    /// Features on a disc that a stronger one already found.
    pub repeated: Vec<usize>,
    /// Features where the truth has no disc.
    pub elsewhere: Vec<usize>,
    /// Whether the truth is complete, as that of a chart is; a scene's covers only a part.
    pub is_whole_truth: bool,
}

impl AgainstTruth {
    /// Label of the features [elsewhere](Self::elsewhere): they are false only where the truth is complete.
    pub fn name_of_elsewhere(&self) -> &'static str {
        if self.is_whole_truth { "False" } else { "Elsewhere" }
    }

    /// The counts as a sentence.
    pub fn summary(&self) -> String {
        let discs = [self.found.len(), self.at_wrong_motion.len(), self.missed.len()];
        let [all, repeated, elsewhere] = [discs.iter().sum(), self.repeated.len(), self.elsewhere.len()];
        let ([found, wrong, missed], name) = (discs, self.name_of_elsewhere().to_lowercase());
        format!(
            "{found} of {all} found; {wrong} at a wrong motion, {missed} missed, {repeated} repeated, {elsewhere} {name}"
        )
    }
}

/// Compares the features with `truth`.
///
/// ```
/// use burstscope_core::inspect::{ProbeCache, result::against_truth};
/// use burstscope_core::{Monitor, detector::SearchParams, synth::{ChartParams, synth_chart}};
/// let (chart, monitor) = (ChartParams { width: 400, discs: 12, ..ChartParams::default() }, Monitor::default());
/// let (burst, truth) = synth_chart(&chart, &monitor)?;
/// let cache = ProbeCache::new(&burst, &SearchParams::default(), &monitor)?;
/// let against = against_truth(&cache, &truth, &monitor)?;
/// assert_eq!(against.found.len() + against.at_wrong_motion.len() + against.missed.len(), 12);
/// assert!(against.missed.iter().all(|miss| !miss.why.is_empty()), "each miss has its reason");
/// # Ok::<(), burstscope_core::Error>(())
/// ```
pub fn against_truth(cache: &ProbeCache, truth: &Truth, monitor: &Monitor) -> Result<AgainstTruth, Cancelled> {
    let features = &cache.detection().features;
    // Those of one keypoint count once.
    let mut rest: Vec<usize> = judge(features, truth, Ranking::Strength).iter().map(|judged| judged.feature).collect();
    let mut out = AgainstTruth { is_whole_truth: truth.kind == TruthKind::Chart, ..AgainstTruth::default() };
    let mut free = vec![true; truth.features.len()];
    for by_motion in [true, false] {
        rest.retain(|&index| {
            let feature = &features[index];
            let distance = |disc: usize| {
                let disc = &truth.features[disc];
                (f64::from(feature.u) - disc.u).hypot(f64::from(feature.v) - disc.v)
            };
            let finds = |disc: &usize| {
                let disc = &truth.features[*disc];
                let (slope, limit) = (slope_of(disc), motion_limit(disc.sigma as f32, truth.span()));
                let moves_as_it = (feature.slope.u - slope.u).hypot(feature.slope.v - slope.v) <= limit;
                finds(feature, disc) && (!by_motion || moves_as_it)
            };
            let discs = (0..free.len()).filter(|disc| free[*disc]).filter(finds);
            let Some(disc) = discs.min_by(|a, b| distance(*a).total_cmp(&distance(*b))) else { return true };
            free[disc] = false;
            if by_motion { &mut out.found } else { &mut out.at_wrong_motion }.push((index, disc));
            false
        });
    }
    let lies_on_one = |index: &usize| truth.features.iter().any(|disc| finds(&features[*index], disc));
    (out.repeated, out.elsewhere) = rest.into_iter().partition(lies_on_one);
    for (index, disc) in truth.features.iter().enumerate().filter(|(index, _)| free[*index]) {
        monitor.check()?;
        out.missed.push(miss(cache, index, disc, monitor)?);
    }
    Ok(out)
}

fn slope_of(disc: &FeatureTruth) -> Slope {
    Slope::new(disc.slope_u as f32, disc.slope_v as f32)
}

/// Reason why no feature found `disc`, the truth's number `index`.
pub fn miss(cache: &ProbeCache, index: usize, disc: &FeatureTruth, monitor: &Monitor) -> Result<Miss, Cancelled> {
    let (width, height) = cache.burst.size();
    let inside = disc.u >= 0.0 && disc.v >= 0.0 && disc.u <= (width - 1) as f64 && disc.v <= (height - 1) as f64;
    if !inside {
        return Ok(Miss { disc: index, fate: None, why: "it lies outside the picture at mid-burst".to_owned() });
    }
    let place = [disc.u as f32, disc.v as f32];
    let (trail, slope) = (&cache.trail, slope_of(disc));
    let Near { fates, peaks, .. } = near(trail, place, REACH_SIGMAS, monitor)?;
    // A candidate would find it with its position, its size, and its sign (a bright disc is a negative extremum).
    let would_find =
        |fate: &Fate| is_of_disc(fate.pos_image, fate.sigma, disc) && (fate.value < 0.0) == (disc.contrast_sign > 0);
    let fates: Vec<Fate> = sorted_by_stage(fates.into_iter().filter(would_find).collect());
    let own = fates.iter().find(|fate| is_same_motion(trail, fate.slope, slope, disc.sigma as f32));
    let outdoes = |snr: f32| own.is_none_or(|fate| !fate.is_kept() && snr > fate.snr);
    let small = too_small(trail, &peaks, &[slope], monitor)?;
    let small = small.filter(|reason| reason.sigma_and_snr.is_some_and(|(_, snr)| outdoes(snr)));
    let best = own.or(fates.first()).cloned();
    let nothing = || "no candidate of its size stands out there at any slope".to_owned();
    let why = small.map(|reason| reason.sentence);
    let why = why.unwrap_or_else(|| best.as_ref().map_or_else(nothing, |fate| fate.verdict.clone()));
    Ok(Miss { disc: index, fate: best, why })
}

/// Maximum distance of the candidates that are examined, in σ.
const REACH_SIGMAS: f32 = 1.5;
