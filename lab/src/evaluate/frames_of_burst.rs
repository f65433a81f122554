//! Detection over the number of frames of a given burst: its middle n frames as a burst, for n = 2 … all.
//!
//! The search of all frames is the reference: a feature of fewer frames is *confirmed* when that search found it too,
//! by the rule of [`burstscope_core::inspect::result`] (its features as discs of radius √2·σ, both bright or both
//! dark). The middle n frames have a mid-burst of their own, half a frame before the whole burst's where n is odd and
//! the number of all frames even or the other way round; positions are moved there along their slopes. With a truth,
//! discs found and false features are counted as well, and with a second burst the matches between the two.

use super::ascending;
use crate::synth::{FeatureTruth, Truth, TruthKind};
use burstscope_core::burst::{Burst, Offset};
use burstscope_core::dataset::{DetectedBurst, match_bursts};
use burstscope_core::detector::{Detection, DetectorParams, Feature, FrameRange, SearchParams, SlopeGrid};
use burstscope_core::error::{Error, Result};
use burstscope_core::inspect::result::{Ranking, judge_by_discs};
use burstscope_core::matching::{MatchCounts, MatchParams};
use burstscope_core::monitor::{Monitor, Stage};
use burstscope_core::{detect::detect, detector::slopes::resolve};
use serde::Serialize;
use std::{f64::consts::SQRT_2, ops::Range};

/// Parameters of the search and matching of the bursts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BurstFramesStudy {
    /// Parameters of the search. Slopes to be found are found once, from all frames; of a range the middle ones count.
    pub search: SearchParams,
    /// Parameters of matching and verification of the features of the two bursts.
    pub matching: MatchParams,
    /// Numbers of frames, one row for each, in any order; empty for all from 2.
    pub frame_counts: Vec<usize>,
}

/// Report of a study of the middle frames of a burst.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct BurstFramesReport {
    pub burst: String,
    pub second: Option<String>,
    /// The detector's parameters with the slopes that were searched in the burst.
    pub detector: DetectorParams,
    pub second_slopes: Option<SlopeGrid>,
    /// Number of features that the search of all frames found; the orientations of one keypoint count once.
    pub features: usize,
    /// Number of known discs; absent without a truth.
    pub discs: Option<usize>,
    /// One row for each number of frames, the smallest first.
    pub rows: Vec<BurstFramesRow>,
}

/// Result of the search of the middle frames. The orientations of one keypoint count as one feature, except in matches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct BurstFramesRow {
    pub frames: usize,
    /// Index of the first of them.
    pub first_frame: usize,
    pub features: usize,
    /// Number of features that the search of all frames found too.
    pub confirmed: usize,
    pub unconfirmed: usize,
    /// Number of discs of the truth that were found; absent without a truth.
    pub discs_found: Option<usize>,
    /// Features on no disc, or on one that was already found; only where the truth is complete, as a chart's is.
    pub false_features: Option<usize>,
    /// Matches with as many middle frames of the second burst; absent where it has fewer.
    pub matches: Option<MatchCounts>,
}

struct SearchedBurst<'a> {
    burst: &'a Burst,
    params: DetectorParams,
    frames: Range<usize>,
}

impl<'a> SearchedBurst<'a> {
    fn new(burst: &'a Burst, search: &SearchParams, monitor: &Monitor) -> Result<Self> {
        let (params, _) = resolve(burst, search, monitor)?;
        params.validate_for(&burst.positions, burst.size())?;
        let frames = params.frames.map_or(0..burst.len(), |range| range.start..range.end);
        Ok(Self { burst, params, frames })
    }

    fn first_of(&self, count: usize) -> usize {
        self.frames.start + (self.frames.len() - count) / 2
    }

    /// Detection in the middle `count` frames, and the parameters with their range.
    fn middle(&self, count: usize, monitor: &Monitor) -> Result<(Detection, DetectorParams)> {
        let start = self.first_of(count);
        let frames = Some(FrameRange { start, end: start + count });
        let params = DetectorParams { frames, ..self.params.clone() };
        Ok((detect(self.burst, &params, monitor)?, params))
    }

    /// Mid-burst of `count` frames from `first` on, from that of the whole burst.
    fn mid(&self, first: usize, count: usize) -> Offset {
        self.burst.positions.offset(first) - self.burst.positions.offset_from(first..first + count, first)
    }
}

impl BurstFramesStudy {
    /// Searches the middle frames of `burst` for each number; compares with the search of all, `truth` and `second`.
    ///
    /// # Errors
    /// A parameter that makes no sense for a burst, a truth of another number of frames, or cancellation.
    pub fn run(
        &self,
        burst: &Burst,
        second: Option<&Burst>,
        truth: Option<&Truth>,
        monitor: &Monitor,
    ) -> Result<BurstFramesReport> {
        self.run_telling(burst, second, truth, monitor, &|_| {})
    }

    /// Runs the study as `run` does; calls `tell` with the report so far after every number of frames.
    pub fn run_telling(
        &self,
        burst: &Burst,
        second: Option<&Burst>,
        truth: Option<&Truth>,
        monitor: &Monitor,
        tell: &(dyn Fn(BurstFramesReport) + Sync),
    ) -> Result<BurstFramesReport> {
        self.matching.validate()?;
        if let Some(truth) = truth.filter(|truth| truth.frames != burst.len()) {
            let problem = format!("truth.json is of {} frames, but the burst has {}", truth.frames, burst.len());
            return Err(Error::param("frames", problem, "put back the frames that were taken away"));
        }
        let silent = monitor.silent();
        monitor.report(Stage::Evaluate, 0.0);
        let first = SearchedBurst::new(burst, &self.search, &silent)?;
        let second = second.map(|burst| SearchedBurst::new(burst, &self.search, &silent)).transpose()?;
        let counts = self.counts(first.frames.len())?;
        let of_second = |count: usize| second.as_ref().filter(|second| second.frames.len() >= count);
        // One search of all frames, and those of the rows.
        let frames_of = |count: usize| count * (1 + usize::from(of_second(count).is_some()));
        let total = first.frames.len() + counts.iter().map(|&count| frames_of(count)).sum::<usize>();
        let mut done = first.frames.len();
        let (all, _) = first.middle(first.frames.len(), &monitor.part(0.0, done as f32 / total as f32).silent())?;
        let mut report = BurstFramesReport {
            burst: burst.name.clone(),
            second: second.as_ref().map(|second| second.burst.name.clone()),
            second_slopes: second.as_ref().map(|second| second.params.used_slopes()),
            // Judging without discs merges the orientations of a keypoint, and so counts keypoints.
            features: judge_by_discs(&all.features, &[], Ranking::default()).len(),
            discs: truth.map(|truth| truth.features.len()),
            detector: first.params.clone(),
            rows: Vec::with_capacity(counts.len()),
        };
        for count in counts {
            monitor.report(Stage::Evaluate, done as f32 / total as f32);
            let (found, params) = first.middle(count, &silent)?;
            let matched = |second: &SearchedBurst<'_>| -> Result<MatchCounts> {
                let (other, of_other) = second.middle(count, &silent)?;
                let a = DetectedBurst { burst: first.burst, params: &params, detection: &found };
                let b = DetectedBurst { burst: second.burst, params: &of_other, detection: &other };
                Ok(match_bursts([a, b], &self.matching, &silent)?.counts)
            };
            let matches = of_second(count).map(matched).transpose()?;
            report.rows.push(row(&first, count, (&found, &all), truth, matches));
            tell(report.clone());
            done += frames_of(count);
        }
        monitor.report(Stage::Evaluate, 1.0);
        Ok(report)
    }

    fn counts(&self, frames: usize) -> Result<Vec<usize>> {
        if frames < 2 {
            let remedy = "name a burst of 2 frames or more";
            return Err(Error::param("frames", format!("{frames} is all there is"), remedy));
        }
        let counts = if self.frame_counts.is_empty() { (2..=frames).collect() } else { ascending(&self.frame_counts) };
        if let Some(count) = counts.iter().find(|count| !(2..=frames).contains(*count)) {
            let remedy = "give numbers from 2 to the number of frames of the burst";
            return Err(Error::param("frame-counts", format!("{count} of {frames} frames"), remedy));
        }
        Ok(counts)
    }
}

fn row(
    searched: &SearchedBurst<'_>,
    count: usize,
    (found, all): (&Detection, &Detection),
    truth: Option<&Truth>,
    matches: Option<MatchCounts>,
) -> BurstFramesRow {
    let first_frame = searched.first_of(count);
    let mid = searched.mid(first_frame, count);
    let later = mid - searched.mid(searched.frames.start, searched.frames.len());
    // A bright feature must not confirm a dark one at the same place.
    let confirmed = [true, false].map(|is_bright| {
        let of_side = |features: &[Feature]| -> Vec<Feature> {
            features.iter().filter(|f| (f.response < 0.0) == is_bright).copied().collect()
        };
        let reference = of_side(&all.features);
        // Each keypoint of the reference once.
        let discs: Vec<FeatureTruth> = judge_by_discs(&reference, &[], Ranking::default())
            .iter()
            .map(|judged| moved(disc_of(&reference[judged.feature]), later))
            .collect();
        let judged = judge_by_discs(&of_side(&found.features), &discs, Ranking::default());
        judged.iter().filter(|one| one.disc.is_some()).count()
    });
    let confirmed = confirmed.iter().sum::<usize>();
    let features = judge_by_discs(&found.features, &[], Ranking::default()).len();
    let counted = truth.map(|truth| {
        let discs: Vec<FeatureTruth> = truth.features.iter().map(|&disc| moved(disc, mid)).collect();
        let judged = judge_by_discs(&found.features, &discs, Ranking::default());
        // Only the truth of a chart is complete: elsewhere a feature on no disc may be real.
        let on_discs = judged.iter().filter(|one| one.disc.is_some()).count();
        (on_discs, (truth.kind == TruthKind::Chart).then(|| judged.len() - on_discs))
    });
    BurstFramesRow {
        frames: count,
        first_frame,
        features,
        confirmed,
        unconfirmed: features - confirmed,
        discs_found: counted.map(|(found, _)| found),
        false_features: counted.and_then(|(_, false_features)| false_features),
        matches,
    }
}

fn disc_of(feature: &Feature) -> FeatureTruth {
    FeatureTruth {
        u: f64::from(feature.u),
        v: f64::from(feature.v),
        radius: SQRT_2 * f64::from(feature.sigma),
        sigma: f64::from(feature.sigma),
        slope_u: f64::from(feature.slope.u),
        slope_v: f64::from(feature.slope.v),
        contrast_sign: if feature.response < 0.0 { 1 } else { -1 },
        ..FeatureTruth::default()
    }
}

/// The disc displaced along its slope by the offset `at`.
fn moved(disc: FeatureTruth, at: Offset) -> FeatureTruth {
    let (u, v) = disc.position(at);
    FeatureTruth { u, v, ..disc }
}
