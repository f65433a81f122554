//! Checks of the sizes that a file declares, before any decoder reads it.
//!
//! A decoder takes memory and time as the file tells it to. So the sizes in the file's own structures are compared with
//! the file's length: a file that announces more than it could hold is damaged, and is refused with a reason. The check
//! reads headers only, and bounds its own memory.

mod directories;
mod pictures;
mod refusal;

pub(super) use directories::{Directories, MAX_TEXT_BYTES};
pub(super) use pictures::check_picture;
pub(super) use refusal::Refusal;

use std::io::{Read, Seek, SeekFrom};

/// Reads bytes of `file` from `at` on, as many as fill `buffer`.
///
/// # Errors
/// `Refusal::Io` where the file ends before or cannot be read.
fn read_at(file: &mut (impl Read + Seek), at: u64, buffer: &mut [u8]) -> Result<(), Refusal> {
    file.seek(SeekFrom::Start(at))?;
    Ok(file.read_exact(buffer)?)
}
