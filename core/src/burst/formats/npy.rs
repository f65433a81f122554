//! `.npy` arrays of integers, floats or booleans, C or Fortran order: a stack or a frame. Of an `.npz` one is taken.
//!
//! The header is a Python dictionary such as `{'descr': '<u2', 'fortran_order': False, 'shape': (10, 480, 640), }`. It
//! is read here rather than by a library, because a stack is read frame by frame, and because a hostile header must
//! neither take memory nor nest without end. Format:
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use super::{Input, Numbers, Rank, Record};
use crate::burst::layout::{Axis, AxisChoice, Dump, ViewGrid, ViewsChoice};
use crate::burst::reading::plain::{Index, Plain};
use crate::burst::{number::Number, options::OpenOptions};
use crate::error::{Error, ErrorKind, Result};
use std::io::{BufReader, Error as IoError, Read};
use std::{fs::File, path::Path};
use zip::{CompressionMethod, ZipArchive};

pub(super) struct Npy;

impl Numbers for Npy {
    const MAGIC: Option<&'static [u8]> = Some(MAGIC);

    fn record(&self) -> Record {
        let opens = "`[N,H,W]`, `[H,W]`, `[N,H,W,1]`, `[N,H,W,3]`, `[N,1,H,W]`; `[H,W,N]` where the last axis is eight times shorter than the others, which a note tells; `[rows,columns,H,W]` with five columns or more, and `[rows,columns,H,W,3]`, of the views of a light field";
        let options = "`--axis first`, `--axis last`; `--views 3x3` for arrays with fewer columns of views";
        Record { name: "NPY", rank: Rank::Picture, extensions: &["npy"], opens, options }
    }

    fn plain(&self, mut input: Input, path: &Path, options: &OpenOptions) -> Result<Plain> {
        let header = ArrayHeader::read(path, "NPY", &mut input.file)?;
        match options.raw.filter(|shape| shape.number == Number::U1) {
            Some(shape) => header.packed(path, input.length, shape, options),
            None => header.plain(path, "NPY", input.length, options),
        }
    }
}

pub(super) struct Npz;

impl Numbers for Npz {
    const MAGIC: Option<&'static [u8]> = Some(b"PK\x03\x04");

    fn record(&self) -> Record {
        let (opens, options) = ("the one array of such a shape", "`--array NAME` where there are several");
        Record { name: "NPZ", rank: Rank::Other, extensions: &["npz"], opens, options }
    }

    fn plain(&self, input: Input, path: &Path, options: &OpenOptions) -> Result<Plain> {
        of_archive(path, input.file, options)
    }
}

/// Largest header allowed, bytes. Longer ones are of structured arrays, which are no pictures.
const MAX_HEADER_BYTES: usize = 4096;

const DTYPES: [(&str, Number); 12] = [
    ("b1", Number::Bool),
    ("u1", Number::U8),
    ("u2", Number::U16),
    ("u4", Number::U32),
    ("u8", Number::U64),
    ("i1", Number::I8),
    ("i2", Number::I16),
    ("i4", Number::I32),
    ("i8", Number::I64),
    ("f2", Number::F16),
    ("f4", Number::F32),
    ("f8", Number::F64),
];

#[derive(Debug, Clone, PartialEq)]
struct ArrayHeader {
    descr: String,
    fortran_order: bool,
    shape: Vec<u64>,
    data_offset: u64,
}

impl ArrayHeader {
    fn read(path: &Path, kind: &str, reader: &mut impl Read) -> Result<Self> {
        let corrupt = |reason: &str| Error::corrupt(path, kind, reason);
        let fail = |e: std::io::Error| Error::from_read(path, kind, &e);
        let mut start = [0u8; 10];
        reader.read_exact(&mut start).map_err(fail)?;
        if !start.starts_with(MAGIC) {
            return Err(corrupt("its array does not begin as one"));
        }
        let (mut header_bytes, mut data_offset) = (usize::from(u16::from_le_bytes([start[8], start[9]])), 10);
        match start[6] {
            1 => {}
            // Versions 2 and 3 have a length of four bytes.
            2 | 3 => {
                let mut high = [0u8; 2];
                reader.read_exact(&mut high).map_err(fail)?;
                header_bytes |= usize::from(u16::from_le_bytes(high)) << 16;
                data_offset = 12;
            }
            version => return Err(corrupt(&format!("version {version} of the format is unknown"))),
        }
        if header_bytes > MAX_HEADER_BYTES {
            return Err(corrupt("its header is too long"));
        }
        let mut text = vec![0u8; header_bytes];
        reader.read_exact(&mut text).map_err(fail)?;
        let text = std::str::from_utf8(&text).map_err(|_| corrupt("its header is not text"))?;
        let (descr, fortran_order, shape) = parse(text).ok_or_else(|| corrupt("its header cannot be understood"))?;
        Ok(Self { descr, fortran_order, shape, data_offset: data_offset + header_bytes as u64 })
    }

    /// Whether the axes and the type can be those of frames.
    fn is_of_frames(&self) -> bool {
        (2..=5).contains(&self.shape.len()) && DTYPES.iter().any(|(code, _)| self.descr.get(1..) == Some(*code))
    }

    /// Frames of bits, of which bytes are an array, of the shape that the user says.
    fn packed(&self, path: &Path, length: u64, shape: Dump, options: &OpenOptions) -> Result<Plain> {
        let bytes = self.shape.iter().fold(1u64, |product, length| product.saturating_mul(*length));
        let (step, (width, height)) = (shape.frame_bytes(), shape.size);
        if self.descr.get(1..) != Some("u1") || self.fortran_order || !bytes.is_multiple_of(step) {
            let problem = format!("this array of the shape {:?} is no frames of {shape}", self.shape);
            let remedy = "save numpy.packbits(frames > 0, axis=-1), and say the size of a frame before it was packed";
            return Err(Error::new(ErrorKind::Mismatch, problem, remedy).about(path));
        }
        let frames = (bytes / step, height as u64, width as u64);
        let places = Plain::places_in(path, "NPY", frames, (self.data_offset, step, length), &options.limits)?;
        Ok(Plain::new("NPY", shape.size, places, Number::U1))
    }

    /// Its frames. `length` is that of the file or the member, bytes; a shape beyond the limits is refused.
    fn plain(&self, path: &Path, kind: &'static str, length: u64, options: &OpenOptions) -> Result<Plain> {
        let (order, code) = self.descr.split_at_checked(1).unwrap_or(("", ""));
        let number = DTYPES.iter().find(|(known, _)| *known == code).map(|(_, number)| *number);
        let number = number.ok_or_else(|| {
            let descr = &self.descr;
            let reason =
                format!("its values are of the type '{descr}'; save integers or floats, such as uint16 or float32");
            Error::unsupported(path, kind, reason)
        })?;
        let big_endian = match order {
            "<" | "|" | "=" => false,
            ">" => true,
            _ => return Err(Error::corrupt(path, kind, "its byte order is unknown")),
        };
        let of_views = axes_of_views(&self.shape, options.views);
        let shape = of_views.as_ref().map_or(&self.shape, |(_, shape)| shape);
        if of_views.is_some() && self.fortran_order {
            let reason = "its views are in Fortran's order; save it as numpy.ascontiguousarray makes it";
            return Err(Error::unsupported(path, kind, reason));
        }
        let (mut indices, taken) = meaning(shape, options.axis.as_ref()).map_err(|remedy| {
            let problem = format!("this array has the shape {:?}", self.shape);
            Error::new(ErrorKind::Unsupported, problem, remedy).about(path)
        })?;
        let length_of = |index| indices.iter().find(|(own, _)| *own == index).map_or(1, |(_, length)| *length);
        let (frames, height, width, channels) =
            (length_of(Index::Frame), length_of(Index::Row), length_of(Index::Column), length_of(Index::Colour));
        let step = number.bytes(height.saturating_mul(width).saturating_mul(channels));
        let bytes = (self.data_offset, step, length);
        let places = Plain::places_in(path, kind, (frames, height, width), bytes, &options.limits)?;
        // Fastest index first, as the values lie in the file: Fortran's order has it so already.
        if !self.fortran_order {
            indices.reverse();
        }
        let in_order = [Index::Colour, Index::Column, Index::Row, Index::Frame];
        // An axis of length 1 does not change the order in the file.
        let is_in_order = indices
            .iter()
            .filter(|(_, length)| *length > 1)
            .map(|(index, _)| in_order.iter().position(|own| own == index))
            .is_sorted();
        let scattered = indices.iter().map(|(index, length)| (*index, *length as usize));
        let scattered = if is_in_order { Vec::new() } else { scattered.collect() };
        // A program that saves frame after frame into one file leaves an array for each.
        let end = step.saturating_mul(frames).saturating_add(self.data_offset);
        let behind = (length > end).then(|| format!("behind the array lie {} bytes that are not read", length - end));
        let (views, taken) = (of_views.map(|(grid, _)| grid), taken.into_iter().chain(behind).collect());
        let is_encoded = channels > 1 && number == Number::U8;
        let plain = Plain::new(kind, (width as usize, height as usize), places, number);
        Ok(Plain { big_endian, channels: channels as usize, is_encoded, views, taken, scattered, ..plain })
    }
}

const MAGIC: &[u8] = b"\x93NUMPY";

/// Axes of an array as indices with their lengths, and a word about what was guessed.
type Meaning = (Vec<(Index, u64)>, Option<String>);

/// Least number of columns of views in an array that is taken for a light field unasked: fewer may be colours.
const MIN_COLUMNS: u64 = 5;

/// Grid of views of an array [rows, columns, v, u] (and colours), and its shape as a stack; four axes may need `views`.
fn axes_of_views(shape: &[u64], views: Option<ViewsChoice>) -> Option<(ViewGrid, Vec<u64>)> {
    let [rows, columns, frame @ ..] = shape else { return None };
    let grid = ViewGrid::new(usize::try_from(*rows).ok()?, usize::try_from(*columns).ok()?)?;
    let is_of_views = match (frame, views) {
        (_, Some(ViewsChoice::Grid(asked))) => (2..=3).contains(&frame.len()) && asked == grid,
        // Of views there are fewer than pixels along each side: else the last axis is one of channels.
        ([v, u], None) => *columns >= MIN_COLUMNS && rows <= v && columns <= u && !matches!(u, 1..=4),
        ([_, _, 1 | 3 | 4], None) => true,
        _ => false,
    };
    is_of_views.then(|| (grid, [&[grid.count() as u64], frame].concat()))
}

/// Meaning of the axes of an array. The error is a remedy.
fn meaning(shape: &[u64], axis: Option<&AxisChoice>) -> Result<Meaning, String> {
    use Index::{Colour, Column, Frame, Row};
    /// The last axis is taken for that of the frames where it is this many times shorter than the others.
    const SHORTER: u64 = 8;
    let axis = axis.map(|choice| choice.along);
    let usual = "a stack is [frames, rows, columns], one frame is [rows, columns], and [frames, rows, columns, 3] has colours; a light field is [rows, columns, v, u] with --views ROWSxCOLUMNS";
    let (indices, taken): (&[Index], _) = match *shape {
        _ if !matches!(axis, None | Some(Axis::First | Axis::Last)) => {
            return Err("the axes of an array have no names; say --axis first or --axis last".to_owned());
        }
        [_, _] => (&[Row, Column], None),
        [0, ..] => return Err(usual.to_owned()),
        [_, _, _] if axis == Some(Axis::First) => (&[Frame, Row, Column], None),
        [_, _, _] if axis == Some(Axis::Last) => (&[Row, Column, Frame], None),
        [first, middle, last] if last > 0 && last.saturating_mul(SHORTER) <= first.min(middle) => {
            if matches!(last, 3 | 4) {
                return Err(format!(
                    "it may be a picture with {last} colours or {last} frames: say --axis last for frames, or save a picture as [1, rows, columns, {last}]"
                ));
            }
            let words = "the last axis, which is by far the shortest, is taken for that of the frames; --axis first takes the first";
            (&[Row, Column, Frame], Some(words.to_owned()))
        }
        // The order that numpy.stack makes of frames.
        [_, _, _] => (&[Frame, Row, Column], None),
        [_, 1, _, _] => (&[Frame, Colour, Row, Column], None),
        [_, _, _, 1] => (&[Frame, Row, Column, Colour], None),
        [_, _, _, 3 | 4] => (
            &[Frame, Row, Column, Colour],
            Some("the last axis is taken for that of the colours, whose luma is used".to_owned()),
        ),
        _ => return Err(usual.to_owned()),
    };
    Ok((indices.iter().copied().zip(shape.iter().copied()).collect(), taken))
}

fn parse(text: &str) -> Option<(String, bool, Vec<u64>)> {
    let mut rest = text.trim().strip_prefix('{')?.trim_start();
    let (mut descr, mut fortran_order, mut shape) = (None, None, None);
    while !rest.starts_with('}') {
        let (key, after) = quoted(rest)?;
        rest = after.trim_start().strip_prefix(':')?.trim_start();
        match key {
            "descr" => {
                // A structured type is a list: not a picture.
                if rest.starts_with('[') {
                    return Some(("record".to_owned(), false, Vec::new()));
                }
                let (value, after) = quoted(rest)?;
                (descr, rest) = (Some(value.trim().to_owned()), after);
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

fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| *c == '\'' || *c == '"')?;
    text[1..].split_once(quote)
}

/// Most bytes to which a deflated byte unpacks.
const MOST_OF_BYTE: u64 = 1032;
const MAX_MEMBERS: usize = 256;

/// The array of an `.npz` archive, stored or deflated, that the options name, or the only one that can be frames.
fn of_archive(path: &Path, file: File, options: &OpenOptions) -> Result<Plain> {
    let fail = |e: zip::result::ZipError| Error::from_read(path, "NPZ", &IoError::from(e));
    let file_length = file.metadata().map_err(|e| Error::from_io(path, &e))?.len();
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(fail)?;
    let mut found = Vec::new();
    for index in 0..archive.len().min(MAX_MEMBERS) {
        let mut member = archive.by_index(index).map_err(fail)?;
        let Some(name) = member.name().strip_suffix(".npy").map(str::to_owned) else { continue };
        let length = member.size();
        // A size is a promise until the bytes are compared with it.
        let (packed, at) = (member.compressed_size(), member.data_start());
        let is_stored = member.compression() == CompressionMethod::Stored;
        let most = if is_stored { packed } else { packed.saturating_mul(MOST_OF_BYTE) };
        if at.saturating_add(packed) > file_length || length > most {
            let reason = format!(
                "'{name}' in it announces {length} bytes, and {packed} packed ones from byte {at} of {file_length} on"
            );
            return Err(Error::corrupt(path, "NPZ", reason));
        }
        found.push((name, index, length, ArrayHeader::read(path, "NPZ", &mut member)?));
    }
    if found.is_empty() {
        let problem = "this archive holds no arrays (.npy)";
        return Err(Error::new(ErrorKind::Unsupported, problem, "unpack it, and open what is in it").about(path));
    }
    let refused = |problem: String| {
        let all: Vec<String> = found.iter().map(|(name, .., header)| format!("{name} {:?}", header.shape)).collect();
        let remedy = format!("say with --array NAME which one holds the frames: {}", all.join(", "));
        Error::new(ErrorKind::Unsupported, problem, remedy).about(path)
    };
    // A named array is taken whatever it looks like; unasked, exactly one must look like frames.
    let chosen = match &options.array {
        Some(array) => {
            let named = found.iter().find(|(name, ..)| name == array);
            named.ok_or_else(|| refused(format!("this archive has no array '{array}'")))?
        }
        None => {
            let frames: Vec<_> = found.iter().filter(|(.., header)| header.is_of_frames()).collect();
            match frames[..] {
                [only] => only,
                [] => return Err(refused("no array of this archive can be frames".to_owned())),
                _ => return Err(refused(format!("this archive has {} arrays that can be frames", frames.len()))),
            }
        }
    };
    let (name, index, length, header) = chosen;
    let plain = header.plain(path, "NPZ", *length, options)?;
    let more = (found.len() > 1).then(|| format!("of {} arrays '{name}' is taken", found.len()));
    Ok(Plain { member: Some(*index), taken: plain.taken.iter().cloned().chain(more).collect(), ..plain })
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn arrays_of_views_are_told_from_colours() {
        let of = |shape: &[u64], views: Option<&str>| {
            axes_of_views(shape, views.map(|text| text.parse().expect("a choice"))).map(|found| found.1)
        };
        assert_eq!(of(&[9, 9, 480, 640], None), Some(vec![81, 480, 640]));
        for (shape, views) in [
            (&[10, 480, 640, 3][..], None),
            (&[9, 9, 480, 640], Some("3x27")),
            (&[81, 480, 640], Some("9x9")),
            (&[0, 9, 480, 640], None),
            (&[u64::MAX, 9, 480, 640], None),
        ] {
            assert_eq!(of(shape, views), None, "{shape:?}");
        }
    }
}
