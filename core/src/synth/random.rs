//! Random numbers that are the same on every machine.
//!
//! The generator is ChaCha with 8 rounds, whose output never changes. The distributions use only additions,
//! multiplications, square roots and `libm`, so that no system's mathematics library can change a pixel.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use std::sync::LazyLock;

/// One independent stream of random numbers.
#[derive(Debug, Clone)]
pub struct Stream {
    generator: ChaCha8Rng,
}

impl Stream {
    /// Stream number `stream` of `seed`. Different streams of one seed are independent.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Self { generator }
    }

    /// A number uniform in [0, 1), with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// A number uniform in [low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A whole number, uniform in 0 … count−1; 0 for a count of 0.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// A Gaussian number with mean 0 and variance 1, by the ziggurat of G. Marsaglia and W. W. Tsang, "The ziggurat
    /// method for generating random variables", Journal of Statistical Software 5(8) (2000).
    pub fn normal(&mut self) -> f64 {
        let ziggurat = &*ZIGGURAT;
        loop {
            let bits = self.generator.next_u64();
            // Seven bits choose a block, 53 others the position in it.
            let block = (bits & 127) as usize;
            let place = 2.0 * ((bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)) - 1.0;
            let edge = ziggurat.edges[block];
            if place.abs() < ziggurat.ratios[block] {
                return place * edge;
            }
            if block == 0 {
                return self.normal_tail(place < 0.0);
            }
            let x = place * edge;
            // In the wedge beside the block: a height between its edges is compared with the curve.
            let upper = libm::exp(-0.5 * (edge * edge - x * x));
            let inner = ziggurat.edges[block + 1];
            let lower = libm::exp(-0.5 * (inner * inner - x * x));
            if lower + self.uniform() * (upper - lower) < 1.0 {
                return x;
            }
        }
    }

    fn normal_tail(&mut self, negative: bool) -> f64 {
        loop {
            // 1 − uniform() is never 0, whose logarithm would be infinite.
            let x = -libm::log(1.0 - self.uniform()) / TAIL_START;
            let y = -libm::log(1.0 - self.uniform());
            if 2.0 * y >= x * x {
                return if negative { -TAIL_START - x } else { TAIL_START + x };
            }
        }
    }

    /// A Poisson number with the given mean; 0 for a mean of 0 or below. Exact for any mean: inversion for small ones,
    /// the transformed rejection of W. Hörmann, "The transformed rejection method for generating Poisson random
    /// variables", Insurance: Mathematics and Economics 12 (1993), 39–45, for large ones.
    pub fn poisson(&mut self, mean: f64) -> f64 {
        if mean <= 0.0 {
            0.0
        } else if mean < 24.0 {
            self.poisson_by_inversion(mean)
        } else {
            self.poisson_by_rejection(mean)
        }
    }

    fn poisson_by_inversion(&mut self, mean: f64) -> f64 {
        let u = self.uniform();
        let mut count = 0u8;
        let mut probability = libm::exp(-mean);
        let mut cumulative = probability;
        // Rounding may leave the sum slightly below 1; far in the tail the probability vanishes and the loop must end.
        while u >= cumulative && count < 199 {
            count += 1;
            probability *= mean * (1.0 / f64::from(count));
            cumulative += probability;
        }
        f64::from(count)
    }

    fn poisson_by_rejection(&mut self, mean: f64) -> f64 {
        let b = 0.931 + 2.53 * mean.sqrt();
        let a = -0.059 + 0.02483 * b;
        let inverse_alpha = 1.1239 + 1.1328 / (b - 3.4);
        let v_r = 0.9277 - 3.6224 / (b - 2.0);
        let log_mean = libm::log(mean);
        loop {
            let u = self.uniform() - 0.5;
            let v = self.uniform();
            let us = 0.5 - u.abs();
            if us <= 0.0 {
                continue;
            }
            let count = ((2.0 * a / us + b) * u + mean + 0.43).floor();
            // Most numbers are accepted here, without a logarithm.
            if us >= 0.07 && v <= v_r {
                return count;
            }
            if count < 0.0 || (us < 0.013 && v > us) {
                continue;
            }
            let accept = libm::log(v * inverse_alpha / (a / (us * us) + b));
            if accept <= count * log_mean - mean - libm::lgamma(count + 1.0) {
                return count;
            }
        }
    }
}

/// End of the ziggurat's blocks and start of the tail, for 128 blocks.
const TAIL_START: f64 = 3.442_619_855_899;
const BLOCK_AREA: f64 = 9.912_563_035_262_17e-3;

struct Ziggurat {
    /// Right edge of each block; the last one is 0.
    edges: [f64; 129],
    /// The part of each block that is under the curve at any height.
    ratios: [f64; 128],
}

static ZIGGURAT: LazyLock<Ziggurat> = LazyLock::new(|| {
    let mut edges = [0.0; 129];
    let mut height = libm::exp(-0.5 * TAIL_START * TAIL_START);
    edges[0] = BLOCK_AREA / height;
    edges[1] = TAIL_START;
    for i in 2..128 {
        edges[i] = (-2.0 * libm::log(BLOCK_AREA / edges[i - 1] + height)).sqrt();
        height = libm::exp(-0.5 * edges[i] * edges[i]);
    }
    Ziggurat { edges, ratios: std::array::from_fn(|i| edges[i + 1] / edges[i]) }
});

/// A fixed pseudo-random value in [0, 1) for a lattice point, on which procedural textures are based.
pub fn lattice(seed: u64, i: i64, j: i64) -> f32 {
    let mut x = seed
        ^ (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (j as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F).rotate_left(31);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^= x >> 31;
    (x >> 40) as f32 * (1.0 / (1u64 << 24) as f32)
}
