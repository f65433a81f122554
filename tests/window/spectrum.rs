//! Slopes that a burst needs: bars under the slider, the tab with its advice.

use crate::support::{Start, Window};
use burstscope::app::project::BottomTab;
use burstscope::detector::{DetectorParams, SlopeAxis, SlopeChoice, SlopeGrid};
use burstscope::synth::random::Stream;
use egui::accesskit::Role;
use egui::{Key, vec2};
use egui_kittest::kittest::Queryable;
use ndarray::Array3;
use std::path::{Path, PathBuf};

/// Writes many discs that all move by (2.5, 0), with noise, as a `.npy` stack.
pub fn fast(folder: &Path) -> PathBuf {
    let (frames, height, width) = (8, 150, 220);
    let mut stream = Stream::new(11, 0);
    let mut uniform = |n: usize| stream.uniform() as f32 * n as f32;
    let discs: Vec<(f32, f32)> = (0..60).map(|_| (uniform(width + 40) - 20.0, uniform(height))).collect();
    let array = Array3::from_shape_fn((frames, height, width), |(t, v, u)| {
        let light: f32 = discs
            .iter()
            .map(|(cu, cv)| {
                let d2 = (u as f32 - cu - 2.5 * t as f32).powi(2) + (v as f32 - cv).powi(2);
                if d2 < 200.0 { (-d2 / 18.0).exp() } else { 0.0 }
            })
            .sum();
        0.15 + 0.12 * light + 0.02 * stream.normal() as f32
    });
    let path = folder.join("fast.npy");
    ndarray_npy::write_npy(&path, &array).unwrap();
    path
}

/// Window on the burst, searched in a range that is too narrow.
fn open(folder: &Path) -> Window {
    let mut start = Start { size: [1280.0, 800.0], ..Start::of(&fast(folder)) };
    start.startup.params =
        DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 5), ..DetectorParams::default() }.into();
    let mut window = start.open();
    window.run_action("detect");
    window.settle();
    window
}

/// Opens the tab; slopes are analysed automatically, unless the detection took long.
fn look_at_slopes(window: &mut Window) {
    window.app_mut().model.bottom_tab = BottomTab::Slopes;
    window.settle();
    if window.shows("Analyse slopes") {
        window.click("Analyse slopes");
        window.settle();
    }
}

fn axis(window: &Window) -> SlopeAxis {
    window.app().model.params.slopes.u
}

#[test]
fn too_narrow_a_range_is_told_and_one_click_widens_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(folder.path());
    let slope = window.app().model.cursor().slope;
    look_at_slopes(&mut window);
    let spectrum = window.app().model.spectrum().unwrap().clone();
    let advice = &spectrum.advice[0];
    assert!(!advice.changes.is_empty() && window.shows("moves faster than the range"), "{advice:?}");
    assert!(window.shows(&advice.changes[0].label()) && window.shows("at the limit"));
    assert_eq!(window.app().model.cursor().slope, slope, "it never moves the slope by itself");
    window.snapshot("slopes_advice");
    let before = axis(&window);
    window.click("Apply");
    let wider = axis(&window);
    assert!(wider.max >= 2.5 && wider.count > before.count, "{wider:?}");
    assert_eq!(window.app().model.slopes, SlopeChoice::Given);
    window.ctrl(Key::Z);
    assert_eq!(axis(&window), before, "it is undone as any change of a parameter");
    window.click("Apply");
    window.run_action("detect");
    window.settle();
    look_at_slopes(&mut window);
    let spectrum = window.app().model.spectrum().unwrap().clone();
    assert_eq!(spectrum.grid.u, wider, "the slopes are those of the new detection");
    assert!((spectrum.most_features().unwrap().u - 2.5).abs() < 0.6);
    let told = |spectrum: &burstscope::inspect::spectrum::Spectrum| {
        spectrum.advice.iter().any(|a| a.subject == burstscope::inspect::spectrum::Subject::Range)
    };
    assert!(!told(&spectrum), "{:?}", spectrum.advice);
    window.key(Key::B);
    assert!((window.app().model.cursor().slope.u - 2.5).abs() < 0.6);
}

#[test]
fn the_ends_of_the_range_are_dragged_below_the_slider() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(folder.path());
    assert!(window.harness.query_by_label("Features and evidence below the slider").is_some());
    let end = window.harness.get_by_role_and_label(Role::Slider, "Range end u").rect().center();
    let start = window.harness.get_by_role_and_label(Role::Slider, "Range start u").rect().center();
    // The distance from the middle to the end is 1 px/frame.
    let unit = 0.5 * (end.x - start.x);
    window.harness.hover_at(end);
    window.harness.run_steps(1);
    window.harness.drag_at(end);
    window.harness.run_steps(1);
    for part in [0.3, 0.7, 1.0] {
        window.harness.hover_at(end + vec2(part * unit, 0.0));
        window.harness.run_steps(1);
    }
    window.harness.drop_at(end + vec2(unit, 0.0));
    window.harness.run_steps(2);
    assert_eq!(axis(&window), SlopeAxis { min: -1.0, max: 2.0, count: 7 }, "by whole steps");
    window.ctrl(Key::Z);
    assert_eq!(axis(&window), SlopeAxis { min: -1.0, max: 1.0, count: 5 }, "the drag is one step");
}

#[test]
fn a_plane_of_slopes_has_cells() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::automatic() }.open();
    look_at_slopes(&mut window);
    assert!(window.app().model.spectrum().unwrap().grid.is_plane());
    assert!(window.shows("Evidence by slope") && window.shows("Cost: "));
    assert!(window.harness.query_by_label("Features and evidence below the slider").is_none());
    window.snapshot("slopes_plane");
}
