//! Lessons and sessions, damaged at random: reading returns a valid value or an error with a message.
//!
//! Other readers are tested in `core/tests/files/parsers.rs`; docs/FUZZING.md says which tests were run.

use crate::damage::{damage, damaged_text, says_something};
use burstscope::app::project::Model;
use burstscope::app::session::Session;
use burstscope::requests::{BurstSource, OpenBurst};
use burstscope::teach::Lesson;
use burstscope::{Burst, Plane};
use proptest::prelude::*;
use std::sync::OnceLock;

const LESSON: &str = "title = \"One\"\nabout = \"What it is about.\"\n[set]\nburst = \"demo-later\"\nslope = [1, 0]\n\n[[step]]\ntitle = \"First\"\ncaption = \"Some *text*.\"\nhighlight = [\"slope_u\", \"noise_gate\"]\ntry = \"Do it\"\ngoal = { slope_u = [-1, 1] }\n\n[[step]]\ntitle = \"Second\"\ncaption = \"More.\"\n[step.set]\nslope = [2, 0]\n";

fn model() -> Model {
    let mut model = Model::default();
    let burst = Burst::from_planes("test", vec![Plane::zeros(64, 48), Plane::zeros(64, 48)]);
    model.take_burst(OpenBurst::new(burst, BurstSource::Demo));
    model
}

fn sound_session() -> &'static str {
    static SOUND: OnceLock<String> = OnceLock::new();
    SOUND.get_or_init(|| Session::of(&model()).expect("a burst is open").to_toml())
}

/// Undamaged ones are read: the tests below begin with valid files.
#[test]
fn sound_ones_are_read() {
    assert!(Lesson::read("one.toml", LESSON).is_ok());
    assert!(Session::from_toml(sound_session()).is_ok());
}

proptest! {
    #[test]
    fn lessons(damages in damage()) {
        let text = damaged_text(LESSON, &damages);
        if let Err(error) = Lesson::read("one.toml", &text) {
            let lines = text.lines().count() + 1;
            prop_assert!(error.line.is_none_or(|line| (1..=lines).contains(&line)), "{}", error);
            prop_assert!(error.to_string().contains("one.toml"));
        }
    }

    #[test]
    fn sessions(damages in damage()) {
        match Session::from_toml(&damaged_text(sound_session(), &damages)) {
            Ok(session) => {
                let mut model = model();
                session.apply(&mut model);
                prop_assert!(model.cursor().slope.u.is_finite() && model.cursor().slope.v.is_finite());
            }
            Err(error) => prop_assert!(says_something(&error)),
        }
    }
}
