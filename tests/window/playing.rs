//! What was done in a window, copied as a text and done again in another one.

use crate::{steps_back::copied, support::*};
use burstscope::app::document::journal::read_steps;

fn did(window: &mut Window) -> Steps {
    window.click("Help");
    let item = |window: &mut Window| window.harness.get_by_role_and_label(Role::Button, "Copy what I did").click();
    let texts = copied(window, item);
    let text = texts.iter().find(|text| text.contains("did = [")).expect("it is copied");
    read_steps(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn played(like: Start, steps: Steps) -> Window {
    Start { startup: Startup { source: None, play: Some(steps), ..Startup::default() }, ..like }.open()
}

fn assert_same(window: &Window, again: &Window) {
    let (model, other) = (window.model(), again.model());
    assert_eq!(model.document, other.document);
    assert_eq!(Session::of(Read::of(model)), Session::of(Read::of(other)));
    assert_eq!(model.shell.history.can_undo(), other.shell.history.can_undo());
}

#[test]
fn what_was_done_with_one_burst_is_done_again_and_what_was_done_with_two_bursts_is_done_again() {
    let mut window = Start::default().open();
    window.key(Key::ArrowRight).settle().slide("Slope u", 2.5).settle().run_action("Split right").settle();
    window.key(Key::ArrowLeft).settle().ctrl(Key::Z).settle().run_action("preset sift").settle().ctrl(Key::Z).settle();
    window.run_action("First feature or match").run_action("Zoom in").settle();
    let place = window.ui_from_image(pos2(60.0, 50.0)).expect("it is drawn");
    window.run_action("Pin this result").settle().shift_click_at(place).settle();
    window.drag(place, place + vec2(30.0, 12.0)).settle();
    let steps = did(&mut window);
    assert!(steps.iter().flatten().any(|action| matches!(action, Action::Probe(..))), "{steps:?}");
    let mut again = played(Start::default(), steps.clone());
    assert_same(&window, &again);
    assert_eq!(did(&mut again), steps, "and what was played can be copied");
    let size = [1400.0, 900.0];
    let mut window = Start { size, ..Start::default() }.open();
    window.ctrl(Key::Num2).settle().click("Later demo burst as B").settle();
    window.key(Key::N).run_action("Go to the selection").settle().slide("Slope u", 1.25).settle();
    window.run_action("Zoom and pan together").settle().run_action("Swap A and B").settle();
    let steps = did(&mut window);
    assert_same(&window, &played(Start { size, ..Start::default() }, steps));
}

#[test]
fn what_is_played_shows_its_errors_and_needs_no_session_file() {
    let (home, path) = folder_with("s.burstscope.toml");
    let mut window = Start::default().open();
    window.key(Key::ArrowRight).settle();
    fs::write(&path, Session::of(window.read()).unwrap().to_toml()).unwrap();
    let mut window = Start::nothing_open().open();
    window.drop_file(path.clone()).settle();
    let steps = did(&mut window);
    fs::remove_file(&path).unwrap();
    assert_same(&window, &played(Start::default(), steps));
    let gone = Action::OpenFeatures(burstscope::app::document::side::Side::A, home.join("gone.csv"));
    assert!(played(Start::default(), Steps::from([vec![gone]])).app().is_settled());
}
