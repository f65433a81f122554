//! Ways in which a command fails, their exit codes, and what is written to the terminal: results on the standard
//! output, errors on the standard error. In what names of files and errors say, control characters are written as
//! escapes (`\u{1b}`) and take no effect. A standard error that is full or closed is ignored.

#[cfg(feature = "app")]
use crate::app::RenderError;
use crate::burst::OpenError;
use crate::dataset::DatasetError;
use crate::detector::{DetectError, ParamError};
use crate::evaluate::EvaluateError;
use crate::evaluate::poses::PoseError;
use crate::figures::FiguresError;
use crate::matching::MatchError;
use crate::monitor::Cancelled;
use crate::requests::SourceError;
use crate::synth::{SynthError, WriteBurstError};
use std::borrow::Cow;
use std::io::{ErrorKind, Result, Write};

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

impl Failure {
    /// Creates the failure of wrong use, with a message that says what would be right.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::Usage(anyhow::Error::msg(message.into()))
    }

    /// Creates the failure of a standard output that cannot be written.
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

impl From<OpenError> for Failure {
    fn from(error: OpenError) -> Self {
        if error.is_cancelled() { Self::Interrupted } else { Self::Failed(error.into()) }
    }
}

impl From<SourceError> for Failure {
    fn from(error: SourceError) -> Self {
        match error {
            SourceError::Open(error) => error.into(),
            SourceError::Synth(error) => error.into(),
            SourceError::Plant(error) => error.into(),
            error @ SourceError::Case(_) => Self::Failed(error.into()),
        }
    }
}

impl From<DetectError> for Failure {
    fn from(error: DetectError) -> Self {
        match error {
            DetectError::Cancelled(_) => Self::Interrupted,
            DetectError::Param(error) => error.into(),
        }
    }
}

impl From<MatchError> for Failure {
    fn from(error: MatchError) -> Self {
        match error {
            MatchError::Cancelled(_) => Self::Interrupted,
            MatchError::Param(error) => error.into(),
        }
    }
}

impl From<ParamError> for Failure {
    fn from(error: ParamError) -> Self {
        Self::usage(format!("--{error}"))
    }
}

impl From<crate::export::ExportError> for Failure {
    fn from(error: crate::export::ExportError) -> Self {
        match error {
            crate::export::ExportError::Cancelled(_) => Self::Interrupted,
            other => Self::Failed(other.into()),
        }
    }
}

impl From<crate::files::lock::LockError> for Failure {
    fn from(error: crate::files::lock::LockError) -> Self {
        Self::Failed(error.into())
    }
}

impl From<SynthError> for Failure {
    fn from(error: SynthError) -> Self {
        match error {
            SynthError::Cancelled(_) => Self::Interrupted,
            SynthError::Param { .. } => Self::usage(format!("--{error}")),
        }
    }
}

impl From<EvaluateError> for Failure {
    fn from(error: EvaluateError) -> Self {
        match error {
            EvaluateError::Cancelled(_) => Self::Interrupted,
            EvaluateError::Synth(error) => error.into(),
            EvaluateError::Detector(error) => error.into(),
            EvaluateError::Param { .. } => Self::usage(format!("--{error}")),
        }
    }
}

impl From<DatasetError> for Failure {
    fn from(error: DatasetError) -> Self {
        match error {
            DatasetError::Cancelled(_) => Self::Interrupted,
            DatasetError::Param(error) => error.into(),
            other => Self::Failed(other.into()),
        }
    }
}

#[cfg(feature = "app")]
impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Cancelled(_) => Self::Interrupted,
            RenderError::Param(error) => error.into(),
            other => Self::Failed(anyhow::Error::new(other).context("the window cannot be drawn")),
        }
    }
}

impl From<PoseError> for Failure {
    fn from(error: PoseError) -> Self {
        match error {
            PoseError::Param { .. } => Self::usage(format!("--{error}")),
            other => Self::Failed(other.into()),
        }
    }
}

impl From<FiguresError> for Failure {
    fn from(error: FiguresError) -> Self {
        match error {
            FiguresError::Cancelled(_) => Self::Interrupted,
            FiguresError::Evaluate(error) => error.into(),
            FiguresError::Dataset(error) => error.into(),
            FiguresError::WriteBurst(error) => error.into(),
            other => Self::Failed(other.into()),
        }
    }
}

impl From<WriteBurstError> for Failure {
    fn from(error: WriteBurstError) -> Self {
        match error {
            WriteBurstError::Cancelled(_) => Self::Interrupted,
            other => Self::Failed(other.into()),
        }
    }
}

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
pub(super) fn print(text: &str) -> Result<()> {
    print_bytes(&printable(text))
}

/// Prints a JSON document. Control characters occur only inside its strings, where they are written as `\u` escapes.
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
