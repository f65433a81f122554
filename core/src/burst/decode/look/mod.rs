//! Kind of a file, by its first bytes, and checks of the sizes that it declares, before any decoder reads it.
//!
//! A decoder takes memory and time as the file tells it to. So the sizes in the file's own structures are compared with
//! the file's length: a file that announces more than it could hold is damaged, and is refused with a reason. The check
//! reads headers only, and bounds its own memory. Here are single pictures: the chunks of PNG and WebP, and the pixels
//! of BMP and PNM, whose length follows from the header; [`directories`] checks TIFFs and raw files.

mod directories;

pub(super) use directories::{Directories, MAX_TEXT_BYTES};

use crate::burst::error::OpenError;
use image::ImageFormat;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Reads bytes of `file` from `at` on, as many as fill `buffer`.
///
/// # Errors
/// `Refusal::Io` where the file ends before or cannot be read.
fn read_at(file: &mut (impl Read + Seek), at: u64, buffer: &mut [u8]) -> Result<(), Refusal> {
    file.seek(SeekFrom::Start(at))?;
    Ok(file.read_exact(buffer)?)
}

/// Reason why a file is refused before a decoder reads it.
#[derive(Debug)]
pub(super) enum Refusal {
    /// The file announces the impossible: the end of a sentence about the file.
    Corrupt(String),
    /// The file announces more than the limit.
    TooLarge {
        /// The announced size, in words.
        found: String,
        /// Largest size allowed, in words.
        limit: String,
    },
    /// The file ends early or could not be read.
    Io(std::io::Error),
}

impl From<std::io::Error> for Refusal {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

impl Refusal {
    /// Refusal of a file that announces the impossible.
    pub(super) fn corrupt(reason: impl Into<String>) -> Self {
        Self::Corrupt(reason.into())
    }

    /// Converts to an error about the file `path` of the format `kind`.
    pub(super) fn into_error(self, path: &Path, kind: &'static str) -> OpenError {
        let path = path.to_path_buf();
        match self {
            Self::Corrupt(reason) => OpenError::Corrupt { path, kind, reason },
            Self::TooLarge { found, limit } => {
                OpenError::BeyondLimit { path, found, limit, remedy: "copy it again, or save it anew".into() }
            }
            Self::Io(error) => OpenError::from_read(&path, kind, &error),
        }
    }
}

/// Largest ratio of deflated data's length to its compressed length, about.
const DEFLATE_GAIN: u64 = 1040;

/// Checks a picture of `length` bytes.
///
/// # Errors
/// [`Refusal`] of a picture that announces more than it can hold.
pub(super) fn check_picture(file: &mut (impl Read + Seek), length: u64, format: ImageFormat) -> Result<(), Refusal> {
    match format {
        ImageFormat::Png => check_png(file, length),
        ImageFormat::WebP => check_webp(file, length),
        ImageFormat::Bmp => check_bmp(file, length),
        ImageFormat::Pnm => check_pnm(file, length),
        _ => Ok(()),
    }
}

/// Checks that the chunks up to the first one of the picture lie within the file, and that the picture has no more rows
/// than deflate can make of such a file.
fn check_png(file: &mut (impl Read + Seek), length: u64) -> Result<(), Refusal> {
    const CHUNKS: usize = 4096;
    let mut at = 8;
    for index in 0..CHUNKS {
        let mut head = [0; 8];
        if at + 8 > length {
            return Err(Refusal::corrupt("it ends before its picture data"));
        }
        read_at(file, at, &mut head)?;
        let size = u64::from(u32::from_be_bytes([head[0], head[1], head[2], head[3]]));
        let name = [head[4], head[5], head[6], head[7]];
        let end = at + 12 + size;
        if index == 0 {
            if &name != b"IHDR" || size != 13 {
                return Err(Refusal::corrupt("it does not begin with its size"));
            }
            let mut header = [0; 13];
            read_at(file, at + 8, &mut header)?;
            let side =
                |at: usize| u64::from(u32::from_be_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]));
            let samples = match header[9] {
                2 => 3,
                4 => 2,
                6 => 4,
                _ => 1,
            };
            let row = (side(0).saturating_mul(samples * u64::from(header[8]))).div_ceil(8);
            if side(4).saturating_mul(row) > length.saturating_mul(DEFLATE_GAIN) {
                return Err(Refusal::corrupt(format!(
                    "its {} bytes are too few for {}×{} pixels",
                    length,
                    side(0),
                    side(4)
                )));
            }
        }
        // Where the file ends within the picture's data, the decoder's message is better.
        if &name == b"IDAT" {
            return Ok(());
        }
        if end > length {
            let name = String::from_utf8_lossy(&name).into_owned();
            return Err(Refusal::corrupt(format!("its chunk {name} announces {size} bytes, more than are left")));
        }
        at = end;
    }
    Err(Refusal::corrupt(format!("it has more than {CHUNKS} chunks before its picture data")))
}

/// Checks that each chunk lies within the file.
fn check_webp(file: &mut (impl Read + Seek), length: u64) -> Result<(), Refusal> {
    const CHUNKS: usize = 1 << 16;
    let mut head = [0; 8];
    read_at(file, 0, &mut head)?;
    // Bytes after the announced end are ignored.
    let all = 8 + u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
    let mut at = 12;
    for _ in 0..CHUNKS {
        if at + 8 > length.min(all) {
            return Ok(());
        }
        read_at(file, at, &mut head)?;
        let size = u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
        let end = at + 8 + size;
        if end > length {
            let name = String::from_utf8_lossy(&head[..4]).into_owned();
            return Err(Refusal::corrupt(format!("its chunk {name} announces {size} bytes, more than are left")));
        }
        at = end + size % 2;
    }
    Err(Refusal::corrupt(format!("it has more than {CHUNKS} chunks")))
}

/// Checks that uncompressed pixels are as many as the header says.
fn check_bmp(file: &mut (impl Read + Seek), length: u64) -> Result<(), Refusal> {
    const PLAIN: [u32; 4] = [0, 3, 6, 11];
    let mut head = [0; 34];
    if length < 34 {
        return Err(Refusal::corrupt("it ends within its header"));
    }
    read_at(file, 0, &mut head)?;
    let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    // Headers of 12 bytes have another form, and are older than any camera.
    if number(14) < 40 || !PLAIN.contains(&number(30)) {
        return Ok(());
    }
    let (width, height) = (u64::from(number(18)), u64::from((number(22) as i32).unsigned_abs()));
    let bits = u64::from(u16::from_le_bytes([head[28], head[29]]));
    let bytes = width.saturating_mul(bits).div_ceil(32).saturating_mul(4).saturating_mul(height);
    if bytes.saturating_add(u64::from(number(10))) > length {
        return Err(Refusal::corrupt(format!(
            "its {length} bytes are too few for {width}×{height} pixels of {bits} bit"
        )));
    }
    Ok(())
}

/// Checks that binary pixels are as many as the header says, and that pixels in digits have a digit and a blank each.
fn check_pnm(file: &mut (impl Read + Seek), length: u64) -> Result<(), Refusal> {
    // Headers are short, but may have comments; a longer one is left to the decoder.
    let mut head = vec![0; usize::try_from(length).unwrap_or(usize::MAX).min(4096)];
    read_at(file, 0, &mut head)?;
    let Some([width, height, largest]) = pnm_numbers(&head) else { return Ok(()) };
    let samples = width.saturating_mul(height);
    let wide = 1 + u64::from(largest > 255);
    let bytes = match head.get(1) {
        Some(b'1') => samples,
        Some(b'2') => samples.saturating_mul(2) - 1,
        Some(b'3') => samples.saturating_mul(6) - 1,
        Some(b'4') => width.div_ceil(8).saturating_mul(height),
        Some(b'5') => samples.saturating_mul(wide),
        Some(b'6') => samples.saturating_mul(3 * wide),
        _ => return Ok(()),
    };
    if bytes > length {
        return Err(Refusal::corrupt(format!("its {length} bytes are too few for {width}×{height} pixels")));
    }
    Ok(())
}

/// Columns, rows and the largest value (1 where there is none) of the header of a P1 to P6; `None` for other data,
/// which is left to the decoder's error.
fn pnm_numbers(head: &[u8]) -> Option<[u64; 3]> {
    let mut numbers = [0, 0, 1];
    let mut rest = head.get(2..)?;
    let wanted = if matches!(head[1], b'1' | b'4') { 2 } else { 3 };
    for number in numbers.iter_mut().take(wanted) {
        loop {
            match rest {
                [b'#', comment @ ..] => rest = &comment[comment.iter().position(|b| matches!(b, b'\n' | b'\r'))?..],
                [blank, tail @ ..] if blank.is_ascii_whitespace() => rest = tail,
                _ => break,
            }
        }
        let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
        *number = std::str::from_utf8(&rest[..digits]).ok()?.parse().ok()?;
        rest = &rest[digits..];
    }
    (numbers[0] > 0 && numbers[1] > 0).then_some(numbers)
}

/// A kind of file that can be decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Values as the sensor gave them, in one of many formats.
    Raw,
    Npy,
    Tiff,
    Picture(::image::ImageFormat),
}

/// Extensions (lower case) of raw files; the decoder tells what they contain.
pub(in crate::burst) const RAW_EXTENSIONS: &[&str] = &[
    "dng", "nef", "nrw", "cr2", "cr3", "crw", "arw", "raf", "orf", "rw2", "rwl", "pef", "srw", "3fr", "fff", "iiq",
    "kdc", "dcr", "mrw", "erf", "mef", "mos", "x3f",
];

/// Whether the extension is one of a raw file.
pub(super) fn has_raw_extension(path: &Path) -> bool {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    extension.is_some_and(|e| RAW_EXTENSIONS.contains(&&*e))
}

/// Whether a file that begins with `start` is a video: MP4 and QuickTime (but not HEIF, which is a picture in the same
/// container), Matroska and WebM, AVI, MPEG, Flash, Windows Media, GIF.
pub(super) fn is_video(start: &[u8]) -> bool {
    let at = |place: usize, magic: &[u8]| start.get(place..).is_some_and(|rest| rest.starts_with(magic));
    let is_picture = [&b"hei"[..], b"hev", b"mif1", b"msf1", b"avi"].iter().any(|brand| at(8, brand));
    (at(4, b"ftyp") && !is_picture)
        || [&b"moov"[..], b"mdat", b"wide"].iter().any(|atom| at(4, atom))
        || (at(0, b"RIFF") && at(8, b"AVI "))
        || [
            &b"\x1a\x45\xdf\xa3"[..],
            b"\0\0\x01\xba",
            b"\0\0\x01\xb3",
            b"FLV\x01",
            b"\x30\x26\xb2\x75\x8e\x66\xcf\x11",
            b"GIF8",
        ]
        .iter()
        .any(|magic| at(0, magic))
}

/// Kind that a file's extension stands for, as [`Kind::name`] names it; `None` for other extensions.
pub(super) fn named_kind(path: &Path) -> Option<&'static str> {
    if has_raw_extension(path) {
        return Some(Kind::Raw.name());
    }
    Some(match &*path.extension()?.to_string_lossy().to_lowercase() {
        "png" => "PNG",
        "jpg" | "jpeg" => "JPEG",
        "tif" | "tiff" => "TIFF",
        "npy" => "NPY",
        "webp" => "WebP",
        "bmp" => "BMP",
        "pgm" | "ppm" | "pnm" | "pbm" | "pam" => "PNM",
        _ => return None,
    })
}

/// Error for a file that begins with `start`, which is no kind that can be decoded.
pub(super) fn unknown(path: &Path, start: &[u8]) -> OpenError {
    let path = path.to_path_buf();
    // A PNG's signature is made to show a transfer as text, which changes it.
    if start.get(1..4) == Some(b"PNG") || start.get(12..16) == Some(b"IHDR") {
        let reason = "its first bytes are changed, as by a transfer as text or of seven bits".to_owned();
        return OpenError::Corrupt { path, kind: "PNG", reason };
    }
    match named_kind(&path) {
        Some(named) => OpenError::NotAsNamed { path, named },
        None => OpenError::UnknownKind { path },
    }
}

/// Kind that the first bytes show; `None` for files that cannot be decoded.
pub(super) fn kind_of(start: &[u8]) -> Option<Kind> {
    use ::image::ImageFormat::{Bmp, Jpeg, Png, Pnm, WebP};
    if start.starts_with(b"\x93NUMPY") {
        return Some(Kind::Npy);
    }
    if [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| start.starts_with(*magic)) {
        return Some(Kind::Tiff);
    }
    match ::image::guess_format(start) {
        Ok(format @ (Png | Jpeg | Pnm | WebP | Bmp)) => Some(Kind::Picture(format)),
        _ => None,
    }
}

impl Kind {
    /// Name in messages.
    pub(super) fn name(self) -> &'static str {
        use ::image::ImageFormat::{Bmp, Jpeg, Png, Pnm, WebP};
        match self {
            Self::Raw => "raw",
            Self::Npy => "NPY",
            Self::Tiff => "TIFF",
            Self::Picture(Png) => "PNG",
            Self::Picture(Jpeg) => "JPEG",
            Self::Picture(Pnm) => "PNM",
            Self::Picture(WebP) => "WebP",
            Self::Picture(Bmp) => "BMP",
            Self::Picture(_) => "picture",
        }
    }
}
