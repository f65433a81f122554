//! Work in the background, in one list of parts: in each pass the answers that came are taken, and what is missing is
//! requested. What is missing, each part says as a value of what is set and found (`Read`); what an answer changes
//! stands in this room, as it may move a cursor or a selection too.

use crate::app::apply::{comparison, datasets, detection, explained, methods, pair, panes, probe, studies};
use crate::app::document::Side;
use crate::app::results::{Effect, Matches, MethodFound, Model, Read, Results};
use crate::engine::{Ended, Engine, Want, Wanted};
use crate::requests::{Compared, JobError, PictureAnswer, RangeClass, Request, Urgency};

/// Pass of the window. While the pointer drags a value, long work waits for the final one.
struct Pass<'a> {
    model: &'a mut Model,
    engine: &'a Engine,
    dragging: bool,
}

trait Part {
    fn wants<'m>(&self, results: &'m Results) -> Vec<&'m dyn Want>;

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect>;

    fn ask(&self, pass: &mut Pass<'_>);

    /// Whether all that this part wants is there, or failed.
    fn is_there(&self, model: Read<'_>) -> bool;
}

struct One<R: Request> {
    wanted: fn(&Results) -> &Wanted<R>,
    wanted_mut: fn(&mut Results) -> &mut Wanted<R>,
    /// Request for what is missing now, with and without a drag.
    missing: fn(Read<'_>, bool) -> Option<R>,
    /// Whether a request ends when nothing is missing any more.
    ends: bool,
    take: fn(&mut Model, Ended<R>, &Engine) -> Vec<Effect>,
    /// Takes what was done of a request that still runs.
    take_partial: fn(&mut Model, R::Partial),
}

impl<R: Request> Part for One<R> {
    fn wants<'m>(&self, results: &'m Results) -> Vec<&'m dyn Want> {
        vec![(self.wanted)(results)]
    }

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect> {
        for partial in (self.wanted_mut)(&mut pass.model.results).take_partial() {
            (self.take_partial)(pass.model, partial);
        }
        let ended = (self.wanted_mut)(&mut pass.model.results).take();
        ended.into_iter().flat_map(|ended| (self.take)(pass.model, ended, pass.engine)).collect()
    }

    fn ask(&self, pass: &mut Pass<'_>) {
        let missing = (self.missing)(Read::of(pass.model), pass.dragging);
        if self.ends || missing.is_some() {
            (self.wanted_mut)(&mut pass.model.results).want(pass.engine, missing);
        }
    }

    fn is_there(&self, model: Read<'_>) -> bool {
        (self.missing)(model, false).is_none_or(|missing| (self.wanted)(model.results).has_failed(&missing))
    }
}

struct PanePictures;

impl Part for PanePictures {
    fn wants<'m>(&self, results: &'m Results) -> Vec<&'m dyn Want> {
        results.pictures.values().map(|shown| &shown.wanted as _).collect()
    }

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect> {
        let mut all_ended = Vec::new();
        for (id, shown) in &mut pass.model.results.pictures {
            // The first picture sets the range of values, which a preview must not.
            let is_new = |preview: &PictureAnswer| {
                let class = |picture: &PictureAnswer| RangeClass::of(&picture.request);
                shown.picture.as_ref().is_some_and(|picture| class(picture) == class(preview))
            };
            shown.preview = shown.wanted.take_partial().into_iter().rfind(is_new).or(shown.preview.take());
            all_ended.extend(shown.wanted.take().into_iter().map(|ended| (*id, ended)));
        }
        for (id, ended) in all_ended {
            match ended.result {
                Ok(picture) => panes::take_picture(pass.model, id, picture),
                Err(JobError::Cancelled) => pass.model.results.pictures.entry(id).or_default().wanted.forget(),
                // The request keeps the reason.
                Err(_) => {}
            }
        }
        Vec::new()
    }

    /// That of the pane in focus first. Pictures that need a search wait for the end of a drag, and for a running
    /// detection in their burst, from which they may be made.
    fn ask(&self, pass: &mut Pass<'_>) {
        let model = &mut *pass.model;
        let mut ids = model.document.panes.shown();
        ids.sort_by_key(|id| *id != model.document.focus());
        for id in ids {
            let Some(wanted) = Read::of(model).wanted(id).filter(|_| !Read::of(model).is_current(id)) else { continue };
            let side = model.document.panes.get(id).map_or(Side::A, |pane| pane.side);
            let waits = pass.dragging || model.results.slots[side].detecting.is_pending();
            if !(waits && wanted.urgency() == Urgency::SlowPicture) {
                model.results.pictures.entry(id).or_default().wanted.want(pass.engine, Some(wanted));
            }
        }
    }

    fn is_there(&self, model: Read<'_>) -> bool {
        model.pictures_are_current()
    }
}

/// Work of the comparison, one request at a time.
struct Methods;

impl Part for Methods {
    fn wants<'m>(&self, results: &'m Results) -> Vec<&'m dyn Want> {
        vec![&results.compare.wanted]
    }

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect> {
        let (compare, messages) = (&mut pass.model.results.compare, &mut pass.model.shell.messages);
        for ended in compare.wanted.take() {
            let Some(job) = compare.asked.take() else { continue };
            match ended.result {
                Ok(Compared::Detected(burst, params, detection)) => {
                    let found = MethodFound { burst, params, detection, elapsed: ended.elapsed };
                    compare.take_found(job.method, job.side, found);
                }
                Ok(Compared::Matched(matched)) => {
                    compare.take_matches(job.method, Matches::new(matched, ended.elapsed));
                }
                Err(error) => {
                    if error != JobError::Cancelled {
                        messages.error(job.method.label(), error.to_string());
                    }
                    compare.failed.push((job, error.to_string()));
                }
            }
        }
        Vec::new()
    }

    fn ask(&self, pass: &mut Pass<'_>) {
        let model = &mut *pass.model;
        if !model.document.compares_methods() || model.results.slots.a.burst.is_none() {
            return;
        }
        methods::share_what_is_found(model);
        let opening = model.results.compare.opening_gold.both();
        let is_busy = model.results.compare.wanted.is_pending() || opening.iter().any(|gold| gold.is_pending());
        let asks = !pass.dragging && model.document.auto_detect && !is_busy;
        if let Some(job) = Read::of(model).next_compare_job().filter(|_| asks) {
            model.results.compare.wanted.ask(pass.engine, job.request.clone());
            model.results.compare.asked = Some(job);
        }
    }

    fn is_there(&self, model: Read<'_>) -> bool {
        !model.document.compares_methods() || !model.document.auto_detect || model.next_compare_job().is_none()
    }
}

/// Makes a [`One`]: whether it ends, where its requests are, what is missing, how an answer and a part of it is taken.
macro_rules! one {
    (@$ends:literal, |$r:ident| $wanted:expr, $missing:expr, $take:expr) => {
        one!(@$ends, |$r| $wanted, $missing, $take, |_, _| ())
    };
    (@$ends:literal, |$r:ident| $wanted:expr, $missing:expr, $take:expr, $take_partial:expr) => {
        &One {
            wanted: |$r| &$wanted,
            wanted_mut: |$r| &mut $wanted,
            missing: $missing,
            ends: $ends,
            take: $take,
            take_partial: $take_partial,
        }
    };
    ($ends:literal, |$r:ident| $wanted:expr, $missing:expr, |$to:ident, $ended:ident| $take:expr $(, $take_partial:expr)?) => {
        one!(@$ends, |$r| $wanted, $missing, |$to, $ended, _| { $take; Vec::new() } $(, $take_partial)?)
    };
}

/// Of requests that the user asks for nothing is missing by itself.
fn nothing<R>(_: Read<'_>, _: bool) -> Option<R> {
    None
}

/// The one list. Pictures are asked for before the detection from which later ones may be made.
#[rustfmt::skip]
const PARTS: &[&dyn Part] = &[
    one!(@false, |r| r.slots.a.opening, nothing, |_, ended, _| vec![Effect::Opened(Side::A, ended)]),
    one!(@false, |r| r.slots.b.opening, nothing, |_, ended, _| vec![Effect::Opened(Side::B, ended)]),
    &PanePictures,
    one!(false, |r| r.patches.wanted, |m, _| m.missing_stack(), |m, ended| panes::take_stack(m, ended)),
    one!(false, |r| r.patches.wanted_in_focus, |m, drags| m.missing_in_focus(drags), |m, ended| m.results.patches.in_focus = m.shell.messages.answer(ended.result, "Loupe").or(m.results.patches.in_focus.take())),
    one!(false, |r| r.slots.a.detecting, |m, drags| m.missing_features(Side::A, drags), |m, ended| detection::take_features(m, Side::A, ended), |m, first| detection::take_first_features(m, Side::A, first)),
    one!(false, |r| r.slots.b.detecting, |m, drags| m.missing_features(Side::B, drags), |m, ended| detection::take_features(m, Side::B, ended), |m, first| detection::take_first_features(m, Side::B, first)),
    one!(false, |r| r.probed.wanted_trail, |m, drags| m.missing_trail(drags), |m, ended| probe::take_probed_trail(m, ended)),
    one!(false, |r| r.probed.wanted_answer, |m, _| m.missing_probe(), |m, ended| probe::take_probed(m, ended)),
    one!(false, |r| r.pair.matching, |m, drags| m.missing_matches(drags), |m, ended| pair::take_matches(m, ended)),
    one!(false, |r| r.compare.opening_gold.a, nothing, |m, ended| methods::take_gold(m, Side::A, ended)),
    one!(false, |r| r.compare.opening_gold.b, nothing, |m, ended| methods::take_gold(m, Side::B, ended)),
    &Methods,
    one!(true, |r| r.explained.asked_slopes, |m, _| m.missing_slopes(), |m, ended| explained::take_explained(m, ended)),
    one!(true, |r| r.explained.asked_candidates, |m, _| m.missing_candidates(), |m, ended| explained::take_explained(m, ended)),
    one!(true, |r| r.explained.asked_too_few, |m, _| m.missing_too_few(), |m, ended| explained::take_explained(m, ended)),
    one!(true, |r| r.explained.asked_decoys, |m, _| m.missing_decoys(), |m, ended| explained::take_explained(m, ended)),
    one!(true, |r| r.slots.a.comparison.wanted, |m, _| m.missing_comparison(Side::A), |m, ended| comparison::take_comparison(m, Side::A, ended)),
    one!(true, |r| r.slots.b.comparison.wanted, |m, _| m.missing_comparison(Side::B), |m, ended| comparison::take_comparison(m, Side::B, ended)),
    one!(true, |r| r.coherence.wanted.a, |m, _| m.missing_coherence(Side::A), |m, ended| explained::take_coherences(m, ended)),
    one!(true, |r| r.coherence.wanted.b, |m, _| m.missing_coherence(Side::B), |m, ended| explained::take_coherences(m, ended)),
    one!(false, |r| r.pair.lost.wanted, |m, _| m.missing_losses(), |m, ended| pair::take_losses(m, ended)),
    one!(false, |r| r.pair.lost.pricing, |m, _| m.missing_price(), |m, ended| m.results.pair.lost.priced = ended.result.ok().or(m.results.pair.lost.priced.take())),
    one!(false, |r| r.studies.wanted_chart, |m, _| m.missing_chart(), |m, ended| studies::take_chart(m, ended)),
    one!(false, |r| r.studies.wanted, nothing, |m, ended| studies::take_study(m, ended), |m, report| studies::take_part_of_study(m, report)),
    one!(true, |r| r.preview.wanted, |m, _| m.results.preview.missing(), |m, ended| m.results.preview.take(ended)),
    one!(true, |r| r.shape.wanted, |m, _| m.results.shape.missing(), |m, ended| m.results.shape.take(ended)),
    one!(true, |r| r.folder.wanted, |m, _| m.results.folder.missing(), |m, ended| m.results.folder.take(ended)),
    one!(false, |r| r.figures, nothing, |m, ended| studies::take_figures(m, ended)),
    one!(false, |r| r.poses.reading, nothing, |m, ended| studies::take_trajectories(m, ended)),
    one!(@false, |r| r.datasets.wanted, nothing, |m, ended, engine| datasets::take_dataset_answer(m, ended, engine), |m, event| datasets::take_dataset_event(m, &event)),
];

impl<'a> Read<'a> {
    fn wants(self) -> impl Iterator<Item = &'a dyn Want> {
        PARTS.iter().flat_map(|part| part.wants(self.results))
    }

    pub fn is_searching(self) -> bool {
        self.wants().any(|want| want.urgency() == Some(Urgency::Search))
    }

    /// Work on datasets, the Lab's studies and the figures of the paper are cancelled separately.
    pub fn cancel_searches(self) {
        self.wants().filter(|want| want.urgency() == Some(Urgency::Search)).for_each(Want::cancel);
    }

    pub fn is_settled(self) -> bool {
        self.wants().all(Want::is_settled) && PARTS.iter().all(|part| part.is_there(self))
    }
}

#[must_use]
pub(in crate::app) fn take_answers(model: &mut Model, engine: &Engine) -> Vec<Effect> {
    engine.enforce_grace();
    studies::probe_planted(model);
    let mut pass = Pass { model, engine, dragging: false };
    PARTS.iter().flat_map(|part| part.take(&mut pass)).collect()
}

pub(in crate::app) fn ask(model: &mut Model, engine: &Engine, dragging: bool) {
    probe::follow_pointer(model);
    comparison::check_references(model);
    pair::refresh_why(model);
    let mut pass = Pass { model, engine, dragging };
    PARTS.iter().for_each(|part| part.ask(&mut pass));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::bench::Bench;
    use crate::app::apply::opening;
    use crate::detector::{NoiseGate, SlopeGrid};
    use crate::requests::BurstSource;
    use crate::synth::Example;

    fn bench_with(example: Example) -> Bench {
        let mut bench = Bench::new();
        let burst = BurstSource::Example(example).open(&Default::default(), &crate::Monitor::default());
        opening::take_burst(&mut bench.model, burst.expect("built in"));
        bench
    }

    #[test]
    fn features_follow_a_threshold_that_is_dragged_but_not_what_needs_a_search() {
        let mut bench = bench_with(Example::LowContrast);
        bench.model.document.params.slopes = SlopeGrid::line(-1.0..=1.0, 3).into();
        bench.settle();
        let all = bench.read().features().len();
        assert!(all > 3);
        let mut dragged = |change: fn(&mut Model)| {
            change(&mut bench.model);
            ask(&mut bench.model, &bench.engine, true);
            let asks = bench.model.results.slots.a.detecting.is_pending();
            if asks {
                // A newer value waits, and the features of the first value arrive.
                change(&mut bench.model);
                ask(&mut bench.model, &bench.engine, true);
                while bench.model.results.slots.a.detecting.is_pending() {
                    let _ = take_answers(&mut bench.model, &bench.engine);
                }
            }
            (asks, bench.read().features().len(), bench.read().features_are_current(Side::A))
        };
        assert_eq!(dragged(|model| model.document.params.max_features = 2), (true, 2, true));
        assert_eq!(dragged(|model| model.document.params.max_features = 3), (true, 3, true));
        assert_eq!(dragged(|model| model.document.params.max_features += 1), (true, 4, false));
        assert_eq!(dragged(|model| model.document.params.max_features = 0), (true, all, true));
        assert_eq!(dragged(|model| model.document.params.noise_gate = NoiseGate::Factor(3.0)), (false, all, false));
        assert_eq!(dragged(|model| model.document.params.noise_gate = NoiseGate::Auto), (false, all, true));
        assert!(!dragged(|model| model.document.params.slopes = SlopeGrid::line(-0.8..=0.8, 3).into()).0);
        let wider = dragged(|model| model.document.params.slopes = SlopeGrid::line(-1.0..=2.0, 4).into());
        assert!(wider.0 && wider.2, "one more slope is searched while the end is dragged");
    }

    #[test]
    fn a_long_search_shows_the_features_of_one_slope_before_those_of_all() {
        let mut bench = bench_with(Example::Street);
        bench.model.document.params.slopes = SlopeGrid::plane(-3.0..=3.0, 13, -3.0..=3.0, 13).into();
        bench.run_until(|model, _| model.results.slots.a.found.is_some());
        let found = bench.model.results.slots.a.found.clone().expect("found");
        assert_eq!(bench.read().stale(), Some(crate::app::results::Stale::FirstSlope));
        assert!(bench.model.results.slots.a.detecting.is_pending());
        assert!(!bench.read().features_are_current(Side::A));
        assert_eq!(found.detection.slopes, SlopeGrid::single(bench.model.document.cursor().slope), "it is on show");
        assert!(found.judgement.is_none(), "one slope tells nothing about the range");
        let source = bench.read().found_source(Side::A);
        assert!(source.is_none(), "nothing is asked of features that no search finds alone");
        bench.settle();
        assert!(bench.read().features_are_current(Side::A) && bench.read().stale().is_none());
        let first = found.detection.features.len();
        assert!((1..bench.read().features().len()).contains(&first), "{first}");
    }
}
