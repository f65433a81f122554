//! Tests of `kernel::stack`.
#![allow(unused_imports)]

use burstscope_core::plane::*;
use multiversion::multiversion;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

#[test]
fn rows_of_any_length_have_the_bits_of_short_ones() {
    let frames: Vec<Vec<f32>> =
        (0..3).map(|t| (0..400).map(|i| ((i * 31 + t * 7 + i * i % 11) % 29) as f32 / 29.0).collect()).collect();
    let mut maker = WeightedRows::default();
    for parts in [[0.0, 0.0, 0.0], [0.5, 0.5, 0.5], [0.0, 0.3, 0.9]] {
        let taps: Vec<Tap<'_>> =
            frames.iter().zip(parts).map(|(frame, part)| Tap::new(&frame[3..], 1.0 / 3.0, part)).collect();
        for columns in [1, 15, 16, 17, 33, 100, 129] {
            let mut out = vec![f32::NAN; 2 * 131];
            maker.make(&taps, 133, columns, 1..3, &mut out, 131);
            for (v, row) in out.chunks(131).enumerate() {
                let mut expected = vec![0.0; columns];
                short_row(&taps, (v + 1) * 133, Between::of(&taps), &mut expected);
                assert_eq!(row[..columns], expected, "{parts:?} {columns}");
                // No other values are written.
                assert!(row[columns..].iter().all(|x| x.is_nan()), "{parts:?} {columns}");
            }
        }
    }
}

