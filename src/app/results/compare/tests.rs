//! Tests of the comparison: missing steps are done in order and once, only current results count, and failed steps are
//! not repeated with the same input.

use crate::app::document::method::CompareLook;
use crate::app::results::compare::*;
use crate::app::results::pair::tests::pair;
use crate::app::results::tests::open;
use crate::teach::Workspace;

fn methods() -> Model {
    let mut model = pair();
    model.document.workspace = Workspace::Methods;
    model
}

fn do_all(model: &mut Model) -> Vec<(MethodId, Side)> {
    let mut done = Vec::new();
    while let Some(CompareJob { method, side, request, .. }) = model.next_compare_job() {
        match request {
            CompareRequest::Detect(request) => {
                let detection = model.found_of(side).expect("found").detection.clone();
                let (burst, params) = (request.burst.id, request.params.detector);
                let found = MethodFound { burst, params, detection, elapsed: Duration::ZERO };
                model.results.compare.take_found(method, side, found);
            }
            CompareRequest::Match(request) => {
                let matched = request.matched(&crate::monitor::Monitor::default()).expect("valid");
                model.results.compare.take_matches(method, Matches::new(matched, Duration::ZERO));
            }
        }
        done.push((method, side));
        assert!(done.len() < 50, "it never ends: {done:?}");
    }
    done
}

#[test]
fn each_method_runs_once_on_a_then_on_b_and_is_matched() {
    let mut model = methods();
    let done = do_all(&mut model);
    let on_a: Vec<MethodId> = done.iter().filter(|(_, side)| *side == Side::A).map(|(method, _)| *method).collect();
    assert_eq!(on_a, [MethodId::Sift, MethodId::Merge, MethodId::Buff1d, MethodId::Buff2d]);
    assert!(done[..4].iter().all(|(_, side)| *side == Side::A), "all of A first: {done:?}");
    assert_eq!(done.len(), 12, "on A, on B, and matched");
    assert!(model.method_matches(MethodId::Buff1d).is_some());
    assert!(model.next_compare_job().is_none());
}

#[test]
fn a_changed_parameter_makes_what_was_found_old() {
    let mut model = methods();
    do_all(&mut model);
    model.document.matching.ratio = 0.7;
    let again = do_all(&mut model);
    assert_eq!(again.len(), 4, "only the matches are made again: {again:?}");
    model.document.params.slopes = crate::detector::SlopeGrid::line(-3.0..=3.0, 9);
    let again = do_all(&mut model);
    assert!(again.iter().any(|(method, _)| *method == MethodId::Buff2d), "{again:?}");
    model.take_burst(open((64, 48), 5));
    assert!(model.method_found(MethodId::Sift, Side::A).is_none());
}

#[test]
fn what_is_hidden_is_not_done_and_gold_needs_its_image() {
    let mut model = methods();
    model.document.methods.show(MethodId::Buff2d, false);
    model.document.methods.show(MethodId::Merge, false);
    assert_eq!(model.methods_shown(), [MethodId::Sift, MethodId::Buff1d]);
    model.results.compare.gold.a = Some(open((64, 48), 1));
    assert_eq!(model.methods_shown().last(), Some(&MethodId::Gold));
    let done = do_all(&mut model);
    assert!(done.contains(&(MethodId::Gold, Side::A)) && !done.contains(&(MethodId::Gold, Side::B)));
    model.take_burst(open((64, 48), 5));
    assert_eq!(model.methods_shown(), [MethodId::Sift, MethodId::Buff1d], "it was of the other burst's view");
}

#[test]
fn what_failed_is_not_tried_again_until_asked_or_changed() {
    let mut model = methods();
    let job = model.next_compare_job().expect("nothing is there yet");
    model.results.compare.take_failure(job.clone(), "cancelled".into());
    assert_eq!(model.results.compare.problem(job.method), Some("cancelled"));
    assert_ne!(model.next_compare_job().map(|next| next.method), Some(job.method));
    model.results.compare.forget_failures();
    assert_eq!(model.next_compare_job().map(|next| next.method), Some(job.method));
    model.results.compare.take_failure(job.clone(), "cancelled".into());
    model.document.params.edge_threshold *= 2.0;
    assert_eq!(model.next_compare_job().map(|next| next.method), Some(job.method));
}

#[test]
fn what_other_rooms_found_is_shared() {
    let mut model = methods();
    model.share_what_is_found();
    let shared = model.method_found(MethodId::Buff1d, Side::A).expect("the window searches one line of slopes");
    assert!(Arc::ptr_eq(&shared.detection, &model.found_of(Side::A).expect("found").detection));
    assert!(model.method_found(MethodId::Sift, Side::A).is_none());
}

#[test]
fn the_look_from_a_file_makes_sense() {
    let methods = vec![MethodId::Gold, MethodId::Sift, MethodId::Gold];
    let look = CompareLook { methods, ..CompareLook::default() }.sanitised();
    assert_eq!(look.methods, [MethodId::Sift, MethodId::Gold]);
}
