//! Scans of a JPEG (ITU-T T.81, F.2 and G.2): every code is read for its length, no coefficient is computed. Of a
//! progressive picture the coefficients that are not zero are recorded, because later scans depend on that.
//!
//! A scan is read bit by bit ([`Bits`]): bytes up to a marker, in which 0xFF is followed by 0x00. Tables of Huffman
//! codes ([`Table`], annexes C and F.2.2.3) give the lengths of the codes.

use crate::plane::memory;

/// Number of coefficients of a block.
const BLOCK: usize = 64;
/// Value of `missing_bits` for a coefficient that no scan has given yet.
const NEVER: u8 = 255;

/// A component of the picture: brightness or a colour.
#[derive(Debug)]
pub(super) struct Component {
    /// Identifier in the headers of scans.
    pub id: u8,
    across: usize,
    down: usize,
    /// Number of 8×8 blocks (columns, rows) that hold pixels.
    size: (usize, usize),
    /// Blocks in a row of the picture when it is padded to whole coded units.
    stride: usize,
    /// For each block of a progressive picture: bit set of the coefficients that are not zero.
    nonzero: Vec<u64>,
    /// For each coefficient: number of low bits still to come, or `NEVER`.
    missing_bits: [u8; BLOCK],
}

impl Component {
    /// Component of `across`×`down` blocks in each coded unit.
    pub(super) fn new(id: u8, across: u8, down: u8) -> Self {
        Self {
            id,
            across: across.into(),
            down: down.into(),
            size: (0, 0),
            stride: 0,
            nonzero: Vec::new(),
            missing_bits: [NEVER; BLOCK],
        }
    }

    /// Whether the standard allows the sampling.
    pub(super) fn is_possible(&self) -> bool {
        (1..=4).contains(&self.across) && (1..=4).contains(&self.down)
    }
}

/// A picture's components.
#[derive(Debug)]
pub(super) struct Frame {
    /// Components in the order of the file.
    pub components: Vec<Component>,
    /// Coded units (columns, rows) of the picture, when all components are interleaved.
    units: (usize, usize),
    progressive: bool,
}

/// Header of a scan.
#[derive(Debug)]
pub(super) struct Scan {
    /// Index of each component, of its DC table and of its AC table.
    pub components: Vec<(usize, usize, usize)>,
    /// First coefficient.
    pub first: usize,
    /// Last coefficient.
    pub last: usize,
    /// Number of low bits that were still to come before this scan; 0 for the first one of a coefficient.
    pub high: u8,
    /// Number of low bits that are still to come after it.
    pub low: u8,
    /// Number of coded units between restart markers; 0 for none.
    pub restart_interval: usize,
}

/// Tables for DC and for AC.
type Tables<'a> = [&'a [Option<Table>; 4]; 2];

/// Reason why a block could not be read.
enum Fault {
    NoCode,
    Overfull,
}

impl Frame {
    /// A picture of `size` (columns, rows), both above 0, of possible components.
    pub(super) fn new((width, height): (usize, usize), mut components: Vec<Component>, progressive: bool) -> Self {
        let across = components.iter().map(|c| c.across).max().unwrap_or(1);
        let down = components.iter().map(|c| c.down).max().unwrap_or(1);
        let units = (width.div_ceil(8 * across), height.div_ceil(8 * down));
        if let [single] = &mut components[..] {
            // A single component is never interleaved, whatever its sampling.
            (single.across, single.down) = (1, 1);
            single.size = (width.div_ceil(8), height.div_ceil(8));
            single.stride = single.size.0;
            return Self { units: single.size, components, progressive };
        }
        for component in &mut components {
            let (own_width, own_height) =
                ((width * component.across).div_ceil(across), (height * component.down).div_ceil(down));
            component.size = (own_width.div_ceil(8), own_height.div_ceil(8));
            component.stride = units.0 * component.across;
        }
        Self { components, units, progressive }
    }

    /// Reads the data of `scan` from `start` on; returns the position of its end.
    ///
    /// # Errors
    /// A description of the damage, as the end of a sentence.
    pub(super) fn read_scan(
        &mut self,
        scan: &Scan,
        tables: Tables<'_>,
        bytes: &[u8],
        start: usize,
    ) -> Result<usize, String> {
        self.check_header(scan)?;
        // Each block takes a bit at least, except in scans of AC alone, where one code may stand for many.
        let blocks: usize = match &scan.components[..] {
            [(index, ..)] => self.components[*index].size.0 * self.components[*index].size.1,
            several => several.iter().map(|(index, ..)| self.blocks_of(*index)).sum(),
        };
        if scan.first == 0 && blocks / 8 > bytes.len().saturating_sub(start) {
            return Err(format!("its picture data is too short for {blocks} blocks"));
        }
        for (index, ..) in &scan.components {
            let count = self.blocks_of(*index);
            let component = &mut self.components[*index];
            if self.progressive && component.nonzero.is_empty() {
                component.nonzero = memory::zeroed(count);
            }
            for missing in &mut component.missing_bits[scan.first..=scan.last] {
                *missing = scan.low;
            }
        }
        let mut state =
            ScanState { scan, tables, progressive: self.progressive, bits: Bits::new(bytes, start), run: 0 };
        state.read(self, bytes)?;
        Ok(state.bits.place())
    }

    /// Number of blocks of a component, with those that pad coded units.
    fn blocks_of(&self, index: usize) -> usize {
        let component = &self.components[index];
        component.stride * self.units.1 * component.down
    }

    /// Checks that the header of a scan is possible for this picture.
    fn check_header(&self, scan: &Scan) -> Result<(), String> {
        if scan.first > scan.last || scan.last >= BLOCK {
            return Err("the header of a scan is damaged".to_owned());
        }
        let ac = scan.first > 0;
        // A refining scan comes after the scan that it refines, and every AC scan after the DC of its component.
        let before = if scan.high > 0 { scan.first } else { 0 };
        let is_begun = |index: usize| self.components[index].missing_bits[before] != NEVER;
        let possible = (1..=4).contains(&scan.components.len())
            && ((!ac && scan.high == 0) || scan.components.iter().all(|(index, ..)| is_begun(*index)))
            && scan.low < 14
            && (!self.progressive || ac || scan.last == 0)
            && (!ac || (self.progressive && scan.components.len() == 1))
            && (self.progressive || (scan.last == BLOCK - 1 && scan.high == 0 && scan.low == 0));
        if possible { Ok(()) } else { Err("the header of a scan is damaged".to_owned()) }
    }

    /// Checks that all scans came.
    ///
    /// # Errors
    /// A description of the missing scans.
    pub(super) fn check_complete(&self) -> Result<(), String> {
        let missing = |component: &Component| component.missing_bits.iter().any(|bits| *bits != 0);
        match self.components.iter().filter(|component| missing(component)).count() {
            0 => Ok(()),
            _ if self.components.iter().all(|c| c.missing_bits[0] == NEVER) => {
                Err("its picture data is missing".into())
            }
            _ if self.progressive => Err("the scans that refine the picture are missing".to_owned()),
            _ => Err("a scan is missing".to_owned()),
        }
    }
}

/// State of the reading of a scan.
struct ScanState<'a> {
    scan: &'a Scan,
    tables: Tables<'a>,
    progressive: bool,
    bits: Bits<'a>,
    /// Blocks that the last end-of-band code still covers.
    run: u32,
}

impl ScanState<'_> {
    fn read(&mut self, frame: &mut Frame, bytes: &[u8]) -> Result<(), String> {
        let single = (self.scan.components.len() == 1).then(|| self.scan.components[0].0);
        let (columns, rows) = single.map_or(frame.units, |index| frame.components[index].size);
        let units = columns * rows;
        for unit in 0..units {
            let (column, row) = (unit % columns, unit / columns);
            let restarts = unit.checked_div(self.scan.restart_interval).unwrap_or(0);
            if restarts > 0 && unit.is_multiple_of(self.scan.restart_interval) {
                self.pass_restart(bytes, restarts - 1)
                    .map_err(|reason| format!("{reason} after {row} of its {rows} rows of blocks"))?;
            }
            for &(index, dc, ac) in &self.scan.components {
                let component = &mut frame.components[index];
                let (across, down) = if single.is_some() { (1, 1) } else { (component.across, component.down) };
                for v in 0..down {
                    for u in 0..across {
                        let place = (row * down + v) * component.stride + column * across + u;
                        let mut none = 0;
                        let nonzero = if self.progressive { &mut component.nonzero[place] } else { &mut none };
                        let read = self.read_block(nonzero, dc, ac);
                        let problem = match read {
                            _ if self.bits.overran() => "its picture data ends",
                            Ok(()) => continue,
                            Err(Fault::NoCode) => "its picture data holds a code of no table",
                            Err(Fault::Overfull) => "its picture data overfills a block",
                        };
                        return Err(format!("{problem} after {row} of its {rows} rows of blocks"));
                    }
                }
            }
        }
        Ok(())
    }

    /// Skips the restart marker that follows interval `interval`.
    fn pass_restart(&mut self, bytes: &[u8], interval: usize) -> Result<(), &'static str> {
        let (marker, next) = super::marker_from(bytes, self.bits.place()).ok_or("its picture data ends")?;
        if !(0xd0..=0xd7).contains(&marker) {
            return Err("its picture data ends");
        }
        if usize::from(marker - 0xd0) != interval % 8 {
            return Err("a part of its picture data is missing");
        }
        self.bits.restart_at(next);
        self.run = 0;
        Ok(())
    }

    #[inline]
    fn read_block(&mut self, nonzero: &mut u64, dc: usize, ac: usize) -> Result<(), Fault> {
        if !self.progressive {
            self.read_dc(dc)?;
            return self.read_ac(ac, 1, BLOCK - 1);
        }
        match (self.scan.first, self.scan.high) {
            (0, 0) => self.read_dc(dc),
            (0, _) => {
                self.bits.skip(1);
                Ok(())
            }
            (_, 0) => self.read_ac_first(nonzero, ac),
            _ => self.read_ac_refinement(nonzero, ac),
        }
    }

    #[inline]
    fn symbol(&mut self, table: &Option<Table>) -> Result<u8, Fault> {
        let next = self.bits.peek16();
        let (length, symbol) = table.as_ref().and_then(|table| table.code(next)).ok_or(Fault::NoCode)?;
        self.bits.skip(length);
        Ok(symbol)
    }

    fn read_dc(&mut self, table: usize) -> Result<(), Fault> {
        let tables = self.tables;
        let size = self.symbol(&tables[0][table])?;
        if size > 15 {
            return Err(Fault::Overfull);
        }
        self.bits.skip(size.into());
        Ok(())
    }

    /// Reads all coefficients from `first` to `last`.
    fn read_ac(&mut self, table: usize, first: usize, last: usize) -> Result<(), Fault> {
        let tables = self.tables;
        let table = tables[1][table].as_ref().ok_or(Fault::NoCode)?;
        let mut k = first;
        while k <= last {
            let (length, symbol) = table.code(self.bits.peek16()).ok_or(Fault::NoCode)?;
            let (zeros, size) = (usize::from(symbol >> 4), u32::from(symbol & 15));
            self.bits.skip(length + size);
            if size == 0 && zeros < 15 {
                return Ok(());
            }
            k += zeros + 1;
        }
        if k > last + 1 { Err(Fault::Overfull) } else { Ok(()) }
    }

    /// Reads the first scan of coefficients, in which one code may end many blocks.
    fn read_ac_first(&mut self, nonzero: &mut u64, table: usize) -> Result<(), Fault> {
        if self.run > 0 {
            self.run -= 1;
            return Ok(());
        }
        let tables = self.tables;
        let mut k = self.scan.first;
        while k <= self.scan.last {
            let symbol = self.symbol(&tables[1][table])?;
            let (zeros, size) = (u32::from(symbol >> 4), u32::from(symbol & 15));
            if size == 0 {
                if zeros < 15 {
                    self.run = (1 << zeros) - 1 + self.bits.take(zeros);
                    return Ok(());
                }
                k += 16;
                continue;
            }
            k += zeros as usize;
            if k > self.scan.last {
                return Err(Fault::Overfull);
            }
            self.bits.skip(size);
            *nonzero |= 1 << k;
            k += 1;
        }
        if k > self.scan.last + 1 { Err(Fault::Overfull) } else { Ok(()) }
    }

    /// Reads a later scan of coefficients: one more bit of those that are not zero, and new ones.
    fn read_ac_refinement(&mut self, nonzero: &mut u64, table: usize) -> Result<(), Fault> {
        let tables = self.tables;
        let (mut k, last) = (self.scan.first, self.scan.last);
        if self.run == 0 {
            while k <= last {
                let symbol = self.symbol(&tables[1][table])?;
                let (mut zeros, size) = (u32::from(symbol >> 4), symbol & 15);
                if size == 0 && zeros < 15 {
                    // This block belongs to the run.
                    self.run = (1 << zeros) + self.bits.take(zeros);
                    break;
                }
                if size > 0 {
                    self.bits.skip(1); // the sign of the new coefficient
                }
                while k <= last {
                    if *nonzero >> k & 1 == 1 {
                        self.bits.skip(1);
                    } else if zeros == 0 {
                        break;
                    } else {
                        zeros -= 1;
                    }
                    k += 1;
                }
                if size > 0 {
                    if k > last {
                        return Err(Fault::Overfull);
                    }
                    *nonzero |= 1 << k;
                }
                k += 1;
            }
        }
        if self.run > 0 {
            for k in k..=last {
                self.bits.skip((*nonzero >> k & 1) as u32);
            }
            self.run -= 1;
        }
        Ok(())
    }
}

/// Length of code, bits, up to which one table look-up is enough.
const LOOK_BITS: u32 = 10;

/// The codes of one table.
#[derive(Debug, Clone)]
pub(super) struct Table {
    /// For each value of the next [`LOOK_BITS`] bits: the code's length times 256, plus its value; 0 for longer codes.
    short: Vec<u16>,
    /// For each length from 1 to 16: one more than the largest code of that length, aligned to the top of 16 bits.
    ends: [u32; 17],
    /// For each length: offset from a code to the index of its value.
    offsets: [i32; 17],
    values: Vec<u8>,
}

impl Table {
    /// Table with `counts[l − 1]` codes of length l for `values`; `None` where there are more codes than the length
    /// allows, or fewer values.
    pub(super) fn new(counts: &[u8; 16], values: &[u8]) -> Option<Self> {
        let mut table =
            Self { short: vec![0; 1 << LOOK_BITS], ends: [0; 17], offsets: [0; 17], values: values.to_vec() };
        let (mut code, mut place) = (0u32, 0usize);
        for length in 1..=16u32 {
            let count = usize::from(counts[length as usize - 1]);
            if code + count as u32 > 1 << length {
                return None;
            }
            table.offsets[length as usize] = place as i32 - code as i32;
            for value in values.get(place..place + count)? {
                if length <= LOOK_BITS {
                    let start = (code << (LOOK_BITS - length)) as usize;
                    table.short[start..start + (1 << (LOOK_BITS - length))]
                        .fill((length as u16) << 8 | u16::from(*value));
                }
                code += 1;
            }
            place += count;
            table.ends[length as usize] = code << (16 - length);
            code <<= 1;
        }
        Some(table)
    }

    /// Length and value of the code at the top of the 16 bits `next`; `None` where there is no such code.
    #[inline]
    pub(super) fn code(&self, next: u32) -> Option<(u32, u8)> {
        let short = self.short[(next >> (16 - LOOK_BITS)) as usize];
        if short != 0 {
            return Some((u32::from(short >> 8), short as u8));
        }
        let length = (LOOK_BITS as usize + 1..=16).find(|length| next < self.ends[*length])?;
        let place = (next >> (16 - length)) as i32 + self.offsets[length];
        Some((length as u32, *self.values.get(usize::try_from(place).ok()?)?))
    }
}

/// Reader of bits. After the last one it returns zeros without end, and counts them.
#[derive(Debug)]
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    /// Index of the next byte; at the marker once there are no more.
    at: usize,
    /// Next bits, the first one at the top.
    buffer: u64,
    /// Number of bits in the buffer, padding included.
    held: u32,
    /// Number of padding bits; more than `held` once one was used.
    made_up: u32,
    ended: bool,
}

impl<'a> Bits<'a> {
    /// The bits of `bytes` from `at` on.
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, buffer: 0, held: 0, made_up: 0, ended: false }
    }

    /// Whether padding bits were used.
    #[inline]
    pub(super) fn overran(&self) -> bool {
        self.made_up > self.held
    }

    /// Position at or before the marker that ends the data, and after all markers before it.
    pub(super) fn place(&self) -> usize {
        self.at
    }

    /// Starts again at `at`, as after a restart marker.
    pub(super) fn restart_at(&mut self, at: usize) {
        *self = Self::new(self.bytes, at);
    }

    /// Fills the buffer with at least 32 bits.
    #[inline]
    fn fill(&mut self) {
        if self.held > 32 {
            return;
        }
        if let Some(next) = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<4>()) {
            let word = u32::from_be_bytes(*next);
            // No byte of the word is 0xFF: none of the complement is 0.
            let complement = !word;
            let has_ff = complement.wrapping_sub(0x0101_0101) & !complement & 0x8080_8080 != 0;
            if !has_ff && !self.ended {
                self.buffer |= u64::from(word) << (32 - self.held);
                (self.held, self.at) = (self.held + 32, self.at + 4);
                return;
            }
        }
        self.fill_slowly();
    }

    #[cold]
    fn fill_slowly(&mut self) {
        while self.held <= 32 {
            let byte = match self.bytes.get(self.at) {
                _ if self.ended => None,
                Some(0xff) if self.bytes.get(self.at + 1) == Some(&0) => Some((0xff, 2)),
                Some(0xff) | None => None, // a marker, or the end of the file
                Some(byte) => Some((*byte, 1)),
            };
            match byte {
                Some((byte, length)) => {
                    self.buffer |= u64::from(byte) << (56 - self.held);
                    (self.held, self.at) = (self.held + 8, self.at + length);
                }
                None => {
                    self.ended = true;
                    self.made_up = self.made_up.saturating_add(32);
                    self.held += 32;
                }
            }
        }
    }

    /// Next 16 bits, without consuming them.
    #[inline]
    pub(super) fn peek16(&mut self) -> u32 {
        self.fill();
        (self.buffer >> 48) as u32
    }

    /// Skips `count` bits, at most 32 (after a peek: 16 of the code and 16 of its value).
    #[inline]
    pub(super) fn skip(&mut self, count: u32) {
        self.fill();
        self.buffer <<= count;
        self.held -= count;
    }

    /// Consumes and returns the next `count` bits, at most 16.
    #[inline]
    pub(super) fn take(&mut self, count: u32) -> u32 {
        let value = self.peek16() >> (16 - count);
        self.skip(count);
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_every_length_are_found() {
        // The table of T.81, K.3.1 has codes of 2 to 9 bits; this one goes on to 12.
        let mut counts = [0; 16];
        counts[1] = 1; // 00
        counts[2] = 2; // 010, 011
        counts[11] = 2; // 100000000000, 100000000001
        let table = Table::new(&counts, &[7, 8, 9, 10, 11]).expect("a table");
        assert_eq!(table.code(0b0011_1111_1111_1111), Some((2, 7)));
        assert_eq!(table.code(0b0100_0000_0000_0000), Some((3, 8)));
        assert_eq!(table.code(0b0111_1111_1111_1111), Some((3, 9)));
        assert_eq!(table.code(0b1000_0000_0000_1111), Some((12, 10)));
        assert_eq!(table.code(0b1000_0000_0001_0000), Some((12, 11)));
        assert_eq!(table.code(0b1000_0000_0010_0000), None);
        assert_eq!(table.code(0xffff), None);
        assert!(Table::new(&[3; 16], &[0; 48]).is_none(), "three codes of one bit");
    }

    #[test]
    fn stuffed_bytes_and_the_end_are_seen() {
        let bytes = [0x12, 0xff, 0x00, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xff, 0xd9, 0x11];
        let mut bits = Bits::new(&bytes, 0);
        assert_eq!([4, 4, 8, 16].map(|count| bits.take(count)), [1, 2, 0xff, 0x3456]);
        bits.skip(20);
        assert_eq!((bits.take(4), bits.overran(), bits.place()), (0xc, false, 8));
        assert_eq!((bits.take(1), bits.overran()), (0, true));
        let mut bits = Bits::new(&bytes[..2], 0);
        // A lone 0xFF at the end of a file is no data.
        bits.skip(8);
        assert!(!bits.overran());
        bits.skip(1);
        assert!(bits.overran());
    }
}
