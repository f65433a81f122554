//! Times of the frames, from the images alone.
//!
//! Each block of the picture has a slope of its own. If the frames were taken at other times than their order says, the
//! correlation of two of them peaks at the slope times their distance in time, not in the order. Read along the slopes
//! of all blocks, the correlation of a pair is a function of its time difference alone, and the sum over pairs one of
//! the times of all frames: a log-likelihood, in nats, half the square of each block's significance, at its best slope.
//! Times are sought freely, and as one event that happens to cameras, such as two frames exchanged or one missing. An
//! event is reported if it alone explains nearly all that free times do.

use super::SlopeEvidence;
use super::event::{Event, MAX_MISSING, MAX_SCRAMBLED};
use super::evidence::{SHARED_NOISE, least_significance};
use super::lags::Lags;
use super::peak::{MIN_OVERLAP, cubic, overlap_at, peak_of, unbiased};
use super::spectra::{Fourier, Sum};
use rayon::prelude::*;

/// Least gain of an event over even times, nats: twice ln 400, about what the luckiest of 400 events gains by noise.
const MIN_NATS: f64 = 12.0;
/// Least gain besides, nats for each block that shows nothing: its slope fits the noise anew for each event. In the
/// dark this gained 8.1 in the worst of 936 bursts where nothing happened.
const BLIND_NATS: f64 = 8.5;
/// Least gain of the even-numbered blocks, and of the odd-numbered ones, nats.
const MIN_HALF_NATS: f64 = 5.0;
/// Part of the blocks' gain that others may lose: 0.3 or more where nothing happened, up to 0.05 after an event.
const MAX_LOST: f64 = 0.2;
/// Least gain, as a part of the nats of even times: the model errs on real pictures by up to half of it.
const MIN_PART: f64 = 0.01;
/// Part of the gain of free times that an event may leave; a motion that speeds up leaves 0.27 to 0.64.
const MAX_LEFT: f64 = 0.2;
/// Gain of free times that an event may leave besides, as a part of what even times have: even frames have it too.
const MAX_LEFT_PART: f64 = 0.005;
/// Part of its gain by which an event must lead the next different one.
const MIN_AHEAD: f64 = 0.1;
/// Part of its gain that frames beside the motion's line may gain: up to 0.23 after an event, from 0.55 for a hand.
const MAX_BESIDE: f64 = 0.35;
/// Number of events that get slopes of their own: those that agree best with the slopes of even times.
const TRIED: usize = 8;
/// Factors of the slopes of even times with which events are tried: missing frames make slopes look larger.
const SLOWER: [f64; 5] = [1.0, 0.95, 0.9, 0.85, 0.78];
/// Parts of a frame interval to which times are found.
const PARTS: f64 = 8.0;
/// Distances, frame intervals, that are tried for frames next to each other in a scrambled burst.
const APART: [f64; 4] = [1.0, 2.0, 3.0, 4.0];
/// Least distance between slopes that are tried for scrambled frames, level pixels per frame.
const APART_SLOPES: f64 = 0.1;
/// Number of orders tried with each scrambled slope.
const TRIED_ORDERS: usize = 2;
/// First step of a climb to the best slope, and the one that ends it, level pixels per frame.
const CLIMB: [f64; 2] = [0.16, 0.01];
/// Rounds of trying events, each with the slopes of the best before.
const ROUNDS: usize = 2;
/// Rounds over all frames in which their times are freed.
const FREE_ROUNDS: usize = 6;

struct Block {
    /// Correlation of each pair, divided by the overlap, and its variance before that.
    pairs: Vec<(Vec<f32>, f64)>,
    /// Slope for even times, level pixels per frame.
    slope: [f64; 2],
    /// Lowest significance of a block that counts as evidence.
    least: f64,
}

pub(super) struct Blocks<'a> {
    pairs: &'a [(usize, usize)],
    frames: usize,
    overlap: &'a [f32],
    blocks: Vec<Block>,
}

#[derive(Debug, Clone)]
pub(super) struct Agreement {
    pub event: Event,
    pub nats: f64,
    slopes: Vec<[f64; 2]>,
    significance: Vec<f64>,
}

/// Correlation of each pair over the time between its frames, nats.
type Readings = Vec<Vec<f64>>;

impl<'a> Blocks<'a> {
    /// Blocks `seen` at `level`; pairs up to `ignored_lags` apart share noise and are left out.
    pub fn of(
        seen: &[(Sum, SlopeEvidence)],
        (lags, ignored_lags): (&'a Lags, usize),
        level: u32,
        fourier: &'a Fourier,
    ) -> Self {
        // The pairs of frames that follow one another come first.
        let from = lags.near.iter().take_while(|(s, t)| t - s <= ignored_lags).count();
        let unit = f64::from(1u32 << level);
        let mut scratch = fourier.scratch(0);
        let mut block = |(sum, evidence): &(Sum, SlopeEvidence)| {
            let planes = fourier.correlations(&sum.pairs.products[from..], &mut scratch);
            let planes = planes.iter().map(|plane| unbiased(plane, &fourier.overlap));
            let pairs = planes.zip(sum.pairs.variance[from..].iter().map(|variance| SHARED_NOISE * variance)).collect();
            let slope = [evidence.slope.u, evidence.slope.v].map(|slope| f64::from(slope) / unit);
            Block { pairs, slope, least: f64::from(least_significance(evidence)) }
        };
        let blocks = seen.iter().map(&mut block).collect();
        Self { pairs: &lags.near[from..], frames: lags.frames, overlap: &fourier.overlap, blocks }
    }

    /// Event that happened to the frames; `None` where nothing did, or the frames do not show which.
    pub fn event(&self) -> Option<Event> {
        let [even, free, rest @ ..] = &self.compared()[..] else { return None };
        let [first, others @ ..] = rest else { return None };
        let gain = first.nats - even.nats;
        // Events of nearly the same times mend the burst alike: only a different one competes.
        let other = others
            .iter()
            .find(|other| !other.event.is_like(&first.event, self.frames))
            .map_or(even.nats, |other| other.nats);
        // A large rest that only free times explain has another cause, such as a hand that speeds up.
        let is_all = gain >= (1.0 - MAX_LEFT) * (free.nats - even.nats) - MAX_LEFT_PART * even.nats;
        let is_ahead = first.nats - other >= MIN_AHEAD * gain;
        let is_told = self.is_clear(first, even) && is_all && is_ahead && self.is_shared(first, even);
        let is_told = is_told && self.gain_beside(first) <= MAX_BESIDE * gain;
        is_told.then(|| first.event.clone())
    }

    /// Nats gained if frames also lie beside the line of the motion, where no event but a hand moves them.
    fn gain_beside(&self, one: &Agreement) -> f64 {
        let times = one.event.times(self.frames);
        let weighed = |axis: usize| one.slopes.iter().zip(&one.significance).map(|(s, w)| s[axis] * w * w).sum::<f64>();
        let (u, v) = (weighed(0), weighed(1));
        let across = [-v, u].map(|x| x / u.hypot(v).max(f64::MIN_POSITIVE));
        let mut beside = vec![[0.0; 2]; self.frames];
        let of_blocks = |beside: &[[f64; 2]], frame: Option<usize>| -> Vec<[f64; 3]> {
            let is_of = |s: usize, t: usize| frame.is_none_or(|frame| s == frame || t == frame);
            let blocks = self.blocks.par_iter().zip(&one.slopes);
            blocks.map(|(block, slope)| self.power(block, *slope, &times, |t| beside[t], is_of)).collect()
        };
        let total = |sums: &[[f64; 3]]| -> f64 { sums.iter().map(|sums| nats(significance(*sums))).sum() };
        let mut sums = of_blocks(&beside, None);
        let (before, [mut step, last]) = (total(&sums), CLIMB);
        while step > last {
            let mut is_better = false;
            // Steps are halved when no frame improves: far moves first need few evaluations.
            for frame in 0..self.frames {
                for by in [step, -step] {
                    let mut other = beside.clone();
                    other[frame] = [0, 1].map(|axis| beside[frame][axis] + by * across[axis]);
                    // Only the pairs of this frame change: their part of the sums is exchanged.
                    let (own, moved) = (of_blocks(&beside, Some(frame)), of_blocks(&other, Some(frame)));
                    let others = sums.iter().zip(own.iter().zip(&moved));
                    let others: Vec<[f64; 3]> =
                        others.map(|(sum, (own, moved))| [0, 1, 2].map(|k| sum[k] - own[k] + moved[k])).collect();
                    if total(&others) > total(&sums) {
                        (sums, beside, is_better) = (others, other, true);
                    }
                }
            }
            if !is_better {
                step *= 0.5;
            }
        }
        total(&sums) - before
    }

    /// Whether a block shows anything, and nearly all blocks prefer `one` to `even` times: of hundreds of events,
    /// chance favours one in some blocks, and as much against it in others.
    fn is_shared(&self, one: &Agreement, even: &Agreement) -> bool {
        let is_seen = self.blocks.iter().zip(&one.significance).any(|(block, seen)| *seen >= block.least);
        let gains = one.significance.iter().zip(&even.significance).map(|(one, even)| nats(*one) - nats(*even));
        let (mut halves, mut lost) = ([0.0; 2], 0.0);
        for (i, gain) in gains.enumerate() {
            halves[i % 2] += gain;
            lost -= gain.min(0.0);
        }
        is_seen && halves.iter().all(|gain| *gain >= MIN_HALF_NATS) && lost <= MAX_LOST * (halves[0] + halves[1] + lost)
    }

    /// Even times, free ones, and the events that agree best.
    pub fn compared(&self) -> Vec<Agreement> {
        if self.blocks.is_empty() {
            return Vec::new();
        }
        let slopes: Vec<[f64; 2]> = self.blocks.iter().map(|block| block.slope).collect();
        let even = self.agreement(Event::Nothing, &slopes);
        let events = Event::all(self.frames);
        let mut tried = best_first(self.likeliest(&even, &events).into_iter().chain(self.scrambled(&events)));
        // The slopes of even times mislead where many frames are missing; those of the event found do not.
        for _ in 0..ROUNDS {
            let Some(first) = tried.first().filter(|first| self.is_clear(first, &even)) else { break };
            let (nats, again) = (first.nats, self.likeliest(first, &events));
            tried = best_first(tried.into_iter().chain(again));
            if tried[0].nats <= nats {
                break;
            }
        }
        // Freed from two starts: from even times alone the ascent may end at a lower maximum.
        let free = [Some(&even), tried.first()].into_iter().flatten().map(|from| self.freed(from));
        let free = free.max_by(|a, b| a.nats.total_cmp(&b.nats));
        [Some(even), free].into_iter().flatten().chain(tried).collect()
    }

    fn is_clear(&self, one: &Agreement, even: &Agreement) -> bool {
        let blind = self.blocks.iter().zip(&one.significance).filter(|(block, seen)| **seen < block.least).count();
        one.nats - even.nats >= (MIN_NATS + BLIND_NATS * blind as f64).max(MIN_PART * even.nats)
    }

    /// Members of `events` that agree best with the slopes `from` or somewhat lower ones, with slopes of their own.
    fn likeliest(&self, from: &Agreement, events: &[Event]) -> Vec<Agreement> {
        let readings = self.readings(&from.slopes, Some(&from.event.times(self.frames)));
        let slower = |event: &Event| {
            let times = event.times(self.frames);
            let value = |slower: &f64| self.read(&readings, &times.iter().map(|t| slower * t).collect::<Vec<_>>());
            let best = SLOWER.iter().map(|slower| (value(slower), *slower)).max_by(|a, b| a.0.total_cmp(&b.0));
            best.unwrap_or((f64::NEG_INFINITY, 1.0))
        };
        let mut best: Vec<((f64, f64), &Event)> = events.par_iter().map(|event| (slower(event), event)).collect();
        // Reading tables is cheap, climbing to slopes is not: all events are read, the best alone climb.
        best.sort_by(|a, b| b.0.0.total_cmp(&a.0.0));
        let own = |((_, slower), event): &((f64, f64), &Event)| {
            let slopes: Vec<[f64; 2]> = from.slopes.iter().map(|slope| slope.map(|s| slower * s)).collect();
            self.agreement((*event).clone(), &slopes)
        };
        best[..TRIED.min(best.len())].iter().map(own).collect()
    }

    /// Orders of few frames that agree with a slope that two frames show, since those of even times mean nothing here.
    fn scrambled(&self, events: &[Event]) -> Vec<Agreement> {
        if self.frames > MAX_SCRAMBLED {
            return Vec::new();
        }
        let whole = self.whole();
        let mut slopes: Vec<[f64; 2]> = Vec::new();
        for (plane, variance) in whole.blocks[0].pairs.iter().take(self.frames - 1) {
            // `peak_of` takes correlations before the division by the overlap.
            let biased: Vec<f32> = plane.iter().zip(self.overlap).map(|(value, overlap)| value * overlap).collect();
            let Some((shift, _)) = peak_of(&biased, self.overlap, *variance) else { continue };
            for slope in APART.map(|apart| shift.map(|x| x / apart)) {
                let is_new = |other: &[f64; 2]| (other[0] - slope[0]).hypot(other[1] - slope[1]) > APART_SLOPES;
                if slope[0].hypot(slope[1]) > APART_SLOPES && slopes.iter().all(is_new) {
                    slopes.push(slope);
                }
            }
        }
        let orders = |slope: &[f64; 2]| {
            let readings = whole.readings(&[*slope], None);
            let read = |event: &Event| whole.read(&readings, &event.times(self.frames));
            let mut best: Vec<(f64, &Event)> =
                events.iter().filter(|event| event.is_order()).map(|event| (read(event), event)).collect();
            best.sort_by(|a, b| b.0.total_cmp(&a.0));
            best.into_iter().take(TRIED_ORDERS).map(|(_, event)| (event.clone(), *slope)).collect::<Vec<_>>()
        };
        let tried = slopes.iter().flat_map(orders);
        tried.map(|(event, slope)| self.agreement(event, &vec![slope; self.blocks.len()])).collect()
    }

    fn whole(&self) -> Self {
        let sum = |pair: usize| {
            let mut planes = self.blocks.iter().map(|block| &block.pairs[pair]);
            let (mut plane, mut variance) = planes.next().cloned().unwrap_or_default();
            for (other, of_other) in planes {
                plane.iter_mut().zip(other).for_each(|(a, b)| *a += b);
                variance += of_other;
            }
            (plane, variance)
        };
        let block = Block { pairs: (0..self.pairs.len()).map(sum).collect(), slope: [0.0; 2], least: 0.0 };
        Self { blocks: vec![block], ..*self }
    }

    /// Power of a block with `slope` at `times` with frames `beside` their places, that of things of amplitude 1, and
    /// the variance, over the pairs that `counts` accepts.
    fn power(
        &self,
        block: &Block,
        slope: [f64; 2],
        times: &[f64],
        beside: impl Fn(usize) -> [f64; 2],
        counts: impl Fn(usize, usize) -> bool,
    ) -> [f64; 3] {
        let mut sums = [0.0; 3];
        let pairs = self.pairs.iter().zip(&block.pairs).filter(|((s, t), _)| counts(*s, *t));
        for ((s, t), (plane, variance)) in pairs {
            let (from, to) = (beside(*s), beside(*t));
            let shift = [0, 1].map(|axis| slope[axis] * (times[*t] - times[*s]) + to[axis] - from[axis]);
            let overlap = f64::from(overlap_at(self.overlap, shift));
            if overlap >= f64::from(MIN_OVERLAP) {
                // The division by the overlap raised the noise: its square weights pairs by their accuracy.
                let weight = overlap * overlap;
                sums = [sums[0] + weight * cubic(plane, shift), sums[1] + weight, sums[2] + weight * variance];
            }
        }
        sums
    }

    /// Slope near `from` at which a block is most significant at `times`, and this significance.
    fn climbed(&self, block: &Block, from: [f64; 2], times: &[f64]) -> ([f64; 2], f64) {
        let value = |slope| (slope, significance(self.power(block, slope, times, |_| [0.0; 2], |_, _| true)));
        let (mut best, [mut step, last]) = (value(from), CLIMB);
        while step > last {
            let [u, v] = best.0;
            let around = [[u + step, v], [u - step, v], [u, v + step], [u, v - step]].map(value);
            match around.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).filter(|other| other.1 > best.1) {
                Some(better) => best = better,
                None => step *= 0.5,
            }
        }
        best
    }

    fn agreement(&self, event: Event, from: &[[f64; 2]]) -> Agreement {
        let times = event.times(self.frames);
        let climbed = self.blocks.par_iter().zip(from).map(|(block, from)| self.climbed(block, *from, &times));
        let (slopes, significance): (Vec<_>, Vec<f64>) = climbed.collect::<Vec<_>>().into_iter().unzip();
        let nats = significance.iter().map(|s| nats(*s)).sum();
        Agreement { event, nats, slopes, significance }
    }

    /// Readings along `slopes`. Each block's amplitude is fixed to its value at `times`; without them it is free.
    fn readings(&self, slopes: &[[f64; 2]], times: Option<&[f64]>) -> Readings {
        let reach = (self.frames + MAX_MISSING + 1) as f64;
        let mut readings = vec![vec![0.0; 2 * (PARTS * reach) as usize + 1]; self.pairs.len()];
        for (block, slope) in self.blocks.iter().zip(slopes) {
            let amplitude = times.map(|times| {
                let [power, full, _] = self.power(block, *slope, times, |_| [0.0; 2], |_, _| true);
                power.max(0.0) / full.max(f64::MIN_POSITIVE)
            });
            // With a known amplitude, a pair without correlation counts as much against as one with it counts for.
            let (weight, middle) = amplitude.map_or((1.0, 0.0), |amplitude| (amplitude, 0.5 * amplitude));
            readings.par_iter_mut().zip(&block.pairs).for_each(|(row, (plane, variance))| {
                for (i, sum) in row.iter_mut().enumerate() {
                    let shift = slope.map(|x| x * (i as f64 / PARTS - reach));
                    let overlap = f64::from(overlap_at(self.overlap, shift));
                    if overlap >= f64::from(MIN_OVERLAP) && *variance > 0.0 {
                        *sum += overlap * overlap * weight / variance * (cubic(plane, shift) - middle);
                    }
                }
            });
        }
        readings
    }

    fn read(&self, readings: &Readings, times: &[f64]) -> f64 {
        self.pairs.iter().zip(readings).map(|((s, t), row)| at(row, times[*t] - times[*s])).sum()
    }

    /// Free times that agree best, by coordinate ascent from the times of an agreement.
    fn freed(&self, from: &Agreement) -> Agreement {
        let mut times = from.event.times(self.frames);
        let readings = self.readings(&from.slopes, Some(&times));
        let ends = [-(PARTS as i64), PARTS as i64 * (self.frames + MAX_MISSING) as i64];
        for _ in 0..FREE_ROUNDS {
            let before = times.clone();
            for frame in 0..self.frames {
                let of_frame = self.pairs.iter().zip(&readings).filter(|((s, t), _)| *s == frame || *t == frame);
                let of_frame: Vec<_> = of_frame.collect();
                let value = |time: f64| -> f64 {
                    let apart = |s: usize, t: usize| if t == frame { time - times[s] } else { times[t] - time };
                    of_frame.iter().map(|((s, t), row)| at(row, apart(*s, *t))).sum()
                };
                // All times of one frame are tried, so that no local maximum along its time holds the ascent.
                let all = (ends[0]..=ends[1]).map(|i| i as f64 / PARTS).map(|time| (value(time), time));
                times[frame] = all.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(times[frame], |best| best.1);
            }
            if times == before {
                break;
            }
        }
        self.agreement(Event::Free(times), &from.slopes)
    }
}

fn significance([power, _, variance]: [f64; 3]) -> f64 {
    if variance > 0.0 { power / variance.sqrt() } else { 0.0 }
}

/// Logarithm of the likelihood of a significance.
fn nats(significance: f64) -> f64 {
    0.5 * significance.max(0.0).powi(2)
}

fn best_first(tried: impl Iterator<Item = Agreement>) -> Vec<Agreement> {
    let mut all: Vec<Agreement> = tried.collect();
    all.sort_by(|a, b| b.nats.total_cmp(&a.nats));
    let mut best: Vec<Agreement> = Vec::with_capacity(all.len());
    for one in all {
        if best.iter().all(|other| other.event != one.event) {
            best.push(one);
        }
    }
    best
}

/// Reading at a time difference, frame intervals; 0 beyond its ends.
fn at(row: &[f64], apart: f64) -> f64 {
    let place = PARTS * apart + (row.len() / 2) as f64;
    let (whole, part) = (place.floor(), place.fract());
    let value = |i: f64| if i >= 0.0 { row.get(i as usize).copied().unwrap_or(0.0) } else { 0.0 };
    (1.0 - part) * value(whole) + if part > 0.0 { part * value(whole + 1.0) } else { 0.0 }
}
