//! Pictures of the window. Each was looked at; a changed one has to be looked at again.

use crate::{flat, support::*};

const PLAIN: [f32; 2] = [1280.0, 800.0];

fn open() -> Window {
    Start { size: PLAIN, ..Start::default() }.open()
}

#[test]
fn start_and_kinds_of_picture() {
    open().snapshot("start");
    flat::open(PLAIN).key(Key::Num1).snapshot("flat/single_frame");
    let mut window = open();
    window.key(Key::Num3);
    // The axis of the histogram depends on earlier pictures, so each picture is waited for.
    window.settle().slide("Octave", 1.0).change(|document| document.bottom_tab = BottomTab::Tally);
    window.snapshot("dog_response");
}

#[test]
fn selected_feature_and_parameter_error() {
    let mut window = Start { size: [1280.0, 1100.0], ..Start::default() }.open();
    window.key(Key::Home).key(Key::Enter).snapshot("selected_feature");
    let mut window = flat::with_features(flat::open(PLAIN));
    window.set().params.slopes = SlopeGrid::line(3.0..=-3.0, 7).into();
    window.snapshot("flat/parameter_error");
}

#[test]
fn palette_shortcuts_errors_and_first_page() {
    let mut window = flat::open(PLAIN);
    window.ctrl(Key::P);
    window.type_into("Find an action", "exp").steps(3).snapshot("flat/palette");
    flat::open(PLAIN).key(Key::Questionmark).snapshot("flat/shortcuts");
    let mut window = flat::open(PLAIN);
    window.app_mut().model.shell.messages.error(
        "Open",
        "this is not a picture that can be read; give PNG, JPEG, TIFF, PNM, WebP, BMP or .npy: /data/night/frame_003.png",
    );
    window.snapshot("flat/error_message");
    Start { size: PLAIN, ..Start::nothing_open() }.open().snapshot("flat/first_page");
}

#[test]
fn themes_sizes_and_planes_of_slopes() {
    let settings = Settings { theme: egui::ThemePreference::Light, ..given().settings };
    let startup = Startup { settings, ..given() };
    let mut window = flat::with_features(flat::open_with(Start { size: PLAIN, startup, ..Start::default() }));
    window.snapshot("flat/light_theme");
    let start = Start { size: [1000.0, 600.0], pixels_per_point: 2.0, ..Start::default() };
    flat::with_features(flat::open_with(start)).snapshot("flat/small_hidpi");
    let slopes = SlopeGrid::plane(-3.0..=3.0, 7, -2.0..=2.0, 5);
    let mut window = flat::with_features(flat::open_with(flat::at_slopes([1280.0, 720.0], slopes)));
    window.set().focused_mut().cursor.slope = Slope::new(1.6, -1.2);
    window.snapshot("flat/plane_of_slopes");
}

fn open_pair(size: [f32; 2]) -> Window {
    let mut window = Start::two_bursts(size).open();
    // The range of values depends on which picture came first: one before or after A's slope was found.
    let model = &mut window.app_mut().model;
    let picture = Read::of(model).picture().cloned().expect("A is on show");
    model.document.look.ranges.forget();
    model.document.look.ranges.fix_once(&picture);
    window
}

#[test]
fn two_bursts_and_single_match() {
    open_pair([1400.0, 900.0]).snapshot("two_bursts");
    open_pair([1400.0, 1000.0]).key(Key::Home).snapshot("single_match");
}

#[test]
fn methods_and_methods_matches_and_wipe() {
    open_pair([1400.0, 900.0]).ctrl(Key::Num3).snapshot("methods");
    let mut window = open_pair([1400.0, 1000.0]);
    window.ctrl(Key::Num3).settle().click("Match lines").snapshot("methods_matches");
    let mut window = open();
    window.ctrl(Key::Num3).settle().click("Wipe").snapshot("wipe");
}
