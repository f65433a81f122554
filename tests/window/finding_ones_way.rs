//! Palette, shortcuts, menus, themes.

use crate::support::*;
use burstscope::app::actions::{ACTIONS, ActionId, Menu};

#[test]
fn the_palette_finds_and_runs_an_action_and_begins_with_what_is_mostly_wanted() {
    let mut window = Start::without_auto_detect().open();
    window.run_action("show dog").settle();
    assert_eq!(window.document().cursor().kind, ViewKind::Dog);
    window.ctrl(Key::P);
    assert!(window.shows("Find an action"));
    window.key(Key::Escape);
    assert_eq!(window.document().cursor().kind, ViewKind::Dog);
    window.ctrl(Key::L);
    let before = *window.document().cursor();
    let field = window.harness.get_by_role_and_label(Role::TextInput, "Path");
    field.type_text("3");
    window.steps(1).key(Key::Num3).key(Key::G);
    assert_eq!(*window.document().cursor(), before);
    let mut window = Start::without_auto_detect().open();
    window.ctrl(Key::P).steps(3);
    assert!(window.shows("Find features with") || window.shows("Detect"));
    let field = window.harness.get_by_role_and_label(Role::TextInput, "Find an action");
    field.type_text("keyb");
    window.steps(3);
    for _ in 0..4 {
        window.key(Key::Backspace);
    }
    window.steps(3);
    // As many rows as before are visible again.
    let is_seen = |label: &str| window.harness.query_all_by_label_contains(label).next().is_some();
    let seen = ACTIONS.iter().filter(|action| is_seen(action.label)).count();
    assert!(seen > 8, "{seen} rows");
    window.key(Key::Enter).settle();
    assert!(window.results().slots.a.found.is_some(), "with nothing typed Enter detects");
}

#[test]
fn the_question_mark_shows_every_action_that_has_keys_without_scrolling() {
    for size in [[1280.0, 800.0], [1024.0, 700.0]] {
        let mut window = Start { size, ..Start::without_auto_detect() }.open();
        window.key(Key::Questionmark);
        // In its first pass it is not yet at its final place.
        window.settle();
        assert!(window.shows("Keyboard shortcuts"));
        let close = window.harness.get_by_label("Close").rect();
        let foot = window.harness.get_by_label_contains("finds every action by its name").rect();
        for action in ACTIONS.iter().filter(|action| action.id != ActionId::Shortcuts) {
            let by_label = window.harness.query_all_by_label(action.label).map(|node| node.rect());
            let by_value = window.harness.query_all_by_value(action.label).map(|node| node.rect());
            let is_here = |rect: Rect| rect.top() > close.bottom() && rect.bottom() < foot.top();
            let is_here = by_label.chain(by_value).any(is_here);
            assert!(is_here || action.shortcut.is_none(), "{} is missing at {size:?}", action.label);
        }
        window.click("Close").settle();
        assert!(!window.shows("finds every action by its name"));
    }
}

#[test]
fn themes_and_panels_are_actions_and_a_slow_click_is_a_click() {
    let mut window = Start::without_auto_detect().open();
    assert!(window.harness.ctx.global_style().visuals.dark_mode);
    window.run_action("light theme").settle();
    assert!(!window.harness.ctx.global_style().visuals.dark_mode);
    window.run_action("dark theme").settle();
    assert!(window.harness.ctx.global_style().visuals.dark_mode);
    assert!(window.shows("Noise gate"));
    window.ctrl(Key::B);
    assert!(!window.shows("Noise gate"));
    window.ctrl(Key::B);
    assert!(window.shows("Noise gate"));
    let button = window.rect(Role::Button, "▶ Play").center();
    window.harness.drag_at(button);
    let pressed = window.harness.ctx.input(|i| i.time);
    while window.harness.ctx.input(|i| i.time) < pressed + 1.5 {
        window.harness.step();
    }
    window.harness.drop_at(button);
    window.steps(2);
    assert!(window.document().playing);
}

#[test]
fn escape_closes_a_drop_down_alone_and_the_tip_of_a_feature_goes_when_a_dialog_comes() {
    let mut window = Start::default().open();
    window.key(Key::Home);
    assert_eq!(window.document().selected, Some(0));
    window.click("Features");
    assert!(window.shows("Clear filter"), "the menu is open");
    window.key(Key::Escape).steps(3);
    assert!(!window.shows("Clear filter"), "the menu is closed");
    assert_eq!(window.document().selected, Some(0));
    window.key(Key::Escape);
    assert_eq!(window.document().selected, None);
    window.change(|document| document.look.overlay = FeaturesShown::All).settle();
    let feature = window.read().features()[0];
    let place = window.ui_from_image(pos2(feature.u, feature.v)).expect("drawn");
    window.hover(place).steps(3);
    assert!(window.shows("px/frame\nresponse"), "the tip");
    window.ctrl(Key::P).steps(2);
    assert!(window.shows("Find an action") && !window.shows("px/frame\nresponse"));
    window.key(Key::Escape).steps(3);
    assert!(window.shows("px/frame\nresponse"), "it comes back");
}

/// Scrolls an open menu to its end, where it is longer than the window.
fn scroll_to_end(window: &mut Window, inside: Pos2) {
    window.harness.hover_at(inside);
    for _ in 0..12 {
        let delta = vec2(0.0, -200.0);
        let (unit, modifiers, phase) = (egui::MouseWheelUnit::Point, Modifiers::NONE, egui::TouchPhase::Move);
        let source = egui::MouseWheelSource::Wheel;
        window.harness.event(egui::Event::MouseWheel { unit, delta, modifiers, phase, source });
        window.steps(4);
    }
}

#[test]
fn the_last_entry_of_every_menu_can_be_reached_at_every_size() {
    for size in [[1280.0, 800.0], [960.0, 640.0], [720.0, 480.0]] {
        let mut window = Start { size, ..Start::without_auto_detect() }.open();
        for menu in Menu::ALL.into_iter().filter(|menu| menu.has_content(window.read())).collect::<Vec<_>>() {
            let rect = |window: &Window, entry: &str| {
                window.harness.get_all_by_label_contains(entry).last().expect("drawn").rect()
            };
            // To the end of the menu, or of the one that it is in and then of its own.
            let mut at = Rect::NOTHING;
            for menu in menu.parent().into_iter().chain([menu]) {
                window.click(menu.label()).steps(3);
                let last = ACTIONS.iter().rfind(|action| action.menu == menu).expect("it has entries");
                let below = Menu::ALL.into_iter().rfind(|below| below.parent() == Some(menu)).map(Menu::label);
                let entry = below.or(menu.submenu(last.group)).unwrap_or(last.label);
                let before = rect(&window, entry);
                scroll_to_end(&mut window, pos2(before.center().x, size[1] * 0.4));
                at = rect(&window, entry);
            }
            let entry = menu.label();
            assert!(window.harness.ctx.content_rect().contains_rect(at), "{size:?} {menu:?}: {entry} at {at:?}");
            window.key(Key::Escape).steps(3);
        }
    }
}

#[test]
fn menus_of_what_is_not_there_are_not_shown_and_groups_of_many_entries_are_folded() {
    let mut window = Start::without_auto_detect().open();
    let has = |window: &Window, label: &str| window.has(Role::Button, label);
    assert!(!has(&window, "Pair") && !has(&window, "Dataset") && has(&window, "Help"));
    window.click("View").steps(3);
    assert!(window.shows("Fit picture") && !window.shows("Show DoG"));
    window.click("Picture").steps(3);
    window.harness.get_by_label_contains("Show DoG").click();
    window.steps(3).settle();
    assert_eq!(window.document().cursor().kind, ViewKind::Dog);
    window.ctrl(Key::Num2);
    assert!(has(&window, "Pair"));
}
