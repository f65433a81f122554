//! What the project wants of the engine: in each pass it takes the answers that came, and requests what is missing.
//!
//! Each part of the project holds a [`Wanted`](crate::engine::Wanted) for what it asks, takes its answers and asks for
//! what is missing. [`Model::wants`] is the one list of them all.

use super::Model;
use super::side::Side;
use crate::engine::{Ended, Engine, Want};
use crate::requests::{DatasetRequest, OpenRequest, Urgency};

/// A change beyond the project that an answer brings; the window makes it.
#[derive(Debug)]
pub enum Effect {
    /// A burst was opened for a side, or could not be.
    Opened(Side, Ended<OpenRequest>),
    /// Work on a dataset ended.
    Dataset(Ended<DatasetRequest>),
}

impl Model {
    /// All that want something of the engine, but for the pictures of panes and small pictures of datasets.
    pub fn wants(&self) -> Vec<&dyn Want> {
        let Self { slots, pair, compare, against, explained, coherence, probe, datasets, trajectories, lab, .. } = self;
        let opening: [&dyn Want; 2] = slots.both().map(|slot| &slot.opening as _);
        let detecting: [&dyn Want; 2] = slots.both().map(|slot| &slot.detecting as _);
        let gold: [&dyn Want; 2] = compare.opening_gold.both().map(|gold| gold as _);
        let coherences: [&dyn Want; 2] = coherence.wanted.both().map(|wanted| wanted as _);
        let others: [&dyn Want; 16] = [
            &self.wanted_patch,
            &self.figures,
            &pair.matching,
            &pair.wanted_patches,
            &pair.lost.wanted,
            &pair.lost.wanted_pictures,
            &compare.wanted,
            &against.wanted,
            &explained.asked_slopes,
            &explained.asked_candidates,
            &probe.wanted_trail,
            &probe.wanted_answer,
            &datasets.wanted,
            &trajectories.reading,
            &lab.wanted,
            &lab.wanted_chart,
        ];
        [opening, detecting, gold, coherences].into_iter().flatten().chain(others).collect()
    }

    /// Whether a search runs that [`Self::cancel_searches`] would cancel.
    pub fn is_searching(&self) -> bool {
        self.wants().iter().any(|want| want.urgency() == Some(Urgency::Search))
    }

    /// Cancels what is opened, detected, matched or compared. Work on datasets, the Lab's studies and the figures of the
    /// paper each have their own way to be cancelled.
    pub fn cancel_searches(&self) {
        self.wants().into_iter().filter(|want| want.urgency() == Some(Urgency::Search)).for_each(Want::cancel);
    }

    /// Whether everything that is shown is there, or is known to be impossible.
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
    }

    /// Takes the answers that came since the last pass.
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
        }
        effects.extend(self.datasets.wanted.take().into_iter().map(Effect::Dataset));
        effects
    }

    /// Requests what is missing. While the pointer still drags a value, long work waits for the last one.
    pub(in crate::app) fn ask(&mut self, engine: &Engine, dragging: bool) {
        self.ask_for_pictures(engine, dragging);
        if self.auto_detect && !dragging {
            self.ask_for_features(Side::A, engine);
        }
        self.ask_for_probed(engine, dragging);
        self.ask_for_pair(engine, dragging);
        self.ask_for_compared(engine, dragging);
        self.ask_for_explanations(engine);
        self.ask_for_comparison(engine);
        self.ask_for_coherences(engine);
        self.ask_for_losses(engine);
        self.ask_for_chart(engine);
    }
}
