//! Lessons: every step of each, played by its own data.

use crate::support::*;
use burstscope::{app::parts, teach::Part};

/// A test of each lesson, and the steps that their pictures show, from 1.
macro_rules! lessons {
    ($($test:ident: $name:literal, $step:literal;)*) => {
        const KEY_STEPS: &[(&str, usize)] = &[$(($name, $step)),*];
        $(
            #[test]
            fn $test() {
                play($name);
            }
        )*
    };
}

lessons! {
    out_of_the_dark_is_played: "out-of-the-dark", 5;
    slope_is_depth_is_played: "slope-is-depth", 4;
    the_aperture_is_played: "the-aperture", 4;
    blobs_at_every_scale_is_played: "blobs-at-every-scale", 6;
    what_noise_does_is_played: "what-noise-does", 3;
    what_a_burst_costs_is_played: "what-a-burst-costs", 4;
    ghosts_is_played: "ghosts", 5;
    when_it_fails_is_played: "when-it-fails", 3;
    from_features_to_cameras_is_played: "from-features-to-cameras", 10;
    from_light_fields_to_bursts_is_played: "from-light-fields-to-bursts", 3;
}

pub const SIZES: [[f32; 2]; 2] = [[1280.0, 800.0], [1024.0, 700.0]];

pub fn nothing_open() -> Window {
    Start { size: SIZES[0], ..Start::nothing_open() }.open()
}

pub fn lesson(name: &str) -> Arc<Lesson> {
    built_in().iter().find(|lesson| lesson.name == name).expect("a lesson").clone()
}

fn key(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.harness.key_press_modifiers(modifiers, key);
    window.steps(2);
}

fn fulfil(window: &mut Window, goal: &Goal) {
    let Goal { slope_u, slope_v, show, layout, frame, octave, level, frames_used, .. } = goal.clone();
    if let Some(layout) = layout {
        window.run_action(match layout {
            Layout::Single => "layout: single",
            Layout::FrameAndStack => "layout: frame and",
            Layout::TwoSlopes => "layout: two slopes",
            Layout::ThreeSlopes => "layout: 3 slopes",
            Layout::FiveSlopes => "layout: 5 slopes",
            Layout::SevenSlopes => "layout: 7 slopes",
            Layout::NineSlopes => "layout: 9 slopes",
            Layout::Scales => "layout: scales",
            Layout::Methods => "methods",
            Layout::Slice => "stack and slice",
            Layout::TwoByTwo => "2 × 2",
        });
    }
    if let Some(show) = show {
        let (modifiers, letter) = match show {
            ViewKind::Frame => (Modifiers::NONE, Key::Num1),
            ViewKind::Stack => (Modifiers::NONE, Key::Num2),
            ViewKind::Dog => (Modifiers::NONE, Key::Num3),
            ViewKind::Merge => (Modifiers::NONE, Key::Num4),
            ViewKind::Noise => (Modifiers::SHIFT, Key::N),
            ViewKind::Coverage => (Modifiers::SHIFT, Key::C),
            ViewKind::Motion => (Modifiers::SHIFT, Key::V),
            ViewKind::Field => (Modifiers::SHIFT, Key::U),
            ViewKind::InFocus => (Modifiers::SHIFT, Key::I),
            // No lesson shows others.
            _ => panic!("{show:?} has no key"),
        };
        key(window, modifiers, letter);
    }
    let sliders = [
        ("Slope u", slope_u),
        ("Slope v", slope_v),
        ("Frame", frame),
        ("Octave", octave),
        ("Level", level),
        ("Frames", frames_used),
    ];
    for (label, wanted) in sliders {
        if let Some(wanted) = wanted {
            window.slide(label, f64::from(wanted.middle()));
        }
    }
    if goal.reads_depths == Some(true) {
        window.click_on(Role::CheckBox, "Read slopes as depths").steps(2);
    }
    if goal.finds_slopes == Some(true) {
        window.click_on(Role::CheckBox, "Auto slopes").steps(2);
    }
    if goal.features.is_some() && !window.document().auto_detect {
        window.click("Detect");
    }
    if goal.selected == Some(true) || goal.selected_match == Some(true) {
        window.key(Key::Home);
    }
    if goal.camera == Some(true) {
        window.click_on(Role::Row, "Camera burst_003.png").steps(2);
    }
    if let Some(near) = goal.probe {
        probe(window, near);
    }
    goal.params.iter().for_each(|(name, wanted)| set_parameter(window, name.as_str(), wanted));
    if let Some(Between { min, max }) = goal.searches_u {
        let axis = fields(window, "Slopes u");
        set(window, axis[0], f64::from(min));
        set(window, axis[1], f64::from(max));
    }
    if let Some(slopes) = goal.slopes {
        if slopes.max > 1000.0 {
            window.run_action("preset buff 2d");
        } else {
            let axis = fields(window, "Slopes u");
            let rows = window.read().grid_of(Side::A).v.count as f64;
            set(window, axis[2], (f64::from(slopes.min) / rows).ceil());
        }
    }
    match goal.tab {
        Some(BottomTab::Compared) => window.run_action("compare with the truth"),
        Some(tab) => window.open_tab(&format!("{tab:?}")),
        None => &mut *window,
    };
    match goal.workspace {
        Some(Workspace::Pair) => window.ctrl(Key::Num2),
        Some(Workspace::Inspect) => window.ctrl(Key::Num1),
        Some(other) => panic!("no lesson asks for {other:?}"),
        None => &mut *window,
    };
    if goal.detects == Some(true) {
        window.click_on(Role::CheckBox, "Auto").steps(2);
    }
}

fn probe(window: &mut Window, near: Near) {
    // Shown features would be probed instead of the places beside them.
    let [u, v] = near.place;
    window.shift_click_at(window.ui_from_image(pos2(u, v)).expect("drawn"));
}

fn fields(window: &Window, label: &str) -> Vec<egui::accesskit::NodeId> {
    let nodes = window.harness.query_all_by_role_and_label(Role::SpinButton, label);
    nodes.map(|node| node.accesskit_node().locate().0).collect()
}

fn set(window: &mut Window, field: egui::accesskit::NodeId, value: f64) {
    let by_id = egui_kittest::kittest::by().predicate(move |node| node.locate().0 == field);
    window.harness.get(by_id).set_value_accesskit(value);
    window.steps(2);
}

fn set_parameter(window: &mut Window, name: &str, wanted: &GoalValue) {
    let doc = burstscope::detector::params::doc::ALL
        .map(|record| record.doc)
        .into_iter()
        .chain(burstscope::matching::params::doc::ALL.map(|record| record.doc))
        .find(|doc| doc.name.replace('-', "_") == name)
        .expect("a parameter");
    match wanted {
        GoalValue::Between(between) => {
            if name == "noise_gate" && fields(window, doc.label).is_empty() {
                choose(window, doc.label, "Factor");
            }
            set(window, fields(window, doc.label)[0], f64::from(between.middle()));
        }
        GoalValue::Number(number) => {
            set(window, fields(window, doc.label)[0], *number);
        }
        GoalValue::Word(word) => {
            let entry = match word.as_str() {
                "sift" => "SIFT",
                "merge" => "Merge + SIFT",
                word => &format!("{}{}", word[..1].to_uppercase(), &word[1..]),
            };
            choose(window, doc.label, entry);
        }
        GoalValue::Switch(_) => {
            window.click_on(Role::CheckBox, doc.label).steps(2);
        }
    }
}

pub fn choose(window: &mut Window, label: &str, entry: &str) {
    window.click_on(Role::ComboBox, label).steps(4);
    let found = window.harness.query_all_by_label(entry).last();
    found.unwrap_or_else(|| panic!("'{label}' has no entry '{entry}'")).click();
    window.steps(4);
}

fn play(name: &str) {
    SIZES.into_iter().for_each(|size| play_at(name, size));
}

fn is_in_sight(window: &Window, place: [f32; 2]) -> bool {
    let app = window.app();
    let pane = app.widgets.rect_ui(app.model.document.focus()).expect("a pane").expand(0.5);
    window.ui_from_image(place.into()).is_some_and(|pos| pane.contains(pos))
}

/// Asserts that the step's picture is whole or shows the part it asks for, with all places that have a ring.
fn assert_in_sight(window: &Window, step: &Step, what: &str) {
    let state = &step.state;
    let rings = state.rings.iter().flatten().map(|ring| (ring.place, ring.radius));
    let spots = state.spot.iter().map(|spot| (spot.place, spot.ground[1]));
    for ([u, v], radius) in rings.chain(spots) {
        for place in [[u - radius, v], [u + radius, v], [u, v - radius], [u, v + radius]] {
            assert!(is_in_sight(window, place), "{what}: {place:?} of a ring");
        }
    }
    if state.workspace == Some(Workspace::Trajectories) {
        return;
    }
    let plane = &window.opened().burst.frames[0];
    let whole = [0.0, 0.0, plane.width() as f32 - 1.0, plane.height() as f32 - 1.0];
    let [left, top, right, bottom] = match state.view {
        Some(InView::Region(region)) => region,
        None => whole,
        Some(InView::Centre(_)) => return,
    };
    assert!(is_in_sight(window, [left, top]) && is_in_sight(window, [right, bottom]), "{what}: the picture");
}

fn play_at(name: &str, size: [f32; 2]) {
    let lesson = lesson(name);
    let mut window = Start { size, ..Start::nothing_open() }.open();
    window.app_mut().start_lesson(lesson.clone());
    for (place, step) in lesson.steps.iter().enumerate() {
        let what = format!("{name} at {size:?}, step {} '{}'", place + 1, step.title);
        window.settle();
        let errors = format!("{:?}", window.errors());
        let open = window.app().lessons.open.as_ref().unwrap_or_else(|| panic!("{what}: the lesson was left"));
        assert!(open.step == place && open.is_ready, "{what}: {} {errors}", open.step);
        assert!(!open.is_done(), "{what}: done before anything was tried");
        assert!(window.results().slots.a.param_error.is_none(), "{what}: {:?}", window.results().slots.a.param_error);
        let drawn = parts::drawn(&window.harness.ctx);
        for part in &step.highlight {
            let rect = drawn.iter().find(|(drawn, _)| drawn == part);
            assert!(rect.is_some_and(|(_, rect)| rect.area() > 100.0), "{what}: {part} is not seen: {drawn:?}");
        }
        assert_in_sight(&window, step, &what);
        // Whoever learns about something else is not to wonder about the slopes.
        let is_of_slopes =
            step.highlight.iter().any(|part| *part == Part::Below || part.to_string().starts_with("slopes"));
        assert!(is_of_slopes || !window.shows("Apply slopes"), "{what}: a verdict on slopes that the step set");
        let task = step.task.as_ref().expect("something to try");
        fulfil(&mut window, &task.goal);
        window.settle();
        let open = window.app().lessons.open.as_ref().expect("open");
        assert!(open.is_done(), "{what}: {:?} was done, and not noticed", task.goal);
        assert!(window.shows("✔ Done"), "{what}");
        assert!(window.errors().is_empty(), "{what}: {:?}", window.errors());
        if KEY_STEPS.contains(&(name, place + 1)) && size == SIZES[0] {
            window.snapshot(&format!("lesson_{}", name.replace('-', "_")));
        }
        let is_last = place + 1 == lesson.steps.len();
        window.click(if is_last { "Finish the lesson" } else { "Next step" });
    }
    window.settle();
    ends(&mut window, &lesson, size == SIZES[0]);
    assert!(window.app().lessons.open.is_none() && window.results().slots.a.burst.is_none(), "what was open is back");
    let progress = &window.app().lessons.progress[name];
    assert_eq!((progress.done.len(), progress.step), (lesson.steps.len(), 0), "it begins anew");
}

/// At the end of a lesson there are three lines and the way to the next one; goes there, or closes the last lesson.
fn ends(window: &mut Window, lesson: &Lesson, is_drawn: bool) {
    assert!(window.shows("What you have learnt") && window.shows("The end"));
    assert_eq!(lesson.learnt.len(), 3);
    for line in &lesson.learnt {
        let plain = line.split('*').max_by_key(|part| part.len()).expect("a part").trim();
        // Long lines are drawn in pieces.
        let words: Vec<&str> = plain.split_whitespace().take(3).collect();
        assert!(window.shows(&words.join(" ")), "{line}");
    }
    if lesson.name == "ghosts" && is_drawn {
        window.snapshot("lesson_end");
    }
    let next = built_in().iter().skip_while(|other| other.name != lesson.name).nth(1);
    let Some(next) = next else {
        window.click("Close the lesson").settle();
        return;
    };
    assert!(window.shows(&format!("Next: {}", next.title)));
    // The last step can be looked at again.
    window.click("Step back").settle();
    assert!(window.shows(&format!("Step {0} of {0}", lesson.steps.len())));
    window.click("Finish the lesson").settle().click("Next lesson").settle();
    assert_eq!(window.app().lessons.open.as_ref().map(|open| (&open.lesson.name, open.step)), Some((&next.name, 0)));
    window.click("Leave lesson").settle();
}

#[test]
fn every_lesson_has_its_test_and_its_picture() {
    for lesson in built_in() {
        let (_, step) = KEY_STEPS.iter().find(|(name, _)| *name == lesson.name).expect("a key step");
        assert!((1..=lesson.steps.len()).contains(step));
    }
    assert_eq!(built_in().len(), KEY_STEPS.len());
}
