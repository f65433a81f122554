//! Decoding of files to float frames: one file, or many at once with progress by frame and the first failure in their
//! order. The kind of a file is told by its first bytes, not by its name.
//!
//! Before any decoder runs, the sizes that the file declares are checked ([`look`]). Third-party decoders run in a
//! child process ([`child`], [`serve`]) where they could take much memory, and always for raw files.

mod axes;
#[cfg(feature = "bags")]
mod bag;
mod child;
mod dump;
mod exif;
mod film;
mod fits;
mod image;
mod jpeg;
mod look;
mod mosaic;
mod npy;
mod pixels;
mod plain;
#[cfg(feature = "raw")]
mod raw;
mod ser;
mod serve;
mod tiff;
mod tiles;
mod wire;
mod y4m;

pub use child::DecodeWorker;
pub use dump::{LikelyShape, likely_shapes};
pub(super) use look::{Rank, extensions, rank};
pub use pixels::LUMA_WEIGHTS;
pub use serve::serve_decoding;

use super::layout::{Mosaic, ViewGrid, ViewsChoice};
use super::options::{Encoding, Limits, OpenOptions};
use super::times::Times;
use crate::error::{Error, Result, one_line};
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use crate::plane::memory::{self};
use ::image::ImageFormat::WebP;
use look::{Directories, Kind, check_webp};
use plain::Plain;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Unit of a file's values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) enum FileScale {
    /// Integers of up to 16 bit: the largest value of the type. The plane is already divided by it.
    Range(f32),
    /// Values as the sensor gave them: the plane is a fraction of the range from black to white.
    #[cfg_attr(not(feature = "raw"), allow(dead_code))] // only raw frames are of this kind
    Raw {
        /// File value that became 1.0.
        white: f32,
    },
    /// Float, and integers of 32 and 64 bit, whose range no sensor fills: the plane is in file units.
    Data {
        integer: bool,
        /// Largest value in this frame, 0 where none is above it: a sensor's noise, or one bad pixel, far below 0 says
        /// nothing of its full scale.
        largest: f32,
    },
}

impl FileScale {
    /// Name of the file's samples; frames whose samples differ are not in one unit. A raw file declares its own white.
    pub(super) fn samples(self) -> String {
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

#[derive(Debug)]
pub(super) struct RawFrame {
    pub plane: Plane,
    pub scale: FileScale,
    pub encoding: Encoding,
    /// Sensor pixels along a side of one pixel of the plane: 1 unless a colour mosaic was binned.
    pub binning: usize,
    /// Reason why a part of the picture is made up; set only where damage was accepted.
    pub damage: Option<String>,
    /// The kind of its file, where the extension names another.
    pub misnamed: Option<&'static str>,
    /// Whether the file has colours for each pixel.
    pub is_colour: bool,
    /// Mosaic of colours that its file declares; it is not binned yet.
    pub mosaic: Option<Mosaic>,
}

impl RawFrame {
    /// Frame whose values are proportional to light, as far as the file tells.
    pub(super) fn linear(plane: Plane, scale: FileScale) -> Self {
        let (encoding, damage, misnamed, mosaic) = (Encoding::Linear, None, None, None);
        Self { plane, scale, encoding, binning: 1, damage, misnamed, is_colour: false, mosaic }
    }

    /// Frame of the same file with the pixels of `plane`.
    pub(super) fn like(&self, plane: Plane) -> Self {
        let Self { scale, encoding, binning, misnamed, is_colour, mosaic, .. } = *self;
        Self { plane, scale, encoding, binning, damage: self.damage.clone(), misnamed, is_colour, mosaic }
    }
}

/// Declarations of a file, before any pixel is read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    /// Name of its kind.
    pub kind: &'static str,
    /// Size before a mosaic is binned.
    pub width: usize,
    pub height: usize,
    pub frames: usize,
    /// Name of its samples, such as "16 bit".
    pub samples: String,
    pub is_colour: bool,
    pub mosaic: Option<Mosaic>,
    pub times: Times,
    /// Grid of views that the frames are, where the file says so.
    pub views: Option<ViewGrid>,
    /// Guesses and choices, for the user.
    pub taken: Vec<String>,
}

impl Header {
    fn new(
        kind: &'static str,
        (width, height): (usize, usize),
        frames: usize,
        samples: String,
        is_colour: bool,
    ) -> Self {
        let (mosaic, times, views, taken) = (None, Times::default(), None, Vec::new());
        Self { kind, width, height, frames, samples, is_colour, mosaic, times, views, taken }
    }
}

/// Size that a frame must have, and the file that it comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected<'a> {
    pub first: &'a Path,
    pub size: (usize, usize),
}

/// A file, and the way its frames are read.
#[derive(Clone, Copy)]
pub(super) struct Reading<'a> {
    pub path: &'a Path,
    /// Size that its frame must have, where others come before it.
    pub expected: Option<Expected<'a>>,
    pub options: &'a OpenOptions,
    pub ticker: &'a Ticker<'a>,
}

impl<'a> Reading<'a> {
    pub(super) fn new(path: &'a Path, options: &'a OpenOptions, ticker: &'a Ticker<'a>) -> Self {
        Self { path, expected: None, options, ticker }
    }

    fn check(&self, size: (usize, usize)) -> Result<()> {
        match self.expected {
            Some(Expected { first, size: first_size }) if size != first_size => Err(Error::different_sizes(
                (&first.display().to_string(), first_size),
                (&self.path.display().to_string(), size),
            )),
            _ => Ok(()),
        }
    }
}

/// Number of frames in the file, for a TIFF and a film at most 2; reads as little as possible.
pub(super) fn frame_count(path: &Path, options: &OpenOptions) -> Result<usize> {
    if let Some((grid, _)) = options.views.and_then(ViewsChoice::picture) {
        return Ok(grid.count());
    }
    // Extensions are tried first, because this is called for every picture of a folder.
    if let Some(Kind::Raw | Kind::Picture(_)) = Kind::named(path) {
        return Ok(1);
    }
    // A thumbnail may lie between two pages.
    const PAGES: usize = 3;
    let input = InputFile::open(path, PAGES, options)?;
    let options =
        &OpenOptions { limits: Limits { max_frames: usize::MAX, ..Limits::default() }, take: None, ..options.clone() };
    guarded(path, input.kind, || match input.kind {
        Kind::Raw | Kind::Picture(_) => Ok(1),
        Kind::Film => Ok(2),
        #[cfg(feature = "bags")]
        Kind::Bag => bag::frame_count(path, options),
        Kind::Tiff => tiff::frame_count(path, input.file),
        _ => Ok(plain(path, input, options)?.places.len()),
    })
}

/// Size and number of frames that the file declares, checked against the limits. A raw file declares little before it
/// is decoded: for it the frame is returned too.
pub(super) fn header(path: &Path, options: &OpenOptions, monitor: &Monitor) -> Result<(Header, Option<RawFrame>)> {
    let input = InputFile::open(path, usize::MAX, options)?;
    let mut found = guarded(path, input.kind, || match input.kind {
        Kind::Raw => {
            let misnamed = input.misnamed;
            let frame = raw_frame(Reading::new(path, options, &Ticker::new(monitor, 1)), &input)?;
            let frame = RawFrame { misnamed, ..frame };
            let header = Header::new(input.kind.name(), frame.plane.size(), 1, frame.scale.samples(), false);
            Ok((header, Some(frame)))
        }
        Kind::Film => Ok((film::header(path, options, monitor)?, None)),
        #[cfg(feature = "bags")]
        Kind::Bag => Ok((bag::header(path, options, monitor)?, None)),
        Kind::Tiff => Ok((tiff::header(path, input.file, options)?, None)),
        Kind::Picture(format) => Ok((image::header(path, input.file, format, &options.limits)?, None)),
        _ => Ok((plain(path, input, options)?.header(), None)),
    })?;
    found.0.taken.iter_mut().for_each(|taken| *taken = one_line(taken));
    Ok(found)
}

/// Times that the file gives for its frames. Decodes nothing.
pub(super) fn times(path: &Path, options: &OpenOptions, monitor: &Monitor) -> Result<Times> {
    let input = InputFile::open(path, usize::MAX, options)?;
    match input.kind {
        Kind::Raw | Kind::Picture(_) | Kind::Tiff => guarded(path, input.kind, || Ok(exif::times(path))),
        _ => Ok(header(path, options, monitor)?.0.times),
    }
}

pub(super) fn frame(reading: Reading<'_>) -> Result<RawFrame> {
    let Reading { path, options, .. } = reading;
    let input = InputFile::open(path, usize::MAX, options)?;
    let misnamed = input.misnamed;
    let frame = guarded(path, input.kind, || match input.kind {
        Kind::Raw => raw_frame(reading, &input),
        Kind::Film => Err(Error::stack_among_frames(path, 2)),
        #[cfg(feature = "bags")]
        Kind::Bag => bag::only(reading),
        Kind::Tiff => tiff::frame(reading, input),
        Kind::Picture(format) => image::frame(reading, input, format),
        _ => plain(path, input, options)?.only(reading),
    })?;
    mosaic::applied(path, RawFrame { misnamed, ..frame }, options)
}

pub(super) fn stack(reading: Reading<'_>) -> Result<Vec<RawFrame>> {
    let Reading { path, options, ticker, .. } = reading;
    let input = InputFile::open(path, usize::MAX, options)?;
    let misnamed = input.misnamed;
    let frames = match input.kind {
        Kind::Film => guarded(path, input.kind, || film::stack(reading)),
        #[cfg(feature = "bags")]
        Kind::Bag => guarded(path, input.kind, || bag::stack(reading)),
        Kind::Tiff => guarded(path, input.kind, || tiff::stack(reading, input)),
        Kind::Raw | Kind::Picture(_) => {
            let frame = frame(reading)?;
            ticker.tick();
            return options.taken(path, vec![frame], (1, 1));
        }
        _ => guarded(path, input.kind, || plain(path, input, options)?.stack(reading)),
    }?;
    let finished = |frame| mosaic::applied(path, RawFrame { misnamed, ..frame }, options);
    frames.into_par_iter().map(finished).collect()
}

/// Pixels of a file that holds plain numbers.
fn plain(path: &Path, input: InputFile, options: &OpenOptions) -> Result<Plain> {
    let InputFile { mut file, length, kind, .. } = input;
    let whole = &options.of_whole();
    let plain = match kind {
        Kind::Npy => npy::ArrayHeader::read(path, kind.name(), &mut file)?.plain(path, kind.name(), length, whole),
        Kind::Npz => npy::of_archive(path, file, whole),
        Kind::Y4m => y4m::plain(path, file, length, whole),
        Kind::Ser => ser::plain(path, file, length, whole),
        Kind::Fits => fits::plain(path, file, length, whole),
        Kind::Dump => dump::plain(path, length, whole),
        #[cfg(feature = "bags")]
        Kind::Bag => unreachable!("it has a decoder of its own"),
        Kind::Raw | Kind::Film | Kind::Tiff | Kind::Picture(_) => unreachable!("these have decoders of their own"),
    }?;
    plain.part(path, options)
}

/// Decodes one page of a TIFF, picture of a bag or frame of a FITS image, which is frame `frame` of its burst.
fn page(reading: Reading<'_>, page: usize, frame: usize) -> Result<RawFrame> {
    let Reading { path, options, .. } = reading;
    let input = InputFile::open(path, usize::MAX, options)?;
    guarded(path, input.kind, || match input.kind {
        #[cfg(feature = "bags")]
        Kind::Bag => bag::page(reading, page, frame),
        Kind::Fits => plain(path, input, options)?.page(reading, page),
        _ => tiff::page(reading, input, page, frame),
    })
}

fn raw_frame(reading: Reading<'_>, input: &InputFile) -> Result<RawFrame> {
    if cfg!(feature = "raw") && child::is_installed() {
        // Two pixels a byte are more than any camera packs; a directory gives their number.
        let packed = input.length.saturating_mul(2);
        let pixels =
            input.directories.as_ref().map_or(packed, |found| found.pixels).min(reading.options.limits.max_pixels);
        const DECODER_BYTES_PER_PIXEL: u64 = 32;
        let budget = child::Budget::new(input.length, pixels, pixels.saturating_mul(DECODER_BYTES_PER_PIXEL));
        return child::decode(reading, Kind::Raw.name(), wire::Part::Only, budget);
    }
    #[cfg(feature = "raw")]
    let frame = raw::frame(reading);
    #[cfg(not(feature = "raw"))]
    let frame = {
        let reason = "this program was built without raw frames (the feature 'raw'); convert it to a 16-bit TIFF";
        Err(Error::unsupported(reading.path, "raw", reason))
    };
    frame
}

struct InputFile {
    file: File,
    length: u64,
    kind: Kind,
    /// The name of its kind, where its extension names another.
    misnamed: Option<&'static str>,
    directories: Option<Directories>,
}

impl InputFile {
    /// Opens a regular file that is not empty, tells its kind and checks the sizes that it declares; of a TIFF, the
    /// first `pages` pages only.
    fn open(path: &Path, pages: usize, options: &OpenOptions) -> Result<Self> {
        let read_error = |e: std::io::Error| Error::from_io(path, &e);
        let metadata = std::fs::metadata(path).map_err(read_error)?;
        if !metadata.is_file() {
            return Err(Error::not_a_file(path));
        }
        let length = metadata.len();
        if length == 0 {
            return Err(Error::damaged(path, "this file is empty (0 bytes)"));
        }
        let mut file = File::open(path).map_err(read_error)?;
        let mut start = Vec::with_capacity(32);
        (&mut file).take(32).read_to_end(&mut start).map_err(read_error)?;
        // A raw file may use a video container.
        let named = Kind::named(path);
        let is_raw = named == Some(Kind::Raw);
        // By chance a dump begins like another file; one whose shape is given is taken for what its name says.
        let is_dump = named.is_none_or(|kind| kind == Kind::Dump) && (options.raw.is_some());
        let begins_as = if is_dump { Some(Kind::Dump) } else { Kind::of(&start) };
        let mut kind = match begins_as {
            None | Some(Kind::Tiff) if is_raw => Kind::Raw,
            Some(kind) => kind,
            None if look::container(&start).is_some() => Kind::Film,
            None if named == Some(Kind::Dump) => Kind::Dump,
            None => return Err(look::unknown(path, &start)),
        };
        let mut reader = BufReader::with_capacity(512, &mut file);
        let mut directories = None;
        if begins_as == Some(Kind::Tiff) {
            let found = Directories::read(&mut reader, length, is_raw, pages);
            let found = found.map_err(|e| Error::from_read(path, kind.name(), &e))?;
            if found.is_dng {
                kind = Kind::Raw; // whatever its extension
            }
            directories = Some(found);
        } else if kind == Kind::Picture(WebP) {
            check_webp(&mut reader, length).map_err(|e| Error::from_read(path, kind.name(), &e))?;
        }
        file.seek(SeekFrom::Start(0)).map_err(read_error)?;
        let misnamed = named.filter(|named| *named != kind && *named != Kind::Dump).map(|_| kind.name());
        Ok(Self { file, length, kind, misnamed, directories })
    }
}

/// Runs a decoder. A panic in it, and memory that the system refuses it, become errors about the file.
fn guarded<T>(path: &Path, kind: Kind, decode: impl FnOnce() -> Result<T>) -> Result<T> {
    let decode = || memory::refusable(decode).unwrap_or_else(|refused| Err(refused.about(path)));
    let decoded = std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err(Error::corrupt(path, kind.name(), "its decoder failed unexpectedly")));
    // Names in a file may hold anything.
    decoded.map_err(|error| Error { problem: one_line(&error.problem), remedy: one_line(&error.remedy), ..error })
}

/// Makes a frame of a plane in file units, in which NaN is an undefined value. Fails at the first infinite one.
pub(super) fn frame_of_plane(path: &Path, frame: usize, plane: Plane, integer: bool) -> Result<RawFrame> {
    let values = plane.data();
    // Bits of positive floats are ordered as they are, infinity and NaN above all, and those of negative ones are
    // negative integers: so many are compared at a time.
    let (magnitude, largest) = values.iter().fold((0, 0), |(magnitude, largest): (i32, i32), v| {
        let bits = v.to_bits() as i32;
        ((bits & i32::MAX).max(magnitude), bits.max(largest))
    });
    let mut largest = f32::from_bits(largest as u32);
    if !f32::from_bits(magnitude as u32).is_finite() {
        if let Some(index) = values.iter().position(|v| v.is_infinite()) {
            return Err(Error::not_finite(path, frame, plane.width(), index, values[index]));
        }
        largest = values.iter().copied().fold(0.0, f32::max);
    }
    Ok(RawFrame::linear(plane, FileScale::Data { integer, largest }))
}

/// Counter of finished frames, for use from any thread.
pub(super) struct Ticker<'a> {
    monitor: &'a Monitor,
    done: AtomicUsize,
    total: usize,
}

impl<'a> Ticker<'a> {
    pub(super) fn new(monitor: &'a Monitor, total: usize) -> Self {
        Self { monitor, done: AtomicUsize::new(0), total }
    }

    pub(super) fn monitor(&self) -> &'a Monitor {
        self.monitor
    }

    pub(super) fn check(&self) -> Result<()> {
        Ok(self.monitor.check()?)
    }

    pub(super) fn tick(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        self.monitor.report(Stage::Open, done as f32 / self.total.max(1) as f32);
    }
}

/// Computes `f(0) … f(count − 1)` in parallel. When several fail, the error is that of the lowest index, whatever the
/// number of threads, so that a user who mends one file after the other sees them in order.
pub(super) fn in_order<T: Send>(count: usize, f: impl Fn(usize) -> Result<T> + Sync) -> Result<Vec<T>> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_failure_in_order_is_the_answer() {
        let fail = |path: usize| Error::damaged(Path::new(&path.to_string()), "");
        for _ in 0..50 {
            let answer = in_order(100, |i| if i % 7 == 5 { Err(fail(i)) } else { Ok(i) });
            assert_eq!(answer, Err(fail(5)));
        }
        assert_eq!(in_order(100, Ok), Ok((0..100).collect()));
    }
}
