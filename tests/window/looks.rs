//! Pictures of the window. Each was looked at; a changed one has to be looked at again.

use crate::flat;
use crate::support::*;

const PLAIN: [f32; 2] = [1280.0, 800.0];

fn open() -> Window {
    Start { size: PLAIN, ..Start::default() }.open()
}

#[test]
fn start() {
    open().snapshot("start");
}

#[test]
fn single_frame() {
    flat::open(PLAIN).key(Key::Num1).snapshot("flat/single_frame");
}

#[test]
fn dog_response() {
    let mut window = open();
    window.key(Key::Num3);
    // The axis of the histogram depends on earlier pictures, so each picture is waited for.
    window.settle();
    window.slide("Octave", 1.0).change(|document| document.bottom_tab = BottomTab::Tally);
    window.snapshot("dog_response");
}

#[test]
fn selected_feature() {
    let mut window = Start { size: [1280.0, 1100.0], ..Start::default() }.open();
    window.key(Key::Home).key(Key::Enter).snapshot("selected_feature");
}

#[test]
fn parameter_error() {
    let mut window = flat::with_features(flat::open(PLAIN));
    window.app_mut().model.document.params.slopes = SlopeGrid::line(3.0..=-3.0, 7).into();
    window.snapshot("flat/parameter_error");
}

#[test]
fn palette() {
    let mut window = flat::open(PLAIN);
    window.ctrl(Key::P);
    {
        use egui_kittest::kittest::Queryable;
        let field = window.harness.get_by_role_and_label(Role::TextInput, "Find an action");
        field.type_text("exp");
    }
    window.steps(3).snapshot("flat/palette");
}

#[test]
fn shortcuts() {
    flat::open(PLAIN).key(Key::Questionmark).snapshot("flat/shortcuts");
}

#[test]
fn light_theme() {
    let settings = Settings { theme: egui::ThemePreference::Light, ..given().settings };
    let startup = Startup { settings, ..given() };
    let mut window = flat::with_features(flat::open_with(Start { size: PLAIN, startup, ..Start::default() }));
    window.snapshot("flat/light_theme");
}

#[test]
fn small_hidpi() {
    let start = Start { size: [1000.0, 600.0], pixels_per_point: 2.0, ..Start::default() };
    flat::with_features(flat::open_with(start)).snapshot("flat/small_hidpi");
}

#[test]
fn plane_of_slopes() {
    let slopes = SlopeGrid::plane(-3.0..=3.0, 7, -2.0..=2.0, 5);
    let mut window = flat::with_features(flat::open_with(flat::at_slopes([1280.0, 720.0], slopes)));
    window.app_mut().model.document.focused_mut().cursor.slope = Slope::new(1.6, -1.2);
    window.snapshot("flat/plane_of_slopes");
}

#[test]
fn first_page() {
    Start { size: PLAIN, ..Start::nothing_open() }.open().snapshot("flat/first_page");
}

#[test]
fn error_message() {
    let mut window = flat::open(PLAIN);
    window.app_mut().model.shell.messages.error(
        "Open",
        "this is not a picture that can be read; give PNG, JPEG, TIFF, PNM, WebP, BMP or .npy: /data/night/frame_003.png",
    );
    window.snapshot("flat/error_message");
}

/// Two bursts of the demo street in a window of `size`.
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
fn two_bursts() {
    open_pair([1400.0, 900.0]).snapshot("two_bursts");
}

#[test]
fn single_match() {
    open_pair([1400.0, 1000.0]).key(Key::Home).snapshot("single_match");
}

#[test]
fn methods() {
    open_pair([1400.0, 900.0]).ctrl(Key::Num3).snapshot("methods");
}

#[test]
fn methods_matches() {
    let mut window = open_pair([1400.0, 1000.0]);
    window.ctrl(Key::Num3).settle();
    window.click("Match lines").snapshot("methods_matches");
}

#[test]
fn wipe() {
    let mut window = open();
    window.ctrl(Key::Num3).settle();
    window.click("Wipe").snapshot("wipe");
}
