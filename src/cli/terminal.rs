//! Output to the terminal: results on the standard output, errors on the standard error.
//!
//! File names may contain any characters, including those that change a terminal's colours, title or keys. Control
//! characters are written as escapes (`\u{1b}`) and take no effect. A standard error that is full or closed is ignored.

use std::borrow::Cow;
use std::io::{ErrorKind, Result, Write};

/// Whether a terminal may read `c` as a command: true for control characters except line feed and tab.
fn is_command(c: char) -> bool {
    c.is_control() && c != '\n' && c != '\t'
}

/// Replaces each control character except line feeds and tabs by an escape.
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

/// Prints text for people on the standard output. A reader that closed the pipe, such as `head`, is no failure.
///
/// # Errors
/// When writing to the standard output fails for any other reason.
pub(super) fn print(text: &str) -> Result<()> {
    print_bytes(&printable(text))
}

/// Prints a JSON document. Control characters occur only inside its strings, where they are written as `\u` escapes.
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

/// Prints a line on the standard error; a failed write is ignored.
pub(super) fn complain(text: &str) {
    // A standard error that cannot be written is no reason to fail.
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
