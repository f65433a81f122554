//! Cost of drawing the features over a picture: a whole pass of the window with 25 000 features, against the same pass
//! with none drawn. What is drawn is tessellated too; the graphics card's part is left out.

use burstscope::Monitor;
use burstscope::app::document::look::FeaturesShown;
use burstscope::app::document::panes::Panels;
use burstscope::app::settings::Settings;
use burstscope::app::{BurstscopeApp, Startup};
use burstscope::detector::{DetectorParams, NoiseGate, SlopeGrid};
use burstscope::requests::BurstSource;
use burstscope::synth::{Motion, SceneParams, synth_scene};
use criterion::{Criterion, criterion_group, criterion_main};
use egui::{Event, RawInput, Rect, pos2, vec2};
use std::hint::black_box;
use std::time::Duration;

/// Fewest features that are drawn.
const FEATURES: usize = 25_000;

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
    let scene = SceneParams { width: 2000, height: 1500, frames: 6, motion, seed: 7, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("valid parameters");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.npy");
    let (width, height) = burst.size();
    let frames = ndarray::Array3::from_shape_fn((burst.len(), height, width), |(t, v, u)| burst.frames[t].at(u, v));
    ndarray_npy::write_npy(&path, &frames).expect("a file");

    let slopes = SlopeGrid::line(-3.0..=3.0, 7);
    let gate = NoiseGate::Factor(2.0);
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
    group.sample_size(40);
    let shown = [("all", FeaturesShown::All), ("this slope", FeaturesShown::ThisSlope), ("none", FeaturesShown::None)];
    for (name, shown) in shown {
        app.model.document.look.overlay = shown;
        for warm_up in 0..5 {
            pass(&ctx, &mut app, warm_up);
        }
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                number += 1;
                black_box(pass(&ctx, &mut app, number))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, overlay);
criterion_main!(benches);
