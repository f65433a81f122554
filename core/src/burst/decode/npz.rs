//! `.npz` archives: one array of frames, as in a `.npy` file, stored or deflated.

use super::npy::ArrayHeader;
use super::plain::Plain;
use crate::burst::options::OpenOptions;
use crate::error::{Error, ErrorKind, Result};
use std::fs::File;
use std::io::{BufReader, Error as IoError};
use std::path::Path;
use zip::ZipArchive;

/// Largest number of members that are looked at.
const MAX_MEMBERS: usize = 256;

/// The array that the options name, or the only one that can be frames.
pub(super) fn plain(path: &Path, file: File, options: &OpenOptions) -> Result<Plain> {
    let fail = |e: zip::result::ZipError| Error::from_read(path, "NPZ", &IoError::from(e));
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(fail)?;
    let mut found = Vec::new();
    for index in 0..archive.len().min(MAX_MEMBERS) {
        let mut member = archive.by_index(index).map_err(fail)?;
        let Some(name) = member.name().strip_suffix(".npy").map(str::to_owned) else { continue };
        let length = member.size();
        found.push((name, index, length, ArrayHeader::read(path, "NPZ", &mut member)?));
    }
    if found.is_empty() {
        let problem = "this archive holds no arrays (.npy)";
        return Err(Error::new(ErrorKind::Unsupported, problem, "unpack it, and open what is in it").about(path));
    }
    let refused = |problem: String| {
        let all: Vec<String> = found.iter().map(|(name, .., header)| format!("{name} {:?}", header.shape)).collect();
        let remedy = format!("say with --array NAME which one holds the frames: {}", all.join(", "));
        Error::new(ErrorKind::Unsupported, problem, remedy).about(path)
    };
    let chosen = match &options.array {
        Some(array) => {
            let named = found.iter().find(|(name, ..)| name == array);
            named.ok_or_else(|| refused(format!("this archive has no array '{array}'")))?
        }
        None => {
            let frames: Vec<_> = found.iter().filter(|(.., header)| header.is_of_frames()).collect();
            match frames[..] {
                [only] => only,
                [] => return Err(refused("no array of this archive can be frames".to_owned())),
                _ => return Err(refused(format!("this archive has {} arrays that can be frames", frames.len()))),
            }
        }
    };
    let (name, index, length, header) = chosen;
    let plain = header.plain(path, "NPZ", *length, options)?;
    let more = (found.len() > 1).then(|| format!("of {} arrays '{name}' is taken", found.len()));
    Ok(Plain { member: Some(*index), taken: plain.taken.iter().cloned().chain(more).collect(), ..plain })
}
