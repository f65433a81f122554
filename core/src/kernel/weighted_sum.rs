//! The weighted sum of rows that makes a motion-stack image, and the sample of a single pixel at the border.

use super::offset::FrameOffset;
use crate::plane::Plane;
use crate::plane::blocks::{BlockSize, LARGE, SMALL, for_blocks};
use multiversion::multiversion;

/// The bilinear sample of `frame` for pixel (u, v); beyond the frame the nearest pixel.
pub(crate) fn sample_clamped(frame: &Plane, offset: &FrameOffset, u: usize, v: usize) -> f32 {
    let (width, height) = frame.size();
    let at = |du: i64, dv: i64| {
        let x = (u as i64 + offset.whole_u + du).clamp(0, width as i64 - 1);
        let y = (v as i64 + offset.whole_v + dv).clamp(0, height as i64 - 1);
        frame.data()[y as usize * width + x as usize]
    };
    let upper = (1.0 - offset.part_u) * at(0, 0) + offset.part_u * at(1, 0);
    let lower = (1.0 - offset.part_u) * at(0, 1) + offset.part_u * at(1, 1);
    (1.0 - offset.part_v) * upper + offset.part_v * lower
}

/// `B` values of the weighted sum, from `start` on, held in registers.
#[inline(always)]
fn weighted_block<const B: usize>(taps: &[(&[f32], f32)], scale: f32, start: usize, out: &mut [f32]) {
    let mut acc = [0.0f32; B];
    for &(row, weight) in taps {
        let row: &[f32; B] = row[start..start + B].try_into().expect("a block");
        for i in 0..B {
            acc[i] = weight.mul_add(row[i], acc[i]);
        }
    }
    acc.iter_mut().for_each(|x| *x *= scale);
    out[start..start + B].copy_from_slice(&acc);
}

/// `out = scale·Σ weight·row`, over `(row, weight)`; each row is at least as long as `out`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
pub(crate) fn weighted_sum(taps: &[(&[f32], f32)], scale: f32, out: &mut [f32]) {
    for_blocks(
        out.len(),
        #[inline(always)]
        |start, size| match size {
            BlockSize::Large => weighted_block::<LARGE>(taps, scale, start, out),
            BlockSize::Small => weighted_block::<SMALL>(taps, scale, start, out),
            BlockSize::One => weighted_block::<1>(taps, scale, start, out),
        },
    );
}
