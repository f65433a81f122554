//! How long a probe takes once its cache is there: a click should be answered at once. 1600×1200 pixels, ten frames, 7
//! slopes on a line and 7×7.

use burstscope::Monitor;
use burstscope::detector::{DetectorParams, SearchParams, SlopeGrid};
use burstscope::inspect::{ProbeCache, ProbeOptions, probe};
use burstscope::synth::{Motion, SceneParams, synth_scene};
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

criterion_group!(benches, probes);
criterion_main!(benches);
