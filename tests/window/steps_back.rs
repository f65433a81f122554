//! Undo and redo, the clipboard, context menus, and keys while a dialog is open.

use crate::support::*;
use egui::OutputCommand;

fn redo(window: &mut Window) {
    window.harness.key_press_modifiers(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
    window.steps(2);
}

/// Clipboard contents set by the window while `act` runs: texts, and the sizes of pictures.
pub fn copied(window: &mut Window, act: impl FnOnce(&mut Window)) -> Vec<String> {
    act(window);
    let mut texts = Vec::new();
    for _ in 0..3 {
        window.harness.step();
        for command in &window.harness.output().platform_output.commands {
            match command {
                OutputCommand::CopyText(text) => texts.push(text.clone()),
                OutputCommand::CopyImage(image) => texts.push(format!("{:?}", image.size)),
                _ => {}
            }
        }
    }
    texts
}

pub fn second_click_at(window: &mut Window, pos: Pos2) {
    window.hover(pos).steps(1);
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Secondary, Modifiers::NONE);
        window.harness.event(egui::Event::PointerButton { pos, button, pressed, modifiers });
        window.steps(1);
    }
    window.steps(3);
}

#[test]
fn parameters_slopes_and_strips_are_taken_back_and_parameters_made_again() {
    let mut window = Start::without_auto_detect().open();
    window.key(Key::ArrowRight).run_action("preset sift").slide("Slope u", 2.5).settle();
    let state = |window: &Window| (window.document().params.method, window.document().cursor().slope.u);
    // Before the last step there is no more.
    let (sift, buff) = (Method::Sift, Method::Buff);
    for expected in [(sift, 2.5), (sift, 1.0), (buff, 1.0), (buff, 0.0), (buff, 0.0)] {
        assert_eq!(state(&window), expected);
        window.ctrl(Key::Z);
    }
    redo(&mut window);
    redo(&mut window);
    assert_eq!(state(&window), (Method::Sift, 1.0));
    window.settle();
    assert!(window.read().picture_is_current());
    window.key(Key::Num8).settle();
    let slopes = |window: &Window| -> Vec<f32> {
        let panes = &window.document().panes;
        panes.shown().iter().map(|id| panes.get(*id).unwrap().cursor.slope.u).collect()
    };
    let before = slopes(&window);
    window.key(Key::ArrowRight);
    assert_eq!(slopes(&window)[0], before[0] + 1.0);
    window.ctrl(Key::Z);
    assert_eq!(slopes(&window), before);
}

#[test]
fn a_feature_a_value_a_place_and_a_picture_are_copied_and_rows_have_menus() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    window.key(Key::Home);
    let texts = copied(&mut window, |window| window.harness.event(egui::Event::Copy));
    let first = window.read().features()[window.document().selected.unwrap()];
    assert_eq!(texts.len(), 1);
    assert!(texts[0].starts_with("u\tv\tsigma") && texts[0].contains(&format!("\n{}\t{}", first.u, first.v)));
    window.key(Key::Escape);
    let at = window.ui_from_image(pos2(300.2, 40.3)).unwrap();
    window.hover(at).steps(2);
    let texts = copied(&mut window, |window| window.harness.event(egui::Event::Copy));
    assert_eq!(texts, [window.read().picture().unwrap().plane.clone().at(300, 40).to_string()]);
    second_click_at(&mut window, at);
    let texts = copied(&mut window, |window| window.harness.get_by_label_contains("Copy place (300.").click());
    assert!(texts[0].starts_with("300."), "{texts:?}");
    second_click_at(&mut window, at);
    let texts =
        copied(&mut window, |window| window.harness.get_by_role_and_label(Role::Button, "Copy picture").click());
    assert_eq!(texts, ["[480, 360]"]);
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let row = window.rect(Role::Row, "Feature 2").center();
    second_click_at(&mut window, row);
    window.click("Go to feature").settle();
    let feature = window.read().features()[2];
    assert_eq!((window.document().selected, window.document().cursor().slope), (Some(2), feature.slope));
    let at = window.ui_from_image(pos2(feature.u, feature.v)).unwrap();
    window.key(Key::Escape);
    second_click_at(&mut window, at);
    let hovered = window.results().hovered.expect("the pointer is on a feature");
    window.harness.get_all_by_role_and_label(Role::Button, "Select").next().unwrap().click();
    window.steps(2);
    assert_eq!(window.document().selected, Some(hovered));
}

#[test]
fn keys_are_for_the_dialog_that_is_open_or_being_opened() {
    let mut window = Start::without_auto_detect().open();
    let before = *window.document().cursor();
    // The key that opens the dialog, and one after it in the same pass.
    window.harness.key_press_modifiers(Modifiers::COMMAND, Key::L);
    window.harness.key_press(Key::Num3);
    window.harness.step();
    window.harness.key_press(Key::ArrowRight);
    window.steps(2);
    assert_eq!(*window.document().cursor(), before);
    assert!(window.shows("Open a path"));
    window.harness.key_press_modifiers(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::P);
    window.steps(2);
    assert!(!window.shows("Find an action"));
    window.key(Key::Escape).key(Key::Num3);
    assert_eq!(window.document().cursor().kind, ViewKind::Dog);
    assert_eq!(window.document().cursor().slope, Slope::default());
}
