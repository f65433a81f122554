//! How long a probe takes once its cache is there: a click should be answered at once. 1600×1200 pixels, ten frames, 7
//! slopes on a line and 7×7. And how long features take to follow a threshold.

use burstscope::Monitor;
use burstscope::detector::{DetectorParams, Distinct, NoiseGate, SearchParams, SlopeGrid};
use burstscope::inspect::ProbeCache;
use burstscope::inspect::place::{ProbeOptions, probe};
use burstscope::synth::{Motion, SceneParams, demo_burst, synth_scene};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

fn probes(criterion: &mut Criterion) {
    let never = Monitor::default();
    let mut group = criterion.benchmark_group("probe 1600×1200");
    group.sample_size(20);
    let grids = [
        ("7 slopes", Motion::OneD, SlopeGrid::line(-3.0..=3.0, 7)),
        ("7×7 slopes", Motion::TwoD, SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7)),
    ];
    for (name, motion, slopes) in grids {
        let scene = SceneParams { width: 1600, height: 1200, frames: 10, motion, seed: 7, ..SceneParams::default() };
        let (burst, _) = synth_scene(&scene, &never).expect("valid parameters");
        let params = SearchParams::from(DetectorParams { slopes, ..DetectorParams::default() });
        let cache = ProbeCache::new(&burst, &params, &never).expect("valid parameters");
        let feature = cache.detection().features[cache.detection().features.len() / 3];
        for (what, place) in [("feature", [feature.u, feature.v]), ("empty place", [801.0, 603.0])] {
            let options = ProbeOptions::default();
            // The frames of the coarser octaves are made with the first question.
            let first = probe(&cache, place, &options, &never).expect("inside");
            assert!(first.samples > 0);
            group.bench_function(format!("{name}, {what}"), |bencher| {
                bencher.iter(|| black_box(probe(&cache, place, &options, &never).expect("inside")));
            });
        }
    }
    group.finish();
}

/// How long features take to follow a threshold: each step is another value, judged from what the search left.
fn thresholds(criterion: &mut Criterion) {
    let never = Monitor::default();
    let mut group = criterion.benchmark_group("threshold");
    group.sample_size(20);
    let slopes = SlopeGrid::line(-3.0..=3.0, 7);
    let scene = SceneParams { width: 1600, height: 1200, frames: 10, snr: 8.0, seed: 7, ..SceneParams::default() };
    let (scene, _) = synth_scene(&scene, &never).expect("valid parameters");
    for (name, burst) in [("demo", demo_burst()), ("1600×1200, 7 slopes", scene)] {
        let params = DetectorParams { slopes, levels: 3, ..DetectorParams::default() };
        let cache = ProbeCache::new(&burst, &params.clone().into(), &never).expect("valid parameters");
        let gate = cache.detection().noise_gate_factor;
        type Change = fn(&mut DetectorParams, f32, f32);
        let changes: [(&str, Change); 5] = [
            ("noise gate", |params, gate, part| params.noise_gate = NoiseGate::Factor(gate * (1.0 + 0.2 * part))),
            ("peak threshold", |params, _, part| params.peak_threshold = 0.001 * part),
            ("edge threshold", |params, _, part| params.edge_threshold *= 1.0 - 0.2 * part),
            ("distinct", |params, _, part| params.distinct = Distinct::Radius(1.0 + part)),
            ("max features", |params, _, part| params.max_features = 500 + (2500.0 * part) as usize),
        ];
        for (what, change) in changes {
            let mut step = 0u32;
            group.bench_function(format!("{name}, {what}"), |bencher| {
                bencher.iter(|| {
                    step += 1;
                    let mut changed = params.clone();
                    change(&mut changed, gate, (step % 20) as f32 / 20.0);
                    black_box(cache.trail.rejudged(&changed, &never).expect("not cancelled").expect("not less strict"))
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, probes, thresholds);
criterion_main!(benches);
