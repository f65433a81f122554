//! Around lessons: leaving and coming back, the hall, sheets, lessons from files.

use crate::lessons::{SIZES, choose, lesson, nothing_open};
use crate::support::*;
use burstscope::app::parts;

#[test]
fn nothing_is_lost_of_what_was_open() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    window.key(Key::Num6).slide("Slope u", 0.75).change(|document| document.params.levels = 4).settle();
    window.key(Key::Home).run_action("light theme").settle();
    let state = |window: &Window| {
        let mut panes = window.document().panes.clone();
        panes.iter_mut().for_each(|(_, pane)| pane.view = Default::default());
        let burst = window.results().slots.a.burst.as_ref().map(|burst| burst.id);
        (
            burst,
            window.document().params.clone(),
            window.document().selected,
            window.read().features().to_vec(),
            panes,
            window.document().panels,
            window.document().theme,
        )
    };
    let before = state(&window);
    window.key(Key::F1).steps(5).click("Lesson: Out of the dark").settle();
    let (in_lesson, count) = (window.read().is_in_lesson(), window.read().features().len());
    assert!(in_lesson && count == 0, "{in_lesson} {count}");
    window.slide("Frame", 1.0).settle().click("Next step").settle().click("Leave lesson").settle();
    assert!(!window.read().is_in_lesson());
    assert!(state(&window) == before, "everything is as it was");
    assert!(window.model().shell.history.can_undo(), "what was done before can be undone");
    // Coming back continues at the step that was left, with the tasks done.
    window.run_action("lessons").steps(5);
    assert!(window.shows("step 2 of"));
    window.click("Lesson: Out of the dark").settle();
    let open = window.app().lessons.open.as_ref().expect("open");
    assert_eq!((open.step, open.done.clone()), (1, [0].into()));
    assert!(window.document().focused().shows(ViewKind::Frame), "set up as the step begins");
    window.click("Step back").settle();
    assert_eq!(window.app().lessons.open.as_ref().map(|open| (open.step, open.is_done())), Some((0, true)));
    // Settings are those made outside the lesson, and the progress in it.
    let mut memory = Memory::default();
    eframe::App::save(window.app_mut(), &mut memory);
    let settings = Settings::load(&memory);
    assert!(settings.panels == Panels::all() && settings.auto_detect, "the lesson's panels are nobody's setting");
    assert_eq!(settings.lessons["out-of-the-dark"].done, [0].into());
}

#[test]
fn a_step_is_set_up_again_and_what_is_opened_in_a_lesson_leaves_it_and_the_first_page_offers_lessons() {
    let mut window = nothing_open();
    window.app_mut().start_lesson(lesson("slope-is-depth"));
    window.settle().slide("Slope u", 2.5).settle().click("Set the step up again").settle();
    assert_eq!(window.document().cursor().slope, Slope::new(-2.1, 0.0));
    window.click("Step 3: A slice through time").settle();
    let source = window.results().slots.a.burst.as_ref().map(|burst| burst.source.clone());
    assert_eq!(source.and_then(|source| source.name()), Some("demo-depths"));
    window.run_action("open demo burst").settle();
    assert!(window.app().lessons.open.is_none() && !window.read().is_in_lesson());
    assert_eq!(window.results().slots.a.burst.as_ref().map(|burst| &burst.source), Some(&BurstSource::Demo));
    assert_eq!(window.app().lessons.progress["slope-is-depth"].step, 2);
    let mut window = nothing_open();
    window.click_on(Role::Link, "Lesson: What noise does").steps(2).settle();
    assert_eq!(window.app().lessons.open.as_ref().map(|open| open.lesson.name.as_str()), Some("what-noise-does"));
}

#[test]
fn frames_are_added_one_by_one_and_the_ratio_grows_as_the_root() {
    let mut window = nothing_open();
    window.app_mut().lessons.progress.entry("out-of-the-dark".to_owned()).or_default().step = 3;
    window.app_mut().start_lesson(lesson("out-of-the-dark"));
    window.settle();
    let ratio = |window: &Window| -> f64 {
        let node = window.harness.query_all_by_label_contains("SNR ").next().expect("it is measured");
        let text = node.accesskit_node().value().or_else(|| node.accesskit_node().label()).expect("a text");
        text.trim_start_matches("SNR ").parse().expect("a number")
    };
    let one = ratio(&window);
    window.slide("Frames", 4.0).settle();
    let four = ratio(&window);
    assert!((1.6..2.9).contains(&(four / one)), "{one} → {four}");
    window.click("▶ Add one by one");
    window.wait("all frames are added", |app| {
        app.lessons.open.as_ref().is_some_and(|open| open.is_done()) && app.read().pictures_are_current()
    });
    window.settle();
    let ten = ratio(&window);
    // Of one frame the ratio itself is uncertain by 0.1.
    assert!((2.6..3.8).contains(&(ten / one)), "{one} → {ten}");
    assert!(window.shows("10 dots measured"), "none is skipped");
}

#[test]
fn in_a_hall_the_picture_is_large_and_a_presenters_keys_lead_through_the_lesson() {
    for lesson in built_in() {
        let mut window = at_step(&lesson.name, 0, SIZES[1]);
        window.key(Key::F11);
        for (place, step) in lesson.steps.iter().enumerate() {
            window.settle();
            let what = format!("{}, step {} '{}'", lesson.name, place + 1, step.title);
            let app = window.app();
            assert_eq!(
                app.lessons.open.as_ref().map(|open| (open.step, open.is_ended)),
                Some((place, false)),
                "{what}"
            );
            let pane = |id| app.widgets.rect_ui(id).expect("drawn");
            let panes = app.model.document.panes.shown().into_iter().map(pane).reduce(Rect::union).expect("a pane");
            let drawn = parts::drawn(&window.harness.ctx);
            let has_plane = step.state.workspace == Some(Workspace::Trajectories);
            let plane = drawn.iter().find(|(part, _)| has_plane && *part == Part::Pictures);
            let panes = plane.map_or(panes, |(_, rect)| *rect);
            assert!(panes.width() >= 500.0 && panes.height() >= 400.0, "{what}: {panes}");
            for part in &step.highlight {
                assert!(drawn.iter().any(|(drawn, _)| drawn == part), "{what}: {part} is not seen: {drawn:?}");
            }
            if lesson.name == "ghosts" && place == 4 {
                window.snapshot("lesson_in_hall");
            }
            window.key(if place % 2 == 0 { Key::PageDown } else { Key::ArrowRight });
        }
        let ended = |window: &Window| window.app().lessons.open.as_ref().map(|open| open.is_ended);
        assert_eq!(ended(&window), Some(true));
        window.key(Key::PageUp).settle();
        assert_eq!(ended(&window), Some(false), "back to the last step");
        window.key(Key::F11).settle();
        assert!(window.read().shows_left() && !window.document().panels.hall, "as before");
    }
}

#[test]
fn a_lesson_is_written_as_a_sheet_and_what_was_measured_stays_from_step_to_step() {
    let (_folder, file) = folder_with("sheet.md");
    let mut window = at_step("ghosts", 0, SIZES[0]);
    window.will_choose(&file).run_action("export lesson sheet");
    window.wait("the sheet", |app| app.is_settled() && file.exists());
    assert_eq!(fs::read_to_string(file).unwrap(), sheet(&lesson("ghosts")));
    let mut window = at_step("out-of-the-dark", 3, [1280.0, 800.0]);
    for frames in [4.0, 10.0] {
        window.slide("Frames", frames).settle();
    }
    assert!(window.shows("3 dots measured"));
    window.click("Next step").settle();
    assert!(window.shows("3 dots measured"), "four frames were measured before");
    window.click("Set the step up again").settle();
    assert!(window.shows("1 dot measured"));
}

fn at_step(name: &str, step: usize, size: [f32; 2]) -> Window {
    let mut window = Start { size, ..Start::nothing_open() }.open();
    window.app_mut().lessons.progress.entry(name.to_owned()).or_default().step = step;
    window.app_mut().start_lesson(lesson(name));
    window.settle();
    window
}

#[test]
fn zooms_keep_their_subject_in_sight_and_the_search_in_two_directions_circles_the_lanterns() {
    // Corners of the bus stop's disc and ring, and of the sign.
    let (bus_stop, sign) = ([[72.0, 170.0], [105.0, 202.0]], [[218.0, 150.0], [404.0, 205.0]]);
    for size in [[1280.0, 800.0], [960.0, 640.0]] {
        for (step, subjects) in [(3, vec![bus_stop, sign]), (4, vec![bus_stop]), (5, vec![bus_stop])] {
            let window = at_step("out-of-the-dark", step, size);
            let pane = window.harness.get_by_role(Role::Canvas).rect();
            for [u, v] in subjects.concat() {
                let pos = window.ui_from_image(pos2(u, v)).expect("drawn");
                assert!(pane.contains(pos), "step {} at {size:?}: ({u}, {v}) is at {pos} of {pane}", step + 1);
            }
        }
    }
    let mut window = at_step("slope-is-depth", 7, [1280.0, 800.0]);
    let near = |window: &Window| {
        let rising = |f: &&burstscope::Feature| (f.slope.u - 1.6).hypot(f.slope.v + 1.2) < 0.5;
        window.read().features().iter().filter(rising).count()
    };
    assert_eq!(near(&window), 0, "no line holds them");
    window.choose("BuFF 1D ⏷", "Preset BuFF 2D").settle();
    assert!(near(&window) >= 5, "{}", near(&window));
    assert!(window.document().look.overlay == FeaturesShown::ThisSlope);
    window.snapshot("lesson_lanterns");
}

#[test]
fn lessons_are_opened_from_a_folder_and_a_mistake_is_said_with_its_line() {
    let (folder, file) = folder_with("mine.toml");
    let good =
        "title = \"My own\"\nabout = \"About it.\"\n\n[[step]]\ntitle = \"First\"\ncaption = \"Look at *this*.\"\n";
    fs::write(&file, good.replace("caption", "captoin")).unwrap();
    let mut window = nothing_open();
    window.will_choose(&*folder).run_action("open lessons").wait_for_error();
    assert!(window.shows("mine.toml, line 6") && window.shows("captoin"));
    fs::write(&file, good).unwrap();
    window.will_choose(&*folder).run_action("open lessons").wait("the list", |app| app.lessons.list_is_open);
    assert!(window.errors().is_empty(), "the mistake is mended");
    window.steps(5).click("Lesson: My own").settle();
    assert!(window.read().is_in_lesson(), "it is open");
    assert!(window.shows("First") && window.shows("Step 1 of 1"));
    let lessons = &mut window.app_mut().lessons;
    lessons.open_at(&folder).unwrap();
    assert_eq!(lessons.all().count(), built_in().len() + 1, "opened again, it is there once");
    assert_eq!(Purpose::OpenLessons.title(), "Open lessons");
}

#[test]
fn the_joint_rule_loses_a_few_landmarks_of_the_street_and_more_elsewhere() {
    let step = lesson("blobs-at-every-scale").steps.iter().position(|step| step.title == "Which were lost");
    let mut window = at_step("blobs-at-every-scale", step.expect("the step"), SIZES[0]);
    window.run_action("compare with the truth").settle();
    let counts = |window: &Window| {
        let shown = window.read().shown_comparison(Side::A).expect("a comparison");
        [Compared::Same, Compared::Ours].map(|kind| shown.count(kind))
    };
    let [found, elsewhere] = counts(&window);
    choose(&mut window, "Slope extrema", "Joint");
    window.settle();
    let [found_jointly, elsewhere_jointly] = counts(&window);
    assert_eq!([found, found_jointly], [45, 41], "as the step says");
    assert!(elsewhere_jointly + 4 < elsewhere, "{elsewhere} and {elsewhere_jointly}");
}
