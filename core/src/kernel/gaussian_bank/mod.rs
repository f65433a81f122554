//! A bank of Gaussian filters: all levels of an octave straight from its first pixels.
//!
//! The scale space is defined as a chain: each level is blurred from the one before it. Blurs add up, so every level is
//! also one blur of the chain's input, by the convolution of the kernels so far. That way a level costs more
//! multiplications, but levels no longer wait for one another: one pass along the rows makes all of them with each
//! pixel loaded once, a second one along the columns finishes them, and all intermediate values stay in the nearest
//! caches.
//!
//! Numerics. A level's kernel is the exact convolution of the chain's kernels, cut at [`LEVEL_CUT`] standard deviations
//! and normalised to sum 1. Near the border the chain repeats the nearest pixel of every level in turn, which differs
//! from repeating the nearest pixel of the input; there the weights are taken from the chain's own matrix (`edge`), so
//! that the result is the chain's everywhere. Every value is made by the same operations in the same order wherever it
//! lies in a tile, so results do not depend on tiles and threads, to the bit.

mod band;
mod edge;
mod filter;
mod horizontal;
mod kernel;
mod lanes;
mod vertical;

pub use edge::Axis;
pub use filter::{FilterScratch, Lines, filter_tile};

use crate::plane::blur::GaussianKernel;
use edge::Edges;
use kernel::Kernel;
use std::ops::Range;

/// Radius of a level's kernel, in its standard deviations: beyond it lie 7 millionths of its weight.
pub const LEVEL_CUT: f64 = 4.5;

/// Filters that make some consecutive levels of a chain of blurs.
#[derive(Debug)]
pub struct FilterBank {
    chain: Vec<GaussianKernel>,
    /// Range of the chain's levels that are made.
    wanted: Range<usize>,
    kernels: Vec<Kernel>,
    /// The weights near a border that is far from the opposite one.
    edges: Edges,
}

impl FilterBank {
    /// Filters for the levels `wanted` of `chain`: level `i` is the input blurred by `chain[0]` … `chain[i]` in turn.
    pub fn new(chain: Vec<GaussianKernel>, wanted: Range<usize>) -> Self {
        let kernels: Vec<Kernel> = kernel::composed(&chain, LEVEL_CUT).drain(wanted.clone()).collect();
        let edges = Edges::far_apart(&chain, &wanted, &kernels);
        Self { chain, wanted, kernels, edges }
    }

    /// Number of levels that the bank makes.
    pub fn len(&self) -> usize {
        self.kernels.len()
    }

    /// Whether the bank makes no level.
    pub fn is_empty(&self) -> bool {
        self.kernels.is_empty()
    }

    /// Pixels to each side that a value of any level depends on.
    pub fn radius(&self) -> usize {
        self.kernels.iter().map(Kernel::radius).max().unwrap_or(0)
    }
}
