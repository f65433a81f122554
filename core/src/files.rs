//! Reading small text files that people write or hand over, and file names as text.
//!
//! A file that is too large, a device or a pipe is refused before it fills the memory or is waited for. A file name
//! need not be text; where text is needed its other bytes are written as `\xNN`, so that different names stay
//! different. Below: the mark of what the program wrote, locks of folders, and folders of unfinished work.

pub mod lock;
pub mod mark;
pub mod unfinished;

use crate::error::{Error, ErrorKind, one_line};
use crate::monitor::Cancelled;
use serde::Serializer;
use std::fs::{File, OpenOptions};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Largest parameter or camera file, bytes: far more than a person writes.
pub const MAX_SETTINGS_BYTES: u64 = 1 << 20;
/// Largest session file, bytes. It holds the views of all panes and no pixels.
pub const MAX_SESSION_BYTES: u64 = 16 << 20;
/// Largest text or JSON file of numbers, bytes: features, poses, the truth of a synthetic burst.
pub const MAX_TABLE_BYTES: u64 = 1 << 30;

/// Opens the regular file `path` for reading. All files that others made are opened here, or by [`open_as`].
///
/// # Errors
/// The system's error, and [`io::ErrorKind::InvalidInput`] for a path that is no regular file.
pub fn open(path: &Path) -> io::Result<File> {
    open_as(path, OpenOptions::new().read(true))
}

/// Opens the regular file `path` as `options` say; errors as of [`open`].
pub fn open_as(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    // Opening a pipe waits for its other end, and so does reading what the system makes up, such as /proc/kmsg.
    #[cfg(unix)]
    let options =
        std::os::unix::fs::OpenOptionsExt::custom_flags(options, rustix::fs::OFlags::NONBLOCK.bits().cast_signed());
    // Also opening a device may have effects.
    let is_regular = |found: std::fs::Metadata| found.is_file();
    let is_other = std::fs::metadata(path).is_ok_and(|found| !is_regular(found));
    let file = if is_other { None } else { Some(options.open(path)?) };
    match file {
        Some(file) if is_regular(file.metadata()?) => Ok(file),
        _ => Err(io::Error::new(io::ErrorKind::InvalidInput, "this is not a regular file; name one")),
    }
}

/// Opens the SQLite database `path`, which nobody writes meanwhile, for reading alone.
#[cfg(any(feature = "bags", feature = "colmap"))]
pub(crate) fn open_database(path: &Path) -> rusqlite::Result<rusqlite::Connection> {
    use rusqlite::OpenFlags;
    let kept = |byte: u8| byte.is_ascii_alphanumeric() || b"/._-:".contains(&byte);
    let escaped = |byte: &u8| if kept(*byte) { char::from(*byte).to_string() } else { format!("%{byte:02x}") };
    let path: String = path.as_os_str().as_encoded_bytes().iter().map(escaped).collect();
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    // `immutable`: SQLite takes no locks and writes no files beside one that may be read-only.
    let connection = rusqlite::Connection::open_with_flags(format!("file:{path}?immutable=1"), flags)?;
    // The schema is a stranger's: its functions are not trusted.
    connection.execute_batch("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON;")?;
    Ok(connection)
}

/// The next `count` bytes of `from`, or as many as there are.
pub(crate) fn next_bytes(from: impl Read, count: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(count).read_to_end(&mut bytes).map(|_| bytes)
}

/// Reads the regular file `path`, at most `max_bytes` bytes.
///
/// # Errors
/// As [`open`] (a folder, a device, a pipe), and [`io::ErrorKind::FileTooLarge`] for a file beyond the limit.
pub fn read_bytes(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    // A file may grow while it is read, so the limit applies to the bytes read.
    let bytes = next_bytes(open(path)?, max_bytes.saturating_add(1))?;
    if bytes.len() as u64 > max_bytes {
        let problem = format!("this file is larger than {} MiB, too large for what it shall hold", max_bytes >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, problem));
    }
    Ok(bytes)
}

/// Reads the regular file `path` as text, at most `max_bytes` bytes: UTF-8, or UTF-16 that begins with a mark.
///
/// # Errors
/// As [`read_bytes`], and [`io::ErrorKind::InvalidData`] for bytes that are neither.
pub fn read_text(path: &Path, max_bytes: u64) -> io::Result<String> {
    let bytes = read_bytes(path, max_bytes)?;
    let text = of_utf16(&bytes).map_or_else(|| String::from_utf8(bytes), Ok);
    text.map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "this is not text; save it as UTF-8"))
}

/// Text of UTF-16 with a mark of its byte order, as shells and spreadsheets on Windows write it; `None` for others.
pub fn of_utf16(bytes: &[u8]) -> Option<String> {
    let (mark, units) = bytes.split_first_chunk::<2>()?;
    let unit = match mark {
        [0xff, 0xfe] => u16::from_le_bytes,
        [0xfe, 0xff] => u16::from_be_bytes,
        _ => return None,
    };
    let units: Vec<u16> = units.as_chunks::<2>().0.iter().map(|pair| unit(*pair)).collect();
    String::from_utf16(&units).ok()
}

/// Largest whole number that files of parameters, sessions and cases keep: TOML has no larger one.
pub const MAX_INTEGER: u64 = i64::MAX.unsigned_abs();

/// Reads a whole number of 0 or more, at most [`MAX_INTEGER`]; the error is the fault in `text`.
pub fn whole_number<T: TryFrom<u64>>(text: &str) -> Result<T, String> {
    let digits = text.trim();
    let number =
        digits.parse().ok().filter(|number| *number <= MAX_INTEGER).and_then(|number| T::try_from(number).ok());
    number.ok_or_else(|| match digits.bytes().all(|byte| byte.is_ascii_digit()) && !digits.is_empty() {
        true => {
            let most = MAX_INTEGER.min(u64::MAX >> (64 - 8 * size_of::<T>()));
            format!("{text} is more than {most}, the largest number there is here")
        }
        false => format!("'{text}' is not a whole number of 0 or more"),
    })
}

const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Beginning of the line that names the program version that wrote a file.
pub const WRITTEN_BY: &str = "# Written by Burstscope ";

/// First line of a parameter or session file: the version of the program that wrote it.
pub fn written_by() -> String {
    format!("{WRITTEN_BY}{VERSION}\n")
}

/// Text of a TOML file without its table `name`, and the text of that table; lines keep their numbers, for errors.
pub fn without_table(text: &str, name: &str) -> [String; 2] {
    let mut parts = [String::new(), String::new()];
    let mut is_in_table = false;
    for line in text.lines() {
        if let Some(head) = line.trim_start().strip_prefix('[') {
            let rest = head.trim_start_matches('[').trim_start().strip_prefix(name).map(str::trim_start);
            is_in_table = rest.is_some_and(|rest| rest.starts_with(['.', ']']));
        }
        parts[usize::from(is_in_table)] += line;
        parts.iter_mut().for_each(|part| part.push('\n'));
    }
    parts
}

/// Returns the `problem` with a file of this text; adds that a newer program wrote it, which may know more, if so.
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

/// The text as one word for a shell, on one line.
pub fn shell_word(text: &str) -> String {
    if !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || "/._-:+,=@%".contains(c)) {
        return text.to_owned();
    }
    let quoted = |text: &str| format!("'{}'", text.replace('\'', r"'\''"));
    if !text.contains('\n') {
        return quoted(text);
    }
    let format = text.replace('\\', r"\\").replace('%', "%%").replace('\n', r"\n");
    format!("\"$(printf {})\"", quoted(&format))
}

/// The path as one word for a shell, which no program takes for an option.
pub fn shell_path(path: &Path) -> String {
    let path = path.display().to_string();
    shell_word(&if path.starts_with('-') { format!("./{path}") } else { path })
}

/// The path as text, on one line, with bytes that are not UTF-8 as `\xNN`.
pub fn path_text(path: &Path) -> String {
    let mut text = String::new();
    for chunk in path.as_os_str().as_encoded_bytes().utf8_chunks() {
        text += &one_line(chunk.valid());
        chunk.invalid().iter().for_each(|byte| text += &format!("\\x{byte:02X}"));
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
