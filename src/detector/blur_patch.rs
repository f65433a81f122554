//! From the pixels around a feature to the Gaussian level on which it is described.
//!
//! One blur to a level equals the levels' chain of blurs up to the kernels' cut. Each row is combined from the rows around it and then convolved, so that what
//! lies between the two passes is one row.

use super::patch::{Block, LANES, Patch, in_blocks, room};
use crate::plane::blur::GaussianKernel;
use multiversion::multiversion;
use std::ops::Range;

/// Space for one row between the passes; reused from patch to patch.
#[derive(Debug, Default)]
pub struct BlurScratch(Vec<Block>);

impl Patch {
    /// Columns `columns` and rows `rows` blurred by `kernel`, into `out`. The patch must reach farther by the kernel's radius.
    ///
    /// # Panics
    /// When it doesn't.
    pub fn blurred(
        &self,
        columns: Range<i64>,
        rows: Range<i64>,
        kernel: &GaussianKernel,
        scratch: &mut BlurScratch,
        out: &mut Self,
    ) {
        let radius = kernel.radius() as i64;
        let (left, top) = (columns.start - radius, rows.start - radius);
        assert!(self.columns().end >= columns.end + radius, "the patch reaches far enough");
        assert!(self.rows().end >= rows.end + radius, "the patch reaches far enough");
        let (width, count) = (columns.clone().count(), rows.clone().count());
        out.reset(columns.clone(), rows.clone());
        let stride = out.stride();
        let combined = room(&mut scratch.0, width + 2 * kernel.radius() + 2 * LANES);
        let from = (self.from(left, top), self.stride());
        blur_rows(from, kernel.half(), (width, count), combined, out.from_mut(columns.start, rows.start), stride);
    }
}

/// Blurs `rows` rows of `columns` pixels by the kernel whose centre and right half are `half`. `from` begins a radius above and to the left of the first one; the rows of `out` lie
/// `stride` apart and are written in whole vectors.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn blur_rows(
    (from, from_stride): (&[f32], usize),
    half: &[f32],
    (columns, rows): (usize, usize),
    combined: &mut [f32],
    out: &mut [f32],
    stride: usize,
) {
    let radius = half.len() - 1;
    for v in 0..rows {
        let values = &from[v * from_stride..];
        in_blocks!(u, columns + 2 * radius, V, {
            symmetric_sum::<V>(half, |k| &values[k * from_stride + u..], &mut combined[u..]);
        });
        let out = &mut out[v * stride..];
        in_blocks!(u, columns, V, symmetric_sum::<V>(half, |k| &combined[u + k..], &mut out[u..]));
    }
}

/// `V` vectors of Σ taps·values over a symmetric kernel; `at(k)` gives the values under tap `k`, counted from the kernel's first.
#[inline(always)]
fn symmetric_sum<'a, const V: usize>(half: &[f32], at: impl Fn(usize) -> &'a [f32], out: &mut [f32]) {
    let radius = half.len() - 1;
    #[inline(always)]
    fn vectors<const V: usize>(values: &[f32]) -> &[[f32; LANES]] {
        values[..V * LANES].as_chunks().0
    }
    let (mut sums, centre) = ([[0.0f32; LANES]; V], vectors::<V>(at(radius)));
    for j in 0..V {
        for i in 0..LANES {
            sums[j][i] = half[0] * centre[j][i];
        }
    }
    for (k, &tap) in half.iter().enumerate().skip(1) {
        let (a, b) = (vectors::<V>(at(radius - k)), vectors::<V>(at(radius + k)));
        for j in 0..V {
            for i in 0..LANES {
                sums[j][i] = tap.mul_add(a[j][i] + b[j][i], sums[j][i]);
            }
        }
    }
    out[..V * LANES].copy_from_slice(sums.as_flattened());
}
