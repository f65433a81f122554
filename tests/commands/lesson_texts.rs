//! Texts of lessons: what is read of them, and how mistakes are said.

use crate::shared::folder;
use burstscope::teach::{Layout, Lesson, Part, Workspace, built_in, glossary::glossary, lessons_at};
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

fn texts() -> Vec<(String, String)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/lessons");
    let files = std::fs::read_dir(folder).expect("lessons").map(|entry| entry.expect("a lesson").path());
    let read = |path: std::path::PathBuf| (path.display().to_string(), std::fs::read_to_string(path).expect("a text"));
    files.filter(|path| path.extension().is_some_and(|is| is == "toml")).map(read).collect()
}

#[test]
fn a_lesson_is_read_and_one_of_when_methods_were_a_workspace_asks_for_their_layout() {
    let lesson = Lesson::read("folder/one.toml", GOOD).expect("good");
    assert_eq!((lesson.name.as_str(), lesson.title.as_str(), lesson.steps.len()), ("one", "One", 2));
    let [first, second] = &lesson.steps[..] else { panic!("two steps") };
    assert_eq!((first.state.slope.map(|s| s.u), second.state.slope.map(|s| s.u)), (Some(1.0), Some(2.0)));
    assert_eq!(first.state.burst(), second.state.burst());
    assert_eq!(first.highlight, [Part::SlopeU, Part::Parameter("noise-gate")]);
    assert!(first.task.is_some() && second.task.is_none());
    let goal = GOOD.replace("goal = { slope_u = [-1, 1] }", "goal = { workspace=\"methods\", detects = true }");
    let lesson = Lesson::read("one.toml", &goal.replace("slope = [2, 0]", "workspace = 'methods'")).expect("good");
    let [first, second] = &lesson.steps[..] else { panic!("two steps") };
    let goal = &first.task.as_ref().expect("a task").goal;
    assert_eq!((goal.layout, goal.workspace), (Some(Layout::Methods), Some(Workspace::Inspect)));
    assert_eq!((first.state.layout, second.state.layout), (None, Some(Layout::Methods)));
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
fn folders_are_read_in_the_order_of_names_and_every_lesson_and_its_links_are_whole() {
    let folder = folder();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    assert!(lessons_at(&folder).expect_err("empty")[0].problem.contains("no lesson"));
    write("10.toml", GOOD);
    write("9.toml", GOOD);
    write("notes.txt", "not read");
    let names: Vec<String> = lessons_at(&folder).expect("good").into_iter().map(|l| l.name).collect();
    assert_eq!(names, ["9", "10"]);
    write("bad.toml", "title = 3");
    write("worse.toml", "\n\nabout = [");
    let errors = lessons_at(&folder).expect_err("two are wrong");
    assert_eq!(errors.len(), 2);
    assert!(errors[0].subject.ends_with("bad.toml, line 1"), "{}", errors[0]);
    assert_eq!(lessons_at(&folder.join("9.toml")).expect("good").len(), 1);
    assert!(lessons_at(&folder.join("none.toml")).is_err());
    assert!(texts().len() >= 9);
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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn no_damaged_lesson_makes_it_panic(which in 0usize..99, at in 0usize..9000, junk in "[a-z0-9=\\[\\]\"{}.\\-\n]{0,6}") {
        let texts = texts();
    let (name, text) = &texts[which % texts.len()];
        let mut at = at % (text.len() + 1);
        while !text.is_char_boundary(at) { at -= 1; }
        let mut text = text.clone();
        text.insert_str(at, &junk);
        if let Err(error) = Lesson::read(name, &text) {
            let lines = text.lines().count() + 1;
            let line = error.subject.rsplit_once(", line ").map(|(_, line)| line.parse::<usize>());
            prop_assert!(line.is_none_or(|line| line.is_ok_and(|line| (1..=lines).contains(&line))), "{error}");
            prop_assert!(!error.problem.is_empty());
        }
    }
}
