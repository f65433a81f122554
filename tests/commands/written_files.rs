//! Files that the window writes of itself: sessions, and lists of what was done.

use crate::support::*;
use burstscope::app::actions::ActionId;
use burstscope::app::apply;
use burstscope::app::document::action::Reselect;
use burstscope::app::document::journal::{LAST_STEPS, MAX_STEPS, read_steps};
use burstscope::app::document::side::Side;
use burstscope::app::document::{Action, Journal, Steps};
use burstscope::app::pane::PaneId;
use burstscope::app::results::{Model, Read};
use burstscope::app::session::Session;
use burstscope::detector::{ParamChange, params::doc};

fn model() -> Model {
    let mut model = Model::default();
    let burst = Burst::from_planes("test", vec![Plane::zeros(64, 48), Plane::zeros(64, 48)]);
    apply::opening::take_burst(&mut model, OpenBurst::new(burst, BurstSource::Paths(vec!["frames".into()])));
    model.document.params.peak_threshold = 0.01;
    model.document.focused_mut().cursor.slope = Slope::new(1.25, -0.5);
    model.document.filter.hide_slope_limit = true;
    model.document.look.motion_vectors = false;
    let bias = Some("dark.tiff".into());
    model.document.calibration = OpenOptions { bias, black_level: Some(64.0), ..OpenOptions::default() };
    model
}

#[test]
fn what_is_probed_and_compared_in_b_comes_back_with_b() {
    let mut model = model();
    let second = || {
        let burst = Burst::from_planes("second", vec![Plane::zeros(80, 48), Plane::zeros(80, 48)]);
        OpenBurst::new(burst, BurstSource::Paths(vec!["others".into()]))
    };
    apply::pair::take_second_burst(&mut model, second());
    let before = Session::of(Read::of(&model)).expect("a burst is open");
    let text = before.to_toml();
    assert!(!text.contains("theirs.csv"), "{text}");
    apply::probe::probe_place(&mut model, Side::B, [70.0, 20.0]);
    apply::comparison::lay_over(&mut model, Side::B, "theirs.csv".into());
    let session = Session::of(Read::of(&model)).expect("a burst is open");
    let text = session.to_toml();
    assert_eq!(Session::from_toml(&text).as_ref(), Ok(&session), "{text}");
    let mut restored = self::model();
    let nothing = Reselect::Feature(None);
    let document = session.over_first(&restored.document);
    apply::staged::show_document(&mut restored, document, nothing);
    apply::pair::take_second_burst(&mut restored, second());
    let document = session.over_second(&restored.document);
    apply::staged::show_document(&mut restored, document, nothing);
    assert_eq!((restored.document.probe.side, Read::of(&restored).probed_place()), (Side::B, Some([70.0, 20.0])));
    let file = restored.document.comparisons.b.file.clone().expect("it was opened");
    assert!(file.is_absolute() && file.ends_with("theirs.csv"));
    assert_eq!(Session::of(Read::of(&restored)).expect("a burst is open").document, session.document);
    // The session of before says nothing of B's probe, and takes it away.
    let document = before.over_second(&restored.document);
    apply::staged::show_document(&mut restored, document, nothing);
    assert!(!restored.document.probe.is_on() && restored.document.comparisons == Default::default());
}

#[test]
fn what_is_not_a_session_is_said_and_unknown_keys_are_named_wherever_they_are() {
    let texts =
        ["", "hello", "version = 4", "version = 3\nburst = \"demo\"", "levels = 4", "version = 99\nburst = \"demo\""];
    texts.into_iter().for_each(|text| says(Session::from_toml(text).expect_err(text), &["session"]));
    assert!(Session::from_toml("version = 4\nburst = \"demo\"").is_ok());
    let text = Session::of(Read::of(&model())).expect("a burst is open").to_toml();
    let tables: Vec<&str> = text.lines().filter(|line| line.starts_with('[')).collect();
    assert!(tables.len() > 20, "{tables:?}");
    let mut of_one_kinds = 0;
    for table in tables {
        let misspelt = text.replacen(table, &format!("{table}\nmisspelt = 1"), 1);
        let error = Session::from_toml(&misspelt).expect_err(table);
        // A value of an enum is a table with the variant as the only key.
        let of_one_kind = error.contains("wanted exactly 1 element");
        assert!(error.contains("misspelt") || (of_one_kind && error.contains(table)), "{table}: {error}");
        of_one_kinds += usize::from(of_one_kind);
        for (version, which) in [("version 5", "a newer Burstscope"), ("version 3", "the Burstscope that wrote it")] {
            let other = misspelt.replacen("version = 4", &version.replace(' ', " = "), 1);
            let error = Session::from_toml(&other).expect_err(table);
            assert!(error.contains(version) && error.ends_with(which), "{table}: {error}");
        }
    }
    assert!(of_one_kinds < 10, "{of_one_kinds}");
    let misspelt = text.replacen("[document.film]", "[document.film]\nmisspelt = 1", 1);
    says(Session::from_toml(&misspelt).expect_err("unknown"), &["document.film.misspelt"]);
    // Within a value of an enum.
    let inner = "version = 4\nburst = { dark_copy = { of = \"demo\", noise = 0.1, seed = 3 } }";
    says(Session::from_toml(inner).expect_err("unknown"), &["seed"]);
}

fn taken(passes: &[(Action, bool)]) -> Journal {
    let mut journal = Journal::default();
    for (action, goes_on) in passes {
        journal.take(action, false);
        journal.close(*goes_on);
    }
    journal
}

fn search(edge_threshold: f32) -> Action {
    Action::SetSearch(Box::new(SearchParams { edge_threshold, ..SearchParams::default() }))
}

#[test]
fn a_drag_is_one_step_that_keeps_its_last_value() {
    let slope = |u| Action::SetSlope(PaneId(1), Slope::new(u, 0.0));
    let change = |parameter, value| Action::Change(vec![ParamChange::new(parameter, value)]);
    let journal = taken(&[
        (search(3.0), true),
        (search(4.0), true),
        (search(5.0), false),
        (search(6.0), false),
        (slope(1.0), true),
        (slope(1.5), false),
        (Action::Note("seen".into()), false),
        (ActionId::SaveSession.into(), false),
        (change(doc::EDGE_THRESHOLD, 7), true),
        (change(doc::EDGE_THRESHOLD, 6), true),
        (change(doc::LEVELS, 4), false),
    ]);
    let changes = vec![change(doc::EDGE_THRESHOLD, 6), change(doc::LEVELS, 4)];
    let steps = Steps::from([vec![search(5.0)], vec![search(6.0)], vec![slope(1.0), slope(1.5)], changes]);
    assert_eq!(read_steps(&journal.to_toml()), Ok(steps), "{}", journal.to_toml());
}

#[test]
fn of_many_steps_the_last_are_kept_and_mistakes_in_them_are_named_with_their_lines() {
    let journal = taken(&vec![(ActionId::ZoomIn.into(), false); MAX_STEPS + 3]);
    let text = journal.to_toml();
    assert!(text.contains("left_out = 3\n"), "{}", &text[..300]);
    assert_eq!(read_steps(&text).map(|steps| steps.len()), Ok(MAX_STEPS));
    assert_eq!(journal.last_lines().matches("zoom_in").count(), LAST_STEPS);
    let wrong = |did: &str| read_steps(&format!("version = 1\ndid = [\n  [{did}],\n]\n")).expect_err(did);
    for (did, words) in [
        ("{ set_slop = [0, 1] }", vec!["line 3", "set_slop", "set_slope"]),
        ("{ do = \"zoom\" }", vec!["line 3", "zoom_in"]),
        ("{ set_frame = [0, \"last\"] }", vec!["line 3", "string \"last\"", "usize"]),
        ("{ select = [1] }", vec!["line 3", "none"]),
    ] {
        says(wrong(did), &words);
    }
    says(read_steps("version = 9\ndid = []").expect_err("another version"), &["version is 9", "version = 1"]);
}
