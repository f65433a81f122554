//! Detecting, cancelling, selecting, sorting, filtering.

use crate::support::*;
use burstscope::inspect::words::counted;

#[test]
fn detect_finds_what_the_detector_finds_and_of_other_parameters_it_is_stale_until_detected_again() {
    let mut window = Start::without_auto_detect().open();
    assert!(window.results().slots.a.found.is_none());
    window.click("Detect").settle();
    let burst = &window.opened().burst;
    let expected = burstscope::detect(burst, &window.document().params.at_given(), &Monitor::default()).unwrap();
    assert_eq!(window.read().features(), expected.features);
    assert!(window.shows(&format!("{} in", counted(expected.features.len(), "feature"))));
    window.click("Detect").settle().run_action("preset sift").settle();
    assert_eq!(window.document().params.method, Method::Sift);
    assert!(window.shows("Stale features"));
    window.click("Detect again").settle();
    assert!(!window.shows("Stale features"));
    assert_eq!(window.found().detection.slopes.len(), 1);
    let mut window = Start::without_auto_detect().open();
    window.harness.key_press(Key::ArrowRight);
    window.harness.key_press(Key::ArrowRight);
    window.harness.step();
    assert_eq!(window.document().cursor().slope.u, 2.0);
}

#[test]
fn what_is_pointed_at_is_marked_as_long_as_the_pointer_is_there() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    window.change(|document| document.look.overlay = FeaturesShown::All).settle();
    let strongest = &window.read().features()[0];
    let in_picture = window.ui_from_image(pos2(strongest.u, strongest.v)).unwrap();
    let in_table = window.rect(Role::Row, "Feature 1").center();
    let elsewhere = pos2(640.0, 790.0);
    for (pos, wanted) in [(in_picture, true), (elsewhere, false), (in_table, true), (elsewhere, false)] {
        window.hover(pos).steps(3);
        assert_eq!(window.results().hovered.is_some(), wanted, "{pos}");
    }
    // A hidden table has no row under the pointer.
    window.hover(in_table).steps(3);
    assert_eq!(window.results().hovered, Some(1));
    window.ctrl(Key::J).steps(3);
    assert_ne!(window.results().hovered, Some(1));
}

#[test]
fn a_feature_is_selected_in_the_picture_and_in_the_table() {
    let mut window = Start::default().open();
    window.set().look.overlay = FeaturesShown::All;
    let features = window.read().features().to_vec();
    // Zoomed in enough to tell features apart, on one with no other nearby, so that the click is unambiguous.
    const POINTS_PER_PX: f32 = 8.0;
    let alone = |i: usize| {
        features.iter().enumerate().all(|(j, g)| {
            let f = &features[i];
            let (distance, radius) = ((f.u - g.u).hypot(f.v - g.v), std::f32::consts::SQRT_2 * g.sigma);
            i == j || distance.min((distance - radius).abs()) * POINTS_PER_PX > 12.0
        })
    };
    let index = (0..features.len()).find(|&i| alone(i)).expect("the demo has a feature that stands alone");
    let feature = features[index];
    window.set().focused_mut().view.look_at(pos2(feature.u, feature.v), POINTS_PER_PX);
    window.settle();
    let pos = window.ui_from_image(pos2(feature.u, feature.v)).unwrap();
    window.click_at(pos);
    assert_eq!(window.document().selected, Some(index));
    window.settle();
    assert!(window.shows(&format!("{:.2}, {:.2} px", feature.u, feature.v)), "the panel shows its numbers");
    assert!(window.has(Role::Image, "Descriptor"));
    assert!(window.has(Role::Image, "Patch in the motion stack"));
    // The table scrolls to the feature with the row above visible.
    // The row is wider than what is seen of it.
    let row = window.rect(Role::Row, &format!("Feature {}", index - 1));
    window.click_at(row.left_center() + vec2(80.0, 0.0)).steps(2);
    assert_eq!(window.document().selected, Some(index - 1));
    window.key(Key::N);
    assert_eq!(window.document().selected, Some(index));
    window.key(Key::P);
    assert_eq!(window.document().selected, Some(index - 1));
    window.key(Key::Escape);
    assert_eq!(window.document().selected, None);
}

#[test]
fn nothing_found_says_which_setting_to_change_and_every_parameter_has_a_row_with_its_name_and_unit() {
    let mut start = Start::without_auto_detect();
    start.startup.params.peak_threshold = 0.5;
    let mut window = start.open();
    window.click("Detect").settle();
    assert!(window.read().features().is_empty());
    assert!(window.shows("No feature was found") && window.shows("; try Peak threshold 0"));
    window.click("Apply setting").steps(2);
    assert!(window.document().params.peak_threshold == 0.0 && !window.shows("; try Peak threshold 0"));
    window.click("Detect").settle();
    assert!(!window.read().features().is_empty());
    let window = Start { size: [1280.0, 1400.0], ..Start::without_auto_detect() }.open();
    for doc in burstscope::detector::params::doc::ALL {
        assert!(window.shows(doc.label) && window.shows(doc.unit), "{} or its unit", doc.label);
    }
}

#[test]
fn a_detection_is_cancelled_and_the_window_goes_on() {
    let folder = folder();
    let mut start = Start::of(&noisy_stack(&folder, 12, 700, 900));
    // Many slopes, of which a cancelled search takes only the first.
    start.startup.params.slopes = SlopeGrid::plane(-4.0..=4.0, 49, -4.0..=4.0, 49).into();
    let mut window = start.open();
    window.click("Detect").wait("the detection runs", |app| app.model.results.slots.a.detecting.is_pending());
    window.slide("Slope u", 1.0).wait("the picture of the new slope", |app| app.read().picture_is_current());
    assert!(window.results().slots.a.detecting.is_pending(), "it must still run for this test to mean something");
    window.click("Cancel").wait("the detection ends", |app| !app.model.results.slots.a.detecting.is_pending());
    // A search that is cancelled has the features of its first slope, or none.
    let has_all = |window: &Window| window.results().slots.a.found.as_ref().is_some_and(|found| !found.is_first_slope);
    assert!(!has_all(&window));
    assert!(window.shows("Detection cancelled"));
    window.settle().click("Detect").wait("it runs again", |app| app.model.results.slots.a.detecting.is_pending());
    window.harness.key_press(Key::Escape);
    window.wait("the key ends it", |app| !app.model.results.slots.a.detecting.is_pending());
    assert!(!has_all(&window));
    window.change(|document| document.auto_detect = true).settle();
    assert!(!has_all(&window), "what was cancelled is not begun again by itself");
    assert!(window.errors().is_empty(), "a person did not want it");
}

#[test]
fn with_the_switch_on_a_change_is_detected_by_itself() {
    let mut window = Start::default().open();
    let before = window.read().features().len();
    window.change(|document| document.params.max_features = 3).settle();
    assert!(before > 3);
    assert_eq!(window.found().params.max_features, 3);
    assert!(window.read().stale().is_none());
    let none = SlopeGrid { u: SlopeAxis { count: 0, ..SlopeAxis::ZERO }, ..SlopeGrid::default() };
    window.change(|document| document.params.slopes = none.into()).settle();
    assert!(window.shows("the count is 0: give at least 1 slope"));
    assert!(window.shows("the parameters are invalid"));
    assert!(window.read().picture_is_current(), "pictures go on");
    window.click("Reset Slopes u").settle();
    assert_eq!(window.results().slots.a.param_error, None);
}

#[test]
fn headings_sort_and_the_filter_leaves_out_what_its_sliders_say() {
    let mut window = Start::default().open();
    window.click("Sort by σ").settle();
    assert_eq!(window.document().order.column, Quantity::Sigma);
    let sigmas: Vec<f32> = window.results().listed.iter().map(|&i| window.read().features()[i].sigma).collect();
    assert!(sigmas.is_sorted() && sigmas.len() > 5);
    let total = sigmas.len();
    window.click_on(Role::CheckBox, "At this slope").settle();
    assert!(!window.results().listed.is_empty() && window.results().listed.len() < total);
    assert!(window.shows(&format!("{} of {total}", window.results().listed.len())));
    window.click("Clear filter").settle();
    assert_eq!(window.results().listed.len(), total);
    window.click("Filter").steps(3);
    assert!(window.document().filter.is_open());
    assert_eq!(window.results().listed.len(), total);
    // The first row with handles is slope u, the second the scale.
    window.harness.get_all_by_role_and_label(Role::Slider, "low").nth(1).unwrap().set_value_accesskit(4.0);
    window.settle();
    let expected = window.read().features().iter().filter(|f| f.sigma >= 4.0).count();
    assert!(expected < total);
    assert_eq!(window.results().listed.len(), expected);
}
