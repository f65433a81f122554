//! SER films of astronomical cameras: a header, frames of 8 to 16 bits of grey, mosaic or colours, and their times.
//!
//! Format: <http://www.grischa-hahn.homepage.t-online.de/astro/ser/>. By it LittleEndian is 1 for numbers with the low
//! byte first, but the first programs wrote 0, and all others follow them: 1 is big endian here, as in Siril.

use super::{Input, Numbers, Rank, Record};
use crate::burst::reading::plain::Plain;
use crate::burst::{layout::Mosaic, number::Number, options::OpenOptions, times::Times};
use crate::error::{Error, Result};
use crate::files::next_bytes;
use std::io::{Read, Seek, SeekFrom};
use std::{fs::File, path::Path};

const KIND: &str = "SER";
const HEADER_BYTES: usize = 178;
const MAX_TIMES: usize = 1 << 20;
/// Ticks of 100 ns of a second.
const TICKS_A_SECOND: u64 = 10_000_000;
const TICKS_TO_1970: u64 = 621_355_968_000_000_000;

pub(super) struct Ser;

impl Numbers for Ser {
    const MAGIC: Option<&'static [u8]> = Some(b"LUCAM-RECORDER");

    fn record(&self) -> Record {
        let opens = "mono, Bayer mosaic or RGB of 8 to 16 bits, with the times of frames; of a recording that was stopped the whole frames";
        Record { name: KIND, rank: Rank::Film, extensions: &["ser"], opens, options: "`--times header`" }
    }

    fn plain(&self, input: Input, path: &Path, options: &OpenOptions) -> Result<Plain> {
        let Input { mut file, length } = input;
        let fail = |e: std::io::Error| Error::from_read(path, KIND, &e);
        let mut header = [0; HEADER_BYTES];
        file.read_exact(&mut header).map_err(fail)?;
        // Six numbers follow the signature and the camera's number (LuID).
        let number = |index: usize| {
            let at = 18 + 4 * index;
            u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]])
        };
        let [colour, low_byte_last, width, height, bits, announced] = std::array::from_fn(number);
        let corrupt = |reason: String| Error::corrupt(path, KIND, reason);
        if !(1..=16).contains(&bits) {
            return Err(corrupt(format!("PixelDepthPerPlane is {bits} bits, and 1 to 16 are possible")));
        }
        let (channels, mosaic) = match colour {
            0 => (1, None),
            8..=11 => (1, Some(Mosaic::ALL[colour as usize - 8])),
            100 | 101 => (3, None),
            16..=19 => {
                let reason = "its mosaic is of cyan, yellow, green and magenta; save it as RGB";
                return Err(Error::unsupported(path, KIND, reason));
            }
            _ => return Err(corrupt(format!("ColorID is {colour}, which the format does not know"))),
        };
        let (width, height, kind) =
            (u64::from(width), u64::from(height), if bits > 8 { Number::U16 } else { Number::U8 });
        let step = kind.bytes(height.saturating_mul(width).saturating_mul(channels as u64));
        // A recording that was stopped has no number of frames.
        let there = length.saturating_sub(HEADER_BYTES as u64) / step.max(1);
        let shape = (if announced == 0 { there } else { announced.into() }, height, width);
        if shape.0 == 0 {
            return Err(corrupt("FrameCount is 0, and no whole frame follows".to_owned()));
        }
        let places = Plain::places_in(path, KIND, shape, (HEADER_BYTES as u64, step, length), &options.limits)?;
        let end = HEADER_BYTES as u64 + step * shape.0;
        let mut taken = Vec::new();
        if announced == 0 {
            taken.push(format!(
                "FrameCount is 0, as of a recording that was stopped; the {there} whole frames are taken"
            ));
        }
        if bits > 8 {
            let order = if low_byte_last == 1 { "high" } else { "low" };
            taken.push(format!(
                "the {order} byte of a number is taken for the first, as programs write the field LittleEndian"
            ));
        }
        let plain = Plain {
            big_endian: low_byte_last == 1,
            channels,
            is_bgr: colour == 101,
            white: Some(((1u32 << bits) - 1) as f32),
            mosaic,
            times: times(path, &mut file, (end, length), shape.0 as usize, options, &mut taken)?,
            taken,
            ..Plain::new(KIND, (width as usize, height as usize), places, kind)
        };
        let order = if low_byte_last == 1 { u16::from_be_bytes } else { u16::from_le_bytes };
        aligned(plain, bits, &mut file, order).map_err(fail)
    }
}

/// Most bytes of the first frame that are looked at.
const MAX_LOOKED: u64 = 1 << 22;

/// The frames with the full scale that their numbers have: some programs fill the upper bits of 16.
fn aligned(plain: Plain, bits: u32, file: &mut File, number: fn([u8; 2]) -> u16) -> std::io::Result<Plain> {
    file.seek(SeekFrom::Start(plain.places.at(0)))?;
    let bytes = next_bytes(file, plain.frame_bytes().min(MAX_LOOKED))?;
    // The bits that any number sets show where in the word the values lie.
    let all = bytes.as_chunks::<2>().0.iter().fold(0, |all, two| all | number(*two));
    if !(9..16).contains(&bits) || u32::from(all) >> bits == 0 {
        return Ok(plain);
    }
    let is_upper = all.trailing_zeros() >= 16 - bits;
    let white = if is_upper { ((1u32 << bits) - 1) << (16 - bits) } else { u32::from(u16::MAX) };
    let mut taken = plain.taken;
    taken.push(match is_upper {
        true => format!("its numbers fill the upper {bits} of 16 bits: {white} is taken for white"),
        false => format!("its numbers exceed the {bits} bits that it announces: {white} is taken for white; --full-scale says another value"),
    });
    Ok(Plain { white: Some(white as f32), taken, ..plain })
}

/// Times of `taken`, behind the last frame, which ends at `end` of `length` bytes; none that make no sense.
fn times(
    path: &Path,
    file: &mut File,
    (end, length): (u64, u64),
    frames: usize,
    options: &OpenOptions,
    taken: &mut Vec<String>,
) -> Result<Times> {
    let (there, whole) = (length.saturating_sub(end), 8 * frames as u64);
    if there < whole {
        if there > 0 {
            taken.push(format!(
                "{there} bytes follow the last frame, from byte {end} on, and the times of {frames} frames take {whole}: \
                 the file may be cut there; its times are not read"
            ));
        }
        return Ok(Times::default());
    }
    let range = options.take.map_or(0..frames, |range| range.start.min(frames)..range.end.min(frames));
    if range.len() > MAX_TIMES {
        taken.push(format!("the times of more than {MAX_TIMES} frames are not read; take a part"));
        return Ok(Times::default());
    }
    let mut bytes = vec![0; 8 * range.len()];
    file.seek(SeekFrom::Start(end + 8 * range.start as u64)).map_err(|e| Error::from_read(path, KIND, &e))?;
    file.read_exact(&mut bytes).map_err(|e| Error::from_read(path, KIND, &e))?;
    let ticks: Vec<u64> = bytes.as_chunks::<8>().0.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect();
    // Earlier stamps are no times of a recording.
    if ticks.iter().any(|ticks| *ticks < TICKS_TO_1970) {
        return Ok(Times::default());
    }
    taken.extend((!ticks.is_sorted()).then(|| "the stamps of its frames are not in their order".to_owned()));
    let seconds = |ticks: u64| {
        let ticks = ticks - TICKS_TO_1970;
        // The whole seconds and the rest each keep their digits.
        (ticks / TICKS_A_SECOND) as f64 + (ticks % TICKS_A_SECOND) as f64 / TICKS_A_SECOND as f64
    };
    Ok(Times { seconds: ticks.into_iter().map(seconds).collect(), is_absolute: true })
}
