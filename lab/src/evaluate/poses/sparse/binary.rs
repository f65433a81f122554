//! Models in binary: little-endian numbers without padding, counts before lists.
//!
//! Every count is checked against the remaining bytes first, so that a damaged file takes neither memory nor time.

use super::{SparseImage, SparsePoint, world_from_camera};
use crate::evaluate::poses::{corrupt, unread};
use burstscope_core::error::{Error, Result};
use std::fmt::Display;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

const NO_POINT: u64 = u64::MAX;
/// Bytes of a keypoint in `images.bin`: x, y, id of its point.
const KEYPOINT_BYTES: u64 = 24;
/// Bytes of an image without name and keypoints: id, pose, camera, the name's end, number of keypoints.
const IMAGE_BYTES: u64 = 4 + 7 * 8 + 4 + 1 + 8;
/// Bytes of a point without its track: id, place, colour, error, length of the track.
const POINT_BYTES: u64 = 8 + 3 * 8 + 3 + 8 + 8;
/// Bytes of one element of a track: image, index of the keypoint.
const TRACK_BYTES: u64 = 8;
const LONGEST_NAME: usize = 4096;

pub(super) fn read_images(path: &Path) -> Result<Vec<SparseImage>> {
    let (file, bytes) = open(path)?;
    images(file, bytes, path)
}

pub(super) fn read_points(path: &Path) -> Result<Vec<SparsePoint>> {
    let (file, bytes) = open(path)?;
    points(file, bytes, path)
}

fn open(path: &Path) -> Result<(BufReader<File>, u64)> {
    let file = burstscope_core::files::open(path).map_err(|e| unread(path, &e))?;
    let bytes = file.metadata().map_err(|e| unread(path, &e))?.len();
    Ok((BufReader::with_capacity(1 << 16, file), bytes))
}

pub(super) fn images(stream: impl Read, bytes: u64, path: &Path) -> Result<Vec<SparseImage>> {
    let mut fields = Fields { stream, left: bytes, path, place: FilePart::Count("images") };
    let count = fields.count(IMAGE_BYTES)?;
    let mut images = Vec::new();
    for index in 0..count {
        fields.place = FilePart::Entry("image", index + 1, count);
        let id = fields.u32()?;
        let quaternion = fields.floats::<4>()?;
        let translation = fields.floats::<3>()?;
        let _camera_id = fields.u32()?;
        let name = fields.name()?;
        let keypoints = fields.count(KEYPOINT_BYTES)?;
        let mut points = 0;
        for _ in 0..keypoints {
            // Positions are read past, because a stream cannot skip them.
            fields.floats::<2>()?;
            points += usize::from(fields.u64()? != NO_POINT);
        }
        let world_from_camera = world_from_camera(quaternion, translation).map_err(|problem| fields.fail(problem))?;
        images.push(SparseImage { id, name, keypoints: keypoints as usize, points, world_from_camera });
    }
    Ok(images)
}

pub(super) fn points(stream: impl Read, bytes: u64, path: &Path) -> Result<Vec<SparsePoint>> {
    let mut fields = Fields { stream, left: bytes, path, place: FilePart::Count("points") };
    let count = fields.count(POINT_BYTES)?;
    let mut points = Vec::new();
    for index in 0..count {
        fields.place = FilePart::Entry("point", index + 1, count);
        points.push(point(&mut fields)?);
    }
    Ok(points)
}

fn point<R: Read>(fields: &mut Fields<'_, R>) -> Result<SparsePoint> {
    let _id = fields.u64()?;
    let position = fields.floats()?;
    fields.bytes::<3>()?;
    let [reprojection_error_px] = fields.floats()?;
    let track_length = fields.count(TRACK_BYTES)?;
    for _ in 0..track_length {
        fields.u64()?;
    }
    Ok(SparsePoint { position, reprojection_error_px, track_length: track_length as usize })
}

struct Fields<'a, R> {
    stream: R,
    left: u64,
    path: &'a Path,
    place: FilePart,
}

/// Place for messages: a number of things, or one thing with its number, from 1, of how many.
#[derive(Debug, Clone, Copy)]
enum FilePart {
    Count(&'static str),
    Entry(&'static str, u64, u64),
}

impl<R: Read> Fields<'_, R> {
    fn fail(&self, problem: impl Display) -> Error {
        let place = match self.place {
            FilePart::Count(things) => format!("the number of {things}"),
            FilePart::Entry(thing, number, count) => format!("{thing} {number} of {count}"),
        };
        corrupt(self.path, &place, problem)
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        if self.left < N as u64 {
            return Err(self.fail("the file ends too early; copy it again"));
        }
        self.stream.read_exact(&mut bytes).map_err(|e| unread(self.path, &e))?;
        self.left -= N as u64;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    fn u64(&mut self) -> Result<u64> {
        Ok(u64::from_le_bytes(self.bytes()?))
    }

    fn floats<const N: usize>(&mut self) -> Result<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = f64::from_le_bytes(self.bytes()?);
        }
        Ok(values)
    }

    /// A number of entries of at least `entry_bytes` bytes each, which must all fit into the remaining bytes.
    fn count(&mut self, entry_bytes: u64) -> Result<u64> {
        let count = self.u64()?;
        if count > self.left / entry_bytes {
            return Err(
                self.fail(format!("it announces {count} entries, for which the file is too short; copy it again"))
            );
        }
        Ok(count)
    }

    /// Text that ends with a zero byte.
    fn name(&mut self) -> Result<String> {
        let mut name = Vec::new();
        loop {
            match self.bytes::<1>()? {
                [0] => return Ok(String::from_utf8_lossy(&name).into_owned()),
                // In a damaged file the zero at the end may be missing.
                _ if name.len() == LONGEST_NAME => {
                    return Err(self.fail(format!("its name is longer than {LONGEST_NAME} bytes, so this is no name")));
                }
                [byte] => name.push(byte),
            }
        }
    }
}
