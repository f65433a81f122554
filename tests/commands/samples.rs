//! Samples of output in the documents, compared with what the program writes.
//!
//! A sample is a block whose first line is `$ burstscope …`. Its lines stand in the output in this order; a line of `…`
//! stands for any lines. Times differ from machine to machine and are not compared.
//!
//! A number in a sentence or a table has its source in a comment of its paragraph: `<!-- $ burstscope slopes demo | 25;
//! 0.95 ± 0.1 -->` says that the command writes 25, and a number within 0.1 of 0.95. With `--json` a number may have a
//! place in the document: `25 = /spectrum/features`. With `> FILE` the numbers are those of a file that the command
//! wrote; of a figure (SVG) those of its texts. Measurements that take too long to be repeated by a test stand below
//! the words `measured with version X.Y.Z`, which count up to the next heading.

use super::house::documents::documents;
use crate::support::*;
use std::collections::HashMap;

/// Commands of a document's samples, each with the lines that it is said to write.
fn samples(text: &str) -> Vec<(&str, Vec<&str>)> {
    let blocks = text.split("```").skip(1).step_by(2);
    blocks
        .filter_map(|block| {
            let mut lines = block.lines().skip(1);
            let command = lines.next()?.strip_prefix("$ burstscope ")?;
            Some((command, lines.filter(|line| !matches!(line.trim(), "" | "…")).collect()))
        })
        .collect()
}

fn words(line: &str) -> Vec<&str> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let is_time = |i: usize| {
        words[i].starts_with(|c: char| c.is_ascii_digit()) && matches!(words.get(i + 1), Some(&("s" | "ms" | "min")))
    };
    (0..words.len()).map(|i| if is_time(i) { "TIME" } else { words[i] }).collect()
}

#[test]
fn the_documents_show_what_the_program_writes() {
    let home = folder();
    let mut compared = 0;
    for (document, text) in documents() {
        for (command, lines) in samples(&text) {
            let output = home.run_well(&command.split_whitespace().collect::<Vec<_>>());
            let mut rest = output.lines();
            for line in lines {
                let name = Path::new(&document).file_name().expect("a file").display();
                assert!(
                    rest.any(|written| words(written) == words(line)),
                    "{name}: `burstscope {command}` does not write\n{line}\nin this order; it writes\n{output}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared > 5, "{compared} lines were compared");
}

/// Documents in which every measured number has its source or its version.
const SOURCED: [&str; 4] = ["README.md", "docs/GUIDE.md", "docs/PAPER.md", "docs/FIRST_MINUTES.md"];
/// Units and things whose numbers are measured, not set.
const MEASURED: &str = "% features matches inliers keypoints discs cameras images times s ms minutes seconds MB GB";
const VERSION_MARK: &str = "easured with version ";

/// A number of a document or an output: digits, which spaces may group.
fn number(word: &str) -> Option<f64> {
    let word = word.trim_matches(|c: char| "*(),.;:–".contains(c)).replace('−', "-");
    word.replace(' ', "").trim_start_matches('+').parse().ok()
}

fn numbers(output: &str) -> impl Iterator<Item = f64> + '_ {
    let words: Vec<&str> = output.split_whitespace().collect();
    let joined: Vec<String> = words.windows(2).filter(|pair| pair[1].len() == 3).map(|pair| pair.concat()).collect();
    words.into_iter().filter_map(number).chain(joined.into_iter().filter_map(|word| number(&word)))
}

#[derive(Debug, PartialEq)]
struct Expected<'a> {
    text: &'a str,
    tolerance: f64,
    pointer: Option<&'a str>,
}

fn source(comment: &str) -> Option<(&str, Vec<Expected<'_>>)> {
    let (command, numbers) = comment.trim().strip_prefix("$ burstscope ")?.split_once('|')?;
    let expected = numbers.split(';').map(|entry| {
        let (entry, pointer) = entry.split_once('=').map_or((entry, None), |(entry, at)| (entry, Some(at.trim())));
        let (text, tolerance) = entry.split_once('±').map_or((entry, "0"), |(text, tolerance)| (text, tolerance));
        Expected { text: text.trim(), tolerance: tolerance.trim().parse().expect("a tolerance"), pointer }
    });
    Some((command.trim(), expected.collect()))
}

fn apart(text: &str) -> (String, Vec<&str>) {
    let (mut shown, mut comments, mut rest) = (String::new(), Vec::new(), text);
    while let Some((before, after)) = rest.split_once("<!--") {
        let (comment, after) = after.split_once("-->").expect("an end of the comment");
        shown += before;
        comments.push(comment);
        rest = after;
    }
    (shown + rest, comments)
}

/// Whether a paragraph or table states measured numbers.
fn is_measured(block: &str) -> bool {
    let cells = |line: &str| {
        line.split('|').filter(|cell| cell.split_ascii_whitespace().next().is_some_and(|w| number(w).is_some())).count()
    };
    let words: Vec<&str> = block.split_ascii_whitespace().collect();
    let has_unit = |pair: &[&str]| {
        number(pair[0]).is_some()
            && MEASURED.split(' ').any(|unit| unit == pair[1].trim_end_matches([',', '.', ';', ':', ')']))
    };
    if block.trim_start().starts_with('|') {
        block.lines().any(|line| cells(line) >= 2)
    } else {
        words.windows(2).any(has_unit)
    }
}

/// Paragraphs, tables and samples of output of a document, each with whether it stands below a version mark.
fn blocks(text: &str) -> Vec<(&str, bool)> {
    let (mut is_marked, mut in_code) = (false, false);
    let mut found = Vec::new();
    for block in text.split("\n\n") {
        let block = block.trim_matches('\n');
        let begins_in_code = in_code;
        in_code ^= block.matches("```").count() % 2 == 1;
        let is_code = begins_in_code || block.contains("```");
        is_marked &= is_code || !block.starts_with('#');
        if let Some((_, version)) = block.split_once(VERSION_MARK) {
            assert!(version.starts_with(|c: char| c.is_ascii_digit()), "{block}");
            is_marked = true;
        }
        let is_output = block.starts_with("```text") && !block.contains("\n$ burstscope ");
        if is_output || (!is_code && is_measured(&apart(block).0)) {
            found.push((block, is_marked));
        }
    }
    found
}

/// Output of a command, or of the file that it writes (`COMMAND > FILE`).
fn output_of(home: &Path, command: &str) -> String {
    let (command, file) = command.split_once(" > ").map_or((command, None), |(command, file)| (command, Some(file)));
    let output = home.run_well(&command.split_whitespace().collect::<Vec<_>>());
    let Some(file) = file else { return output };
    let text = fs::read_to_string(home.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    let is_figure = file.ends_with(".svg");
    if is_figure {
        text.split('<').filter_map(|part| part.split_once('>')).map(|(_, text)| format!("{text} ")).collect()
    } else {
        text
    }
}

fn assert_written(name: &str, command: &str, expected: &Expected<'_>, output: &str) {
    let Expected { text, tolerance, pointer } = expected;
    let value = number(text).unwrap_or_else(|| panic!("{name}: {text} is no number"));
    let is_it = |written: f64| (written - value).abs() <= tolerance + 1e-9;
    let is_written = match pointer {
        Some(pointer) => {
            let document: Value = serde_json::from_str(output).expect("JSON");
            document.pointer(pointer).and_then(Value::as_f64).is_some_and(is_it)
        }
        None => numbers(output).any(is_it),
    };
    assert!(is_written, "{name} says {text} ± {tolerance}, `burstscope {command}` does not; it writes\n{output}");
}

#[test]
fn every_measured_number_has_its_source_or_its_version() {
    let home = folder();
    let mut outputs: HashMap<String, String> = HashMap::new();
    let (mut sourced, mut versioned) = (0, 0);
    for name in SOURCED {
        let (_, text) = documents().into_iter().find(|(path, _)| path.ends_with(name)).expect("the document");
        for (block, is_marked) in blocks(&text) {
            let (_, comments) = apart(block);
            let has_source = comments.iter().any(|comment| source(comment).is_some());
            assert!(is_marked || has_source, "{name}: these numbers have no source and no version:\n{block}");
            versioned += usize::from(is_marked);
        }
        for block in text.split("\n\n") {
            let (shown, comments) = apart(block);
            for (command, numbers) in comments.into_iter().filter_map(source) {
                let run = || output_of(&home, command);
                let output = outputs.entry(command.to_owned()).or_insert_with(run);
                for expected in numbers {
                    assert!(shown.contains(expected.text), "{name}: {} does not stand in\n{shown}", expected.text);
                    assert_written(name, command, &expected, output);
                    sourced += 1;
                }
            }
        }
    }
    assert!(sourced > 3 && versioned > 10, "{sourced} numbers have a source, {versioned} paragraphs a version");
}

#[test]
fn numbers_without_a_source_are_seen_and_samples_begin_with_a_command() {
    let text = "# A\n\nIt finds 254 features.\n\n## B\n\nmeasured with version 0.1.0.\n\n| a | b |\n| 1 | 2 |\n\n### C\n\n5 % more.\n\n## D\n\n3 times.\n\n```text\nout\n```\n\nTen frames.";
    let found: Vec<bool> = blocks(text).into_iter().map(|(_, is_marked)| is_marked).collect();
    assert_eq!(found, [false, true, false, false, false]);
    let (shown, comments) = apart("A 1 077.<!-- $ burstscope slopes demo --json | 1 077; 0.95 ± 0.1 = /a/b -->");
    assert_eq!(shown, "A 1 077.");
    let (command, numbers) = source(comments[0]).expect("a source");
    assert_eq!((command, number(numbers[0].text)), ("slopes demo --json", Some(1077.0)));
    assert_eq!(numbers[1], Expected { text: "0.95", tolerance: 0.1, pointer: Some("/a/b") });
    assert_written("x", command, &numbers[1], r#"{"a": {"b": 0.9}}"#);
    assert_written("x", command, &numbers[0], "demo: 1 077 features");
    assert!(std::panic::catch_unwind(|| assert_written("x", command, &numbers[0], "demo: 1 076 features")).is_err());
    let text = "```sh\nburstscope demo\n```\nand\n```text\n$ burstscope slopes demo\na\n  …\nb 0.06 s\n```\n";
    assert_eq!(samples(text), [("slopes demo", vec!["a", "b 0.06 s"])]);
    assert_eq!(words("  b 0.06 s"), words("b 12 s"));
    assert_ne!(words("b 0.06 px"), words("b 12 px"));
}
