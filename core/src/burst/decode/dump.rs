//! Files without header, whose shape the user says.

use super::plain::Plain;
use crate::burst::layout::Dump;
use crate::burst::options::{Limits, OpenOptions};
use crate::error::{Error, ErrorKind};
use std::path::Path;

const KIND: &str = "headerless";

/// Frames of a file of `length` bytes. Its bytes must fill a whole number of frames.
pub(super) fn plain(path: &Path, length: u64, options: &OpenOptions) -> Result<Plain, Error> {
    let Some(dump) = options.raw else { return Err(without_shape(path, length, &options.limits)) };
    let there = length.saturating_sub(dump.skip);
    let step = dump.frame_bytes();
    let frames = there / step;
    if frames == 0 || !there.is_multiple_of(step) {
        let problem = format!("{there} bytes are no whole number of frames of {dump}, {step} bytes each");
        return Err(refused(path, problem, length, &options.limits));
    }
    let (width, height) = dump.size;
    let shape = (frames, height as u64, width as u64);
    let places = Plain::places_in(path, KIND, shape, (dump.skip, step, length), &options.limits)?;
    Ok(Plain { big_endian: dump.big_endian, ..Plain::new(KIND, dump.size, places, dump.number) })
}

fn without_shape(path: &Path, length: u64, limits: &Limits) -> Error {
    refused(path, "this file has no header that says its size".to_owned(), length, limits)
}

fn refused(path: &Path, problem: String, length: u64, limits: &Limits) -> Error {
    const FEW: usize = 6;
    let likely = Dump::likely(length, limits.max_frames as u64);
    let shapes: Vec<String> = likely
        .iter()
        .take(FEW)
        .map(|(dump, frames)| match frames {
            1 => format!("{dump} (one frame)"),
            _ => format!("{dump} ({frames} frames)"),
        })
        .collect();
    let fitting = match &shapes[..] {
        [] => format!("no usual size fills its {length} bytes"),
        _ => format!("its {length} bytes would be {}", shapes.join(", ")),
    };
    let remedy = format!("say it with --raw WIDTHxHEIGHT:TYPE, such as --raw 1600x1200:u16le; {fitting}");
    Error::new(ErrorKind::Unsupported, problem, remedy).about(path)
}
