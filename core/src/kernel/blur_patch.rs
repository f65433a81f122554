//! Blur of the pixels around a feature to the Gaussian level on which it is described.
//!
//! One blur to a level equals the levels' chain of blurs up to the kernels' cut. A few rows are combined from the rows
//! around them, then convolved, so that the intermediate values stay in the nearest cache.

use super::machine::PATCH_ROWS_TOGETHER as TOGETHER;
use crate::kernel::patch::{LANES, Patch};
use crate::kernel::vectors::{load, store};
use crate::plane::aligned::Aligned;
use crate::plane::blur::GaussianKernel;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Buffer for the values between the passes; reused from patch to patch.
#[derive(Debug, Default)]
pub struct BlurScratch(Aligned);

impl Patch {
    /// Blurs columns `columns` and rows `rows` (at least four) by `kernel` into `out`. The patch must extend beyond
    /// them by the kernel's radius.
    ///
    /// # Panics
    /// When it does not, or when there are fewer rows.
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
        assert!(self.columns().start <= left && self.columns().end >= columns.end + radius, "the patch is wide enough");
        assert!(self.rows().start <= top && self.rows().end >= rows.end + radius, "the patch is high enough");
        // Vectors that begin at cache lines.
        let skipped = (left - self.columns().start) as usize % LANES;
        let (width, count) = (columns.clone().count(), rows.clone().count());
        assert!(count >= TOGETHER, "{count} rows are too few");
        out.reset(columns.clone(), rows.clone());
        let stride = out.stride();
        let band_stride = (skipped + width + 2 * kernel.radius()).next_multiple_of(LANES);
        scratch.0.grow(TOGETHER * band_stride + LANES);
        Arch::new().dispatch(BlurRows {
            from: self.values(left - skipped as i64, top),
            from_stride: self.stride(),
            half: kernel.half(),
            band: &mut scratch.0,
            band_stride,
            skipped,
            out: out.values_mut(columns.start, rows.start),
            stride,
            columns: width,
            rows: count,
        });
    }
}

/// Rows blurred by the kernel whose centre and right half are `half`.
struct BlurRows<'a> {
    /// Begins a radius above the first pixel, and a radius and `skipped` columns to the left of it; rows `from_stride`
    /// apart.
    from: &'a [f32],
    from_stride: usize,
    half: &'a [f32],
    /// Combined rows `band_stride` apart, beginning at the columns where `from` does.
    band: &'a mut [f32],
    band_stride: usize,
    skipped: usize,
    /// Rows `stride` apart, written in whole vectors.
    out: &'a mut [f32],
    stride: usize,
    columns: usize,
    rows: usize,
}

impl WithSimd for BlurRows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for first in (0..self.rows).step_by(TOGETHER) {
            // The last rows overlap those before them.
            let first = first.min(self.rows - TOGETHER);
            let from = &self.from[first * self.from_stride..];
            for u in (0..self.band_stride).step_by(S::F32_LANES) {
                combine(simd, self.half, &from[u..], self.from_stride, &mut self.band[u..], self.band_stride);
            }
            for v in 0..TOGETHER {
                let line = &self.band[v * self.band_stride + self.skipped..];
                let out = &mut self.out[(first + v) * self.stride..];
                let mut u = 0;
                while u + S::F32_LANES < self.columns {
                    convolve::<S, 2>(simd, self.half, &line[u..], &mut out[u..]);
                    u += 2 * S::F32_LANES;
                }
                if u < self.columns {
                    convolve::<S, 1>(simd, self.half, &line[u..], &mut out[u..]);
                }
            }
        }
    }
}

/// Combines one vector of [`TOGETHER`] rows: Σ taps·values over a symmetric kernel. `from` begins at the first row that
/// the first one reads.
#[inline(always)]
fn combine<S: Simd>(simd: S, half: &[f32], from: &[f32], stride: usize, out: &mut [f32], out_stride: usize) {
    let radius = half.len() - 1;
    let tap = simd.splat_f32s(half[0]);
    let (mut above, mut sums) = ([tap; TOGETHER], [tap; TOGETHER]);
    for i in 0..TOGETHER {
        above[i] = load::<S>(from, (radius + i) * stride);
        sums[i] = simd.mul_f32s(tap, above[i]);
    }
    let mut below = above;
    // One tap farther, the rows needed are those already loaded, shifted by one, and a new one.
    let mut distance = 1;
    macro_rules! step {
        () => {
            let tap = simd.splat_f32s(half[distance]);
            for i in (1..TOGETHER).rev() {
                above[i] = above[i - 1];
            }
            for i in 1..TOGETHER {
                below[i - 1] = below[i];
            }
            above[0] = load::<S>(from, (radius - distance) * stride);
            below[TOGETHER - 1] = load::<S>(from, (radius + distance + TOGETHER - 1) * stride);
            for i in 0..TOGETHER {
                sums[i] = simd.mul_add_f32s(tap, simd.add_f32s(above[i], below[i]), sums[i]);
            }
            distance += 1;
        };
    }
    while distance + 3 < half.len() {
        step!();
        step!();
        step!();
        step!();
    }
    while distance < half.len() {
        step!();
    }
    for (i, &sum) in sums.iter().enumerate() {
        store::<S>(out, i * out_stride, sum);
    }
}

/// Convolves `V` vectors: Σ taps·values over a symmetric kernel; `line` begins at the first value under the first tap.
#[inline(always)]
fn convolve<S: Simd, const V: usize>(simd: S, half: &[f32], line: &[f32], out: &mut [f32]) {
    let (radius, read) = (half.len() - 1, V * S::F32_LANES);
    let tap = simd.splat_f32s(half[0]);
    let mut sums = [tap; V];
    for (i, sum) in sums.iter_mut().enumerate() {
        *sum = simd.mul_f32s(tap, load::<S>(line, radius + i * S::F32_LANES));
    }
    // Iterators need no bounds checks in the loop.
    let before = line[..radius + read - 1].windows(read).rev();
    let after = line[radius + 1..2 * radius + read].windows(read);
    for ((before, after), &tap) in before.zip(after).zip(&half[1..]) {
        let tap = simd.splat_f32s(tap);
        for (i, sum) in sums.iter_mut().enumerate() {
            let at = i * S::F32_LANES;
            *sum = simd.mul_add_f32s(tap, simd.add_f32s(load::<S>(before, at), load::<S>(after, at)), *sum);
        }
    }
    for (i, &sum) in sums.iter().enumerate() {
        store::<S>(out, i * S::F32_LANES, sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::scale_space::octave::Base;
    use crate::kernel::patch::PatchScratch;
    use crate::plane::Plane;
    use crate::plane::blur::gaussian_blur;

    #[test]
    fn a_patch_is_blurred_as_the_whole_image_is() {
        let plane = Plane::from_fn(130, 90, |u, v| ((u * 31 + v * 17 + (u * v) % 13) % 29) as f32 / 29.0);
        let (mut raw, mut blurred) = (Patch::default(), Patch::default());
        for (sigma, (left, top), (width, height)) in
            [(0.0, (20, 20), (40, 7)), (1.2, (0, 3), (17, 30)), (2.7, (61, 50), (66, 36))]
        {
            let kernel = GaussianKernel::new(sigma);
            let whole = gaussian_blur(&plane, &kernel);
            let (columns, rows) = (left..left + width, top..top + height);
            // A little more than is needed, on one side even more.
            let reach = kernel.radius() as i64 + 1;
            let (wide, tall) = (columns.start - reach - 3..columns.end + reach, rows.start - reach..rows.end + reach);
            let middle = plane.at(((wide.start + wide.end) / 2) as usize, ((tall.start + tall.end) / 2) as usize);
            Base::Level(&plane).patch((130, 90), wide, tall, &mut PatchScratch::default(), &mut raw);
            raw.blurred(columns.clone(), rows.clone(), &kernel, &mut BlurScratch::default(), &mut blurred);
            for v in rows {
                for (u, value) in columns.clone().zip(blurred.row(v)) {
                    let expected = whole.at((u as usize).min(129), (v as usize).min(89)) - middle;
                    assert!(u > 129 || v > 89 || (value - expected).abs() < 1e-5, "({u}, {v}): {value} {expected}");
                }
            }
        }
    }
}
