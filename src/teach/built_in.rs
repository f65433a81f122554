//! The lessons that are built into the program.

use super::lesson::Lesson;
use std::sync::{Arc, OnceLock};

macro_rules! texts {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../assets/lessons/", $name, ".toml")))),*]
    };
}

/// Name and text of each lesson, in teaching order: each builds on those before it.
pub(super) const TEXTS: &[(&str, &str)] = texts![
    "out-of-the-dark",
    "slope-is-depth",
    "blobs-at-every-scale",
    "what-noise-does",
    "when-it-fails",
    "from-features-to-cameras"
];

/// Built-in lessons, in teaching order: each builds on those before it.
pub fn built_in() -> &'static [Arc<Lesson>] {
    static LESSONS: OnceLock<Vec<Arc<Lesson>>> = OnceLock::new();
    LESSONS.get_or_init(|| {
        let read = |(name, text): &(&str, &str)| match Lesson::read(name, text) {
            Ok(lesson) => Arc::new(lesson),
            Err(error) => unreachable!("tests read every lesson that is built in: {error}"),
        };
        TEXTS.iter().map(read).collect()
    })
}

/// Names of the built-in lessons, as `--lesson` takes them.
pub fn built_in_names() -> impl Iterator<Item = &'static str> {
    TEXTS.iter().map(|(name, _)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teach::glossary::glossary;

    #[test]
    fn every_lesson_is_whole() {
        assert!(TEXTS.len() >= 6);
        for lesson in built_in() {
            assert!(lesson.steps.len() >= 7, "{} has {} steps", lesson.name, lesson.steps.len());
            assert!(TEXTS.iter().any(|(name, _)| *name == lesson.name), "{}", lesson.name);
            for step in &lesson.steps {
                let place = format!("{}: {}", lesson.name, step.title);
                let words = step.caption.split_whitespace().count();
                assert!((15..=110).contains(&words), "{place}: {words} words");
                assert!(step.task.is_some(), "{place}: nothing to try");
                assert!(!step.highlight.is_empty(), "{place}: nothing is pointed at");
            }
        }
    }

    #[test]
    fn links_to_the_glossary_lead_somewhere() {
        let mut links = 0;
        for lesson in built_in() {
            for step in &lesson.steps {
                for link in step.caption.split("](word:").skip(1) {
                    let name = link.split(')').next().expect("a part");
                    assert!(glossary().find(name).is_some(), "{}: no word is called '{name}'", lesson.name);
                    links += 1;
                }
            }
        }
        assert!(links >= 20, "{links} links");
    }
}
