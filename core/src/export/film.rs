//! Films: pictures of one size one after the other, for ever, as GIF, which is shown everywhere but has 256 colours; or
//! as PNG files with numbers, with all colours, for a program that makes a film of them.

use super::Bitmap;
use super::atomic::write_marked;
use super::png::write_png;
use crate::error::{Error, ErrorKind, Result};
use crate::files::mark::OutputKind;
use crate::monitor::{Monitor, Stage};
use image::RgbaImage;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Whether the name of a file ends as that of a film: `.gif`, or `.png` for pictures with numbers.
pub fn is_film(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gif")) || is_series(path)
}

fn is_series(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

/// Files of a film of `count` pictures at `path`: the GIF, or for `sweep.png` `sweep-000.png`, `sweep-001.png`, ….
pub fn film_files(path: &Path, count: usize) -> Vec<PathBuf> {
    if !is_series(path) {
        return vec![path.to_owned()];
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    (0..count).map(|index| path.with_file_name(format!("{stem}-{index:03}.png"))).collect()
}

/// Pictures per second that a film may have.
pub const FILM_RATES: std::ops::RangeInclusive<u16> = 1..=50;
/// Speed of the choice of a GIF's colours: 1 is best, 30 fastest.
const GIF_SPEED: i32 = 10;

/// Encodes `count` `pictures` of one size, `per_second` of them a second, each as it comes.
///
/// # Errors
/// Pictures of no size, of several sizes, too few or too large for the format, and errors of `pictures` and `out`.
pub fn encode_film(
    out: &mut dyn Write,
    (count, pictures): (usize, impl IntoIterator<Item = io::Result<RgbaImage>>),
    per_second: u16,
    monitor: &Monitor,
) -> io::Result<()> {
    let mut pictures = pictures.into_iter();
    let first = pictures.next().ok_or_else(|| io::Error::other("a film has at least one picture"))??;
    let size = first.dimensions();
    let (Ok(width), Ok(height)) = (u16::try_from(size.0), u16::try_from(size.1)) else {
        return Err(io::Error::other("a GIF has at most 65535 columns and rows"));
    };
    let mut encoder = gif::Encoder::new(out, width, height, &[]).map_err(io::Error::other)?;
    // Viewers show a film without this once, and then its last picture.
    encoder.set_repeat(gif::Repeat::Infinite).map_err(io::Error::other)?;
    for (index, picture) in std::iter::once(Ok(first)).chain(pictures).enumerate() {
        let picture = picture?;
        if width == 0 || height == 0 || picture.dimensions() != size {
            return Err(io::Error::other("all pictures of a film have one size, of at least one pixel"));
        }
        monitor.check().map_err(io::Error::other)?;
        monitor.report(Stage::Write, index as f32 / count.max(1) as f32);
        let mut frame = gif::Frame::from_rgba_speed(width, height, &mut picture.into_raw(), GIF_SPEED);
        // Hundredths of a second, the unit of the format; rounded so that the sum is right, not each of them.
        let until = |count: usize| 100 * count / usize::from(per_second.max(1));
        frame.delay = (until(index + 1) - until(index)) as u16;
        encoder.write_frame(&frame).map_err(io::Error::other)?;
    }
    Ok(())
}

/// Bytes, about, of a film of `count` pictures at `path`: the mean size of two of them, times their number.
pub fn estimated_film_bytes(path: &Path, pictures: [&RgbaImage; 2], count: usize) -> u64 {
    let of_one = |picture: &RgbaImage| {
        let mut bytes = Vec::new();
        let encoded = match is_series(path) {
            true => bitmap(picture).encode_png(&mut bytes),
            false => encode_film(&mut bytes, (1, [Ok(picture.clone())]), 10, &Monitor::default()),
        };
        encoded.map_or(0, |()| bytes.len() as u64)
    };
    (of_one(pictures[0]) + of_one(pictures[1])) / 2 * count as u64
}

fn bitmap(picture: &RgbaImage) -> Bitmap<'_> {
    Bitmap::rgba(picture.width() as usize, picture.height() as usize, picture.as_raw())
}

/// Writes a film to its [`film_files`]; [`encode_film`] encodes a GIF.
///
/// # Errors
/// Those of the pictures, a file that cannot be written, and cancellation, which leaves no picture of this film.
pub fn write_film(
    path: &Path,
    (count, pictures): (usize, impl IntoIterator<Item = io::Result<RgbaImage>>),
    per_second: u16,
    monitor: &Monitor,
) -> Result<()> {
    if !is_series(path) {
        return write_marked(path, OutputKind::Film, |mut out| {
            encode_film(&mut out, (count, pictures), per_second, monitor)
        });
    }
    let files = film_files(path, count);
    let write = |(index, (file, picture)): (usize, (&PathBuf, io::Result<RgbaImage>))| {
        monitor.check()?;
        monitor.report(Stage::Write, index as f32 / count.max(1) as f32);
        let picture = picture.map_err(|e| Error::new(ErrorKind::Unwritten, e.to_string(), "").about(file))?;
        write_png(file, bitmap(&picture))
    };
    let mut written = 0;
    let result = files.iter().zip(pictures).enumerate().try_for_each(|one| write(one).map(|()| written += 1));
    if result.is_err() {
        files[..written].iter().for_each(|file| drop(std::fs::remove_file(file)));
    }
    result
}
