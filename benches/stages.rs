//! The stages of a detection and the whole of it, measured by criterion: pictures on ten frames of 1600×1200, whole
//! searches on 800×600.
//!
//!     cargo bench --bench stages
//!     cargo bench --bench stages -- search      (only those whose name has it)

mod common;

use burstscope::detector::noise::frame_noise;
use burstscope::detector::view::{dog_view, stack_view};
use burstscope::detector::{DetectorParams, Method, SearchParams, Slope, SlopeGrid};
use burstscope::inspect::ProbeCache;
use burstscope::synth::demo_burst;
use burstscope::{Burst, Monitor, Plane, detect};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

fn line(peak_threshold: f32) -> DetectorParams {
    DetectorParams { octaves: 16, levels: 3, peak_threshold, ..DetectorParams::default() }
}

fn plane(peak_threshold: f32) -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), ..line(peak_threshold) }
}

/// What the window asks for while a slider moves, beside a copy of the burst.
fn pictures(c: &mut Criterion) {
    let burst = common::burst(1600, 1200);
    let (params, quiet) = (line(0.0015), Monitor::default());
    let slope = Slope::new(1.3, -0.7);
    let mut group = c.benchmark_group("picture");
    let mut copies: Vec<Plane> = burst.frames.iter().map(|frame| (**frame).clone()).collect();
    group.bench_function("copy of the burst", |b| {
        b.iter(|| {
            copies.iter_mut().zip(&burst.frames).for_each(|(to, from)| to.data_mut().copy_from_slice(from.data()));
            black_box(&copies);
        });
    });
    group.bench_function("noise estimate", |b| b.iter(|| frame_noise(&burst, 0..burst.len(), &quiet)));
    group.bench_function("motion-stack image", |b| b.iter(|| stack_view(&burst, &params, slope, &quiet)));
    for octave in [0, 2] {
        group.bench_with_input(BenchmarkId::new("DoG", octave), &octave, |b, &octave| {
            b.iter(|| dog_view(&burst, &params, slope, octave, 1, &quiet));
        });
    }
    group.finish();
}

/// Whole detections: what is searched, and how much is described (a high threshold leaves next to nothing to describe).
fn searches(c: &mut Criterion) {
    let burst = common::burst(800, 600);
    let quiet = Monitor::default();
    let run = |burst: &Burst, params: &DetectorParams| detect(burst, params, &quiet).expect("valid parameters");
    let mut group = c.benchmark_group("search");
    group.sample_size(10).measurement_time(Duration::from_secs(4));
    let one_frame = DetectorParams { method: Method::Sift, ..line(0.0015) };
    let doubled = DetectorParams { first_octave: -1, ..line(0.0015) };
    for (name, params) in [
        ("one frame", one_frame),
        ("1D", line(0.0015)),
        ("1D, nothing described", line(0.5)),
        ("1D, first octave -1", doubled),
        ("2D", plane(0.0015)),
        ("2D, nothing described", plane(0.5)),
    ] {
        group.bench_function(name, |b| b.iter(|| run(&burst, &params)));
    }
    group.finish();
}

/// Searches by day with the default thresholds: for all features, and for the 3000 strongest.
fn strongest(c: &mut Criterion) {
    let quiet = Monitor::default();
    let mut group = c.benchmark_group("by day");
    group.sample_size(10).measurement_time(Duration::from_secs(20));
    for (name, motion, slopes) in
        [("1D", (1, 0), SlopeGrid::line(-3.0..=3.0, 7)), ("2D", (1, 1), SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7))]
    {
        let Some(burst) = common::by_day(motion) else { continue };
        for max_features in [0, 3000] {
            let params = DetectorParams { slopes, levels: 3, max_features, ..DetectorParams::default() };
            let run = |burst: &Burst| detect(burst, &params, &quiet).expect("valid parameters");
            let id = BenchmarkId::new(name, if max_features == 0 { "all".into() } else { max_features.to_string() });
            group.bench_with_input(id, &burst, |b, burst| b.iter(|| run(burst)));
        }
    }
    group.finish();
}

/// A new search, and one that goes on from a search of a part of its slopes, as the window's: with what explains them.
fn widened(c: &mut Criterion) {
    let burst = common::burst(800, 600);
    let quiet = Monitor::default();
    let mut group = c.benchmark_group("widened");
    group.sample_size(10).measurement_time(Duration::from_secs(4));
    let rows = |reach: f32, count: usize| SlopeGrid::plane(-3.0..=3.0, 7, -reach..=reach, count);
    for (name, from, to) in [
        ("7 to 9", SlopeGrid::line(-3.0..=3.0, 7), SlopeGrid::line(-4.0..=4.0, 9)),
        ("5 to 7 rows of 7", rows(2.0, 5), rows(3.0, 7)),
    ] {
        let params = |slopes: SlopeGrid| SearchParams::from(DetectorParams { slopes, ..line(0.0015) });
        let earlier = [Arc::new(ProbeCache::new(&burst, &params(from), &quiet).expect("valid parameters"))];
        for (kind, earlier) in [("new", &[][..]), ("going on", &earlier[..])] {
            group.bench_function(BenchmarkId::new(name, kind), |b| {
                b.iter(|| ProbeCache::after(earlier, &burst, &params(to), &|_| {}, &quiet));
            });
        }
    }
    group.finish();
}

/// A long search until the features of its first slope are there, and the whole of it, as the window's: the demo, with
/// its slopes found, and a plane of slopes.
fn first_features(c: &mut Criterion) {
    let (demo, larger, quiet) = (demo_burst(), common::burst(800, 600), Monitor::default());
    let rows = SearchParams::from(plane(0.0015));
    let mut group = c.benchmark_group("first features");
    group.sample_size(10).measurement_time(Duration::from_secs(6));
    for (name, burst, params) in [("demo", &demo, SearchParams::default()), ("7x7", &larger, rows)] {
        for kind in ["first", "whole"] {
            let search = || {
                let (began, first) = (Instant::now(), OnceLock::new());
                let tell = |_| _ = first.set(began.elapsed());
                ProbeCache::after(&[], burst, &params, &tell, &quiet).expect("valid parameters");
                let whole = began.elapsed();
                if kind == "first" { *first.get().expect("a long search") } else { whole }
            };
            group.bench_function(BenchmarkId::new(name, kind), |b| {
                b.iter_custom(|times| (0..times).map(|_| search()).sum());
            });
        }
    }
    group.finish();
}

/// How the time grows with frames, pixels and slopes.
fn growth(c: &mut Criterion) {
    let quiet = Monitor::default();
    let mut group = c.benchmark_group("growth");
    group.sample_size(10).measurement_time(Duration::from_secs(3));
    let burst = common::burst(800, 600);
    for frames in [5, 10] {
        let some = Burst { frames: burst.frames[..frames].to_vec(), ..burst.clone() };
        group.bench_with_input(BenchmarkId::new("frames", frames), &some, |b, some| {
            b.iter(|| detect(some, &line(0.0015), &quiet));
        });
    }
    for slopes in [1, 3, 7, 13] {
        let params = DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, slopes), ..line(0.0015) };
        group.bench_with_input(BenchmarkId::new("slopes", slopes), &params, |b, params| {
            b.iter(|| detect(&burst, params, &quiet));
        });
    }
    for (width, height) in [(400, 300), (800, 600), (1600, 1200)] {
        let sized = common::burst(width, height);
        group.bench_with_input(BenchmarkId::new("pixels", width * height), &sized, |b, sized| {
            b.iter(|| detect(sized, &line(0.0015), &quiet));
        });
    }
    group.finish();
}

criterion_group!(benches, widened, first_features, pictures, searches, strongest, growth);
criterion_main!(benches);
