//! Putative matches: nearest neighbours that pass the ratio test and the mutual check.
//!
//! The neighbours are exact: in |a|² + |b|² − 2·a·b all terms are whole numbers of at most 128·255² = 8 323 200, and
//! twice that is below 2²⁴, so `f32` holds every partial sum exactly, whatever the order of the additions.
//!
//! The searched descriptors are transposed into blocks of `LANES`, so that one lane is one descriptor. Queries go in
//! groups that stay in the nearest cache with one block; `TILE` of them share each load of it. Each product serves both
//! ways: the mutual check needs no second search. Ties go to the lowest index, for any number of threads.

use super::params::MatchParams;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::{detector::Descriptor, error::Result};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A pair of features whose descriptors match.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Match {
    /// Index of the feature in image A.
    pub a: usize,
    /// Index of the feature in image B.
    pub b: usize,
    /// Euclidean distance of the descriptors: 0 … 2885, and up to about 724 for the detector's, of length 512.
    pub distance: f32,
    /// Ratio of that distance to the one to the second nearest descriptor among those that were compared, 0 … 1; with
    /// the mutual check the larger of the two images' ratios. `None` without a second, and 1 where both are 0.
    pub ratio: Option<f32>,
    /// How it was predicted by its motion; `None` for a sure match, of descriptors among all of both images.
    pub predicted: Option<Predicted>,
}

/// A match found at the place that the motion predicts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Predicted {
    /// Number of places in B that were compared.
    pub among: usize,
    /// Ratio of its distance to that of the nearest other descriptor in all of B, with the mutual check the larger of
    /// both ways: above 1 where another one is nearer, and infinite where that one is equal. `None` without another.
    pub ratio_among_all: Option<f32>,
}

impl Match {
    /// Uncertainty by which the search for a geometry ranks it: its ratio, 0 where nothing competed.
    pub fn rank(&self) -> f32 {
        self.ratio.unwrap_or(0.0)
    }

    /// Its ratios with the digits `digits`, and among how many: "0.483 among 5; 0.84 among all".
    pub fn ratio_words(&self) -> String {
        let words = |ratio: Option<f32>| ratio.map_or_else(|| "no other".to_owned(), |ratio| format!("{ratio:.2}"));
        match self.predicted {
            None => words(self.ratio),
            Some(Predicted { among, ratio_among_all }) => {
                format!("{} among {among}; {} among all", words(self.ratio), words(ratio_among_all))
            }
        }
    }
}

pub(super) struct Neighbours {
    of_a: Vec<Nearest>,
    of_b: Vec<Nearest>,
}

impl Neighbours {
    pub fn new(a: &[Descriptor], b: &[Descriptor], params: &MatchParams, monitor: &Monitor) -> Result<Self> {
        params.validate()?;
        let (of_a, of_b) = search([a, b], params.mutual, monitor)?;
        Ok(Self { of_a, of_b })
    }

    /// Putative matches in the order of A's descriptors: the nearest in B, if the ratio is at most
    /// [`MatchParams::ratio`], and with [`MatchParams::mutual`] both ways. Of equals the first counts.
    pub fn matches(&self, params: &MatchParams) -> Vec<Match> {
        let back = params.mutual.then_some(|b: usize| Some(self.of_b[b]));
        let candidates = self.of_a.iter().enumerate().filter_map(|(a, nearest)| nearest.matched(a, back));
        candidates.filter(|m| m.rank() <= params.ratio).collect()
    }

    /// Number of features of A that are in none of `matches`, which are in A's order, and fail the mutual check.
    pub fn not_mutual(&self, matches: &[Match]) -> usize {
        let fails = |a: usize, nearest: &Nearest| self.of_b.get(nearest.index).is_some_and(|back| back.index != a);
        let is_lost = |a: usize| matches.binary_search_by_key(&a, |m| m.a).is_err();
        self.of_a.iter().enumerate().filter(|(a, nearest)| fails(*a, nearest) && is_lost(*a)).count()
    }

    pub fn ratio_among_all(&self, m: &Match) -> Option<f32> {
        let to_others = |nearest: &Nearest, partner: usize| match nearest.second_distance_squared {
            second if nearest.index == partner => Some(m.distance / f64::from(second?).sqrt() as f32),
            _ => Some(m.distance / f64::from(nearest.distance_squared).sqrt() as f32),
        };
        let ways = [to_others(&self.of_a[m.a], m.b), self.of_b.get(m.b).and_then(|back| to_others(back, m.a))];
        // Equal descriptors are as near as any other.
        ways.into_iter().flatten().map(|ratio| if ratio.is_nan() { 1.0 } else { ratio }).reduce(f32::max)
    }
}

pub(crate) fn distance_squared(a: &Descriptor, b: &Descriptor) -> u32 {
    a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum()
}

/// Descriptors in a block: one AVX-512 register of `f32`, two of AVX2, four of NEON.
const LANES: usize = 16;
/// Queries that share the loads of a block: as many sums of AVX-512 as it takes to wait for none.
const TILE: usize = 8;
/// Queries of a group: 16 KiB, so that they stay in the nearest cache beside a block of 8 KiB.
const GROUP: usize = 32;
/// Queries of a part of the work, which has states of its own for all that is searched, at least.
const PART: usize = 512;
const PARTS: usize = 64;
const LENGTH: usize = 128;

/// Nearest of the searched descriptors, and the distance of the second nearest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nearest {
    /// Index of the nearest; the lowest of several equally near ones.
    pub index: usize,
    /// Squared Euclidean distance of the nearest, a whole number of at most 128·255².
    pub distance_squared: u32,
    /// Squared distance of the second nearest, at least that of the nearest; `None` where one was searched.
    pub second_distance_squared: Option<u32>,
}

impl Nearest {
    /// The match of feature `a` with its nearest one; `None` where that one's own nearest, given by `back`, is another.
    pub(super) fn matched(&self, a: usize, back: Option<impl Fn(usize) -> Option<Self>>) -> Option<Match> {
        let back = match back {
            Some(back) => back(self.index).filter(|back| back.index == a)?.ratio(),
            None => None,
        };
        let distance = f64::from(self.distance_squared).sqrt() as f32;
        let ratio = [self.ratio(), back].into_iter().flatten().reduce(f32::max);
        Some(Match { a, b: self.index, distance, ratio, predicted: None })
    }

    /// Distance of the nearest over that of the second nearest, 0 … 1: 1 where both are 0. `None` without a second.
    pub fn ratio(&self) -> Option<f32> {
        let ratio = |second| (f64::from(self.distance_squared) / f64::from(second)).sqrt() as f32;
        self.second_distance_squared.map(|second| if second == 0 { 1.0 } else { ratio(second) })
    }
}

/// Nearest ones, one for each query.
pub type Ones = Vec<Nearest>;

/// The nearest and second nearest of `searched`, by Euclidean distance, of each of `queries`; empty if there is none.
pub fn nearest_two(queries: &[Descriptor], searched: &[Descriptor], monitor: &Monitor) -> Result<Ones, Cancelled> {
    Ok(search([queries, searched], false, monitor)?.0)
}

/// [`nearest_two`] of `a` in `b`, and of `b` in `a`, at the cost of one of them.
pub fn nearest_two_both_ways(a: &[Descriptor], b: &[Descriptor], monitor: &Monitor) -> Result<(Ones, Ones), Cancelled> {
    search([a, b], true, monitor)
}

fn search([queries, searched]: [&[Descriptor]; 2], both: bool, monitor: &Monitor) -> Result<(Ones, Ones), Cancelled> {
    monitor.check()?;
    if queries.is_empty() || searched.is_empty() {
        return Ok((Vec::new(), Vec::new()));
    }
    let (arch, finished) = (Arch::new(), AtomicUsize::new(0));
    let blocks: Vec<Block> = searched.par_chunks(LANES).map(Block::new).collect();
    let search_part = |(first, part): (usize, &[Descriptor])| {
        let (mut nearest, mut back) =
            (Vec::with_capacity(part.len()), vec![State::START; blocks.len() * usize::from(both)]);
        for (first, group) in (first..).step_by(GROUP).zip(part.chunks(GROUP)) {
            monitor.check()?;
            let elements = floats_of(group);
            let lengths: Vec<f32> = group.iter().map(|query| squared_length(query) as f32).collect();
            let mut states = [State::START; GROUP];
            for (number, block) in blocks.iter().enumerate() {
                // With a large set each group of queries takes a while.
                if number % 1024 == 1023 {
                    monitor.check()?;
                }
                let (elements, states, lengths) = (&elements, &mut states, &lengths);
                let (numbers, back) = ((first as u32, number as u32), back.get_mut(number));
                arch.dispatch(BlockSearch { elements, lengths, block, numbers, states, back });
            }
            nearest.extend(group.iter().zip(&states).map(|(query, state)| state.nearest(squared_length(query))));
            let done = group.len() + finished.fetch_add(group.len(), Ordering::Relaxed);
            monitor.report(Stage::Match, done as f32 / queries.len() as f32);
        }
        Ok((nearest, back))
    };
    // Few parts, of whole groups: each keeps states for all that is searched.
    let part = queries.len().div_ceil(PARTS).next_multiple_of(GROUP).max(PART);
    let parts = queries.par_chunks(part).enumerate().map(|(index, queries)| search_part((index * part, queries)));
    let (nearest, back): (Vec<_>, Vec<_>) = parts.collect::<Result<Vec<_>, Cancelled>>()?.into_iter().unzip();
    // Joined in order, so that of equally near queries the first stays.
    let back = back
        .into_iter()
        .reduce(|before, later| before.iter().zip(&later).map(|(before, later)| before.with_later(later)).collect());
    let of_lanes =
        back.unwrap_or_default().into_iter().flat_map(|state| (0..LANES).map(move |lane| state.of_lane(lane)));
    let back = searched.iter().zip(of_lanes).map(|(one, nearest)| nearest(squared_length(one))).collect();
    Ok((nearest.concat(), back))
}

fn squared_length(descriptor: &Descriptor) -> u32 {
    descriptor.iter().map(|&x| u32::from(x) * u32::from(x)).sum()
}

struct Block {
    elements: [[f32; LANES]; LENGTH],
    /// |d|² of each; infinite in lanes without a descriptor, which then are never the nearest.
    squared_lengths: [f32; LANES],
}

impl Block {
    fn new(descriptors: &[Descriptor]) -> Self {
        let mut block = Self { elements: [[0.0; LANES]; LENGTH], squared_lengths: [f32::INFINITY; LANES] };
        for (lane, descriptor) in descriptors.iter().enumerate() {
            block.squared_lengths[lane] = squared_length(descriptor) as f32;
            for (row, &element) in block.elements.iter_mut().zip(descriptor) {
                row[lane] = f32::from(element);
            }
        }
        block
    }
}

/// The elements of up to [`GROUP`] queries, `TILE` side by side; missing queries are 0.
fn floats_of(group: &[Descriptor]) -> [[[f32; TILE]; LENGTH]; GROUP / TILE] {
    let mut tiles = [[[0.0; TILE]; LENGTH]; GROUP / TILE];
    for (index, query) in group.iter().enumerate() {
        for (row, &element) in tiles[index / TILE].iter_mut().zip(query) {
            row[index % TILE] = f32::from(element);
        }
    }
    tiles
}

/// Best results so far, lane by lane. Scores are 2·a·b less the squared length of the result: the larger, the nearer.
#[derive(Clone, Copy)]
struct State {
    best: [f32; LANES],
    second: [f32; LANES],
    number: [u32; LANES],
}

impl State {
    const START: Self =
        Self { best: [f32::NEG_INFINITY; LANES], second: [f32::NEG_INFINITY; LANES], number: [0; LANES] };

    #[inline(always)]
    fn update(&mut self, products: &[f32; LANES], squared_lengths: &[f32; LANES], number: u32) {
        // Local copies tell the compiler that nothing overlaps, so that all of this stays in registers.
        let Self { mut best, mut second, number: mut numbers } = *self;
        for l in 0..LANES {
            let score = 2.0 * products[l] - squared_lengths[l];
            // Only a strictly nearer descriptor replaces an earlier one: the lowest index wins.
            let nearer = score > best[l];
            let loser = if nearer { best[l] } else { score };
            second[l] = if loser > second[l] { loser } else { second[l] };
            numbers[l] = if nearer { number } else { numbers[l] };
            best[l] = if nearer { score } else { best[l] };
        }
        *self = Self { best, second, number: numbers };
    }

    fn with_later(&self, later: &Self) -> Self {
        let mut both = *self;
        for l in 0..LANES {
            let loser = if later.best[l] > self.best[l] {
                (both.best[l], both.number[l]) = (later.best[l], later.number[l]);
                self.best[l]
            } else {
                later.best[l]
            };
            both.second[l] = loser.max(self.second[l]).max(later.second[l]);
        }
        both
    }

    fn nearest(&self, squared_length: u32) -> Nearest {
        let index = |lane: usize| self.number[lane] as usize * LANES + lane;
        let mut winner = 0;
        for lane in 1..LANES {
            let nearer = self.best[lane] > self.best[winner];
            if nearer || (self.best[lane] == self.best[winner] && index(lane) < index(winner)) {
                winner = lane;
            }
        }
        let others = (0..LANES).filter(|&lane| lane != winner).map(|lane| self.best[lane]);
        let second = others.fold(self.second[winner], f32::max);
        nearest_of(index(winner), [self.best[winner], second], squared_length)
    }

    /// Nearest of one lane, as a function of the squared length of its descriptor.
    fn of_lane(&self, lane: usize) -> impl Fn(u32) -> Nearest + use<> {
        let (index, scores) = (self.number[lane] as usize, [self.best[lane], self.second[lane]]);
        move |squared_length| nearest_of(index, scores, squared_length)
    }
}

/// Scores are whole numbers of less than 2²⁴ in magnitude, so the distances are exact.
fn nearest_of(index: usize, [best, second]: [f32; 2], squared_length: u32) -> Nearest {
    let distance_squared = |score: f32| (i64::from(squared_length) - score as i64) as u32;
    Nearest {
        index,
        distance_squared: distance_squared(best),
        second_distance_squared: second.is_finite().then(|| distance_squared(second)),
    }
}

struct BlockSearch<'a> {
    elements: &'a [[[f32; TILE]; LENGTH]; GROUP / TILE],
    /// |q|² of the queries that there are.
    lengths: &'a [f32],
    block: &'a Block,
    /// Numbers of the first query and of the block.
    numbers: (u32, u32),
    states: &'a mut [State; GROUP],
    /// Results of each descriptor of the block among the queries, if they are wanted.
    back: Option<&'a mut State>,
}

impl WithSimd for BlockSearch<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        simd.vectorize(
            #[inline(always)]
            || match LANES / S::F32_LANES {
                1 => self.search::<S, TILE, 1>(simd),
                2 => self.search::<S, 4, 2>(simd),
                4 => self.search::<S, 2, 4>(simd),
                _ => self.search::<S, 1, LANES>(simd),
            },
        );
    }
}

impl BlockSearch<'_> {
    /// `QUERIES` at a time, with `REGISTERS` for the lanes of each.
    #[inline(always)]
    fn search<S: Simd, const QUERIES: usize, const REGISTERS: usize>(&mut self, simd: S) {
        let firsts = (0..self.lengths.len()).step_by(QUERIES);
        for first in firsts {
            let (tile, within) = (&self.elements[first / TILE], first % TILE);
            let mut sums = [[simd.splat_f32s(0.0); REGISTERS]; QUERIES];
            for (queries, row) in tile.iter().zip(&self.block.elements) {
                // Loaded once for all queries: the loop waits for arithmetic, not for memory.
                let row = S::as_simd_f32s(row).0;
                for q in 0..QUERIES {
                    let query = simd.splat_f32s(queries[within + q]);
                    for p in 0..REGISTERS {
                        sums[q][p] = simd.mul_add_f32s(query, row[p], sums[q][p]);
                    }
                }
            }
            for (q, &length) in (first..).zip(&self.lengths[first..]).take(QUERIES) {
                let mut products = [0.0f32; LANES];
                S::as_mut_simd_f32s(&mut products).0.copy_from_slice(&sums[q - first]);
                self.states[q].update(&products, &self.block.squared_lengths, self.numbers.1);
                // The same products, seen from the block's descriptors.
                if let Some(back) = &mut self.back {
                    back.update(&products, &[length; LANES], self.numbers.0 + q as u32);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matches(a: &[Descriptor], b: &[Descriptor], params: &MatchParams) -> Vec<Match> {
        Neighbours::new(a, b, params, &Monitor::default()).expect("valid and not cancelled").matches(params)
    }

    fn nearest(queries: &[Descriptor], searched: &[Descriptor]) -> Vec<Nearest> {
        nearest_two(queries, searched, &Monitor::default()).expect("not cancelled")
    }

    fn at(x: u8, y: u8) -> Descriptor {
        let mut descriptor = [0; 128];
        (descriptor[3], descriptor[100]) = (x, y);
        descriptor
    }

    #[test]
    fn the_ratio_test_and_the_mutual_check_do_what_they_say() {
        // A's first has a clear partner; its second lies between two; its third's partner is nearer to the first.
        let a = [at(0, 0), at(100, 0), at(3, 0)];
        let b = [at(1, 0), at(105, 0), at(94, 0), at(255, 255)];
        let pairs = |params: &MatchParams| matches(&a, &b, params).iter().map(|m| (m.a, m.b)).collect::<Vec<_>>();
        let one_way = MatchParams { mutual: false, ..MatchParams::default() };
        assert_eq!(pairs(&one_way), [(0, 0), (2, 0)]);
        assert_eq!(pairs(&MatchParams { ratio: 0.9, ..one_way.clone() }), [(0, 0), (1, 1), (2, 0)]);
        assert_eq!(pairs(&MatchParams::default()), [(0, 0)]);
        assert_eq!(pairs(&MatchParams { ratio: 1.0, ..MatchParams::default() }), [(0, 0), (1, 1)]);
        let found = matches(&a, &b, &one_way)[1];
        assert_eq!((found.distance, found.ratio), (2.0, Some(2.0 / 91.0)));
        // Among A's the nearest to b₀ is 1 away and the second 2.
        assert_eq!(matches(&a, &b, &MatchParams::default())[0].ratio, Some(0.5));
    }

    #[test]
    fn twins_are_ambiguous_and_a_lone_descriptor_is_not() {
        let params = MatchParams { mutual: false, ..MatchParams::default() };
        assert_eq!(matches(&[at(5, 5)], &[at(5, 5), at(5, 5)], &params), []);
        let off = MatchParams { ratio: 1.0, ..params.clone() };
        let twin = Match { a: 0, b: 0, distance: 0.0, ratio: Some(1.0), predicted: None };
        assert_eq!(matches(&[at(5, 5)], &[at(5, 5), at(5, 5)], &off), [twin]);
        assert_eq!(matches(&[at(5, 5)], &[at(5, 9)], &params), [Match { distance: 4.0, ratio: None, ..twin }]);
        let refused = Neighbours::new(&[], &[], &MatchParams { ratio: 0.0, ..params }, &Monitor::default());
        assert!(refused.is_err_and(|error| error.subject == "ratio"));
    }

    fn descriptors(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Descriptor>> {
        let one = prop::array::uniform32(any::<u32>());
        let bytes = |words: [u32; 32]| std::array::from_fn(|i| words[i / 4].to_le_bytes()[i % 4]);
        prop::collection::vec(one.prop_map(bytes), count)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn exchanging_the_images_exchanges_the_sides(a in descriptors(0..50), b in descriptors(0..50), ratio in 0.9f32..=1.0) {
            let params = MatchParams { ratio, mutual: true, ..MatchParams::default() };
            let there = matches(&a, &b, &params);
            let mut back: Vec<Match> = matches(&b, &a, &params).iter().map(|m| Match { a: m.b, b: m.a, ..*m }).collect();
            back.sort_by_key(|m| m.a);
            prop_assert_eq!(there, back);
        }
    }

    fn brute_force(queries: &[Descriptor], searched: &[Descriptor]) -> Vec<Nearest> {
        let nearest = |query: &Descriptor| {
            let mut order: Vec<(u32, usize)> =
                searched.iter().enumerate().map(|(i, b)| (distance_squared(query, b), i)).collect();
            order.sort_unstable();
            let (distance_squared, index) = *order.first()?;
            Some(Nearest { index, distance_squared, second_distance_squared: order.get(1).map(|x| x.0) })
        };
        queries.iter().filter_map(nearest).collect()
    }

    fn coarse(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Descriptor>> {
        let element = prop::sample::select(vec![0u8, 1, 255]);
        let one = (prop::collection::vec(element, 4), any::<u8>()).prop_map(|(few, shift)| {
            let mut descriptor = [0u8; 128];
            few.iter().enumerate().for_each(|(i, &x)| descriptor[(i * 31 + usize::from(shift % 2)) % 128] = x);
            descriptor
        });
        prop::collection::vec(one, count)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn it_is_brute_force_both_ways_and_ties_go_to_the_lowest_index(
            (a, b) in prop_oneof![(descriptors(0..70), descriptors(0..70)), (coarse(0..90), coarse(0..90))],
        ) {
            let both = nearest_two_both_ways(&a, &b, &Monitor::default()).expect("not cancelled");
            prop_assert_eq!(both, (brute_force(&a, &b), brute_force(&b, &a)));
            prop_assert_eq!(nearest(&a, &b), brute_force(&a, &b));
        }
    }

    #[test]
    fn the_extremes_are_exact() {
        let (black, white) = ([0u8; 128], [255u8; 128]);
        let mut nearly = white;
        nearly[127] = 254;
        for searched in [vec![black], vec![white], vec![black, nearly], vec![nearly, white], vec![black; 33]] {
            assert_eq!(nearest(&[black, white, nearly], &searched), brute_force(&[black, white, nearly], &searched));
        }
        let farthest = Nearest { index: 0, distance_squared: 8_323_200, second_distance_squared: None };
        assert_eq!(nearest(&[black], &[white]), [farthest]);
    }

    #[test]
    fn cancelling_leaves_no_result() {
        assert_eq!(nearest_two(&[[0; 128]], &[[1; 128]], &Monitor::cancelled()), Err(Cancelled));
    }

    #[test]
    fn parts_of_the_work_find_what_the_whole_finds() {
        let many = |seed: u64, count: usize| {
            let mut stream = crate::synth::random::Stream::new(seed, 0);
            let mut one = || std::array::from_fn(|_| (4.0 * stream.uniform()) as u8);
            (0..count).map(|_| one()).collect::<Vec<Descriptor>>()
        };
        // More queries than a part, the last of which is none whole.
        let (a, b) = (many(1, 2 * PART + 37), many(2, 150));
        let (of_a, of_b) = nearest_two_both_ways(&a, &b, &Monitor::default()).expect("not cancelled");
        assert_eq!((of_a, of_b), (brute_force(&a, &b), brute_force(&b, &a)));
    }
}
