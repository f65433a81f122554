//! Masks of planes: what is hidden has no weight, and a value from around.

use burstscope_core::plane::mask::*;
use burstscope_core::plane::{Mask, Plane};
use burstscope_core::synth::random::Stream;

fn ramp(u: usize, v: usize) -> f32 {
    0.2 + 0.002 * u as f32 + 0.001 * v as f32
}

fn disc(u: usize, v: usize) -> f32 {
    f32::from((u as f32 - 30.0).hypot(v as f32 - 25.0) > 12.0)
}

#[test]
fn hidden_values_follow_their_surroundings_and_seen_ones_stay() {
    let mask = Mask::new(Plane::from_fn(97, 61, disc)).expect("a disc is hidden");
    let mut noise = Stream::new(3, 0);
    let frame = Plane::from_fn(97, 61, |u, v| if disc(u, v) > 0.0 { ramp(u, v) } else { f32::NAN });
    let noisy = Plane::from_fn(97, 61, |u, v| frame.at(u, v) + 0.05 * noise.normal() as f32);
    let (filled, of_noisy) = (frame.clone().masked(Some(mask.clone())), noisy.clone().masked(Some(mask.clone())));
    let mut largest = [0.0f32; 2];
    for (u, v) in (0..61).flat_map(|v| (0..97).map(move |u| (u, v))) {
        if disc(u, v) > 0.0 {
            assert_eq!((filled.at(u, v), of_noisy.at(u, v)), (frame.at(u, v), noisy.at(u, v)));
        } else {
            let off = [&filled, &of_noisy].map(|plane| (plane.at(u, v) - ramp(u, v)).abs());
            largest = [0, 1].map(|i| largest[i].max(off[i]));
        }
    }
    assert!(largest[0] < 0.02 && largest[1] < 0.06, "{largest:?}");
    assert_eq!((mask.span(25), mask.span(40)), (18..43, 0..0));
}

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
