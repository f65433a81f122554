//! Frames that lie in a file as plain numbers, at known places, as in `.npy`, `.npz`, FITS, SER, Y4M and files without
//! header. Each is read in blocks, several at a time. No memory is taken for frames that a file only announces.

use super::confined::{self, Budget};
use super::pixels::{Curve, grey_from_interleaved, grey_from_planes};
use super::tiles::Tiles;
use super::{Declared, FileScale, RawFrame, Reading, Ticker, confined::wire::Part, frame_of_plane, in_order};
use crate::burst::layout::{Mosaic, ViewGrid};
use crate::burst::number::{Number, Scaling};
use crate::burst::options::{Encoding, Limits, OpenOptions};
use crate::burst::times::Times;
use crate::error::{Error, Result};
use crate::plane::{Plane, memory};
use std::io::{self, Read, Seek, SeekFrom};
use std::{fs::File, ops::Range, path::Path};
use zip::ZipArchive;

/// Bytes read and converted at once: whole numbers and groups of packed ones of every size, few enough for the cache.
const BLOCK_BYTES: usize = 15 << 14;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Index {
    Frame,
    Row,
    Column,
    Colour,
}

#[derive(Debug, Clone)]
pub enum Places {
    /// One after the other, in steps from the first one on: however many are announced, they take no memory.
    Even { first: u64, step: u64, count: u64 },
    /// Those that were seen in the file.
    Listed(Vec<u64>),
}

impl Places {
    pub fn len(&self) -> usize {
        match self {
            Self::Even { count, .. } => usize::try_from(*count).unwrap_or(usize::MAX),
            Self::Listed(places) => places.len(),
        }
    }

    pub fn at(&self, t: usize) -> u64 {
        match self {
            Self::Even { first, step, .. } => first + t as u64 * step,
            Self::Listed(places) => places[t],
        }
    }

    fn part(self, range: Range<usize>) -> Self {
        match self {
            Self::Even { step, .. } => Self::Even { first: self.at(range.start), step, count: range.len() as u64 },
            Self::Listed(places) => Self::Listed(places[range].to_vec()),
        }
    }
}

#[derive(Debug, Clone)]
pub struct Plain {
    pub kind: &'static str,
    /// Size (columns, rows) of a frame.
    pub size: (usize, usize),
    /// Place of each frame's first byte; in an archive, from the start of its member; of an image in tiles, its number.
    pub places: Places,
    pub number: Number,
    pub big_endian: bool,
    /// Samples of a pixel, side by side: 1, or 3 (colours) or 4 (with alpha).
    pub channels: usize,
    pub is_bgr: bool,
    /// Value that is full scale; `None` for floats and long integers.
    pub white: Option<f32>,
    /// Conversion of numbers to values, where these differ.
    pub scaling: Option<Scaling>,
    /// Whether values are encoded for screens.
    pub is_encoded: bool,
    pub mosaic: Option<Mosaic>,
    pub times: Times,
    pub views: Option<ViewGrid>,
    pub taken: Vec<String>,
    /// Lengths of an array whose frames do not follow one another, the fastest index first; empty for others.
    pub scattered: Vec<(Index, usize)>,
    /// Index of the member of an archive that holds the pixels.
    pub member: Option<usize>,
    /// Bytes, or tiles' layers, from one colour of a frame to the next, where its colours are planes; 0 for others.
    pub planes: u64,
    pub tiles: Option<Tiles>,
}

impl Plain {
    pub fn new(kind: &'static str, size: (usize, usize), places: Places, number: Number) -> Self {
        Self {
            kind,
            size,
            places,
            number,
            big_endian: false,
            channels: 1,
            is_bgr: false,
            white: number.range(),
            scaling: None,
            is_encoded: false,
            mosaic: None,
            times: Times::default(),
            views: None,
            taken: Vec::new(),
            scattered: Vec::new(),
            member: None,
            planes: 0,
            tiles: None,
        }
    }

    pub fn declared(self) -> Declared {
        let samples = self.white.map_or_else(|| self.number.words(), |white| FileScale::Range(white).samples());
        let declared =
            Declared::new(self.kind, self.size, self.places.len(), samples, self.channels > 2 || self.planes > 0);
        let Self { mosaic, times, views, taken, .. } = self;
        Declared { mosaic, times, views, taken, ..declared }
    }

    /// These frames, or the part of `--take`.
    pub fn part(mut self, path: &Path, options: &OpenOptions) -> Result<Self> {
        if options.take.is_none() {
            return Ok(self);
        }
        if !self.scattered.is_empty() {
            let reason = "its frames are not one after the other, so no part of them can be taken; save [N,H,W]";
            return Err(Error::unsupported(path, self.kind, reason));
        }
        let range = options.taken_of(path, self.places.len(), self.size)?;
        if self.times.seconds.len() == self.places.len() {
            self.times.seconds = self.times.seconds[range.clone()].to_vec();
        }
        Ok(Self { places: self.places.part(range), views: None, ..self })
    }

    pub fn frame_bytes(&self) -> u64 {
        self.number.bytes(self.samples() as u64)
    }

    fn samples(&self) -> usize {
        self.size.0 * self.size.1 * self.channels
    }

    pub fn only(&self, reading: Reading<'_>) -> Result<RawFrame> {
        if self.places.len() != 1 {
            return Err(Error::stack_among_frames(reading.path, self.places.len()));
        }
        reading.check(self.size)?;
        Ok(self.stack(Reading { ticker: &Ticker::new(&reading.ticker.monitor().silent(), 1), ..reading })?.remove(0))
    }

    pub fn stack(&self, reading: Reading<'_>) -> Result<Vec<RawFrame>> {
        let path = reading.path;
        if self.planes > 0 {
            return self.merged(reading);
        }
        let fail = |e: io::Error| Error::from_read(path, self.kind, &e);
        let all = |from: &mut dyn Read| match self.scattered[..] {
            [] => (0..self.places.len()).map(|t| self.read(reading, t, from)).collect(),
            _ => self.read_scattered(reading, from),
        };
        if let Some(tiles) = &self.tiles {
            return self.unpacked(reading, tiles);
        }
        if let Some(member) = self.member {
            let mut archive = ZipArchive::new(File::open(path).map_err(fail)?).map_err(|e| fail(e.into()))?;
            let mut reader = archive.by_index(member).map_err(|e| fail(e.into()))?;
            let length = reader.size();
            // The checksum is compared at the member's end: all is read, and nothing may follow.
            let mut whole = (&mut reader).take(length);
            skip(reading, &mut whole, self.places.at(0)).map_err(fail)?;
            let frames = all(&mut whole)?;
            reading.ticker.check()?;
            skip(reading, &mut whole, u64::MAX).map_err(fail)?;
            // A cancelled skip ends early, which is no damage of the file.
            reading.ticker.check()?;
            if whole.limit() > 0 || reader.read(&mut [0]).map_err(fail)? > 0 {
                let reason = format!("the array in it is not {length} bytes long, as it says");
                return Err(Error::corrupt(path, self.kind, reason));
            }
            return Ok(frames);
        }
        // A file handle for each frame, since frames are read in parallel.
        let at = |place: u64| {
            let mut file = File::open(path)?;
            file.seek(SeekFrom::Start(place))?;
            Ok(file)
        };
        if !self.scattered.is_empty() {
            return all(&mut at(self.places.at(0)).map_err(fail)?);
        }
        in_order(self.places.len(), |t| self.read(reading, t, &mut at(self.places.at(t)).map_err(fail)?))
    }

    fn merged(&self, reading: Reading<'_>) -> Result<Vec<RawFrame>> {
        let frame = |t: usize| {
            let places = (0..3).map(|colour| self.places.at(t) + colour * self.planes).collect();
            let planes = Self { planes: 0, mosaic: None, places: Places::Listed(places), ..self.clone() };
            let colours = planes.stack(reading)?;
            let [red, green, blue] = [0, 1, 2].map(|colour| colours[colour].plane.data());
            let values = grey_from_planes(red, green, blue, Curve::Linear(1.0));
            let plane = Plane::from_vec(self.size.0, self.size.1, values);
            let scale = match self.white {
                Some(white) => FileScale::Range(white),
                None => frame_of_plane(reading.path, t, plane.clone(), false)?.scale,
            };
            Ok(RawFrame { is_colour: true, ..RawFrame::linear(plane, scale) })
        };
        (0..self.places.len()).map(frame).collect()
    }

    /// Frames of an image in tiles: layer by layer here where memory allows, else each frame in a process of its own.
    fn unpacked(&self, reading: Reading<'_>, tiles: &Tiles) -> Result<Vec<RawFrame>> {
        let count = self.places.len();
        let (first, bytes) = (self.places.at(0), tiles.layer_bytes());
        if confined::takes(bytes) {
            let limits = Limits { max_frames: usize::MAX, ..reading.options.limits };
            // The other process counts frames from the start of the file, whatever part is taken here.
            let options = &OpenOptions { take: None, limits, ..reading.options.clone() };
            let budget = Budget::new(0, (self.size.0 * self.size.1) as u64, bytes.saturating_mul(2));
            return in_order(count, |frame| {
                let part = Part::Page { page: self.places.at(frame) as usize, frame };
                let decoded =
                    confined::decode(Reading { expected: None, options, ..reading }, self.kind, part, budget)?;
                reading.ticker.tick();
                Ok(decoded)
            });
        }
        let layers = tiles.layer_of(first)..tiles.layer_of(self.places.at(count - 1)) + 1;
        let at_once = (rayon::current_num_threads() as u64).min(layers.end - layers.start);
        memory::check_room(bytes * at_once + 4 * (count * self.size.0 * self.size.1) as u64);
        let frames = in_order((layers.end - layers.start) as usize, |layer| {
            let layer = layers.start + layer as u64;
            let (bytes, start) = tiles.layer(reading, layer)?;
            let own = (0..count).filter(|t| tiles.layer_of(self.places.at(*t)) == layer);
            let read = |t| {
                let at = (self.places.at(t) - start) * self.frame_bytes();
                self.read(reading, t, &mut bytes.get(at as usize..).unwrap_or_default())
            };
            own.map(read).collect::<Result<Vec<_>>>()
        })?;
        Ok(frames.into_iter().flatten().collect())
    }

    pub fn page(mut self, reading: Reading<'_>, page: usize) -> Result<RawFrame> {
        if page >= self.places.len() {
            return Err(Error::corrupt(reading.path, self.kind, "it became shorter"));
        }
        self.places = self.places.part(page..page + 1);
        Ok(self.stack(reading)?.remove(0))
    }

    pub fn read(&self, reading: Reading<'_>, t: usize, from: &mut dyn Read) -> Result<RawFrame> {
        let count = self.samples();
        // Colours are weighted, and an encoding is undone, after the conversion.
        let whole = self.channels > 1 || self.is_encoded && reading.options.linearise;
        let mut values = memory::with_capacity(count);
        self.convert_all(reading, from, count, whole, |converted| values.extend_from_slice(converted))?;
        values.truncate(count); // of packed numbers the last group may be fuller
        let frame = self.frame_of(reading, t, values, whole)?;
        reading.ticker.tick();
        Ok(frame)
    }

    fn convert_all(
        &self,
        reading: Reading<'_>,
        from: &mut dyn Read,
        count: usize,
        whole: bool,
        mut take: impl FnMut(&[f32]),
    ) -> Result<()> {
        let divisor = if whole { 1.0 } else { self.white.unwrap_or(1.0) };
        let mut left = self.number.bytes(count as u64) as usize;
        let mut block = vec![0u8; BLOCK_BYTES.min(left)];
        let mut values = Vec::new();
        while left > 0 {
            reading.ticker.check()?;
            let block = &mut block[..BLOCK_BYTES.min(left)];
            from.read_exact(block).map_err(|e| Error::from_read(reading.path, self.kind, &e))?;
            values.clear();
            self.number.convert(block, self.big_endian, self.scaling, divisor, &mut values);
            take(&values);
            left -= block.len();
        }
        Ok(())
    }

    fn frame_of(&self, reading: Reading<'_>, t: usize, mut values: Vec<f32>, whole: bool) -> Result<RawFrame> {
        let Reading { path, options, .. } = reading;
        // Luma weighs red and blue differently, so their order matters.
        if self.is_bgr {
            values.chunks_exact_mut(self.channels).for_each(|pixel| pixel.swap(0, 2));
        }
        if whole {
            let curve = Curve::of(self.white.unwrap_or(1.0), self.is_encoded && options.linearise);
            values = grey_from_interleaved(&values, self.channels, curve);
        }
        let plane = Plane::from_vec(self.size.0, self.size.1, values);
        let frame = match self.white {
            Some(white) if self.scaling.is_none() => RawFrame::linear(plane, FileScale::Range(white)),
            white => {
                let is_integer = !self.number.is_float() && self.scaling.is_none_or(|scaling| scaling.factor == 1.0);
                let frame = frame_of_plane(path, t, plane, is_integer)?;
                RawFrame { scale: white.map_or(frame.scale, FileScale::Range), ..frame }
            }
        };
        let encoding = if self.is_encoded && !options.linearise { Encoding::Srgb } else { Encoding::Linear };
        Ok(RawFrame { encoding, mosaic: self.mosaic, is_colour: self.channels > 2, ..frame })
    }

    fn read_scattered(&self, reading: Reading<'_>, from: &mut dyn Read) -> Result<Vec<RawFrame>> {
        let frames = self.places.len();
        let mut planes: Vec<Vec<f32>> = (0..frames).map(|_| memory::zeroed(self.samples())).collect();
        // Distance of two samples of a frame that differ by one in an index.
        let step = |index| match index {
            Index::Frame => 0,
            Index::Colour => 1,
            Index::Column => self.channels,
            Index::Row => self.channels * self.size.0,
        };
        let axes: Vec<(bool, usize, usize)> =
            self.scattered.iter().map(|(index, length)| (*index == Index::Frame, *length, step(*index))).collect();
        let mut at = vec![0; axes.len()];
        let (mut t, mut place) = (0, 0);
        let whole = self.channels > 1;
        self.convert_all(reading, from, frames * self.samples(), whole, |values| {
            for value in values {
                planes[t][place] = *value;
                // An odometer: the fastest index turns first, and each full turn moves the next index.
                for (at, (is_frame, length, step)) in at.iter_mut().zip(&axes) {
                    let (counter, by) = if *is_frame { (&mut t, 1) } else { (&mut place, *step) };
                    *at += 1;
                    *counter += by;
                    if *at < *length {
                        break;
                    }
                    *counter -= by * *length;
                    *at = 0;
                }
            }
        })?;
        let frames = planes.into_iter().enumerate().map(|(t, values)| {
            reading.ticker.tick();
            self.frame_of(reading, t, values, whole)
        });
        frames.collect()
    }

    /// Checks frames of this size, of `step` bytes from `first` on, against the limits and the file's `length`.
    pub fn places_in(
        path: &Path,
        kind: &str,
        (frames, height, width): (u64, u64, u64),
        (first, step, length): (u64, u64, u64),
        limits: &Limits,
    ) -> Result<Places> {
        limits.check_frame(path, width, height)?;
        limits.check_burst(path, frames, width, height)?;
        let (wanted, there) = (frames.saturating_mul(step), length.saturating_sub(first));
        if there < wanted {
            let reason = format!("{wanted} bytes of values are announced, {there} are there");
            return Err(Error::corrupt(path, kind, reason));
        }
        Ok(Places::Even { first, step, count: frames })
    }
}

/// Reads on by at most `count` bytes, unless the work is cancelled.
fn skip(reading: Reading<'_>, from: &mut impl Read, count: u64) -> io::Result<()> {
    let mut left = from.take(count);
    while !reading.ticker.monitor().is_cancelled() && io::copy(&mut (&mut left).take(1 << 20), &mut io::sink())? > 0 {}
    Ok(())
}
