//! Tests of `matching::align::solve`.
#![allow(unused_imports)]

use burstscope_core::matching::align::pair::*;
use burstscope_core::matching::align::solve::*;
use burstscope_core::matching::align::*;
use burstscope_core::matching::*;
use burstscope_core::monitor::*;
use std::collections::HashMap;

#[test]
fn orientations_of_one_place_move_together() {
    let features = [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [1.0, 2.0, 3.5], [9.0, 2.0, 3.0], [1.0, 2.0, 3.0]];
    let places = Places::of(features);
    assert_eq!(places, Places { of_feature: vec![0, 0, 1, 2, 0], first: vec![0, 2, 3] });
}
