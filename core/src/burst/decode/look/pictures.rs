//! Checks of single pictures: the chunks of PNG and WebP, and the pixels of BMP and PNM, whose length follows from the
//! header.

use super::{Refusal, read_at};
use image::ImageFormat;
use std::io::{Read, Seek};

/// Largest ratio of deflated data's length to its compressed length, about.
const DEFLATE_GAIN: u64 = 1040;

/// Checks a picture of `length` bytes.
///
/// # Errors
/// [`Refusal`] of a picture that announces more than it can hold.
pub(in crate::burst::decode) fn check_picture(
    file: &mut (impl Read + Seek),
    length: u64,
    format: ImageFormat,
) -> Result<(), Refusal> {
    match format {
        ImageFormat::Png => check_png(file, length),
        ImageFormat::WebP => check_webp(file, length),
        ImageFormat::Bmp => check_bmp(file, length),
        ImageFormat::Pnm => check_pnm(file, length),
        _ => Ok(()),
    }
}

/// Checks that the chunks up to the first one of the picture lie within the file, and that the picture has no more rows
/// than deflate can make of such a file.
fn check_png(file: &mut (impl Read + Seek), length: u64) -> Result<(), Refusal> {
    const CHUNKS: usize = 4096;
    let mut at = 8;
    for index in 0..CHUNKS {
        let mut head = [0; 8];
        if at + 8 > length {
            return Err(Refusal::corrupt("it ends before its picture data"));
        }
        read_at(file, at, &mut head)?;
        let size = u64::from(u32::from_be_bytes([head[0], head[1], head[2], head[3]]));
        let name = [head[4], head[5], head[6], head[7]];
        let end = at + 12 + size;
        if index == 0 {
            if &name != b"IHDR" || size != 13 {
                return Err(Refusal::corrupt("it does not begin with its size"));
            }
            let mut header = [0; 13];
            read_at(file, at + 8, &mut header)?;
            let side =
                |at: usize| u64::from(u32::from_be_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]));
            let samples = match header[9] {
                2 => 3,
                4 => 2,
                6 => 4,
                _ => 1,
            };
            let row = (side(0).saturating_mul(samples * u64::from(header[8]))).div_ceil(8);
            if side(4).saturating_mul(row) > length.saturating_mul(DEFLATE_GAIN) {
                return Err(Refusal::corrupt(format!(
                    "its {} bytes are too few for {}×{} pixels",
                    length,
                    side(0),
                    side(4)
                )));
            }
        }
        // Where the file ends within the picture's data, the decoder's message is better.
        if &name == b"IDAT" {
            return Ok(());
        }
        if end > length {
            let name = String::from_utf8_lossy(&name).into_owned();
            return Err(Refusal::corrupt(format!("its chunk {name} announces {size} bytes, more than are left")));
        }
        at = end;
    }
    Err(Refusal::corrupt(format!("it has more than {CHUNKS} chunks before its picture data")))
}

/// Checks that each chunk lies within the file.
fn check_webp(file: &mut (impl Read + Seek), length: u64) -> Result<(), Refusal> {
    const CHUNKS: usize = 1 << 16;
    let mut head = [0; 8];
    read_at(file, 0, &mut head)?;
    // Bytes after the announced end are ignored.
    let all = 8 + u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
    let mut at = 12;
    for _ in 0..CHUNKS {
        if at + 8 > length.min(all) {
            return Ok(());
        }
        read_at(file, at, &mut head)?;
        let size = u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
        let end = at + 8 + size;
        if end > length {
            let name = String::from_utf8_lossy(&head[..4]).into_owned();
            return Err(Refusal::corrupt(format!("its chunk {name} announces {size} bytes, more than are left")));
        }
        at = end + size % 2;
    }
    Err(Refusal::corrupt(format!("it has more than {CHUNKS} chunks")))
}

/// Checks that uncompressed pixels are as many as the header says.
fn check_bmp(file: &mut (impl Read + Seek), length: u64) -> Result<(), Refusal> {
    const PLAIN: [u32; 4] = [0, 3, 6, 11];
    let mut head = [0; 34];
    if length < 34 {
        return Err(Refusal::corrupt("it ends within its header"));
    }
    read_at(file, 0, &mut head)?;
    let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    // Headers of 12 bytes have another form, and are older than any camera.
    if number(14) < 40 || !PLAIN.contains(&number(30)) {
        return Ok(());
    }
    let (width, height) = (u64::from(number(18)), u64::from((number(22) as i32).unsigned_abs()));
    let bits = u64::from(u16::from_le_bytes([head[28], head[29]]));
    let bytes = width.saturating_mul(bits).div_ceil(32).saturating_mul(4).saturating_mul(height);
    if bytes.saturating_add(u64::from(number(10))) > length {
        return Err(Refusal::corrupt(format!(
            "its {length} bytes are too few for {width}×{height} pixels of {bits} bit"
        )));
    }
    Ok(())
}

/// Checks that binary pixels are as many as the header says, and that pixels in digits have a digit and a blank each.
fn check_pnm(file: &mut (impl Read + Seek), length: u64) -> Result<(), Refusal> {
    // Headers are short, but may have comments; a longer one is left to the decoder.
    let mut head = vec![0; usize::try_from(length).unwrap_or(usize::MAX).min(4096)];
    read_at(file, 0, &mut head)?;
    let Some([width, height, largest]) = pnm_numbers(&head) else { return Ok(()) };
    let samples = width.saturating_mul(height);
    let wide = 1 + u64::from(largest > 255);
    let bytes = match head.get(1) {
        Some(b'1') => samples,
        Some(b'2') => samples.saturating_mul(2) - 1,
        Some(b'3') => samples.saturating_mul(6) - 1,
        Some(b'4') => width.div_ceil(8).saturating_mul(height),
        Some(b'5') => samples.saturating_mul(wide),
        Some(b'6') => samples.saturating_mul(3 * wide),
        _ => return Ok(()),
    };
    if bytes > length {
        return Err(Refusal::corrupt(format!("its {length} bytes are too few for {width}×{height} pixels")));
    }
    Ok(())
}

/// Columns, rows and the largest value (1 where there is none) of the header of a P1 to P6; `None` for other data,
/// which is left to the decoder's error.
fn pnm_numbers(head: &[u8]) -> Option<[u64; 3]> {
    let mut numbers = [0, 0, 1];
    let mut rest = head.get(2..)?;
    let wanted = if matches!(head[1], b'1' | b'4') { 2 } else { 3 };
    for number in numbers.iter_mut().take(wanted) {
        loop {
            match rest {
                [b'#', comment @ ..] => rest = &comment[comment.iter().position(|b| matches!(b, b'\n' | b'\r'))?..],
                [blank, tail @ ..] if blank.is_ascii_whitespace() => rest = tail,
                _ => break,
            }
        }
        let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
        *number = std::str::from_utf8(&rest[..digits]).ok()?.parse().ok()?;
        rest = &rest[digits..];
    }
    (numbers[0] > 0 && numbers[1] > 0).then_some(numbers)
}
