//! Decoding of JPEGs that takes no damaged data.
//!
//! The picture library fills in missing data without an error. So a JPEG is decoded here by the same decoder in its
//! strict mode, and its end marker must be there: the decoder does not miss it. Bytes after the end of the picture are
//! allowed: cameras put films and second pictures there.

use super::look::too_few_bytes;
use crate::plane::memory;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions};

/// Largest number of pixels of a byte of a JPEG: a block of 8×8 takes a bit or more.
const PIXELS_A_BYTE: u64 = 8 * 64;

/// Samples of a whole JPEG; in its own colours, or `as_rgb` unless it is grey.
///
/// # Errors
/// Damage, in words.
pub(super) fn samples(bytes: &[u8], as_rgb: bool) -> Result<Vec<u8>, String> {
    if !has_end(bytes) {
        return Err("its end marker is missing: it is cut off".to_owned());
    }
    // The caller has checked the size against its limits.
    let options = DecoderOptions::default().set_strict_mode(true).set_max_width(usize::MAX).set_max_height(usize::MAX);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let words = |error: zune_jpeg::errors::DecodeErrors| error.to_string().trim_matches('"').to_owned();
    decoder.decode_headers().map_err(words)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
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

/// Whether an end marker follows the headers, in which a thumbnail may have its own.
fn has_end(bytes: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    const WITHOUT_SEGMENT: [u8; 10] = [0x01, 0xd0, 0xd1, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8];
    let mut rest = bytes;
    loop {
        // Other bytes between segments, and fill bytes, are skipped, as the decoder does.
        let marker = rest.windows(2).position(|two| two[0] == 0xff && !matches!(two[1], 0 | 0xff));
        let Some(at) = marker else { return false };
        let marker = rest[at + 1];
        rest = &rest[at + 2..];
        if marker == START_OF_SCAN {
            return rest.windows(2).any(|two| two == [0xff, 0xd9]);
        }
        if !WITHOUT_SEGMENT.contains(&marker) {
            let length = rest.first_chunk::<2>().map(|length| usize::from(u16::from_be_bytes(*length)));
            let Some(after) = length.and_then(|length| rest.get(length..)) else { return false };
            rest = after;
        }
    }
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
        for bytes in SAMPLES {
            let whole = samples(bytes, true).expect("whole");
            assert_eq!(whole, image::load_from_memory(bytes).expect("whole").into_rgb8().into_raw());
            assert_eq!(samples(&[bytes, bytes, b"film"].concat(), true), Ok(whole));
            for cut in 2..bytes.len() {
                assert!(samples(&bytes[..cut], true).is_err(), "cut at {cut} of {}", bytes.len());
            }
        }
    }
}
