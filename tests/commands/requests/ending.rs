//! Tests of requests without an answer: cancelled at once, or failed with a helpful message.

use super::{answer, detected, empty, open, params, source};
use crate::support::*;
use burstscope::detector::Detection;
use burstscope::inspect::ProbeCache;
use burstscope::monitor::Progress;
use burstscope::requests::{
    BurstId, CoherenceRequest, CompareRequest, ComparisonRequest, DetectionSource, ExplainQuestion, ExplainRequest,
    MatchRequest, OpenRequest, PictureKind, PictureRequest, PosesRequest, ProbeQuestion, ProbeRequest, ReferenceSource,
    Traced,
};
use std::sync::Arc;

#[track_caller]
fn why<T>(result: Result<T, JobError>) -> String {
    match result {
        Err(JobError::Failed(why)) => why,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("it has an answer"),
    }
}

#[test]
fn what_was_cancelled_before_it_began_has_no_answer() {
    fn end<R: Request>(request: R) -> Option<JobError> {
        let cancelled = Monitor::default();
        cancelled.cancel();
        request.compute(&Work::alone(&cancelled)).err()
    }
    let detect = DetectRequest { burst: open(), params: params().into() };
    let detection = detected().detection;
    let earlier = ReferenceSource::Earlier { burst: open(), asked: params().into(), detection: None };
    let cache = Arc::new(source().trail(&Monitor::default()).expect("valid"));
    let stack = PictureKind::Stack { slope: Slope::default() };
    let ends = [
        end(OpenRequest { source: open().source, options: OpenOptions::default() }),
        end(detect.clone()),
        end(CompareRequest::Detect(detect)),
        end(PictureRequest::new(open(), stack, params())),
        end(probe(open().id, cache)),
        end(CoherenceRequest { of: source(), detection: detection.clone() }),
        end(ComparisonRequest { detection, with: earlier }),
        end(PosesRequest { sources: Default::default(), study: Default::default() }),
    ];
    assert!(ends.iter().all(|end| *end == Some(JobError::Cancelled)), "{ends:?}");
}

fn probe(burst: BurstId, cache: Arc<ProbeCache>) -> ProbeRequest {
    ProbeRequest {
        traced: Traced { burst, cache },
        question: ProbeQuestion::Strongest,
        near_sigma: None,
        in_view: None,
    }
}

/// A monitor that is cancelled at the first report of `at` or more, and what is reported after that.
fn cancelling(at: f32) -> (Monitor, Arc<Mutex<Vec<f32>>>) {
    let (heard, own): (Arc<Mutex<Vec<f32>>>, Arc<OnceLock<Monitor>>) = Default::default();
    let (later, inner) = (heard.clone(), own.clone());
    let monitor = Monitor::with_listener(move |progress: Progress| {
        let monitor = inner.get().expect("it is set before the work begins");
        if monitor.is_cancelled() {
            later.lock().expect("no panic").push(progress.fraction);
        } else if progress.fraction >= at {
            monitor.cancel();
        }
    });
    own.set(monitor.clone()).expect("set once");
    (monitor, heard)
}

fn bursts() -> [(OpenBurst, DetectorParams); 2] {
    [(open(), params()), (open(), params())]
}

#[test]
fn what_is_cancelled_on_its_way_ends_long_before_it_would_have_been_done() {
    fn ends<R: Request>(request: &R, at: f32) {
        let (monitor, heard) = cancelling(at);
        let end = request.clone().compute(&Work::alone(&monitor)).map(drop);
        assert_eq!(end, Err(JobError::Cancelled), "cancelled at {at}");
        let max = heard.lock().expect("no panic").iter().copied().fold(0.0, f32::max);
        assert!(max < at + 0.3, "cancelled at {at}, still working at {max}");
    }
    let mut many = Detection::clone(&detected().detection);
    (many.features, many.descriptors) = (many.features.repeat(1000), many.descriptors.repeat(1000));
    let (a, b) = (Arc::new(many.clone()), Arc::new(many));
    for at in [0.0, 0.3, 0.6] {
        ends(&ExplainRequest { of: source(), question: ExplainQuestion::Slopes }, at);
    }
    ends(&MatchRequest { a, b, bursts: bursts(), params: MatchParams::default() }, 0.0);
}

#[test]
fn failures_say_what_is_wrong_and_the_time_left_follows_from_what_is_done() {
    let frame = PictureRequest::new(open(), PictureKind::Frame(4), params());
    assert_eq!(why(answer(frame)), "there is no frame 4; the burst has 4 frames");
    let wrong = DetectRequest { burst: open(), params: DetectorParams { levels: 0, ..params() }.into() };
    assert!(why(answer(wrong)).contains("levels"));
    let detection = detected().detection;
    let wrong = MatchParams { ratio: -1.0, ..MatchParams::default() };
    assert!(
        why(answer(MatchRequest { a: detection.clone(), b: detection.clone(), bursts: bursts(), params: wrong }))
            .contains("ratio")
    );
    let against = |with| answer(ComparisonRequest { detection: detection.clone(), with });
    assert!(why(against(ReferenceSource::File { path: "gone.csv".into(), features: None })).contains("gone.csv"));
    let unknown = ReferenceSource::Truth { burst: empty((32, 32), 3), params: params() };
    assert!(why(against(unknown)).contains("nothing is known"));
    let of = DetectionSource { burst: empty((32, 32), 3), ..source() };
    let cache = Arc::new(of.trail(&Monitor::default()).expect("valid"));
    assert!(why(answer(probe(of.burst.id, cache))).contains("nothing in this burst is an extremum"));
    let left = |millis, fraction| burstscope::requests::time_left(Duration::from_millis(millis), fraction);
    assert_eq!(left(10_000, 0.5), Some(Duration::from_secs(10)));
    assert_eq!(left(1_000, 0.25), Some(Duration::from_secs(3)));
    assert_eq!(left(10_000, 0.01), None, "too early to say");
    assert_eq!(left(400, 0.5), None, "too short to say");
    assert_eq!(left(10_000, 1.0), None, "it is done");
}
