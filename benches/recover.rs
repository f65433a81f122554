//! How long the first curve of planted things takes on the demo, and each way to combine shifted frames: 1600×1200
//! pixels, ten frames, at a slope between pixels.

use burstscope::Monitor;
use burstscope::detector::combine::{Combine, combined_stack};
use burstscope::detector::{Interpolation, Slope};
use burstscope::plane::Plane;
use burstscope::recover::RecoverStudy;
use burstscope::synth::{SceneParams, demo_burst, synth_scene};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

/// The study up to its first answer: the search of the burst, one copy with its search, and its curves.
fn first_curve(criterion: &mut Criterion) {
    let burst = demo_burst();
    let study = RecoverStudy { copies: 1, ..RecoverStudy::default() };
    let mut group = criterion.benchmark_group("recover");
    group.sample_size(10);
    group.bench_function("first curve, demo", |bencher| {
        bencher.iter(|| black_box(study.run(&burst, &Monitor::default()).expect("a burst with noise")));
    });
    group.finish();
}

fn combining(criterion: &mut Criterion) {
    let scene = SceneParams { width: 1600, height: 1200, frames: 10, seed: 7, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("valid parameters");
    let frames: Vec<&Plane> = burst.frames.iter().map(|frame| &**frame).collect();
    let slope = Slope::new(1.3, -0.4);
    let mut group = criterion.benchmark_group("combine 1600×1200");
    group.sample_size(20);
    for combine in Combine::ALL {
        group.bench_function(format!("{combine:?}"), |bencher| {
            bencher.iter(|| {
                let stack = combined_stack(
                    &frames,
                    &burst.positions,
                    slope,
                    Interpolation::Linear,
                    combine,
                    &Monitor::default(),
                );
                black_box(stack.expect("not cancelled"))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, first_curve, combining);
criterion_main!(benches);
