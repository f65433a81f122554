//! Pictures of the window, each compared with a stored one that was looked at; colours by coherence; contents that a
//! small window still shows.

use crate::support::{Start, Window, given};
use burstscope::Monitor;
use burstscope::app::Startup;
use burstscope::app::project::BottomTab;
use burstscope::app::project::side::Side;
use burstscope::app::settings::Settings;
use burstscope::detector::{Slope, SlopeGrid};
use burstscope::inspect::ProbeCache;
use burstscope::inspect::shares::coherences;
use burstscope::requests::BurstSource;
use egui::accesskit::Role;
use egui::{Key, Rect, pos2};
use egui_kittest::kittest::{NodeT, Queryable};

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
    let mut window = open();
    window.key(Key::Num1);
    window.snapshot("single_frame");
}

#[test]
fn dog_response() {
    let mut window = open();
    window.key(Key::Num3);
    // The axis of the histogram depends on earlier pictures, so each picture is waited for.
    window.settle();
    window.slide("Octave", 1.0);
    window.app_mut().model.bottom_tab = BottomTab::Tally;
    window.snapshot("dog_response");
}

#[test]
fn selected_feature() {
    let mut window = Start { size: [1280.0, 1100.0], ..Start::default() }.open();
    window.key(Key::Home);
    window.key(Key::Enter);
    window.snapshot("selected_feature");
}

#[test]
fn parameter_error() {
    let mut window = open();
    window.app_mut().model.params.slopes = SlopeGrid::line(3.0..=-3.0, 7);
    window.snapshot("parameter_error");
}

#[test]
fn palette() {
    let mut window = open();
    window.ctrl(Key::P);
    {
        use egui_kittest::kittest::Queryable;
        let field = window.harness.get_by_role_and_label(egui::accesskit::Role::TextInput, "Find an action");
        field.type_text("exp");
    }
    window.harness.run_steps(3);
    window.snapshot("palette");
}

#[test]
fn shortcuts() {
    let mut window = open();
    window.key(Key::Questionmark);
    window.snapshot("shortcuts");
}

#[test]
fn light_theme() {
    let settings = Settings { theme: egui::ThemePreference::Light, ..Settings::default() };
    let startup = Startup { settings, ..given() };
    let mut window = Start { size: PLAIN, startup, ..Start::default() }.open();
    window.key(Key::Home);
    window.snapshot("light_theme");
}

#[test]
fn small_hidpi() {
    let mut window = Start { size: [1000.0, 600.0], pixels_per_point: 2.0, ..Start::default() }.open();
    window.snapshot("small_hidpi");
}

#[test]
fn plane_of_slopes() {
    let mut start = Start { size: [1280.0, 720.0], ..Start::default() };
    start.startup.params.detector.slopes = SlopeGrid::plane(-3.0..=3.0, 7, -2.0..=2.0, 5);
    let mut window = start.open();
    window.app_mut().model.focused_mut().cursor.slope = Slope::new(1.6, -1.2);
    window.snapshot("plane_of_slopes");
}

#[test]
fn first_page() {
    Start { size: PLAIN, ..Start::nothing_open() }.open().snapshot("first_page");
}

#[test]
fn error_message() {
    let mut window = open();
    window.app_mut().model.messages.error(
        "Open",
        "this is not a picture that can be read; give PNG, JPEG, TIFF, PNM, WebP, BMP or .npy: /data/night/frame_003.png",
    );
    window.snapshot("error_message");
}

/// Two bursts of the demo street in a window of `size`.
fn open_pair(size: [f32; 2]) -> Window {
    let mut start = Start { size, ..Start::default() };
    start.startup.second = Some(burstscope::requests::BurstSource::DemoLater);
    let mut window = start.open();
    // The range of values depends on which picture came first: one before or after A's slope was found.
    let model = &mut window.app_mut().model;
    let picture = model.picture().cloned().expect("A is on show");
    model.look.ranges.forget();
    model.look.ranges.fix_once(&picture);
    window
}

#[test]
fn two_bursts() {
    open_pair([1400.0, 900.0]).snapshot("two_bursts");
}

#[test]
fn single_match() {
    let mut window = open_pair([1400.0, 1000.0]);
    window.key(Key::Home);
    window.snapshot("single_match");
}

#[test]
fn methods() {
    let mut window = open_pair([1400.0, 900.0]);
    window.click("Methods");
    window.snapshot("methods");
}

#[test]
fn methods_matches() {
    let mut window = open_pair([1400.0, 1000.0]);
    window.click("Methods");
    window.settle();
    window.click("Match lines");
    window.snapshot("methods_matches");
}

#[test]
fn wipe() {
    let mut window = open();
    window.click("Methods");
    window.settle();
    window.click("Wipe");
    window.snapshot("wipe");
}

fn colour_by_coherence(window: &mut Window) {
    window.harness.get_by_role_and_label(Role::ComboBox, "Colour by").click();
    window.harness.run_steps(4);
    window.click("Coherence");
}

#[test]
fn colours_tell_the_coherence_and_features_are_grey_until_it_is_known() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() }.open();
    window.run_action("detect");
    window.settle();
    colour_by_coherence(&mut window);
    window.settle();
    // The values are those of the library.
    let model = &window.app().model;
    let detection = model.slots.a.found.as_ref().unwrap().detection.clone();
    let values = model.coherence.of(&detection).unwrap().clone();
    let cache =
        ProbeCache::new(&model.slots.a.burst.as_ref().unwrap().burst, &model.asked(), &Monitor::default()).unwrap();
    assert_eq!(*values, coherences(&cache.trail, &Monitor::default()).unwrap());
    assert!(window.shows("Legend: coherence from 0 to 1") && !window.shows("Grey: not computed yet"));
    assert_eq!(window.shows("Grey: too noisy to tell"), values.iter().any(Option::is_none));
    // The selected feature and the one under the pointer show their values.
    let index = (0..values.len()).find(|&i| values[i].is_some_and(|c| c < 0.995)).expect("one is not quite even");
    let text = format!("{:.2}", values[index].unwrap());
    window.app_mut().model.selected = Some(index);
    window.harness.run_steps(2);
    window.settle();
    assert!(window.shows("Coherence") && window.shows(&text));
    let feature = detection.features[index];
    let at = window.app().ui_from_image(pos2(feature.u, feature.v)).unwrap();
    window.harness.hover_at(at);
    window.harness.run_steps(3);
    assert!(window.shows("\ncoherence "), "the pointer says it");
    window.snapshot("coherence");
    // The figure has these colours too, with a legend.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coherence.svg");
    window.app_mut().model.figure.legend = true;
    window.dialogs.will_choose(&path);
    window.run_action("figure as svg");
    window.settle();
    let svg = std::fs::read_to_string(&path).unwrap();
    let colours: std::collections::BTreeSet<&str> = svg
        .lines()
        .filter(|line| line.contains("<circle"))
        .filter_map(|line| line.split("stroke=\"").nth(1)?.split('"').next())
        .collect();
    assert!(colours.len() > 5 && svg.contains(">0.75"), "{colours:?}");
    // Another detection has other values; unknown ones are grey, and choosing the quantity again restarts a cancelled
    // computation.
    window.app_mut().model.params.octaves = 2;
    window.run_action("detect");
    window.settle();
    let now = window.app().model.slots.a.found.as_ref().unwrap().detection.clone();
    let model = &mut window.app_mut().model;
    assert!(model.coherence.of(&detection).is_none() && model.coherence.of(&now).is_some());
    model.coherence = Default::default();
    let missing = model.missing_coherence(Side::A).expect("it is shown, and was forgotten");
    let app = window.app_mut();
    app.model.coherence.wanted.a.ask(&app.engine, missing);
    app.model.coherence.wanted.a.cancel();
    window.settle();
    assert!(window.shows("Grey: cancelled"));
    colour_by_coherence(&mut window);
    window.settle();
    assert!(window.app().model.coherence.of(&now).is_some() && !window.shows("Grey: cancelled"));
}

fn rect_of(window: &Window, role: Role, label: &str) -> Rect {
    window.harness.get_by_role_and_label(role, label).rect()
}

#[test]
fn at_1024_by_700_the_picture_and_the_columns_that_matter_are_seen() {
    let mut window = Start { size: [1024.0, 700.0], ..Start::default() }.open();
    window.key(Key::Home);
    window.settle();
    window.snapshot("small_window");
    // The panel on the right ends where the table does.
    let right = rect_of(&window, Role::Button, "Why?").left();
    for heading in ["#", "u", "v", "σ", "Slope u", "Slope v", "SNR"] {
        let rect = rect_of(&window, Role::Button, &format!("Sort by {heading}"));
        assert!(rect.right() < right && rect.bottom() < 700.0, "{heading}: {rect:?}, but {right}");
    }
    let visible = window.app().widgets.get(window.app().model.focus()).and_then(|w| w.picture.visible_image).unwrap();
    let (width, height) = window.app().model.size();
    assert!(visible.width() >= width as f32 && visible.height() >= height as f32, "the whole picture: {visible:?}");
}

#[test]
fn the_numbers_of_two_bursts_fit_at_960_points() {
    let mut start = Start { size: [960.0, 640.0], ..Start::default() };
    start.startup.second = Some(BurstSource::DemoLater);
    let mut window = start.open();
    assert!(window.app().model.found_of(Side::B).is_some());
    window.snapshot("two_bursts_narrow");
    // Between the two panels on the sides.
    let left = rect_of(&window, Role::Slider, "Slope v").right();
    let right = window.harness.get_by_label("Selected match").rect().left();
    let wide = |role: Role, name: &str| {
        let named = window.harness.query_all_by_label_contains(name);
        let rects = named.filter(|node| node.accesskit_node().role() == role).map(|node| node.rect());
        // The numbers' line contains the name alone too, and the name with its value.
        rects.max_by(|a, b| a.width().total_cmp(&b.width())).unwrap_or_else(|| panic!("{name} is missing"))
    };
    let numbers = ["Keypoints", "Putative", "Inliers", "Match ratio", "Match score", "Precision"];
    let lost = ["no keypoint", "ratio test", "mutual check", "geometry"];
    let rects: Vec<Rect> = numbers
        .map(|name| wide(Role::Label, name))
        .into_iter()
        .chain(lost.map(|name| wide(Role::CheckBox, name)))
        .collect();
    for (index, rect) in rects.iter().enumerate() {
        assert!(rect.left() > left && rect.right() < right && rect.bottom() < 640.0, "{index}: {rect:?}");
        assert!(rects[..index].iter().all(|other| !other.shrink(1.0).intersects(*rect)), "{rects:?}");
    }
}
