//! Lessons: reading from a file or a folder, with errors that name the line, and those built into the program.

use super::values::{Text, text};
use super::{Goal, Layout, Part, State, Workspace};
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
    pub questions: Vec<Question>,
    /// At least one.
    pub steps: Vec<Step>,
}

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
    /// Reads the text of a lesson's file; `file` is named in errors, its stem is the lesson's name. Errors name lines.
    pub fn read(file: &str, text: &str) -> Result<Self, Error> {
        let wrong = |line: Option<usize>, problem: String| wrong_at(file, line, &problem);
        let line_at = |byte: usize| text.as_bytes()[..byte.min(text.len())].iter().filter(|b| **b == b'\n').count() + 1;
        let read: LessonFile = toml::from_str(text).map_err(|error| {
            let line = error.span().map(|span| line_at(span.start));
            wrong(line, error.message().replace('\n', " ").trim().to_owned())
        })?;
        let step_span = read.step.span();
        // Read again as a table, because the typed form does not say which word named a workspace.
        let tables: toml::Table = toml::from_str(text).expect("it was read already");
        let mut steps = Vec::new();
        for (table, written) in read.step.into_inner().into_iter().zip(tables["step"].as_array().expect("steps")) {
            let line = line_at(table.span().start);
            let step = table.into_inner().step(&read.set).map_err(|problem| wrong(Some(line), problem))?;
            steps.push(step.with_methods(written, &tables));
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
        let wrong = |problem: &str| Err(format!("step '{title}' {problem}"));
        let task = match (self.r#try, self.goal) {
            (Some(Text(text)), Some(goal)) if !goal.is_empty() => Some(Task { text, goal }),
            (None, None) => None,
            (Some(_), _) => return wrong("has 'try' but no 'goal'; add the goal that ends the task"),
            (None, Some(_)) => return wrong("has 'goal' but no 'try'; add the text of the task"),
        };
        let state = self.set.over(default);
        // These parts show what is measured at the spot.
        let in_lesson = |part: &Part| matches!(part, Part::Snr | Part::FramesAdded);
        if state.spot.is_none()
            && let Some(part) = self.highlight.iter().find(|part| in_lesson(part))
        {
            return wrong(&format!("highlights '{part}', which needs a 'spot' to measure; set one"));
        }
        // A lesson must not point at a part whose panel is closed.
        let is_hidden = |part: &&Part| match part {
            Part::Tabs | Part::Below => state.tab.is_none() && state.workspace != Some(Workspace::Pair),
            Part::Probe | Part::Response | Part::Shares => state.probe.is_none() || state.layout == Some(Layout::Slice),
            _ => false,
        };
        if let Some(part) = self.highlight.iter().find(is_hidden) {
            let key = if matches!(part, Part::Tabs | Part::Below) { "'tab'" } else { "'probe', without a slice" };
            return wrong(&format!("highlights '{part}', whose panel is closed; set {key}"));
        }
        Ok(Step { title, caption: self.caption.0, highlight: self.highlight, task, state })
    }
}

impl Step {
    /// The step with the layout *Methods*, where a lesson or step names that as a workspace.
    fn with_methods(mut self, step: &toml::Value, lesson: &toml::Table) -> Self {
        let workspace = |table: Option<&toml::Value>| table?.get("workspace")?.as_str().map(str::to_owned);
        let is_methods = |name: Option<String>| name.is_some_and(|name| name == "methods");
        if is_methods(workspace(step.get("set")).or_else(|| workspace(lesson.get("set")))) {
            self.state.layout = Some(Layout::Methods);
        }
        if let Some(task) = self.task.as_mut().filter(|_| is_methods(workspace(step.get("goal")))) {
            task.goal.layout = Some(Layout::Methods);
        }
        self
    }
}

/// Reads the lessons of one file, or of all `*.toml` of a folder by name; the errors of all files instead, if any.
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
    // All files are read, so that a teacher sees all mistakes at once.
    let (read, failed): (Vec<_>, Vec<_>) = files.iter().map(|file| read_file(file)).partition(Result::is_ok);
    let errors: Vec<Error> = failed.into_iter().filter_map(Result::err).collect();
    if errors.is_empty() { Ok(read.into_iter().flatten().collect()) } else { Err(errors) }
}

fn read_file(path: &Path) -> Result<Lesson, Error> {
    let file = path.display().to_string();
    let wrong = |problem: String| wrong_at(&file, None, &problem);
    Lesson::read(&file, &read_text(path, MAX_BYTES).map_err(|error| wrong(error.to_string()))?)
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

pub fn built_in_names() -> impl Iterator<Item = &'static str> {
    TEXTS.iter().map(|(name, _)| *name)
}
