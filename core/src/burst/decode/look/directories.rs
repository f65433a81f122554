//! The directories of a TIFF file, and of raw files that are TIFFs by their structure (DNG, NEF, CR2, ARW and others).
//!
//! A directory is a list of entries: a tag, a type, a count of values, and the values or their place. A decoder that
//! trusts the count allocates memory for four thousand million values of a file of two hundred bytes. Here every count
//! is compared with the file's length, and only a few numbers of each directory are kept.

use super::{Refusal, read_at};
use std::collections::HashSet;
use std::io::{Read, Seek};

/// Maximum number of directories that are read; a burst has fewer frames.
const MAX_DIRECTORIES: usize = 1 << 14;
/// Maximum number of entries of all directories together: real files have some tens a directory.
const MAX_ENTRIES: usize = 1 << 20;
/// Longest text allowed, bytes: decoders read texts whole.
pub(in crate::burst::decode) const MAX_TEXT_BYTES: u64 = 1 << 26;
/// Largest total of all entries' values, as a multiple of the file's length: several entries may share a place.
const MAX_SHARING: u64 = 4;
/// Further allowance for the values of all entries, bytes: for small files.
const SMALL_VALUES: u64 = 1 << 24;

/// Tags that are understood here.
mod tag {
    pub(super) const NEW_SUBFILE_TYPE: u16 = 254;
    pub(super) const IMAGE_WIDTH: u16 = 256;
    pub(super) const IMAGE_LENGTH: u16 = 257;
    pub(super) const IMAGE_DESCRIPTION: u16 = 270;
    pub(super) const STRIP_OFFSETS: u16 = 273;
    pub(super) const STRIP_BYTE_COUNTS: u16 = 279;
    pub(super) const TILE_OFFSETS: u16 = 324;
    pub(super) const TILE_BYTE_COUNTS: u16 = 325;
    pub(super) const SUB_DIRECTORIES: u16 = 330;
    pub(super) const EXIF: u16 = 34665;
    pub(super) const GPS: u16 = 34853;
    pub(super) const INTEROPERABILITY: u16 = 40965;
    pub(super) const DNG_VERSION: u16 = 50706;
    /// The standard's tags are below this one; those from here on are private.
    pub(super) const PRIVATE: u16 = 32768;
}

/// The values of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Values {
    kind: u16,
    count: u64,
    /// Position in the file; `None` where the values are in the entry itself.
    at: Option<u64>,
    /// The entry's own field, where it holds the values.
    inline: [u8; 8],
}

impl Values {
    fn bytes(&self) -> u64 {
        self.count.saturating_mul(size_of_kind(self.kind))
    }
}

/// The numbers that are kept of a directory.
#[derive(Debug, Default)]
pub(in crate::burst::decode) struct Directory {
    /// Columns; 0 where not given.
    pub width: u64,
    /// Rows; 0 where not given.
    pub height: u64,
    /// Whether it is marked as a smaller copy of another.
    pub is_thumbnail: bool,
    /// Position and length of its description, bytes.
    description: Option<(u64, u64)>,
    /// Positions of the strips or tiles, and their lengths.
    chunks: [Option<Values>; 2],
}

/// The directories of a file.
#[derive(Debug)]
pub(in crate::burst::decode) struct Directories {
    /// Pages and the directories that they refer to, in the order in which they are found.
    pub list: Vec<Directory>,
    /// Whether the first one is marked as that of a DNG.
    pub is_dng: bool,
    big_endian: bool,
}

/// Announced position of a directory.
#[derive(Debug, Clone, Copy)]
struct Pointer {
    at: u64,
    /// Whether it is one of the file's pages, and another may follow it.
    in_chain: bool,
    /// Whether it holds notes (EXIF): the data that they refer to may be absent, and decoders skip it.
    is_notes: bool,
}

impl Directories {
    /// Reads at most `most` pages of `file`, a TIFF of `length` bytes. A file that is `raw` by its name, or a DNG, must
    /// hold all values of all its directories of pictures.
    ///
    /// # Errors
    /// [`Refusal`] of a file that announces more than it can hold, or that cannot be read.
    pub(in crate::burst::decode) fn read(
        file: &mut (impl Read + Seek),
        length: u64,
        raw: bool,
        most: usize,
    ) -> Result<Self, Refusal> {
        let mut start = [0; 16];
        let have = start.len().min(usize::try_from(length).unwrap_or(usize::MAX));
        read_at(file, 0, &mut start[..have])?;
        let big_endian = start[0] == b'M';
        let numbers = Numbers { big_endian };
        let big = numbers.u16(&start[2..4]) == 43;
        let first = if big { numbers.u64(&start[8..16]) } else { u64::from(numbers.u32(&start[4..8])) };
        let found = Self { list: Vec::new(), is_dng: false, big_endian };
        let mut walk =
            Walk { file, length, numbers, big, raw, entries: 0, value_bytes: 0, seen: HashSet::new(), found };
        walk.read_all(first, most.min(MAX_DIRECTORIES))?;
        Ok(walk.found)
    }

    /// Largest size (columns × rows) that a directory announces.
    pub(in crate::burst::decode) fn pixels(&self) -> u64 {
        self.list.iter().map(|d| d.width.saturating_mul(d.height)).max().unwrap_or(0)
    }

    /// Beginning of the first page's description; at most `most` bytes of it.
    pub(in crate::burst::decode) fn description(&self, file: &mut (impl Read + Seek), most: usize) -> Option<String> {
        let (at, length) = self.list.first()?.description?;
        let mut bytes = vec![0; most.min(usize::try_from(length).ok()?)];
        read_at(file, at, &mut bytes).ok()?;
        bytes.truncate(bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len()));
        Some(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Checks that all strips and tiles of full pictures lie in the file of `length` bytes.
    ///
    /// # Errors
    /// [`Refusal`] of a file that ends before one of them.
    pub(in crate::burst::decode) fn check_chunks(
        &self,
        file: &mut (impl Read + Seek),
        length: u64,
    ) -> Result<(), Refusal> {
        let numbers = Numbers { big_endian: self.big_endian };
        for directory in self.list.iter().filter(|d| !d.is_thumbnail) {
            let [Some(places), Some(lengths)] = directory.chunks else { continue };
            let (places, lengths) = (numbers.list(file, places)?, numbers.list(file, lengths)?);
            let end = places.iter().zip(&lengths).map(|(at, bytes)| at.saturating_add(*bytes)).max();
            if end.is_some_and(|end| end > length) {
                return Err(Refusal::corrupt("it ends before its picture data does"));
            }
        }
        Ok(())
    }
}

/// Numbers in the file's byte order.
#[derive(Debug, Clone, Copy)]
struct Numbers {
    big_endian: bool,
}

impl Numbers {
    fn u16(self, bytes: &[u8]) -> u16 {
        let bytes = [bytes[0], bytes[1]];
        if self.big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) }
    }

    fn u32(self, bytes: &[u8]) -> u32 {
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
    }

    fn u64(self, bytes: &[u8]) -> u64 {
        let (a, b) = (u64::from(self.u32(bytes)), u64::from(self.u32(&bytes[4..])));
        if self.big_endian { a << 32 | b } else { b << 32 | a }
    }

    /// `bytes` as whole numbers of the type `kind`; none for other types.
    fn of_bytes(self, kind: u16, bytes: &[u8]) -> impl Iterator<Item = u64> {
        let size = match kind {
            1 | 3 | 4 | 13 | 16 | 18 => size_of_kind(kind) as usize,
            _ => usize::MAX,
        };
        bytes.chunks_exact(size).map(move |value| match size {
            1 => u64::from(value[0]),
            2 => u64::from(self.u16(value)),
            4 => u64::from(self.u32(value)),
            _ => self.u64(value),
        })
    }

    /// Values of an entry, as whole numbers. Its count has been compared with the file's length.
    fn list(self, file: &mut (impl Read + Seek), values: Values) -> Result<Vec<u64>, Refusal> {
        let Some(at) = values.at else {
            let inline = &values.inline[..values.bytes() as usize];
            return Ok(self.of_bytes(values.kind, inline).collect());
        };
        let mut bytes = crate::plane::memory::zeroed::<u8>(values.bytes() as usize);
        read_at(file, at, &mut bytes)?;
        Ok(self.of_bytes(values.kind, &bytes).collect())
    }
}

/// Bytes of a value of each type; 1 for unknown types, as decoders take them.
fn size_of_kind(kind: u16) -> u64 {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16 | 17 | 18 => 8,
        _ => 1,
    }
}

fn is_known(kind: u16) -> bool {
    (1..=13).contains(&kind) || (16..=18).contains(&kind)
}

/// State of the walk through a file.
struct Walk<'a, R> {
    file: &'a mut R,
    length: u64,
    numbers: Numbers,
    big: bool,
    /// Whether the file is raw, by its name or as a DNG: its decoder reads all data that its directories refer to.
    raw: bool,
    entries: usize,
    value_bytes: u64,
    seen: HashSet<u64>,
    found: Directories,
}

impl<R: Read + Seek> Walk<'_, R> {
    fn read_all(&mut self, first: u64, most: usize) -> Result<(), Refusal> {
        let mut next = Some(Pointer { at: first, in_chain: true, is_notes: false });
        let (mut pages, mut others) = (0, 0);
        while let Some(page) = next.filter(|_| pages < most) {
            if !self.seen.insert(page.at) {
                return Err(Refusal::corrupt("its list of pages leads back to itself"));
            }
            let mut pointed_at = Vec::new();
            next = self.read_directory(page, &mut pointed_at)?;
            pages += 1;
            while let Some(pointer) = pointed_at.pop() {
                others += 1;
                // Two directories may refer to the same one; a cycle ends here too.
                if others < MAX_DIRECTORIES && self.seen.insert(pointer.at) {
                    self.read_directory(pointer, &mut pointed_at)?;
                }
            }
        }
        Ok(())
    }

    /// Reads the directory at `pointer`; returns the position of the next page, and adds the directories that it refers
    /// to to `pointed_at`.
    fn read_directory(&mut self, pointer: Pointer, pointed_at: &mut Vec<Pointer>) -> Result<Option<Pointer>, Refusal> {
        let Some((entries, next)) = self.table_at(pointer)? else { return Ok(None) };
        let entry_bytes = if self.big { 20 } else { 12 };
        let tags = entries.chunks_exact(entry_bytes).map(|entry| self.numbers.u16(entry));
        if self.found.list.is_empty() && tags.into_iter().any(|tag| tag == tag::DNG_VERSION) {
            (self.found.is_dng, self.raw) = (true, true);
        }
        let mut directory = Directory::default();
        for entry in entries.chunks_exact(entry_bytes) {
            let tag = self.numbers.u16(entry);
            let values = self.values_of(entry);
            self.check(tag, values, pointer)?;
            let single = self.single(entry);
            match tag {
                tag::NEW_SUBFILE_TYPE => directory.is_thumbnail = single & 1 == 1,
                tag::IMAGE_WIDTH => directory.width = single,
                tag::IMAGE_LENGTH => directory.height = single,
                tag::IMAGE_DESCRIPTION => directory.description = values.at.map(|at| (at, values.count)),
                tag::STRIP_OFFSETS | tag::TILE_OFFSETS => directory.chunks[0] = Some(values),
                tag::STRIP_BYTE_COUNTS | tag::TILE_BYTE_COUNTS => directory.chunks[1] = Some(values),
                tag::SUB_DIRECTORIES if self.raw && !pointer.is_notes => {
                    let places = self.numbers.list(self.file, values)?.into_iter().take(MAX_DIRECTORIES);
                    pointed_at.extend(places.map(|at| Pointer { at, in_chain: false, is_notes: false }));
                }
                tag::EXIF | tag::GPS | tag::INTEROPERABILITY if self.raw => {
                    pointed_at.push(Pointer { at: single, in_chain: false, is_notes: true });
                }
                _ => {}
            }
        }
        if !pointer.is_notes {
            self.found.list.push(directory);
        }
        Ok((pointer.in_chain && next != 0).then_some(Pointer { at: next, ..pointer }))
    }

    /// Entries of a directory, and the position of the next page; `None` for notes that are absent.
    fn table_at(&mut self, pointer: Pointer) -> Result<Option<(Vec<u8>, u64)>, Refusal> {
        let (count_bytes, entry_bytes, offset_bytes) = if self.big { (8, 20, 8) } else { (2, 12, 4) };
        let left = self.length.saturating_sub(pointer.at);
        let mut head = [0; 8];
        let mut bytes = None;
        if left >= count_bytes {
            read_at(self.file, pointer.at, &mut head[..count_bytes as usize])?;
            let count = if self.big { self.numbers.u64(&head) } else { u64::from(self.numbers.u16(&head)) };
            bytes = count
                .checked_mul(entry_bytes)
                .filter(|bytes| bytes.checked_add(count_bytes + offset_bytes).is_some_and(|all| all <= left));
        }
        let bytes = match bytes {
            Some(bytes) => bytes,
            None if pointer.is_notes => return Ok(None),
            None if left == 0 => return Err(Refusal::corrupt("its list of pages leads beyond its end")),
            None => return Err(Refusal::corrupt("it ends too early, within a directory")),
        };
        self.entries = self.entries.saturating_add((bytes / entry_bytes) as usize);
        if self.entries > MAX_ENTRIES {
            return Err(Refusal::corrupt(format!("its directories have more than {MAX_ENTRIES} entries")));
        }
        let mut table = vec![0; (bytes + offset_bytes) as usize];
        read_at(self.file, pointer.at + count_bytes, &mut table)?;
        let next = &table[bytes as usize..];
        let next = if self.big { self.numbers.u64(next) } else { u64::from(self.numbers.u32(next)) };
        table.truncate(bytes as usize);
        Ok(Some((table, next)))
    }

    /// Type, count and place of the values of `entry`.
    fn values_of(&self, entry: &[u8]) -> Values {
        let kind = self.numbers.u16(&entry[2..]);
        let (count, field, room) = if self.big {
            (self.numbers.u64(&entry[4..]), self.numbers.u64(&entry[12..]), 8)
        } else {
            (u64::from(self.numbers.u32(&entry[4..])), u64::from(self.numbers.u32(&entry[8..])), 4)
        };
        let values = Values { kind, count, at: None, inline: [0; 8] };
        if values.bytes() > room {
            return Values { at: Some(field), ..values };
        }
        let mut inline = [0; 8];
        inline[..room as usize].copy_from_slice(&entry[entry.len() - room as usize..]);
        Values { inline, ..values }
    }

    /// Value of an entry with one whole number; 0 for others.
    fn single(&self, entry: &[u8]) -> u64 {
        match self.values_of(entry) {
            values @ Values { count: 1, at: None, .. } => {
                self.numbers.of_bytes(values.kind, &values.inline).next().unwrap_or(0)
            }
            _ => 0,
        }
    }

    fn check(&mut self, tag: u16, values: Values, pointer: Pointer) -> Result<(), Refusal> {
        let bytes = values.bytes();
        if bytes > self.length {
            return Err(Refusal::corrupt(format!(
                "tag {tag} announces {} values of {} bytes each, and the file has {} bytes",
                values.count,
                size_of_kind(values.kind),
                self.length
            )));
        }
        const TEXT: u16 = 2;
        if values.kind == TEXT && bytes > MAX_TEXT_BYTES {
            return Err(Refusal::TooLarge {
                found: format!("tag {tag} is a text of {} MiB", bytes >> 20),
                limit: format!("{} MiB", MAX_TEXT_BYTES >> 20),
            });
        }
        self.value_bytes = self.value_bytes.saturating_add(bytes);
        if self.value_bytes > self.length.saturating_mul(MAX_SHARING).saturating_add(SMALL_VALUES) {
            return Err(Refusal::corrupt("its directories announce far more than the file holds"));
        }
        let is_read = is_known(values.kind) && !pointer.is_notes && (self.raw || tag < tag::PRIVATE);
        if is_read && values.at.is_some_and(|at| at.saturating_add(bytes) > self.length) {
            return Err(Refusal::corrupt(format!("it ends before the values of tag {tag}")));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Cursor;

    const LONG: u16 = 4;

    /// TIFF of one directory after `before` bytes of other data, with entries (tag, type, count, value).
    fn tiff(entries: &[(u16, u16, u32, u32)], before: usize) -> Vec<u8> {
        let mut bytes = b"II*\0".to_vec();
        bytes.extend((8 + before as u32).to_le_bytes());
        bytes.resize(8 + before, 7);
        bytes.extend((entries.len() as u16).to_le_bytes());
        for (tag, kind, count, value) in entries {
            bytes.extend(
                [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat(),
            );
        }
        bytes.extend([0; 4]);
        bytes
    }

    /// BigTIFF of one directory, most significant byte first.
    fn big_tiff(entries: &[(u16, u16, u64, u64)], before: usize) -> Vec<u8> {
        let mut bytes = b"MM\0+\0\x08\0\0".to_vec();
        bytes.extend((16 + before as u64).to_be_bytes());
        bytes.resize(16 + before, 7);
        bytes.extend((entries.len() as u64).to_be_bytes());
        for (tag, kind, count, value) in entries {
            bytes.extend(
                [&tag.to_be_bytes()[..], &kind.to_be_bytes(), &count.to_be_bytes(), &value.to_be_bytes()].concat(),
            );
        }
        bytes.extend([0; 8]);
        bytes
    }

    fn read(bytes: &[u8], raw: bool) -> Result<Directories, Refusal> {
        Directories::read(&mut Cursor::new(bytes), bytes.len() as u64, raw, usize::MAX)
    }

    /// Reason why a file is refused.
    fn reason(bytes: &[u8], raw: bool) -> String {
        match read(bytes, raw) {
            Err(Refusal::Corrupt(reason)) => reason,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn sizes_and_descriptions_are_read_in_both_forms_and_byte_orders() {
        let little = tiff(&[(256, LONG, 1, 40), (257, LONG, 1, 30), (270, 2, 6, 8)], 6);
        let big = big_tiff(&[(256, LONG, 1, 40 << 32), (257, 3, 1, 30 << 48), (270, 2, 12, 16)], 12);
        for bytes in [little, big] {
            let found = read(&bytes, false).expect("sound");
            assert_eq!((found.pixels(), found.is_dng, found.list.len()), (1200, false, 1));
            let text = found.description(&mut Cursor::new(&bytes), 4);
            assert_eq!(text.as_deref(), Some("\x07\x07\x07\x07"));
        }
    }

    #[test]
    fn counts_beyond_the_file_are_refused() {
        // A file of 226 bytes whose decoder asks for 34 GB.
        for kind in [1, 2, 5, 7, 10, 12, 99] {
            for raw in [true, false] {
                let bytes = tiff(&[(256, LONG, 1, 4), (33434, kind, u32::MAX, 8)], 180);
                let reason = reason(&bytes, raw);
                assert!(reason.contains("4294967295 values") && reason.contains("tag 33434"), "{reason}");
            }
        }
        let reason = reason(&big_tiff(&[(270, 2, 4 << 30, 16)], 10), false);
        assert!(reason.contains("tag 270"), "{reason}");
        // A text that is as long as a long file is too long as well.
        let bytes = tiff(&[(270, 2, 1 << 27, 8)], 0);
        let length = 1 << 30;
        let refused = Directories::read(&mut Cursor::new(&bytes), length, false, 1).expect_err("128 MiB of text");
        assert!(matches!(refused, Refusal::TooLarge { .. }), "{refused:?}");
    }

    #[test]
    fn values_behind_the_end_are_refused_where_somebody_reads_them() {
        let beyond = |tag| tiff(&[(tag, LONG, 9, 100)], 90);
        assert!(reason(&beyond(273), false).contains("it ends before the values of tag 273"));
        // A damaged private tag does not spoil a TIFF; the decoder of raw files reads every tag.
        assert!(read(&beyond(50000), false).is_ok());
        assert!(reason(&beyond(50000), true).contains("tag 50000"));
        // So it is for a DNG, whatever its name.
        let dng = tiff(&[(50000, LONG, 9, 100), (50706, 1, 4, 1)], 60);
        assert!(reason(&dng, false).contains("tag 50000"));
    }

    #[test]
    fn circles_and_places_behind_the_end_are_refused() {
        let mut bytes = tiff(&[(256, LONG, 1, 4)], 0);
        let next = bytes.len() - 4;
        bytes[next..].copy_from_slice(&8u32.to_le_bytes());
        assert!(reason(&bytes, false).contains("back to itself"));
        bytes[next..].copy_from_slice(&9999u32.to_le_bytes());
        assert!(reason(&bytes, false).contains("beyond its end"));
        for cut in 8..bytes.len() {
            assert!(read(&bytes[..cut], false).is_err(), "cut at {cut}");
        }
        // A directory that names itself as its part is read once.
        let own = tiff(&[(330, LONG, 1, 8)], 0);
        assert_eq!(read(&own, true).expect("no circle of pages").list.len(), 1);
        // Many entries that share a long place.
        let many = tiff(&vec![(50000, 1, 1 << 20, 8); 4000], 1 << 20);
        assert!(reason(&many, false).contains("far more than the file holds"));
    }

    #[test]
    fn strips_lie_within_the_file() {
        let check = |offset: u32, length: u32| {
            let bytes = tiff(&[(273, LONG, 1, offset), (279, LONG, 1, length)], 50);
            let found = read(&bytes, true).expect("sound");
            found.check_chunks(&mut Cursor::new(&bytes), bytes.len() as u64)
        };
        assert!(check(8, 50).is_ok());
        assert!(check(8, 5000).is_err() && check(u32::MAX, u32::MAX).is_err());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.max(400), ..ProptestConfig::default() })]

        /// Any answer is right; the data that is read and kept is bounded by the file.
        #[test]
        fn damaged_directories_are_looked_through(
            entries in prop::collection::vec((prop_oneof![254..300u16, 320..335u16, Just(34665), Just(50706), any::<u16>()], 0..20u16, prop_oneof![0..9u32, any::<u32>()], prop_oneof![0..300u32, any::<u32>()]), 0..12),
            before in 0..64usize,
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
            is_big in any::<bool>(),
            raw in any::<bool>(),
            claimed in prop_oneof![Just(0u64), 0..1u64 << 40],
        ) {
            let mut bytes = if is_big {
                let wide: Vec<_> = entries.iter().map(|&(t, k, c, v)| (t, k, u64::from(c) << (v % 40), u64::from(v) << (c % 40))).collect();
                big_tiff(&wide, before)
            } else {
                tiff(&entries, before)
            };
            for (place, value) in changes {
                let place = place.index(bytes.len());
                bytes[place] = value;
            }
            // A file may become shorter between two reads.
            let length = (bytes.len() as u64).max(claimed.min(1 << 20));
            let mut file = Cursor::new(&bytes);
            if let Ok(found) = Directories::read(&mut file, length, raw, usize::MAX) {
                let _ = found.check_chunks(&mut file, length);
                let text = found.description(&mut file, 100);
                prop_assert!(text.is_none_or(|text| text.len() <= 300));
                prop_assert!(found.list.len() <= bytes.len());
            }
        }
    }
}
