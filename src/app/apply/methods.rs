//! Methods that are compared: one piece of work at a time, so that times can be compared; what other workspaces found
//! is shared; and the panes follow the methods that are shown.

use crate::app::document::{MethodId, Side};
use crate::app::pane::{MethodsPreset, PaneGroup};
use crate::app::results::{FoundFeatures, MethodFound, Model, Read};
use crate::burst::OpenOptions;
use crate::engine::{Ended, Engine};
use crate::requests::{BurstSource, Detected, OpenRequest};

pub(in crate::app) fn open_gold(model: &mut Model, side: Side, source: BurstSource, engine: &Engine) {
    let options = Read::of(model).calibration_of(side).clone().with_burst_of(&OpenOptions::default());
    model.results.compare.opening_gold[side].ask(engine, OpenRequest { source, options });
}

pub(super) fn take_gold(model: &mut Model, side: Side, ended: Ended<OpenRequest>) {
    const TITLE: &str = "Open gold standard";
    if let Some(open) = model.shell.messages.answer(ended.result, TITLE) {
        model.shell.messages.resolved(TITLE);
        model.shell.messages.note(format!("Opened as gold standard of {}: {}", side.name(), open.describe()));
        model.results.compare.gold[side] = Some(open);
    }
    model.document.gold[side] = model.results.compare.gold[side].as_ref().map(|open| open.source.clone());
}

/// Takes over results of the other workspaces with equal parameters, so that they are not computed again.
pub fn share_what_is_found(model: &mut Model) {
    for method in MethodId::ALL.into_iter().filter(|m| *m != MethodId::Gold) {
        for side in Side::BOTH {
            let read = Read::of(model);
            let is_missing = read.method_found(method, side).is_none();
            let is_wanted = |f: &&FoundFeatures| is_missing && f.params == read.method_params(method, side);
            let shared = read.whole_found_of(side).filter(is_wanted).cloned();
            if let (Some(found), Some(open)) = (shared, read.burst_of(side)) {
                let (elapsed, Detected { params, detection, .. }) = (found.elapsed, found.detected);
                let found = MethodFound { burst: open.id, params, detection, elapsed };
                model.results.compare.take_found(method, side, found);
            }
        }
    }
}

/// Where methods are compared, those that were switched on get a pane, others lose theirs; the rest stays.
pub fn refresh_workspace(model: &mut Model) {
    model.document.panes.follow(model.document.workspace);
    if !model.document.compares_methods() || model.results.slots.a.burst.is_none() {
        return;
    }
    let now = Read::of(model).methods_shown();
    if now == model.results.compare.arranged {
        return;
    }
    let before = std::mem::replace(&mut model.results.compare.arranged, now.clone());
    let has_pane = |method: &MethodId| model.document.panes.each_shown().any(|pane| pane.method == Some(*method));
    if before.is_empty() && !now.iter().any(has_pane) {
        return lay_out_methods(model, MethodsPreset::Panes);
    }
    let both = Read::of(model).burst_of(Side::B).is_some();
    now.iter().for_each(|method| model.document.panes.add_method(*method, both));
    before.iter().filter(|method| !now.contains(method)).for_each(|method| model.document.panes.remove_method(*method));
}

pub fn keep_methods_arranged(model: &mut Model) {
    let shown = model.document.panes.shown_in(PaneGroup::Methods);
    let is_laid_out = shown.iter().filter_map(|id| model.document.panes.get(*id)).any(|pane| pane.method.is_some());
    model.results.compare.arranged = if is_laid_out { Read::of(model).methods_shown() } else { Vec::new() };
}

pub fn lay_out_methods(model: &mut Model, preset: MethodsPreset) {
    let (methods, both) = (Read::of(model).methods_shown(), Read::of(model).burst_of(Side::B).is_some());
    model.document.panes.lay_out_methods(preset, &methods, both);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::bench::open;
    use crate::app::apply::pair::tests::pair;
    use crate::app::document::CompareLook;
    use crate::app::results::Matches;
    use crate::app::results::compare::*;
    use crate::requests::CompareRequest;
    use std::sync::Arc;
    use std::time::Duration;

    fn methods() -> Model {
        let mut model = pair();
        model.document.compare_methods();
        model
    }

    fn do_all(model: &mut Model) -> Vec<(MethodId, Side)> {
        let mut done = Vec::new();
        while let Some(CompareJob { method, side, request, .. }) = Read::of(model).next_compare_job() {
            match request {
                CompareRequest::Detect(request) => {
                    let detection = Read::of(model).found_of(side).expect("found").detection.clone();
                    let (burst, params) = (request.burst.id, request.params.at_given());
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
        assert!(Read::of(&model).method_matches(MethodId::Buff1d).is_some());
        assert!(Read::of(&model).next_compare_job().is_none());
    }

    #[test]
    fn a_changed_parameter_makes_what_was_found_old() {
        let mut model = methods();
        do_all(&mut model);
        model.document.matching.ratio = 0.7;
        let again = do_all(&mut model);
        assert_eq!(again.len(), 4, "only the matches are made again: {again:?}");
        model.document.params.slopes = crate::detector::SlopeGrid::line(-3.0..=3.0, 9).into();
        let again = do_all(&mut model);
        assert!(again.iter().any(|(method, _)| *method == MethodId::Buff2d), "{again:?}");
        crate::app::apply::opening::take_burst(&mut model, open((64, 48), 5));
        assert!(Read::of(&model).method_found(MethodId::Sift, Side::A).is_none());
    }

    #[test]
    fn what_failed_is_not_tried_again_until_asked_or_changed() {
        let mut model = methods();
        let job = Read::of(&model).next_compare_job().expect("nothing is there yet");
        model.results.compare.failed.push((job.clone(), "cancelled".into()));
        assert_eq!(model.results.compare.problem(job.method), Some("cancelled"));
        assert_ne!(Read::of(&model).next_compare_job().map(|next| next.method), Some(job.method));
        model.results.compare.failed.clear();
        assert_eq!(Read::of(&model).next_compare_job().map(|next| next.method), Some(job.method));
        model.results.compare.failed.push((job.clone(), "cancelled".into()));
        model.document.params.edge_threshold *= 2.0;
        assert_eq!(Read::of(&model).next_compare_job().map(|next| next.method), Some(job.method));
    }

    #[test]
    fn what_other_rooms_found_is_shared() {
        let mut model = methods();
        share_what_is_found(&mut model);
        let shared =
            Read::of(&model).method_found(MethodId::Buff1d, Side::A).expect("the window searches one line of slopes");
        assert!(Arc::ptr_eq(&shared.detection, &Read::of(&model).found_of(Side::A).expect("found").detection));
        assert!(Read::of(&model).method_found(MethodId::Sift, Side::A).is_none());
    }

    #[test]
    fn the_look_from_a_file_makes_sense() {
        let methods = vec![MethodId::Gold, MethodId::Sift, MethodId::Gold];
        let look = CompareLook { methods, ..CompareLook::default() }.sanitised();
        assert_eq!(look.methods, [MethodId::Sift, MethodId::Gold]);
    }
}
