//! From one file to float frames. The kind of a file is told by its first bytes, not by its name.

mod image;
mod kind;
mod npy;
mod npy_header;
#[cfg(feature = "raw")]
mod raw;
#[cfg(feature = "raw")]
mod raw_levels;
mod tiff;
mod tiff_tiles;
mod turned;

pub(super) use kind::RAW_EXTENSIONS;

use super::encoding::Encoding;
use super::error::OpenError;
use super::options::OpenOptions;
use super::progress::Ticker;
use crate::plane::{Plane, memory};
use kind::{Kind, has_raw_extension, is_video, kind_of};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// What a file's values mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FileScale {
    /// Integers of 8 or 16 bit: the largest value that the type can hold. The plane is already divided by it.
    Range(f32),
    /// A sensor's own values: the plane is a fraction of the range from black to white.
    #[cfg_attr(not(feature = "raw"), allow(dead_code))] // only raw frames are of this kind
    Raw {
        /// The file's value that became 1.0.
        white: f32,
    },
    /// Float, and integers of 32 and 64 bit, whose range no sensor fills: the plane is in file units, and its largest
    /// magnitude is this.
    Data {
        /// Whether the file holds integers.
        integer: bool,
        /// The largest magnitude in this frame.
        largest: f32,
    },
}

/// One decoded frame.
#[derive(Debug)]
pub(super) struct RawFrame {
    /// The pixels.
    pub plane: Plane,
    /// Their unit.
    pub scale: FileScale,
    /// How they follow the light.
    pub encoding: Encoding,
    /// Pixels of the sensor along a side of one pixel of the plane: 1 unless a mosaic of colours was binned.
    pub binning: usize,
}

impl RawFrame {
    /// Values that are proportional to light, as far as the file says.
    fn linear(plane: Plane, scale: FileScale) -> Self {
        Self { plane, scale, encoding: Encoding::Linear, binning: 1 }
    }
}

/// The sizes that a file declares, before any pixel is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Header {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// How many frames the file holds.
    pub frames: usize,
}

/// The size that a frame shall have, and the file that it comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected<'a> {
    /// The burst's first frame.
    pub first: &'a Path,
    /// Its (columns, rows).
    pub size: (usize, usize),
}

impl Expected<'_> {
    fn check(&self, path: &Path, size: (usize, usize)) -> Result<(), OpenError> {
        if size == self.size {
            return Ok(());
        }
        Err(OpenError::DifferentSizes { first: self.first.into(), first_size: self.size, path: path.into(), size })
    }
}

/// How many frames the file holds; reads as little as possible.
pub(super) fn frame_count(path: &Path) -> Result<usize, OpenError> {
    // Told by their names first, because this is asked of every picture of a folder.
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if RAW_EXTENSIONS.contains(&&*extension) {
        return Ok(1);
    }
    if ["png", "jpg", "jpeg", "pgm", "ppm", "pnm", "pbm", "pam", "webp", "bmp"].contains(&&*extension) {
        return Ok(1);
    }
    let (file, kind) = open(path)?;
    guarded(path, kind, || match kind {
        Kind::Raw => Ok(1),
        Kind::Npy => Ok(npy_header::read(path, file, &OpenOptions::default().limits)?.frames),
        Kind::Tiff => tiff::frame_count(path, file),
        Kind::Picture(_) => Ok(1),
    })
}

/// What the file declares, checked against the limits.
pub(super) fn header(path: &Path, options: &OpenOptions) -> Result<Header, OpenError> {
    let limits = &options.limits;
    let (file, kind) = open(path)?;
    guarded(path, kind, || match kind {
        #[cfg(feature = "raw")]
        Kind::Raw => raw::header(path, options),
        #[cfg(not(feature = "raw"))]
        Kind::Raw => Err(without_raw(path)),
        Kind::Npy => {
            let header = npy_header::read(path, file, limits)?;
            Ok(Header { width: header.width, height: header.height, frames: header.frames })
        }
        Kind::Tiff => tiff::header(path, file, limits),
        Kind::Picture(format) => image::header(path, file, format, limits),
    })
}

/// The frame of a file that holds one frame.
pub(super) fn frame(path: &Path, expected: Expected<'_>, options: &OpenOptions) -> Result<RawFrame, OpenError> {
    let limits = &options.limits;
    let (file, kind) = open(path)?;
    guarded(path, kind, || match kind {
        #[cfg(feature = "raw")]
        Kind::Raw => raw::frame(path, expected, options),
        #[cfg(not(feature = "raw"))]
        Kind::Raw => Err(without_raw(path)),
        Kind::Npy => npy::frame(path, file, expected, limits),
        Kind::Tiff => tiff::frame(path, file, expected, options),
        Kind::Picture(format) => image::frame(path, file, format, expected, options),
    })
}

/// All frames of a file that may hold several.
pub(super) fn stack(path: &Path, options: &OpenOptions, ticker: &Ticker<'_>) -> Result<Vec<RawFrame>, OpenError> {
    let limits = &options.limits;
    let (file, kind) = open(path)?;
    guarded(path, kind, || match kind {
        #[cfg(feature = "raw")]
        Kind::Raw => {
            let frame = raw::read(path, options)?;
            ticker.tick();
            Ok(vec![frame])
        }
        #[cfg(not(feature = "raw"))]
        Kind::Raw => Err(without_raw(path)),
        Kind::Npy => npy::stack(path, file, limits, ticker),
        Kind::Tiff => tiff::stack(path, file, options, ticker),
        Kind::Picture(format) => {
            let header = image::header(path, file, format, limits)?;
            let expected = Expected { first: path, size: (header.width, header.height) };
            let frame = frame(path, expected, options)?;
            ticker.tick();
            Ok(vec![frame])
        }
    })
}

/// Opens a regular file that is not empty and tells its kind. The file stands at its start.
fn open(path: &Path) -> Result<(File, Kind), OpenError> {
    let read_error = |e: std::io::Error| OpenError::from_io(path, &e);
    let metadata = std::fs::metadata(path).map_err(read_error)?;
    if !metadata.is_file() {
        return Err(OpenError::NotAFile { path: path.into() }); // opening a pipe would wait for ever
    }
    if metadata.len() == 0 {
        return Err(OpenError::EmptyFile { path: path.into() });
    }
    let mut file = File::open(path).map_err(read_error)?;
    let mut start = Vec::with_capacity(32);
    (&mut file).take(32).read_to_end(&mut start).map_err(read_error)?;
    file.seek(SeekFrom::Start(0)).map_err(read_error)?;
    // A raw file may lie in a film's container.
    if is_video(&start) && !has_raw_extension(path) {
        return Err(OpenError::Video { path: path.into() });
    }
    let kind = match kind_of(&start) {
        // What the program that wrote it calls raw; a DNG is one by whatever name.
        None | Some(Kind::Tiff) if has_raw_extension(path) => Kind::Raw,
        Some(Kind::Tiff) if tiff::is_dng(&file) => Kind::Raw,
        Some(kind) => kind,
        None => return Err(OpenError::UnknownKind { path: path.into() }),
    };
    file.seek(SeekFrom::Start(0)).map_err(read_error)?;
    Ok((file, kind))
}

/// What is said of raw files where nothing reads them.
#[cfg(not(feature = "raw"))]
fn without_raw(path: &Path) -> OpenError {
    OpenError::Unsupported {
        path: path.into(),
        kind: "raw",
        reason: "this program was built without raw frames (the feature 'raw'); convert it to a 16-bit TIFF".to_owned(),
    }
}

/// Runs a decoder. Should it panic over a file that nobody thought of, that is an error about the file, and the program
/// lives on; so is memory that the system refuses it.
fn guarded<T>(path: &Path, kind: Kind, decode: impl FnOnce() -> Result<T, OpenError>) -> Result<T, OpenError> {
    let decode =
        || memory::refusable(decode).unwrap_or_else(|refused| Err(OpenError::NoMemory { path: path.into(), refused }));
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode)).unwrap_or_else(|_| {
        Err(OpenError::Corrupt {
            path: path.into(),
            kind: kind.name(),
            reason: "its decoder failed unexpectedly".into(),
        })
    })
}

/// Makes a frame of values in file units whose scale the data tells. Fails over the first value that is not finite.
fn frame_from_data(
    path: &Path,
    frame: usize,
    size: (usize, usize),
    values: Vec<f32>,
    integer: bool,
) -> Result<RawFrame, OpenError> {
    // The bits of magnitudes are in the order of the magnitudes, infinity and NaN above all; integers are compared many
    // at a time.
    let largest = values.iter().fold(0, |largest, v| (v.to_bits() & 0x7fff_ffff).max(largest));
    let largest = f32::from_bits(largest);
    if !largest.is_finite() {
        let index = values.iter().position(|v| !v.is_finite()).expect("the largest one is not finite");
        let (u, v) = (index % size.0, index / size.0);
        return Err(OpenError::NotFinite { path: path.into(), frame, u, v, value: values[index] });
    }
    Ok(RawFrame::linear(Plane::from_vec(size.0, size.1, values), FileScale::Data { integer, largest }))
}

/// The error of a decoder's read: a file that ends early is damaged, anything else is the system's.
fn read_failure(path: &Path, kind: &'static str, error: &std::io::Error) -> OpenError {
    use std::io::ErrorKind::{InvalidData, InvalidInput, Other, UnexpectedEof};
    match error.kind() {
        UnexpectedEof => OpenError::Corrupt { path: path.into(), kind, reason: "it ends too early".into() },
        InvalidData | InvalidInput | Other => OpenError::Corrupt { path: path.into(), kind, reason: error.to_string() },
        _ => OpenError::from_io(path, error),
    }
}
