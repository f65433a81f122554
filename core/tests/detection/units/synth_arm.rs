//! Tests of `synth::arm`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::error::*;
use burstscope_core::monitor::Monitor;
use burstscope_core::plane::*;
use burstscope_core::synth::paint::*;
use burstscope_core::synth::truth::*;
use burstscope_core::synth::*;
use burstscope_core::synth::{ChartParams, synth_chart};
use std::sync::Arc;

#[test]
fn an_arm_stands_still_and_hides_what_lies_behind_it() {
    let plain = ChartParams { width: 240, height: 180, discs: 12, frames: 5, ..ChartParams::default() };
    let plain = ChartParams { radius: 3.6..=9.0, snr: f64::INFINITY, ..plain };
    let made = |mask: f64| synth_chart(&ChartParams { mask, ..plain.clone() }, &Monitor::default());
    let (bare, all) = made(0.0).expect("a chart");
    let (burst, truth) = made(0.4).expect("a chart");
    assert_eq!((all.mask_columns, truth.mask_columns, all.mask()), (0, 96, None));
    assert!(!truth.features.is_empty() && truth.features.iter().all(|disc| disc.u > 96.0));
    assert!(all.features.iter().filter(|disc| disc.u > 130.0).all(|disc| truth.features.contains(disc)));
    for (frame, bare) in burst.frames.iter().zip(&bare.frames) {
        assert_eq!(frame.row(50)[..96], burst.frames[0].row(50)[..96], "the arm moves");
        assert_eq!(frame.row(50)[96..], bare.row(50)[96..], "the rest is the chart");
    }
    let masked = truth.masked(burst);
    assert!(masked.frames.iter().all(|frame| frame.weight_at(95, 0) == 0.0 && frame.weight_at(96, 0) == 1.0));
    let error = made(0.95).expect_err("nothing is left").to_string();
    assert!(error.starts_with("mask: 0.95 of the columns"), "{error}");
}
