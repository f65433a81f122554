//! `.npy` arrays: a stack `[frames, rows, columns]` or one frame `[rows, columns]`, of any integer or float type in
//! either byte order, in C or Fortran order. Booleans become 0 and 1.

use super::npy_header::{self, NpyHeader};
use super::{Expected, FileScale, RawFrame, frame_of_plane};
use crate::burst::decode::{Ticker, in_order};
use crate::burst::options::Limits;
use crate::error::Error;
use crate::monitor::Monitor;
use crate::plane::{Plane, memory};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes that are read and converted at once: a multiple of every value's size, and small enough for the cache.
const BLOCK_BYTES: usize = 1 << 18;

pub(super) fn frame(
    path: &Path,
    file: File,
    expected: Option<Expected<'_>>,
    limits: &Limits,
) -> Result<RawFrame, Error> {
    let header = npy_header::read(path, &file, limits)?;
    if header.frames != 1 {
        return Err(Error::stack_among_frames(path, header.frames));
    }
    Expected::check(expected, path, (header.width, header.height))?;
    let mut frames = stack(path, file, limits, &Ticker::new(&Monitor::default(), 1))?;
    Ok(frames.remove(0))
}

pub(super) fn stack(path: &Path, file: File, limits: &Limits, ticker: &Ticker<'_>) -> Result<Vec<RawFrame>, Error> {
    let header = npy_header::read(path, &file, limits)?;
    let planes = if header.fortran_order {
        read_fortran(path, file, &header, ticker)?
    } else {
        in_order(header.frames, |t| {
            let frame = read_frame(path, &header, t, ticker)?;
            ticker.tick();
            Ok(frame)
        })?
    };
    let is_integer = !header.code.starts_with('f');
    let frame = |(t, values)| {
        let plane = Plane::from_vec(header.width, header.height, values);
        match header.range {
            Some(full_scale) => Ok(RawFrame::linear(plane, FileScale::Range(full_scale))),
            None => frame_of_plane(path, t, plane, is_integer),
        }
    };
    planes.into_iter().enumerate().map(frame).collect()
}

fn read_frame(path: &Path, header: &NpyHeader, t: usize, ticker: &Ticker<'_>) -> Result<Vec<f32>, Error> {
    let fail = |e: std::io::Error| Error::from_read(path, "NPY", &e);
    let count = header.width * header.height;
    let bytes = count * header.value_bytes;
    let mut file = File::open(path).map_err(fail)?;
    file.seek(SeekFrom::Start(header.data_offset + (t * bytes) as u64)).map_err(fail)?;
    let mut values = memory::with_capacity(count);
    let mut block = vec![0u8; BLOCK_BYTES.min(bytes)];
    let mut left = bytes;
    while left > 0 {
        ticker.check()?;
        let block = &mut block[..BLOCK_BYTES.min(left)];
        file.read_exact(block).map_err(fail)?;
        convert(block, header, &mut values);
        left -= block.len();
    }
    Ok(values)
}

/// Reads all frames of an array in Fortran order, where the frame index runs fastest and the column slowest.
fn read_fortran(path: &Path, mut file: File, header: &NpyHeader, ticker: &Ticker<'_>) -> Result<Vec<Vec<f32>>, Error> {
    let fail = |e: std::io::Error| Error::from_read(path, "NPY", &e);
    let (frames, height, width) = (header.frames, header.height, header.width);
    let mut planes: Vec<Vec<f32>> = (0..frames).map(|_| memory::zeroed(width * height)).collect();
    file.seek(SeekFrom::Start(header.data_offset)).map_err(fail)?;
    let mut left = frames * height * width * header.value_bytes;
    let mut block = vec![0u8; BLOCK_BYTES.min(left)];
    let mut values = Vec::new();
    let (mut t, mut v, mut u) = (0, 0, 0);
    while left > 0 {
        ticker.check()?;
        let block = &mut block[..BLOCK_BYTES.min(left)];
        file.read_exact(block).map_err(fail)?;
        values.clear();
        convert(block, header, &mut values);
        for &value in &values {
            planes[t][v * width + u] = value;
            t += 1;
            if t == frames {
                (t, v) = (0, v + 1);
                if v == height {
                    (v, u) = (0, u + 1);
                }
            }
        }
        left -= block.len();
    }
    (0..frames).for_each(|_| ticker.tick());
    Ok(planes)
}

/// Appends the values of `bytes`, divided by the type's range if it has one.
fn convert(bytes: &[u8], header: &NpyHeader, values: &mut Vec<f32>) {
    let divisor = header.range.unwrap_or(1.0);
    macro_rules! from {
        ($type:ty) => {{
            const SIZE: usize = size_of::<$type>();
            let (chunks, _) = bytes.as_chunks::<SIZE>();
            if header.big_endian {
                values.extend(chunks.iter().map(|c| <$type>::from_be_bytes(*c) as f32 / divisor));
            } else {
                values.extend(chunks.iter().map(|c| <$type>::from_le_bytes(*c) as f32 / divisor));
            }
        }};
    }
    match header.code {
        "b1" => values.extend(bytes.iter().map(|b| f32::from(u8::from(*b != 0)))),
        "u1" => from!(u8),
        "u2" => from!(u16),
        "u4" => from!(u32),
        "u8" => from!(u64),
        "i1" => from!(i8),
        "i2" => from!(i16),
        "i4" => from!(i32),
        "i8" => from!(i64),
        "f4" => from!(f32),
        "f8" => from!(f64),
        "f2" => {
            let (chunks, _) = bytes.as_chunks::<2>();
            let bits = |c: &[u8; 2]| if header.big_endian { u16::from_be_bytes(*c) } else { u16::from_le_bytes(*c) };
            values.extend(chunks.iter().map(|c| half::f16::from_bits(bits(c)).to_f32()));
        }
        other => unreachable!("{other} is not in the table of types"),
    }
}
