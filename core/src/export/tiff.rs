//! Planes as TIFF files of one page of 32-bit floats: the exact values, for ImageJ, napari or numpy.

use super::atomic::write_whole;
use crate::error::Error;
use crate::files::mark::{Checksum, Kind, Mark, SOFTWARE};
use crate::plane::Plane;
use std::io::{self, Seek, Write};
use std::path::Path;
use tiff::TiffResult;
use tiff::encoder::{TiffEncoder, TiffKind, colortype::Gray32Float};
use tiff::tags::Tag;

/// Maximum size of a plain TIFF's values, because its offsets end at 4 GiB; larger planes become BigTIFF.
const MAX_PLAIN_BYTES: usize = 0xf000_0000;

/// Writes the plane's values unchanged.
pub fn write_tiff(path: &Path, plane: &Plane) -> Result<(), Error> {
    let (width, height) = plane.size();
    let unfit = || Error::unfit(path, (width, height), "TIFF");
    let columns = u32::try_from(width).ok().filter(|w| *w > 0).ok_or_else(unfit)?;
    let rows = u32::try_from(height).ok().filter(|h| *h > 0).ok_or_else(unfit)?;
    write_whole(path, |out| {
        let size = (columns, rows);
        let written = if size_of_val(plane.data()) > MAX_PLAIN_BYTES {
            TiffEncoder::new_big(out).and_then(|encoder| write_page(encoder, size, plane))
        } else {
            TiffEncoder::new(out).and_then(|encoder| write_page(encoder, size, plane))
        };
        written.map_err(|e| match e {
            tiff::TiffError::IoError(e) => e,
            other => io::Error::other(other),
        })
    })
}

/// Writes the page, the program's name and the mark, which claims the samples as they are in the file.
fn write_page<K: TiffKind>(
    mut encoder: TiffEncoder<impl Write + Seek, K>,
    (columns, rows): (u32, u32),
    plane: &Plane,
) -> TiffResult<()> {
    let mut page = encoder.new_image::<Gray32Float>(columns, rows)?;
    let mark = Mark::new(Kind::Picture, Checksum::of(bytemuck::cast_slice(plane.data())));
    page.encoder().write_tag(Tag::Software, format!("{SOFTWARE} {}", mark.text()).as_str())?;
    page.write_data(plane.data())
}
