//! Animated PNG and WebP: the times of their frames, without decoding, and the frames as they are shown.

use super::{ImageFormat, failure, name};
use crate::burst::options::{Encoding, OpenOptions};
use crate::burst::reading::pixels::{Curve, grey_from_interleaved};
use crate::burst::reading::{FileScale, RawFrame, Reading, read_at};
use crate::burst::times::Times;
use crate::error::Result;
use crate::plane::{Plane, memory};
use image::codecs::{png::PngDecoder, webp::WebPDecoder};
use image::{AnimationDecoder, Frames};
use std::io::{self, BufRead, Read, Seek};

/// Largest number of parts of a file that are looked at.
const MAX_PARTS: usize = 1 << 16;

/// Seconds for which each frame of an animation is shown; none for a single picture.
pub(super) fn delays_s(file: &mut (impl Read + Seek), format: ImageFormat, length: u64) -> io::Result<Vec<f64>> {
    let (is_png, mut delays, mut start) = (format == ImageFormat::Png, Vec::new(), [0; 8]);
    if !is_png && format != ImageFormat::WebP {
        return Ok(delays);
    }
    let (mut at, mut is_announced) = (if is_png { 8 } else { 12 }, false);
    for _ in 0..MAX_PARTS {
        if at + 8 > length {
            break;
        }
        read_at(file, at, &mut start)?;
        let [first, second] = [[0, 1, 2, 3], [4, 5, 6, 7]].map(|of| of.map(|byte| start[byte]));
        let (size, kind) =
            if is_png { (u32::from_be_bytes(first), second) } else { (u32::from_le_bytes(second), first) };
        is_announced |= [b"acTL", b"ANIM"].contains(&&kind);
        // Of a single picture no more is read than stands before its pixels.
        if !is_announced && [b"IDAT", b"VP8 ", b"VP8L", b"IEND"].contains(&&kind) {
            break;
        }
        let end = at + 8 + u64::from(size) + if is_png { 4 } else { u64::from(size % 2) };
        let mut data = [0; 26];
        let most = data.len().min(size as usize);
        if [b"fcTL", b"ANMF"].contains(&&kind) && end <= length && most > 14 {
            read_at(file, at + 8, &mut data[..most])?;
            let number = |at: usize| f64::from(u16::from_be_bytes([data[at], data[at + 1]]));
            delays.push(match is_png {
                // A denominator of 0 stands for hundredths.
                true if number(22) > 0.0 => number(20) / number(22),
                true => number(20) / 100.0,
                false => f64::from(u32::from_le_bytes([data[12], data[13], data[14], 0])) * 1e-3,
            });
        }
        at = end;
    }
    Ok(if delays.len() > 1 { delays } else { Vec::new() })
}

/// Times from the first frame on; none where a frame is shown for no time.
pub(super) fn times(delays_s: &[f64]) -> Times {
    if delays_s.iter().any(|delay| *delay <= 0.0) {
        return Times::default();
    }
    let from = |sum: &mut f64, delay: &f64| Some(std::mem::replace(sum, *sum + delay));
    Times { seconds: delays_s.iter().scan(0.0, from).collect(), is_absolute: false }
}

/// The frames as they are shown, one over the other, up to the last that is taken.
pub(super) fn frames(
    reading: Reading<'_>,
    reader: impl BufRead + Seek,
    (format, is_colour): (ImageFormat, bool),
) -> Result<Vec<RawFrame>> {
    let Reading { path, options, ticker, .. } = reading;
    let fail = |e| failure(path, format, e);
    let shown: Frames<'_> = match format {
        ImageFormat::Png => PngDecoder::new(reader).and_then(PngDecoder::apng).map_err(fail)?.into_frames(),
        _ => WebPDecoder::new(reader).map_err(fail)?.into_frames(),
    };
    let OpenOptions { take, linearise, limits, .. } = options;
    let end = take.map_or(usize::MAX, |range| range.end);
    let mut frames = Vec::new();
    for frame in shown.take(end) {
        ticker.check()?;
        let picture = frame.map_err(fail)?.into_buffer();
        let (width, height) = picture.dimensions();
        limits.check_burst(path, frames.len() as u64 + 1, width.into(), height.into())?;
        memory::check_room(4 * u64::from(width) * u64::from(height));
        let values = grey_from_interleaved(picture.as_raw(), 4, Curve::of(255.0, *linearise));
        let plane = Plane::from_vec(width as usize, height as usize, values);
        let encoding = if is_colour && !linearise { Encoding::Srgb } else { Encoding::Linear };
        frames.push(RawFrame { encoding, is_colour, ..RawFrame::linear(plane, FileScale::Range(255.0)) });
        ticker.tick();
    }
    if frames.is_empty() {
        return Err(crate::error::Error::corrupt(path, name(format), "no frame of its animation is whole"));
    }
    options.taken(path, frames, (1, 1))
}
