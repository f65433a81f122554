//! Prices of the changes that advice offers: how many features there are with each, counted in the background before it
//! is applied.

use crate::app::project::Model;
use crate::app::project::explained::SHORT_SECS;
use crate::app::project::side::Side;
use crate::detector::params::doc;
use crate::detector::{ParamChange, Sample};
use crate::engine::{Engine, Wanted};
use crate::inspect::price::{Price, time_factor};
use crate::requests::{JobError, PriceRequest, Priced, Request};

/// Maximum number of prices that are kept.
const KEPT: usize = 32;

/// Known prices, and the request for a missing one.
#[derive(Debug, Default)]
pub struct Prices {
    /// Known ones, the latest last.
    known: Vec<Priced>,
    /// Whether prices are wanted although the detection took long.
    pub wanted_long: bool,
    /// The request for a price.
    pub wanted: Wanted<PriceRequest>,
}

/// Price of a change, as far as it is counted: in features that come and go, or seconds of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KnownPrice {
    /// The number of features with it.
    Counted(Price),
    /// The factor by which the search takes longer.
    Time(f32),
    /// The count runs, or is about to.
    Counting,
    /// The count takes long, so it waits for the user; seconds that the detection took.
    Long(f32),
    /// It could not be counted.
    Unknown,
}

impl KnownPrice {
    /// Text beside the button that applies the change; empty where nothing is known.
    pub fn text(&self) -> String {
        match self {
            Self::Counted(price) => {
                let sentence = price.sentence();
                let (first, rest) = sentence.split_at(1);
                format!("{}{rest}", first.to_uppercase())
            }
            Self::Time(factor) => format!("About {factor:.1} times the time"),
            Self::Counting => "Counting features…".to_owned(),
            Self::Long(_) | Self::Unknown => String::new(),
        }
    }
}

/// Whether a change is one of the slopes, whose effect is told by its time.
fn is_of_slopes(change: &ParamChange) -> bool {
    [doc::SLOPES_U, doc::SLOPES_V, doc::SLOPE_DIRECTION].contains(&change.parameter)
}

impl Model {
    /// Changes that are offered now, with the side of their burst and the candidate that they are about: by the probe,
    /// and by the advice on few features.
    fn offered_changes(&self) -> Vec<(Side, ParamChange, Option<Sample>)> {
        let mut offered = Vec::new();
        let side = self.probe.side;
        let is_shown = self.probe.is_open && self.shows_right() && !self.probe.follows && self.probe_is_here();
        if let Some(answer) = self.probe.answer.as_ref().filter(|_| is_shown && self.probe.is_current()) {
            let fate = answer.probe.subject_fate();
            let remedy = fate.and_then(|fate| fate.remedy.as_ref()).map(|remedy| &remedy.change);
            let changes = remedy.into_iter().chain(answer.probe.suspicions.iter().filter_map(|s| s.change.as_ref()));
            offered.extend(changes.map(|change| (side, change.clone(), fate.map(|fate| fate.of_sample()))));
        }
        if let Some(advice) = self.slots.a.found.as_ref().and_then(|found| found.advice.as_ref()) {
            let change = ParamChange { parameter: advice.parameter, value: advice.value.clone() };
            offered.push((Side::A, change, None));
        }
        offered
    }

    fn price_request(&self, side: Side, change: &ParamChange, sample: Option<Sample>) -> Option<PriceRequest> {
        Some(PriceRequest { of: self.found_source(side)?, change: change.clone(), sample })
    }

    /// Seconds that the detection of `side` took, if it took long.
    fn took_long(&self, side: Side) -> Option<f32> {
        self.found_of(side).map(|found| found.elapsed.as_secs_f32()).filter(|secs| *secs > SHORT_SECS)
    }

    /// The price that is missing: of the first change on offer whose price is not known. A running detection comes
    /// first.
    pub fn missing_price(&self) -> Option<PriceRequest> {
        let is_missing = |(side, change, sample): (Side, ParamChange, Option<Sample>)| {
            let is_time = !self.slots[side].detecting.is_pending() && self.features_are_current(side);
            let is_asked = self.prices.wanted_long || self.took_long(side).is_none();
            let request = self.price_request(side, &change, sample).filter(|_| is_time && is_asked)?;
            let can = !is_of_slopes(&change) && change.applied(&request.of.params).is_ok();
            let is_new = !self.prices.known.iter().any(|known| known.request.is_same(&request));
            (can && is_new && !self.prices.wanted.has_failed(&request)).then_some(request)
        };
        self.offered_changes().into_iter().find_map(is_missing)
    }

    /// Price of a change to the detection of `side`, as far as it is counted.
    pub fn price_of(&self, side: Side, change: &ParamChange, sample: Option<Sample>) -> KnownPrice {
        let Some(request) = self.price_request(side, change, sample) else { return KnownPrice::Unknown };
        if let Some(known) = self.prices.known.iter().find(|known| known.request.is_same(&request)) {
            return KnownPrice::Counted(known.price);
        }
        let Ok(params) = change.applied(&request.of.params) else { return KnownPrice::Unknown };
        if is_of_slopes(change) {
            return KnownPrice::Time(time_factor(&request.of.params, &params, request.of.burst.burst.size()));
        }
        match self.took_long(side) {
            _ if self.prices.wanted.has_failed(&request) || !self.features_are_current(side) => KnownPrice::Unknown,
            Some(secs) if !self.prices.wanted_long => KnownPrice::Long(secs),
            _ => KnownPrice::Counting,
        }
    }

    /// Takes the price that was counted.
    pub(in crate::app) fn take_prices(&mut self) {
        for ended in self.prices.wanted.take() {
            match ended.result {
                Ok(priced) => {
                    self.prices.known.push(priced);
                    let over = self.prices.known.len().saturating_sub(KEPT);
                    self.prices.known.drain(..over);
                }
                Err(JobError::Cancelled) => {}
                Err(error) => self.messages.error("Price", error.to_string()),
            }
        }
    }

    /// Requests the price that is missing.
    pub(in crate::app) fn ask_for_prices(&mut self, engine: &Engine) {
        let missing = self.missing_price();
        self.prices.wanted.want(engine, missing);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::tests::Bench;
    use crate::detector::NoiseGate;
    use crate::inspect::probe::Wanted as Subject;
    use crate::requests::ProbeQuestion;

    #[test]
    fn the_price_of_a_remedy_is_counted_in_the_background_and_is_what_applying_it_gives() {
        let mut bench = Bench::with_two_charts();
        bench.model.open_workspace(crate::app::project::workspace::Workspace::Inspect);
        bench.model.params.noise_gate = NoiseGate::Factor(300.0);
        bench.model.auto_detect = true;
        bench.settle();
        bench.model.ask_probe(Side::A, ProbeQuestion::Strongest);
        bench.settle();
        let answer = bench.model.probe.answer.clone().expect("answered");
        let fate = answer.probe.subject_fate().expect("a candidate").clone();
        assert!(!fate.is_kept(), "the gate rejects all");
        bench.model.probe.look_at(Subject::Candidate(fate.of_sample()));
        bench.settle();
        let change = fate.remedy.as_ref().expect("it has one").change.clone();
        let price = match bench.model.price_of(Side::A, &change, Some(fate.of_sample())) {
            KnownPrice::Counted(price) => price,
            other => panic!("not counted: {other:?}"),
        };
        assert_eq!(price.now, bench.model.features().len());
        assert_eq!(price.own.map(|own| own.0), Some(fate.features.len()));
        bench.model.apply_change(&change);
        bench.settle();
        assert_eq!(bench.model.features().len(), price.then);
    }

    #[test]
    fn a_change_of_the_slopes_is_told_by_its_time() {
        let mut bench = Bench::with_two_charts();
        bench.settle();
        let slopes = bench.model.found_of(Side::A).expect("found").params.slopes.u;
        let twice = ParamChange::new(doc::SLOPES_U, slopes.with_more(0, slopes.count));
        let known = bench.model.price_of(Side::A, &twice, None);
        assert!(matches!(known, KnownPrice::Time(factor) if (factor - 2.0).abs() < 1e-4), "{known:?}");
        assert_eq!(known.text(), "About 2.0 times the time");
    }
}
