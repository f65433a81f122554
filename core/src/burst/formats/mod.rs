//! Formats of files, each in a file or folder of its own, and one list of them: [`ALL`].
//!
//! A format says by which first bytes and extensions its files are known, what a file declares before any pixel is read
//! ([`Declared`]), and how frames are read; what formats share lies in [`reading`](super::reading). The kind of a file
//! is told by its first bytes, not by its name. Before a decoder runs, the sizes that the file declares are checked.
//! A new format is a file here and a line of the list, from which messages, dialogs and the guide's table are made.

#[cfg(feature = "bags")]
mod bag;
mod dump;
mod film;
mod fits;
mod npy;
mod picture;
#[cfg(feature = "raw")]
mod raw;
mod ser;
mod tiff;
#[cfg(test)]
mod toy;
mod y4m;

pub use dump::{LikelyShape, likely_shapes, shape_of};
pub(crate) use film::{Ran, ffmpeg, file_url, ran};

use super::options::{Limits, OpenOptions};
use super::reading::confined::{self, wire::Part};
use super::reading::{Declared, RawFrame, Reading, Ticker};
use super::reading::{pixels::with_mosaic, plain::Plain};
use super::times::Times;
use crate::error::{Error, ErrorKind, Result, one_line};
use crate::files::{self, shell_path};
use crate::{monitor::Monitor, plane::memory};
use rayon::prelude::*;
use std::io::{Seek, SeekFrom};
use std::{fs::File, path::Path};

/// All formats, in the order in which they are asked for a file; a list of extensions has this order too.
static ALL: &[&dyn Format] = &[
    &picture::PNG,
    &tiff::Tiff,
    &npy::Npy,
    &picture::JPEG,
    &picture::PNM,
    &picture::WEBP,
    &picture::BMP,
    &fits::Fits,
    &ser::Ser,
    &y4m::Y4m,
    &npy::Npz,
    #[cfg(feature = "bags")]
    &bag::Bag,
    #[cfg(feature = "raw")]
    &raw::Raw,
    &film::Film,
    &dump::Dump,
    #[cfg(test)]
    &toy::Toy,
];

/// Rank of a format in a folder: the frames are the files of the first rank there, beside results, films and lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    Picture,
    Film,
    Other,
}

/// Facts about a format: a row of the guide's table.
#[derive(Debug, Clone, Copy)]
pub struct FormatRecord {
    /// Name in messages, unique.
    pub name: &'static str,
    pub(super) rank: Rank,
    /// Extensions of its files, lower case.
    pub extensions: &'static [&'static str],
    /// What is taken as frames, a clause in Markdown.
    pub opens: &'static str,
    /// Options that act on its files, a clause in Markdown.
    pub options: &'static str,
}

use FormatRecord as Record;

/// The formats of this build.
pub fn file_formats() -> impl Iterator<Item = FormatRecord> {
    ALL.iter().map(|format| format.record())
}

pub(super) struct Start<'a> {
    pub path: &'a Path,
    /// The first bytes, at most 32.
    pub bytes: &'a [u8],
    pub length: u64,
    file: &'a File,
}

/// A file that is open at its start, not empty, and of a known format.
pub(super) struct Input {
    pub file: File,
    pub length: u64,
}

/// A format of files. Decoders may panic on damage: whoever calls takes that for damage.
pub(super) trait Format: Sync {
    fn record(&self) -> Record;

    /// Whether files that begin so are of this format.
    fn begins(&self, start: &Start<'_>) -> bool;

    /// Whether the options say that this file is of the format, whatever it begins with.
    fn is_asked_for(&self, _start: &Start<'_>, _options: &OpenOptions) -> bool {
        false
    }

    /// Whether a file of this name belongs to the format, whose extension does not say it.
    fn has_name(&self, _path: &Path) -> bool {
        false
    }

    /// Checks the lengths that the first `pages` pages of a file declare against its own, before a decoder trusts them.
    fn check(&self, _input: &Input, _path: &Path, _pages: usize) -> Result<()> {
        Ok(())
    }

    /// Number of frames, or 2 for any larger number: reads as little as possible.
    fn count(&self, _input: Input, _reading: Reading<'_>) -> Result<usize> {
        Ok(1)
    }

    /// Declarations before any pixel is read; the limits are checked.
    fn declared(&self, input: Input, reading: Reading<'_>) -> Result<Declared>;

    /// Times that the file gives for its frames. Decodes nothing.
    fn times(&self, input: Input, reading: Reading<'_>) -> Result<Times> {
        Ok(self.declared(input, reading)?.times)
    }

    fn frames(&self, input: Input, reading: Reading<'_>) -> Result<Vec<RawFrame>> {
        alone(reading, self.only(input, reading)?)
    }

    /// The frame of a file that has one; of the expected size.
    fn only(&self, input: Input, reading: Reading<'_>) -> Result<RawFrame>;

    /// Page `page` of the file, which is frame `frame` of its burst: for a process that decodes one of them.
    fn page(&self, input: Input, reading: Reading<'_>, _page: usize, _frame: usize) -> Result<RawFrame> {
        self.only(input, reading)
    }
}

pub(super) trait Numbers: Sync {
    /// First bytes of the files; `None` where the options alone say what is of the format.
    const MAGIC: Option<&'static [u8]>;

    fn record(&self) -> Record;

    fn is_asked_for(&self, _start: &Start<'_>, _options: &OpenOptions) -> bool {
        false
    }

    /// Compares the sum that the file states of its numbers, where it does, before they are read.
    fn verify(&self, _input: &Input, _reading: Reading<'_>) -> Result<()> {
        Ok(())
    }

    /// All frames of the file; `options` have limits for a whole file, of which a part may be taken.
    fn plain(&self, input: Input, path: &Path, options: &OpenOptions) -> Result<Plain>;
}

impl<N: Numbers> Format for N {
    fn record(&self) -> Record {
        Numbers::record(self)
    }

    fn begins(&self, start: &Start<'_>) -> bool {
        N::MAGIC.is_some_and(|magic| start.bytes.starts_with(magic))
    }

    fn is_asked_for(&self, start: &Start<'_>, options: &OpenOptions) -> bool {
        Numbers::is_asked_for(self, start, options)
    }

    fn count(&self, input: Input, reading: Reading<'_>) -> Result<usize> {
        Ok(part_of(self, input, reading)?.places.len())
    }

    fn declared(&self, input: Input, reading: Reading<'_>) -> Result<Declared> {
        Ok(part_of(self, input, reading)?.declared())
    }

    fn frames(&self, input: Input, reading: Reading<'_>) -> Result<Vec<RawFrame>> {
        self.verify(&input, reading)?;
        part_of(self, input, reading)?.stack(reading)
    }

    fn only(&self, input: Input, reading: Reading<'_>) -> Result<RawFrame> {
        self.verify(&input, reading)?;
        part_of(self, input, reading)?.only(reading)
    }

    fn page(&self, input: Input, reading: Reading<'_>, page: usize, _frame: usize) -> Result<RawFrame> {
        part_of(self, input, reading)?.page(reading, page)
    }
}

fn part_of(format: &impl Numbers, input: Input, reading: Reading<'_>) -> Result<Plain> {
    let Reading { path, options, .. } = reading;
    format.plain(input, path, &options.of_whole())?.part(path, options)
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|own| extensions.contains(&&*own.to_string_lossy().to_lowercase()))
}

fn named(path: &Path) -> Option<&'static dyn Format> {
    ALL.iter().copied().find(|format| has_extension(path, format.record().extensions))
}

pub(super) fn extensions() -> impl Iterator<Item = &'static str> {
    ALL.iter().flat_map(|format| format.record().extensions.iter().copied())
}

pub(super) fn rank(path: &Path) -> Option<Rank> {
    if ALL.iter().any(|format| format.has_name(path)) {
        return Some(Rank::Film);
    }
    named(path).map(|format| format.record().rank)
}

fn found(path: &Path, options: &OpenOptions) -> Result<(&'static dyn Format, Input)> {
    let read_error = |e: std::io::Error| Error::from_io(path, &e);
    let metadata = std::fs::metadata(path).map_err(read_error)?;
    if !metadata.is_file() {
        return Err(Error::not_a_file(path));
    }
    let length = metadata.len();
    if length == 0 {
        return Err(Error::damaged(path, "this file is empty (0 bytes)"));
    }
    let mut file = files::open(path).map_err(read_error)?;
    let bytes = files::next_bytes(&mut file, 32).map_err(read_error)?;
    let start = Start { path, bytes: &bytes, length, file: &file };
    // Options come first: a file without header may begin like any format.
    let asked = ALL.iter().find(|format| format.is_asked_for(&start, options));
    let format = asked.or_else(|| ALL.iter().find(|format| format.begins(&start)));
    let format = *format.ok_or_else(|| unknown(&start, &options.limits))?;
    file.seek(SeekFrom::Start(0)).map_err(read_error)?;
    Ok((format, Input { file, length }))
}

/// Does `work` with the format and the file. A decoder's panic or refused memory becomes an error about the file.
fn with_format<T>(
    reading: Reading<'_>,
    pages: usize,
    work: impl FnOnce(&dyn Format, Input) -> Result<T>,
) -> Result<(T, &'static str)> {
    let path = reading.path;
    let (format, input) = found(path, reading.options)?;
    let name = format.record().name;
    let decode = || format.check(&input, path, pages).and_then(|()| work(format, input));
    let decode = || memory::refusable(decode).unwrap_or_else(|refused| Err(refused.about(path)));
    let decoded = std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err(Error::corrupt(path, name, "its decoder failed unexpectedly")));
    // Names in a file may hold anything.
    let decoded = decoded.map_err(|e| Error { problem: one_line(&e.problem), remedy: one_line(&e.remedy), ..e })?;
    Ok((decoded, name))
}

/// Formats that others read: first bytes, name, and the way to frames, in which FILE is the path, as a word of a shell.
const OF_OTHERS: [(&[u8], &str, &str); 11] = [
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file (also MATLAB's .mat of version 7.3)",
        "save its frames as an array: python3 -c \"import sys, h5py, numpy; numpy.save('frames.npy', h5py.File(sys.argv[1])['NAME'][:])\" FILE; h5py.File(…).keys() has the names",
    ),
    (
        b"MATLAB 5.0 MAT",
        "a MATLAB file",
        "save its frames as an array: python3 -c \"import sys, scipy.io, numpy; numpy.save('frames.npy', scipy.io.loadmat(sys.argv[1])['NAME'])\" FILE",
    ),
    (b"#ROSBAG V", "a ROS 1 bag", ROS),
    (b"\x89MCAP0\r\n", "a bag in MCAP", ROS),
    (b"SQLite format 3\0", "a database, as ROS 2 records them", ROS),
    (b"\x1f\x8b", "a file that gzip compressed", "unpack it first: gunzip --keep FILE"),
    (
        b"v/1\x01",
        "an OpenEXR picture",
        "save it as TIFF: python3 -c \"import sys, imageio.v3 as i; i.imwrite('frame.tiff', i.imread(sys.argv[1]).astype('float32'))\" FILE",
    ),
    (b"\0\0\0\x0cjP  ", "a JPEG 2000 picture", "convert it to a 16-bit PNG: opj_decompress -i FILE -o frame.png"),
    (b"\0\0\0\x0cJXL ", "a JPEG XL picture", "convert it to a 16-bit PNG: djxl FILE frame.png"),
    (b"ZISRAWFILE", "a CZI file of microscopes", MICROSCOPE),
    (b"\xda\xce\xbe\x0a", "an ND2 file of microscopes", MICROSCOPE),
];

const ROS: &str = "save its pictures as an array: python3 -c \"import sys, numpy; from rosbags.highlevel import AnyReader; from rosbags.image import message_to_cvimage; \
     from pathlib import Path; r = AnyReader([Path(sys.argv[1])]); r.open(); numpy.save('frames.npy', [message_to_cvimage(r.deserialize(m, c.msgtype)) \
     for c, _, m in r.messages() if c.topic == 'TOPIC'])\" FILE";
const MICROSCOPE: &str = "convert it to OME-TIFF: bfconvert FILE frames.ome.tiff";

fn unknown(start: &Start<'_>, limits: &Limits) -> Error {
    let Start { path, bytes, length, .. } = *start;
    // A PNG's signature is made to show a transfer as text, which changes it.
    if bytes.get(1..4) == Some(b"PNG") || bytes.get(12..16) == Some(b"IHDR") {
        let reason = "its first bytes are changed, as by a transfer as text or of seven bits";
        return Error::corrupt(path, "PNG", reason);
    }
    if let Some((_, name, way)) = OF_OTHERS.iter().find(|(magic, ..)| bytes.starts_with(magic)) {
        let remedy = way.replace("FILE", &shell_path(path));
        return Error::new(ErrorKind::Unsupported, format!("this is {name}, which is not opened here"), remedy)
            .about(path);
    }
    if named(path).is_none() && tiff::is_of_sensor(start) {
        let reason = "this program was built without raw frames (the feature 'raw'); convert it to a 16-bit TIFF";
        return Error::unsupported(path, "raw", reason);
    }
    match named(path).map(|format| format.record().name) {
        Some(dump::NAME) => dump::without_shape(path, length, limits),
        Some(kind) => {
            let problem =
                format!("this file is named as a {kind} but does not begin like one: it is damaged or of another kind");
            Error::damaged(path, problem)
        }
        None => {
            let extensions = extensions().collect::<Vec<_>>().join(", ");
            let problem = format!("this is not a picture of a kind that can be opened ({extensions})");
            let remedy = "convert it to PNG or TIFF, say its shape with --raw if it has no header, or remove it";
            Error::new(ErrorKind::Unsupported, problem, remedy).about(path)
        }
    }
}

/// Number of frames in the file, for a TIFF and a film at most 2; reads as little as possible.
pub(super) fn frame_count(path: &Path, options: &OpenOptions) -> Result<usize> {
    if let Some(grid) = options.views.and_then(|views| views.picture()) {
        return Ok(grid.0.count());
    }
    // A thumbnail may lie between two pages.
    const PAGES: usize = 3;
    let limits = Limits { max_frames: usize::MAX, ..Limits::default() };
    let whole = &OpenOptions { limits, take: None, ..options.clone() };
    let quiet = Monitor::default();
    let ticker = Ticker::new(&quiet, 1);
    let reading = Reading::new(path, whole, &ticker);
    Ok(with_format(reading, PAGES, |format, input| format.count(input, reading))?.0)
}

pub(super) fn declared(path: &Path, options: &OpenOptions, monitor: &Monitor) -> Result<Declared> {
    let ticker = Ticker::new(monitor, 1);
    let reading = Reading::new(path, options, &ticker);
    let (mut found, _) = with_format(reading, usize::MAX, |format, input| format.declared(input, reading))?;
    found.taken.iter_mut().for_each(|taken| *taken = one_line(taken));
    if let (Some(mosaic), None) = (found.mosaic, options.mosaic) {
        let named = format!("{mosaic:?}").to_lowercase();
        let told = "squares of 2×2 pixels become one; --mosaic none leaves them as they are";
        found.taken.push(format!("the mosaic of colours is what the file says, {named}: {told}"));
    }
    if let Some(frame) = &mut found.first {
        frame.misnamed = misnamed(path, found.kind);
    }
    Ok(found)
}

/// Name of the format of a file, where its extension names another.
fn misnamed(path: &Path, format: &'static str) -> Option<&'static str> {
    let named = named(path)?.record();
    (named.name != format && named.name != dump::NAME).then_some(format)
}

pub(super) fn times(path: &Path, options: &OpenOptions, monitor: &Monitor) -> Result<Times> {
    let ticker = Ticker::new(monitor, 1);
    let reading = Reading::new(path, options, &ticker);
    Ok(with_format(reading, usize::MAX, |format, input| format.times(input, reading))?.0)
}

/// The only frame of a file, with the mosaic binned.
pub(super) fn frame(reading: Reading<'_>) -> Result<RawFrame> {
    let (frame, name) = with_format(reading, usize::MAX, |format, input| format.only(input, reading))?;
    finished(reading, name, frame)
}

pub(super) fn stack(reading: Reading<'_>) -> Result<Vec<RawFrame>> {
    let (frames, name) = with_format(reading, usize::MAX, |format, input| format.frames(input, reading))?;
    frames.into_par_iter().map(|frame| finished(reading, name, frame)).collect()
}

fn finished(reading: Reading<'_>, name: &'static str, frame: RawFrame) -> Result<RawFrame> {
    with_mosaic(reading.path, RawFrame { misnamed: misnamed(reading.path, name), ..frame }, reading.options)
}

fn alone(reading: Reading<'_>, frame: RawFrame) -> Result<Vec<RawFrame>> {
    reading.ticker.tick();
    reading.options.taken(reading.path, vec![frame], (1, 1))
}

/// The main function of a program started as a [`DecodeWorker`](super::DecodeWorker): decodes the file `path` as the
/// request on standard input says, and writes it to standard output. Returns the exit code.
pub fn serve_decoding(path: &Path) -> u8 {
    confined::serve::serve_decoding(path, |reading, part| match part {
        // Mosaics are binned where the frame was asked for.
        Part::Only => Ok(with_format(reading, usize::MAX, |format, input| format.only(input, reading))?.0),
        Part::Page { page, frame } => {
            Ok(with_format(reading, usize::MAX, |format, input| format.page(input, reading, page, frame))?.0)
        }
    })
}
