//! The workers of the probe: one answers questions about places from what a detection left behind, the latest first;
//! the other repeats a detection of which that was not kept (see [`super::trails`]).

use super::jobs::{JobAnswer, Jobs};
use super::picture_jobs::PICTURE_GRACE;
use super::queue::{JobQueue, Priority};
use super::trails::Trails;
use crate::monitor::Monitor;
use crate::requests::{DetectionSource, JobError, ProbeRequest, Probed, Running, Traced, TrailStore};
use std::sync::Arc;
use std::time::Duration;

/// The workers.
pub struct ProbeWorker {
    trails: Trails,
    traces: Jobs<DetectionSource, Traced>,
    places: Jobs<ProbeRequest, Probed>,
}

impl ProbeWorker {
    pub(super) fn new(queue: &Arc<JobQueue>, trails: &Trails) -> Self {
        let its = trails.clone();
        let trace = move |source: DetectionSource, monitor: &Monitor| {
            let cache = its.get_or_make(&source, monitor)?;
            Ok(Traced { burst: source.burst.id, cache })
        };
        Self {
            trails: trails.clone(),
            traces: Jobs::new(queue, Priority::Search, Duration::ZERO, trace),
            places: Jobs::new(queue, Priority::Picture, PICTURE_GRACE, ProbeRequest::compute),
        }
    }

    /// What a detection left behind, if it is kept.
    pub fn kept(&self, source: &DetectionSource) -> Option<Traced> {
        Some(Traced { burst: source.burst.id, cache: self.trails.get(source)? })
    }

    /// Repeats a detection of which nothing is kept.
    pub fn trace(&self, source: DetectionSource) {
        self.traces.submit(source);
    }

    /// Asks about a place; what was asked before and is not answered yet is superseded.
    pub fn ask(&self, request: ProbeRequest) {
        self.places.submit(request);
    }

    /// Stops both workers.
    pub fn cancel(&self) {
        self.traces.cancel();
        self.places.cancel();
    }

    /// The trail that was made since the last call, or why there is none. Never waits.
    pub fn poll_trail(&self) -> Option<Result<Traced, JobError>> {
        self.traces.take_answers().filter(|answer| !answer.is_superseded()).last().map(|answer| answer.result)
    }

    /// The answer that came since the last call.
    pub fn poll_answer(&self) -> Option<JobAnswer<Probed>> {
        self.places.take_answers().filter(|answer| !answer.is_superseded()).last()
    }

    /// How far the trail is, while one is made.
    pub fn tracing(&self) -> Option<Running> {
        self.traces.running()
    }

    /// Whether a question is being answered, and since when.
    pub fn probing(&self) -> Option<Running> {
        self.places.running()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::{DetectorParams, SlopeGrid};
    use crate::engine::tests::wait_for;
    use crate::engine::{DEFAULT_CACHE_BYTES, Engine};
    use crate::inspect::probe::Wanted;
    use crate::requests::{BurstSource, OpenBurst, ProbeQuestion};

    fn source() -> DetectionSource {
        let example = crate::synth::Example::LowContrast;
        let burst = OpenBurst::new(example.burst(), BurstSource::Example(example));
        let slopes = SlopeGrid::line(-2.0..=2.0, 5);
        let params = DetectorParams { slopes, octaves: 2, ..DetectorParams::default() };
        DetectionSource { burst, asked: params.clone().into(), params, finding: None }
    }

    #[test]
    fn the_latest_place_is_answered_and_the_strongest_candidate_is_found() {
        let (engine, source) = (Engine::new(Arc::new(|| {}), DEFAULT_CACHE_BYTES), source());
        assert!(engine.probe().kept(&source).is_none());
        engine.probe().trace(source.clone());
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
        assert_eq!(last.request.traced.burst, source.burst.id);
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
