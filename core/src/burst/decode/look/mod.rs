//! Kind of a file, by its first bytes, and checks of the sizes that it declares, before any decoder reads it.
//!
//! A decoder takes memory and time as the file tells it to. So a file that announces more than its length could hold is
//! refused. The check reads headers only, and bounds its own memory; [`directories`] checks TIFFs and raw files.

mod directories;

pub(super) use directories::Directories;

#[cfg(feature = "bags")]
use super::bag::form;
use super::{fits, npy, ser, y4m};
use crate::error::{Error, ErrorKind};
use crate::files::shell_path;
use image::ImageFormat::{Bmp, Jpeg, Png, Pnm, WebP};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

fn read_at(file: &mut (impl Read + Seek), at: u64, buffer: &mut [u8]) -> io::Result<()> {
    file.seek(SeekFrom::Start(at))?;
    file.read_exact(buffer)
}

/// Error of a file that announces the impossible; `reason` is the end of a sentence about it.
fn corrupt(reason: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason.into())
}

/// Damage of a file of `length` bytes that announces more pixels than at most `pixels_a_byte` in each of them.
pub(super) fn too_few_bytes(length: u64, width: u64, height: u64, pixels_a_byte: u64) -> Option<String> {
    let is_possible = width.saturating_mul(height) / pixels_a_byte <= length;
    (!is_possible).then(|| format!("its {length} bytes are too few for {width}×{height} pixels"))
}

/// Checks that each chunk of a WebP of `length` bytes lies within it: the decoder would take memory for notes.
pub(super) fn check_webp(file: &mut (impl Read + Seek), length: u64) -> io::Result<()> {
    const CHUNKS: usize = 1 << 16;
    let mut head = [0; 8];
    let size_in = |head: [u8; 8]| u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
    read_at(file, 0, &mut head)?;
    // Bytes after the announced end are ignored.
    let end = length.min(8 + size_in(head));
    let mut at = 12;
    for _ in 0..CHUNKS {
        if at + 8 > end {
            return Ok(());
        }
        read_at(file, at, &mut head)?;
        let size = size_in(head);
        at += 8 + size;
        if at > length {
            let name = String::from_utf8_lossy(&head[..4]);
            return Err(corrupt(format!("its chunk {name} announces {size} bytes, more than are left")));
        }
        at += size % 2;
    }
    Err(corrupt(format!("it has more than {CHUNKS} chunks")))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Values as the sensor gave them, in one of many formats, which the decoder tells apart.
    Raw,
    Npy,
    Npz,
    Tiff,
    Fits,
    Ser,
    Y4m,
    /// A film in a container that `ffmpeg` reads.
    Film,
    /// A recording of a robot, of which a topic is taken.
    #[cfg(feature = "bags")]
    Bag,
    /// Values without a header.
    Dump,
    Picture(image::ImageFormat),
}

/// Kinds of files of one folder of which those of the first rank that is there are frames: beside pictures lie films of
/// them, results and lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::burst) enum Rank {
    Picture,
    Film,
    Other,
}

/// Each kind, its name in messages, its rank and its extensions.
const KINDS: &[(Kind, &str, Rank, &[&str])] = &[
    (Kind::Picture(Png), "PNG", Rank::Picture, &["png"]),
    (Kind::Tiff, "TIFF", Rank::Picture, &["tif", "tiff"]),
    (Kind::Npy, "NPY", Rank::Picture, &["npy"]),
    (Kind::Picture(Jpeg), "JPEG", Rank::Picture, &["jpg", "jpeg"]),
    (Kind::Picture(Pnm), "PNM", Rank::Picture, &["pgm", "ppm", "pnm", "pbm", "pam"]),
    (Kind::Picture(WebP), "WebP", Rank::Picture, &["webp"]),
    (Kind::Picture(Bmp), "BMP", Rank::Picture, &["bmp"]),
    (
        Kind::Raw,
        "raw",
        Rank::Picture,
        &[
            "dng", "nef", "nrw", "cr2", "cr3", "crw", "arw", "raf", "orf", "rw2", "rwl", "pef", "srw", "3fr", "fff",
            "iiq", "kdc", "dcr", "mrw", "erf", "mef", "mos", "x3f",
        ],
    ),
    (Kind::Fits, "FITS", Rank::Film, &["fits", "fit", "fts", "fz"]),
    (Kind::Ser, "SER", Rank::Film, &["ser"]),
    (Kind::Y4m, "Y4M", Rank::Film, &["y4m"]),
    (Kind::Npz, "NPZ", Rank::Other, &["npz"]),
    #[cfg(feature = "bags")]
    (Kind::Bag, "bag", Rank::Other, &["bag", "mcap", "db3"]),
    (Kind::Film, "film", Rank::Other, &["mp4", "mkv", "avi", "mov", "webm", "mpg", "gif"]),
    (Kind::Dump, "headerless", Rank::Other, &["raw", "bin", "dat"]),
];

/// Extensions (lower case) of all files that this program can open.
pub(in crate::burst) fn extensions() -> impl Iterator<Item = &'static str> {
    let can_open = |kind| cfg!(feature = "raw") || kind != Kind::Raw;
    KINDS.iter().filter(move |(kind, ..)| can_open(*kind)).flat_map(|(.., extensions)| extensions.iter().copied())
}

/// Rank of a file in its folder, by its name; `None` for files that cannot be opened.
pub(in crate::burst) fn rank(path: &Path) -> Option<Rank> {
    #[cfg(feature = "bags")]
    if form::is_metadata(path) {
        return Some(Rank::Film);
    }
    let kind = Kind::named(path).filter(|kind| cfg!(feature = "raw") || *kind != Kind::Raw)?;
    KINDS.iter().find(|(own, ..)| *own == kind).map(|(_, _, rank, _)| *rank)
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        KINDS.iter().find(|(kind, ..)| *kind == self).map_or("picture", |(_, name, ..)| name)
    }

    pub(super) fn named(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        KINDS.iter().find(|(.., extensions)| extensions.contains(&&*extension)).map(|(kind, ..)| *kind)
    }

    /// Kind that the first bytes show.
    pub(super) fn of(start: &[u8]) -> Option<Self> {
        let magics = [
            (npy::MAGIC, Self::Npy),
            (b"PK\x03\x04", Self::Npz),
            (fits::MAGIC, Self::Fits),
            (ser::MAGIC, Self::Ser),
            (y4m::MAGIC, Self::Y4m),
        ];
        if let Some((_, kind)) = magics.into_iter().find(|(magic, _)| start.starts_with(magic)) {
            return Some(kind);
        }
        #[cfg(feature = "bags")]
        if form::is_recording(start) {
            return Some(Self::Bag);
        }
        if [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| start.starts_with(*magic)) {
            return Some(Self::Tiff);
        }
        let kind = Self::Picture(image::guess_format(start).ok()?);
        KINDS.iter().any(|(known, ..)| *known == kind).then_some(kind)
    }
}

/// Name that `ffmpeg` has for the container of a video that begins with `start`: MP4 and QuickTime (but not HEIF, which
/// is a picture in the same container), Matroska and WebM, AVI, MPEG, Flash, Windows Media, GIF.
pub(super) fn container(start: &[u8]) -> Option<&'static str> {
    let at = |place: usize, magic: &[u8]| start.get(place..).is_some_and(|rest| rest.starts_with(magic));
    let is_picture = [&b"hei"[..], b"hev", b"mif1", b"msf1", b"avi"].iter().any(|brand| at(8, brand));
    let magics: [(usize, &[u8], &str); 10] = [
        (4, b"moov", "mov"),
        (4, b"mdat", "mov"),
        (4, b"wide", "mov"),
        (8, b"AVI ", "avi"),
        (0, b"\x1a\x45\xdf\xa3", "matroska"),
        (0, b"\0\0\x01\xba", "mpeg"),
        (0, b"\0\0\x01\xb3", "mpegvideo"),
        (0, b"FLV\x01", "flv"),
        (0, b"\x30\x26\xb2\x75\x8e\x66\xcf\x11", "asf"),
        (0, b"GIF8", "gif"),
    ];
    if at(4, b"ftyp") && !is_picture {
        return Some("mov");
    }
    let found = magics.into_iter().find(|(place, magic, _)| at(*place, magic)).map(|(.., name)| name);
    found.filter(|name| *name != "avi" || at(0, b"RIFF"))
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

/// Error for a file that begins with `start`, which is no kind that can be decoded.
pub(super) fn unknown(path: &Path, start: &[u8]) -> Error {
    // A PNG's signature is made to show a transfer as text, which changes it.
    if start.get(1..4) == Some(b"PNG") || start.get(12..16) == Some(b"IHDR") {
        let reason = "its first bytes are changed, as by a transfer as text or of seven bits";
        return Error::corrupt(path, "PNG", reason);
    }
    if let Some((_, name, way)) = OF_OTHERS.iter().find(|(magic, ..)| start.starts_with(magic)) {
        let remedy = way.replace("FILE", &shell_path(path));
        return Error::new(ErrorKind::Unsupported, format!("this is {name}, which is not opened here"), remedy)
            .about(path);
    }
    if let Some(named) = Kind::named(path) {
        let kind = named.name();
        let problem =
            format!("this file is named as a {kind} but does not begin like one: it is damaged or of another kind");
        return Error::damaged(path, problem);
    }
    let extensions = extensions().collect::<Vec<_>>().join(", ");
    let problem = format!("this is not a picture of a kind that can be opened ({extensions})");
    Error::new(
        ErrorKind::Unsupported,
        problem,
        "convert it to PNG or TIFF, say its shape with --raw if it has no header, or remove it",
    )
    .about(path)
}
