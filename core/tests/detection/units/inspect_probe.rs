//! Tests of `inspect::probe`.
#![allow(unused_imports)]

use burstscope_core::burst::Burst;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::test::*;
use burstscope_core::detector::*;
use burstscope_core::detector::{DetectorParams, NoiseGate, SearchParams, SlopeGrid};
use burstscope_core::error::*;
use burstscope_core::inspect::candidates::*;
use burstscope_core::inspect::fate::*;
use burstscope_core::inspect::outlook::*;
use burstscope_core::inspect::probe::*;
use burstscope_core::inspect::reason::*;
use burstscope_core::inspect::remedy::*;
use burstscope_core::inspect::response::*;
use burstscope_core::inspect::shares::*;
use burstscope_core::inspect::suspicion::*;
use burstscope_core::inspect::telling::*;
use burstscope_core::inspect::verdict::*;
use burstscope_core::inspect::words::*;
use burstscope_core::inspect::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::Plane;
use burstscope_core::plane::*;
use burstscope_core::synth::random::Stream;
use serde::{Deserialize, Serialize};

/// A small blob at (80, 80), and a large one whose centre is 13 px away and which reaches over it.
fn small_under_large(gate: NoiseGate) -> ProbeCache {
    let blobs = [(80.0, 80.0, 2.0, 0.1), (93.0, 80.0, 16.0, 0.2)];
    let mut stream = Stream::new(5, 0);
    let mut frame = |_| {
        Plane::from_fn(192, 160, |u, v| {
            let of = |(bu, bv, sigma, height): (f32, f32, f32, f32)| {
                let (du, dv) = (u as f32 - bu, v as f32 - bv);
                height * (-(du * du + dv * dv) / (2.0 * sigma * sigma)).exp()
            };
            0.3 + 0.01 * stream.normal() as f32 + blobs.into_iter().map(of).sum::<f32>()
        })
    };
    let burst = Burst::from_planes("blobs", (0..6).map(&mut frame).collect());
    let params = DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 3), noise_gate: gate, ..Default::default() };
    ProbeCache::new(&burst, &SearchParams::from(params), &Monitor::default()).expect("valid parameters")
}

fn at(cache: &ProbeCache, place: [f32; 2], options: ProbeOptions) -> Probe {
    probe(cache, place, &options, &Monitor::default()).expect("inside")
}

#[test]
fn the_small_blob_under_the_click_comes_before_the_large_one_over_it() {
    for gate in [NoiseGate::Auto, NoiseGate::Factor(1000.0)] {
        let (cache, place) = (small_under_large(gate), [81.0, 80.5]);
        let probe = at(&cache, place, ProbeOptions::default());
        let apart = |fate: &Fate| (fate.pos_image[0] - place[0]).hypot(fate.pos_image[1] - place[1]);
        let first = probe.subject_fate().expect("it is at the place");
        assert_eq!(probe.subject.fate, Some(0));
        assert!(apart(first) < AT_PLACE_PX && (1.4..4.0).contains(&first.sigma), "{first:?}");
        assert_eq!(first.is_kept(), gate == NoiseGate::Auto);
        // The large one responds more clearly, and is last all the same.
        let large = probe.larger_fates().iter().find(|fate| fate.sigma > 10.0).expect("it reaches over the place");
        assert!(large.snr > first.snr && apart(large) > AT_PLACE_PX, "{large:?}");
        assert!(probe.near_fates().iter().all(|fate| fate.sigma < 10.0 || apart(fate) <= AT_PLACE_PX));
        // Chosen candidates are examined wherever they are.
        let wanted = Wanted::Candidate(large.of_sample());
        let chosen = at(&cache, place, ProbeOptions { wanted, ..ProbeOptions::default() });
        assert_eq!(chosen.subject_fate().map(Fate::of_sample), Some(large.of_sample()));
        let beyond = probe.near_fates().iter().map(|fate| apart(fate).max(AT_PLACE_PX));
        assert!(beyond.is_sorted(), "the nearest come first");
    }
}
