//! Tests of `plane::mask`.
#![allow(unused_imports)]

use burstscope_core::plane::mask::*;
use burstscope_core::plane::sample::*;
use burstscope_core::plane::statistics::*;
use burstscope_core::plane::*;
use burstscope_core::synth::random::Stream;
use std::ops::Range;
use std::sync::Arc;

#[test]
fn a_transposed_frame_is_filled_as_the_frame_is() {
    let mut noise = Stream::new(5, 0);
    let frame = Plane::from_fn(53, 38, |_, _| noise.normal() as f32);
    let transposed = |plane: &Plane| Plane::from_fn(plane.height(), plane.width(), |u, v| plane.at(v, u));
    let weights = Plane::from_fn(53, 38, |u, v| f32::from((u * 7 + v * 3) % 11 > 4 && u < 40));
    let of = |frame: Plane, weights: Plane| frame.masked(Mask::new(weights));
    let (one, other) = (of(frame.clone(), weights.clone()), of(transposed(&frame), transposed(&weights)));
    let apart = transposed(&one).data().iter().zip(other.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart < 1e-5, "{apart}");
    assert_eq!(transposed(one.mask().expect("masked").weights()), *other.mask().expect("masked").weights());
}

#[test]
fn a_mask_of_nothing_is_none_and_one_of_everything_fills_with_nothing() {
    assert_eq!(Mask::new(Plane::from_fn(9, 7, |_, _| 1.0)), None);
    let blind = Plane::from_fn(9, 7, |_, _| f32::NAN).masked(Mask::new(Plane::zeros(9, 7)));
    assert!(blind.data().iter().all(|x| *x == 0.0));
}
