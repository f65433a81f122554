//! Sampling of matches: the most promising first.
//!
//! PROSAC (Chum and Matas, "Matching with PROSAC", CVPR 2005) draws from the best few matches at first and enlarges
//! that set, until after [`UNIFORM_AFTER`] samples it draws from all matches alike, as plain RANSAC does. If the order
//! by quality is useful, good samples come early; otherwise nothing is lost. The random numbers are ChaCha's, which a
//! seed determines for all time.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Number of samples after which all matches are drawn from. The paper takes ten times as many, more than are drawn
/// here by default.
const UNIFORM_AFTER: f64 = 20_000.0;

/// Sampler of different matches.
pub(super) struct Sampler {
    random: ChaCha8Rng,
    /// Match indices, the most promising first.
    order: Vec<usize>,
    /// Number of first matches that are drawn from.
    open: usize,
    /// Number of samples drawn so far.
    drawn: f64,
    /// The paper's T_n and T'_n: the samples that plain RANSAC would have drawn from the open set, and the sample after
    /// which the set grows.
    expected: f64,
    grows_after: f64,
    size: usize,
}

impl Sampler {
    /// Creates a sampler of `size` matches out of `order`, which begins with the most promising and has at least
    /// `size`.
    pub(super) fn new(order: Vec<usize>, size: usize, seed: u64) -> Self {
        let count = order.len();
        // The samples among the first `size` that UNIFORM_AFTER uniform samples of all matches would hold.
        let expected = (0..size).fold(UNIFORM_AFTER, |t, i| t * (size - i) as f64 / (count - i) as f64);
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            order,
            open: size,
            drawn: 0.0,
            expected,
            grows_after: 1.0,
            size,
        }
    }

    /// Draws the next sample: different matches, as indices.
    pub(super) fn draw(&mut self, sample: &mut [usize]) {
        self.drawn += 1.0;
        let count = self.order.len();
        while self.drawn > self.grows_after && self.open < count {
            let next = self.expected * (self.open + 1) as f64 / (self.open + 1 - self.size) as f64;
            self.grows_after += (next - self.expected).ceil().max(1.0);
            self.expected = next;
            self.open += 1;
        }
        let size = self.size;
        if self.drawn <= self.grows_after && self.open < count {
            // The newest of the open set and others before it: all other samples of the open set were drawn earlier.
            self.distinct(&mut sample[..size - 1], self.open - 1);
            sample[size - 1] = self.open - 1;
        } else {
            self.distinct(&mut sample[..size], self.open);
        }
        for place in sample.iter_mut() {
            *place = self.order[*place];
        }
    }

    /// Fills `places` with different numbers below `below`.
    fn distinct(&mut self, places: &mut [usize], below: usize) {
        for i in 0..places.len() {
            places[i] = loop {
                let number = self.below(below);
                if !places[..i].contains(&number) {
                    break number;
                }
            };
        }
    }

    /// A number below `below`, with equal probabilities up to one part in 2³².
    pub(super) fn below(&mut self, below: usize) -> usize {
        ((u128::from(self.random.next_u64()) * below as u128) >> 64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_of_different_matches_and_begin_with_the_best() {
        let order: Vec<usize> = (0..50).rev().collect();
        let mut sampler = Sampler::new(order, 7, 3);
        let mut sample = [0; 7];
        let mut seen = [0usize; 50];
        for drawn in 0..30_000 {
            sampler.draw(&mut sample);
            let mut sorted = sample;
            sorted.sort_unstable();
            assert!(sorted.windows(2).all(|w| w[0] < w[1]) && sorted[6] < 50, "{sample:?}");
            if drawn == 0 {
                assert_eq!(sorted, [43, 44, 45, 46, 47, 48, 49], "the seven most promising");
            }
            sample.iter().for_each(|&i| seen[i] += 1);
        }
        assert!(seen.iter().all(|&n| n > 1000) && seen[49] > 2 * seen[0], "{seen:?}");
    }

    #[test]
    fn a_set_of_just_one_sample_works_and_a_seed_fixes_all() {
        let mut sample = [0; 4];
        Sampler::new(vec![3, 1, 0, 2], 4, 0).draw(&mut sample);
        sample.sort_unstable();
        assert_eq!(sample, [0, 1, 2, 3]);
        let draws = |seed: u64| {
            let mut sampler = Sampler::new((0..99).collect(), 4, seed);
            let mut sample = [0; 4];
            (0..200)
                .map(|_| {
                    sampler.draw(&mut sample);
                    sample
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(draws(5), draws(5));
        assert_ne!(draws(5), draws(6));
    }
}
