//! Cost of features over a picture: CPU time of a whole pass of the window with 100 000 of them, drawn, selected in
//! turn, filtered or sorted anew, against the same pass with none drawn. What is drawn is tessellated too; the graphics
//! card's part and the work in the background are left out.

use burstscope::Monitor;
use burstscope::app::document::panes::Panels;
use burstscope::app::document::{Document, FeaturesShown, Interval};
use burstscope::app::settings::Settings;
use burstscope::app::{BurstscopeApp, Startup};
use burstscope::detector::{DetectorParams, NoiseGate, Quantity, SlopeGrid};
use burstscope::requests::BurstSource;
use burstscope::synth::{Motion, SceneParams, synth_scene};
use cpu_time::ThreadTime;
use criterion::{Criterion, criterion_group, criterion_main};
use egui::{Event, RawInput, Rect, pos2, vec2};
use std::hint::black_box;
use std::time::Duration;

/// Fewest features that are drawn.
const FEATURES: usize = 100_000;

/// Input of a pass: the pointer moves over the picture, as in a drag.
fn input(pass: usize) -> RawInput {
    let pointer = pos2(700.0 + (pass % 50) as f32, 400.0);
    RawInput {
        screen_rect: Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(1280.0, 800.0))),
        events: vec![Event::PointerMoved(pointer)],
        ..RawInput::default()
    }
}

/// Runs one pass; returns the number of shapes that it drew.
fn pass(ctx: &egui::Context, app: &mut BurstscopeApp, number: usize) -> usize {
    let output = ctx.run_ui(input(number), |ui| app.show(ui));
    let mut textures = output.textures_delta;
    textures.clear();
    ctx.tessellate(output.shapes, output.pixels_per_point).len()
}

fn overlay(criterion: &mut Criterion) {
    let motion = Motion::OneD;
    let scene = SceneParams { width: 4000, height: 3000, frames: 5, motion, seed: 7, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("valid parameters");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.npy");
    let (width, height) = burst.size();
    let frames = ndarray::Array3::from_shape_fn((burst.len(), height, width), |(t, v, u)| burst.frames[t].at(u, v));
    ndarray_npy::write_npy(&path, &frames).expect("a file");

    let slopes = SlopeGrid::line(-3.0..=3.0, 7);
    let gate = NoiseGate::Factor(1.8);
    let params = DetectorParams { slopes, noise_gate: gate, peak_threshold: 0.0, ..DetectorParams::default() };
    let settings =
        Settings { panels: Panels { welcome: false, ..Panels::default() }, auto_detect: true, ..Settings::default() };
    let source = Some(BurstSource::Paths(vec![path]));
    let startup = Startup { source, params: params.into(), settings, ..Startup::default() };
    let ctx = egui::Context::default();
    let mut app = BurstscopeApp::new(&ctx, None, startup);
    let mut number = 0;
    while !(app.is_settled() && app.model.results.slots.a.found.is_some()) {
        number += 1;
        pass(&ctx, &mut app, number);
        std::thread::sleep(Duration::from_millis(5));
    }
    let count = app.read().features().len();
    assert!(count >= FEATURES, "only {count} features to draw");

    let mut group = criterion.benchmark_group(format!("a pass with {count} features"));
    group.sample_size(20);
    let mut measure = |name: &str, change: &mut dyn FnMut(&mut Document, usize)| {
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|times| {
                let started = ThreadTime::now();
                for _ in 0..times {
                    number += 1;
                    change(&mut app.model.document, number);
                    black_box(pass(&ctx, &mut app, number));
                }
                started.elapsed()
            });
        });
    };
    let shown = [("this slope", FeaturesShown::ThisSlope), ("none", FeaturesShown::None), ("all", FeaturesShown::All)];
    for (name, shown) in shown {
        measure(name, &mut |document, _| document.look.overlay = shown);
    }
    measure("all, another selected", &mut |document, number| document.selected = Some(number * 7919 % count));
    measure("all, filtered anew", &mut |document, number| {
        let limits = Interval { min: 2.0 + 0.001 * (number % 1000) as f32, max: 1e6 };
        (document.selected, _) = (None, document.filter.ranges.insert(Quantity::Snr, limits));
    });
    measure("all, sorted anew", &mut |document, number| {
        document.filter = Default::default();
        (document.order.column, document.order.descending) = (Quantity::Sigma, number.is_multiple_of(2));
    });
    measure("all circles", &mut |document, _| document.look.draws_all = true);
    group.finish();
}

criterion_group!(benches, overlay);
criterion_main!(benches);
