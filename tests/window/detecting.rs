//! Detecting, cancelling, selecting, sorting, filtering.

use crate::support::*;
use burstscope::inspect::words::counted;

#[test]
fn detect_finds_what_the_detector_finds() {
    let mut window = Start::without_auto_detect().open();
    assert!(window.results().slots.a.found.is_none());
    window.click("Detect").settle();
    let model = window.model();
    let burst = &model.results.slots.a.burst.as_ref().unwrap().burst;
    let expected = burstscope::detect(burst, &model.document.params.at_given(), &Monitor::default()).unwrap();
    assert_eq!(Read::of(model).features(), expected.features);
    assert!(window.shows(&format!("{} in", counted(expected.features.len(), "feature"))));
}

#[test]
fn what_is_pointed_at_is_marked_as_long_as_the_pointer_is_there() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    window.change(|document| document.look.overlay = FeaturesShown::All).settle();
    let strongest = &window.read().features()[0];
    let in_picture = window.ui_from_image(pos2(strongest.u, strongest.v)).unwrap();
    let in_table = window.harness.get_by_role_and_label(Role::Row, "Feature 1").rect().center();
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
    window.app_mut().model.document.look.overlay = FeaturesShown::All;
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
    window.app_mut().model.document.focused_mut().view.look_at(pos2(feature.u, feature.v), POINTS_PER_PX);
    window.settle();
    let pos = window.ui_from_image(pos2(feature.u, feature.v)).unwrap();
    window.click_at(pos);
    assert_eq!(window.document().selected, Some(index));
    window.settle();
    assert!(window.shows(&format!("{:.2}, {:.2} px", feature.u, feature.v)), "the panel shows its numbers");
    assert!(window.harness.query_by_role_and_label(Role::Image, "Descriptor").is_some());
    assert!(window.harness.query_by_role_and_label(Role::Image, "Patch in the motion stack").is_some());
    // The table scrolls to the feature with the row above visible.
    // The row is wider than what is seen of it.
    let row = window.harness.get_by_role_and_label(Role::Row, &format!("Feature {}", index - 1)).rect();
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
fn nothing_found_says_which_setting_to_change() {
    let mut start = Start::without_auto_detect();
    start.startup.params.peak_threshold = 0.5;
    let mut window = start.open();
    window.click("Detect").settle();
    assert!(window.read().features().is_empty());
    assert!(window.shows("No feature was found") && window.shows("; try Peak threshold 0"));
    // The advice is shown only while it holds.
    window.change(|document| document.params.peak_threshold = 0.0).steps(2);
    assert!(!window.shows("; try Peak threshold 0"));
}

#[test]
fn a_detection_is_cancelled_and_the_window_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut start = Start::of(&noisy_stack(folder.path(), 12, 700, 900));
    // Many slopes, of which a cancelled search takes only the first.
    start.startup.params.slopes = SlopeGrid::plane(-4.0..=4.0, 49, -4.0..=4.0, 49).into();
    let mut window = start.open();
    window.click("Detect").wait("the detection runs", |app| app.model.results.slots.a.detecting.is_pending());
    // Scrubbing works while the detection runs.
    window.slide("Slope u", 1.0).wait("the picture of the new slope", |app| app.read().picture_is_current());
    assert!(
        window.results().slots.a.detecting.is_pending(),
        "the detection must still run for this test to mean something"
    );
    window.click("Cancel").wait("the detection ends", |app| !app.model.results.slots.a.detecting.is_pending());
    // A search that is cancelled has the features of its first slope, or none.
    let has_all = |window: &Window| window.results().slots.a.found.as_ref().is_some_and(|found| !found.is_first_slope);
    assert!(!has_all(&window));
    assert!(window.shows("Detection cancelled"));
    window.settle();
    window.click("Detect").wait("it runs again", |app| app.model.results.slots.a.detecting.is_pending());
    window.harness.key_press(Key::Escape);
    window.wait("the key ends it", |app| !app.model.results.slots.a.detecting.is_pending());
    assert!(!has_all(&window));
    window.change(|document| document.auto_detect = true).settle();
    assert!(!has_all(&window), "what was cancelled is not begun again by itself");
    assert!(window.model().shell.messages.errors.is_empty(), "a person did not want it");
}

#[test]
fn features_of_other_parameters_are_marked_as_stale_until_detected_again() {
    let mut window = Start::without_auto_detect().open();
    window.click("Detect").settle();
    window.run_action("preset sift").settle();
    assert_eq!(window.document().params.method, Method::Sift);
    assert!(window.shows("Stale features"));
    window.click("Detect again").settle();
    assert!(!window.shows("Stale features"));
    assert_eq!(window.results().slots.a.found.as_ref().unwrap().detection.slopes.len(), 1);
}

#[test]
fn with_the_switch_on_a_change_is_detected_by_itself() {
    let mut window = Start::default().open();
    let before = window.read().features().len();
    window.change(|document| document.params.max_features = 3).settle();
    assert!(before > 3);
    assert_eq!(window.results().slots.a.found.as_ref().unwrap().params.max_features, 3);
    assert!(window.read().stale().is_none());
}

#[test]
fn a_parameter_that_makes_no_sense_says_so_and_can_be_reset() {
    let mut window = Start::default().open();
    let none = SlopeGrid { u: SlopeAxis { count: 0, ..SlopeAxis::ZERO }, ..SlopeGrid::default() };
    window.change(|document| document.params.slopes = none.into()).settle();
    assert!(window.shows("the count is 0: give at least 1 slope"));
    assert!(window.shows("the parameters are invalid"));
    assert!(window.read().picture_is_current(), "pictures go on");
    window.click("Reset Slopes u").settle();
    assert_eq!(window.results().slots.a.param_error, None);
}

#[test]
fn headings_sort_and_the_filter_leaves_out() {
    let mut window = Start::default().open();
    window.click("Sort by σ").settle();
    let model = window.model();
    assert_eq!(model.document.order.column, Quantity::Sigma);
    let sigmas: Vec<f32> = model.results.listed.iter().map(|&i| Read::of(model).features()[i].sigma).collect();
    assert!(sigmas.is_sorted() && sigmas.len() > 5);
    let total = sigmas.len();
    window.click_on(Role::CheckBox, "At this slope").settle();
    let model = window.model();
    assert!(!model.results.listed.is_empty() && model.results.listed.len() < total);
    assert!(window.shows(&format!("{} of {total}", model.results.listed.len())));
    window.click("Clear filter").settle();
    assert_eq!(window.results().listed.len(), total);
}

#[test]
fn looking_at_the_filter_changes_nothing_and_its_sliders_do() {
    let mut window = Start::default().open();
    let total = window.read().features().len();
    window.click("Filter").steps(3);
    assert!(window.document().filter.is_open());
    assert_eq!(window.results().listed.len(), total);
    // The first row with handles is slope u, the second the scale.
    window.harness.get_all_by_role_and_label(Role::Slider, "low").nth(1).unwrap().set_value_accesskit(4.0);
    window.settle();
    let model = window.model();
    let expected = Read::of(model).features().iter().filter(|f| f.sigma >= 4.0).count();
    assert!(
        expected < total && model.results.listed.len() == expected,
        "{} {expected} {total}",
        model.results.listed.len()
    );
}

#[test]
fn every_parameter_has_a_row_with_its_name_and_unit() {
    let window = Start { size: [1280.0, 1400.0], ..Start::without_auto_detect() }.open();
    for doc in burstscope::detector::params::doc::ALL {
        assert!(
            window.harness.query_all_by_label(doc.label).next().is_some() || window.shows(doc.label),
            "{}",
            doc.label
        );
        assert!(doc.unit.is_empty() || window.shows(doc.unit), "the unit of {}", doc.label);
    }
}

#[test]
fn a_key_pressed_twice_between_two_pictures_counts_twice() {
    let mut window = Start::without_auto_detect().open();
    window.harness.key_press(Key::ArrowRight);
    window.harness.key_press(Key::ArrowRight);
    window.harness.step();
    assert_eq!(window.document().cursor().slope.u, 2.0);
}
