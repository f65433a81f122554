//! Tests of `detector::combine`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::*;
use burstscope_core::detector::combine::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::stack::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use proptest::prelude::*;

#[test]
fn every_way_is_its_definition() {
    let of = |values: &[f32]| Combine::ALL.map(|combine| combine.of_sorted(values));
    assert_eq!(of(&[3.0]), [3.0, 3.0, 3.0, 3.0, 3.0, 0.0, 0.0]);
    let deviation = (2.0f32 * (1.5 * 1.5 + 0.5 * 0.5) / 3.0).sqrt();
    assert_eq!(of(&[1.0, 2.0, 3.0, 4.0]), [2.5, 2.5, 2.5, 4.0, 1.0, deviation, 0.0]);
    // The quartiles are 1 and 2, so what is farther from 1.5 than 1.9 does not count.
    assert_eq!(of(&[1.0, 1.0, 2.0, 12.0])[2], 4.0 / 3.0);
}


