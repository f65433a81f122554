//! Requests of the project to the engine: in each pass it takes the answers that came, and requests what is missing.

use super::messages::Messages;
use super::side::Side;
use super::{Effect, Model};
use crate::engine::{Ended, Engine, Want, Wanted};
use crate::requests::{JobError, Request, Urgency};

impl Model {
    pub fn wants(&self) -> Vec<&dyn Want> {
        let Self { slots, pair, compare, explained, coherence, probe, datasets, trajectories, studies, .. } = self;
        let opening: [&dyn Want; 2] = slots.both().map(|slot| &slot.opening as _);
        let detecting: [&dyn Want; 2] = slots.both().map(|slot| &slot.detecting as _);
        let against: [&dyn Want; 2] = slots.both().map(|slot| &slot.against.wanted as _);
        let gold: [&dyn Want; 2] = compare.opening_gold.both().map(|gold| gold as _);
        let coherences: [&dyn Want; 2] = coherence.wanted.both().map(|wanted| wanted as _);
        let others: [&dyn Want; 17] = [
            &self.wanted_patch,
            &self.figures,
            &pair.matching,
            &pair.wanted_patches,
            &pair.lost.wanted,
            &pair.lost.wanted_pictures,
            &pair.lost.pricing,
            &compare.wanted,
            &explained.asked_slopes,
            &explained.asked_candidates,
            &explained.asked_decoys,
            &probe.wanted_trail,
            &probe.wanted_answer,
            &datasets.wanted,
            &trajectories.reading,
            &studies.wanted,
            &studies.wanted_chart,
        ];
        [opening, detecting, against, gold, coherences].into_iter().flatten().chain(others).collect()
    }

    pub fn is_searching(&self) -> bool {
        self.wants().iter().any(|want| want.urgency() == Some(Urgency::Search))
    }

    /// Work on datasets, the Lab's studies and the figures of the paper are cancelled separately.
    pub fn cancel_searches(&self) {
        self.wants().into_iter().filter(|want| want.urgency() == Some(Urgency::Search)).for_each(Want::cancel);
    }

    pub fn is_settled(&self) -> bool {
        self.wants().into_iter().all(Want::is_settled)
            && self.pictures_are_current()
            && !(self.auto_detect && self.wants_detection(Side::A))
            && self.pair_is_settled()
            && self.probe_is_settled()
            && self.comparison_of_methods_is_there()
            && Side::BOTH.into_iter().all(|side| {
                let wanted = &self.coherence.wanted[side];
                self.missing_coherence(side).is_none_or(|missing| wanted.has_failed(&missing))
            })
            && self.missing_slopes().is_none_or(|missing| self.explained.asked_slopes.has_failed(&missing))
            && self.missing_candidates().is_none_or(|missing| self.explained.asked_candidates.has_failed(&missing))
            && self.missing_decoys().is_none_or(|missing| self.explained.asked_decoys.has_failed(&missing))
    }

    #[must_use]
    pub(in crate::app) fn take_answers(&mut self, engine: &Engine) -> Vec<Effect> {
        engine.enforce_grace();
        let mut effects = Vec::new();
        for side in Side::BOTH {
            effects.extend(self.slots[side].opening.take().into_iter().map(|ended| Effect::Opened(side, ended)));
        }
        self.take_pictures();
        self.take_features();
        self.take_matches();
        self.take_probed();
        self.take_compared();
        self.take_explanations();
        self.take_coherences();
        self.take_comparisons();
        self.take_losses();
        self.take_studies();
        self.take_figures();
        self.take_trajectories();
        for event in self.datasets.wanted.take_told() {
            self.datasets.open.iter_mut().for_each(|dataset| dataset.take_event(&event));
            // Counts that were said before are old.
            self.messages.forget_note();
        }
        for ended in self.datasets.wanted.take() {
            effects.extend(self.take_dataset_answer(ended, engine));
        }
        effects
    }

    /// While the pointer drags a value, long work waits for the final one; features that need no search follow it.
    pub(in crate::app) fn ask(&mut self, engine: &Engine, dragging: bool) {
        self.ask_for_pictures(engine, dragging);
        if self.auto_detect && (!dragging || self.features_can_follow(Side::A)) {
            self.ask_for_features(Side::A, engine);
        }
        self.ask_for_probed(engine, dragging);
        self.ask_for_pair(engine, dragging);
        self.ask_for_compared(engine, dragging);
        self.ask_for_explanations(engine);
        self.ask_for_comparisons(engine);
        self.ask_for_coherences(engine);
        self.ask_for_losses(engine);
        self.ask_for_chart(engine);
    }
}

/// The answers since the last pass. A failure becomes a message with this title.
pub(super) fn answers<R: Request>(wanted: &mut Wanted<R>, title: &str, messages: &mut Messages) -> Vec<R::Answer> {
    let answer = |ended: Ended<R>| match ended.result {
        Ok(answer) => Some(answer),
        Err(JobError::Cancelled) => None,
        Err(error) => {
            messages.error(title, error.to_string());
            None
        }
    };
    wanted.take().into_iter().filter_map(answer).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::tests::Bench;
    use crate::detector::{NoiseGate, SlopeGrid};
    use crate::requests::BurstSource;
    use crate::synth::Example;

    #[test]
    fn features_follow_a_threshold_that_is_dragged_but_not_what_needs_a_search() {
        let mut bench = Bench::new();
        let burst = BurstSource::Example(Example::LowContrast).open(&Default::default(), &crate::Monitor::default());
        bench.model.take_burst(burst.expect("built in"));
        bench.model.params.slopes = SlopeGrid::line(-1.0..=1.0, 3);
        bench.settle();
        let all = bench.model.features().len();
        assert!(all > 3);
        let mut dragged = |change: fn(&mut Model)| {
            change(&mut bench.model);
            bench.model.ask(&bench.engine, true);
            let asks = bench.model.slots.a.detecting.is_pending();
            if asks {
                // A newer value waits, so that the features of this one come.
                change(&mut bench.model);
                bench.model.ask(&bench.engine, true);
                while bench.model.slots.a.detecting.is_pending() {
                    let _ = bench.model.take_answers(&bench.engine);
                }
            }
            (asks, bench.model.features().len(), bench.model.features_are_current(Side::A))
        };
        assert_eq!(dragged(|model| model.params.max_features = 2), (true, 2, true));
        assert_eq!(dragged(|model| model.params.max_features = 3), (true, 3, true));
        assert_eq!(dragged(|model| model.params.max_features += 1), (true, 4, false));
        assert_eq!(dragged(|model| model.params.max_features = 0), (true, all, true));
        assert_eq!(dragged(|model| model.params.noise_gate = NoiseGate::Factor(3.0)), (false, all, false));
        assert_eq!(dragged(|model| model.params.noise_gate = NoiseGate::Auto), (false, all, true));
        assert!(!dragged(|model| model.params.slopes = SlopeGrid::line(-0.8..=0.8, 3)).0);
        let (asks, _, is_current) = dragged(|model| model.params.slopes = SlopeGrid::line(-1.0..=2.0, 4));
        assert!(asks && is_current, "one more slope is searched while the end is dragged");
    }

    #[test]
    fn what_was_cancelled_is_not_begun_again_by_itself() {
        let mut bench = Bench::new();
        let source = BurstSource::Example(Example::Street);
        let burst = source.open(&Default::default(), &crate::Monitor::default()).expect("built in");
        bench.model.take_burst(burst);
        bench.model.params.slopes = SlopeGrid::plane(-3.0..=3.0, 31, -3.0..=3.0, 31);
        bench.run_until(|model, _| model.slots.a.detecting.is_pending());
        assert!(bench.model.is_searching());
        bench.model.cancel_searches();
        bench.settle();
        assert!(bench.model.slots.a.found.is_none() && !bench.model.wants_detection(Side::A));
        assert!(bench.model.slots.a.detecting.failure().is_some_and(|(_, why)| *why == JobError::Cancelled));
        assert!(bench.model.messages.errors().is_empty(), "a person did not want it");
        // Other parameters are another detection.
        bench.model.params.slopes = SlopeGrid::line(-1.0..=1.0, 3);
        bench.settle();
        assert!(bench.model.features_are_current(Side::A));
    }
}
