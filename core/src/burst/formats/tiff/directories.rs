//! The directories of a TIFF file, and of raw files that are TIFFs by their structure (DNG, NEF, CR2, ARW and others).
//!
//! A directory is a list of entries: a tag, a type, a count of values, and the values or their place. A decoder that
//! trusts the count allocates memory for four thousand million values of a file of two hundred bytes. Here every count
//! is compared with the file's length; whether the values are there, the decoders see.

use super::{described::Axes, sensor::Sensor};
use crate::burst::formats::{Start, has_extension};
use crate::burst::reading::{corrupt, read_at};
use crate::burst::times::Times;
use std::collections::HashSet;
use std::io::{self, BufReader, Read, Seek};

/// Extensions of files with the values of a sensor, of which many are TIFFs by their structure.
pub const OF_SENSORS: &[&str] = &[
    "dng", "nef", "nrw", "cr2", "cr3", "crw", "arw", "raf", "orf", "rw2", "rwl", "pef", "srw", "3fr", "fff", "iiq",
    "kdc", "dcr", "mrw", "erf", "mef", "mos", "x3f",
];

pub fn begins(start: &[u8]) -> bool {
    [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| start.starts_with(*magic))
}

/// Whether a file holds the values of a sensor: by its name, or as a DNG of any name.
pub fn is_of_sensor(start: &Start<'_>) -> bool {
    let is_dng = || {
        let found = Directories::read(&mut BufReader::with_capacity(512, start.file), start.length, false, 1);
        found.is_ok_and(|found| found.is_dng)
    };
    has_extension(start.path, OF_SENSORS) || begins(start.bytes) && is_dng()
}

/// Maximum number of directories that are read; a burst has fewer frames.
const MAX_DIRECTORIES: usize = 1 << 14;
/// Maximum number of entries of all directories together: real files have some tens a directory.
const MAX_ENTRIES: u64 = 1 << 20;
/// Largest total of all entries' values, as a multiple of the file's length: several entries may share a place.
const MAX_SHARING: u64 = 4;
/// Further allowance for the values of all entries, bytes: for small files.
const SMALL_VALUES: u64 = 1 << 24;

const UNCOMPRESSED: u64 = 1;
const JPEG: u64 = 7;

mod tag {
    pub(super) const NEW_SUBFILE_TYPE: u64 = 254;
    pub(super) const IMAGE_WIDTH: u64 = 256;
    pub(super) const IMAGE_LENGTH: u64 = 257;
    pub(super) const COMPRESSION: u64 = 259;
    pub(super) const PHOTOMETRIC: u64 = 262;
    pub(super) const STRIP_OFFSETS: u64 = 273;
    pub(super) const STRIP_BYTE_COUNTS: u64 = 279;
    pub(super) const TILE_OFFSETS: u64 = 324;
    pub(super) const TILE_BYTE_COUNTS: u64 = 325;
    pub(super) const SUB_DIRECTORIES: u64 = 330;
    pub(super) const TILE_DEPTH: u64 = 32998;
    pub(super) const MOSAIC: u64 = 33422;
    pub(super) const EXIF: u64 = 34665;
    pub(super) const GPS: u64 = 34853;
    pub(super) const INTEROPERABILITY: u64 = 40965;
    pub(super) const DNG_VERSION: u64 = 50706;
    /// Tags of MetaMorph: their count is that of the planes, and their values have lengths of their own.
    pub(super) const FIRST_OF_PLANES: u64 = 33628;
    pub(super) const PLANES: u64 = 33629;
    pub(super) const LAST_OF_PLANES: u64 = 33631;
}

/// Planes of a MetaMorph stack, six numbers each: depth (two), day and millisecond of recording and of change.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct Planes {
    pub count: u64,
    pub numbers: Vec<u64>,
}

impl Planes {
    /// Times of the planes, and their axis: time where the times rise, else depth where one is given.
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

#[derive(Debug, Default)]
pub struct Directories {
    /// Largest size, columns × rows.
    pub pixels: u64,
    pub is_dng: bool,
    pub(super) planes: Planes,
    pub(super) sensor: Sensor,
    /// Pages that a tile of a volume has, 0 where none has several.
    pub(super) tile_depth: u64,
}

impl Directories {
    /// Checks at most `most` pages of `file`, a TIFF of `length` bytes; of a file that is `raw` by its name, and of a
    /// DNG, all directories, because its decoder reads them. A DNG must hold the data of all its pictures.
    pub fn read(file: &mut (impl Read + Seek), length: u64, raw: bool, most: usize) -> io::Result<Self> {
        let mut start = [0; 16];
        let have = start.len().min(usize::try_from(length).unwrap_or(usize::MAX));
        read_at(file, 0, &mut start[..have])?;
        let big_endian = start[0] == b'M';
        // BigTIFF has the version 43, and places of eight bytes.
        let big = number(big_endian, &start[2..4]) == 43;
        let first = number(big_endian, if big { &start[8..16] } else { &start[4..8] });
        let (entries, value_bytes) = (0, 0);
        let (seen, parts, found) = (HashSet::new(), Vec::new(), Self::default());
        let mut walk = Walk { file, length, big_endian, big, raw, entries, value_bytes, seen, parts, found };
        walk.read_all(first, most.min(MAX_DIRECTORIES))?;
        Ok(walk.found)
    }
}

fn number(big_endian: bool, bytes: &[u8]) -> u64 {
    let push = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
    if big_endian { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) }
}

/// Bytes of a value of each type; 1 for unknown types, as decoders take them.
fn size_of_kind(kind: u64) -> u64 {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16 | 17 | 18 => 8,
        _ => 1,
    }
}

struct Walk<'a, R> {
    file: &'a mut R,
    length: u64,
    big_endian: bool,
    big: bool,
    raw: bool,
    entries: u64,
    value_bytes: u64,
    seen: HashSet<u64>,
    /// Positions of directories that earlier ones refer to, and whether each holds notes (EXIF), which may be absent.
    parts: Vec<(u64, bool)>,
    found: Directories,
}

impl<R: Read + Seek> Walk<'_, R> {
    fn read_all(&mut self, first: u64, most: usize) -> io::Result<()> {
        let mut next = first;
        for _ in 0..most {
            if !self.seen.insert(next) {
                return Err(corrupt("its list of pages leads back to itself"));
            }
            next = self.read_directory(next, false)?;
            while let Some((at, is_notes)) = self.parts.pop() {
                // Two directories may refer to the same one; a cycle ends here too.
                if self.seen.len() < MAX_DIRECTORIES && self.seen.insert(at) {
                    self.read_directory(at, is_notes)?;
                }
            }
            if next == 0 {
                break;
            }
        }
        Ok(())
    }

    fn read_directory(&mut self, at: u64, is_notes: bool) -> io::Result<u64> {
        let (count_bytes, field_bytes) = if self.big { (8, 8) } else { (2, 4) };
        let entry_bytes = 4 + 2 * field_bytes as u64;
        let left = self.length.saturating_sub(at);
        let mut head = vec![0; count_bytes];
        let is_begun = left >= count_bytes as u64;
        if is_begun {
            read_at(self.file, at, &mut head)?;
        }
        let mut bytes = number(self.big_endian, &head).saturating_mul(entry_bytes);
        if !is_begun || bytes.saturating_add((count_bytes + field_bytes) as u64) > left {
            // Decoders read the entries of cut notes that are there, so these are checked too.
            bytes = left.saturating_sub((count_bytes + field_bytes) as u64) / entry_bytes * entry_bytes;
            if !is_notes || bytes == 0 {
                return if is_notes { Ok(0) } else { Err(corrupt("a directory lies beyond its end")) };
            }
        }
        self.entries += bytes / entry_bytes;
        if self.entries > MAX_ENTRIES {
            return Err(corrupt(format!("its directories have more than {MAX_ENTRIES} entries")));
        }
        let mut table = vec![0; bytes as usize + field_bytes];
        read_at(self.file, at + count_bytes as u64, &mut table)?;
        let (table, next) = table.split_at(bytes as usize);
        let first = at + count_bytes as u64;
        self.check((first..).step_by(entry_bytes as usize).zip(table.chunks_exact(entry_bytes as usize)), is_notes)?;
        Ok(number(self.big_endian, next))
    }

    fn check<'e>(&mut self, entries: impl Iterator<Item = (u64, &'e [u8])> + Clone, is_notes: bool) -> io::Result<()> {
        let big_endian = self.big_endian;
        let number = |bytes: &[u8]| number(big_endian, bytes);
        // DNG's version stands in the first directory, and changes how all entries are judged.
        if self.seen.len() == 1 && entries.clone().any(|(_, entry)| number(&entry[..2]) == tag::DNG_VERSION) {
            (self.found.is_dng, self.raw) = (true, true);
        }
        let (mut width, mut height, mut is_thumbnail) = (0, 0, false);
        let (mut compression, mut places, mut lengths) = (UNCOMPRESSED, None, None);
        for (at, entry) in entries {
            let (tag, kind) = (number(&entry[..2]), number(&entry[2..4]));
            let (count, field) = entry[4..].split_at((entry.len() - 4) / 2);
            let (count, size) = (number(count), size_of_kind(kind));
            if (tag::FIRST_OF_PLANES..=tag::LAST_OF_PLANES).contains(&tag) {
                if tag == tag::PLANES && self.found.planes.count == 0 {
                    self.read_planes(count, number(field))?;
                }
                continue;
            }
            let bytes = count.saturating_mul(size);
            if bytes > self.length {
                return Err(corrupt(format!(
                    "tag {tag} announces {count} values of {size} bytes each, and the file has {} bytes",
                    self.length
                )));
            }
            self.value_bytes += bytes;
            if self.value_bytes > self.length.saturating_mul(MAX_SHARING).saturating_add(SMALL_VALUES) {
                return Err(corrupt("its directories announce far more than the file holds"));
            }
            // Decoders of other raw formats know where values are, and notes may be absent.
            let place = if bytes > field.len() as u64 { number(field) } else { 0 };
            if place.saturating_add(bytes) > self.length && !is_notes && (self.found.is_dng || !self.raw) {
                let end = self.length;
                return Err(corrupt(format!(
                    "the {bytes} bytes of tag {tag} begin at byte {place}, and it ends at {end}"
                )));
            }
            let single = number(&field[..field.len().min(size as usize)]);
            match tag {
                tag::NEW_SUBFILE_TYPE => is_thumbnail = single & 1 == 1,
                tag::IMAGE_WIDTH => width = single,
                tag::IMAGE_LENGTH => height = single,
                tag::COMPRESSION => compression = single,
                tag::PHOTOMETRIC if single == Sensor::PHOTOMETRIC => {
                    // The two low bytes of the value.
                    let in_front = if big_endian { size.saturating_sub(2) } else { 0 };
                    self.found.sensor.marks.push(at + (entry.len() - field.len()) as u64 + in_front);
                }
                tag::TILE_DEPTH => self.found.tile_depth = single,
                tag::MOSAIC if bytes <= 64 => self.found.sensor.pattern = self.values(bytes, size, field)?,
                tag::STRIP_OFFSETS | tag::TILE_OFFSETS => places = Some((bytes, size, field)),
                tag::STRIP_BYTE_COUNTS | tag::TILE_BYTE_COUNTS => lengths = Some((bytes, size, field)),
                tag::SUB_DIRECTORIES if self.raw && !is_notes => {
                    let places = self.values(bytes, size, field)?.into_iter().take(MAX_DIRECTORIES);
                    self.parts.extend(places.map(|at| (at, false)));
                }
                tag::EXIF | tag::GPS | tag::INTEROPERABILITY if self.raw => match kind {
                    4 if place.saturating_add(bytes) <= self.length => {
                        let places = self.values(bytes, size, field)?.into_iter().take(MAX_DIRECTORIES);
                        self.parts.extend(places.map(|at| (at, true)));
                    }
                    // Where bytes stand for a place, decoders take that of the bytes.
                    7 if bytes > field.len() as u64 => self.parts.push((place, true)),
                    7 => self.parts.push((at + (entry.len() - field.len()) as u64, true)),
                    // Decoders read the first byte of an unknown type.
                    0 | 13.. => {
                        let mut first = [field[0]];
                        if count > field.len() as u64 && number(field) < self.length {
                            read_at(self.file, number(field), &mut first)?;
                        }
                        self.parts.push((first[0].into(), true));
                    }
                    _ => self.parts.push((single, true)),
                },
                _ => {}
            }
        }
        if is_notes {
            return Ok(());
        }
        self.found.pixels = self.found.pixels.max(width.saturating_mul(height));
        // Plain pixels end where the picture does, whatever is said of their length; JPEGs have an end of their own.
        let is_checked = self.found.is_dng || !self.raw && ![UNCOMPRESSED, JPEG].contains(&compression);
        if let Some((places, lengths)) = places.zip(lengths).filter(|_| is_checked && !is_thumbnail) {
            let mut values = |(bytes, size, field)| self.values(bytes, size, field);
            let (places, lengths) = (values(places)?, values(lengths)?);
            let ends = places.iter().zip(&lengths).map(|(at, bytes)| at.saturating_add(*bytes));
            if let Some(end) = ends.max().filter(|end| *end > self.length) {
                let reason = format!("it ends before its picture data does, at byte {} of {end}", self.length);
                return Err(corrupt(reason));
            }
        }
        Ok(())
    }

    fn read_planes(&mut self, count: u64, at: u64) -> io::Result<()> {
        const PLANE_BYTES: u64 = 24;
        let end = count.saturating_mul(PLANE_BYTES).saturating_add(at);
        if end > self.length {
            let reason = format!("the numbers of {count} planes end at byte {end}, and it ends at {}", self.length);
            return Err(corrupt(reason));
        }
        let mut bytes = crate::plane::memory::zeroed::<u8>((count * PLANE_BYTES) as usize);
        read_at(self.file, at, &mut bytes)?;
        let numbers = bytes.chunks_exact(4).map(|bytes| number(self.big_endian, bytes)).collect();
        self.found.planes = Planes { count, numbers };
        Ok(())
    }

    /// Values of an entry, as whole numbers of `size` bytes. Their `bytes` have been compared with the file's length.
    fn values(&mut self, bytes: u64, size: u64, field: &[u8]) -> io::Result<Vec<u64>> {
        let mut values = crate::plane::memory::zeroed::<u8>(bytes as usize);
        match field.get(..bytes as usize) {
            Some(inline) => values.copy_from_slice(inline),
            None => read_at(self.file, number(self.big_endian, field), &mut values)?,
        }
        Ok(values.chunks_exact(size as usize).map(|value| number(self.big_endian, value)).collect())
    }
}
