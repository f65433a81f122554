//! Conversion of the sums in the cells to the bytes of a descriptor.

use super::cells::{BINS, DIRECTIONS};
use crate::detector::feature::Descriptor;
use crate::kernel::patch::LANES;
use multiversion::multiversion;

/// Sum of `f` over the bins, in as many partial sums as a vector has lanes.
#[inline(always)]
fn sum_of(bins: &[f32; BINS], f: impl Fn(f32) -> f32) -> f32 {
    let mut sums = [0.0f32; LANES];
    for vector in bins.chunks_exact(LANES) {
        for i in 0..LANES {
            sums[i] += f(vector[i]);
        }
    }
    sums.iter().sum()
}

/// Scales the bins to a Euclidean length of 1, unless all are 0.
#[inline(always)]
fn normalise(bins: &mut [f32; BINS]) {
    let norm = sum_of(bins, |x| x * x).sqrt();
    if norm > 0.0 {
        bins.iter_mut().for_each(|x| *x /= norm);
    }
}

/// Converts the 128 sums to bytes, in UBC/COLMAP's order: within each cell the directions run the other way round than
/// VLFeat's, the first stays.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn quantise(mut bins: [f32; BINS]) -> Descriptor {
    normalise(&mut bins);
    bins.iter_mut().for_each(|x| *x = x.min(0.2));
    normalise(&mut bins);
    let sum = sum_of(&bins, |x| x);
    if sum <= 0.0 {
        return [0; BINS];
    }
    let scaled = bins.map(|x| ((x / sum).sqrt() * 512.0 + 0.5).min(255.0) as i32 as u8);
    to_vlfeat_order(&scaled)
}

/// Converts a descriptor to VLFeat's order; its own inverse.
pub fn to_vlfeat_order(descriptor: &Descriptor) -> Descriptor {
    let mut out = [0; BINS];
    for (out, cell) in out.chunks_exact_mut(DIRECTIONS).zip(descriptor.chunks_exact(DIRECTIONS)) {
        for (direction, out) in out.iter_mut().enumerate() {
            *out = cell[(DIRECTIONS - direction) % DIRECTIONS];
        }
    }
    out
}
