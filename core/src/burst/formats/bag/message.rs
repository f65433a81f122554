//! ROS messages `sensor_msgs/Image` and `CompressedImage`, in ROS 1's form and as CDR of either byte order.

use super::records::Wire;
use crate::burst::reading::plain::{Places, Plain};
use crate::burst::{layout::Mosaic, number::Number, options::Limits};
use crate::error::{Error, Result};
use crate::plane::memory;
use std::{borrow::Cow, path::Path};

/// Encodings of pictures: name, numbers, samples of a pixel, whether blue comes first, mosaic.
const ENCODINGS: [(&str, Number, usize, bool, Option<Mosaic>); 24] = [
    ("mono8", Number::U8, 1, false, None),
    ("mono16", Number::U16, 1, false, None),
    ("8UC1", Number::U8, 1, false, None),
    ("16UC1", Number::U16, 1, false, None),
    ("32FC1", Number::F32, 1, false, None),
    ("64FC1", Number::F64, 1, false, None),
    ("rgb8", Number::U8, 3, false, None),
    ("bgr8", Number::U8, 3, true, None),
    ("rgba8", Number::U8, 4, false, None),
    ("bgra8", Number::U8, 4, true, None),
    ("8UC3", Number::U8, 3, true, None),
    ("8UC4", Number::U8, 4, true, None),
    ("rgb16", Number::U16, 3, false, None),
    ("bgr16", Number::U16, 3, true, None),
    ("rgba16", Number::U16, 4, false, None),
    ("bgra16", Number::U16, 4, true, None),
    ("bayer_rggb8", Number::U8, 1, false, Some(Mosaic::Rggb)),
    ("bayer_grbg8", Number::U8, 1, false, Some(Mosaic::Grbg)),
    ("bayer_gbrg8", Number::U8, 1, false, Some(Mosaic::Gbrg)),
    ("bayer_bggr8", Number::U8, 1, false, Some(Mosaic::Bggr)),
    ("bayer_rggb16", Number::U16, 1, false, Some(Mosaic::Rggb)),
    ("bayer_grbg16", Number::U16, 1, false, Some(Mosaic::Grbg)),
    ("bayer_gbrg16", Number::U16, 1, false, Some(Mosaic::Gbrg)),
    ("bayer_bggr16", Number::U16, 1, false, Some(Mosaic::Bggr)),
];

pub(super) const STAMP_BYTES: u64 = 16;

struct Fields<'a> {
    rest: &'a [u8],
    wire: Wire,
    big_endian: bool,
    /// Bytes since the place from which CDR aligns numbers.
    read: usize,
}

impl<'a> Fields<'a> {
    fn of(message: &'a [u8], wire: Wire) -> Result<Self, String> {
        if wire == Wire::Ros1 {
            return Ok(Self { rest: message, wire, big_endian: false, read: 0 });
        }
        let (head, rest) = message.split_first_chunk::<4>().ok_or("a message has no bytes")?;
        // Plain CDR of the first and of the second version; the lowest bit is the byte order.
        if !matches!(head, [0, 0 | 1 | 6 | 7, ..]) {
            return Err(format!("a message is serialised as {:02x}{:02x}, which is not CDR", head[0], head[1]));
        }
        Ok(Self { rest, wire, big_endian: head[1] & 1 == 0, read: 0 })
    }

    fn take(&mut self, count: usize, name: &str) -> Result<&'a [u8], String> {
        let taken = self.rest.split_at_checked(count);
        let (taken, rest) = taken.ok_or_else(|| format!("the field '{name}' of a message lies behind its end"))?;
        self.rest = rest;
        self.read += count;
        Ok(taken)
    }

    fn u32(&mut self, name: &str) -> Result<u32, String> {
        // CDR aligns each number to its size; ROS 1 packs them.
        if self.wire == Wire::Cdr {
            self.take(self.read.next_multiple_of(4) - self.read, name)?;
        }
        let mut bytes = [0; 4];
        bytes.copy_from_slice(self.take(4, name)?);
        Ok(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// Byte string: a 32-bit length, then the bytes.
    fn bytes(&mut self, name: &str) -> Result<&'a [u8], String> {
        let count = self.u32(name)?;
        self.take(count as usize, name)
    }

    fn text(&mut self, name: &str) -> Result<String, String> {
        Ok(String::from_utf8_lossy(self.bytes(name)?).trim_end_matches('\0').to_owned())
    }

    /// The stamp of the message's header, nanoseconds.
    fn stamp(&mut self) -> Result<u64, String> {
        // ROS 1 headers begin with a sequence number, which ROS 2 dropped.
        if self.wire == Wire::Ros1 {
            self.u32("header.seq")?;
        }
        let (s, ns) = (self.u32("header.stamp")?, self.u32("header.stamp")?);
        Ok(u64::from(s) * 1_000_000_000 + u64::from(ns))
    }
}

/// The stamp of a message of which at least the first [`STAMP_BYTES`] bytes are given, nanoseconds.
pub(super) fn stamp_ns(message: &[u8], wire: Wire) -> Result<u64, String> {
    Fields::of(message, wire)?.stamp()
}

#[derive(Debug, PartialEq)]
pub(super) struct PictureMessage<'a> {
    pub stamp_ns: u64,
    /// Encoding, or the format of a compressed picture.
    pub encoding: String,
    pub data: &'a [u8],
    /// Size (columns, rows), bytes of a row, byte order; of compressed pictures the data has them.
    shape: Option<([u32; 2], u32, bool)>,
}

impl<'a> PictureMessage<'a> {
    pub(super) fn read(message: &'a [u8], wire: Wire, is_compressed: bool) -> Result<Self, String> {
        let mut fields = Fields::of(message, wire)?;
        let stamp_ns = fields.stamp()?;
        fields.bytes("header.frame_id")?;
        if is_compressed {
            let encoding = fields.text("format")?;
            return Ok(Self { stamp_ns, encoding, data: fields.bytes("data")?, shape: None });
        }
        let (rows, columns) = (fields.u32("height")?, fields.u32("width")?);
        let encoding = fields.text("encoding")?;
        let big_endian = fields.take(1, "is_bigendian")?[0] != 0;
        let step = fields.u32("step")?;
        Ok(Self { stamp_ns, encoding, data: fields.bytes("data")?, shape: Some(([columns, rows], step, big_endian)) })
    }

    /// Mosaic that the encoding before compression names, such as `bayer_rggb8; jpeg compressed bayer_rggb8`.
    pub(super) fn mosaic(&self) -> Option<Mosaic> {
        let encoding = self.encoding.split(';').next().unwrap_or_default().trim();
        ENCODINGS.iter().find(|(name, ..)| *name == encoding).and_then(|(.., mosaic)| *mosaic)
    }

    pub(super) fn plain(&self, path: &Path, kind: &'static str, limits: &Limits) -> Result<(Plain, Cow<'a, [u8]>)> {
        let Self { encoding, data, shape, .. } = self;
        let corrupt = |reason: String| Error::corrupt(path, kind, reason);
        let ([width, height], step, big_endian) = shape.ok_or_else(|| corrupt("a picture has no shape".to_owned()))?;
        let found = ENCODINGS.iter().find(|(name, ..)| name == encoding).ok_or_else(|| {
            let reason = format!(
                "its pictures have the encoding '{encoding:.40}'; mono, Bayer, RGB and float ones are read: convert them \
                 with cv_bridge to mono8 or mono16"
            );
            Error::unsupported(path, kind, reason)
        })?;
        let (_, number, channels, is_bgr, mosaic) = *found;
        // The announced size is checked against the limits before any room is made for it.
        limits.check_frame(path, width.into(), height.into())?;
        let row = number.bytes(u64::from(width) * channels as u64) as usize;
        let (step, rows) = (step as usize, height as usize);
        if step < row {
            return Err(corrupt(format!("the field 'step' is {step}, and a row of {width} pixels has {row} bytes")));
        }
        // The last row may lack its padding.
        let bytes = step.saturating_mul(rows - 1).saturating_add(row);
        if data.len() < bytes {
            return Err(corrupt(format!("the field 'data' has {} bytes, and {bytes} are announced", data.len())));
        }
        let packed = match step == row {
            true => Cow::Borrowed(&data[..bytes]),
            false => {
                let mut packed = memory::with_capacity(row * rows);
                data.chunks(step).take(rows).for_each(|bytes| packed.extend_from_slice(&bytes[..row]));
                Cow::Owned(packed)
            }
        };
        // Colours of 8 bits are taken as encoded for screens; mono values are those of the sensor.
        let is_encoded = channels > 1 && number == Number::U8;
        let plain = Plain::new(kind, (width as usize, rows), Places::Listed(vec![0]), number);
        Ok((Plain { big_endian, channels, is_bgr, mosaic, is_encoded, ..plain }, packed))
    }
}
