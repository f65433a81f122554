//! Lessons: reading from a file or a folder, with errors that name the line, and those built into the program.

use super::goal::Goal;
use super::part::Part;
use super::state::{Layout, State, Workspace};
use super::values::{Text, text};
use crate::error::{Error, ErrorKind};
use crate::files::read_text;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use toml::Spanned;

#[derive(Debug, Clone, PartialEq)]
pub struct Lesson {
    /// Name on the command line: the file's name without its ending.
    pub name: String,
    pub title: String,
    /// Learning goal, in a sentence.
    pub about: String,
    /// Lines that sum up the lesson, shown at its end, in CommonMark.
    pub learnt: Vec<String>,
    /// Questions of the lesson's sheet, with their answers.
    pub questions: Vec<Question>,
    /// At least one.
    pub steps: Vec<Step>,
}

/// Question about a lesson and its answer, in CommonMark.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Question {
    #[serde(deserialize_with = "text")]
    pub ask: String,
    #[serde(deserialize_with = "text")]
    pub answer: String,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    pub title: String,
    /// Explanation, in CommonMark. Links to `word:NAME` lead to the glossary.
    pub caption: String,
    pub highlight: Vec<Part>,
    pub task: Option<Task>,
    pub state: State,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Instruction, in CommonMark.
    pub text: String,
    pub goal: Goal,
}

const MAX_BYTES: u64 = 1 << 20;

/// An error at a line, counted from 1, of a lesson's file, which may be the lesson's name.
fn wrong_at(file: &str, line: Option<usize>, problem: &str) -> Error {
    let line = line.map_or_else(String::new, |line| format!(", line {line}"));
    Error { subject: format!("{file}{line}"), ..Error::new(ErrorKind::Content, problem, "") }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LessonFile {
    title: Text,
    about: Text,
    #[serde(default)]
    learnt: Vec<Text>,
    #[serde(default)]
    questions: Vec<Question>,
    #[serde(default)]
    set: State,
    step: Spanned<Vec<Spanned<StepTable>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StepTable {
    title: Text,
    caption: Text,
    #[serde(default)]
    highlight: Vec<Part>,
    r#try: Option<Text>,
    goal: Option<Goal>,
    #[serde(default)]
    set: State,
}

impl Lesson {
    /// Reads the text of a lesson's file. `file` is named in errors, and its stem is the lesson's name.
    ///
    /// # Errors
    /// The first mistake, with its line.
    pub fn read(file: &str, text: &str) -> Result<Self, Error> {
        let wrong = |line: Option<usize>, problem: String| wrong_at(file, line, &problem);
        let line_at = |byte: usize| text.as_bytes()[..byte.min(text.len())].iter().filter(|b| **b == b'\n').count() + 1;
        let read: LessonFile = toml::from_str(text).map_err(|error| {
            let line = error.span().map(|span| line_at(span.start));
            wrong(line, error.message().replace('\n', " ").trim().to_owned())
        })?;
        let step_span = read.step.span();
        let mut steps = Vec::new();
        for table in read.step.into_inner() {
            let line = line_at(table.span().start);
            let step = table.into_inner().step(&read.set).map_err(|problem| wrong(Some(line), problem))?;
            steps.push(step);
        }
        if steps.is_empty() {
            return Err(wrong(Some(line_at(step_span.start)), "a lesson needs at least one [[step]]".to_owned()));
        }
        let stem = Path::new(file).file_stem().map_or_else(|| file.into(), |stem| stem.to_string_lossy());
        let learnt = read.learnt.into_iter().map(|line| line.0).collect();
        let (title, about, questions) = (read.title.0, read.about.0, read.questions);
        Ok(Self { name: stem.into_owned(), title, about, learnt, questions, steps })
    }
}

impl StepTable {
    fn step(self, default: &State) -> Result<Step, String> {
        let Text(title) = self.title;
        let task = match (self.r#try, self.goal) {
            (Some(Text(text)), Some(goal)) if !goal.is_empty() => Some(Task { text, goal }),
            (None, None) => None,
            (Some(_), _) => {
                return Err(format!("step '{title}' has 'try' but no 'goal'; add the goal that ends the task"));
            }
            (None, Some(_)) => {
                return Err(format!("step '{title}' has 'goal' but no 'try'; add the text of the task"));
            }
        };
        let state = self.set.over(default);
        let in_lesson = |part: &Part| matches!(part, Part::Snr | Part::FramesAdded);
        if state.spot.is_none()
            && let Some(part) = self.highlight.iter().find(|part| in_lesson(part))
        {
            return Err(format!("step '{title}' highlights '{part}', which needs a 'spot' to measure; set one"));
        }
        let is_hidden = |part: &&Part| match part {
            Part::Tabs | Part::Below => state.tab.is_none() && state.workspace != Some(Workspace::Pair),
            Part::Probe | Part::Response | Part::Shares => state.probe.is_none() || state.layout == Some(Layout::Slice),
            _ => false,
        };
        if let Some(part) = self.highlight.iter().find(is_hidden) {
            let key = if matches!(part, Part::Tabs | Part::Below) { "'tab'" } else { "'probe', without a slice" };
            return Err(format!("step '{title}' highlights '{part}', whose panel is closed; set {key}"));
        }
        Ok(Step { title, caption: self.caption.0, highlight: self.highlight, task, state })
    }
}

/// Reads the lessons at `path`: one file, or all files `*.toml` of a folder, in the order of their names.
///
/// # Errors
/// All mistakes, one for each file that has any; no lesson is returned then.
pub fn lessons_at(path: &Path) -> Result<Vec<Lesson>, Vec<Error>> {
    let whole = |problem: String| wrong_at(&path.display().to_string(), None, &problem);
    let files = if path.is_dir() {
        let entries = std::fs::read_dir(path).and_then(|entries| entries.collect::<Result<Vec<_>, _>>());
        let entries = entries.map_err(|error| vec![whole(error.to_string())])?;
        let is_lesson = |path: &PathBuf| path.is_file() && path.extension().is_some_and(|ending| ending == "toml");
        let mut files: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).filter(is_lesson).collect();
        alphanumeric_sort::sort_path_slice(&mut files);
        if files.is_empty() {
            return Err(vec![whole("the folder has no lesson; give a folder with *.toml files".to_owned())]);
        }
        files
    } else {
        vec![path.to_owned()]
    };
    let (mut lessons, mut errors) = (Vec::new(), Vec::new());
    for file in files {
        match read_file(&file) {
            Ok(lesson) => lessons.push(lesson),
            Err(error) => errors.push(error),
        }
    }
    if errors.is_empty() { Ok(lessons) } else { Err(errors) }
}

fn read_file(path: &Path) -> Result<Lesson, Error> {
    let file = path.display().to_string();
    let wrong = |problem: String| wrong_at(&file, None, &problem);
    let text = read_text(path, MAX_BYTES).map_err(|error| wrong(error.to_string()))?;
    Lesson::read(&file, &text)
}

macro_rules! texts {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../assets/lessons/", $name, ".toml")))),*]
    };
}

const TEXTS: &[(&str, &str)] = texts![
    "out-of-the-dark",
    "slope-is-depth",
    "the-aperture",
    "blobs-at-every-scale",
    "what-noise-does",
    "what-a-burst-costs",
    "ghosts",
    "when-it-fails",
    "from-features-to-cameras",
    "from-light-fields-to-bursts"
];

/// Built-in lessons, in teaching order.
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
    use proptest::prelude::*;

    const GOOD: &str = r#"title = "One"
about = "What it is about."
[set]
burst = "demo-later"
slope = [1, 0]

[[step]]
title = "First"
caption = "Some *text*."
highlight = ["slope_u", "noise_gate"]
try = "Do it"
goal = { slope_u = [-1, 1] }

[[step]]
title = "Second"
caption = "More."
[step.set]
slope = [2, 0]
"#;

    #[test]
    fn a_lesson_is_read_and_its_steps_have_what_it_sets_for_all() {
        let lesson = Lesson::read("folder/one.toml", GOOD).expect("good");
        assert_eq!((lesson.name.as_str(), lesson.title.as_str(), lesson.steps.len()), ("one", "One", 2));
        let [first, second] = &lesson.steps[..] else { panic!("two steps") };
        assert_eq!((first.state.slope.map(|s| s.u), second.state.slope.map(|s| s.u)), (Some(1.0), Some(2.0)));
        assert_eq!(first.state.burst(), second.state.burst());
        assert_eq!(first.highlight, [Part::SlopeU, Part::Parameter("noise-gate")]);
        assert!(first.task.is_some() && second.task.is_none());
    }

    #[test]
    fn a_mistake_is_said_with_its_line() {
        // Text that is replaced, its replacement, the line of the mistake, and a word of the message.
        for (from, to, line, word) in [
            ("title = \"One\"", "titel = \"One\"", 1, "titel"),
            ("\"slope_u\"", "\"slope_x\"", 10, "slope_x"),
            ("\"demo-later\"", "\"street\"", 4, "street"),
            ("goal = { slope_u = [-1, 1] }", "goal = { slope_u = [1, -1] }", 12, "give min"),
            ("goal = { slope_u = [-1, 1] }", "goal = { slope = [1, 2] }", 12, "slope"),
            ("goal = { slope_u = [-1, 1] }", "", 7, "no 'goal'"),
            ("try = \"Do it\"", "", 7, "no 'try'"),
            ("caption = \"More.\"", "caption = \" \"", 16, "empty"),
            ("caption = \"More.\"", "caption = \"More.", 16, ""),
            ("slope = [2, 0]", "slope = [2]", 18, ""),
            ("slope = [2, 0]", "params = { levels = 99 }", 18, "levels"),
            ("slope = [2, 0]", "params = { level = 3 }", 18, "level"),
            ("highlight = [\"slope_u\", \"noise_gate\"]", "highlight = [\"snr\"]", 7, "spot"),
            ("highlight = [\"slope_u\", \"noise_gate\"]", "highlight = [\"below\"]", 7, "set 'tab'"),
            ("highlight = [\"slope_u\", \"noise_gate\"]", "highlight = [\"response\"]", 7, "set 'probe'"),
            ("slope = [2, 0]", "view = [9, 9, 8, 12]", 18, "left < right"),
            ("slope = [2, 0]", "view = [9, 9, 0]", 18, "zoom"),
        ] {
            let text = GOOD.replace(from, to);
            assert_ne!(text, GOOD, "{from} is in it");
            let error = Lesson::read("one.toml", &text).expect_err(to);
            assert_eq!(error.subject, format!("one.toml, line {line}"), "{to}: {error}");
            assert!(error.problem.contains(word), "{error}");
        }
        let none = Lesson::read("x", "title = \"a\"\nabout = \"b\"\nstep = []").expect_err("no step");
        assert!(none.problem.contains("at least one") && none.subject.ends_with(", line 3"), "{none}");
        assert!(Lesson::read("x", "").is_err());
    }

    #[test]
    fn a_folder_is_read_in_the_order_of_its_names_or_every_mistake_is_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
        assert!(lessons_at(folder.path()).expect_err("empty")[0].problem.contains("no lesson"));
        write("10.toml", GOOD);
        write("9.toml", GOOD);
        write("notes.txt", "not read");
        let names: Vec<String> = lessons_at(folder.path()).expect("good").into_iter().map(|l| l.name).collect();
        assert_eq!(names, ["9", "10"]);
        write("bad.toml", "title = 3");
        write("worse.toml", "\n\nabout = [");
        let errors = lessons_at(folder.path()).expect_err("two are wrong");
        assert_eq!(errors.len(), 2);
        assert!(errors[0].subject.ends_with("bad.toml, line 1"), "{}", errors[0]);
        assert_eq!(lessons_at(&folder.path().join("9.toml")).expect("good").len(), 1);
        assert!(lessons_at(&folder.path().join("none.toml")).is_err());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn no_damaged_lesson_makes_it_panic(which in 0usize..99, at in 0usize..9000, junk in "[a-z0-9=\\[\\]\"{}.\\-\n]{0,6}") {
            let (name, text) = TEXTS[which % TEXTS.len()];
            let mut at = at % (text.len() + 1);
            while !text.is_char_boundary(at) { at -= 1; }
            let mut text = text.to_owned();
            text.insert_str(at, &junk);
            if let Err(error) = Lesson::read(name, &text) {
                let lines = text.lines().count() + 1;
                let line = error.subject.rsplit_once(", line ").map(|(_, line)| line.parse::<usize>());
                prop_assert!(line.is_none_or(|line| line.is_ok_and(|line| (1..=lines).contains(&line))), "{error}");
                prop_assert!(!error.problem.is_empty());
            }
        }
    }

    #[test]
    fn every_lesson_is_whole_and_its_links_lead_to_the_glossary() {
        assert!(TEXTS.len() >= 9);
        for lesson in built_in() {
            assert_eq!(lesson.learnt.len(), 3, "{}: three lines of what was learnt", lesson.name);
            for line in &lesson.learnt {
                let words = line.split_whitespace().count();
                assert!((6..=30).contains(&words), "{}: {words} words: {line}", lesson.name);
            }
            assert!(lesson.questions.len() >= 3, "{}: questions for the sheet", lesson.name);
            assert!(lesson.steps.len() >= 7, "{} has {} steps", lesson.name, lesson.steps.len());
            for step in &lesson.steps {
                let place = format!("{}: {}", lesson.name, step.title);
                let words = step.caption.split_whitespace().count();
                assert!((15..=110).contains(&words), "{place}: {words} words");
                assert!(step.task.is_some(), "{place}: nothing to try");
                assert!(!step.highlight.is_empty(), "{place}: nothing is pointed at");
                for link in step.caption.split("](word:").skip(1) {
                    let name = link.split(')').next().expect("a part");
                    assert!(glossary().find(name).is_some(), "{place}: no word is called '{name}'");
                }
            }
        }
    }
}
