//! Counts that show whether the code is still simple to read and to extend, each with its bound.
//!
//! `cargo test --test commands counts -- --nocapture` prints the table.

use super::reading::{PACKAGES, code, files};
use super::screenshots::{self, Stored};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

struct Count {
    subject: &'static str,
    found: usize,
    /// Largest number allowed; `None` where the number is only told.
    bound: Option<usize>,
    /// Files or lines counted, for the message; empty where they are too many to help.
    which: Vec<String>,
}

impl Count {
    fn of(subject: &'static str, bound: usize, which: Vec<String>) -> Self {
        Self { subject, found: which.len(), bound: Some(bound), which }
    }

    fn told(subject: &'static str, found: usize) -> Self {
        Self { subject, found, bound: None, which: Vec::new() }
    }
}

/// A source file: its package, its path below `src`, its text, and its code without comments and tests.
struct Source {
    package: &'static str,
    path: PathBuf,
    text: String,
    code: String,
}

fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |(name, path): (PathBuf, PathBuf)| {
        let package = PACKAGES.into_iter().find(|package| root.join(package).join(&name) == path).expect("a package");
        let text = std::fs::read_to_string(path).expect("text");
        let code = code(&text);
        Source { package, path: name, text, code }
    };
    files().into_iter().map(read).collect()
}

/// Lines of code of a package to a line of plain comments, which say why.
fn lines_to_a_why(package: &str) -> usize {
    let (mut code, mut why) = (0, 0);
    for source in sources().iter().filter(|source| source.package == package) {
        for line in source.text.lines().map(str::trim).filter(|line| !line.is_empty()) {
            match line.strip_prefix("//") {
                None => code += 1,
                Some(words) if words.starts_with(['/', '!']) => {}
                Some(_) => why += 1,
            }
        }
    }
    code / why
}

/// Names of the files for which `is` holds.
fn which(sources: &[Source], is: impl Fn(&Source) -> bool) -> Vec<String> {
    sources.iter().filter(|source| is(source)).map(|source| source.path.display().to_string()).collect()
}

/// Doc comments that begin with words that put off their subject.
fn late_subjects(source: &Source) -> impl Iterator<Item = String> + '_ {
    let mut inside = false;
    source.text.lines().enumerate().filter_map(move |(number, line)| {
        let comment = ["///", "//!"].into_iter().find_map(|mark| line.trim_start().strip_prefix(mark));
        let begins = !std::mem::replace(&mut inside, comment.is_some()) && comment.is_some();
        let words = comment.unwrap_or_default().trim_start();
        let is_late = ["What ", "The one that "].iter().any(|start| words.starts_with(start));
        (begins && is_late).then(|| format!("{}:{}", source.path.display(), number + 1))
    })
}

/// Comments of 8 to 60 words of which a quarter or more point at other words: a reader looks each of them up.
fn pointing(source: &Source) -> Vec<String> {
    const POINTERS: &str = " it its it's they them their that those this these which whose one ones what who whom ";
    let (mut found, mut comment, mut begin) = (Vec::new(), String::new(), 0);
    for (number, line) in source.text.lines().chain([""]).enumerate() {
        match line.trim_start().strip_prefix("//") {
            Some(words) => {
                begin = if comment.is_empty() { number + 1 } else { begin };
                comment += words.trim_start_matches(['/', '!']);
                comment.push(' ');
            }
            None => {
                let is_letter = |letter: char| letter.is_ascii_alphabetic() || letter == '\'';
                let words: Vec<&str> = comment.split(|c| !is_letter(c)).filter(|word| !word.is_empty()).collect();
                let is_pointer = |word: &&&str| POINTERS.contains(&format!(" {} ", word.to_lowercase()));
                let pointers = words.iter().filter(is_pointer).count();
                if (8..=60).contains(&words.len()) && 4 * pointers >= words.len() {
                    found.push(format!("{}:{begin}", source.path.display()));
                }
                comment.clear();
            }
        }
    }
    found
}

fn long_comments(source: &Source) -> impl Iterator<Item = String> + '_ {
    let is_long = |line: &str| line.trim_start().starts_with("//") && line.chars().count() > 120;
    let numbered = source.text.lines().enumerate().filter(move |(_, line)| is_long(line));
    numbered.map(|(number, _)| format!("{}:{}", source.path.display(), number + 1))
}

fn takers(source: &Source) -> impl Iterator<Item = String> + '_ {
    source.code.match_indices(": &mut Model").map(|(at, _)| {
        let line = source.code[..at].lines().count();
        format!("{}:{line}", source.path.display())
    })
}

/// Those in rooms that draw: panels and panes read the model, and push actions.
fn drawing_takers(sources: &[Source]) -> Vec<String> {
    let rooms = ["panel", "inspector", "workspace", "dataset", "measure", "figure", "canvas", "histogram"];
    let draws = |source: &&Source| rooms.iter().any(|room| source.path.starts_with(Path::new("app").join(room)));
    sources.iter().filter(draws).flat_map(takers).collect()
}

fn counts() -> Vec<Count> {
    let sources = sources();
    let lines = |source: &Source| source.text.lines().count();
    let is_shell = |source: &Source| source.code.contains("BurstscopeApp") && source.path != Path::new("app/mod.rs");
    let stored = screenshots::stored();
    let larger = |folder: &str, bytes: u64| {
        let is =
            |file: &&Stored| file.is_picture() && file.path.parent() == Some(Path::new(folder)) && file.bytes > bytes;
        stored.iter().filter(is).map(|file| file.path.display().to_string()).collect()
    };
    vec![
        Count::of("files that see the whole window", 4, which(&sources, is_shell)),
        Count::of(
            "files with methods of the whole window",
            2,
            which(&sources, |s| s.code.contains("impl BurstscopeApp")),
        ),
        Count::of(
            "functions outside of app/apply that take the whole model to change it",
            0,
            sources.iter().filter(|source| !source.path.starts_with("app/apply")).flat_map(takers).collect(),
        ),
        Count::of("functions that draw and take the model to change it", 0, drawing_takers(&sources)),
        Count::of(
            "doc comments that begin with “What” or “The one that”",
            19,
            sources.iter().flat_map(late_subjects).collect(),
        ),
        Count::of(
            "comments of which a quarter of the words point at others",
            35,
            sources.iter().flat_map(pointing).collect(),
        ),
        Count::of("lines of comments above 120 characters", 0, sources.iter().flat_map(long_comments).collect()),
        Count::of("files above 600 lines", 0, which(&sources, |source| lines(source) > 600)),
        Count { bound: Some(537), ..Count::told("source files", sources.len()) },
        Count { bound: Some(4_000_000), ..Count::told("bytes of screenshots", screenshots::bytes(&stored)) },
        Count::of("pictures of documents above 100 000 bytes", 0, larger("", 100_000)),
        // Noise takes more.
        Count::of("pictures without noise above 70 000 bytes", 0, larger("flat", 70_000)),
        Count::told("source files under 80 lines", which(&sources, |source| lines(source) < 80).len()),
        Count {
            bound: Some(33),
            ..Count::told("lines of code of the library to a line why", lines_to_a_why("core/src"))
        },
        Count { bound: Some(34), ..Count::told("lines of code of the bench to a line why", lines_to_a_why("lab/src")) },
        Count { bound: Some(57), ..Count::told("lines of code of the program to a line why", lines_to_a_why("src")) },
        Count::told("lines of all sources, their tests included", lines_of_rooms().values().sum()),
    ]
}

/// Most lines of each room: a folder of a package's sources, or its files outside of folders.
const ROOMS: &str = include_str!("rooms.txt");

fn rooms(text: &str) -> BTreeMap<String, usize> {
    let row = |line: &str| {
        let (room, lines) = line.split_once(' ').expect("a room and its lines");
        (room.to_owned(), lines.trim().parse().expect("a number"))
    };
    text.lines().map(row).collect()
}

fn lines_of_rooms() -> BTreeMap<String, usize> {
    let mut found = BTreeMap::new();
    for Source { package, path, text, .. } in sources() {
        let folder = (path.components().count() > 1).then(|| path.iter().next()).flatten();
        let room = folder.map_or(package.to_owned(), |folder| format!("{package}/{}", folder.display()));
        *found.entry(room).or_default() += text.lines().count();
    }
    found
}

#[test]
fn each_room_has_at_most_the_lines_that_it_is_given() {
    let (found, given) = (lines_of_rooms(), rooms(ROOMS));
    let text: String = found.iter().map(|(room, lines)| format!("{room} {lines}\n")).collect();
    println!("{text}");
    for (room, lines) in found {
        let bound = given.get(&room).copied().unwrap_or(0);
        assert!(lines <= bound, "{room} has {lines} lines, and is given {bound}");
    }
}

/// A room is given more only where others are given as much less in the same commit. Of a copy without its history,
/// only what the history would compare is left out: the rooms have their bounds.
#[test]
fn what_rooms_are_given_never_rises_together() {
    let file = "tests/commands/house/rooms.txt";
    let git = |arguments: &[&str]| {
        let root = env!("CARGO_MANIFEST_DIR");
        let done = std::process::Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
        done.status.success().then(|| String::from_utf8_lossy(&done.stdout).into_owned())
    };
    let commits = git(&["log", "--format=%H", "-n", "50", "--", file]).unwrap_or_default();
    let mut later = ("the files here".to_owned(), rooms(ROOMS).values().sum::<usize>());
    for commit in commits.lines() {
        let Some(text) = git(&["show", &format!("{commit}:{file}")]) else { continue };
        let given = rooms(&text).values().sum();
        assert!(later.1 <= given, "{} give the rooms {} lines, {commit} before them {given}", later.0, later.1);
        later = (commit.to_owned(), given);
    }
}

#[test]
fn counts_stay_within_their_bounds_and_late_subjects_are_counted_once_a_comment() {
    let counts = counts();
    for Count { subject, found, bound, .. } in &counts {
        let bound = bound.map(|bound| format!("at most {bound}")).unwrap_or_default();
        println!("{subject:<60} {found:>7}  {bound}");
    }
    for Count { subject, found, bound, which } in counts {
        assert!(bound.is_none_or(|bound| found <= bound), "{found} {subject}: {}", which.join(", "));
    }
    assert!(files().len() > 200, "too few files were read to be all");
    let text = "/// What it is.\n/// What it is not.\nfn a() {}\n/// Width, px.\n/// What follows.\nfn b() {}\n//! The one that runs.\n";
    let source = Source { package: "src", path: "x.rs".into(), text: text.to_owned(), code: String::new() };
    assert_eq!(late_subjects(&source).collect::<Vec<_>>(), ["x.rs:1", "x.rs:7"]);
}
