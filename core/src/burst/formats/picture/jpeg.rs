//! Decoding of JPEGs that refuses damaged data.
//!
//! The picture library fills in missing data without an error. So a JPEG is decoded by the same decoder in its strict
//! mode, and its end marker must be there. After it cameras put films and second pictures.

use crate::burst::reading::{Asked, too_few_bytes};
use crate::{monitor::Monitor, plane::memory};
use std::{borrow::Cow, io::Cursor};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::{colorspace::ColorSpace, options::DecoderOptions};

/// Largest number of pixels of a byte of a JPEG: a block of 8×8 takes a bit or more.
const PIXELS_A_BYTE: u64 = 8 * 64;

/// Samples of a whole JPEG in its own colours, or `as_rgb` unless grey; the error is its damage, or a cancellation.
pub fn samples(bytes: &[u8], as_rgb: bool, monitor: &Monitor) -> Result<Vec<u8>, String> {
    if !has_end(bytes) {
        return Err("its end marker is missing: it is cut off".to_owned());
    }
    // The caller has checked the size against its limits.
    let options = DecoderOptions::default().set_strict_mode(true).set_max_width(usize::MAX).set_max_height(usize::MAX);
    let mut decoder = JpegDecoder::new_with_options(Asked::new(Cursor::new(bytes), monitor), options);
    let words = |error: zune_jpeg::errors::DecodeErrors| error.to_string().trim_matches('"').to_owned();
    decoder.decode_headers().map_err(words)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    // Checked before the buffer is made: few bytes may announce many pixels.
    if let Some(reason) = too_few_bytes(bytes.len() as u64, width as u64, height as u64, PIXELS_A_BYTE) {
        return Err(reason);
    }
    let own = decoder.input_colorspace().unwrap_or(ColorSpace::Luma);
    let colours = if as_rgb && own != ColorSpace::Luma { ColorSpace::RGB } else { own };
    decoder.set_options(options.jpeg_set_out_colorspace(colours));
    let mut samples = memory::zeroed(decoder.output_buffer_size().unwrap_or_default());
    decoder.decode_into(&mut samples).map_err(words)?;
    Ok(samples)
}

/// Example Huffman tables of the standard (ITU-T T.81, K.3 to K.6), as segments: frames of Motion JPEG omit them.
const USUAL_TABLES: &[u8] = include_bytes!("samples/usual_tables.dht");

/// A JPEG without bytes between segments and with the tables that it omits. The error says why nothing here reads it.
pub fn normalised(bytes: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let mut clean = bytes.get(..2).unwrap_or(bytes).to_vec();
    let (mut at, mut has_tables) = (2, false);
    loop {
        // A JPEG without picture data is damaged, which the decoder reports.
        let Some((marker, start, end)) = next_segment(bytes, at) else { return Ok(Cow::Borrowed(bytes)) };
        let Some(segment) = bytes.get(start..end) else { return Ok(Cow::Borrowed(bytes)) };
        match marker {
            0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf => {
                return Err(
                    "its pixels are coded without loss, in layers or arithmetically; convert it to PNG".to_owned()
                );
            }
            0xc0..=0xc2 if segment.get(4).is_some_and(|bits| *bits != 8) => {
                return Err(format!("its samples have {} bits; convert it to a 16-bit PNG", segment[4]));
            }
            0xc0..=0xc2 if segment.get(5..7) == Some(&[0, 0]) => {
                return Err("it tells its number of rows behind its pixels (DNL); convert it to PNG".to_owned());
            }
            0xc4 => has_tables = true,
            // Nothing is missing: the original bytes need no copy.
            START_OF_SCAN if clean.len() == start && has_tables => return Ok(Cow::Borrowed(bytes)),
            START_OF_SCAN => {
                if !has_tables {
                    clean.extend(USUAL_TABLES);
                }
                clean.extend(&bytes[start..]);
                return Ok(Cow::Owned(clean));
            }
            _ => {}
        }
        clean.extend(segment);
        at = end;
    }
}

/// Number of pictures that a JPEG announces (CIPA DC-007, multi-picture format): 1 where it says nothing.
pub(super) fn pictures(bytes: &[u8]) -> usize {
    const HEAD: usize = 1 << 18;
    let head = &bytes[..bytes.len().min(HEAD)];
    let find = || {
        let at = head.windows(4).position(|four| four == b"MPF\0")? + 4;
        let tiff = head.get(at..)?;
        let is_big = tiff.starts_with(b"MM");
        let number = |at: usize, count: usize| {
            let bytes = tiff.get(at..at + count)?;
            let push = |number: usize, byte: &u8| number << 8 | usize::from(*byte);
            Some(if is_big { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) })
        };
        let directory = number(4, 4)?;
        let entries = number(directory, 2)?.min(64);
        let entry = |k: usize| directory.saturating_add(2 + 12 * k);
        (0..entries).find(|k| number(entry(*k), 2) == Some(0xb001)).and_then(|k| number(entry(k) + 8, 4))
    };
    find().unwrap_or(1)
}

/// Whether an end marker follows the headers, in which a thumbnail may have its own.
fn has_end(bytes: &[u8]) -> bool {
    let mut at = 0;
    while let Some((marker, start, end)) = next_segment(bytes, at) {
        if marker == START_OF_SCAN {
            return bytes[start + 2..].windows(2).any(|two| two == [0xff, 0xd9]);
        }
        at = end;
    }
    false
}

const START_OF_SCAN: u8 = 0xda;

/// Marker, start and end of the next segment from `at` on; its end may lie behind that of the bytes.
fn next_segment(bytes: &[u8], at: usize) -> Option<(u8, usize, usize)> {
    let rest = bytes.get(at..)?;
    // Other bytes between segments, and fill bytes, are skipped, as the decoder does.
    let skipped = rest.windows(2).position(|two| two[0] == 0xff && !matches!(two[1], 0 | 0xff))?;
    let (marker, after) = (rest[skipped + 1], &rest[skipped + 2..]);
    // TEM, RST and SOI stand alone: no length follows.
    let length = after.first_chunk().filter(|_| !matches!(marker, 0x01 | 0xd0..=0xd8));
    let length = length.map_or(0, |length| usize::from(u16::from_be_bytes(*length)));
    Some((marker, at + skipped, at + skipped + 2 + length))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Colour pictures of 45×37: progressive and not, halved colours, restart markers, a scan for each component.
    const SAMPLES: [&[u8]; 4] = [
        include_bytes!("samples/progressive.jpg"),
        include_bytes!("samples/restarts.jpg"),
        include_bytes!("samples/progressive_restarts.jpg"),
        include_bytes!("samples/one_scan_each.jpg"),
    ];

    #[test]
    fn pictures_are_refused_wherever_they_are_cut_and_what_follows_them_is_nobodys() {
        let monitor = &Monitor::default();
        for bytes in SAMPLES {
            let whole = samples(bytes, true, monitor).expect("whole");
            assert_eq!(whole, image::load_from_memory(bytes).expect("whole").into_rgb8().into_raw());
            assert_eq!(samples(&[bytes, bytes, b"film"].concat(), true, monitor), Ok(whole));
            for cut in 2..bytes.len() {
                assert!(samples(&bytes[..cut], true, monitor).is_err(), "cut at {cut} of {}", bytes.len());
            }
        }
    }
}
