//! What the hand finds where it looks: contrast, playing, the wheel, focus under the pointer, only real features.

use crate::support::*;
use burstscope::{app::document::panes::Hidden, app::document::panes::MaskShape, inspect::words::slope_text};
use egui::{Event, MouseWheelSource, MouseWheelUnit, PointerButton};

fn wheel_at(window: &mut Window, pos: Pos2, modifiers: Modifiers) {
    window.hover(pos).steps(1);
    let (unit, phase, source) = (MouseWheelUnit::Line, egui::TouchPhase::Move, MouseWheelSource::Unknown);
    let event = Event::MouseWheel { unit, delta: vec2(0.0, 1.0), phase, source, modifiers };
    window.harness.event_modifiers(event, modifiers);
    window.steps(3);
}

fn centre_of(window: &Window, role: Role, name: &str) -> Pos2 {
    window.harness.get_by_role_and_label(role, name).rect().center()
}

#[test]
fn contrast_is_set_in_the_header_of_a_pane() {
    let mut window = Start { size: [1400.0, 900.0], ..Start::without_auto_detect() }.open();
    let display = |window: &Window| window.read().display_of(window.document().focus());
    // The panel Display has the same words.
    window.change(|document| document.panels.right = Visibility::Closed).settle();
    let before = display(&window);
    window.click("Contrast").click("0 – 1");
    assert_eq!((display(&window).min, display(&window).max), (0.0, 1.0));
    window.key(Key::Escape);
    // A range of another kind of picture, chosen before, is not this picture's to set.
    window.set().look.ranges.response_fixed = true;
    window.harness.key_press_modifiers(Modifiers::SHIFT, Key::A);
    window.steps(3);
    assert!(window.document().look.ranges.response_fixed);
    assert_eq!((display(&window).min, display(&window).max), (before.min, before.max), "the percentiles again");
    // Dragged sideways the range moves, downwards it widens.
    let range = centre_of(&window, Role::Button, "Contrast");
    window.drag(range, range + vec2(40.0, 0.0));
    let (moved, span) = (display(&window), before.max - before.min);
    assert!(moved.max < before.max && moved.min < before.min && (moved.max - moved.min - span).abs() < 1e-3 * span);
    window.drag(range, range + vec2(0.0, 30.0));
    assert!(display(&window).max - display(&window).min > 1.1 * span);
    window.run_action("contrast");
    assert_eq!(display(&window).max, before.max, "it is found by its name");
}

#[test]
fn playing_steps_through_what_the_picture_shows_and_the_title_names_what_is_open() {
    let mut window = Start::without_auto_detect().open();
    window.key(Key::Num1).settle();
    let start = *window.document().cursor();
    window.key(Key::Space).wait("another frame", |app| app.model.document.cursor().frame != start.frame);
    window.click("What is played").click_on(Role::RadioButton, "frames").steps(3).key(Key::Escape).click("⏸ Pause");
    let cursor = *window.document().cursor();
    assert_eq!((cursor.kind, cursor.slope), (ViewKind::Frame, start.slope), "frames are played, and nothing else");
    assert!(!window.document().playing);
    window.click("What is played").click_on(Role::RadioButton, "scales").steps(3).key(Key::Escape);
    window.click("▶ Play").wait("another scale", |app| app.model.document.cursor().level != start.level);
    window.click("⏸ Pause");
    assert_eq!(window.document().cursor().kind, ViewKind::Dog);
    assert_eq!(Start::nothing_open().open().app().read().title(), "Burstscope");
    let mut window = Start::without_auto_detect().open();
    assert_eq!(window.read().title(), "Demo burst – Burstscope");
    window.run_action("example: low contrast").settle();
    assert_eq!(window.read().title(), "Example: low contrast – Burstscope");
}

#[test]
fn the_wheel_moves_sliders_and_pictures_and_a_frame_beside_a_stack_moves_alone() {
    let mut window = Start::without_auto_detect().open();
    let cursor = |window: &Window| *window.document().cursor();
    let (frame, zoom) = (cursor(&window).frame, window.document().focused().view);
    let slider = centre_of(&window, Role::Slider, "Frame");
    wheel_at(&mut window, slider, Modifiers::NONE);
    assert_eq!((cursor(&window).frame, cursor(&window).kind), (frame + 1, ViewKind::Frame));
    let picture = window.ui_from_image(pos2(200.0, 150.0)).expect("drawn");
    wheel_at(&mut window, picture, Modifiers::ALT);
    assert_eq!(cursor(&window).frame, frame + 2);
    window.key(Key::Num2).settle();
    let before = cursor(&window).slope;
    wheel_at(&mut window, picture, Modifiers::ALT);
    let grid = window.read().cursor_params().slopes;
    assert_eq!(cursor(&window).slope, burstscope::app::document::cursor::stepped(&grid, before, false, true));
    assert!(window.document().focused().view.is_drawn_as(&zoom), "with Alt nothing is zoomed");
    wheel_at(&mut window, picture, Modifiers::NONE);
    assert!(!window.document().focused().view.is_drawn_as(&zoom), "without it the wheel zooms");
    let mut window = Start::without_auto_detect().open();
    window.key(Key::Num6).settle();
    let kinds = |window: &Window| {
        let panes = &window.document().panes;
        panes.shown().into_iter().filter_map(|id| panes.get(id)?.shown()).collect::<Vec<ViewKind>>()
    };
    let before = kinds(&window);
    assert!(before.contains(&ViewKind::Frame) && before.contains(&ViewKind::Stack), "{before:?}");
    for id in window.document().panes.shown() {
        window.set().panes.set_focus(id);
        window.slide("Frame", if id == PaneId(0) { 7.0 } else { 3.0 }).settle();
        assert_eq!(kinds(&window), before, "with {id:?} in focus");
        for key in [Key::Period, Key::Comma] {
            window.key(key).settle();
            assert_eq!(kinds(&window), before, "{key:?} with {id:?} in focus");
        }
    }
}

/// Where in the window there is a place whose motion is not what is shown, and that motion.
fn place_of_other_motion(window: &Window) -> (Pos2, Slope) {
    let found = window.results().slots.a.found.as_ref().expect("detected").detection.clone();
    let field = found.field.clone().expect("the demo moves");
    let shown = window.document().cursor().slope;
    let other = |slope: Slope| (slope.u - shown.u).hypot(slope.v - shown.v) > 0.5;
    let places = (0..400).map(|k| [20.0 + 22.0 * (k % 20) as f32, 20.0 + 16.0 * (k / 20) as f32]);
    let motion = |[u, v]: [f32; 2]| field.known_at(u, v).map(|motion| motion.slope);
    let mut seen = places.filter_map(|place| Some((place, motion(place).filter(|slope| other(*slope))?)));
    let (place, slope) = seen.next().expect("the demo has layers");
    (window.ui_from_image(place.into()).expect("drawn"), slope)
}

#[test]
fn the_loupe_shows_the_place_under_the_pointer_and_a_click_takes_its_slope() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::automatic() }.open();
    let (at, slope) = place_of_other_motion(&window);
    let (cursor, before) = (|window: &Window| *window.document().cursor(), *window.document().cursor());
    window.run_action("focus in a loupe");
    window.harness.event(Event::ModifiersChanged(Modifiers::COMMAND));
    window.hover(at).settle();
    assert_eq!(cursor(&window), before, "the pane stays as it is");
    for name in [format!("Frame {}", before.frame), "Stack".to_owned(), "In focus".to_owned()] {
        let patch = format!("{name} in the loupe");
        assert!(window.has(Role::Image, &patch), "{patch}");
    }
    let (_, taken) = window.results().patches.loupe.expect("on show");
    assert!((taken.u - slope.u).abs() < 0.011 && (taken.v - slope.v).abs() < 0.011, "{taken:?} {slope:?}");
    let stack = window.read().stack_at(Side::A, taken).expect("made").clone();
    assert!(window.results().patches.in_focus.is_some() && window.shows(&slope_text(taken)));
    window.snapshot_with_pointer("focus_in_loupe", at);
    for pressed in [true, false] {
        let (pos, button, modifiers) = (at, PointerButton::Primary, Modifiers::COMMAND);
        window.harness.event(Event::PointerButton { pos, button, pressed, modifiers });
        window.steps(1);
    }
    assert_eq!(cursor(&window).slope, taken);
    window.settle();
    let shown = &window.read().picture().expect("made").plane;
    assert!(Arc::ptr_eq(shown, &stack), "the picture that the loupe had asked for");
    window.harness.event(Event::ModifiersChanged(Modifiers::NONE));
    window.steps(3);
    assert!(!window.shows("Sharp at ") && cursor(&window).slope == taken, "the slope stays without the key");
    window.ctrl(Key::Z);
    assert_eq!(cursor(&window).slope, before.slope, "the click is one step");
    let mut settings = Settings::default();
    settings.take_from(window.document());
    assert!(settings.panels.loupe, "it is kept");
}

#[test]
fn the_place_under_the_pointer_comes_into_focus_and_goes_back() {
    let mut window = Start::automatic().open();
    let before = *window.document().cursor();
    let (at, slope) = place_of_other_motion(&window);
    window.hover(at + vec2(3.0, 0.0)).steps(2);
    let steps = window.document().cursor().slope;
    assert_eq!(steps, before.slope, "nothing is led without the key");
    // Ctrl is held, and the pointer moves.
    window.harness.event(Event::ModifiersChanged(Modifiers::COMMAND));
    window.hover(at).steps(1);
    assert_eq!(window.document().cursor().slope, slope);
    assert!(window.shows("Sharp at "));
    window.harness.event(Event::ModifiersChanged(Modifiers::NONE));
    window.steps(3);
    assert_eq!(window.document().cursor().slope, before.slope, "as before once it is let go");
    // The switch leads without a key, and what it led through is one step to undo.
    window.run_action("focus under");
    for aside in [6.0, 0.0] {
        window.hover(at + vec2(aside, 0.0)).steps(2);
    }
    // Slopes that differ by less than can be seen are not computed anew.
    let led = window.document().cursor().slope;
    assert!((led.u - slope.u).hypot(led.v - slope.v) < 0.02, "{led:?} {slope:?}");
    assert!(window.shows("Sharp at "));
    window.run_action("focus under");
    assert!(!window.document().follows_focus);
}

#[test]
fn a_mask_is_drawn_by_rectangle_polygon_and_brush() {
    let mut window = Start::without_auto_detect().open();
    window.run_action("draw mask");
    let pos = |window: &Window, u: f32, v: f32| window.ui_from_image(pos2(u, v)).expect("drawn");
    let hidden = |window: &Window| window.document().measure.hidden.clone();
    // A stroke that is straight hides nothing.
    let (from, to) = (pos(&window, 100.0, 100.0), pos(&window, 300.0, 250.0));
    window.drag(from, to);
    assert_eq!(hidden(&window), []);
    window.click("rectangle").drag(from, to);
    let [Hidden::Outline(corners)] = &hidden(&window)[..] else { panic!("{:?}", hidden(&window)) };
    assert!(corners.len() == 4 && corners[0].distance(pos2(100.0, 100.0)) < 2.0, "{corners:?}");
    window.click("polygon");
    for (u, v) in [(50.0, 50.0), (90.0, 50.0), (90.0, 90.0), (50.0, 50.0)] {
        window.click_at(pos(&window, u, v));
    }
    let [_, Hidden::Outline(corners)] = &hidden(&window)[..] else { panic!("{:?}", hidden(&window)) };
    assert_eq!((corners.len(), window.document().measure.is_open), (3, false));
    assert_eq!(window.document().selected, None, "a corner selects no feature");
    window.click("brush").drag(from, to);
    let [.., Hidden::Stroke { path, radius_px }] = &hidden(&window)[..] else { panic!("{:?}", hidden(&window)) };
    assert!(path.len() > 2 && *radius_px == 8.0);
    window.click("Take back");
    assert_eq!((hidden(&window).len(), window.document().measure.shape), (2, MaskShape::Brush));
}

#[test]
fn only_real_features_are_shown_and_written() {
    let home = folder();
    let mut window = Start::automatic().open();
    let all = window.read().features().len();
    window.run_action("only real").settle();
    assert_eq!(window.document().filter.verdict, Some(Verdict::Real));
    let shown = window.results().listed.len();
    assert!(0 < shown && shown < all, "{shown} of {all}");
    let file = home.join("real.csv");
    window.will_choose(&file).run_action("export features as csv").settle();
    let text = fs::read_to_string(&file).expect("written");
    assert_eq!(text.lines().count(), 1 + shown);
    assert!(text.starts_with(&(burstscope::export::feature_header() + ",verdict,coherence\n")));
    assert!(text.lines().skip(1).all(|line| line.contains(",real,")));
    assert_eq!(burstscope::export::read_features_csv(&file).expect("read again").len(), shown);
}
