//! Planes as TIFF files of one page of 32-bit floats: the exact values, for ImageJ, napari or numpy. Fields of motion
//! also as colour PFM (portable float map), which programs for optical flow and stereo read.

use super::atomic::write_whole;
use crate::error::{Error, Result};
use crate::files::mark::{Checksum, Mark, OutputKind, SOFTWARE};
use crate::{detector::MotionField, plane::Plane};
use std::io::{Seek, Write};
use std::{io, path::Path};
use tiff::encoder::colortype::{ColorType, Gray32Float, RGB32Float};
use tiff::encoder::{TiffEncoder, TiffKind};
use tiff::{TiffResult, tags::Tag};

/// Maximum size of a plain TIFF's values, because its offsets end at 4 GiB; larger planes become BigTIFF.
const MAX_PLAIN_BYTES: usize = 0xf000_0000;

/// Writes the plane's values unchanged.
pub fn write_tiff(path: &Path, plane: &Plane) -> Result<()> {
    write_samples::<Gray32Float>(path, plane.size(), plane.data())
}

/// Writes a field of motion on the pixels of an image of `size` (columns, rows), three samples a pixel: motion to the
/// right and down, and its standard deviation along the least certain direction, pixels per frame.
pub fn write_field_tiff(path: &Path, field: &MotionField, size: (usize, usize)) -> Result<()> {
    write_samples::<RGB32Float>(path, size, &field_samples(field, size))
}

pub(super) const FIELD_SAMPLES: usize = 3;

/// Motion to the right and down, and its uncertainty, for each pixel of an image of `size`, row by row.
pub(super) fn field_samples(field: &MotionField, size: (usize, usize)) -> Vec<f32> {
    let at = |place: usize| -> [f32; FIELD_SAMPLES] {
        // Sampled at pixels, not cells: readers expect a picture of the image's size.
        let motion = field.at((place % size.0) as f32, (place / size.0) as f32);
        [motion.slope.u, motion.slope.v, motion.ellipse().0[0]]
    };
    (0..size.0 * size.1).flat_map(at).collect()
}

fn write_samples<C: ColorType<Inner = f32>>(
    path: &Path,
    (width, height): (usize, usize),
    samples: &[f32],
) -> Result<()> {
    let unfit = || Error::unfit(path, (width, height), "TIFF");
    // TIFF counts sides in 32 bits, and has no empty pages.
    let columns = u32::try_from(width).ok().filter(|w| *w > 0).ok_or_else(unfit)?;
    let rows = u32::try_from(height).ok().filter(|h| *h > 0).ok_or_else(unfit)?;
    write_whole(path, |out| {
        let size = (columns, rows);
        let written = if size_of_val(samples) > MAX_PLAIN_BYTES {
            TiffEncoder::new_big(out).and_then(|encoder| write_page::<C, _>(encoder, size, samples))
        } else {
            TiffEncoder::new(out).and_then(|encoder| write_page::<C, _>(encoder, size, samples))
        };
        // The system's own errors stay recognisable: a full disk is reported as such.
        written.map_err(|e| match e {
            tiff::TiffError::IoError(e) => e,
            other => io::Error::other(other),
        })
    })
}

/// Writes the page, the program's name and the mark, which claims the samples as they are in the file.
fn write_page<C: ColorType<Inner = f32>, K: TiffKind>(
    mut encoder: TiffEncoder<impl Write + Seek, K>,
    (columns, rows): (u32, u32),
    samples: &[f32],
) -> TiffResult<()> {
    let mut page = encoder.new_image::<C>(columns, rows)?;
    let mark = Mark::new(OutputKind::Picture, Checksum::of(bytemuck::cast_slice(samples)));
    page.encoder().write_tag(Tag::Software, format!("{SOFTWARE} {}", mark.text()).as_str())?;
    page.write_data(samples)
}

/// As [`write_field_tiff`](super::write_field_tiff), little-endian, the last row first. The format has no place for a
/// mark, so the file is replaced only with [`Overwrite::Force`](super::Overwrite::Force).
pub fn write_field_pfm(path: &Path, field: &MotionField, size: (usize, usize)) -> Result<()> {
    write_whole(path, |out| {
        write!(out, "PF\n{} {}\n-1.0\n", size.0, size.1)?;
        let samples = field_samples(field, size);
        let rows = samples.chunks(FIELD_SAMPLES * size.0.max(1)).rev();
        rows.flatten().try_for_each(|value| out.write_all(&value.to_le_bytes()))
    })
}
