//! Pages with the mosaic of a sensor, as TIFF/EP (ISO 12234-2) has them. Their samples are those of grey, but the
//! library (tiff 0.11.3) refuses their photometric interpretation: it reads that of grey in its place.

use crate::burst::layout::Mosaic;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};

#[derive(Debug, Default, Clone)]
pub(super) struct Sensor {
    /// Positions in the file of the photometric interpretations that say that there is one, of two bytes each.
    pub marks: Vec<u64>,
    /// Colours of a square, row by row: 0 red, 1 green, 2 blue. Empty where none are given.
    pub pattern: Vec<u64>,
}

impl Sensor {
    pub(super) const PHOTOMETRIC: u64 = 0x8023;

    pub(super) fn mosaic(&self) -> Result<Option<Mosaic>, &'static str> {
        let square = (self.pattern.len() == 4).then(|| Mosaic::of(|u, v| self.pattern[2 * v + u] as usize));
        match (square.flatten(), self.pattern.len()) {
            _ if self.marks.is_empty() => Ok(None),
            (Some(mosaic), _) => Ok(Some(mosaic)),
            (None, 0) => Err("its mosaic of colours has no pattern; say it, such as --mosaic rggb, or none"),
            _ => Err("its mosaic is not of two green, a red and a blue pixel; --mosaic none opens it as it is"),
        }
    }
}

pub(super) struct AsGrey {
    file: BufReader<File>,
    at: u64,
    pub(super) sensor: Sensor,
    is_big_endian: bool,
}

impl AsGrey {
    pub(super) fn new(mut file: BufReader<File>, mut sensor: Sensor) -> io::Result<Self> {
        file.rewind()?;
        sensor.marks.sort_unstable();
        let is_big_endian = file.fill_buf()?.starts_with(b"MM");
        Ok(Self { file, at: 0, sensor, is_big_endian })
    }
}

impl Read for AsGrey {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        const GREY: u16 = 1;
        let count = self.file.read(buffer)?;
        let bytes = if self.is_big_endian { GREY.to_be_bytes() } else { GREY.to_le_bytes() };
        // A file may have a million marks, and each read meets few.
        let first = self.sensor.marks.partition_point(|mark| mark + 1 < self.at);
        let met = self.sensor.marks[first..].iter().take_while(|mark| **mark < self.at + count as u64);
        for (place, byte) in met.flat_map(|mark| [(*mark, bytes[0]), (mark + 1, bytes[1])]) {
            if let Some(read) = place.checked_sub(self.at).and_then(|k| buffer[..count].get_mut(k as usize)) {
                *read = byte;
            }
        }
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for AsGrey {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = self.file.seek(to)?;
        Ok(self.at)
    }
}
