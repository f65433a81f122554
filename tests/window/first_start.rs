//! The first start: most of the window is picture, a card says how to go on, and panels come when they are asked for.

use crate::support::*;

/// Rectangle of the picture itself, without its header.
fn picture(window: &Window) -> Rect {
    window.rect(Role::Canvas, "Picture")
}

fn share(window: &Window) -> f32 {
    picture(window).area() / window.harness.ctx.content_rect().area()
}

#[test]
fn most_of_the_window_is_picture_at_the_first_start() {
    // A small window is nearly all picture, and a narrow one has its menus beside the workspaces.
    for (size, least, name) in [
        ([1280.0, 800.0], 0.60, "first_start"),
        ([960.0, 640.0], 0.75, "first_start_960"),
        ([720.0, 900.0], 0.75, "first_start_720"),
    ] {
        let mut window = Start::first(size).open();
        assert!(share(&window) >= least, "{size:?}: {}", share(&window));
        window.snapshot(name);
    }
    Start { pixels_per_point: 2.0, ..Start::first([960.0, 640.0]) }.open().snapshot("first_start_hidpi");
}

/// Texts in the window of more than three words, without the name of the picture.
fn sentences(window: &Window) -> Vec<String> {
    let texts = window.harness.query_all_by_role(Role::Label).filter_map(|label| label.value());
    texts.filter(|text| text.split_whitespace().count() > 3 && !text.starts_with("Motion stack")).collect()
}

#[test]
fn the_first_start_has_no_more_controls_and_sentences_than_are_counted_here() {
    let window = Start::first([1280.0, 800.0]).open();
    let roles =
        [Role::Button, Role::CheckBox, Role::Slider, Role::SpinButton, Role::ComboBox, Role::DisclosureTriangle];
    let count: usize = roles.iter().map(|role| window.harness.query_all_by_role(*role).count()).sum();
    let told = sentences(&window);
    // The bounds only fall.
    assert!(count <= 30 && told.len() <= 5, "{count} controls; {} sentences: {told:#?}", told.len());
    assert_eq!(told.iter().filter(|text| text.contains("slopes")).count(), 1, "{told:#?}");
}

/// Parts of the sentences about slopes, without what tells their beginning and end.
fn told_of_slopes(window: &Window) -> Vec<String> {
    let parts = |text: &String| {
        let parts = text.split("; ").map(|part| part.trim_end_matches('.').to_lowercase());
        parts.filter(|part| ["slope", "limit", "range"].iter().any(|word| part.contains(word))).collect::<Vec<_>>()
    };
    sentences(window).iter().flat_map(parts).filter(|part| part.split_whitespace().count() > 3).collect()
}

#[test]
fn nothing_about_slopes_stands_on_the_screen_twice() {
    let tabs = [BottomTab::Table, BottomTab::Tally, BottomTab::Noise, BottomTab::Slopes];
    // Slopes that were found, and slopes that are too few.
    for slopes in [Slopes::AUTO, SlopeGrid::line(-1.0..=1.0, 5).into()] {
        let mut window = Start { size: [1280.0, 900.0], ..Start::automatic() }.open();
        window.change(|document| document.params.slopes = slopes).settle();
        for tab in tabs {
            window.change(|document| document.bottom_tab = tab).settle();
            let judged = window.read().slope_judgement().expect("judged").clone();
            assert_eq!(judged.advice.is_some(), slopes != Slopes::AUTO, "{judged:?}");
            let told = told_of_slopes(&window);
            let once: BTreeSet<&String> = told.iter().collect();
            assert_eq!(once.len(), told.len(), "{tab:?}: {told:#?}");
            let first = judged.sentence.split("; ").next().expect("a clause").to_lowercase();
            assert!(told.contains(&first), "{tab:?}: {first}: {told:#?}");
            // What a button mends stands with it.
            let apply = if tab == BottomTab::Slopes { "Apply" } else { "Apply slopes" };
            let button = window.harness.query_by_role_and_label(Role::Button, apply);
            assert_eq!(button.is_some(), judged.advice.is_some(), "{tab:?}");
        }
    }
}

#[test]
fn a_cursor_that_leaves_the_slope_on_show_says_why_and_the_first_one_does_not() {
    let mut window = Start::first([1280.0, 800.0]).open();
    assert_eq!(window.model().shell.messages.note, None);
    let before = window.document().cursor().slope;
    window.change(|document| document.params.slopes = SlopeGrid::line(0.5..=1.5, 5).into()).settle();
    assert_ne!(window.document().cursor().slope, before);
    assert!(window.shows("Most features ("));
}

#[test]
fn the_card_is_dismissed_for_good_or_starts_the_first_lesson() {
    let mut window = Start::first([1280.0, 800.0]).open();
    assert!(window.shows("Drag in the slope plane"));
    let before = picture(&window);
    window.click("Explore");
    assert!(!window.shows("Drag in the slope plane"));
    assert_eq!(picture(&window), before, "nothing else moves");
    let mut memory = Memory::default();
    eframe::App::save(window.app_mut(), &mut memory);
    assert!(!Settings::load(&memory).panels.welcome);
    let mut window = Start::first([1280.0, 800.0]).open();
    window.click("Three-minute lesson").settle();
    assert!(window.app().lessons.open.is_some());
    assert!(!window.shows("Drag in the slope plane"));
}

#[test]
fn the_right_panel_comes_with_a_selection_or_a_question_and_the_picture_stays() {
    let mut window = Start::first([1280.0, 800.0]).open();
    window.click("Explore");
    let slope = window.document().cursor().slope;
    let moves = |f: &burstscope::Feature| (f.motion().0.u - slope.u).hypot(f.motion().0.v - slope.v) < 0.1;
    let is_here = |f: &&burstscope::Feature| moves(f) && (100.0..300.0).contains(&f.u);
    let feature = *window.read().features().iter().find(is_here).expect("a feature of this slope");
    let place = pos2(feature.u, feature.v);
    let before = window.ui_from_image(place).expect("drawn");
    window.click_at(before).settle();
    assert!(window.document().selected.is_some() && window.read().shows_right());
    let after = window.ui_from_image(place).expect("drawn");
    assert!((after - before).length() < 1.0, "{after:?} instead of {before:?}");
    window.snapshot("first_selection").run_action("Clear selection").settle();
    assert!(!window.read().shows_right());
    assert!(window.document().panes.of(Side::A).view.is_fit(), "as before");
    let rect = picture(&window);
    window.shift_click_at(rect.min + 0.37 * rect.size()).settle();
    assert!(window.read().shows_right() && window.document().probe.is_open);
    window.snapshot("first_probe");
}

#[test]
fn tabs_open_the_panel_below_and_advanced_parameters_are_folded_and_say_that_one_is_changed() {
    let mut window = Start::first([1280.0, 800.0]).open();
    window.click("Explore");
    let whole = picture(&window).height();
    window.harness.get_by_label_contains("Tally · Noise").click();
    window.steps(3);
    assert!(picture(&window).height() < whole - 80.0);
    window.click("Tally").click("Table");
    assert!(window.read().shows_bottom());
    window.click("Table");
    assert_eq!(picture(&window).height(), whole);
    assert!(!window.shows("Edge threshold"));
    window.change(|document| document.params.edge_threshold = 15.0).steps(2);
    assert!(window.shows("1 not the default"));
    window.click("Advanced");
    assert!(window.shows("Edge threshold"));
    window.click("Advanced");
    assert!(!window.shows("Edge threshold"));
    window.change(|document| document.params.edge_threshold = -1.0).steps(2);
    assert!(window.shows("Edge threshold"), "an error opens the fold");
}

#[test]
fn a_narrow_window_folds_the_left_panel_into_a_strip() {
    let mut window = Start::first([900.0, 640.0]).open();
    window.click("Explore");
    assert!(!window.has(Role::SpinButton, "Slope u"));
    window.click("Unfold Cursor and parameters");
    assert!(window.has(Role::SpinButton, "Slope u"));
    window.run_action("Cursor and parameters");
    assert!(!window.has(Role::SpinButton, "Slope u"));
}

#[test]
fn smoothing_changes_what_is_shown_and_not_the_values() {
    let mut window = Start::default().open();
    let planes = |window: &Window| {
        let picture = window.read().picture().expect("a picture");
        (picture.plane.clone(), picture.drawn.clone())
    };
    let (plane, drawn) = planes(&window);
    assert!(Arc::ptr_eq(&plane, &drawn));
    let range = window.document().look.ranges.intensity;
    window.slide("Smoothing", 2.0).settle();
    let (values, smooth) = planes(&window);
    assert_eq!(values, plane);
    let spread = |plane: &Plane| {
        let mean = plane.data().iter().sum::<f32>() / plane.data().len() as f32;
        plane.data().iter().map(|x| (x - mean).powi(2)).sum::<f32>()
    };
    assert!(spread(&smooth) < 0.8 * spread(&values));
    let narrower = window.document().look.ranges.intensity;
    assert!(narrower.max - narrower.min < range.max - range.min, "the range follows");
    window.hover(picture(&window).center()).steps(3);
    assert!(window.shows("display smoothed, σ 2 px"));
    window.snapshot("smoothed_display").slide("Smoothing", 0.0).settle();
    assert!(Arc::ptr_eq(&planes(&window).0, &planes(&window).1));
}
