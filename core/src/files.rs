//! Reading small text files that people write or hand over, and file names as text.
//!
//! A file that is too large, a device or a pipe is refused before it fills the memory or is waited for. A file name
//! need not be text; where text is needed its other bytes are written as `\xNN`, so that different names stay
//! different. Below: the mark of what the program wrote, locks of folders, and folders of unfinished work.

pub mod lock;
pub mod mark;
pub mod unfinished;

use crate::error::{Error, ErrorKind};
use crate::monitor::Cancelled;
use serde::Serializer;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Largest parameter or camera file, bytes: far more than a person writes.
pub const MAX_SETTINGS_BYTES: u64 = 1 << 20;
/// Largest session file, bytes. It holds the views of all panes and no pixels.
pub const MAX_SESSION_BYTES: u64 = 16 << 20;
/// Largest text or JSON file of numbers, bytes: features, poses, the truth of a synthetic burst.
pub const MAX_TABLE_BYTES: u64 = 1 << 30;

/// Reads the regular file `path`, at most `max_bytes` bytes.
///
/// # Errors
/// The system's error; [`io::ErrorKind::InvalidInput`] for a path that is no regular file (a folder, a device, a pipe),
/// and [`io::ErrorKind::FileTooLarge`] for a file beyond the limit.
pub fn read_bytes(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    // Checked before the file is opened, because opening a pipe waits for its writer.
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "this is not a regular file; name one"));
    }
    let mut bytes = Vec::new();
    // A file may grow while it is read, so the limit applies to the bytes read.
    File::open(path)?.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes {
        let problem = format!("this file is larger than {} MiB, too large for what it shall hold", max_bytes >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, problem));
    }
    Ok(bytes)
}

/// Reads the regular file `path` as UTF-8 text, at most `max_bytes` bytes.
///
/// # Errors
/// As [`read_bytes`], and [`io::ErrorKind::InvalidData`] for bytes that are not UTF-8.
pub fn read_text(path: &Path, max_bytes: u64) -> io::Result<String> {
    String::from_utf8(read_bytes(path, max_bytes)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "this is not text; save it as UTF-8"))
}

const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Beginning of the line that names the program version that wrote a file.
pub const WRITTEN_BY: &str = "# Written by Burstscope ";

/// First line of a parameter or session file: the version of the program that wrote it.
pub fn written_by() -> String {
    format!("{WRITTEN_BY}{VERSION}\n")
}

/// Returns the `problem` with a parameter or session file of this text; adds that a newer program wrote the file if so,
/// because that version may know what is unknown here.
pub fn explained(text: &str, problem: &str) -> String {
    let numbers = |version: &str| -> Option<Vec<u64>> { version.split('.').map(|part| part.parse().ok()).collect() };
    let writer = text.lines().find_map(|line| line.strip_prefix(WRITTEN_BY)).map(str::trim);
    let Some(by) = writer.filter(|by| numbers(by) > numbers(VERSION)) else { return problem.to_owned() };
    format!("this file was written by Burstscope {by}, and this is {VERSION}; open it with the newer one ({problem})")
}

/// Reason why a file could not be written, in words.
pub fn write_problem(error: &io::Error) -> String {
    if is_size_limit(error) {
        format!("it becomes larger than this system or the limit of this process (ulimit -f) allows ({error})")
    } else {
        error.to_string()
    }
}

/// Whether the system's limit on file size caused the error, which an encoder may have wrapped.
fn is_size_limit(error: &(dyn std::error::Error + 'static)) -> bool {
    let Some(io) = error.downcast_ref::<io::Error>() else { return error.source().is_some_and(is_size_limit) };
    io.kind() == io::ErrorKind::FileTooLarge || io.get_ref().is_some_and(|inner| is_size_limit(inner))
}

impl Error {
    /// Error for a failed or cancelled write to `path`.
    pub fn unwritten(path: &Path, error: &io::Error) -> Self {
        if error.get_ref().is_some_and(|inner| inner.is::<Cancelled>()) {
            return Cancelled.into();
        }
        let problem = format!("cannot write this file: {}", write_problem(error));
        Self::new(ErrorKind::Unwritten, problem, "check the folder's permissions and the free space").about(path)
    }
}

/// The path as text, with bytes that are not UTF-8 as `\xNN`.
pub fn path_text(path: &Path) -> String {
    let mut text = String::new();
    for chunk in path.as_os_str().as_encoded_bytes().utf8_chunks() {
        text.push_str(chunk.valid());
        for byte in chunk.invalid() {
            text += &format!("\\x{byte:02X}");
        }
    }
    text
}

/// [`path_text`] for `#[serde(serialize_with)]`.
pub fn serialize_path<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path_text(path))
}

/// [`path_text`] of each path, for `#[serde(serialize_with)]`.
pub fn serialize_paths<S: Serializer>(paths: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path_text(path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_up_to_their_limit() {
        let home = tempfile::tempdir().expect("a folder");
        let path = home.path().join("a.toml");
        std::fs::write(&path, "levels = 4\n").expect("written");
        assert_eq!(read_text(&path, 11).expect("just fits"), "levels = 4\n");
        assert_eq!(read_text(&path, 10).expect_err("too large").kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read_text(home.path(), 10).expect_err("a folder").kind(), io::ErrorKind::InvalidInput);
        std::fs::write(&path, [0xff, b'a']).expect("written");
        assert_eq!(read_text(&path, 10).expect_err("no text").kind(), io::ErrorKind::InvalidData);
        #[cfg(unix)]
        assert_eq!(read_text(Path::new("/dev/zero"), 10).expect_err("a device").kind(), io::ErrorKind::InvalidInput);
    }

    #[test]
    fn a_limit_on_the_size_of_files_is_said_also_by_an_encoder() {
        let limit = || io::Error::from(io::ErrorKind::FileTooLarge);
        for error in [limit(), io::Error::other(limit()), io::Error::other(io::Error::other(limit()))] {
            assert!(write_problem(&error).contains("ulimit -f"), "{error}");
        }
        assert_eq!(write_problem(&io::Error::other("disk full")), "disk full");
    }

    #[test]
    fn a_newer_writer_is_said() {
        let older = format!("{}levels = 4\n", written_by());
        assert_eq!(explained(&older, "unknown field"), "unknown field");
        assert_eq!(explained("levels = 4", "unknown field"), "unknown field");
        let newer = "# Written by Burstscope 99.10.2\nlevels = 4\n";
        let words = explained(newer, "unknown field");
        assert!(words.contains("99.10.2") && words.contains(VERSION) && words.contains("unknown field"), "{words}");
        assert_eq!(explained("# Written by Burstscope soon\n", "x"), "x");
    }

    #[cfg(unix)]
    #[test]
    fn names_that_are_no_text_are_said_and_told_apart() {
        use std::os::unix::ffi::OsStrExt;
        let text = |bytes: &[u8]| path_text(Path::new(std::ffi::OsStr::from_bytes(bytes)));
        assert_eq!(text("nächte/1".as_bytes()), "nächte/1");
        assert_eq!(text(b"night\xff\xfe1"), "night\\xFF\\xFE1");
        assert_ne!(text(b"\xff"), text(b"\xfe"));
    }
}
