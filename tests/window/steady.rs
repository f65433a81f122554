//! Nothing moves under the pointer: places of the window before and after what a user does there.

use crate::support::*;

fn rect(window: &Window, role: Role, label: &str) -> Rect {
    window.harness.get_all_by_role_and_label(role, label).next().expect("drawn").rect()
}

/// Two bursts as at the first start, at `size` points.
fn pair(size: [f32; 2], bursts: [BurstSource; 2]) -> Window {
    let [source, second] = bursts;
    let startup = Startup { source: Some(source), second: Some(second), params: given().params, ..Startup::default() };
    let mut window = Start { size, startup, ..Start::default() }.open();
    window.change(|document| document.workspace = Workspace::Pair).settle();
    window
}

fn demos(size: [f32; 2]) -> Window {
    pair(size, [BurstSource::Demo, BurstSource::DemoLater])
}

fn panes(window: &Window) -> [Rect; 2] {
    Side::BOTH.map(|side| window.app().widgets.rect_ui(PaneId::of(side)).expect("drawn"))
}

#[test]
fn two_bursts_are_large_and_stay_where_they_are_when_a_match_is_looked_at() {
    for size in [[1280.0, 800.0], [1920.0, 1080.0]] {
        let mut window = demos(size);
        let before = panes(&window);
        assert!(before.iter().all(|pane| pane.width() >= 450.0), "{size:?}: {before:?}");
        window.key(Key::Home).settle();
        assert!(window.shows("Selected match") && window.shows("Epipolar error"));
        assert_eq!(panes(&window), before, "{size:?}: a match is selected");
        let place = window.ui_from_image_of(Side::B, pos2(200.0, 150.0)).unwrap();
        window.shift_click_at(place).settle();
        assert!(window.document().probe.is_open && window.shows("Candidates here"));
        assert_eq!(panes(&window), before, "{size:?}: the probe is open");
        window.key(Key::Escape).run_action("Clear probe").settle();
        assert!(window.shows("Ratio test"));
        assert_eq!(panes(&window), before, "{size:?}: the parameters are back");
    }
}

#[test]
fn in_a_narrow_window_two_bursts_stay_and_wide_ones_stand_one_above_the_other() {
    let mut window = demos([960.0, 640.0]);
    let before = panes(&window);
    window.key(Key::Home).settle();
    assert!(window.document().selected_match.is_some() && !window.shows("Selected match"));
    assert_eq!(panes(&window), before, "a match is selected");
    window.click("Unfold Feature and display").settle();
    assert!(window.shows("Selected match"));
    let home = folder();
    let path = crate::support::noisy_stack(&home, 5, 60, 150);
    let burst = || BurstSource::Paths(vec![path.clone()]);
    let [a, b] = panes(&pair([1280.0, 800.0], [burst(), burst()]));
    assert!(a.bottom() <= b.top() && a.width() > 900.0, "{a:?} {b:?}");
}

#[test]
fn match_lines_leave_the_picture_free_and_come_near_the_pointer_on_demand() {
    let mut window = demos([1280.0, 800.0]);
    let drawn = |window: &Window| window.results().pair.lines_drawn;
    let (lines, all) = drawn(&window);
    assert!((10..70).contains(&lines) && all > 3 * lines, "{lines} of {all}");
    // As many as are asked for, which the order of the table gives.
    let at_most = |window: &mut Window| {
        window.click_on(Role::CheckBox, "At most").settle();
    };
    at_most(&mut window);
    assert_eq!((window.document().match_look.most, drawn(&window)), (Some(100), (100.min(all), all)));
    at_most(&mut window);
    assert_eq!(drawn(&window), (lines, all));
    window.click_on(Role::RadioButton, "Vectors").settle();
    let (vectors, of) = drawn(&window);
    assert_eq!((window.document().match_look.drawn_as, of), (MatchesAs::Vectors, all));
    assert!(vectors > lines, "short ones take less room: {vectors}");
    window.click_on(Role::RadioButton, "Near pointer").settle();
    assert_eq!(drawn(&window).1, 0, "the pointer is elsewhere");
    let row = window.matches().row(3).unwrap();
    let end = pos2(row.a.u, row.a.v);
    window.hover(window.ui_from_image_of(Side::A, end).unwrap()).steps(3);
    let near = drawn(&window).1;
    assert!(near > 0 && near < all / 3, "{near}");
}

#[test]
fn the_fields_of_the_slopes_stay_while_they_are_used() {
    let mut start = Start { size: [1280.0, 1000.0], ..Start::default() };
    start.startup.params =
        DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 7, -1.0..=1.0, 3), ..Default::default() }.into();
    let mut window = start.open();
    let gate = |window: &Window| rect(window, Role::ComboBox, "Noise gate").top();
    let set = |window: &mut Window, label: &str, count: f64| {
        let field = window.harness.get_all_by_role_and_label(Role::SpinButton, label).nth(2).unwrap();
        window.hover(field.rect().center()).steps(1);
        let field = window.harness.get_all_by_role_and_label(Role::SpinButton, label).nth(2).unwrap();
        field.set_value_accesskit(count);
        window.settle();
    };
    let before = gate(&window);
    let plane = |window: &Window| window.has(Role::Canvas, "Slope plane");
    assert!(plane(&window));
    // From a plane to a line, and to a single slope: each has other pictures above the fields.
    for (label, count) in [("Slopes v", 1.0), ("Slopes u", 1.0), ("Slopes u", 7.0)] {
        set(&mut window, label, count);
        assert_eq!(gate(&window), before, "{label} {count}");
    }
    assert!(plane(&window));
    window.harness.remove_cursor();
    window.settle();
    assert!(!plane(&window), "it goes afterwards");
}

#[test]
fn the_filter_stays_under_the_pointer_when_it_hides_features_and_the_panel_on_the_right_keeps_its_width() {
    let mut window = Start { size: [1280.0, 900.0], ..Start::default() }.open();
    window.click("Filter").steps(3);
    let before = rect(&window, Role::CheckBox, "Hide features at the slope limit");
    let total = window.results().listed.len();
    window.change(|document| document.filter.hide_slope_limit = true).settle();
    assert!(window.results().listed.len() < total);
    assert_eq!(rect(&window, Role::CheckBox, "Hide features at the slope limit"), before);
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let picture = |window: &Window| rect(window, Role::Canvas, "Picture");
    let before = picture(&window);
    window.key(Key::Home).settle();
    assert_eq!(picture(&window), before, "a feature is selected");
    window.run_action("Why this feature?").settle();
    assert_eq!(picture(&window), before, "it is probed");
}

#[test]
fn the_list_of_lessons_opens_at_its_place() {
    for size in [[1280.0, 800.0], [960.0, 640.0]] {
        let mut window = Start { size, ..Start::without_auto_detect() }.open();
        window.harness.key_press(Key::F1);
        let first = |window: &Window| {
            let mut rows = window.harness.query_all_by_label_contains("Lesson: ");
            rows.next().map(|row| row.rect())
        };
        // In its first pass it is measured, and not shown.
        window.steps(2);
        let opened = first(&window).expect("listed");
        window.hover(opened.center()).steps(5);
        assert_eq!(first(&window), Some(opened), "{size:?}");
    }
}
