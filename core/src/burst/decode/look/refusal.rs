//! Why a file is refused before a decoder sees it.

use crate::burst::error::OpenError;
use std::path::Path;

/// Why a file is refused before a decoder sees it.
#[derive(Debug)]
pub(in crate::burst::decode) enum Refusal {
    /// It announces what cannot be: the end of a sentence about the file.
    Corrupt(String),
    /// It announces more than anybody needs.
    TooLarge {
        /// The announced size, in words.
        found: String,
        /// How much is allowed.
        limit: String,
    },
    /// It could not be read.
    Io(std::io::Error),
}

impl From<std::io::Error> for Refusal {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

impl Refusal {
    /// A file that announces what cannot be.
    pub(in crate::burst::decode) fn corrupt(reason: impl Into<String>) -> Self {
        Self::Corrupt(reason.into())
    }

    /// The error about the file `path` of the format `kind`.
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
