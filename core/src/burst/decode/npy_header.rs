//! The header of a `.npy` file: the type of its values, their order, and the shape.
//!
//! The header is a Python dictionary such as `{'descr': '<u2', 'fortran_order': False, 'shape': (10, 480, 640), }`. It
//! is read here rather than by a library, because a stack is read frame by frame, and because a hostile header must
//! neither take memory nor nest without end. Format:
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use crate::burst::options::Limits;
use crate::error::{Error, ErrorKind};
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

/// Largest header allowed, bytes. Longer ones are of structured arrays, which are no pictures.
const MAX_HEADER_BYTES: usize = 4096;

/// Code of each type in the header, bytes of a value, and the largest value where that is the full scale.
const DTYPES: [(&str, usize, Option<f32>); 12] = [
    ("b1", 1, Some(1.0)),
    ("u1", 1, Some(255.0)),
    ("u2", 2, Some(65535.0)),
    ("u4", 4, None),
    ("u8", 8, None),
    ("i1", 1, Some(127.0)),
    ("i2", 2, Some(32767.0)),
    ("i4", 4, None),
    ("i8", 8, None),
    ("f2", 2, None),
    ("f4", 4, None),
    ("f8", 8, None),
];

#[derive(Debug, Clone, Copy)]
pub(super) struct NpyHeader {
    /// Code of the values' type in [`DTYPES`].
    pub code: &'static str,
    pub value_bytes: usize,
    /// Largest value of the types whose range is the full scale.
    pub range: Option<f32>,
    pub big_endian: bool,
    /// Whether the first index runs fastest.
    pub fortran_order: bool,
    pub frames: usize,
    pub height: usize,
    pub width: usize,
    pub data_offset: u64,
}

/// Reads the header, checks the shape against the limits, and the file's length against the shape.
pub(super) fn read(path: &Path, mut file: &File, limits: &Limits) -> Result<NpyHeader, Error> {
    let corrupt = |reason: &str| Error::corrupt(path, "NPY", reason);
    let fail = |e: std::io::Error| Error::from_read(path, "NPY", &e);
    let file_bytes = file.metadata().map_err(fail)?.len();
    file.rewind().map_err(fail)?; // handles of one file share their place
    let mut start = [0u8; 10];
    file.read_exact(&mut start).map_err(fail)?;
    let (mut header_bytes, mut data_offset) = (usize::from(u16::from_le_bytes([start[8], start[9]])), 10);
    match start[6] {
        1 => {}
        2 | 3 => {
            let mut high = [0u8; 2];
            file.read_exact(&mut high).map_err(fail)?;
            header_bytes |= usize::from(u16::from_le_bytes(high)) << 16;
            data_offset = 12;
        }
        version => return Err(corrupt(&format!("version {version} of the format is unknown"))),
    }
    if header_bytes > MAX_HEADER_BYTES {
        return Err(corrupt("its header is too long"));
    }
    let mut text = vec![0u8; header_bytes];
    file.read_exact(&mut text).map_err(fail)?;
    let text = std::str::from_utf8(&text).map_err(|_| corrupt("its header is not text"))?;
    let (descr, fortran_order, shape) = parse(text).ok_or_else(|| corrupt("its header cannot be understood"))?;

    let (order, code) = descr.split_at_checked(1).unwrap_or(("", ""));
    let record = DTYPES.iter().find(|(known, ..)| *known == code);
    let (code, value_bytes, range) = *record.ok_or_else(|| {
        let reason =
            format!("its values are of the type '{descr}'; save integers or floats, such as uint16 or float32");
        Error::unsupported(path, "NPY", reason)
    })?;
    let big_endian = match order {
        "<" | "|" | "=" => false,
        ">" => true,
        _ => return Err(corrupt("its byte order is unknown")),
    };
    let (frames, height, width) = match shape[..] {
        [height, width] => (1, height, width),
        [frames @ (1..), height, width] => (frames, height, width),
        _ => {
            let problem = format!("this array has the shape {shape:?}");
            let remedy = "a stack is [frames, rows, columns], one frame is [rows, columns]";
            return Err(Error::new(ErrorKind::Unsupported, problem, remedy).about(path));
        }
    };
    limits.check_frame(path, width, height)?;
    limits.check_burst(path, frames, width, height)?;
    let data_offset = data_offset + header_bytes as u64;
    // Cannot overflow: the limits have been checked.
    let wanted = frames * height * width * value_bytes as u64;
    let there = file_bytes.saturating_sub(data_offset);
    if there < wanted {
        return Err(corrupt(&format!("{wanted} bytes of values are announced, {there} are there")));
    }
    Ok(NpyHeader {
        code,
        value_bytes,
        range,
        big_endian,
        fortran_order,
        frames: frames as usize,
        height: height as usize,
        width: width as usize,
        data_offset,
    })
}

fn parse(text: &str) -> Option<(String, bool, Vec<u64>)> {
    let mut rest = text.trim().strip_prefix('{')?.trim_start();
    let (mut descr, mut fortran_order, mut shape) = (None, None, None);
    while !rest.starts_with('}') {
        let (key, after) = quoted(rest)?;
        rest = after.trim_start().strip_prefix(':')?.trim_start();
        match key {
            "descr" => {
                // A structured type is a list: not a picture, but named in the error.
                let (value, after) = if rest.starts_with('[') { (rest, "}") } else { quoted(rest)? };
                (descr, rest) = (Some(value.trim().to_owned()), after);
                if value.starts_with('[') {
                    return Some((descr?, false, Vec::new()));
                }
            }
            "fortran_order" => {
                let (value, after) = [(true, "True"), (false, "False")]
                    .iter()
                    .find_map(|(value, word)| Some((*value, rest.strip_prefix(word)?)))?;
                (fortran_order, rest) = (Some(value), after);
            }
            "shape" => {
                let (list, after) = rest.strip_prefix('(')?.split_once(')')?;
                let numbers = list.split(',').map(str::trim).filter(|n| !n.is_empty());
                // Old versions of Python write long integers with an L.
                shape = Some(numbers.map(|n| n.trim_end_matches('L').parse().ok()).collect::<Option<Vec<u64>>>()?);
                rest = after;
            }
            _ => return None,
        }
        rest = rest.trim_start();
        rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
    }
    Some((descr?, fortran_order?, shape?))
}

/// A quoted word and the text after it.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| *c == '\'' || *c == '"')?;
    text[1..].split_once(quote)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn headers_of_numpy_are_understood() {
        let text = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 480, 640), }            \n";
        assert_eq!(parse(text), Some(("<f4".into(), false, vec![3, 480, 640])));
        let text = "{\"shape\":(5L,),\"fortran_order\":True,\"descr\":\"|u1\"}";
        assert_eq!(parse(text), Some(("|u1".into(), true, vec![5])));
        assert_eq!(parse("{'descr': '<f4', 'fortran_order': False, 'shape': ()}"), Some(("<f4".into(), false, vec![])));
        for wrong in ["", "{", "{}", "{'descr': '<f4'}", "{'descr': 3}", "{'shape': (-1,)}", "((((((((", "{'x': 1}"] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }

    proptest! {
        #[test]
        fn no_header_panics(text in "\\PC{0,60}", cut in 0usize..60) {
            let _ = parse(&text);
            let good = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 480, 640), }";
            let _ = parse(&good[..cut]);
            let _ = parse(&format!("{}{text}{}", &good[..cut], &good[cut..]));
        }
    }
}
