//! Loads and stores of one vector at any place of a row.

pub(crate) use crate::kernel::machine::{BLOCK_COLUMNS as BLOCK, WIDEST_VECTOR as VECTOR};
use pulp::Simd;

/// `n` rounded up to whole blocks.
pub(crate) fn whole_blocks(n: usize) -> usize {
    n.next_multiple_of(BLOCK)
}

/// The vector that begins at `row[at]`.
#[inline(always)]
pub(crate) fn load<S: Simd>(row: &[f32], at: usize) -> S::f32s {
    S::as_simd_f32s(&row[at..at + S::F32_LANES]).0[0]
}

/// Writes a vector to `row[at..]`.
#[inline(always)]
pub(crate) fn store<S: Simd>(row: &mut [f32], at: usize, value: S::f32s) {
    S::as_mut_simd_f32s(&mut row[at..at + S::F32_LANES]).0[0] = value;
}
