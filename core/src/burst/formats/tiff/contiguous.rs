//! Frames that lie behind one another in a TIFF of which one directory tells: STK files of MetaMorph, ImageJ's files
//! beyond 4 GiB, arrays that tifffile wrote so, and volumes. They are plain numbers at even distances.

use super::described::{Axes, Described, described};
use super::{FileDecoder, NAME};
use crate::burst::number::Number;
use crate::burst::options::Limits;
use crate::burst::reading::plain::Plain;
use crate::burst::times::Times;
use crate::error::{Error, Result};
use std::path::Path;
use tiff::tags::Tag;

/// Planes of a MetaMorph stack: their number, and for each six numbers: its distance in depth (two), the day and the
/// millisecond when it was taken, and those when it was changed.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct Planes {
    pub count: u64,
    pub numbers: Vec<u64>,
}

impl Planes {
    /// Times of the planes, and their axes.
    pub(super) fn told(&self) -> (Times, Axes) {
        // Days count from noon of the first one of the Julian period.
        const DAY_OF_1970: f64 = 2_440_588.0;
        let planes = || self.numbers.as_chunks::<6>().0.iter();
        let seconds: Vec<f64> =
            planes().map(|plane| (plane[2] as f64 - DAY_OF_1970) * 86_400.0 + plane[3] as f64 * 1e-3).collect();
        let is_of_time = seconds.windows(2).all(|two| two[0] < two[1]) && seconds.iter().all(|second| *second > 0.0);
        let is_of_depth = planes().any(|plane| plane[0] > 0) && !is_of_time;
        let times = Times { seconds: if is_of_time { seconds } else { Vec::new() }, is_absolute: true };
        (times, vec![(if is_of_depth { 'Z' } else { 'T' }, self.count as usize)])
    }
}

/// Images that the description of a file with one directory announces; none where it tells of one.
pub(super) fn announced(description: Option<&str>, path: &Path) -> Option<Described> {
    let text = description?;
    let images = text.lines().find_map(|line| line.strip_prefix("images=")?.trim().parse::<usize>().ok());
    if text.starts_with("ImageJ=") {
        let images = images.filter(|images| *images > 1)?;
        let fits = described(text, path, images, None).ok().flatten();
        return fits.or_else(|| Some(Described::in_order(vec![('T', images)], images)));
    }
    if !text.starts_with('{') || !text.contains("\"truncated\"") {
        return None;
    }
    let found = described(text, path, 1, None).ok().flatten()?;
    let count = found.axes.iter().fold(1usize, |product, (_, length)| product.saturating_mul(*length));
    (count > 1).then(|| Described::in_order(found.axes, count))
}

/// `count` frames of `size` behind one another, of the decoder's current directory, in a file of `length` bytes.
///
/// # Errors
/// They are compressed, in tiles or planes, not alike, or more than the file holds.
pub(super) fn plain(
    decoder: &mut FileDecoder,
    (path, length): (&Path, u64),
    (count, size): (u64, (usize, usize)),
    limits: &Limits,
) -> Result<Plain> {
    let mut tag =
        |tag: Tag, usual: u64| decoder.find_tag_unsigned_vec::<u64>(tag).ok().flatten().unwrap_or(vec![usual]);
    let [compression, bits, format, samples, light] = [
        (Tag::Compression, 1),
        (Tag::BitsPerSample, 1),
        (Tag::SampleFormat, 1),
        (Tag::SamplesPerPixel, 1),
        (Tag::PhotometricInterpretation, 1),
    ]
    .map(|(name, usual)| tag(name, usual).first().copied().unwrap_or(usual));
    let (places, lengths) = (tag(Tag::StripOffsets, 0), tag(Tag::StripByteCounts, 0));
    let number = match (format, bits) {
        (1, 8) => Some(Number::U8),
        (1, 16) => Some(Number::U16),
        (1, 32) => Some(Number::U32),
        (2, 8) => Some(Number::I8),
        (2, 16) => Some(Number::I16),
        (2, 32) => Some(Number::I32),
        (3, 16) => Some(Number::F16),
        (3, 32) => Some(Number::F32),
        (3, 64) => Some(Number::F64),
        _ => None,
    };
    let follow = places.windows(2).zip(&lengths).all(|(two, bytes)| two[0].saturating_add(*bytes) == two[1]);
    let Some(number) = number.filter(|_| (compression, samples, light) == (1, 1, 1) && follow && places[0] > 0) else {
        let reason = format!(
            "it announces {count} images but lists only the first, and they are not plain grey numbers behind one \
             another; save it as BigTIFF, as a .npy stack or as an image sequence"
        );
        return Err(Error::unsupported(path, NAME, reason));
    };
    let step = number.bytes(size.0 as u64 * size.1 as u64);
    let shape = (count, size.1 as u64, size.0 as u64);
    // Where the directory follows the first image, no other is there.
    let directory = decoder.ifd_pointer().map_or(0, |at| at.0);
    let length = if directory > places[0] { length.min(directory) } else { length };
    let places = Plain::places_in(path, NAME, shape, (places[0], step, length), limits)?;
    let big_endian = decoder.byte_order() == tiff::tags::ByteOrder::BigEndian;
    Ok(Plain { big_endian, ..Plain::new(NAME, size, places, number) })
}
