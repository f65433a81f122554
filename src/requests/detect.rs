//! Opening a burst, finding its features, matching those of two, and the steps of the comparison of methods, which are
//! the last two with times that can be compared; and the command line that finds the same features.

use super::{BurstId, BurstSource, JobError, OpenBurst};
use crate::burst::OpenOptions;
use crate::dataset::{DetectedBurst, match_bursts};
use crate::detect::{self, Searched};
use crate::detector::params::doc;
use crate::detector::{Detection, DetectorParams, Method, SearchParams, SlopeAxis, SlopeFinding, Slopes};
use crate::error::Error;
use crate::files::shell_word;
use crate::inspect::ProbeCache;
use crate::inspect::slopes::{SlopeJudgement, judgement};
use crate::matching::{MatchParams, MatchResult};
use crate::monitor::Monitor;
use std::sync::Arc;

#[derive(Debug, Clone, PartialEq)]
pub struct OpenRequest {
    pub source: BurstSource,
    pub options: OpenOptions,
}

request! {
    OpenRequest => OpenBurst: |self, work| {
        self.source.open(&self.options, work.monitor)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct DetectRequest {
    pub burst: OpenBurst,
    pub params: SearchParams,
}

// Reports features of one slope of a long search, before the others are searched.
request! {
    DetectRequest => Detected; Detected: |self, work| {
        let Self { burst, params: asked } = self;
        let (trails, monitor) = (&work.caches.trails, work.monitor);
        // From cheap to dear: a kept search, one that is judged again by other thresholds, a search.
        let rejudged = || trails.rejudged(&burst, &asked, monitor).transpose();
        let cache = match trails.asked(&burst, &asked).map(Ok).or_else(rejudged).transpose()? {
            Some(kept) => kept,
            None => {
                trails.make_room();
                let earlier = trails.of_burst(&burst);
                let first = |detection| (work.tell)(Detected::of_first_slope(burst.id, &asked, detection));
                let made = Arc::new(ProbeCache::after(&earlier, &burst.burst, &asked, &first, monitor)?);
                trails.put(&burst, &made);
                made
            }
        };
        let params = cache.made_with();
        // A method on one merged frame merged all frames.
        let detection = cache.detection().clone().over(&burst.burst, &params);
        // As `params`, of the burst itself.
        let searched = DetectorParams { frames: params.frames, ..cache.trail.searched_with().clone() };
        let (finding, detection) = (cache.finding.clone(), Arc::new(detection));
        let search_secs = cache.trail.search_secs;
        let shown = if params.method == Method::Buff { Some(cache.shown(monitor)?) } else { None };
        let judgement = judgement(&detection, &params, shown, &burst.burst, monitor)?;
        Ok(Detected { burst: burst.id, asked, params, searched, search_secs, finding, detection, judgement })
    }
}

#[derive(Debug, Clone)]
pub struct Detected {
    pub burst: BurstId,
    pub asked: SearchParams,
    pub params: DetectorParams,
    /// `params`, or less strict ones: parameters that [follow](crate::detector::follows) need no search.
    pub searched: DetectorParams,
    pub search_secs: f32,
    pub finding: Option<SlopeFinding>,
    pub detection: Arc<Detection>,
    pub judgement: Option<SlopeJudgement>,
}

impl Detected {
    /// `detection` of the first slope of a search for `asked`; its parameters are those of that slope alone.
    fn of_first_slope(burst: BurstId, asked: &SearchParams, detection: Detection) -> Self {
        let params = asked.at(detection.slopes);
        let (asked, searched) = (SearchParams::from(params.clone()), params.clone());
        let (search_secs, detection) = (detection.times.total_secs(), Arc::new(detection));
        Self { burst, asked, params, searched, search_secs, finding: None, detection, judgement: None }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum CompareRequest {
    Detect(DetectRequest),
    Match(MatchRequest),
}

#[derive(Debug, Clone)]
pub enum Compared {
    Detected(BurstId, DetectorParams, Arc<Detection>),
    Matched(Matched),
}

request! {
    CompareRequest => Compared: |self, work| {
        match self {
            Self::Match(request) => request.compute(work).map(Compared::Matched),
            Self::Detect(DetectRequest { burst, params }) => {
                // Without kept searches, so that the times of methods compare.
                let Searched { detection, params, .. } = detect::search(&burst.burst, &params, work.monitor)?;
                Ok(Compared::Detected(burst.id, params, Arc::new(detection)))
            }
        }
    }
}

#[derive(Debug, Clone)]
pub struct MatchRequest {
    pub a: Arc<Detection>,
    pub b: Arc<Detection>,
    /// The bursts of A and B with the parameters of their search, whose pictures align the matches.
    pub bursts: [(OpenBurst, DetectorParams); 2],
    pub params: MatchParams,
}

request! {
    MatchRequest => Matched: |self, work| {
        Ok(self.matched(work.monitor)?)
    }
}

impl MatchRequest {
    /// The matches, computed now; errors as of [`match_bursts`].
    pub fn matched(self, monitor: &Monitor) -> Result<Matched, Error> {
        let [(burst_a, params_a), (burst_b, params_b)] = &self.bursts;
        let a = DetectedBurst { burst: &burst_a.burst, params: params_a, detection: &self.a };
        let b = DetectedBurst { burst: &burst_b.burst, params: params_b, detection: &self.b };
        let result = Arc::new(match_bursts([a, b], &self.params, monitor)?);
        Ok(Matched { request: self, result })
    }
}

#[derive(Debug, Clone)]
pub struct Matched {
    pub request: MatchRequest,
    pub result: Arc<MatchResult>,
}

const OUT: &str = "features";

/// `inputs` are paths, or names of built-in bursts. Quoted for a shell; values that are the default are left out.
pub fn detect_line(inputs: &[String], params: &SearchParams, calibration: &OpenOptions) -> String {
    let options = options(params).into_iter().chain(calibration.given());
    line("burstscope detect", inputs, &["--out", OUT], options)
}

/// The command that opens `inputs` in the window, as [`detect_line`] writes it.
pub fn window_line(inputs: &[String], calibration: &OpenOptions) -> String {
    line("burstscope", inputs, &[], calibration.given())
}

fn line(
    command: &str,
    inputs: &[String],
    then: &[&str],
    options: impl IntoIterator<Item = (String, Option<String>)>,
) -> String {
    let mut words = vec![command.to_owned()];
    // A path that begins with a dash would be read as an option.
    let path = |input: &String| if input.starts_with('-') { format!("./{input}") } else { input.clone() };
    words.extend(inputs.iter().map(|input| shell_word(&path(input))));
    words.extend(then.iter().copied().map(str::to_owned));
    for (name, value) in options {
        words.push(format!("--{name}"));
        words.extend(value.map(|value| shell_word(&value)));
    }
    words.join(" ")
}

fn options(params: &SearchParams) -> Vec<(String, Option<String>)> {
    let mut options = Vec::new();
    match params.slopes {
        Slopes::Auto { direction_deg } => {
            options.extend(direction_deg.map(|degrees| (doc::SLOPE_DIRECTION.name, degrees.to_string())));
        }
        Slopes::Given(grid) => {
            options.push((doc::SLOPES_U.name, grid.u.to_string()));
            if grid.v != SlopeAxis::ZERO {
                options.push((doc::SLOPES_V.name, grid.v.to_string()));
            }
            if grid.direction_deg != 0.0 {
                options.push((doc::SLOPE_DIRECTION.name, grid.direction_deg.to_string()));
            }
        }
    }
    // Rules imply defaults of their own: only what differs from these is written.
    let implied = SearchParams::implied_by(params.rules);
    let said = [doc::SLOPES, doc::SLOPES_U, doc::SLOPES_V, doc::SLOPE_DIRECTION];
    for record in doc::ALL.iter().filter(|record| !said.contains(record)) {
        let own = record.text(params);
        if own != record.text(&implied) {
            options.push((record.name, own));
        }
    }
    options.into_iter().map(|(name, value)| (name.to_owned(), Some(value))).collect()
}
