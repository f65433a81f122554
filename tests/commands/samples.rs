//! Samples of output in the documents, compared with what the program writes.
//!
//! A sample is a block whose first line is `$ burstscope …`. Its lines stand in the output in this order; a line of `…`
//! stands for any lines. Times differ from machine to machine and are not compared.

use super::house::documents::documents;
use super::support::run_well;
use std::path::Path;

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

/// Words of a line, with each time in place of its number.
fn words(line: &str) -> Vec<&str> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let is_time = |i: usize| {
        words[i].starts_with(|c: char| c.is_ascii_digit()) && matches!(words.get(i + 1), Some(&("s" | "ms" | "min")))
    };
    (0..words.len()).map(|i| if is_time(i) { "TIME" } else { words[i] }).collect()
}

#[test]
fn the_documents_show_what_the_program_writes() {
    let home = tempfile::tempdir().expect("a folder");
    let mut compared = 0;
    for (document, text) in documents() {
        for (command, lines) in samples(&text) {
            let output = run_well(home.path(), &command.split_whitespace().collect::<Vec<_>>());
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

#[test]
fn samples_are_blocks_that_begin_with_a_command_and_times_are_left_out() {
    let text = "```sh\nburstscope demo\n```\nand\n```text\n$ burstscope slopes demo\na\n  …\nb 0.06 s\n```\n";
    assert_eq!(samples(text), [("slopes demo", vec!["a", "b 0.06 s"])]);
    assert_eq!(words("  b 0.06 s"), words("b 12 s"));
    assert_ne!(words("b 0.06 px"), words("b 12 px"));
}
