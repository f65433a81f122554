//! A look at what a file declares, before any decoder sees it.
//!
//! A decoder takes memory and time as the file tells it to. So the sizes in the file's own structures are compared with
//! how long the file is: what announces more than the file could hold is damaged, and is refused with words. The look
//! reads headers only, and is bounded itself in what it reads and keeps.

mod directories;
mod pictures;
mod refusal;

pub(super) use directories::{Directories, MAX_TEXT_BYTES};
pub(super) use pictures::check_picture;
pub(super) use refusal::Refusal;

use std::io::{Read, Seek, SeekFrom};

/// The bytes of `file` from `at` on, as many as `buffer` has.
///
/// # Errors
/// [`Refusal::Corrupt`] where the file ends before.
fn read_at(file: &mut (impl Read + Seek), at: u64, buffer: &mut [u8]) -> Result<(), Refusal> {
    file.seek(SeekFrom::Start(at))?;
    Ok(file.read_exact(buffer)?)
}
