//! Tests of `inspect::decoys`.
#![allow(unused_imports)]

use burstscope_core::burst::Burst;
use burstscope_core::detector::stack::*;
use burstscope_core::detector::*;
use burstscope_core::detector::{DetectorParams, NoiseGate, Slope, SlopeGrid};
use burstscope_core::error::*;
use burstscope_core::inspect::ProbeCache;
use burstscope_core::inspect::decoys::*;
use burstscope_core::inspect::words::*;
use burstscope_core::inspect::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::Plane;
use burstscope_core::synth::random::*;
use burstscope_core::synth::*;
use serde::Serialize;

const SIZE: (usize, usize) = (160, 120);

/// Frames of noise, with blobs that all move by `slope`.
fn burst(frames: usize, blobs: usize, slope: Slope) -> Burst {
    let mut places = Stream::new(5, 99);
    let places: Vec<(f32, f32)> =
        (0..blobs).map(|_| (places.within(20.0, 140.0) as f32, places.within(20.0, 100.0) as f32)).collect();
    let frame = |t: usize| {
        let mut noise = Stream::new(5, t as u64);
        let dt = t as f32 - 0.5 * (frames as f32 - 1.0);
        Plane::from_fn(SIZE.0, SIZE.1, |x, y| {
            let light = |&(u, v): &(f32, f32)| {
                let (du, dv) = (x as f32 - u - dt * slope.u, y as f32 - v - dt * slope.v);
                0.1 * (-(du * du + dv * dv) / (2.0 * 2.5 * 2.5)).exp()
            };
            0.3 + 0.02 * noise.normal() as f32 + places.iter().map(light).sum::<f32>()
        })
    };
    Burst::from_planes("decoys", (0..frames).map(frame).collect())
}

fn cache(burst: &Burst, params: DetectorParams) -> ProbeCache {
    ProbeCache::new(burst, &params.into(), &Monitor::default()).expect("valid")
}

fn line(gate: f32) -> DetectorParams {
    let slopes = SlopeGrid::line(-3.0..=3.0, 13);
    DetectorParams { slopes, noise_gate: NoiseGate::Factor(gate), ..DetectorParams::default() }
}

fn report(cache: &ProbeCache, study: DecoyStudy) -> DecoyReport {
    decoys(&cache.trail, &study, &Monitor::default()).expect("enough frames")
}

#[test]
fn what_is_found_in_noise_alone_is_found_in_copies_as_often() {
    let cache = cache(&burst(8, 0, Slope::default()), line(1.5));
    let all = report(&cache, DecoyStudy { copies: 5, seed: 1 }).rates.swap_remove(0);
    let (rate, error) = (all.rate.expect("found"), all.error.expect("found"));
    assert!(all.found > 100 && error < 0.12, "{all:?}");
    assert!((rate - 1.0).abs() < 3.0 * error, "{all:?}");
}

#[test]
fn what_moves_clearly_is_rarely_found_in_copies_as_strong() {
    let cache = cache(&burst(10, 12, Slope::new(2.0, 0.0)), line(5.0));
    let report = report(&cache, DecoyStudy::default());
    let strong = report.rates.iter().rfind(|one| one.found >= 5).expect("blobs");
    assert!(strong.snr >= 10.0 && strong.rate < Some(0.4), "{report:?}");
    assert!(report.rates[0].rate > Some(0.6), "the ghosts of single frames are weak: {report:?}");
    assert!(report.sentence().contains("found there for each found here at SNR 8"), "{}", report.sentence());
}

#[test]
fn the_own_order_finds_what_was_found_and_a_maximum_number_hides_no_decoy() {
    let burst = burst(6, 6, Slope::new(1.0, 0.0));
    let (all, few) = (cache(&burst, line(3.5)), cache(&burst, DetectorParams { max_features: 5, ..line(3.5) }));
    let own: Vec<usize> = (0..6).collect();
    let again = all.trail.reordered(&own, &Monitor::default()).expect("valid");
    assert_eq!(again.features, all.detection().features);
    assert_eq!((again.tally, again.noise), (all.detection().tally, all.detection().noise.clone()));
    assert_eq!(few.detection().features.len(), 5);
    assert_eq!(report(&few, DecoyStudy::default()), report(&all, DecoyStudy::default()));
}

#[test]
fn without_motion_all_copies_are_alike_and_the_report_says_that_they_tell_nothing() {
    let slopes = SlopeGrid::single(Slope::default());
    let cache = cache(&burst(5, 8, Slope::default()), DetectorParams { slopes, ..line(3.5) });
    let report = report(&cache, DecoyStudy::default());
    assert!(report.rates[0].found > 8, "{report:?}");
    for one in &report.rates {
        assert_eq!(one.rate, (one.found > 0).then_some(1.0), "{one:?}");
    }
    assert!(report.sentence().starts_with("decoys say nothing here"), "{}", report.sentence());
}

#[test]
fn still_features_put_the_rates_in_doubt() {
    let rate = |snr, found: usize, rate: f64| {
        let (in_copies, is_known) = (vec![(rate * found as f64) as usize], found > 0);
        FalseRate { snr, found, in_copies, rate: is_known.then_some(rate), error: is_known.then_some(0.1) }
    };
    let rates = vec![rate(0.0, 100, 0.9), rate(8.0, 50, 0.79), rate(30.0, 10, 0.13)];
    let report = DecoyReport { frames: 10, copies: 1, seed: 1, still: 10, rates };
    assert_eq!(report.sentence(), "0.79 found there for each found here at SNR 8, 0.13 at 30");
    assert_eq!(report.doubt(), None);
    let doubted = DecoyReport { still: 30, ..report.clone() };
    assert!(doubted.doubt().expect("many").starts_with("30 features of 100 stay within"), "{doubted:?}");
    assert_eq!(doubted.sentence(), report.sentence());
    let none = DecoyReport { still: 0, rates: vec![rate(0.0, 0, 0.0)], ..report };
    assert_eq!((none.sentence().as_str(), none.doubt()), ("nothing is found here, so there is no rate", None));
}
