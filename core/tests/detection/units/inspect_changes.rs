//! Tests of `inspect::changes`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::error::*;
use burstscope_core::export::*;
use burstscope_core::export::{write_colmap, write_csv};
use burstscope_core::files::*;
use burstscope_core::inspect::changes::*;
use burstscope_core::inspect::score::*;
use burstscope_core::inspect::*;
use proptest::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};
use std::io::Read;
use std::path::Path;

fn spot(u: f32, v: f32, sigma: f32) -> Spot {
    Spot { pos_image: [u, v], sigma, slope: Some(Slope::default()), is_bright: None }
}

#[test]
fn gained_lost_and_moved_are_told_apart() {
    let before = [spot(10.0, 10.0, 2.0), spot(50.0, 10.0, 2.0), spot(90.0, 10.0, 2.0)];
    let after = [spot(10.1, 10.0, 2.0), spot(51.0, 10.0, 2.0), spot(30.0, 40.0, 2.0)];
    let changes = compare(&before, &after);
    assert_eq!((changes.gained.as_slice(), changes.lost.as_slice()), ([2].as_slice(), [2].as_slice()));
    assert_eq!(changes.moved().map(|s| (s.before, s.after)).collect::<Vec<_>>(), [(1, 1)]);
    assert_eq!(changes.summary(), "1 gained, 1 lost, 1 moved, 1 as before");
    let [one, two, three] = [1, 2, 3].map(|orientations| vec![before[0]; orientations]);
    assert_eq!(compare(&two, &two).summary(), "0 gained, 0 lost, 0 moved, 2 as before");
    assert_eq!(compare(&one, &three).gained, [1, 2]);
    assert_eq!(compare(&three, &two).lost, [2]);
    let dark = Spot { is_bright: Some(false), ..before[0] };
    let bright = Spot { is_bright: Some(true), ..before[0] };
    assert_eq!(compare(&[dark], &[bright]).same, []);
    assert_eq!(compare(&[spot(0.0, 0.0, 2.0)], &[spot(0.0, 0.0, 4.1)]).same, []);
}
