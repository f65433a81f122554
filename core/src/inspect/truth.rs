//! Found, missed, repeated, and false or elsewhere: the features of a burst compared with its truth, with the reason of
//! each miss.
//!
//! A disc is found by the rule of [`crate::inspect::score`].

use super::probe::fates_near;
use super::{Fate, ProbeCache};
use crate::burst::Burst;
use crate::export::case::{self, is_case};
use crate::files::{MAX_TABLE_BYTES, read_text};
use crate::inspect::score::{Ranking, finds, is_of_disc, judge};
use crate::monitor::{Cancelled, Monitor};
use crate::synth::{Example, FeatureTruth, Truth, TruthKind, demo_truth};
use serde::Serialize;
use std::path::{Path, PathBuf};

const DEMO: &str = "demo";

/// Reason why there is no truth to compare with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TruthError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// The file is not a truth.
    #[error("{}: not the truth of a synthetic burst: {reason}; give a truth.json written by 'burstscope synth'", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Problem and its place.
        reason: String,
    },
    /// The truth belongs to another burst.
    #[error("{}: made for {truth:?} pixels, but the burst has {burst:?}; give the truth of this burst", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// Columns and rows of the truth.
        truth: (usize, usize),
        /// Columns and rows of the burst.
        burst: (usize, usize),
    },
}

/// Reads a `truth.json`.
pub fn read_truth(path: &Path) -> Result<Truth, TruthError> {
    let text =
        read_text(path, MAX_TABLE_BYTES).map_err(|e| TruthError::Read { path: path.into(), reason: e.to_string() })?;
    let invalid = |reason: String| TruthError::Json { path: path.into(), reason };
    let truth: Truth = serde_json::from_str(&text).map_err(|e| invalid(e.to_string()))?;
    truth.check().map_err(invalid)?;
    Ok(truth)
}

/// The truth of a burst, if it has one: the `truth.json` in its folder or case, or that of a built-in burst.
pub fn truth_of(burst: &Burst) -> Result<Option<Truth>, TruthError> {
    let [source] = &burst.sources[..] else {
        let built_in = burst.sources.is_empty();
        let is_demo = built_in && burst.name == DEMO;
        let example = Example::named(&burst.name).filter(|_| built_in);
        return Ok(is_demo.then(demo_truth).or_else(|| example.map(Example::truth)));
    };
    let (path, truth) = if is_case(source) {
        let unread = |error: case::CaseError| TruthError::Json { path: source.clone(), reason: error.to_string() };
        (source.clone(), case::read_truth(source).map_err(unread)?)
    } else {
        let path = source.join("truth.json");
        let truth = path.is_file().then(|| read_truth(&path)).transpose()?;
        (path, truth)
    };
    let Some(truth) = truth else { return Ok(None) };
    let size = (truth.width, truth.height);
    if size != burst.size() {
        return Err(TruthError::Size { path, truth: size, burst: burst.size() });
    }
    Ok(Some(truth))
}

/// Whether a burst has a truth, without reading it.
pub fn is_known(burst: &Burst) -> bool {
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AgainstTruth {
    /// (feature, disc) for each disc found.
    pub found: Vec<(usize, usize)>,
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
        format!(
            "{} of {} found; {} missed, {} repeated, {} {}",
            self.found.len(),
            self.found.len() + self.missed.len(),
            self.missed.len(),
            self.repeated.len(),
            self.elsewhere.len(),
            self.name_of_elsewhere().to_lowercase()
        )
    }
}

/// Compares the features with `truth`.
pub fn against_truth(cache: &ProbeCache, truth: &Truth, monitor: &Monitor) -> Result<AgainstTruth, Cancelled> {
    let features = &cache.detection().features;
    let judged = judge(features, truth, Ranking::Strength);
    let mut out = AgainstTruth {
        found: Vec::new(),
        missed: Vec::new(),
        repeated: Vec::new(),
        elsewhere: Vec::new(),
        is_whole_truth: truth.kind == TruthKind::Chart,
    };
    for one in &judged {
        match one.disc {
            Some(disc) => out.found.push((one.feature, disc)),
            None if truth.features.iter().any(|disc| finds(&features[one.feature], disc)) => {
                out.repeated.push(one.feature);
            }
            None => out.elsewhere.push(one.feature),
        }
    }
    let is_found: std::collections::HashSet<usize> = out.found.iter().map(|(_, disc)| *disc).collect();
    for (index, disc) in truth.features.iter().enumerate().filter(|(index, _)| !is_found.contains(index)) {
        monitor.check()?;
        out.missed.push(miss(cache, index, disc, monitor)?);
    }
    Ok(out)
}

/// Reason why no feature found `disc`, the truth's number `index`.
pub fn miss(cache: &ProbeCache, index: usize, disc: &FeatureTruth, monitor: &Monitor) -> Result<Miss, Cancelled> {
    let (width, height) = cache.burst.size();
    let inside = disc.u >= 0.0 && disc.v >= 0.0 && disc.u <= (width - 1) as f64 && disc.v <= (height - 1) as f64;
    if !inside {
        return Ok(Miss { disc: index, fate: None, why: "it lies outside the picture at mid-burst".to_owned() });
    }
    let place = [disc.u as f32, disc.v as f32];
    let fates = fates_near(&cache.trail, place, REACH_SIGMAS, monitor)?;
    // A candidate would find it with its position, its size, and its sign (a bright disc is a negative extremum).
    let would_find =
        |fate: &&Fate| is_of_disc(fate.pos_image, fate.sigma, disc) && (fate.value < 0.0) == (disc.contrast_sign > 0);
    let best = fates.into_iter().find(|fate| would_find(&fate));
    let nothing = || "no candidate of its size stands out there at any slope".to_owned();
    let why = best.as_ref().map_or_else(nothing, |fate| fate.verdict.clone());
    Ok(Miss { disc: index, fate: best, why })
}

/// Maximum distance of the candidates that are examined, in σ.
const REACH_SIGMAS: f32 = 1.5;
