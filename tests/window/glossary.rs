//! Glossary: opened from the menu, from a caption, from a parameter's tooltip, and searched.

use crate::support::{Start, Window};
use burstscope::teach::built_in;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

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
    assert!(window.shows("How many standard deviations of the noise in D a response must reach"));
}

#[test]
fn tooltips_of_kinds_of_picture_of_sliders_and_of_columns_lead_to_their_words() {
    let open = || Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let cases = [
        (Role::Button, "DoG", "DoG", "Difference of Gaussians: the image at the next level of blur"),
        (Role::Button, "Sort by SNR", "Signal-to-noise ratio", "How much something stands out"),
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
    assert!(window.shows("Which share of the frames sees a place"));
}
