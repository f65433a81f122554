//! Tests of `synth::chart`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::error::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use burstscope_core::synth::chart::*;
use burstscope_core::synth::noise::*;
use burstscope_core::synth::options::*;
use burstscope_core::synth::random::*;
use burstscope_core::synth::truth::*;
use burstscope_core::synth::uneven::*;
use burstscope_core::synth::*;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

fn small() -> ChartParams {
    ChartParams { width: 240, height: 180, discs: 9, radius: 3.6..=12.0, frames: 5, ..ChartParams::default() }
}

#[test]
fn each_disc_is_where_the_truth_says_in_every_frame() {
    let params = ChartParams { snr: f64::INFINITY, motion: Motion::TwoD, ..small() };
    let (burst, truth) = synth_chart(&params, &Monitor::default()).expect("a chart");
    let background = params.exposure().expect("valid").background + truth.black_level;
    let mut measured = 0;
    for (t, frame) in burst.frames.iter().enumerate() {
        let dt = t as f64 - truth.t0;
        for disc in &truth.features {
            let (u, v) = disc.position(dt);
            let is_near = |d: &FeatureTruth| {
                let (x, y) = d.position(dt);
                d.id != disc.id && (x - u).hypot(y - v) <= d.radius + disc.radius + 4.0
            };
            if truth.features.iter().any(is_near) {
                continue;
            }
            let reach = disc.radius + 2.0;
            let (mut mass, mut mu, mut mv) = (0.0, 0.0, 0.0);
            for y in (v - reach).ceil() as usize..=(v + reach) as usize {
                for x in (u - reach).ceil() as usize..=(u + reach) as usize {
                    let w = f64::from(frame.at(x, y)) - background;
                    mass += w;
                    mu += w * x as f64;
                    mv += w * y as f64;
                }
            }
            assert!((mu / mass - u).abs() < 0.01, "frame {t}, disc {}: u {} for {u}", disc.id, mu / mass);
            assert!((mv / mass - v).abs() < 0.01, "frame {t}, disc {}: v {} for {v}", disc.id, mv / mass);
            let area = mass / (params.exposure().expect("valid").disc - background + truth.black_level);
            let true_area = std::f64::consts::PI * disc.radius * disc.radius;
            assert!((area / true_area - 1.0).abs() < 2e-3, "area {area} for {true_area}");
            measured += 1;
        }
    }
    assert!(measured > 30, "only {measured} discs stood alone");
}
