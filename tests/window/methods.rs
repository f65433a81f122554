//! Several methods on the same burst.

use crate::support::{Start, Window, noisy_stack};
use burstscope::Monitor;
use burstscope::app::project::compare::{Contender, Layout};
use burstscope::app::project::pair::Side;
use burstscope::baseline;
use burstscope::engine::BurstSource;
use burstscope::inspect::words::counted;
use egui::Key;
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

fn methods(second: bool) -> Window {
    let mut start = Start { size: [1400.0, 900.0], ..Start::default() };
    start.startup.second = second.then_some(BurstSource::DemoLater);
    let mut window = start.open();
    window.click("Methods");
    window.settle();
    window
}

#[test]
fn each_method_finds_what_the_library_finds() {
    let window = methods(false);
    let model = &window.app().model;
    let burst = model.burst.as_ref().unwrap().burst.clone();
    for method in [Contender::Sift, Contender::Merge, Contender::Buff1d, Contender::Buff2d] {
        let found = model.method_found(method, Side::A).unwrap();
        let expected = baseline::detect(&burst, &method.params(&model.params), &Monitor::default()).unwrap();
        assert_eq!(found.detection.features, expected.features, "{method:?}");
        assert!(window.shows(&format!("{}  ·  {}", method.label(), counted(expected.features.len(), "feature"))));
        let name = format!("A: {}", method.label());
        assert!(window.harness.query_by_role_and_label(Role::Canvas, &name).is_some(), "{name}");
    }
    assert!(model.method_found(Contender::Gold, Side::A).is_none());
}

#[test]
fn with_a_second_burst_matches_are_compared_too() {
    let mut window = methods(true);
    let model = &window.app().model;
    let inliers = |method| model.method_matches(method).unwrap().result.counts.inliers.unwrap();
    assert!(inliers(Contender::Buff1d) > 2 * inliers(Contender::Sift), "a burst shows what one frame does not");
    assert!(window.shows(&inliers(Contender::Buff1d).to_string()));
    window.click("Match lines");
    window.settle();
    assert_eq!(window.app().model.compare.look.layout, Layout::Matches);
    assert!(window.harness.query_by_role_and_label(Role::Canvas, "B: BuFF 1D").is_some());
}

#[test]
fn a_wipe_is_dragged_and_a_flip_is_flipped() {
    let mut window = methods(false);
    window.key(Key::W);
    window.settle();
    assert_eq!(window.app().model.compare.look.layout, Layout::Wipe);
    let handle = window.harness.get_by_role_and_label(Role::Slider, "Wipe line").rect().center();
    window.harness.drag_at(handle);
    window.harness.run_steps(1);
    window.harness.hover_at(handle + egui::vec2(120.0, 0.0));
    window.harness.run_steps(1);
    window.harness.drop_at(handle + egui::vec2(120.0, 0.0));
    window.harness.run_steps(2);
    assert!(window.app().model.compare.look.wipe > 0.55, "{}", window.app().model.compare.look.wipe);
    window.key(Key::W);
    window.settle();
    assert!(window.harness.query_by_role_and_label(Role::Canvas, "A: SIFT, one frame").is_some());
    window.key(Key::Y);
    window.settle();
    assert!(window.harness.query_by_role_and_label(Role::Canvas, "A: BuFF 1D").is_some());
}

#[test]
fn a_gold_standard_is_opened_and_methods_are_switched_in_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let path = noisy_stack(folder.path(), 1, 360, 480);
    let mut window = methods(false);
    window.dialogs.will_choose(&path);
    window.run_action("gold standard of a");
    window.settle();
    let model = &window.app().model;
    let found = model.method_found(Contender::Gold, Side::A).unwrap();
    assert!(window.shows(&format!("Gold standard  ·  {} features", found.detection.features.len())));
    window.harness.get_by_role_and_label(Role::CheckBox, "BuFF 2D").click();
    window.settle();
    assert!(window.harness.query_by_role_and_label(Role::Canvas, "A: BuFF 2D").is_none());
}

#[test]
fn the_comparison_is_kept_in_a_session() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("methods.burstscope.toml");
    let mut window = methods(false);
    window.key(Key::W);
    window.app_mut().model.compare.look.wipe = 0.25;
    window.harness.get_by_role_and_label(Role::CheckBox, "SIFT, merged").click();
    window.settle();
    window.dialogs.will_choose(&file);
    window.run_action("save session");
    window.settle();
    let mut other = Start { size: [1400.0, 900.0], ..Start::default() }.open();
    other.dialogs.will_choose(&file);
    other.run_action("open session");
    other.settle();
    assert_eq!(other.app().model.compare.look, window.app().model.compare.look);
    assert!(other.harness.query_by_role_and_label(Role::Canvas, "Wipe").is_some());
}
