//! The front door of the library: every detection of a burst goes through here.
//!
//! [`detect`] runs the detector by any [`Method`], and [`search`] first finds the slopes where none are given.
//! [`prepare`] is the part of a method before the search: for the merge it makes one frame of the burst.

use crate::baseline::merge_burst;
use crate::burst::{Burst, Info, OpenOptions};
use crate::detector::slopes::resolve;
use crate::detector::{Detection, DetectorParams, Method, SearchParams, SlopeFinding, SlopeVerdict, memory, pipeline};
use crate::error::Result;
use crate::monitor::Monitor;
use std::path::PathBuf;
use std::time::Instant;

/// Finds the features of a burst by the method that `params` ask for, at the slopes that they give.
///
/// ```
/// use burstscope_core::{DetectorParams, Monitor, SlopeGrid, detect, synth::demo_burst};
/// let params = DetectorParams { slopes: SlopeGrid::line(-2.0..=1.0, 7), ..DetectorParams::default() };
/// let detection = detect(&demo_burst(), &params, &Monitor::default())?;
/// assert_eq!(detection.features.len(), detection.descriptors.len());
/// # Ok::<(), burstscope_core::Error>(())
/// ```
///
/// # Errors
/// Parameters that make no sense for the burst, and cancellation once `monitor` was cancelled.
pub fn detect(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Detection> {
    Ok(search(burst, &params.clone().into(), monitor)?.detection)
}

/// Features of a burst, with the slopes that were searched: the result of [`search`].
#[derive(Debug, Clone)]
pub struct Searched {
    /// Features, descriptors, and the data that the search used.
    pub detection: Detection,
    /// Requested parameters with the searched slopes.
    pub params: DetectorParams,
    /// Finding of the slopes, if they were to be found.
    pub finding: Option<SlopeFinding>,
    /// Seconds taken to find the slopes; 0 where they were given.
    pub slopes_secs: f32,
}

/// Finds the slopes of a burst if they are to be found, and then its features: for bursts of unknown motion.
///
/// ```
/// use burstscope_core::{Monitor, detect::search, detector::SearchParams, synth::demo_burst};
/// let found = search(&demo_burst(), &SearchParams::default(), &Monitor::default())?;
/// assert_eq!(found.finding.map(|finding| finding.grid), Some(found.params.slopes));
/// # Ok::<(), burstscope_core::Error>(())
/// ```
pub fn search(burst: &Burst, params: &SearchParams, monitor: &Monitor) -> Result<Searched> {
    let mut search = PreparedSearch::new(burst, params, monitor)?;
    let mut detection = pipeline::search(&search.burst, &search.params, &search.rest)?;
    while search.is_widened(&detection)? {
        detection = pipeline::search(&search.burst, &search.params, &search.rest)?;
    }
    let PreparedSearch { asked, finding, slopes_secs, .. } = search;
    Ok(Searched { detection: detection.over(burst, &asked), params: asked, finding, slopes_secs })
}

/// Share of a search's progress that finding the slopes takes.
const SLOPES_SHARE: f32 = 0.2;

const MOST_WIDENED: usize = 2;

/// Search whose slopes are found and whose frames are merged, as its parameters request.
pub(crate) struct PreparedSearch {
    pub burst: Burst,
    pub params: DetectorParams,
    /// The requested parameters, with the slopes that are searched.
    asked: DetectorParams,
    pub finding: Option<SlopeFinding>,
    slopes_secs: f32,
    /// Monitor of the steps after finding the slopes.
    pub rest: Monitor,
    widened: usize,
}

impl PreparedSearch {
    pub fn new(burst: &Burst, params: &SearchParams, monitor: &Monitor) -> Result<Self> {
        let started = Instant::now();
        let (asked, finding) = resolve(burst, params, &monitor.part(0.0, SLOPES_SHARE))?;
        let share = if finding.is_some() { SLOPES_SHARE } else { 0.0 };
        let slopes_secs = if finding.is_some() { started.elapsed().as_secs_f32() } else { 0.0 };
        let rest = monitor.part(share, 1.0 - share);
        let (burst, params) = prepare(burst, &asked, &rest)?;
        Ok(Self { burst, params, asked, finding, slopes_secs, rest, widened: 0 })
    }

    /// Widens the slopes found where features and field of motion of `detection` show that a part of the picture moves
    /// beyond them, such as a floor that comes near; true if the search has to be made once more.
    pub fn is_widened(&mut self, detection: &Detection) -> Result<bool> {
        let Some(finding) = self.finding.as_mut().filter(|finding| finding.verdict == SlopeVerdict::Found) else {
            return Ok(false);
        };
        // Without confirmed evidence, or after several turns, noise would lead on and on.
        let seen = !finding.confirmed(&self.params, &self.burst.positions).is_empty();
        let field = detection.field.as_ref().filter(|_| seen && self.widened < MOST_WIDENED);
        let beyond = field.and_then(|field| field.beyond(&finding.grid, Some(&detection.features)));
        let Some(beyond) = beyond else { return Ok(false) };
        if !beyond.is_held(None, &self.burst, detection.frames_used.clone(), &self.rest)? {
            return Ok(false);
        }
        self.widened += 1;
        finding.grid = beyond.grid;
        (self.params.slopes, self.asked.slopes) = (beyond.grid, beyond.grid);
        let used = self.burst.positions.part(detection.frames_used.clone());
        finding.confidence = finding.agreement(&beyond.grid, &self.params, &used);
        Ok(true)
    }
}

/// Checks, before the burst that `inputs` name is opened, that there is memory for its search; the error gives the
/// least need and changes that lower it. A file that cannot be read passes: opening it reports the error.
pub fn check_memory(inputs: &[PathBuf], options: &OpenOptions, params: &SearchParams, monitor: &Monitor) -> Result<()> {
    match Info::of(inputs, options, &monitor.silent()) {
        Ok(info) => memory::check_before_opening(params, info.frames, (info.width, info.height)),
        Err(_) => Ok(()),
    }
}

/// Burst to search and its parameters: for [`Method::Merge`] one merged frame, otherwise the given ones unchanged.
///
/// # Errors
/// As [`detect`].
pub fn prepare(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<(Burst, DetectorParams)> {
    params.validate_for(&burst.positions, burst.size())?;
    match params.method {
        Method::Buff | Method::Sift => Ok((burst.clone(), params.clone())),
        Method::Merge => {
            let merged = merge_burst(burst, params.used_frames(burst.len()), monitor)?;
            Ok((merged, DetectorParams { frames: None, ..params.clone() }))
        }
    }
}
