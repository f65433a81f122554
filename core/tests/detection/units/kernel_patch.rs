//! Tests of `kernel::patch`.
#![allow(unused_imports)]

use burstscope_core::plane::*;
use burstscope_core::plane::blur::*;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;
use burstscope_core::burst::Positions;
use burstscope_core::detector::params::{Interpolation, Slope};
use burstscope_core::detector::scale_space::Base;
use burstscope_core::detector::stack::frame_offsets;
use burstscope_core::kernel::patch::PatchScratch;
use burstscope_core::plane::blur::gaussian_blur;

#[test]
fn patches_are_cut_from_the_stacked_image_and_repeat_its_border() {
    let frames = [0, 1, 2, 3]
        .map(|t| Plane::from_fn(97, 61, |u, v| ((u * 31 + v * 17 + t * 7 + (u * v) % 13) % 29) as f32 / 29.0));
    let frames: Vec<&Plane> = frames.iter().collect();
    let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
    for slope in [Slope::new(0.0, 0.0), Slope::new(1.3, 0.0), Slope::new(-0.6, 2.2)] {
        let offsets = frame_offsets(&Positions::even(4), slope, Interpolation::Linear);
        for (octave, size) in [(0, (97, 61)), (-1, (194, 122)), (1, (48, 30))] {
            let base = Base::Frames { frames: &frames, offsets: &offsets, octave };
            let mut whole = Plane::zeros(size.0, size.1);
            let mut row = Vec::new();
            base.raw_rows(0..size.1, 0..size.0, &mut row, |v, row| whole.row_mut(v).copy_from_slice(row));
            for (u, v, radius) in [(40, 25, 15), (20, 14, 20), (2, 1, 9), (47, 29, 12), (44, 22, 60)] {
                let (columns, rows) = (u - radius..u + radius + 1, v - radius..v + radius + 1);
                base.patch(size, columns.clone(), rows.clone(), &mut scratch, &mut patch);
                let nearest = |x: i64, n: usize| x.clamp(0, n as i64 - 1) as usize;
                let middle = whole.at(nearest(u, size.0), nearest(v, size.1));
                for y in rows {
                    for (x, value) in columns.clone().zip(patch.row(y)) {
                        let expected = whole.at(nearest(x, size.0), nearest(y, size.1)) - middle;
                        assert!((value - expected).abs() < 1e-6, "{octave} {slope:?} ({x}, {y})");
                    }
                }
            }
        }
    }
}

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

