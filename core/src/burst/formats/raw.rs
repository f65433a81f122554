//! Raw frames: a sensor's own values, by `rawler` (DNG, and the other formats that it knows).
//!
//! Squares of the mosaic become pixels. Values under black stay negative; nothing is stretched, balanced or clipped.
//! The sensor's active area is taken, not the camera's crop. Black and white levels, which become 0 and 1, are the
//! file's unless given; black may differ by colour, column and row (DNG's `BlackLevelDeltaH` and `BlackLevelDeltaV`).

use super::tiff::directories::{Directories, OF_SENSORS, begins as is_tiff};
use super::{Format, Input, Rank, Record, Start, has_extension, tiff::is_of_sensor};
use crate::burst::reading::confined::{self, Budget, wire::Part};
use crate::burst::reading::pixels::{Curve, binned, grey_from_interleaved, turned};
use crate::burst::reading::{Declared, FileScale, RawFrame, Reading, exif, read_at};
use crate::burst::{layout::Mosaic, options::OpenOptions, times::Times};
use crate::error::{Error, ErrorKind, Result};
use crate::files::read_bytes;
use crate::plane::{Plane, memory};
use image::metadata::Orientation;
use rawler::decoders::{RawDecodeParams, WellKnownIFD};
use rawler::formats::tiff::IFD;
use rawler::imgop::{Dim2, Point, Rect};
use rawler::rawimage::{BlackLevel, RawPhotometricInterpretation};
use rawler::tags::{DngTag, TiffCommonTag};
use rawler::{RawImage, RawImageData, rawsource::RawSource};
use std::{io::BufReader, path::Path};

/// Largest file per allowed pixel, bytes: float values, and the file's other data.
const BYTES_PER_PIXEL: u64 = 8;

pub(super) struct Raw;

const NAME: &str = "raw";

impl Format for Raw {
    fn record(&self) -> Record {
        let opens = "each file is one frame: DNG and what `rawler` reads; 2×2 pixels of the mosaic become one";
        Record { name: NAME, rank: Rank::Picture, extensions: OF_SENSORS, opens, options: "`--raw-colour green`" }
    }

    /// A raw file may use a video container.
    fn begins(&self, start: &Start<'_>) -> bool {
        is_of_sensor(start)
    }

    fn declared(&self, input: Input, reading: Reading<'_>) -> Result<Declared> {
        let frame = self.only(input, reading)?;
        let declared = Declared::new(NAME, frame.plane.size(), 1, frame.scale.samples(), false);
        Ok(Declared { first: Some(frame), ..declared })
    }

    fn times(&self, _input: Input, reading: Reading<'_>) -> Result<Times> {
        Ok(exif::times(reading.path))
    }

    fn only(&self, input: Input, reading: Reading<'_>) -> Result<RawFrame> {
        let pixels = declared_pixels(&input, reading)?;
        if !confined::is_installed() {
            return frame(reading);
        }
        const DECODER_BYTES_PER_PIXEL: u64 = 32;
        let pixels = pixels.min(reading.options.limits.max_pixels);
        let budget = Budget::new(input.length, pixels, pixels.saturating_mul(DECODER_BYTES_PER_PIXEL));
        confined::decode(reading, NAME, Part::Only, budget)
    }
}

fn declared_pixels(input: &Input, reading: Reading<'_>) -> Result<u64> {
    let failed = |e| Error::from_read(reading.path, NAME, &e);
    let mut start = [0; 4];
    read_at(&mut &input.file, 0, &mut start[..input.length.min(4) as usize]).map_err(failed)?;
    if !is_tiff(&start) {
        // Two pixels a byte are more than any camera packs.
        return Ok(input.length.saturating_mul(2));
    }
    let is_named = has_extension(reading.path, OF_SENSORS);
    let found = Directories::read(&mut BufReader::with_capacity(512, &input.file), input.length, is_named, usize::MAX);
    Ok(found.map_err(failed)?.pixels)
}

const ELSEWHERE: &str = "convert it to DNG, or to a 16-bit TIFF of its values";

/// Error for a raw file of which the library says no more than `what`.
fn unread(path: &Path, what: &str) -> Error {
    let problem = format!("the decoder of raw files does not read this one: {what}");
    Error::new(ErrorKind::Damaged, problem, format!("it is damaged, or of a kind that is not known: {ELSEWHERE}"))
        .about(path)
}

fn frame(reading: Reading<'_>) -> Result<RawFrame> {
    // The library panics on some damaged files, and allocates what they announce.
    let known = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| memory::refusable(|| decoded(reading))));
    known.unwrap_or_else(|_| Ok(Err(unread(reading.path, "it fails")))).map_err(|e| e.about(reading.path))?
}

fn decoded(reading: Reading<'_>) -> Result<RawFrame> {
    let Reading { path, options, .. } = reading;
    let max_bytes = options.limits.max_pixels.saturating_mul(BYTES_PER_PIXEL);
    let bytes = read_bytes(path, max_bytes).map_err(|e| Error::from_io(path, &e))?;
    let source = RawSource::new_from_slice(&bytes).with_path(path);
    // The library reports an unknown kind as it does damage.
    let corrupt = |e: rawler::RawlerError| match e {
        rawler::RawlerError::Unsupported { what, .. } if is_tiff(&bytes) => {
            Error::unsupported(path, NAME, format!("{what}; {ELSEWHERE}"))
        }
        rawler::RawlerError::Unsupported { .. } => Error::damaged(path, "this raw file does not begin like one"),
        rawler::RawlerError::DecoderFailed(what) => unread(path, &what),
    };
    let decoder = rawler::get_decoder(&source).map_err(corrupt)?;
    // The declared size is checked before anything is decoded.
    let (mut width, mut height) = (0, 0);
    let mut black_steps = BlackSteps::default();
    if let Some(directory) = decoder.ifd(WellKnownIFD::Raw).map_err(corrupt)? {
        let side = |tag| directory.get_entry(tag).map_or(0, |entry| entry.force_usize(0));
        (width, height) = (side(TiffCommonTag::ImageWidth), side(TiffCommonTag::ImageLength));
        black_steps = BlackSteps::of(&directory);
    }
    // Formats without this directory: a dry run of the decoder reads the size alone.
    if width == 0 || height == 0 {
        let announced = decoder.raw_image(&source, &RawDecodeParams::default(), true).map_err(corrupt)?;
        (width, height) = (announced.width, announced.height);
    }
    options.limits.check_frame(path, width as u64, height as u64)?;
    let raw = decoder.raw_image(&source, &RawDecodeParams::default(), false).map_err(corrupt)?;
    let unsupported = |reason: String| Error::unsupported(path, NAME, reason);
    let too_few = || Error::corrupt(path, NAME, "it has fewer values than its size announces");
    // Checked before values are indexed.
    let area = active_area(&raw).ok_or_else(too_few)?;
    let levels = RawLevels::of(&raw, (area.d.w, area.d.h), black_steps, options).map_err(unsupported)?;
    let (plane, binning) = plane_of(&raw, &area, &levels, options).map_err(unsupported)?;
    if let Some(index) = plane.data().iter().position(|v| !v.is_finite()) {
        return Err(Error::not_finite(path, 0, plane.width(), index, plane.data()[index]));
    }
    let orientation = u8::try_from(raw.orientation.to_u16()).ok().and_then(Orientation::from_exif);
    let plane = turned(plane, orientation.unwrap_or(Orientation::NoTransforms));
    reading.check(plane.size())?;
    Ok(RawFrame { binning, ..RawFrame::linear(plane, FileScale::Raw { white: levels.white[0] }) })
}

/// Part of the sensor that sees light; `None` where it is empty or exceeds the declared size, or values are missing.
fn active_area(raw: &RawImage) -> Option<Rect> {
    let count = match &raw.data {
        RawImageData::Integer(values) => values.len(),
        RawImageData::Float(values) => values.len(),
    };
    let area = raw.active_area.unwrap_or(Rect::new(Point::zero(), Dim2::new(raw.width, raw.height)));
    let inside = area.p.x.checked_add(area.d.w)? <= raw.width && area.p.y.checked_add(area.d.h)? <= raw.height;
    let full = raw.width.checked_mul(raw.height)?.checked_mul(raw.cpp)? <= count;
    (inside && full && area.d.w > 0 && area.d.h > 0 && raw.cpp > 0).then_some(area)
}

/// One value for each pixel, or each square of 2×2, with the side of that square in pixels (1 or 2).
fn plane_of(raw: &RawImage, area: &Rect, levels: &RawLevels, options: &OpenOptions) -> Result<(Plane, usize), String> {
    let colour = options.raw_colour;
    // Value of a pixel of the active area, as a fraction.
    let at = |u: usize, v: usize, c: usize| {
        let index = ((area.p.y + v) * raw.width + area.p.x + u) * raw.cpp + c;
        let value = match &raw.data {
            RawImageData::Integer(values) => f32::from(values[index]),
            RawImageData::Float(values) => values[index],
        };
        levels.fraction(value, (u, v), c)
    };
    let is_binned = options.mosaic != Some(Mosaic::None);
    if let (RawPhotometricInterpretation::Cfa(config), 1, true) = (&raw.photometric, raw.cpp, is_binned) {
        let mosaic = &config.cfa;
        let colour_at = |u: usize, v: usize| mosaic.color_at(area.p.y + v, area.p.x + u);
        // A square of two green, a red and a blue pixel: other mosaics have other colours or periods.
        let mut square: Vec<usize> = (0..4).map(|k| colour_at(k % 2, k / 2)).collect();
        square.sort_unstable();
        if (mosaic.width, mosaic.height) != (2, 2) || square != [0, 1, 1, 2] {
            return Err(format!(
                "its mosaic is {}×{} of {}; squares of two green, a red and a blue pixel can be opened, and with --mosaic none its pixels as they are",
                mosaic.width, mosaic.height, mosaic.name
            ));
        }
        let plane = binned((area.d.w, area.d.h), colour, colour_at, |u, v| at(u, v, 0));
        return Ok((plane.ok_or("its active area is smaller than a square of the mosaic")?, 2));
    }
    let plane = match raw.cpp {
        1 => Plane::from_fn(area.d.w, area.d.h, |u, v| at(u, v, 0)),
        3 => Plane::from_fn(area.d.w, area.d.h, |u, v| match colour.index() {
            None => grey_from_interleaved(&[at(u, v, 0), at(u, v, 1), at(u, v, 2)], 3, Curve::Linear(1.0))[0],
            Some(c) => at(u, v, c),
        }),
        samples => return Err(format!("it has {samples} values a pixel; one or three can be opened")),
    };
    Ok((plane, 1))
}

/// Black of each column and row above the level of its colour. Empty where the file gives none.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct BlackSteps {
    columns: Vec<f32>,
    rows: Vec<f32>,
}

impl BlackSteps {
    pub(super) fn of(directory: &IFD) -> Self {
        let steps = |tag: DngTag| {
            let value = directory.get_entry(tag).map(|entry| &entry.value);
            value.map_or_else(Vec::new, |value| {
                (0..value.count()).map(|index| value.get_f32(index).ok().flatten().unwrap_or(f32::NAN)).collect()
            })
        };
        Self { columns: steps(DngTag::BlackLevelDeltaH), rows: steps(DngTag::BlackLevelDeltaV) }
    }

    /// Whether there is one finite step for each column and row of an area of `size` (columns, rows), or none.
    fn fits(&self, size: (usize, usize)) -> bool {
        let fits =
            |steps: &[f32], count| steps.is_empty() || (steps.len() == count && steps.iter().all(|s| s.is_finite()));
        fits(&self.columns, size.0) && fits(&self.rows, size.1)
    }

    fn max(&self) -> f32 {
        let max = |steps: &[f32]| steps.iter().copied().fold(0.0, f32::max);
        max(&self.columns) + max(&self.rows)
    }

    fn at(&self, (u, v): (usize, usize)) -> f32 {
        self.columns.get(u).copied().unwrap_or(0.0) + self.rows.get(v).copied().unwrap_or(0.0)
    }
}

/// Values that become 0 and 1.
pub(super) struct RawLevels {
    /// Levels of a pattern of columns and rows, each with its samples, that begins at the active area's corner.
    black: Vec<f32>,
    black_size: (usize, usize),
    black_steps: BlackSteps,
    white: Vec<f32>,
    samples: usize,
}

impl RawLevels {
    /// Levels of `raw`, whose active area has `size`, or those of `options`. An error ends a sentence about the file.
    pub(super) fn of(
        raw: &RawImage,
        size: (usize, usize),
        black_steps: BlackSteps,
        options: &OpenOptions,
    ) -> Result<Self, String> {
        let BlackLevel { width, height, cpp, .. } = raw.blacklevel;
        let mut black = raw.blacklevel.as_vec();
        let mut black_size = (width.max(1), height.max(1));
        let mut black_steps = black_steps;
        // Some files announce a pattern of levels and give fewer: the first then stands for all.
        if black.len() < black_size.0 * black_size.1 * cpp.max(1) || cpp != raw.cpp {
            (black, black_size) = (vec![black.first().copied().unwrap_or(0.0); raw.cpp], (1, 1));
        }
        // A given level replaces the file's, with its steps by column and row.
        if let Some(level) = options.black_level {
            (black, black_size, black_steps) = (vec![level; raw.cpp], (1, 1), BlackSteps::default());
        }
        if !black_steps.fits(size) {
            let ((width, height), [columns, rows]) = (size, [&black_steps.columns, &black_steps.rows].map(Vec::len));
            return Err(format!(
                "its black levels of columns and rows are {columns} and {rows}, not one for each of {width}×{height}; give one black level"
            ));
        }
        let mut white: Vec<f32> = raw.whitelevel.0.iter().map(|level| *level as f32).collect();
        if white.len() < raw.cpp {
            white = vec![white.first().copied().unwrap_or(65535.0); raw.cpp];
        }
        if let Some(level) = options.full_scale {
            white = vec![level; raw.cpp];
        }
        let levels = Self { black, black_size, black_steps, white, samples: raw.cpp };
        let darkest = levels.white.iter().copied().fold(f32::INFINITY, f32::min);
        let step = levels.black_steps.max();
        if levels.black.iter().all(|black| *black + step < darkest) {
            return Ok(levels);
        }
        Err(format!("its black level is not below its white level, {darkest}; give both by full scale and black level"))
    }

    /// Sample `c` of the active area's pixel in column `u` and row `v`, scaled so that black becomes 0 and white 1.
    pub(super) fn fraction(&self, value: f32, (u, v): (usize, usize), c: usize) -> f32 {
        let (width, height) = self.black_size;
        let level = self.black[((v % height) * width + u % width) * self.samples + c];
        let black = level + self.black_steps.at((u, v));
        (value - black) / (self.white[c] - black)
    }
}
