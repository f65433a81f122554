//! Palette, shortcuts, menus and themes; the glossary, opened from the menu, from a caption and from tooltips.

use crate::support::{Start, Window};
use burstscope::app::actions::{ACTIONS, ActionId};
use burstscope::app::project::cursor::ViewKind;
use burstscope::teach::built_in;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

#[test]
fn the_palette_finds_an_action_and_runs_it() {
    let mut window = Start::without_auto_detect().open();
    window.run_action("show dog");
    window.settle();
    assert_eq!(window.app().model.cursor().kind, ViewKind::Dog);
    window.ctrl(Key::P);
    assert!(window.shows("Find an action"));
    window.key(Key::Escape);
    assert_eq!(window.app().model.cursor().kind, ViewKind::Dog);
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
            let is_here = |rect: egui::Rect| rect.top() > close.bottom() && rect.bottom() < foot.top();
            let is_here = by_label.chain(by_value).any(is_here);
            assert!(is_here || action.shortcut.is_none(), "{} is missing at {size:?}", action.label);
        }
        window.click("Close");
        window.settle();
        assert!(!window.shows("finds every action by its name"));
    }
}

#[test]
fn keys_typed_into_a_field_do_not_run_actions() {
    let mut window = Start::without_auto_detect().open();
    window.ctrl(Key::L);
    let before = *window.app().model.cursor();
    let field = window.harness.get_by_role_and_label(egui::accesskit::Role::TextInput, "Path");
    field.type_text("3");
    window.harness.run_steps(1);
    window.key(Key::Num3);
    window.key(Key::G);
    assert_eq!(*window.app().model.cursor(), before);
}

#[test]
fn light_and_dark_are_actions() {
    let mut window = Start::without_auto_detect().open();
    assert!(window.harness.ctx.global_style().visuals.dark_mode);
    window.run_action("light theme");
    window.settle();
    assert!(!window.harness.ctx.global_style().visuals.dark_mode);
    window.run_action("dark theme");
    window.settle();
    assert!(window.harness.ctx.global_style().visuals.dark_mode);
}

#[test]
fn panels_can_be_hidden_and_shown() {
    let mut window = Start::without_auto_detect().open();
    assert!(window.shows("Reset all"));
    window.ctrl(Key::B);
    assert!(!window.shows("Reset all"));
    window.ctrl(Key::B);
    assert!(window.shows("Reset all"));
}

#[test]
fn escape_closes_a_drop_down_and_nothing_else() {
    let mut window = Start::default().open();
    window.key(Key::Home);
    assert_eq!(window.app().model.selected, Some(0));
    window.click("Features");
    assert!(window.shows("Clear filter"), "the menu is open");
    window.key(Key::Escape);
    window.harness.run_steps(3);
    assert!(!window.shows("Clear filter"), "the menu is closed");
    assert_eq!(window.app().model.selected, Some(0));
    window.key(Key::Escape);
    assert_eq!(window.app().model.selected, None);
}

#[test]
fn a_slow_click_is_a_click() {
    let mut window = Start::without_auto_detect().open();
    window.app_mut().model.focused_mut().cursor.slope.u = 1.0;
    window.settle();
    let button = window.harness.get_by_role_and_label(egui::accesskit::Role::Button, "Zero").rect().center();
    window.harness.drag_at(button);
    let pressed = window.harness.ctx.input(|i| i.time);
    while window.harness.ctx.input(|i| i.time) < pressed + 1.5 {
        window.harness.step();
    }
    window.harness.drop_at(button);
    window.harness.run_steps(2);
    assert_eq!(window.app().model.cursor().slope.u, 0.0);
}

#[test]
fn the_palette_is_as_high_as_its_list_and_begins_with_what_is_mostly_wanted() {
    let mut window = Start::without_auto_detect().open();
    window.ctrl(Key::P);
    window.harness.run_steps(3);
    let row = |window: &crate::support::Window, label: &str| {
        window.harness.query_all_by_label_contains(label).map(|node| node.rect()).next()
    };
    let first = row(&window, "Find features with").or_else(|| row(&window, "Detect"));
    assert!(first.is_some());
    let field = window.harness.get_by_role_and_label(egui::accesskit::Role::TextInput, "Find an action");
    field.type_text("keyb");
    window.harness.run_steps(3);
    for _ in 0..4 {
        window.key(Key::Backspace);
    }
    window.harness.run_steps(3);
    // As many rows as before are visible again.
    let seen = ACTIONS.iter().filter(|a| row(&window, a.label).is_some()).count();
    assert!(seen > 8, "{seen} rows");
    window.key(Key::Enter);
    window.settle();
    assert!(window.app().model.slots.a.found.is_some(), "with nothing typed Enter detects");
}

#[test]
fn the_glossary_is_opened_and_searched() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() }.open();
    window.harness.key_press_modifiers(Modifiers::SHIFT, Key::F1);
    window.harness.run_steps(3);
    assert!(window.shows("Alias"), "all words");
    window.harness.get_by_role_and_label(Role::TextInput, "Search the glossary").type_text("noise gate");
    window.harness.run_steps(3);
    assert!(window.shows("Noise gate") && !window.shows("Alias"));
    window.snapshot("glossary");
}

#[test]
fn a_link_of_a_caption_leads_to_its_word() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::nothing_open() }.open();
    window.app_mut().start_lesson(built_in()[0].clone());
    window.settle();
    window.harness.get_by_role_and_label(Role::Link, "burst").click();
    window.harness.run_steps(4);
    assert!(window.shows("Search the glossary") && window.shows("A few frames taken right after one another"));
    assert!(window.app().lessons.open.is_some(), "the lesson stays");
}

/// Hovers over a widget until its tooltip appears, and follows the link in it.
fn follow_the_tooltip(window: &mut Window, role: Role, label: &str, word: &str) {
    let rect = window.harness.get_all_by_role_and_label(role, label).next().expect("its row").rect();
    window.harness.hover_at(rect.center());
    window.harness.run_steps(40);
    window.harness.get_by_role_and_label(Role::Link, &format!("Glossary: {word}")).click();
    window.harness.run_steps(4);
}

#[test]
fn a_parameters_tooltip_leads_to_its_word() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() }.open();
    follow_the_tooltip(&mut window, Role::Label, "Noise gate", "Noise gate");
    assert!(window.shows("Min |response| in standard deviations of the noise in D"));
}

#[test]
fn tooltips_of_kinds_of_picture_of_sliders_and_of_columns_lead_to_their_words() {
    let open = || Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let cases = [
        (Role::Button, "DoG", "DoG", "Difference of Gaussians: the image at the next level of blur"),
        (Role::Button, "Sort by SNR", "Signal-to-noise ratio", "A signal over the standard deviation of its noise"),
        (Role::Label, "Octave", "Octave", "of the one before on each side"),
    ];
    for (role, label, word, meaning) in cases {
        let mut window = open();
        follow_the_tooltip(&mut window, role, label, word);
        assert!(window.shows(meaning), "{word}");
    }
    let mut window = open();
    window.click("Menu of pane");
    follow_the_tooltip(&mut window, Role::RadioButton, "Coverage", "Coverage");
    assert!(window.shows("Share of the frames that see a place"));
}
