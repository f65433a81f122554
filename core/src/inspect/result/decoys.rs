//! False rate of a search, from decoys: copies of the burst whose frames are in another order.
//!
//! In a copy nothing moves as it did, while noise, clutter and each single frame stay, and so do the noise model, the
//! gates and the slopes. The features of a copy are therefore false ones as this burst gives them, and their number
//! over that of the features found here is the part of these that proves nothing. It tends to be too high, and may
//! exceed 1: in a copy no true feature stands where a false one would be. A feature that stays within its own size over
//! the burst is in every copy too, whether true or not: of such features decoys say nothing.

use crate::detector::{Feature, Method, SearchParams, Trail};
use crate::detector::{feature::strength, stack::FrameTimes};
use crate::error::{Error, Result};
use crate::inspect::place::{Judged, judged};
use crate::inspect::words::{counted, number};
use crate::monitor::Monitor;
use crate::synth::random::Stream;
use serde::Serialize;

/// Copies with which a search is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct DecoyStudy {
    /// Number of copies, whose frames are in other orders.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().copies))]
    pub copies: usize,
    /// Seed of the orders: the same seed gives the same ones on every machine.
    #[cfg_attr(feature = "cli", arg(long, value_name = "SEED", default_value_t = Self::default().seed))]
    pub seed: u64,
}

impl Default for DecoyStudy {
    fn default() -> Self {
        Self { copies: 3, seed: 1 }
    }
}

/// Smallest SNRs of the features that are counted; 0 for all.
pub const SNRS: [f32; 8] = [0.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0];
/// SNR at which a sentence tells the rate of faint features.
const FAINT: f32 = 8.0;
/// Number of features from which a sentence tells the rate of the strongest.
const ENOUGH: usize = 10;
const MAX_COPIES: usize = 100;
/// Largest correlation, of either sign, of a copy's order with the frames' own.
const MAX_CORRELATION: f64 = 0.2;
/// Orders that are drawn at most: each order of six frames comes up many times.
const MAX_DRAWN: usize = 20_000;
/// Share of still features above which the rate is doubted.
const MANY_STILL: f64 = 0.2;

impl DecoyStudy {
    /// Checks, before a search by `params` of `frames` frames, that there are as many copies.
    ///
    /// # Errors
    /// As [`decoys`].
    pub fn check(&self, params: &SearchParams, frames: usize) -> Result<()> {
        let is_one = params.method == Method::Merge;
        self.orders(if is_one { 1 } else { params.used_frames(frames).len() }).map(|_| ())
    }

    /// Orders of `frames` frames, no two of them alike or each other's reverse, all nearly unrelated to time.
    fn orders(&self, frames: usize) -> Result<Vec<Vec<usize>>> {
        if !(1..=MAX_COPIES).contains(&self.copies) {
            return Err(Error::param("copies", self.copies.to_string(), format!("give 1 to {MAX_COPIES}")));
        }
        let mut stream = Stream::new(self.seed, 0);
        let mut orders: Vec<Vec<usize>> = Vec::new();
        for _ in 0..MAX_DRAWN {
            let mut order: Vec<usize> = (0..frames).collect();
            (1..frames).rev().for_each(|last| order.swap(last, stream.below(last + 1)));
            let is_known = |known: &Vec<usize>| known.iter().eq(&order) || known.iter().rev().eq(&order);
            if correlation_with_time(&order).abs() <= MAX_CORRELATION && !orders.iter().any(is_known) {
                orders.push(order);
            }
            if orders.len() == self.copies {
                return Ok(orders);
            }
        }
        Err(match orders.len() {
            0 => Error::param(
                "frames",
                format!("{} taking part", counted(frames, "frame")),
                "decoys are the frames in other orders, which takes 4 or more of them, and a method that reads them one by one",
            ),
            most => Error::param(
                "copies",
                format!("{}; {frames} frames have only {most} orders unlike their own", self.copies),
                format!("give at most {most}"),
            ),
        })
    }
}

/// Pearson's correlation of the times that an order gives with the frames' own, −1 … 1; NaN for a single frame.
fn correlation_with_time(order: &[usize]) -> f64 {
    let from_middle = |place: usize| place as f64 - 0.5 * (order.len() as f64 - 1.0);
    let products = order.iter().enumerate().map(|(i, &place)| from_middle(i) * from_middle(place));
    products.sum::<f64>() / (0..order.len()).map(|i| from_middle(i).powi(2)).sum::<f64>()
}

/// False rates of a search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DecoyReport {
    /// Number of frames that took part.
    pub frames: usize,
    /// Number of copies that were searched.
    pub copies: usize,
    /// Seed of their orders.
    pub seed: u64,
    /// Number of features whose places in the frames have a standard deviation along the motion below their σ: in
    /// another order they are blobs of nearly the same size.
    pub still: usize,
    /// The rates, for [`SNRS`].
    pub rates: Vec<FalseRate>,
}

/// False rate of the features from one SNR on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FalseRate {
    /// Smallest SNR of the features that are counted; 0 for all.
    pub snr: f32,
    /// Number of features found in the burst.
    pub found: usize,
    /// Number of features found in each copy.
    pub in_copies: Vec<usize>,
    /// Mean number found in a copy over the number found in the burst; `None` where that is 0.
    pub rate: Option<f64>,
    /// Standard error of the rate, from the larger of counting and the scatter of the copies.
    pub error: Option<f64>,
}

/// Rates of a search, and the features of its copies, each with the verdict on it among those of its copy.
#[derive(Debug, Clone, PartialEq)]
pub struct Decoys {
    /// The rates.
    pub report: DecoyReport,
    copies: Vec<(Vec<Feature>, Vec<Judged>)>,
    /// Strength of the weakest feature of the burst that is kept; 0 where their number is not limited.
    weakest: f32,
    /// Standard deviation of the frames' positions.
    spread_frames: f32,
}

impl Decoys {
    /// Report, with one rate, on the features of the burst that a filter lets through, `here`, against those of the
    /// copies that the same filter `passes`, with the verdicts there; 0 where they were not judged.
    pub fn among(&self, here: &[&Feature], passes: impl Fn(&Feature, &Judged) -> bool) -> DecoyReport {
        let counts = |(feature, judged): &(&Feature, &Judged)| {
            strength(feature.response, feature.snr) >= self.weakest && passes(feature, judged)
        };
        let in_copies = self.copies.iter().map(|(features, judged)| features.iter().zip(judged).filter(counts).count());
        let still = here.iter().filter(|feature| is_still(feature, self.spread_frames)).count();
        DecoyReport { still, rates: vec![FalseRate::of(0.0, here.len(), in_copies.collect())], ..self.report.clone() }
    }
}

/// Whether the places of a feature in frames of this spread lie within its size.
fn is_still(feature: &Feature, spread_frames: f32) -> bool {
    feature.slope.magnitude() * spread_frames < feature.sigma
}

/// Searches copies of the burst of `trail` for its features; `judges` asks for the verdicts that [`Decoys::among`]
/// needs. All features count, beyond the maximum number too, which would cut those of burst and copies alike.
///
/// # Errors
/// A number of copies that is out of range or that so few frames do not have, and cancellation.
pub fn decoys(trail: &Trail, study: &DecoyStudy, judges: bool, monitor: &Monitor) -> Result<Decoys> {
    let (_, kept, positions) = trail.frames();
    let mut orders = study.orders(kept.len())?;
    orders.extend((trail.params().max_features > 0).then(|| (0..kept.len()).collect()));
    let mut copies = Vec::with_capacity(orders.len());
    for (number, order) in orders.iter().enumerate() {
        let share = 1.0 / orders.len() as f32;
        let part = monitor.part(number as f32 * share, share);
        let search_share = if judges && number < study.copies { 0.6 } else { 1.0 };
        let copy = trail.reordered(order, &part.part(0.0, search_share))?;
        let rest = part.part(search_share, 1.0 - search_share);
        let judged = if search_share < 1.0 { judged(&copy, &rest)? } else { Vec::new() };
        copies.push((copy.detection().features.clone(), judged));
    }
    let all = copies.split_off(study.copies).pop();
    let kept_here = &trail.detection().features;
    let here = all.as_ref().map_or(kept_here, |(features, _)| features);
    let strengths = kept_here.iter().map(|feature| strength(feature.response, feature.snr));
    let weakest = if here.len() > kept_here.len() { strengths.fold(f32::INFINITY, f32::min) } else { 0.0 };
    let spread_frames = FrameTimes::all(positions.clone()).spread_frames();
    let still = here.iter().filter(|feature| is_still(feature, spread_frames)).count();
    let rate = |&snr: &f32| {
        let count = |features: &Vec<Feature>| features.iter().filter(|feature| feature.snr >= snr).count();
        FalseRate::of(snr, count(here), copies.iter().map(|(features, _)| count(features)).collect())
    };
    let rates = SNRS.iter().map(rate).collect();
    let report = DecoyReport { frames: kept.len(), copies: study.copies, seed: study.seed, still, rates };
    Ok(Decoys { report, copies, weakest, spread_frames })
}

impl FalseRate {
    fn of(snr: f32, found: usize, in_copies: Vec<usize>) -> Self {
        let (counted, here) = (Self { snr, found, in_copies, rate: None, error: None }, found as f64);
        let (copies, mean) = (counted.in_copies.len() as f64, counted.mean_in_copies());
        let squares = counted.in_copies.iter().map(|&count| (count as f64 - mean).powi(2)).sum::<f64>();
        let scatter = if copies > 1.0 { squares / (copies - 1.0) } else { 0.0 };
        // Where nothing was found, one more would have been no surprise.
        let variance = mean.max(scatter).max(1.0 / copies) / copies;
        let rate = (found > 0).then(|| mean / here);
        Self { rate, error: rate.map(|rate| (variance + rate * rate * here).sqrt() / here), ..counted }
    }

    /// Mean number of features found in a copy.
    pub fn mean_in_copies(&self) -> f64 {
        self.in_copies.iter().sum::<usize>() as f64 / self.in_copies.len().max(1) as f64
    }
}

impl DecoyReport {
    /// Rates of faint and of strong features, a clause; where there is no rate, the reason.
    pub fn sentence(&self) -> String {
        let told: Vec<(&FalseRate, f64)> = self.rates.iter().filter_map(|one| Some((one, one.rate?))).collect();
        let Some(weakest) = told.first() else { return "nothing is found here, so there is no rate".to_owned() };
        if let Some(doubt) = self.doubt().filter(|_| self.all_still()) {
            return doubt;
        }
        let (faint, rate) = told.iter().find(|(one, _)| one.snr == FAINT).unwrap_or(weakest);
        let mut sentence = format!("{rate:.2} found there for each found here");
        if faint.snr > 0.0 {
            sentence += &format!(" at SNR {}", number(faint.snr, 1));
        }
        match told.iter().rfind(|(one, _)| one.found >= ENOUGH && one.snr > faint.snr) {
            Some((strong, rate)) => sentence + &format!(", {rate:.2} at {}", number(strong.snr, 1)),
            None => sentence,
        }
    }

    /// Number of features found here that the copies let expect by chance, a clause; where they tell none, the reason.
    pub fn expected_words(&self) -> String {
        let (all, mean) = (&self.rates[0], self.rates[0].mean_in_copies());
        let of = format!("of {}", counted(all.found, "feature"));
        match self.doubt() {
            Some(doubt) if self.all_still() => doubt,
            _ if mean < 0.5 && all.found == 0 => self.sentence(),
            // A few copies with hardly a feature leave room for one in this burst.
            _ if mean < 0.5 && all.found < ENOUGH => format!("at most 1 {of} is expected of noise"),
            _ if mean < 0.5 => format!("hardly any {of} is expected of noise"),
            _ if mean >= all.found as f64 => format!("noise alone gives about {mean:.0} such features"),
            Some(_) => format!("at most about {mean:.0} {of} are expected of noise"),
            None => format!("about {mean:.0} {of} are expected of noise"),
        }
    }

    /// Reason to doubt the rates, a clause: features that hardly move, which every copy has too.
    pub fn doubt(&self) -> Option<String> {
        let found = self.rates.first().map_or(0, |all| all.found);
        if self.all_still() {
            return Some(
                "decoys say nothing here: no feature leaves its own size over the burst, so the order of frames changes little"
                    .to_owned(),
            );
        }
        (self.still as f64 > MANY_STILL * found as f64).then(|| {
            format!(
                "{} of {found} stay within their own size over the burst; copies have these too, true or not, so the rates are too high",
                counted(self.still, "feature")
            )
        })
    }

    fn all_still(&self) -> bool {
        self.rates.first().is_some_and(|all| all.found > 0 && self.still == all.found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_unlike_time_and_each_other() {
        for (frames, copies) in [(4, 3), (5, 19), (10, 100), (60, 20)] {
            let orders = DecoyStudy { copies, seed: 3 }.orders(frames).expect("enough");
            assert_eq!(orders.len(), copies);
            for (number, order) in orders.iter().enumerate() {
                let correlation = correlation_with_time(order);
                assert!(correlation.abs() <= MAX_CORRELATION, "{order:?}: {correlation}");
                let is_same = |other: &Vec<usize>| order.iter().eq(other) || order.iter().rev().eq(other);
                assert!(!orders[..number].iter().any(is_same), "{order:?} twice");
            }
        }
    }
}
