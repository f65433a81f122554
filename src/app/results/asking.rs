//! Parts of the project with background work, in one list: in each pass the project takes the answers that came, and
//! requests what is missing.

use crate::app::document::side::Side;
use crate::app::results::compare::Methods;
use crate::app::results::pictures::PanePictures;
use crate::app::results::{Effect, Model};
use crate::app::results::{One, Part, Pass};
use crate::engine::{Ended, Engine, Want};
use crate::requests::{JobError, Request, Urgency};

/// Makes a [`One`]: whether it ends, where its requests are, what is missing, and how an answer is taken, and a partial
/// one.
macro_rules! one {
    ($ends:literal, |$m:ident| $wanted:expr, |$of:ident, $drags:tt| $missing:expr, |$to:ident, $ended:ident| $take:expr) => {
        one!($ends, |$m| $wanted, |$of, $drags| $missing, |$to, $ended| $take, |_, _| ())
    };
    ($ends:literal, |$m:ident| $wanted:expr, |$of:ident, $drags:tt| $missing:expr, |$to:ident, $ended:ident| $take:expr, $take_partial:expr) => {
        &One {
            wanted: |$m| &$wanted,
            wanted_mut: |$m| &mut $wanted,
            missing: |$of, $drags| $missing,
            ends: $ends,
            take: |$to, $ended, _| {
                $take;
                Vec::new()
            },
            take_partial: $take_partial,
        }
    };
}

/// Makes a [`One`] that the user asks for: nothing is missing by itself.
macro_rules! asked {
    (|$m:ident| $wanted:expr, $take:expr) => {
        asked!(|$m| $wanted, $take, |_, _| ())
    };
    (|$m:ident| $wanted:expr, $take:expr, $take_partial:expr) => {
        &One {
            wanted: |$m| &$wanted,
            wanted_mut: |$m| &mut $wanted,
            missing: |_, _| None,
            ends: false,
            take: $take,
            take_partial: $take_partial,
        }
    };
}

/// The one list. Pictures are asked for before the detection from which later ones may be made.
#[rustfmt::skip]
const PARTS: &[&dyn Part] = &[
    asked!(|m| m.results.slots.a.opening, |_, ended, _| vec![Effect::Opened(Side::A, ended)]),
    asked!(|m| m.results.slots.b.opening, |_, ended, _| vec![Effect::Opened(Side::B, ended)]),
    &PanePictures,
    one!(false, |m| m.results.wanted_patch, |m, _| m.missing_patch(), |m, ended| m.take_patch(ended)),
    one!(false, |m| m.results.slots.a.detecting, |m, drags| m.missing_features(Side::A, drags), |m, ended| m.take_features(Side::A, ended), |m, first| m.take_first_features(Side::A, first)),
    one!(false, |m| m.results.slots.b.detecting, |m, drags| m.missing_features(Side::B, drags), |m, ended| m.take_features(Side::B, ended), |m, first| m.take_first_features(Side::B, first)),
    one!(false, |m| m.results.probed.wanted_trail, |m, drags| m.missing_trail(drags), |m, ended| m.take_probed_trail(ended)),
    one!(false, |m| m.results.probed.wanted_answer, |m, _| m.missing_probe(), |m, ended| m.take_probed(ended)),
    one!(false, |m| m.results.pair.wanted_patches, |m, _| m.missing_patches(), |m, ended| m.take_patches(ended)),
    one!(false, |m| m.results.pair.matching, |m, drags| m.missing_matches(drags), |m, ended| m.take_matches(ended)),
    asked!(|m| m.results.compare.opening_gold.a, |m, ended, _| m.take_gold(Side::A, ended)),
    asked!(|m| m.results.compare.opening_gold.b, |m, ended, _| m.take_gold(Side::B, ended)),
    &Methods,
    one!(true, |m| m.results.explained.asked_slopes, |m, _| m.missing_slopes(), |m, ended| m.take_explained(ended)),
    one!(true, |m| m.results.explained.asked_candidates, |m, _| m.missing_candidates(), |m, ended| m.take_explained(ended)),
    one!(true, |m| m.results.explained.asked_decoys, |m, _| m.missing_decoys(), |m, ended| m.take_explained(ended)),
    one!(true, |m| m.results.slots.a.comparison.wanted, |m, _| m.missing_comparison(Side::A), |m, ended| m.take_comparison(Side::A, ended)),
    one!(true, |m| m.results.slots.b.comparison.wanted, |m, _| m.missing_comparison(Side::B), |m, ended| m.take_comparison(Side::B, ended)),
    one!(true, |m| m.results.coherence.wanted.a, |m, _| m.missing_coherence(Side::A), |m, ended| m.take_coherences(ended)),
    one!(true, |m| m.results.coherence.wanted.b, |m, _| m.missing_coherence(Side::B), |m, ended| m.take_coherences(ended)),
    one!(false, |m| m.results.pair.lost.wanted, |m, _| m.missing_losses(), |m, ended| m.take_losses(ended)),
    one!(false, |m| m.results.pair.lost.pricing, |m, _| m.missing_price(), |m, ended| m.take_price(ended)),
    one!(false, |m| m.results.pair.lost.wanted_pictures, |m, _| m.missing_candidate_pictures(), |m, ended| m.take_lost_pictures(ended)),
    one!(false, |m| m.results.studies.wanted_chart, |m, _| m.missing_chart(), |m, ended| m.take_chart(ended)),
    asked!(|m| m.results.studies.wanted, |m, ended, _| m.take_study(ended), |m, report| m.take_part_of_study(report)),
    asked!(|m| m.results.figures, |m, ended, _| m.take_figures(ended)),
    asked!(|m| m.results.poses.reading, |m, ended, _| m.take_trajectories(ended)),
    asked!(|m| m.results.datasets.wanted, |m, ended, engine| m.take_dataset_answer(ended, engine), |m, event| m.take_dataset_event(&event)),
];

impl Model {
    fn wants(&self) -> impl Iterator<Item = &dyn Want> {
        PARTS.iter().flat_map(|part| part.wants(self))
    }

    pub fn is_searching(&self) -> bool {
        self.wants().any(|want| want.urgency() == Some(Urgency::Search))
    }

    /// Work on datasets, the Lab's studies and the figures of the paper are cancelled separately.
    pub fn cancel_searches(&self) {
        self.wants().filter(|want| want.urgency() == Some(Urgency::Search)).for_each(Want::cancel);
    }

    pub fn is_settled(&self) -> bool {
        self.wants().all(Want::is_settled) && PARTS.iter().all(|part| part.is_there(self))
    }

    #[must_use]
    pub(in crate::app) fn take_answers(&mut self, engine: &Engine) -> Vec<Effect> {
        engine.enforce_grace();
        self.probe_planted();
        let mut pass = Pass { model: self, engine, dragging: false };
        PARTS.iter().flat_map(|part| part.take(&mut pass)).collect()
    }

    pub(in crate::app) fn ask(&mut self, engine: &Engine, dragging: bool) {
        self.follow_pointer();
        self.check_references();
        self.refresh_why();
        let mut pass = Pass { model: self, engine, dragging };
        PARTS.iter().for_each(|part| part.ask(&mut pass));
    }

    /// The answer; a failure becomes a message with this title.
    pub(super) fn answer<R: Request>(&mut self, ended: Ended<R>, title: &str) -> Option<R::Answer> {
        match ended.result {
            Ok(answer) => Some(answer),
            Err(JobError::Cancelled) => None,
            Err(error) => {
                self.messages.error(title, error.to_string());
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::results::Stale;
    use crate::app::results::tests::Bench;
    use crate::detector::{NoiseGate, SlopeGrid};
    use crate::requests::BurstSource;
    use crate::synth::Example;

    #[test]
    fn features_follow_a_threshold_that_is_dragged_but_not_what_needs_a_search() {
        let mut bench = Bench::new();
        let burst = BurstSource::Example(Example::LowContrast).open(&Default::default(), &crate::Monitor::default());
        bench.model.take_burst(burst.expect("built in"));
        bench.model.document.params.slopes = SlopeGrid::line(-1.0..=1.0, 3);
        bench.settle();
        let all = bench.model.read().features().len();
        assert!(all > 3);
        let mut dragged = |change: fn(&mut Model)| {
            change(&mut bench.model);
            bench.model.ask(&bench.engine, true);
            let asks = bench.model.results.slots.a.detecting.is_pending();
            if asks {
                // A newer value waits, so that the features of this one come.
                change(&mut bench.model);
                bench.model.ask(&bench.engine, true);
                while bench.model.results.slots.a.detecting.is_pending() {
                    let _ = bench.model.take_answers(&bench.engine);
                }
            }
            (asks, bench.model.read().features().len(), bench.model.features_are_current(Side::A))
        };
        assert_eq!(dragged(|model| model.document.params.max_features = 2), (true, 2, true));
        assert_eq!(dragged(|model| model.document.params.max_features = 3), (true, 3, true));
        assert_eq!(dragged(|model| model.document.params.max_features += 1), (true, 4, false));
        assert_eq!(dragged(|model| model.document.params.max_features = 0), (true, all, true));
        assert_eq!(dragged(|model| model.document.params.noise_gate = NoiseGate::Factor(3.0)), (false, all, false));
        assert_eq!(dragged(|model| model.document.params.noise_gate = NoiseGate::Auto), (false, all, true));
        assert!(!dragged(|model| model.document.params.slopes = SlopeGrid::line(-0.8..=0.8, 3)).0);
        let (asks, _, is_current) = dragged(|model| model.document.params.slopes = SlopeGrid::line(-1.0..=2.0, 4));
        assert!(asks && is_current, "one more slope is searched while the end is dragged");
    }

    #[test]
    fn a_long_search_shows_the_features_of_one_slope_before_those_of_all() {
        let mut bench = Bench::new();
        let burst = BurstSource::Example(Example::Street).open(&Default::default(), &crate::Monitor::default());
        bench.model.take_burst(burst.expect("built in"));
        bench.model.document.params.slopes = SlopeGrid::plane(-3.0..=3.0, 13, -3.0..=3.0, 13);
        bench.run_until(|model, _| model.results.slots.a.found.is_some());
        let found = bench.model.results.slots.a.found.clone().expect("found");
        assert_eq!(bench.model.stale(), Some(Stale::FirstSlope));
        assert!(bench.model.results.slots.a.detecting.is_pending() && !bench.model.features_are_current(Side::A));
        assert_eq!(found.detection.slopes, SlopeGrid::single(bench.model.document.cursor().slope), "it is on show");
        assert!(found.judgement.is_none() && found.advice.is_none(), "one slope tells nothing about the range");
        assert!(bench.model.found_source(Side::A).is_none(), "nothing is asked of features that no search finds alone");
        bench.settle();
        assert!(bench.model.features_are_current(Side::A) && bench.model.stale().is_none());
        let first = found.detection.features.len();
        assert!((1..bench.model.read().features().len()).contains(&first), "{first}");
    }

    #[test]
    fn what_was_cancelled_is_not_begun_again_by_itself() {
        let mut bench = Bench::new();
        let source = BurstSource::Example(Example::Street);
        let burst = source.open(&Default::default(), &crate::Monitor::default()).expect("built in");
        bench.model.take_burst(burst);
        bench.model.document.params.slopes = SlopeGrid::plane(-3.0..=3.0, 31, -3.0..=3.0, 31);
        bench.run_until(|model, _| model.results.slots.a.detecting.is_pending());
        assert!(bench.model.is_searching());
        bench.model.cancel_searches();
        bench.settle();
        assert!(bench.model.results.slots.a.found.is_none() && !bench.model.wants_detection(Side::A));
        assert!(bench.model.results.slots.a.detecting.failure().is_some_and(|(_, why)| *why == JobError::Cancelled));
        assert!(bench.model.messages.errors().is_empty(), "a person did not want it");
        // Other parameters are another detection.
        bench.model.document.params.slopes = SlopeGrid::line(-1.0..=1.0, 3);
        bench.settle();
        assert!(bench.model.features_are_current(Side::A));
    }
}
