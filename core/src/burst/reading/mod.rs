//! What formats of files share: a frame as it is decoded ([`RawFrame`]), what a file declares before that
//! ([`Declared`]), conversion of samples to planes ([`plain`], [`pixels`]), and the process in which
//! decoders of others run ([`confined`]) where they could take much memory, and always for raw files.

pub mod confined;
pub mod exif;
pub mod pixels;
pub mod plain;
pub mod tiles;

use super::layout::{Mosaic, ViewGrid};
use super::options::{Encoding, OpenOptions};
use super::times::Times;
use crate::error::{Error, Result};
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum FileScale {
    /// Integers of up to 16 bit: the largest value of the type. The plane is already divided by it.
    Range(f32),
    /// Values as the sensor gave them: the plane is a fraction of the range from black to white.
    Raw {
        /// File value that became 1.0.
        white: f32,
    },
    /// Float, and integers of 32 and 64 bit, whose range no sensor fills: the plane is in file units.
    Data {
        integer: bool,
        /// Largest value, 0 where none is above: noise or a bad pixel far below 0 says nothing about full scale.
        largest: f32,
    },
}

impl FileScale {
    /// Name of the file's samples; frames whose samples differ are not in one unit. A raw file declares its own white.
    pub fn samples(self) -> String {
        match self {
            Self::Range(127.0) => "8 bit with a sign".to_owned(),
            Self::Range(32767.0) => "16 bit with a sign".to_owned(),
            Self::Range(largest) => format!("{} bit", (largest as u32).checked_ilog2().map_or(1, |bits| bits + 1)),
            Self::Raw { .. } => "raw values".to_owned(),
            Self::Data { integer: true, .. } => "integers of 32 or 64 bit".to_owned(),
            Self::Data { integer: false, .. } => "floats".to_owned(),
        }
    }
}

#[derive(Debug, Serialize, Deserialize)]
pub struct RawFrame {
    // Where a frame comes from another process, its pixels follow it.
    #[serde(skip, default = "no_pixels")]
    pub plane: Plane,
    pub scale: FileScale,
    pub encoding: Encoding,
    /// Sensor pixels along a side of one pixel of the plane: 1 unless a colour mosaic was binned.
    pub binning: usize,
    /// Reason why a part of the picture is made up; set only where damage was accepted.
    pub damage: Option<String>,
    /// The kind of its file, where the extension names another.
    #[serde(skip)]
    pub misnamed: Option<&'static str>,
    pub is_colour: bool,
    /// Mosaic of colours that the file declares, not binned yet.
    pub mosaic: Option<Mosaic>,
}

fn no_pixels() -> Plane {
    Plane::zeros(0, 0)
}

impl RawFrame {
    /// Frame whose values are proportional to light, as far as the file tells.
    pub fn linear(plane: Plane, scale: FileScale) -> Self {
        let (encoding, damage, misnamed, mosaic) = (Encoding::Linear, None, None, None);
        Self { plane, scale, encoding, binning: 1, damage, misnamed, is_colour: false, mosaic }
    }

    pub fn like(&self, plane: Plane) -> Self {
        Self { plane, damage: self.damage.clone(), ..*self }
    }
}

#[derive(Debug)]
pub struct Declared {
    pub kind: &'static str,
    /// Size before a mosaic is binned.
    pub width: usize,
    pub height: usize,
    pub frames: usize,
    pub samples: String,
    pub is_colour: bool,
    pub mosaic: Option<Mosaic>,
    pub times: Times,
    /// Grid of views that the frames are, where the file says so.
    pub views: Option<ViewGrid>,
    pub taken: Vec<String>,
    /// Its frame, where a file declares nothing that decoding does not change.
    pub first: Option<RawFrame>,
}

impl Declared {
    pub fn new(
        kind: &'static str,
        (width, height): (usize, usize),
        frames: usize,
        samples: String,
        is_colour: bool,
    ) -> Self {
        let (mosaic, times, views, taken, first) = (None, Times::default(), None, Vec::new(), None);
        Self { kind, width, height, frames, samples, is_colour, mosaic, times, views, taken, first }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Expected<'a> {
    pub first: &'a Path,
    pub size: (usize, usize),
}

#[derive(Clone, Copy)]
pub struct Reading<'a> {
    pub path: &'a Path,
    /// Size of the frames before, which this frame must have too.
    pub expected: Option<Expected<'a>>,
    pub options: &'a OpenOptions,
    pub ticker: &'a Ticker<'a>,
}

impl<'a> Reading<'a> {
    pub fn new(path: &'a Path, options: &'a OpenOptions, ticker: &'a Ticker<'a>) -> Self {
        Self { path, expected: None, options, ticker }
    }

    pub fn check(&self, size: (usize, usize)) -> Result<()> {
        match self.expected {
            Some(Expected { first, size: first_size }) if size != first_size => Err(Error::different_sizes(
                (&first.display().to_string(), first_size),
                (&self.path.display().to_string(), size),
            )),
            _ => Ok(()),
        }
    }
}

/// Makes a frame of a plane in file units, in which NaN is an undefined value. Fails at the first infinite one.
pub fn frame_of_plane(path: &Path, frame: usize, plane: Plane, integer: bool) -> Result<RawFrame> {
    let values = plane.data();
    // Positive floats are ordered as their bits, infinity and NaN last; integers are compared several at a time.
    let (magnitude, largest) = values.iter().fold((0, 0), |(magnitude, largest): (i32, i32), v| {
        let bits = v.to_bits() as i32;
        ((bits & i32::MAX).max(magnitude), bits.max(largest))
    });
    let mut largest = f32::from_bits(largest as u32);
    if !f32::from_bits(magnitude as u32).is_finite() {
        // Infinity is an error; NaN is allowed, but must not count as the largest value.
        if let Some(index) = values.iter().position(|v| v.is_infinite()) {
            return Err(Error::not_finite(path, frame, plane.width(), index, values[index]));
        }
        largest = values.iter().copied().fold(0.0, f32::max);
    }
    Ok(RawFrame::linear(plane, FileScale::Data { integer, largest }))
}

pub fn read_at(file: &mut (impl Read + Seek), at: u64, buffer: &mut [u8]) -> io::Result<()> {
    file.seek(SeekFrom::Start(at))?;
    file.read_exact(buffer)
}

/// Reader that fails once the work is cancelled. A decoder takes that for damage: check the monitor first.
pub struct Asked<R> {
    pub inner: R,
    pub monitor: Monitor,
}

impl<R> Asked<R> {
    pub fn new(inner: R, monitor: &Monitor) -> Self {
        Self { inner, monitor: monitor.silent() }
    }

    fn ask(&mut self) -> io::Result<&mut R> {
        // A reader that is merely interrupted would be read again.
        self.monitor.check().map_err(io::Error::other)?;
        Ok(&mut self.inner)
    }
}

impl<R: Read> Read for Asked<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.ask()?.read(buffer)
    }
}

impl<R: BufRead> BufRead for Asked<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.ask()?.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        self.inner.consume(count);
    }
}

impl<R: Seek> Seek for Asked<R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.inner.seek(to)
    }
}

/// Error of a file that announces the impossible; `reason` is the end of a sentence about it.
pub fn corrupt(reason: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason.into())
}

/// Damage of a file of `length` bytes that announces more pixels than at most `pixels_a_byte` in each of them.
pub fn too_few_bytes(length: u64, width: u64, height: u64, pixels_a_byte: u64) -> Option<String> {
    let is_possible = width.saturating_mul(height) / pixels_a_byte <= length;
    (!is_possible).then(|| format!("its {length} bytes are too few for {width}×{height} pixels"))
}

pub struct Ticker<'a> {
    monitor: &'a Monitor,
    done: AtomicUsize,
    total: usize,
}

impl<'a> Ticker<'a> {
    pub fn new(monitor: &'a Monitor, total: usize) -> Self {
        Self { monitor, done: AtomicUsize::new(0), total }
    }

    pub fn monitor(&self) -> &'a Monitor {
        self.monitor
    }

    pub fn check(&self) -> Result<()> {
        Ok(self.monitor.check()?)
    }

    pub fn tick(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        self.monitor.report(Stage::Open, done as f32 / self.total.max(1) as f32);
    }
}

/// Computes `f(0) … f(count − 1)` in parallel. Of several errors the lowest index counts, with any threads.
pub fn in_order<T: Send>(count: usize, f: impl Fn(usize) -> Result<T> + Sync) -> Result<Vec<T>> {
    let first_failure = AtomicUsize::new(usize::MAX);
    let answers: Vec<Option<Result<T>>> = (0..count)
        .into_par_iter()
        .with_max_len(1)
        .map(|i| {
            if i > first_failure.load(Ordering::Relaxed) {
                return None; // an earlier one failed: this one is not needed
            }
            let answer = f(i);
            if answer.is_err() {
                first_failure.fetch_min(i, Ordering::Relaxed);
            }
            Some(answer)
        })
        .collect();
    // Skipped items come after a failure, so `flatten` never drops one before the first error.
    answers.into_iter().flatten().collect()
}
