//! Ways in which a command fails, and their exit codes.

use super::terminal::complain;
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
use std::process::ExitCode;

/// Exit code of an interrupted command.
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

    /// Exit code of the failure.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Failed(_) | Self::Reported => 1,
            Self::Usage(_) => 2,
            Self::Interrupted => INTERRUPTED,
        })
    }

    /// Prints the failure on the standard error.
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
        Self::Failed(error.into())
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
