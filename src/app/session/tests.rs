//! Tests that a session is restored unchanged, and that damaged files are reported.

use super::*;
use crate::app::project::against::With;
use crate::burst::{Burst, OpenOptions};
use crate::detector::Slope;
use crate::plane::Plane;
use crate::requests::OpenBurst;
use proptest::prelude::*;

fn model() -> Model {
    let mut model = Model::default();
    let burst = Burst::from_planes("test", vec![Plane::zeros(64, 48), Plane::zeros(64, 48)]);
    model.take_burst(OpenBurst::new(burst, BurstSource::Paths(vec!["frames".into()])));
    model.params.peak_threshold = 0.01;
    model.focused_mut().cursor.slope = Slope::new(1.25, -0.5);
    model.filter.hide_slope_limit = true;
    model.look.motion_vectors = false;
    let bias = Some("dark.tiff".into());
    model.calibration = OpenOptions { bias, black_level: Some(64.0), ..OpenOptions::default() };
    model
}

#[test]
fn a_session_comes_back_as_it_was() {
    let session = Session::of(&model()).expect("a burst is open");
    let text = session.to_toml();
    assert_eq!(Session::from_toml(&text).as_ref(), Ok(&session), "{text}");
    assert!(matches!(&session.burst, BurstSource::Paths(paths) if paths[0].is_absolute()));
    let mut restored = Model::default();
    session.apply(&mut restored);
    assert_eq!(restored.params.peak_threshold, 0.01);
    assert_eq!(restored.cursor().slope, Slope::new(1.25, -0.5));
    assert!(!restored.look.motion_vectors && restored.filter.hide_slope_limit);
    assert_eq!(restored.calibration, session.calibration);
    assert!(session.calibration.bias.as_ref().is_some_and(|path| path.is_absolute()));
}

#[test]
fn with_what_features_were_compared_comes_back_and_older_sessions_have_none() {
    let model = model();
    let mut session = Session::of(&model).expect("a burst is open");
    assert!(session.against.is_none() && !session.to_toml().contains("[against"));
    let mut pinned = model.asked();
    pinned.detector.edge_threshold = 7.0;
    let (with, file) = (Some(With::Pinned), Some(std::path::absolute("theirs.csv").expect("a path")));
    session.against = Some(SavedAgainst { with, file, pinned: Some(pinned) });
    let text = session.to_toml();
    assert_eq!(Session::from_toml(&text).as_ref(), Ok(&session), "{text}");
    let mut restored = self::model();
    session.apply(&mut restored);
    assert_eq!(restored.saved_against(Side::A), session.against);
    assert_eq!(Session::of(&restored).expect("a burst is open").against, session.against);
    // A session without a comparison removes it.
    session.against = None;
    session.apply(&mut restored);
    assert!(restored.saved_against(Side::A).is_none());
}

#[test]
fn what_is_probed_and_compared_in_b_comes_back_with_b_and_older_sessions_have_nothing() {
    let mut model = model();
    let second = || {
        let burst = Burst::from_planes("second", vec![Plane::zeros(80, 48), Plane::zeros(80, 48)]);
        OpenBurst::new(burst, BurstSource::Paths(vec!["others".into()]))
    };
    model.take_second_burst(second());
    let before = Session::of(&model).expect("a burst is open");
    let text = before.to_toml();
    assert!(!text.contains("probe") && !text.contains("against"), "{text}");
    model.probe_place(Side::B, [70.0, 20.0]);
    model.lay_over(Side::B, "theirs.csv".into());
    let session = Session::of(&model).expect("a burst is open");
    assert!(session.probe.is_none() && session.against.is_none(), "they are of B");
    let text = session.to_toml();
    assert_eq!(Session::from_toml(&text).as_ref(), Ok(&session), "{text}");
    let mut restored = self::model();
    session.apply(&mut restored);
    restored.take_second_burst(second());
    session.pair.apply(&mut restored);
    assert_eq!((restored.probe.side, restored.probe.place()), (Side::B, Some([70.0, 20.0])));
    let file = restored.slots.b.against.file.as_ref().expect("it was opened").path.clone();
    assert!(file.is_absolute() && file.ends_with("theirs.csv"));
    assert_eq!(Session::of(&restored).expect("a burst is open").pair, session.pair);
    // A session of before says nothing of B's probe, and takes it away.
    before.pair.apply(&mut restored);
    assert!(!restored.probe.is_on() && restored.saved_against(Side::B).is_none());
}

#[test]
fn without_a_burst_there_is_no_session() {
    assert!(Session::of(&Model::default()).is_none());
}

#[test]
fn what_is_not_a_session_is_said() {
    for text in ["", "hello", "version = 1", "peak_threshold = 0.1", "version = 99\nburst = \"demo\""] {
        let error = Session::from_toml(text).expect_err(text);
        assert!(error.contains("session"), "{error}");
    }
    assert!(Session::from_toml("version = 1\nburst = \"demo\"").is_ok());
}

#[test]
fn unknown_keys_are_named_wherever_they_are_and_older_files_may_have_them() {
    let text = Session::of(&model()).expect("a burst is open").to_toml();
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
        let newer = misspelt.replacen("version = 3", "version = 4", 1);
        let error = Session::from_toml(&newer).expect_err(table);
        assert!(error.contains("version 4") && error.contains("newer"), "{table}: {error}");
    }
    assert!(of_one_kinds < 10, "{of_one_kinds}");
    let misspelt = text.replacen("[pair.links]", "[pair.links]\nmisspelt = 1", 1);
    let error = Session::from_toml(&misspelt).expect_err("unknown");
    assert!(error.contains("pair.links.misspelt"), "{error}");
    assert!(Session::from_toml(&misspelt.replacen("version = 3", "version = 2", 1)).is_ok());
    // Within a value of an enum.
    let inner = "version = 3\nburst = { dark_copy = { of = \"demo\", noise = 0.1, seed = 3 } }";
    let error = Session::from_toml(inner).expect_err("unknown");
    assert!(error.contains("seed"), "{error}");
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(text in ".{0,400}") {
        let _ = Session::from_toml(&text);
    }

    #[test]
    fn no_damaged_session_makes_it_panic(at in 0usize..2000, junk in "[a-z0-9=\\[\\]\"{}.\\-]{0,6}") {
        let mut text = Session::of(&model()).expect("a burst is open").to_toml();
        let mut at = at.min(text.len());
        while !text.is_char_boundary(at) { at -= 1; }
        text.insert_str(at, &junk);
        if let Ok(session) = Session::from_toml(&text) {
            let mut model = model();
            session.apply(&mut model);
            prop_assert!(model.cursor().slope.u.is_finite());
        }
    }
}
