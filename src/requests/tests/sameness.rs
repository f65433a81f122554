//! Tests of `is_same`: the engine computes an answer once, and the window repeats only requests that differ.

use super::{detected, empty, open, params, source};
use crate::burst::OpenOptions;
use crate::detector::{DetectorParams, FrameRange, Method, NoiseGate, Rules, Slope};
use crate::inspect::candidates::SurveyOptions;
use crate::inspect::probe::Wanted;
use crate::matching::MatchParams;
use crate::monitor::Monitor;
use crate::requests::{
    AgainstRequest, CoherenceRequest, ExplainQuestion, ExplainRequest, LossesRequest, MatchRequest, NothingKept,
    PictureKind, PictureRequest, PicturesRequest, ProbeQuestion, ProbeRequest, Reference, Traced, TrailStore, ViewKind,
};
use crate::requests::{Request, Work};
use std::sync::Arc;

const STILL: Slope = Slope { u: 0.0, v: 0.0 };

fn picture(kind: PictureKind, params: DetectorParams) -> PictureRequest {
    PictureRequest::new(open(), kind, params)
}

/// Every kind of picture, at one place of the scale space.
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
            let same = picture(kind, params()).is_same(&picture(kind, changed.clone()));
            assert_eq!(same, !differs, "{what}: {kind:?}");
        }
    }
}

#[test]
fn a_picture_is_decided_by_its_slope_where_it_has_one() {
    let moved = Slope::new(0.5, 0.0);
    for ((still, moving), differs) in
        kinds(STILL).into_iter().zip(kinds(moved)).zip([false, true, true, false, true, true, false])
    {
        assert_eq!(picture(still, params()).is_same(&picture(moving, params())), !differs, "{still:?}");
    }
    let stack = |u| picture(PictureKind::Stack { slope: Slope::new(u, 0.0) }, params());
    assert!(stack(0.0).is_same(&stack(-0.0)), "minus zero is zero");
}

#[test]
fn the_pictures_of_two_openings_and_differences_are_others() {
    let stack = picture(PictureKind::Stack { slope: STILL }, params());
    let again = PictureRequest::new(empty((96, 72), 4), stack.kind, params());
    assert!(!stack.is_same(&again));
    let frame = picture(PictureKind::Frame(0), params());
    let difference = stack.clone().less(&frame);
    assert!(!difference.is_same(&stack) && !difference.is_same(&frame.clone().less(&stack)));
    assert!(difference.alone().is_same(&stack) && difference.is_same(&stack.clone().less(&frame)));
    // Of a difference that is subtracted only the first picture counts.
    assert!(stack.clone().less(&frame.less(&stack)).is_same(&difference));
    let patches = |a: &PictureRequest, b: &PictureRequest| PicturesRequest(vec![a.clone(), b.clone()]);
    assert!(patches(&stack, &difference).is_same(&patches(&stack, &difference)));
    assert!(!patches(&stack, &difference).is_same(&patches(&difference, &stack)));
}

#[test]
fn a_matching_is_of_two_detections_with_parameters() {
    let (a, b) = (detected().detection, Arc::new((*detected().detection).clone()));
    let request = MatchRequest { a: a.clone(), b: b.clone(), params: MatchParams::default() };
    assert!(request.is_same(&request.clone()));
    // Equal features found anew are another detection.
    assert!(!request.is_same(&MatchRequest { a: b.clone(), ..request.clone() }));
    let params = MatchParams { ratio: 0.5, ..MatchParams::default() };
    assert!(!request.is_same(&MatchRequest { params, ..request.clone() }));

    let result = request.clone().compute(&Work::alone(&Monitor::default())).expect("valid").result;
    let losses = |result| LossesRequest { request: request.clone(), result, size_b: (96, 72) };
    assert!(losses(result.clone()).is_same(&losses(result.clone())));
    assert!(!losses(result.clone()).is_same(&losses(Arc::new((*result).clone()))));
}

#[test]
fn a_question_is_of_one_detection() {
    let cache = NothingKept.get_or_make(&source(), &Monitor::default()).expect("valid");
    let traced = |cache| Traced { burst: open().id, cache };
    let at = |place| ProbeQuestion::At { place, wanted: Wanted::Best };
    let ask = |question| ProbeRequest { traced: traced(cache.clone()), question, near_sigma: None };
    assert!(ask(at([3.0, 4.0])).is_same(&ask(at([3.0, 4.0]))));
    assert!(!ask(at([3.0, 4.0])).is_same(&ask(at([3.0, 5.0]))));
    assert!(!ask(at([3.0, 4.0])).is_same(&ask(ProbeQuestion::Strongest)));
    let near_a_scale = ProbeRequest { near_sigma: Some(2.0), ..ask(at([3.0, 4.0])) };
    assert!(!ask(at([3.0, 4.0])).is_same(&near_a_scale));
    let anew = NothingKept.get_or_make(&source(), &Monitor::default()).expect("valid");
    let of_another = ProbeRequest { traced: traced(anew), question: ProbeQuestion::Strongest, near_sigma: None };
    assert!(!ask(ProbeQuestion::Strongest).is_same(&of_another));

    let explain = |of, question| ExplainRequest { of, question };
    let slopes = explain(source(), ExplainQuestion::Slopes);
    let candidates = ExplainQuestion::Candidates(SurveyOptions::default());
    assert!(slopes.is_same(&explain(source(), ExplainQuestion::Slopes)));
    let mut other = source();
    other.params.levels += 1;
    assert!(!slopes.is_same(&explain(other, ExplainQuestion::Slopes)));
    assert!(
        !slopes.is_same(&explain(source(), candidates))
            && explain(source(), candidates).is_same(&explain(source(), candidates))
    );

    let (detection, copy) = (detected().detection, Arc::new((*detected().detection).clone()));
    let coherence = |detection| CoherenceRequest { of: source(), detection };
    assert!(coherence(detection.clone()).is_same(&coherence(detection.clone())));
    assert!(!coherence(detection).is_same(&coherence(copy)));
}

#[test]
fn a_comparison_is_of_a_detection_with_one_reference() {
    let (detection, burst) = (detected().detection, open());
    let with = |with| AgainstRequest { detection: detection.clone(), with };
    let earlier = |burst, detection| Reference::Earlier { burst, asked: params().into(), detection };
    let file = |path: &str| Reference::File { path: path.into(), features: None };
    let truth = |params| Reference::Truth { burst: burst.clone(), params };
    // A request with a kept earlier result equals one whose result has to be detected again.
    assert!(with(earlier(burst.clone(), None)).is_same(&with(earlier(burst.clone(), Some(detection.clone())))));
    assert!(!with(earlier(burst.clone(), None)).is_same(&with(earlier(empty((96, 72), 4), None))));
    assert!(with(file("a.csv")).is_same(&with(file("a.csv"))));
    assert!(!with(file("a.csv")).is_same(&with(file("b.csv"))));
    assert!(with(truth(params())).is_same(&with(truth(params()))));
    assert!(!with(truth(params())).is_same(&with(truth(DetectorParams::default()))));
    assert!(!with(truth(params())).is_same(&with(file("a.csv"))));
    let of_other = AgainstRequest { detection: Arc::new((*detection).clone()), with: file("a.csv") };
    assert!(!with(file("a.csv")).is_same(&of_other));
}

#[test]
fn each_opening_is_a_burst_of_its_own() {
    let again = open().source.open(&OpenOptions::default(), &Monitor::default()).expect("a chart");
    assert_ne!(again.id, open().id);
    assert_eq!(again.burst.frames, open().burst.frames);
}
