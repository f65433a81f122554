//! Refusals of files before a decoder reads them.

use crate::burst::error::OpenError;
use std::path::Path;

/// Reason why a file is refused before a decoder reads it.
#[derive(Debug)]
pub(in crate::burst::decode) enum Refusal {
    /// The file announces the impossible: the end of a sentence about the file.
    Corrupt(String),
    /// The file announces more than the limit.
    TooLarge {
        /// The announced size, in words.
        found: String,
        /// Largest size allowed, in words.
        limit: String,
    },
    /// The file ends early or could not be read.
    Io(std::io::Error),
}

impl From<std::io::Error> for Refusal {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

impl Refusal {
    /// Refusal of a file that announces the impossible.
    pub(in crate::burst::decode) fn corrupt(reason: impl Into<String>) -> Self {
        Self::Corrupt(reason.into())
    }

    /// Converts to an error about the file `path` of the format `kind`.
    pub(in crate::burst::decode) fn into_error(self, path: &Path, kind: &'static str) -> OpenError {
        let path = path.to_path_buf();
        match self {
            Self::Corrupt(reason) => OpenError::Corrupt { path, kind, reason },
            Self::TooLarge { found, limit } => {
                OpenError::BeyondLimit { path, found, limit, remedy: "copy it again, or save it anew".into() }
            }
            Self::Io(error) => OpenError::from_read(&path, kind, &error),
        }
    }
}
