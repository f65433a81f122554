//! Measurements in a picture: a line and a rectangle drawn on it; found, missed, repeated and other features, where the
//! truth is known.

use crate::support::*;
use burstscope::app::measure::Tool;
use burstscope::inspect::result::{against_truth, truth_of};
use burstscope::plane::{sample::profile, sample::region_statistics, statistics::Region};

fn open() -> Window {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    window.key(Key::Num6).settle();
    window
}

fn drag(window: &mut Window, from: Pos2, to: Pos2) {
    let [from, to] = [from, to].map(|pos| window.ui_from_image(pos).unwrap());
    window.hover(from).steps(1);
    window.harness.drag_at(from);
    window.steps(1);
    for i in 1..=4 {
        window.hover(from + (to - from) * (i as f32 / 4.0)).steps(1);
    }
    window.harness.drop_at(to);
    window.steps(2);
}

#[test]
fn the_values_along_a_line_are_shown_of_all_linked_panes_and_exported() {
    let (_folder, file) = folder_with("profile.csv");
    let mut window = open();
    let view = window.document().focused().view;
    window.key(Key::Q);
    drag(&mut window, pos2(100.0, 80.0), pos2(220.0, 170.0));
    window.settle();
    assert_eq!(window.document().focused().view.centre_image, view.centre_image, "the tool draws and does not pan");
    let line = window.document().measure.line.expect("a line was drawn");
    assert!((line.from_image - pos2(100.0, 80.0)).length() < 1.5, "{line:?}");
    assert_eq!(window.document().bottom_tab, BottomTab::Profile);
    assert!(window.has(Role::Image, "Profile of 2 pictures"));
    window.will_choose(&file).click("Export as CSV…").settle();
    let text = fs::read_to_string(&file).unwrap();
    let rows: Vec<&str> = text.lines().skip(1).collect();
    // The stack is the second pane; the frame shows the line half a frame later, moved along its slope.
    let stack = window.read().picture().unwrap().plane.clone();
    let expected = profile(&stack, line.from_image.into(), line.to_image.into(), 1.0);
    let of_stack: Vec<&&str> = rows.iter().filter(|row| row.starts_with("\"2  Stack")).collect();
    assert_eq!((of_stack.len(), rows.len()), (expected.len(), 2 * expected.len()));
    let value: f32 = of_stack[10].rsplit(',').next().unwrap().parse().unwrap();
    assert_eq!(value, expected[10].value);
    let u = |row: &str| row.rsplit(',').nth(2).unwrap().parse::<f32>().unwrap();
    assert!((u(rows[0]) - u(of_stack[0]) + 1.0).abs() < 1e-3, "{} {}", rows[0], of_stack[0]);
    // Escape deselects the tool, and the pointer pans again.
    window.key(Key::Escape);
    assert_eq!(window.document().measure.tool, Tool::Pan);
    window.click("Clear line");
    assert!(window.shows("Drag a line on a picture"));
}

#[test]
fn a_rectangle_is_measured_in_all_linked_panes() {
    let mut window = open();
    window.shift(Key::Q);
    drag(&mut window, pos2(200.0, 60.0), pos2(300.0, 130.0));
    window.settle();
    assert_eq!(window.document().bottom_tab, BottomTab::Region);
    let rect = window.document().measure.region.expect("a rectangle was drawn").rect_image;
    let stack = window.read().picture().unwrap().plane.clone();
    let pixels = |low: f32, high: f32| (low + 0.5).floor() as usize..(high + 0.5).ceil() as usize;
    let region = Region { columns: pixels(rect.min.x, rect.max.x), rows: pixels(rect.min.y, rect.max.y) };
    let expected = region_statistics(&stack, &region).unwrap();
    assert!(window.shows(&expected.count.to_string()));
    assert!(window.shows(&burstscope::app::canvas::number(expected.mean as f32, 5)));
    assert!(window.shows(&burstscope::app::canvas::number(expected.noise.unwrap() as f32, 4)));
    assert!(window.has(Role::Image, "Histogram of the region"));
}

#[test]
fn line_profile_and_region_statistics_panel() {
    let mut window = open();
    window.key(Key::Q);
    drag(&mut window, pos2(40.0, 150.0), pos2(440.0, 110.0));
    window.snapshot("line_profile");
    let mut window = crate::flat::open([1280.0, 800.0]);
    window.shift(Key::Q);
    drag(&mut window, pos2(200.0, 30.0), pos2(330.0, 120.0));
    window.snapshot("flat/region_statistics");
}

#[test]
fn the_demo_knows_what_was_found_and_why_the_rest_was_missed() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    window.run_action("compare with the truth").settle();
    let burst = &window.opened().burst;
    let cache = ProbeCache::new(burst, &window.found().asked, &Monitor::default()).unwrap();
    let truth = truth_of(burst).unwrap().expect("the demo's truth is known");
    let expected = against_truth(&cache, &truth, &Monitor::default()).unwrap();
    let detection: &Detection = &window.found().detection;
    assert_eq!(cache.detection().features, detection.features, "the truth is held against the features on show");
    let shown = window.read().shown_comparison(Side::A).expect("a comparison");
    assert_eq!(shown.with, Reference::Truth);
    let kinds = [Compared::Same, Compared::Theirs, Compared::Repeated, Compared::Ours, Compared::WrongMotion];
    let counts = kinds.map(|kind| shown.count(kind));
    let sizes = [expected.found.len(), expected.missed.len(), expected.repeated.len(), expected.elsewhere.len()];
    assert_eq!(counts[..4], sizes);
    assert_eq!(counts[4], expected.at_wrong_motion.len());
    assert!(counts[0] > 0 && counts[1] > 0 && counts[4] > 0, "{counts:?}");
    assert!(window.shows(" at a wrong motion, "));
    let mut otherwise = shown.rows.iter().filter(|row| row.kind == Compared::WrongMotion);
    assert!(otherwise.all(|row| row.note.starts_with("slope ") && row.note.contains(" instead of ")));
    // The truth of a scene lists only some of its features.
    assert!(expected.summary().ends_with("elsewhere") && window.shows(&expected.summary()));
    assert!(!shown.is_whole_truth && !window.document().comparisons.a.shows(Compared::Ours));
    assert_eq!(shown.rows[0].note, expected.missed[0].why);
    // The row stays in its place when it is selected, and selected when it is clicked again.
    let place = window.rect(Role::Row, "Missed 0");
    for _ in 0..2 {
        window.click_on(Role::Row, "Missed 0").settle();
        assert_eq!(window.document().comparisons.a.selected, Some(0));
        assert_eq!(window.rect(Role::Row, "Missed 0"), place);
    }
    assert!(window.shows(&expected.missed[0].why));
    window.snapshot("truth").click("Why here?").settle();
    let place = window.read().probed_place().expect("the place is probed");
    let miss = &truth.features[expected.missed[0].disc];
    assert!((f64::from(place[0]) - miss.u).abs() < 0.01 && (f64::from(place[1]) - miss.v).abs() < 0.01);
}

#[test]
fn a_burst_of_the_camera_has_no_truth_to_compare_with() {
    let folder = folder();
    let mut window = Start::of(&noisy_stack(&folder, 4, 60, 80)).open();
    window.click("Detect").settle();
    assert!(!window.read().has_reference(Side::A, Reference::Truth));
    window.run_action("compare with the truth").settle();
    assert_eq!(window.document().comparisons.a.with, None);
}
