//! Automatically found slopes.

use crate::support::{Start, Window};
use burstscope::app::project::cursor::slope_limit;
use burstscope::app::session::Session;
use burstscope::detector::{Slope, SlopeAxis, SlopeChoice, SlopeGrid, SlopeVerdict};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

fn grid(window: &Window) -> SlopeGrid {
    window.app().model.params.slopes
}

#[test]
fn the_demo_opens_with_its_slopes_found_and_shown() {
    let window = Start { size: [1280.0, 1000.0], ..Start::automatic() }.open();
    let model = &window.app().model;
    let found = model.slots.a.found.as_ref().unwrap();
    let finding = found.finding.as_ref().unwrap();
    assert_eq!((model.slopes, finding.verdict), (SlopeChoice::AUTO, SlopeVerdict::Found));
    assert_eq!((grid(&window), found.params.slopes), (finding.grid, finding.grid));
    assert!(finding.grid.is_plane() && model.stale().is_none());
    assert!(window.shows(&format!("Found: u {}", finding.grid.u)));
    // The sliders range over the found slopes.
    assert!(slope_limit(&model.slots.a.usable_params.slopes) >= finding.grid.max_magnitude());
    assert_eq!(model.slots.a.usable_params.slopes, finding.grid);
}

#[test]
fn the_switch_gives_what_was_found_to_be_edited_and_a_reset_finds_it_again() {
    let mut window = Start { size: [1280.0, 1000.0], ..Start::automatic() }.open();
    let found = grid(&window);
    window.harness.get_by_role_and_label(Role::CheckBox, "Auto slopes").click();
    window.settle();
    assert_eq!((window.app().model.slopes, grid(&window)), (SlopeChoice::Given, found));
    assert!(window.app().model.slots.a.found.as_ref().unwrap().finding.is_none());
    window.click("Reset Slopes");
    window.settle();
    assert_eq!((window.app().model.slopes, grid(&window)), (SlopeChoice::AUTO, found));
    // A range edited by hand counts as given.
    window.harness.get_all_by_role_and_label(Role::SpinButton, "Slopes v").nth(2).unwrap().set_value_accesskit(3.0);
    window.settle();
    assert_eq!((window.app().model.slopes, grid(&window).v.count), (SlopeChoice::Given, 3));
    assert_eq!(
        (grid(&window).u, window.app().model.slots.a.found.as_ref().unwrap().params.slopes.v.count),
        (found.u, 3)
    );
}

#[test]
fn presets_give_ranges_and_reset_all_finds_them() {
    let mut window = Start::automatic().open();
    window.click("BuFF 1D");
    window.settle();
    assert_eq!((window.app().model.slopes, grid(&window)), (SlopeChoice::Given, SlopeGrid::line(-3.0..=3.0, 7)));
    window.click("Reset all");
    window.settle();
    assert!(window.app().model.slopes.is_auto() && grid(&window).is_plane());
}

#[test]
fn sessions_keep_the_switch_and_older_ones_their_ranges() {
    let mut window = Start::automatic().open();
    let model = &window.app().model;
    let session = Session::of(model).unwrap();
    let text = session.to_toml();
    assert!(text.contains("slopes = \"auto\""), "{text}");
    let mut restored = Start::without_auto_detect().open();
    Session::from_toml(&text).unwrap().apply(&mut restored.app_mut().model);
    assert!(restored.app().model.slopes.is_auto());
    // A session from before slopes were found.
    let older = "version = 1\nburst = \"demo\"\n[params.slopes.u]\nmin = -1.0\nmax = 1.0\ncount = 5\n";
    Session::from_toml(older).unwrap().apply(&mut window.app_mut().model);
    window.settle();
    assert_eq!(window.app().model.slopes, SlopeChoice::Given);
    assert_eq!(grid(&window).u, SlopeAxis::new(-1.0..=1.0, 5));
    assert!(window.app().model.slots.a.found.as_ref().unwrap().finding.is_none());
    assert_eq!(grid(&window).v.value(0.0), Slope::default().v);
}
