//! Lessons and sessions, damaged at random: reading returns a valid value or an error with a message.
//!
//! Other readers are tested in `core/tests/files/parsers.rs`; docs/FUZZING.md says which tests were run.

use crate::damage::{absurd, absurd_tomls, at, damage, damaged_text, numbers, says_something};
use crate::support::*;
use burstscope::app::{apply, document::action::Reselect, results::Model, results::Read, session::Session};
use burstscope::detector::SlopeAxis;
use burstscope::inspect::slopes::SetUp;
use burstscope::recover::RecoverStudy;
use burstscope::synth::NoisyParams;
use burstscope::teach::Lesson;
use proptest::prelude::*;
use toml::{Table, Value};

const LESSON: &str = "title = \"One\"\nabout = \"What it is about.\"\n[set]\nburst = \"demo-later\"\nslope = [1, 0]\n\n[[step]]\ntitle = \"First\"\ncaption = \"Some *text*.\"\nhighlight = [\"slope_u\", \"noise_gate\"]\ntry = \"Do it\"\ngoal = { slope_u = [-1, 1] }\n\n[[step]]\ntitle = \"Second\"\ncaption = \"More.\"\n[step.set]\nslope = [2, 0]\n";

fn model() -> Model {
    let mut model = Model::default();
    let burst = Burst::from_planes("test", vec![Plane::zeros(64, 48), Plane::zeros(64, 48)]);
    apply::opening::take_burst(&mut model, OpenBurst::new(burst, BurstSource::Demo));
    model
}

fn sound_session() -> &'static str {
    static SOUND: OnceLock<String> = OnceLock::new();
    SOUND.get_or_init(|| Session::of(Read::of(&model())).expect("a burst is open").to_toml())
}

/// Undamaged ones are read: the tests below begin with valid files.
#[test]
fn sound_ones_are_read() {
    assert!(Lesson::read("one.toml", LESSON).is_ok());
    assert!(Session::from_toml(sound_session()).is_ok());
}

/// Parts of a session that hold numbers and that the window need not have.
const MORE: &str = r#"
selection = { index = 0, u = 20.0, v = 20.0, sigma = 3.0, slope = { u = 0.5, v = 0.0 } }
selected_match = { a = [20.0, 20.0], b = [20.0, 20.0] }

[document]
bottom_tab = "tally"
slopes = "given"
probe = { question = { at = { place = [20.0, 20.0], wanted = { feature = 0 } } }, near_sigma = 3.0, is_open = true }
selected_match = 0
asked_about = 0
dataset = { source = { paths = ["nowhere"], burst_length = 2, burst_step = 1 }, pair = { a = 0, b = 1 } }
filter = { slope_u = { min = -1.0, max = 1.0 }, slope_v = { min = -1.0, max = 1.0 }, sigma = { min = 0.0, max = 99.0 }, response = { min = 0.0, max = 1.0 }, coherence = { min = 0.0, max = 1.0 }, near_slope = 0.5 }

[document.look]
smoothing_px = 1.5

[document.matching.camera]
model = "PINHOLE"
width = 96
height = 64
params = [90.0, 90.0, 48.0, 32.0]

[document.panes]
next = 9

[document.panes.inspect]
focus = 7
arrangement = { row = [{ share = 1.0, inner = { pane = 0 } }, { share = 2.0, inner = { tabs = { parts = [{ pane = 7 }, { pane = 8 }], active = 1 } } }] }

[document.panes.pane.0]
over = { wipe = { other = 7, at = 0.5 } }
view = { zoom = { points_per_pixel = 2.0 }, centre_image = [20.0, 20.0] }
cursor = { kind = "dog", frame = 1, slope = { u = 0.5, v = 0.0 }, octave = 0, level = 1 }

[document.panes.pane.1]
side = "b"
view = { zoom = { points_per_pixel = 2.0 }, centre_image = [20.0, 20.0] }

[document.panes.pane.7]
content = { difference = [0, 8] }
links = { display = false, view = false, cursor = false }
own_ranges = { intensity = { min = 0.0, max = 1.0, gamma = 1.0 }, response = { min = -0.1, max = 0.1, gamma = 1.0, symmetric = true } }
cursor = { kind = "stack", frame = 1, slope = { u = 0.5, v = 0.0 }, octave = 0, level = 1 }

[document.panes.pane.8]
content = "merge"
"#;

fn merge(into: &mut Table, more: Table) {
    for (key, value) in more {
        match (into.get_mut(&key), value) {
            (Some(Value::Table(old)), Value::Table(new)) => merge(old, new),
            (_, value) => drop(into.insert(key, value)),
        }
    }
}

/// A session that has every part that holds numbers.
fn full_session() -> String {
    let mut session: Table = sound_session().parse().expect("TOML");
    // The values of enums are tables, which are not merged.
    let document = session.get_mut("document").and_then(Value::as_table_mut).expect("a document");
    for part in ["panes", "slopes"] {
        document.remove(part);
    }
    merge(&mut session, MORE.parse().expect("TOML"));
    let detector = DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 3), octaves: 1, ..DetectorParams::default() };
    let search = SearchParams::from(detector.clone());
    let chart = ChartParams { width: 96, height: 64, discs: 2, radius: 3.6..=5.0, gap: 2.0, ..ChartParams::default() };
    let chart = BurstSource::Chart(Box::new(ChartParams { frames: 3, max_slope: 1.0, snr: 9.0, ..chart }));
    let study = RecoverStudy {
        snrs: vec![0.5],
        slopes: Some(SlopeAxis::new(-1.0..=1.0, 3)),
        radii: vec![3.0],
        at_snr: Some(1.0),
        at_radius: 3.0,
        per_copy: Some(9),
        search: search.clone(),
        ..RecoverStudy::default()
    };
    let mut set = |key: &str, value: Value| drop(session.insert(key.to_owned(), value));
    let value = |source: &BurstSource| Value::try_from(source).expect("plain values");
    let planted = BurstSource::Planted { of: Box::new(chart.clone()), study: Box::new(study.clone()), seed: 1 };
    set("burst", value(&BurstSource::DarkCopy { of: Box::new(chart), noise: NoisyParams::default() }));
    set("second", value(&planted));
    let mut part = |name: &str, inner: &[&str], value: Value| {
        let part = session.get_mut(name).and_then(Value::as_table_mut).expect("a table");
        let (last, way) = inner.split_last().expect("a key");
        let at = way.iter().fold(part, |part, key| part[*key].as_table_mut().expect("a table"));
        at.insert((*last).to_owned(), value);
    };
    part("document", &["params"], Value::try_from(&detector).expect("plain values"));
    part("document", &["lab", "planted"], Value::try_from(&study).expect("plain values"));
    part("document", &["set_up", "values"], Value::try_from(SetUp::default()).expect("plain values"));
    part("document", &["set_up", "reads_depths"], true.into());
    let calibration = toml::toml! { full_scale = 1.0
    black_level = 0.0 };
    part("document", &["calibration"], calibration.into());
    part("document", &["comparisons", "a", "pinned"], Value::try_from(&search).expect("plain values"));
    toml::to_string(&session).expect("plain values")
}

#[test]
fn any_number_of_a_session_is_refused_by_its_name_or_does_no_harm() {
    let text = full_session();
    let sound = Session::from_toml(&text).expect("sound");
    assert!(sound.burst.burst(&Default::default(), &Monitor::default()).is_ok());
    let (mut refused, mut taken) = (Vec::new(), 0);
    for (path, changed, value) in absurd_tomls(&text) {
        match Session::from_toml(&changed) {
            Err(error) => {
                assert!(says_something(&error), "{path} = {value}: {error}");
                refused.push((path, value, error));
            }
            Ok(session) => {
                taken += 1;
                let mut model = model();
                let document = session.over_second(&session.over_first(&model.document));
                apply::staged::show_document(&mut model, document, Reselect::Feature(session.selection));
                let focus = model.document.focus();
                model.document.panes.split(focus, burstscope::app::pane::Direction::Right);
                assert!(model.document.cursor().slope.u.is_finite(), "{path} = {value}");
                assert!(model.document.look.smoothing_px <= 8.0, "{path} = {value}");
                if path.starts_with("burst.") {
                    // It is made or refused; what cannot be seen beforehand is said when it is opened.
                    let made = session.burst.burst(&Default::default(), &Monitor::default());
                    assert!(made.map_or_else(|error| says_something(&error.to_string()), |burst| burst.len() < 5000));
                }
            }
        }
    }
    assert!(refused.len() > 250 && taken > 250, "{} {taken}", refused.len());
    for (part, path, value, words) in [
        ("document.look", "smoothing_px", "1000000000.0", "smoothing_px: 1000000000; give 0 to 8 pixels"),
        ("document.look", "smoothing_px", "nan", "smoothing_px: NaN; give 0 to 8 pixels"),
        ("document.lab.planted", "slopes.count", "1000000000", "planted-slopes: 1000000000 slopes; at most 4096"),
        ("document.lab.planted", "copies", "0", "copies: 0; give 1 to 100000"),
        ("document.lab.planted", "radii.0", "1000000000.0", "radius: 1000000000; give 0.5 to 500 pixels"),
        ("document.lab.planted", "search.slopes.u.count", "1000000000", "slopes-u: 1000000000 slopes"),
        ("document.params", "slopes.u.count", "1000000000", "slopes-u: 1000000000 slopes; at most 4096"),
        ("document.params", "levels", "0", "levels: 0; give 1 to 10"),
        ("document.comparisons.a.pinned", "slopes.v.count", "9223372036854775807", "slopes-v: "),
        ("burst", "dark_copy.of.chart.width", "1000000000", "width: 1000000000 pixels; give 16 to 32768"),
        ("burst", "dark_copy.noise.snr", "nan", "snr: NaN; give a ratio"),
        ("second", "planted.study.slopes.count", "1000000000", "planted-slopes: "),
        ("document.matching", "max_iterations", "1000000000", "max-iterations: 1000000000; give 1 to 10000000"),
        ("document.set_up", "values.focal_px", "1000000000.0", "focal-px: 1000000000; give 1 to 1000000 pixels"),
    ] {
        let path = format!("{part}.{path}");
        let said = refused.iter().find(|(of, with, _)| (of.as_str(), with.as_str()) == (&*path, value));
        says(&said.unwrap_or_else(|| panic!("{path} = {value} was taken")).2, &[&format!("{part}: {words}")]);
    }
    let beyond = text.replacen("smoothing_px = 1.5", "smoothing_px = 18446744073709551615", 1);
    assert!(Session::from_toml(&beyond).is_err());
    // The program says the file's name too, and draws nothing.
    let home = folder();
    let wide = text.replacen("smoothing_px = 1.5", "smoothing_px = 1e9", 1);
    home.write("wide.burstscope.toml", wide);
    let words = home.run_badly("render wide.burstscope.toml --out a.png", 1);
    assert!(words.contains("wide.burstscope.toml") && words.contains("smoothing_px: 1000000000"), "{words}");
}

#[test]
fn a_session_of_absurd_numbers_is_drawn() {
    let home = folder();
    let text = full_session();
    let mut whole: Value = toml::from_str(&text).expect("TOML");
    // A dataset that is not there would end the drawing.
    whole["document"].as_table_mut().and_then(|document| document.remove("dataset")).expect("a dataset");
    Session::from_toml(&toml::to_string(&whole).expect("plain values")).expect("sound");
    for which in 0..4 {
        // As many at a time as are taken.
        let mut all = whole.clone();
        for (path, number) in numbers(&whole) {
            let mut next = all.clone();
            *at(&mut next, &path) = absurd(&number)[which].clone();
            if Session::from_toml(&toml::to_string(&next).expect("plain values")).is_ok() {
                all = next;
            }
        }
        home.write("a.burstscope.toml", toml::to_string(&all).expect("plain values"));
        let arguments = "render a.burstscope.toml --out a.png --force --size 900x600 --timeout 60";
        let output = ended(home.start(arguments));
        let words = stderr(&output);
        assert!(matches!(output.status.code(), Some(0 | 1)) && !words.contains("panicked"), "{which}: {words}");
        assert!(!words.contains("seconds"), "{which}: it is not done in time: {words}");
    }
}

#[test]
fn any_number_of_a_lesson_is_refused_or_does_no_harm() {
    let lesson = r#"
title = "One"
about = "What it is about."
[set]
frame = 1
slope = [1.0, 0.0]
octave = 0
level = 1
view = [1.0, 1.0, 20.0, 20.0]
probe = [10.0, 10.0]
spot = [10.0, 10.0, 3.0, 5.0, 9.0]
[set.params]
peak_threshold = 0.01
levels = 3
slopes = { u = { min = -1.0, max = 1.0, count = 3 } }
[set.matching]
ratio = 0.8
max_iterations = 100
[set.set_up]
speed_m_s = 0.5
direction_deg = 0.0
turn_deg_s = 0.0
frames_per_second = 30.0
focal_px = 1200.0
depth_m = [1.0, 8.0]
[[step]]
title = "First"
caption = "Some text."
try = "Do it"
goal = { slope_u = [-1.0, 1.0], features = [1.0, 9.0] }
"#;
    Lesson::read("one.toml", lesson).expect("sound");
    let (mut refused, mut taken) = (0, 0);
    for (path, changed, value) in absurd_tomls(lesson) {
        match Lesson::read("one.toml", &changed) {
            Ok(_) => taken += 1,
            Err(error) => {
                refused += 1;
                let words = error.to_string();
                assert!(words.contains("one.toml") && says_something(&words), "{path} = {value}: {words}");
            }
        }
    }
    assert!(refused > 60 && taken > 40, "{refused} {taken}");
    let counted = lesson.replacen("count = 3", "count = 1000000000", 1);
    says(Lesson::read("one.toml", &counted).expect_err("too many"), &["slopes_u: 1000000000 slopes; at most 4096"]);
}

proptest! {
    #[test]
    fn lessons(damages in damage()) {
        let text = damaged_text(LESSON, &damages);
        if let Err(error) = Lesson::read("one.toml", &text) {
            let lines = text.lines().count() + 1;
            let line = error.subject.rsplit_once(", line ").map(|(_, line)| line.parse::<usize>());
            prop_assert!(line.is_none_or(|line| line.is_ok_and(|line| (1..=lines).contains(&line))), "{}", error);
            prop_assert!(error.to_string().contains("one.toml"));
        }
    }

    #[test]
    fn sessions(damages in damage()) {
        match Session::from_toml(&damaged_text(sound_session(), &damages)) {
            Ok(session) => {
                let mut model = model();
                let document = session.over_first(&model.document);
    apply::staged::show_document(&mut model, document, Reselect::Feature(session.selection));
                prop_assert!(model.document.cursor().slope.u.is_finite() && model.document.cursor().slope.v.is_finite());
            }
            Err(error) => prop_assert!(says_something(&error)),
        }
    }
}
