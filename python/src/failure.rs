//! Failures of the commands as exceptions of Python: their words, with keywords in place of options.

use burstscope::cli::Failure;
use burstscope::error::{Error, ErrorKind as Kind};
use pyo3::PyErr;
use pyo3::exceptions::{
    PyFileExistsError, PyFileNotFoundError, PyKeyboardInterrupt, PyMemoryError, PyOSError, PyPermissionError,
    PyRuntimeError, PyValueError,
};
use std::io::ErrorKind;

/// The exception for a failure. Wrong use and input that cannot be taken are `ValueError`, files that cannot be read or
/// written `OSError` or the kind of it that says why, refused memory `MemoryError`, and an end that was asked for
/// `KeyboardInterrupt`.
pub(crate) fn raised(failure: &Failure) -> PyErr {
    match failure {
        Failure::Usage(error) => PyValueError::new_err(with_keywords(&format!("{error:#}"))),
        Failure::Failed(error) => of_error(error, with_keywords(&format!("{error:#}"))),
        Failure::Reported => PyRuntimeError::new_err("this failed; the messages are on the standard error"),
        Failure::Interrupted => PyKeyboardInterrupt::new_err(()),
    }
}

fn of_error(error: &anyhow::Error, text: String) -> PyErr {
    for cause in error.chain() {
        if let Some(error) = cause.downcast_ref::<std::io::Error>() {
            return match error.kind() {
                ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
                ErrorKind::PermissionDenied => PyPermissionError::new_err(text),
                ErrorKind::AlreadyExists => PyFileExistsError::new_err(text),
                _ => PyOSError::new_err(text),
            };
        }
        match cause.downcast_ref::<Error>().map(|error| error.kind) {
            None | Some(Kind::Failed | Kind::Content) => {}
            Some(Kind::NotFound) => return PyFileNotFoundError::new_err(text),
            Some(Kind::InTheWay) => return PyFileExistsError::new_err(text),
            Some(Kind::NoMemory) => return PyMemoryError::new_err(text),
            Some(Kind::System | Kind::Unwritten | Kind::Refused | Kind::Locked) => return PyOSError::new_err(text),
            Some(_) => return PyValueError::new_err(text),
        }
    }
    PyRuntimeError::new_err(text)
}

/// The text with options (`--max-features`) written as keywords (`max_features`), also the name in front of a fault.
fn with_keywords(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, option) = rest.split_at(at);
        out += before;
        let name = &option[2..];
        let end = name.find(|c: char| !(c.is_ascii_lowercase() || c == '-')).unwrap_or(name.len());
        let is_option = name.starts_with(|c: char| c.is_ascii_lowercase());
        if is_option {
            out += &name[..end].replace('-', "_");
        } else {
            out += &option[..2 + end];
        }
        rest = &name[end..];
    }
    out + rest
}
