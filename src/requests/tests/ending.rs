//! Tests of requests without an answer: cancelled at once, or failed with a helpful message.

use super::{detected, empty, open, params, source};
use crate::burst::OpenOptions;
use crate::detector::{DetectorParams, Slope};
use crate::matching::MatchParams;
use crate::monitor::{Monitor, Progress};
use crate::requests::{
    AgainstRequest, BurstSource, CoherenceRequest, CompareRequest, DetectRequest, ExplainQuestion, ExplainRequest,
    JobError, MatchRequest, NothingKept, OpenRequest, PictureKind, PictureRequest, PosesRequest, ProbeQuestion,
    ProbeRequest, Reference, Traced, TrailStore,
};
use crate::requests::{Request, Work};
use std::sync::{Arc, Mutex, OnceLock};

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
    let cancelled = Monitor::default();
    cancelled.cancel();
    let none = &NothingKept;
    let stack = PictureKind::Stack { slope: Slope::default() };
    let detect = DetectRequest { burst: open(), params: params().into() };
    let detection = detected().detection;
    let matching = MatchRequest { a: detection.clone(), b: detection.clone(), params: Default::default() };
    let cache = none.get_or_make(&source(), &Monitor::default()).expect("valid");
    let probe = ProbeRequest {
        traced: Traced { burst: open().id, cache },
        question: ProbeQuestion::Strongest,
        near_sigma: None,
    };
    let earlier = Reference::Earlier { burst: open(), asked: params().into(), detection: None };
    let explain = ExplainRequest { of: source(), question: ExplainQuestion::Slopes };
    let poses = PosesRequest { estimate: None, truth: None, study: Default::default() };
    let open_it = OpenRequest { source: open().source, options: OpenOptions::default() };
    let ends: [(&str, Result<(), JobError>); 10] = [
        ("open", open_it.compute(&Work::alone(&cancelled)).map(drop)),
        ("detect", detect.clone().compute(&Work::alone(&cancelled)).map(drop)),
        ("compare", CompareRequest::Detect(detect).compute(&Work::alone(&cancelled)).map(drop)),
        ("match", matching.compute(&Work::alone(&cancelled)).map(drop)),
        ("picture", PictureRequest::new(open(), stack, params()).compute(&Work::alone(&cancelled)).map(drop)),
        ("probe", probe.compute(&Work::alone(&cancelled)).map(drop)),
        ("explain", explain.compute(&Work::alone(&cancelled)).map(drop)),
        (
            "coherence",
            CoherenceRequest { of: source(), detection: detection.clone() }.compute(&Work::alone(&cancelled)).map(drop),
        ),
        ("against", AgainstRequest { detection, with: earlier }.compute(&Work::alone(&cancelled)).map(drop)),
        ("poses", poses.compute(&Work::alone(&cancelled)).map(drop)),
    ];
    for (what, end) in ends {
        assert_eq!(end, Err(JobError::Cancelled), "{what}");
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

#[test]
fn what_is_cancelled_on_its_way_ends_long_before_it_would_have_been_done() {
    for at in [0.0, 0.3, 0.6] {
        let (monitor, heard) = cancelling(at);
        let request = ExplainRequest { of: source(), question: ExplainQuestion::Slopes };
        assert_eq!(request.compute(&Work::alone(&monitor)).map(drop), Err(JobError::Cancelled), "cancelled at {at}");
        let max = heard.lock().expect("no panic").iter().copied().fold(0.0, f32::max);
        assert!(max < at + 0.3, "cancelled at {at}, still working at {max}");
    }
}

#[test]
fn failures_say_what_is_wrong() {
    let monitor = Monitor::default();
    let frame = PictureRequest::new(open(), PictureKind::Frame(4), params());
    assert_eq!(why(frame.compute(&Work::alone(&monitor))), "there is no frame 4; the burst has 4 frames");
    let detect = |params: DetectorParams| DetectRequest { burst: open(), params: params.into() };
    let wrong = DetectorParams { levels: 0, ..params() };
    assert!(why(detect(wrong.clone()).compute(&Work::alone(&monitor))).contains("levels"));
    assert!(why(CompareRequest::Detect(detect(wrong)).compute(&Work::alone(&monitor))).contains("levels"));
    let detection = detected().detection;
    let wrong = MatchParams { ratio: -1.0, ..MatchParams::default() };
    let matching = MatchRequest { a: detection.clone(), b: detection.clone(), params: wrong };
    assert!(why(matching.compute(&Work::alone(&monitor))).contains("ratio"));
    let against = |with| AgainstRequest { detection: detection.clone(), with }.compute(&Work::alone(&monitor));
    assert!(why(against(Reference::File { path: "gone.csv".into(), features: None })).contains("gone.csv"));
    let unknown = Reference::Truth { burst: empty((32, 32), 3), params: params() };
    assert!(why(against(unknown)).contains("nothing is known"));
}

#[test]
fn in_a_burst_without_anything_there_is_no_strongest_candidate() {
    let burst = empty((32, 32), 3);
    let of = crate::requests::DetectionSource { burst, ..source() };
    let cache = NothingKept.get_or_make(&of, &Monitor::default()).expect("valid");
    let request = ProbeRequest {
        traced: Traced { burst: of.burst.id, cache },
        question: ProbeQuestion::Strongest,
        near_sigma: None,
    };
    assert!(why(request.compute(&Work::alone(&Monitor::default()))).contains("nothing in this burst is an extremum"));
}

#[test]
fn several_bursts_are_offered_and_a_missing_one_is_named() {
    let home = tempfile::tempdir().expect("a folder");
    for (name, seed) in [("a", 1), ("b", 2)] {
        super::write_chart(&home.path().join(name), seed);
    }
    let open = |path| BurstSource::Paths(vec![path]).open(&OpenOptions::default(), &Monitor::default()).map(drop);
    let Err(JobError::Several(found)) = open(home.path().to_path_buf()) else { panic!("there are two") };
    assert_eq!(found.iter().map(BurstSource::label).collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(JobError::Several(found).to_string(), "there are 2 bursts here; open one of them");
    assert!(why(open(home.path().join("gone"))).contains("gone"));
}
