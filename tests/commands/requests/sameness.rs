//! Tests of the equality of requests: the engine computes an answer once, and the window repeats only requests that
//! differ. And of the answer to a difference of two.

use super::{answer, detected, empty, open, params, source};
use crate::support::*;
use burstscope::detector::{FrameRange, Method, NoiseGate, Rules};
use burstscope::inspect::ProbeCache;
use burstscope::requests::{
    ComparisonRequest, MatchRequest, PictureKind, PictureRequest, ProbeQuestion, ProbeRequest, ReferenceSource, Traced,
    ViewKind,
};
use std::sync::Arc;

const STILL: Slope = Slope { u: 0.0, v: 0.0 };

fn picture(kind: PictureKind, params: DetectorParams) -> PictureRequest {
    PictureRequest::new(open(), kind, params)
}

fn kinds(slope: Slope) -> [PictureKind; 7] {
    let (octave, level) = (0, 1);
    let map = |map| PictureKind::Map { map, octave, level, slope };
    let [noise, coverage, motion] = [ViewKind::Noise, ViewKind::Coverage, ViewKind::Motion].map(map);
    let dog = PictureKind::Dog { octave, level, slope };
    [PictureKind::Frame(1), PictureKind::Stack { slope }, dog, PictureKind::Merge, noise, coverage, motion]
}

#[test]
fn a_picture_is_decided_by_the_parameters_that_it_is_made_with_and_by_no_others() {
    // For each change, which kinds of picture it changes, in the order of `kinds`.
    let changes: [(&str, DetectorParams, [bool; 7]); 6] = [
        ("nothing", params(), [false; 7]),
        (
            "the noise gate",
            DetectorParams { noise_gate: NoiseGate::Strict, ..params() },
            // The maps are made from the search.
            [false, false, false, false, true, true, true],
        ),
        ("levels", DetectorParams { levels: 3, ..params() }, [false, false, true, false, true, true, true]),
        ("rules", DetectorParams { rules: Rules::LIFF, ..params() }, [false, true, true, false, true, true, true]),
        (
            "frames",
            DetectorParams { frames: Some(FrameRange { start: 0, end: 2 }), ..params() },
            [false, true, true, true, true, true, true],
        ),
        ("method", DetectorParams { method: Method::Merge, ..params() }, [false, true, true, false, true, true, true]),
    ];
    for (what, changed, differs) in changes {
        for (kind, differs) in kinds(STILL).into_iter().zip(differs) {
            let same = picture(kind, params()) == picture(kind, changed.clone());
            assert_eq!(same, !differs, "{what}: {kind:?}");
        }
    }
}

#[test]
fn a_picture_is_decided_by_its_slope_its_opening_and_as_a_difference_by_the_first() {
    let differ = [false, true, true, false, true, true, false];
    for ((still, moving), differs) in kinds(STILL).into_iter().zip(kinds(Slope::new(0.5, 0.0))).zip(differ) {
        assert_eq!(picture(still, params()) != picture(moving, params()), differs, "{still:?}");
    }
    let stack = |u| picture(PictureKind::Stack { slope: Slope::new(u, 0.0) }, params());
    assert!(stack(0.0) == stack(-0.0), "minus zero is zero");
    let stack = picture(PictureKind::Stack { slope: STILL }, params());
    assert!(stack != PictureRequest::new(empty((96, 72), 4), stack.kind, params()));
    let frame = picture(PictureKind::Frame(0), params());
    let difference = stack.clone().less(&frame);
    assert!(difference != stack && difference != frame.clone().less(&stack));
    assert!(difference.alone() == stack && difference == stack.clone().less(&frame));
    assert!(stack.clone().less(&frame.less(&stack)) == difference);
    let stack = PictureRequest::new(open(), PictureKind::Stack { slope: Slope::default() }, params());
    let frame = PictureRequest::new(open(), PictureKind::Frame(0), params());
    let difference = answer(stack.clone().less(&frame)).expect("pictures");
    let (a, b) = (answer(stack).expect("a picture"), &open().burst.frames[0]);
    let expected = |at: usize| a.plane.data()[at] - b.data()[at];
    assert!(difference.plane.data().iter().enumerate().all(|(at, x)| (x - expected(at)).abs() < 1e-6));
    // The octave's pixels are twice as large: the frame is taken at every second place.
    let dog = PictureKind::Dog { octave: 1, level: 1, slope: Slope::default() };
    let coarse = answer(PictureRequest::new(open(), dog, params()).less(&frame)).expect("pictures");
    assert_eq!(coarse.plane.size(), (48, 36));
    assert_eq!(coarse.request.minus().map(|minus| minus.kind), Some(PictureKind::Frame(0)));
}

#[test]
fn features_found_anew_trails_and_comparisons_with_another_reference_are_others() {
    let (a, b) = (detected().detection, Arc::new((*detected().detection).clone()));
    let bursts = [(open(), params()), (open(), params())];
    let request = MatchRequest { a: a.clone(), b: b.clone(), bursts, params: MatchParams::default() };
    assert!(request == request.clone() && request != MatchRequest { a: b, ..request.clone() });
    assert!(
        request != MatchRequest { params: MatchParams { ratio: 0.5, ..MatchParams::default() }, ..request.clone() }
    );
    let made = || Arc::new(source().trail(&Monitor::default()).expect("valid"));
    let ask = |cache: &Arc<ProbeCache>, near_sigma| {
        let traced = Traced { burst: open().id, cache: cache.clone() };
        ProbeRequest { traced, question: ProbeQuestion::Strongest, near_sigma, in_view: None }
    };
    let cache = made();
    assert!(ask(&cache, None) == ask(&cache, None));
    assert!(ask(&cache, None) != ask(&cache, Some(2.0)) && ask(&cache, None) != ask(&made(), None));
    let (detection, burst) = (detected().detection, open());
    let with = |with| ComparisonRequest { detection: detection.clone(), with };
    let earlier = |burst, detection| with(ReferenceSource::Earlier { burst, asked: params().into(), detection });
    let file = |path: &str| with(ReferenceSource::File { path: path.into(), features: None });
    // A request with a kept earlier result equals one whose result has to be detected again.
    assert!(earlier(burst.clone(), None) == earlier(burst.clone(), Some(detection.clone())));
    assert!(earlier(burst.clone(), None) != earlier(empty((96, 72), 4), None));
    assert!(file("a.csv") == file("a.csv") && file("a.csv") != file("b.csv"));
    let truth = |params| with(ReferenceSource::Truth { burst: burst.clone(), params });
    assert!(truth(params()) == truth(params()) && truth(params()) != truth(DetectorParams::default()));
    assert!(truth(params()) != file("a.csv"));
    let of_other = ComparisonRequest { detection: Arc::new((*detection).clone()), ..file("a.csv") };
    assert!(file("a.csv") != of_other);
}
