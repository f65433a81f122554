//! Tests of `detector::advice`.
#![allow(unused_imports)]

use burstscope_core::burst::Burst;
use burstscope_core::detector::NoiseGate;
use burstscope_core::detector::advice::*;
use burstscope_core::detector::feature::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::test::*;
use burstscope_core::detector::*;
use burstscope_core::monitor::Monitor;
use burstscope_core::plane::Plane;
use burstscope_core::synth::{ChartParams, synth_chart};

#[test]
fn counts_are_grouped_by_thousands() {
    assert_eq!([0, 7, 999, 1000, 12_345_678].map(grouped), ["0", "7", "999", "1 000", "12 345 678"]);
}
