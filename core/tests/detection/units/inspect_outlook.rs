//! Tests of `inspect::outlook`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::{DetectorParams, NoiseGate, SearchParams, SlopeGrid};
use burstscope_core::inspect::ProbeCache;
use burstscope_core::inspect::fate::*;
use burstscope_core::inspect::outlook::*;
use burstscope_core::inspect::probe::fates_near;
use burstscope_core::inspect::words::*;
use burstscope_core::inspect::*;
use burstscope_core::monitor::Monitor;
use burstscope_core::plane::sample::*;
use burstscope_core::plane::*;
use burstscope_core::synth::{ChartParams, synth_chart};
use serde::Serialize;

/// Chart of one disc, and its search with a fixed gate.
fn searched(frames: usize, snr: f64, seed: u64) -> (ProbeCache, [f32; 2]) {
    let small = ChartParams { width: 160, height: 120, ..ChartParams::default() };
    let chart = ChartParams { discs: 1, radius: 5.0..=5.0001, frames, snr, max_slope: 0.5, seed, ..small };
    let (burst, truth) = synth_chart(&chart, &Monitor::default()).expect("a chart");
    let slopes = SlopeGrid::line(-0.5..=0.5, 5);
    let params = DetectorParams { slopes, noise_gate: NoiseGate::Factor(5.0), ..DetectorParams::default() };
    let cache = ProbeCache::new(&burst, &SearchParams::from(params), &Monitor::default()).expect("valid");
    (cache, [truth.features[0].u as f32, truth.features[0].v as f32])
}

fn is_found((cache, place): &(ProbeCache, [f32; 2])) -> bool {
    let near = |f: &burstscope_core::detector::Feature| (f.u - place[0]).hypot(f.v - place[1]) < 4.0;
    cache.detection().features.iter().any(near)
}

#[test]
fn the_burst_that_the_outlook_asks_for_is_made_and_the_thing_is_found() {
    const SNR: f64 = 0.32;
    let (mut asked, mut by_frames, mut by_exposure) = (0, 0, 0);
    for seed in 1..30 {
        let before = searched(6, SNR, seed);
        let fates = fates_near(&before.0.trail, before.1, 1.0, &Monitor::default()).expect("not cancelled");
        let is_disc = |fate: &&Fate| fate.value < 0.0 && (2.0..7.0).contains(&fate.sigma) && fate.snr > 3.0;
        let outlook = fates.iter().find(is_disc).and_then(|fate| outlook(&before.0.trail, fate));
        let Some(outlook) = outlook else { continue };
        asked += 1;
        let frames = outlook.frames.expect("it stays for long");
        by_frames += usize::from(is_found(&searched(frames, SNR, seed)));
        // The same camera with more light: e times the electrons.
        let exposure = ChartParams { snr: SNR, ..ChartParams::default() }.exposure().expect("valid");
        let e = outlook.exposure.expect("it is dark");
        let (camera, middle) = (exposure.camera, 0.5 * (exposure.background + exposure.disc));
        let electrons = e * camera.full_scale_electrons;
        let variance = (middle * electrons + camera.read_noise_electrons.powi(2)) / (electrons * electrons);
        let snr = (exposure.disc - exposure.background) / variance.sqrt();
        by_exposure += usize::from(is_found(&searched(6, snr, seed)));
        assert!(outlook.sentence.contains(&format!("with {frames} frames")), "{}", outlook.sentence);
    }
    assert!(asked >= 6, "{asked} candidates failed the gate");
    // Nine of ten, less what is chance and what the choice of a strong candidate promises too much.
    assert!(10 * by_frames >= 7 * asked && 10 * by_exposure >= 7 * asked, "{by_frames}, {by_exposure} of {asked}");
}
