//! Messages between both processes: a length, JSON of that length, and pixels as in memory: both are of one program.

use crate::burst::options::{Limits, OpenOptions};
use crate::burst::reading::{RawFrame, corrupt};
use crate::error::{Error, Result};
use crate::plane::{Plane, memory};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::io::{self, Read, Write};
use std::path::Path;

const MAX_JSON_BYTES: u32 = 1 << 20;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Part {
    Only,
    /// A page of a TIFF, or a picture of a bag's topic, by its index in the file, which is this frame of the burst.
    Page {
        page: usize,
        frame: usize,
    },
}

/// Request to decode one file. Its path is an argument of the process, because a path need not be text.
#[derive(Debug, Serialize, Deserialize)]
pub struct DecodeRequest {
    /// The program's version, which must be that of both processes.
    pub version: String,
    pub part: Part,
    /// The first frame's file, for messages, and the size (columns, rows) that this one must have too.
    pub expected: Option<(String, (usize, usize))>,
    pub options: OpenOptions,
    pub limits: Limits,
    pub memory_bytes: u64,
    pub cpu_seconds: u64,
}

/// Size of a frame, and the frame without its pixels, which follow.
type Head<F> = ((usize, usize), F);

pub fn send(to: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    let text = serde_json::to_vec(value)?;
    to.write_all(&u32::try_from(text.len()).map_err(io::Error::other)?.to_le_bytes())?;
    to.write_all(&text)
}

pub fn receive<T: DeserializeOwned>(from: &mut impl Read) -> io::Result<T> {
    let mut length = [0; 4];
    from.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length);
    if length > MAX_JSON_BYTES {
        return Err(corrupt("an answer that is none"));
    }
    let mut text = vec![0; length as usize];
    from.read_exact(&mut text)?;
    Ok(serde_json::from_slice(&text)?)
}

pub fn send_reply(to: &mut impl Write, reply: Result<RawFrame>) -> io::Result<()> {
    match reply {
        Ok(frame) => {
            send(to, &Ok::<Head<_>, Error>((frame.plane.size(), &frame)))?;
            to.write_all(bytemuck::cast_slice(frame.plane.data()))
        }
        Err(error) => send(to, &Err::<Head<RawFrame>, _>(error)),
    }
}

/// Receives the reply about the file `path`. The outer error is a damaged reply, the inner one the child's own.
pub fn receive_reply(from: &mut impl Read, path: &Path, max: &Limits) -> io::Result<Result<RawFrame>> {
    let (size, frame): Head<RawFrame> = match receive(from)? {
        Ok(head) => head,
        Err(error) => return Ok(Err(error)),
    };
    // A crafted file may have taken over the child: its size is checked before room is made.
    if let Err(error) = max.check_frame(path, size.0 as u64, size.1 as u64) {
        return Ok(Err(error));
    }
    let mut values: Vec<f32> = memory::zeroed(size.0 * size.1);
    from.read_exact(bytemuck::cast_slice_mut(&mut values))?;
    Ok(Ok(RawFrame { plane: Plane::from_vec(size.0, size.1, values), ..frame }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::reading::FileScale;

    #[test]
    fn what_is_no_answer_is_an_error() {
        let read = |bytes: &[u8]| receive_reply(&mut &bytes[..], Path::new("a"), &Limits::default());
        assert!(read(b"").is_err() && read(&[255; 40]).is_err() && read(b"\x02\0\0\0{}").is_err());
        // A frame whose pixels are cut off.
        let mut bytes = Vec::new();
        let plane = Plane::zeros(3, 3);
        send_reply(&mut bytes, Ok(RawFrame::linear(plane, FileScale::Range(255.0)))).expect("memory");
        assert!(read(&bytes[..bytes.len() - 1]).is_err() && read(&bytes).is_ok());
    }
}
