//! A lesson on paper: its tasks with room for what was seen, its questions, and on a page of their own the answers.

use super::{Lesson, Step};
use std::fmt::Write as _;

const ROOM: &str = "\n&nbsp;\n\n&nbsp;\n";

/// The sheet of `lesson` in Markdown: steps and tasks, questions, then answers with the lines of what was learnt.
pub fn sheet(lesson: &Lesson) -> String {
    let mut text = format!("# {}\n\n{}\n\nName:\n", lesson.title, plain(&lesson.about));
    for (number, Step { title, caption, task, .. }) in (1..).zip(&lesson.steps) {
        write!(text, "\n## {number}. {title}\n\n{}\n", plain(caption)).expect("into a text");
        if let Some(task) = task {
            write!(text, "\n**Try it.** {} What did you see?\n{ROOM}", plain(&task.text)).expect("into a text");
        }
    }
    // Answers go to a page of their own, after all questions.
    let mut answers = String::new();
    if !lesson.questions.is_empty() {
        text += "\n## Questions\n";
        answers += "\n## Answers\n\n";
    }
    for (number, question) in (1..).zip(&lesson.questions) {
        write!(text, "\n{number}. {}\n{ROOM}", plain(&question.ask)).expect("into a text");
        writeln!(answers, "{number}. {}", plain(&question.answer)).expect("into a text");
    }
    if !lesson.learnt.is_empty() {
        answers += "\n## What was learnt\n\n";
    }
    for line in &lesson.learnt {
        writeln!(answers, "- {}", plain(line)).expect("into a text");
    }
    text + "\n---\n" + &answers
}

/// CommonMark without its links to the glossary, which no paper follows.
fn plain(text: &str) -> String {
    let mut pieces = text.trim().split("](word:");
    let mut plain = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        // The bracket that begins the link's text is the last one so far.
        if let Some(at) = plain.rfind('[') {
            plain.remove(at);
        }
        plain += piece.split_once(')').map_or(piece, |(_, rest)| rest);
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teach::built_in;

    #[test]
    fn links_are_left_out_and_other_brackets_stay() {
        let text = plain("A [slope](word:slope) in [0, 1], a [feature](word:feature).");
        assert_eq!(text, "A slope in [0, 1], a feature.");
        assert_eq!(plain(" no link "), "no link");
    }

    #[test]
    fn a_sheet_has_each_task_each_question_and_behind_a_line_the_answers() {
        for lesson in built_in() {
            let text = sheet(lesson);
            assert!(text.starts_with(&format!("# {}\n", lesson.title)) && !text.contains("word:"), "{text}");
            let (asked, answers) = text.split_once("\n---\n").expect("a line");
            assert_eq!(asked.matches("**Try it.**").count(), lesson.steps.len());
            for question in &lesson.questions {
                assert!(asked.contains(&plain(&question.ask)) && !asked.contains(&plain(&question.answer)));
                assert!(answers.contains(&plain(&question.answer)), "{}", question.ask);
            }
            assert!(lesson.learnt.iter().all(|line| answers.contains(&plain(line))));
        }
    }
}
