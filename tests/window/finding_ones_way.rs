//! Palette, shortcuts, menus, themes.

use crate::support::Start;
use burstscope::app::actions::ACTIONS;
use burstscope::app::project::cursor::ViewKind;
use egui::Key;
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
fn the_question_mark_shows_every_action() {
    let mut window = Start::without_auto_detect().open();
    window.key(Key::Questionmark);
    assert!(window.shows("Keyboard shortcuts"));
    for action in ACTIONS {
        let found = window.harness.query_all_by_label(action.label).next().is_some()
            || window.harness.query_all_by_value(action.label).next().is_some();
        assert!(found, "{} is missing on the sheet", action.label);
    }
    window.click("Close");
    window.settle();
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
