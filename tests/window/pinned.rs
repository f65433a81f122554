//! Places that are pinned: named, marked in the pictures, probed again, kept with the session, and reported.

use crate::support::*;
use burstscope::inspect::words::number;
use egui::Shape;

fn probe_at(window: &mut Window, u: f32, v: f32) {
    window.shift_click_at(window.ui_from_image(pos2(u, v)).unwrap()).settle();
}

fn pinned(window: &Window) -> Vec<(String, [f32; 2])> {
    window.read().places_of(Side::A).map(|(_, place)| (place.name.clone(), place.at)).collect()
}

fn names(window: &Window) -> Vec<String> {
    pinned(window).into_iter().map(|(name, _)| name).collect()
}

fn drawn(window: &Window, text: &str) -> usize {
    let is_text = |shape: &Shape| matches!(shape, Shape::Text(drawn) if drawn.galley.text() == text);
    window.harness.output().shapes.iter().filter(|clipped| is_text(&clipped.shape)).count()
}

#[test]
fn a_pinned_place_has_a_name_and_stays_with_its_burst() {
    let folder = folder();
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    // Shown features would be probed instead of the places beside them.
    window.set().look.overlay = FeaturesShown::None;
    probe_at(&mut window, 92.0, 58.0);
    let first = window.read().probed_place().expect("a place");
    window.click("Pin place");
    assert_eq!(pinned(&window), [("Place 1".to_owned(), first)]);
    assert!(window.read().place_to_pin().is_none(), "it is pinned already");
    // The field of its name, and the picture.
    assert_eq!(drawn(&window, "Place 1"), 2);
    window.harness.get_by_role_and_label(Role::TextInput, "Name of place").focus();
    window.steps(2).ctrl(Key::A).type_into("Name of place", "mast").steps(2).key(Key::Enter).settle();
    assert_eq!((names(&window), drawn(&window, "mast"), drawn(&window, "Place 1")), (vec!["mast".to_owned()], 2, 0));
    window.key(Key::Num6).settle();
    assert_eq!(drawn(&window, "mast"), 3, "both pictures mark it");
    probe_at(&mut window, 24.4, 194.6);
    window.click("Pin place").settle();
    assert_eq!(names(&window), ["mast", "Place 2"]);
    window.ctrl(Key::Z);
    assert_eq!(names(&window), ["mast"]);
    window.run_action("redo");
    assert_eq!(names(&window), ["mast", "Place 2"]);
    window.click("Probe mast").settle();
    assert_eq!(window.read().probed_place(), Some(first));
    let page = folder.join("r.md");
    window.will_choose(&page).run_action("report").settle();
    let text = fs::read_to_string(&page).expect("a report");
    for (name, at) in pinned(&window) {
        let [u, v] = at.map(|x| number(x, 1));
        assert_eq!(text.matches(&format!("## {name} at ({u}, {v})")).count(), 1, "{text}");
    }
    assert!(!text.contains("## Place 3"), "the probed place is one of them");
    let mut other = window.kept_and_opened_in_another(&folder.join("s.toml"));
    assert_eq!(pinned(&other), pinned(&window));
    other.drop_file(noisy_stack(&folder, 3, 48, 48)).settle();
    assert!(pinned(&other).is_empty() && drawn(&other, "mast") == 0, "they are of another burst");
    other.run_action("open demo burst").settle();
    assert_eq!(names(&other), ["mast", "Place 2"], "its burst has them again");
    other.click("Probe").click("Remove mast").settle();
    assert_eq!((names(&other), drawn(&other, "mast")), (vec!["Place 2".to_owned()], 0));
    other.click("Probe Place 2").settle();
    assert_eq!(other.read().probed_place(), Some(pinned(&other)[0].1));
}
