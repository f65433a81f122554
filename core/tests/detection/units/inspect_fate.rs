//! Tests of `inspect::fate`.
#![allow(unused_imports)]

use burstscope_core::detector::feature::*;
use burstscope_core::detector::*;
use burstscope_core::inspect::fate::*;
use burstscope_core::inspect::words::*;
use burstscope_core::inspect::*;
use serde::Serialize;

#[test]
fn each_test_has_names_of_its_own() {
    let mut names = Test::ALL.map(|test| test.record().short);
    assert!(names.iter().all(|name| (1..=14).contains(&name.len())), "{names:?}");
    names.sort_unstable();
    assert!(names.windows(2).all(|two| two[0] != two[1]), "{names:?}");
}
