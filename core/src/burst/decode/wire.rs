//! Messages between the program and the child process that decodes: a length, JSON of that length, and the pixels as
//! they are in memory, because both processes are of one program on one machine.

use super::{FileScale, RawFrame};
use crate::burst::error::OpenError;
use crate::burst::options::{Encoding, Limits, OpenOptions};
use crate::plane::memory::NoMemory;
use crate::plane::{Plane, memory};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::io::{self, Read, Write};
use std::path::Path;

/// Maximum length of the JSON, bytes.
const MAX_JSON_BYTES: u32 = 1 << 20;

/// Part of a file to decode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Part {
    /// The only frame of the file.
    Only,
    /// A page of a TIFF, and the frame of the burst that it is.
    Page {
        /// Index in the file.
        page: usize,
        /// Index in the burst.
        frame: usize,
    },
}

/// Request to decode one file. Its path is an argument of the process, because a path need not be text.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct DecodeRequest {
    /// The program's version, which must be that of both processes.
    pub version: String,
    /// Part of the file to decode.
    pub part: Part,
    /// Expected size (columns, rows), if any.
    pub expected: Option<(usize, usize)>,
    /// Options for opening, without calibration files.
    pub options: OpenOptions,
    /// Limits of the frame's size.
    pub limits: Limits,
    /// Memory that the process may address, bytes.
    pub memory_bytes: u64,
    /// Processor time that it may take, seconds.
    pub cpu_seconds: u64,
}

/// Head of a reply, before the pixels.
#[derive(Debug, Serialize, Deserialize)]
enum ReplyHead {
    Frame { size: (usize, usize), scale: ScaleData, encoding: Encoding, binning: usize, damage: Option<String> },
    Failed(Failure),
}

/// A [`FileScale`] whose numbers are stored bit for bit.
#[derive(Debug, Serialize, Deserialize)]
enum ScaleData {
    Range(u32),
    Raw(u32),
    Data { integer: bool, largest: u32 },
}

/// An [`OpenError`] about one file, without its path.
#[derive(Debug, Serialize, Deserialize)]
enum Failure {
    Read { reason: String },
    Corrupt { reason: String },
    Unsupported { reason: String },
    DifferentSizes { size: (usize, usize) },
    NotFinite { frame: usize, u: usize, v: usize, bits: u32 },
    ZeroSize { width: u64, height: u64 },
    BeyondLimit { found: String, limit: String, remedy: String },
    NoMemory { bytes: u64 },
}

/// Sends `value` as JSON after its length.
pub(super) fn send(to: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    let text = serde_json::to_vec(value)?;
    let length = u32::try_from(text.len()).map_err(io::Error::other)?;
    to.write_all(&length.to_le_bytes())?;
    to.write_all(&text)
}

/// Receives a value that [`send`] sent.
pub(super) fn receive<T: DeserializeOwned>(from: &mut impl Read) -> io::Result<T> {
    let mut length = [0; 4];
    from.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length);
    if length > MAX_JSON_BYTES {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "an answer that is none"));
    }
    let mut text = vec![0; length as usize];
    from.read_exact(&mut text)?;
    Ok(serde_json::from_slice(&text)?)
}

/// Sends the reply, with the pixels of a frame.
pub(super) fn send_reply(to: &mut impl Write, reply: Result<RawFrame, OpenError>) -> io::Result<()> {
    match reply {
        Ok(frame) => {
            let scale = match frame.scale {
                FileScale::Range(range) => ScaleData::Range(range.to_bits()),
                FileScale::Raw { white } => ScaleData::Raw(white.to_bits()),
                FileScale::Data { integer, largest } => ScaleData::Data { integer, largest: largest.to_bits() },
            };
            let RawFrame { plane, encoding, binning, damage, .. } = frame;
            send(to, &ReplyHead::Frame { size: plane.size(), scale, encoding, binning, damage })?;
            to.write_all(bytemuck::cast_slice(plane.data()))
        }
        Err(error) => send(to, &ReplyHead::Failed(Failure::of(error))),
    }
}

/// Receives the reply about the file `path` of the format `kind`; `first` is the file whose size was expected, with
/// that size.
///
/// # Errors
/// Outer: the reply is damaged or cut off. Inner: the child's error about the file, or a frame beyond `limits`.
pub(super) fn receive_reply(
    from: &mut impl Read,
    path: &Path,
    kind: &'static str,
    first: Option<(&Path, (usize, usize))>,
    limits: &Limits,
) -> io::Result<Result<RawFrame, OpenError>> {
    match receive(from)? {
        ReplyHead::Failed(failure) => Ok(Err(failure.into_error(path, kind, first))),
        ReplyHead::Frame { size, scale, encoding, binning, damage } => {
            if let Err(error) = limits.check_frame(path, size.0 as u64, size.1 as u64) {
                return Ok(Err(error));
            }
            let mut values: Vec<f32> = memory::zeroed(size.0 * size.1);
            from.read_exact(bytemuck::cast_slice_mut(&mut values))?;
            let number = f32::from_bits;
            let scale = match scale {
                ScaleData::Range(range) => FileScale::Range(number(range)),
                ScaleData::Raw(white) => FileScale::Raw { white: number(white) },
                ScaleData::Data { integer, largest } => FileScale::Data { integer, largest: number(largest) },
            };
            let plane = Plane::from_vec(size.0, size.1, values);
            Ok(Ok(RawFrame { plane, scale, encoding, binning, damage, misnamed: None }))
        }
    }
}

impl Failure {
    fn of(error: OpenError) -> Self {
        match error {
            OpenError::Read { reason, .. } => Self::Read { reason },
            OpenError::Corrupt { reason, .. } => Self::Corrupt { reason },
            OpenError::Unsupported { reason, .. } => Self::Unsupported { reason },
            OpenError::DifferentSizes { size, .. } => Self::DifferentSizes { size },
            OpenError::NotFinite { frame, u, v, value, .. } => Self::NotFinite { frame, u, v, bits: value.to_bits() },
            OpenError::ZeroSize { width, height, .. } => Self::ZeroSize { width, height },
            OpenError::BeyondLimit { found, limit, remedy, .. } => {
                Self::BeyondLimit { found, limit, remedy: remedy.into_owned() }
            }
            OpenError::NoMemory { refused, .. } => Self::NoMemory { bytes: refused.bytes },
            // A file that disappeared or changed between two reads.
            other => Self::Read { reason: other.to_string() },
        }
    }

    fn into_error(self, path: &Path, kind: &'static str, first: Option<(&Path, (usize, usize))>) -> OpenError {
        let path = path.to_path_buf();
        match self {
            Self::Read { reason } => OpenError::Read { path, reason },
            Self::Corrupt { reason } => OpenError::Corrupt { path, kind, reason },
            Self::Unsupported { reason } => OpenError::Unsupported { path, kind, reason },
            Self::DifferentSizes { size } => {
                let (first, first_size) = first.map_or((path.clone(), size), |(first, size)| (first.into(), size));
                OpenError::DifferentSizes { first, first_size, path, size }
            }
            Self::NotFinite { frame, u, v, bits } => {
                OpenError::NotFinite { path, frame, u, v, value: f32::from_bits(bits) }
            }
            Self::ZeroSize { width, height } => OpenError::ZeroSize { path, width, height },
            Self::BeyondLimit { found, limit, remedy } => {
                OpenError::BeyondLimit { path, found, limit, remedy: remedy.into() }
            }
            Self::NoMemory { bytes } => OpenError::NoMemory { path, refused: NoMemory { bytes } },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(reply: Result<RawFrame, OpenError>) -> Result<RawFrame, OpenError> {
        let mut bytes = Vec::new();
        send_reply(&mut bytes, reply).expect("memory takes everything");
        let first = Some((Path::new("first.dng"), (9, 9)));
        let limits = Limits::default();
        receive_reply(&mut &bytes[..], Path::new("a.dng"), "raw", first, &limits).expect("an answer")
    }

    #[test]
    fn frames_and_errors_come_through_as_they_are() {
        for scale in [
            FileScale::Range(65535.0),
            FileScale::Raw { white: 0.1 + 0.2 },
            FileScale::Data { integer: true, largest: f32::MAX },
        ] {
            let plane = Plane::from_vec(2, 2, vec![0.1, -0.0, f32::MIN_POSITIVE, 7.0]);
            let frame = RawFrame { encoding: Encoding::Srgb, binning: 2, ..RawFrame::linear(plane.clone(), scale) };
            let frame = RawFrame { damage: Some("it ends".to_owned()), ..frame };
            let found = sent(Ok(frame)).expect("a frame");
            assert_eq!((found.scale, found.encoding, found.binning), (scale, Encoding::Srgb, 2));
            assert_eq!((found.plane.size(), found.damage.as_deref()), ((2, 2), Some("it ends")));
            let bits = |plane: &Plane| plane.data().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&found.plane), bits(&plane));
        }
        let path = || Path::new("a.dng").to_path_buf();
        let text = || "why".to_owned();
        for error in [
            OpenError::Read { path: path(), reason: text() },
            OpenError::Corrupt { path: path(), kind: "raw", reason: text() },
            OpenError::Unsupported { path: path(), kind: "raw", reason: text() },
            OpenError::DifferentSizes { first: "first.dng".into(), first_size: (9, 9), path: path(), size: (1, 2) },
            OpenError::NotFinite { path: path(), frame: 0, u: 3, v: 4, value: f32::NEG_INFINITY },
            OpenError::ZeroSize { path: path(), width: 0, height: 5 },
            OpenError::BeyondLimit { path: path(), found: text(), limit: text(), remedy: "do that".into() },
            OpenError::NoMemory { path: path(), refused: NoMemory { bytes: 7 } },
        ] {
            assert_eq!(sent(Err(error.clone())).expect_err("an error"), error);
        }
    }

    #[test]
    fn what_is_no_answer_is_an_error() {
        let limits = Limits::default();
        let read = |bytes: &[u8]| receive_reply(&mut &bytes[..], Path::new("a"), "raw", None, &limits);
        assert!(read(b"").is_err() && read(&[255; 40]).is_err() && read(b"\x02\0\0\0{}").is_err());
        // A frame whose pixels are cut off.
        let mut bytes = Vec::new();
        let plane = Plane::zeros(3, 3);
        send_reply(&mut bytes, Ok(RawFrame::linear(plane, FileScale::Range(255.0)))).expect("memory");
        assert!(read(&bytes[..bytes.len() - 1]).is_err() && read(&bytes).is_ok());
    }
}
