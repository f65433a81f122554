//! The files of a model, whose fields have the same order in binary and in text.
//!
//! In binary: little-endian numbers without padding, counts before lists. Every count is checked against the remaining
//! bytes first, so that a damaged file takes neither memory nor time. In text: one line for each entry (two for an
//! image), fields separated by blanks, comments after `#`; a list is the rest of its line.

use super::{SparseImage, SparsePoint, world_from_camera};
use crate::evaluate::poses::{corrupt, unread};
use burstscope_core::error::{Error, Result};
use burstscope_core::files;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::{fmt::Display, fs::File, str::FromStr};

/// Id of the point of a keypoint without one.
const NO_POINT: i64 = -1;
const LONGEST_NAME: usize = 4096;

/// Kind of the entries of a file, in words for messages.
struct Entries {
    one: &'static str,
    all: &'static str,
    line: &'static str,
    /// Least number of bytes of an entry in binary.
    bytes: u64,
}

const IMAGES: Entries = Entries {
    one: "image",
    all: "images",
    line: "an image is 'IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME'",
    // Id, pose, camera, the name's end, number of keypoints.
    bytes: 4 + 7 * 8 + 4 + 1 + 8,
};

const POINTS: Entries = Entries {
    one: "point",
    all: "points",
    line: "a point is 'POINT3D_ID X Y Z R G B ERROR', then 'IMAGE_ID POINT2D_IDX' for each time it is seen",
    // Id, place, colour, error, length of the track.
    bytes: 8 + 3 * 8 + 3 + 8 + 8,
};

pub(super) struct Reader<R> {
    stream: R,
    path: PathBuf,
    entries: &'static Entries,
    /// Remaining bytes in binary; `None` in text.
    left: Option<u64>,
    /// Number of entries in binary.
    count: u64,
    /// Number of the entry in binary, or of the line in text, from 1.
    at: u64,
    /// The line in text, and how many bytes of it were read.
    line: String,
    read: usize,
}

impl Reader<BufReader<File>> {
    pub fn open(path: &Path, is_binary: bool) -> Result<Self> {
        let file = files::open(path).map_err(|e| unread(path, &e))?;
        let bytes = file.metadata().map_err(|e| unread(path, &e))?.len();
        Ok(Self::new(BufReader::with_capacity(1 << 16, file), is_binary.then_some(bytes), path))
    }
}

impl<R: BufRead> Reader<R> {
    /// Reads a binary file of so many `bytes`, or text; `path` is for messages.
    pub fn new(stream: R, bytes: Option<u64>, path: &Path) -> Self {
        let (path, line) = (path.to_owned(), String::new());
        Self { stream, path, entries: &IMAGES, left: bytes, count: 0, at: 0, line, read: 0 }
    }

    /// Reads id, pose, camera and name of every image, then its keypoints as place and id of the point.
    pub fn images(mut self) -> Result<Vec<SparseImage>> {
        let mut images = Vec::new();
        self.begin(&IMAGES)?;
        while self.next_entry()? {
            let id = self.number()?;
            let (quaternion, translation) = (self.numbers()?, self.numbers()?);
            let _camera_id: u32 = self.number()?;
            let name = self.name()?;
            let world_from_camera = world_from_camera(quaternion, translation).map_err(|problem| self.fail(problem))?;
            if self.left.is_none() {
                // An empty line of keypoints counts: it must not be skipped as other empty lines are.
                self.next_line()?;
            }
            let odd = |words| format!("{words} values; keypoints are 'X Y POINT3D_ID' each");
            let (keypoints, mut points) = (self.list(24, 3, odd)?, 0);
            for _ in 0..keypoints {
                let [_, _]: [f64; 2] = self.numbers()?;
                points += usize::from(self.number::<i64>()? != NO_POINT);
            }
            images.push(SparseImage { id, name, keypoints: keypoints as usize, points, world_from_camera });
        }
        Ok(images)
    }

    /// Reads id, place, colour and error of every point, then its track as image and index of the keypoint.
    pub fn points(mut self) -> Result<Vec<SparsePoint>> {
        let mut points = Vec::new();
        self.begin(&POINTS)?;
        while self.next_entry()? {
            self.skip(8)?;
            let position = self.numbers()?;
            (0..3).try_for_each(|_| self.skip(1))?;
            let reprojection_error_px = self.number()?;
            let odd = |words| format!("its track has {words} values; {}", POINTS.line);
            let track = (0..self.list(8, 2, odd)?).map(|_| self.numbers()).collect::<Result<_>>()?;
            points.push(SparsePoint { position, reprojection_error_px, track });
        }
        Ok(points)
    }

    fn fail(&self, problem: impl Display) -> Error {
        let Entries { one, all, .. } = self.entries;
        let place = match (self.left, self.at) {
            (None, line) => format!("line {line}"),
            (_, 0) => format!("the number of {all}"),
            (_, entry) => format!("{one} {entry} of {}", self.count),
        };
        corrupt(&self.path, &place, problem)
    }

    fn begin(&mut self, entries: &'static Entries) -> Result<()> {
        self.entries = entries;
        if self.left.is_some() {
            self.count = self.count(entries.bytes)?;
        }
        Ok(())
    }

    /// Goes to the next entry: in text the next line that is neither empty nor a comment.
    fn next_entry(&mut self) -> Result<bool> {
        if self.left.is_some() {
            self.at += 1;
            return Ok(self.at <= self.count);
        }
        while self.next_line()? {
            if !self.line.is_empty() && !self.line.starts_with('#') {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Goes to the next line of a text, without the blanks at its ends; at the end of the file that line is empty.
    fn next_line(&mut self) -> Result<bool> {
        let mut bytes = Vec::new();
        let length = self.stream.read_until(b'\n', &mut bytes).map_err(|e| unread(&self.path, &e))?;
        (self.line, self.read) = (String::from_utf8_lossy(&bytes).trim().to_owned(), 0);
        self.at += 1;
        Ok(length > 0)
    }

    /// The next `count` bytes of a binary file, at most 8, before zeros.
    fn bytes(&mut self, count: usize) -> Result<[u8; 8]> {
        let mut bytes = [0; 8];
        let left = self.left.and_then(|left| left.checked_sub(count as u64));
        self.left = Some(left.ok_or_else(|| self.fail("the file ends too early; copy it again"))?);
        self.stream.read_exact(&mut bytes[..count]).map_err(|e| unread(&self.path, &e))?;
        Ok(bytes)
    }

    fn number<T: Number>(&mut self) -> Result<T> {
        if self.left.is_some() {
            return Ok(T::of(self.bytes(size_of::<T>())?));
        }
        let rest = self.line[self.read..].trim_start();
        let start = self.line.len() - rest.len();
        self.read = start + rest.find(char::is_whitespace).unwrap_or(rest.len());
        match &self.line[start..self.read] {
            "" => Err(self.too_early()),
            word => word.parse().map_err(|_| self.fail(format!("'{word}' is not a number that can stand here"))),
        }
    }

    fn too_early(&self) -> Error {
        self.fail(format!("it ends too early; {}", self.entries.line))
    }

    fn numbers<T: Number, const N: usize>(&mut self) -> Result<[T; N]> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = self.number()?;
        }
        Ok(values)
    }

    /// Reads past a number of this many bytes, at most 8.
    fn skip(&mut self, bytes: usize) -> Result<()> {
        if self.left.is_some() { self.bytes(bytes).map(|_| ()) } else { self.number::<f64>().map(|_| ()) }
    }

    /// Number of items of a list: of `bytes` each in binary, of as many `words` of the line in text; `odd` says what is
    /// wrong with another number of words.
    fn list(&mut self, bytes: u64, words: usize, odd: impl Fn(usize) -> String) -> Result<u64> {
        if self.left.is_some() {
            return self.count(bytes);
        }
        let there = self.line[self.read..].split_whitespace().count();
        if there.is_multiple_of(words) { Ok((there / words) as u64) } else { Err(self.fail(odd(there))) }
    }

    /// A number of entries of at least `entry_bytes` bytes each, which must all fit into the remaining bytes.
    fn count(&mut self, entry_bytes: u64) -> Result<u64> {
        let count = u64::from_le_bytes(self.bytes(8)?);
        if self.left.is_some_and(|left| count > left / entry_bytes) {
            let problem = format!("it announces {count} entries, for which the file is too short; copy it again");
            return Err(self.fail(problem));
        }
        Ok(count)
    }

    /// A name: in binary it ends with a zero byte, in text it is the rest of the line, blanks included.
    fn name(&mut self) -> Result<String> {
        if self.left.is_none() {
            let name = self.line.split_off(self.read).trim_start().to_owned();
            return if name.is_empty() { Err(self.too_early()) } else { Ok(name) };
        }
        let mut name = Vec::new();
        loop {
            match self.bytes(1)?[0] {
                0 => return Ok(String::from_utf8_lossy(&name).into_owned()),
                // In a damaged file the zero at the end may be missing.
                _ if name.len() == LONGEST_NAME => {
                    return Err(self.fail(format!("its name is longer than {LONGEST_NAME} bytes, so this is no name")));
                }
                byte => name.push(byte),
            }
        }
    }
}

trait Number: FromStr + Copy + Default {
    /// The number of these bytes, of which a shorter one has the first.
    fn of(bytes: [u8; 8]) -> Self;
}

macro_rules! numbers {
    ($($number:ty)*) => {$(impl Number for $number {
        fn of(bytes: [u8; 8]) -> Self {
            Self::from_le_bytes(*bytes.first_chunk().expect("no number is longer"))
        }
    })*};
}
numbers!(f64 i64 u32);
