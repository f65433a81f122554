//! Ways in which a command fails, their exit codes, and what is written to the terminal: results on the standard
//! output, errors on the standard error. In what names of files and errors say, control characters are written as
//! escapes (`\u{1b}`) and take no effect. A standard error that is full or closed is ignored.

use crate::error::{Error, ErrorKind};
use crate::monitor::Cancelled;
use std::borrow::Cow;
use std::io::{self, Write};

pub const INTERRUPTED: u8 = 130;

/// Reason why a command did not finish all of its work.
#[derive(Debug)]
pub enum Failure {
    /// The arguments make no sense: exit code 2.
    Usage(anyhow::Error),
    /// Something failed: exit code 1.
    Failed(anyhow::Error),
    /// All failures were reported already: exit code 1.
    Reported,
    /// Interrupted from outside, as by Ctrl-C or a scheduler: exit code 130.
    Interrupted,
}

/// Result of a command, or of a part of its work.
pub type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    pub fn usage(message: impl Into<String>) -> Self {
        Self::Usage(anyhow::Error::msg(message.into()))
    }

    pub(super) fn output(error: std::io::Error) -> Self {
        Self::Failed(anyhow::Error::new(error).context("cannot write to the standard output"))
    }

    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Failed(_) | Self::Reported => 1,
            Self::Usage(_) => 2,
            Self::Interrupted => INTERRUPTED,
        }
    }

    pub fn print(&self) {
        match self {
            Self::Failed(error) => complain(&format!("error: {error:#}")),
            Self::Usage(error) => complain(&format!("error: {error:#}\n\nFor more information, try '--help'.")),
            Self::Reported => {}
            Self::Interrupted => complain("interrupted"),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::Interrupted
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error.kind {
            ErrorKind::Cancelled => Self::Interrupted,
            // The subject of a parameter's error is the name of the option.
            ErrorKind::Parameter if error.subject.is_empty() => Self::usage(error.to_string()),
            ErrorKind::Parameter => Self::usage(format!("--{error}")),
            _ => Self::Failed(error.into()),
        }
    }
}

/// Whether a terminal may read `c` as a command: true for control characters except line feed and tab.
fn is_command(c: char) -> bool {
    c.is_control() && c != '\n' && c != '\t'
}

pub(super) fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_command) {
        return Cow::Borrowed(text);
    }
    let clean = |c: char| if is_command(c) { c.escape_unicode().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(clean).collect())
}

/// Prints text for people on the standard output. A reader that closed the pipe, such as `head`, is no failure.
pub(super) fn print(text: &str) -> io::Result<()> {
    print_bytes(&printable(text))
}

pub(super) fn print_json(text: &str) -> io::Result<()> {
    let mut clean = String::with_capacity(text.len());
    for c in text.chars() {
        if is_command(c) { clean += &format!("\\u{:04x}", u32::from(c)) } else { clean.push(c) }
    }
    print_bytes(&clean)
}

fn print_bytes(text: &str) -> io::Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
    }
}

pub(super) fn complain(text: &str) {
    // A standard error that cannot be written is no reason to fail.
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(text));
}
