//! The workers of the probe: one makes the trail of a detection that was made without one, the other answers questions
//! about places from a trail, the latest first.
//!
//! A trail costs as much as the detection that it explains, so it is made once for a burst and its parameters. While a
//! person probes, the detection itself is made with its trail ([`super::Engine::detect_with_trail`]).

use super::jobs::{JobAnswer, Jobs};
use super::picture::job_error;
use super::picture_jobs::PICTURE_GRACE;
use super::queue::{JobQueue, Priority};
use super::source::BurstId;
use super::{DetectRequest, Detected, JobError, Running, detect_now};
use crate::detector::DetectorParams;
use crate::inspect::candidates::{CandidateMark, SurveyOptions, survey};
use crate::inspect::probe::Wanted;
use crate::inspect::{Probe, ProbeCache, ProbeError, ProbeOptions, probe};
use crate::monitor::Monitor;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A detection of a burst with all that it left behind.
#[derive(Debug, Clone)]
pub struct Traced {
    /// The burst.
    pub burst: BurstId,
    /// Its detection, with its trail.
    pub cache: Arc<ProbeCache>,
}

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProbeQuestion {
    /// What happened at a place.
    At {
        /// (u, v) at mid-burst, input pixels.
        place: [f32; 2],
        /// What is looked at more closely.
        wanted: Wanted,
    },
    /// What happened to the strongest candidate of the whole picture, kept or not.
    Strongest,
}

/// A question about a detection.
#[derive(Debug, Clone)]
pub struct ProbeRequest {
    /// What it is asked of.
    pub traced: Traced,
    /// What is asked.
    pub question: ProbeQuestion,
}

impl ProbeRequest {
    /// Whether both ask the same of the same detection.
    pub fn same_answer(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.traced.cache, &other.traced.cache) && self.question == other.question
    }
}

/// An answer with what was asked.
#[derive(Debug, Clone)]
pub struct Probed {
    /// What was asked.
    pub request: ProbeRequest,
    /// What is known of the place.
    pub probe: Arc<Probe>,
}

/// Whether a detection keeps its trail.
pub(super) type KeepTrail = bool;
/// The slot into which a detection puts its trail.
type Kept = Arc<Mutex<Option<Traced>>>;

/// The workers.
pub struct ProbeWorker {
    trails: Jobs<DetectRequest, Traced>,
    places: Jobs<ProbeRequest, Probed>,
    kept: Kept,
}

impl ProbeWorker {
    pub(super) fn new(queue: &Arc<JobQueue>) -> Self {
        Self {
            trails: Jobs::new(queue, Priority::Search, Duration::ZERO, traced),
            places: Jobs::new(queue, Priority::Picture, PICTURE_GRACE, probed),
            kept: Kept::default(),
        }
    }

    /// Work that finds features, and gives their trails to these workers where they are to be kept.
    pub(super) fn detect_jobs(&self, queue: &Arc<JobQueue>) -> Jobs<(DetectRequest, KeepTrail), Detected> {
        let kept = self.kept.clone();
        Jobs::new(queue, Priority::Search, Duration::ZERO, move |(request, keep), monitor: &Monitor| {
            if keep { detect_and_keep(request, &kept, monitor) } else { detect_now(request, monitor) }
        })
    }

    /// Repeats a detection, to keep its trail.
    pub fn trace(&self, request: DetectRequest) {
        self.trails.submit(request);
    }

    /// Asks about a place; what was asked before and is not answered yet is superseded.
    pub fn ask(&self, request: ProbeRequest) {
        self.places.submit(request);
    }

    /// Stops both workers.
    pub fn cancel(&self) {
        self.trails.cancel();
        self.places.cancel();
    }

    /// The trail that was made since the last call, or why there is none. Never waits.
    pub fn poll_trail(&self) -> Option<Result<Traced, JobError>> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner).take();
        let made = self.trails.take_answers().filter(|answer| !answer.is_superseded()).last();
        kept.map(Ok).or_else(|| made.map(|answer| answer.result))
    }

    /// The answer that came since the last call.
    pub fn poll_answer(&self) -> Option<JobAnswer<Probed>> {
        self.places.take_answers().filter(|answer| !answer.is_superseded()).last()
    }

    /// How far the trail is, while one is made.
    pub fn tracing(&self) -> Option<Running> {
        self.trails.running()
    }

    /// Whether a question is being answered, and since when.
    pub fn probing(&self) -> Option<Running> {
        self.places.running()
    }
}

/// Detects, keeps the trail in `kept`, and answers as a detection without one does.
fn detect_and_keep(request: DetectRequest, kept: &Kept, monitor: &Monitor) -> Result<Detected, JobError> {
    let burst = request.burst.clone();
    let traced = traced(request, monitor)?;
    let cache = &traced.cache;
    let asked = cache.asked.clone();
    // A method that searches one merged frame of its own is asked for all frames all the same.
    let params = DetectorParams { frames: asked.detector.frames, ..cache.params().clone() };
    let mut detection = cache.detection().clone();
    detection.frames_used = params.used_frames(burst.burst.len());
    let finding = cache.finding.clone();
    *kept.lock().unwrap_or_else(PoisonError::into_inner) = Some(traced);
    Ok(Detected { burst: burst.id, asked, params, finding, detection: Arc::new(detection) })
}

fn traced(request: DetectRequest, monitor: &Monitor) -> Result<Traced, JobError> {
    let DetectRequest { burst, params } = request;
    let cache = ProbeCache::new(&burst.burst, &params, monitor).map_err(job_error)?;
    Ok(Traced { burst: burst.id, cache: Arc::new(cache) })
}

fn probed(request: ProbeRequest, monitor: &Monitor) -> Result<Probed, JobError> {
    let cache = &request.traced.cache;
    let (place, wanted) = match request.question {
        ProbeQuestion::At { place, wanted } => (place, wanted),
        ProbeQuestion::Strongest => {
            let mark = strongest(cache, monitor)?;
            (mark.pos_image, Wanted::Candidate(mark.of_sample()))
        }
    };
    let probe =
        probe(cache, place, &ProbeOptions { wanted, ..ProbeOptions::default() }, monitor).map_err(
            |error| match error {
                ProbeError::Cancelled(_) => JobError::Cancelled,
                other => JobError::Failed(other.to_string()),
            },
        )?;
    Ok(Probed { request, probe: Arc::new(probe) })
}

/// The candidate with the largest |D| over its noise; in a burst without noise with the largest |D|.
fn strongest(cache: &ProbeCache, monitor: &Monitor) -> Result<CandidateMark, JobError> {
    let strength = |mark: &CandidateMark| if mark.snr.is_finite() { mark.snr } else { mark.value.abs() };
    for min_snr in [SurveyOptions::default().min_snr, 0.0] {
        let marks = survey(&cache.trail, &SurveyOptions { min_snr, test: None }, monitor)?.marks;
        if let Some(mark) = marks.into_iter().max_by(|a, b| strength(a).total_cmp(&strength(b))) {
            return Ok(mark);
        }
    }
    Err(JobError::Failed("nothing in this burst is an extremum at any slope and scale".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::search;
    use crate::detector::{Method, SearchParams, SlopeGrid};
    use crate::engine::{DEFAULT_CACHE_BYTES, Engine, OpenBurst, Update};
    use std::time::Instant;

    fn wait_for<T>(mut poll: impl FnMut() -> Option<T>) -> T {
        let end = Instant::now() + Duration::from_secs(60);
        loop {
            if let Some(found) = poll() {
                return found;
            }
            assert!(Instant::now() < end, "nothing happened");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn burst() -> OpenBurst {
        let example = crate::synth::Example::LowContrast;
        OpenBurst::new(example.burst(), super::super::BurstSource::Example(example))
    }

    fn params(method: Method) -> SearchParams {
        let slopes = SlopeGrid::line(-2.0..=2.0, 5);
        DetectorParams { method, slopes, octaves: 2, ..DetectorParams::default() }.into()
    }

    #[test]
    fn a_detection_with_its_trail_is_that_without_one() {
        let (engine, burst) = (Engine::new(Arc::new(|| {}), DEFAULT_CACHE_BYTES), burst());
        for method in [Method::Buff, Method::Merge] {
            let params = params(method);
            engine.detect_with_trail(DetectRequest { burst: burst.clone(), params: params.clone() });
            let detected = wait_for(|| {
                engine.poll().into_iter().find_map(|update| match update {
                    Update::Detected(answer) => Some(answer.result.expect("valid")),
                    _ => None,
                })
            });
            let expected = search(&burst.burst, &params, &Monitor::default()).expect("valid");
            assert_eq!(detected.detection.features, expected.detection.features);
            assert_eq!(detected.detection.frames_used, expected.detection.frames_used);
            assert_eq!((&detected.params, &detected.asked), (&expected.params, &params));
            let traced = engine.probe().poll_trail().expect("kept").expect("valid");
            assert_eq!((traced.burst, &traced.cache.asked), (burst.id, &params));
        }
    }

    #[test]
    fn the_latest_place_is_answered_and_the_strongest_candidate_is_found() {
        let (engine, burst) = (Engine::new(Arc::new(|| {}), DEFAULT_CACHE_BYTES), burst());
        engine.probe().trace(DetectRequest { burst: burst.clone(), params: params(Method::Buff) });
        let traced = wait_for(|| engine.probe().poll_trail()).expect("valid");
        let ask = |question| {
            engine.probe().ask(ProbeRequest { traced: traced.clone(), question });
        };
        for u in 0..20 {
            ask(ProbeQuestion::At { place: [u as f32, 60.0], wanted: Wanted::Best });
        }
        let last = wait_for(|| {
            let answer = engine.probe().poll_answer()?.result.expect("inside");
            (answer.probe.pos_image == [19.0, 60.0]).then_some(answer)
        });
        assert_eq!(last.request.traced.burst, burst.id);
        ask(ProbeQuestion::At { place: [-50.0, 60.0], wanted: Wanted::Best });
        let error = wait_for(|| engine.probe().poll_answer()).result.expect_err("outside");
        assert!(error.to_string().contains("outside"), "{error}");
        ask(ProbeQuestion::Strongest);
        let strongest = wait_for(|| engine.probe().poll_answer()).result.expect("there is one");
        // The brightest disc.
        let [u, v] = strongest.probe.pos_image;
        assert!((u - 40.0).hypot(v - 60.0) < 4.0, "{u} {v}");
        let fate = strongest.probe.subject_fate().expect("a candidate");
        assert!(fate.is_kept() && fate.snr > 5.0, "{fate:?}");
    }
}
