//! Films: pictures of one size one after the other, for ever, as GIF, which is shown everywhere.

use super::atomic::write_marked;
use crate::error::Result;
use crate::files::mark::OutputKind;
use crate::monitor::{Monitor, Stage};
use image::RgbaImage;
use std::io::{self, Write};
use std::path::Path;

/// Whether the name of a file ends as that of a film.
pub fn is_film(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gif"))
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

/// Bytes of a film of `count` pictures, about, before it is made: the mean size of two of them, times their number.
pub fn estimated_film_bytes(pictures: [&RgbaImage; 2], count: usize) -> u64 {
    let of_one = |picture: &RgbaImage| {
        let mut bytes = Vec::new();
        let encoded = encode_film(&mut bytes, (1, [Ok(picture.clone())]), 10, &Monitor::default());
        encoded.map_or(0, |()| bytes.len() as u64)
    };
    (of_one(pictures[0]) + of_one(pictures[1])) / 2 * count as u64
}

/// Writes a film, which [`encode_film`] encodes.
pub fn write_film(
    path: &Path,
    pictures: (usize, impl IntoIterator<Item = io::Result<RgbaImage>>),
    per_second: u16,
    monitor: &Monitor,
) -> Result<()> {
    write_marked(path, OutputKind::Film, |mut out| encode_film(&mut out, pictures, per_second, monitor))
}
