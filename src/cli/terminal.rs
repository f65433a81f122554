//! What reaches the terminal: results on the standard output, complaints on the standard error.
//!
//! Names of files may hold anything, also what makes a terminal change its colours, its title or its keys. Such
//! characters are written as what they are (`\u{1b}`), and take no effect. That nobody hears a complaint is no reason
//! to stop: a standard error that is full or closed is passed over.

use std::borrow::Cow;
use std::io::{ErrorKind, Result, Write};

/// Whether a terminal may take `c` for a command: every control character but the ends of lines and tabs.
fn is_command(c: char) -> bool {
    c.is_control() && c != '\n' && c != '\t'
}

/// The text with each control character but ends of lines and tabs written as an escape.
pub(super) fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_command) {
        return Cow::Borrowed(text);
    }
    let mut clean = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_command(c) { clean.extend(c.escape_unicode()) } else { clean.push(c) }
    }
    Cow::Owned(clean)
}

/// Prints text for people on the standard output. A reader that has gone away, such as `head`, is no failure.
///
/// # Errors
/// When the standard output cannot be written for any other reason.
pub(super) fn print(text: &str) -> Result<()> {
    print_bytes(&printable(text))
}

/// Prints a JSON document. What a terminal might take for a command stands in its strings alone, where `\u` escapes it.
///
/// # Errors
/// As [`print`].
pub(super) fn print_json(text: &str) -> Result<()> {
    let mut clean = String::with_capacity(text.len());
    for c in text.chars() {
        if is_command(c) { clean += &format!("\\u{:04x}", u32::from(c)) } else { clean.push(c) }
    }
    print_bytes(&clean)
}

fn print_bytes(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
    }
}

/// Says something on the standard error, if it can be said.
pub(super) fn complain(text: &str) {
    // Whoever closed the standard error does not want to know.
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(text));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_to_a_terminal_are_written_out() {
        assert_eq!(
            printable("night\u{1b}[31m\n\tone\u{9b}2J\u{7f}\r"),
            "night\\u{1b}[31m\n\tone\\u{9b}2J\\u{7f}\\u{d}"
        );
        assert!(matches!(printable("夜 night\n"), Cow::Borrowed(_)));
    }
}
