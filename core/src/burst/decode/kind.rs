//! Kind of a file: told by its first bytes, and for raw files also by their names.

use crate::burst::error::OpenError;
use std::path::Path;

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
    if start.get(1..4) == Some(b"PNG") {
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
