//! Fields of motion as colour PFM (portable float map), which programs for optical flow and stereo read.

use super::atomic::write_whole;
use super::tiff::{FIELD_SAMPLES, field_samples};
use crate::detector::MotionField;
use crate::error::Result;
use std::io::Write;
use std::path::Path;

/// Writes a field of motion on the pixels of an image of `size` (columns, rows), with the samples of
/// [`write_field_tiff`](super::write_field_tiff): little-endian, the last row first. The format has no place for a
/// mark, so the file counts as another program's and is replaced only with
/// [`Overwrite::Force`](super::Overwrite::Force).
pub fn write_field_pfm(path: &Path, field: &MotionField, size: (usize, usize)) -> Result<()> {
    write_whole(path, |out| {
        write!(out, "PF\n{} {}\n-1.0\n", size.0, size.1)?;
        let samples = field_samples(field, size);
        let rows = samples.chunks(FIELD_SAMPLES * size.0.max(1)).rev();
        rows.flatten().try_for_each(|value| out.write_all(&value.to_le_bytes()))
    })
}
