//! Tests of `detector::stack`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::stack::*;
use burstscope_core::detector::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::Mask;
use burstscope_core::plane::*;
use proptest::prelude::*;
use rayon::prelude::*;
use std::borrow::Borrow;
use std::ops::Range;

#[test]
fn a_moving_point_is_where_it_was_at_mid_burst() {
    let frames: Vec<Plane> =
        (0..5).map(|t| Plane::from_fn(40, 20, |u, v| f32::from(u == 10 + 2 * t && v == 15 - t))).collect();
    let frames: Vec<&Plane> = frames.iter().collect();
    let (slope, monitor) = (Slope::new(2.0, -1.0), Monitor::default());
    let stack =
        motion_stack(&frames, &Positions::even(5), slope, Interpolation::Linear, &monitor).expect("not cancelled");
    assert_eq!(stack.at(14, 13), 1.0);
    assert_eq!(stack.data().iter().filter(|&&x| x != 0.0).count(), 1);
}
