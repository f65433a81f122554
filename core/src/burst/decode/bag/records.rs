//! Records of a recording as both of its formats with chunks have them: channels, messages, chunks, lists of messages;
//! and the reader of their numbers and texts, which never reads or reserves more than the file has.

use std::collections::{BTreeMap, HashMap};
use std::io::{self, BufReader, Read, Seek};

/// Longest name, or header of a record of a ROS 1 bag, bytes.
const MAX_FIELD_BYTES: u64 = 1 << 24;

/// Error of a file that announces the impossible; `reason` is the end of a sentence about it.
pub(super) fn corrupt(reason: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason.into())
}

/// Serialisation of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wire {
    Ros1,
    Cdr,
}

/// Messages of one writer to a topic.
#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub topic: String,
    /// Type of the messages, such as `sensor_msgs/Image`.
    pub of: String,
    /// `None` for serialisations that are not read.
    pub wire: Option<Wire>,
    pub count: u64,
    /// Messages without a list; of pictures alone.
    pub found: Vec<Message>,
}

impl Channel {
    pub(super) fn new(topic: String, of: &str, wire: Option<Wire>) -> Self {
        Self { topic, of: of.replace("/msg/", "/"), wire, count: 0, found: Vec::new() }
    }

    /// Whether its messages are pictures; those of a camera's own compression are no numbers.
    pub(super) fn has_pictures(&self) -> bool {
        self.wire.is_some() && (self.of == "sensor_msgs/Image" || self.is_compressed())
    }

    pub(super) fn is_compressed(&self) -> bool {
        self.of == "sensor_msgs/CompressedImage"
    }
}

/// Place of a message, and the time when it was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Message {
    /// Nanoseconds.
    pub recorded_ns: u64,
    /// Index of its chunk; 0 is the file itself.
    pub chunk: usize,
    /// Place of its record in the unpacked chunk, or its row.
    pub at: u64,
}

/// A file's list of the messages of a channel in a chunk.
#[derive(Debug, Clone, Copy)]
pub(super) struct List {
    pub channel: u32,
    pub chunk: usize,
    /// Place of its first entry in the file.
    pub at: u64,
    pub count: u64,
}

/// A part of the file that may be packed.
#[derive(Debug, Clone)]
pub(super) struct Chunk {
    pub at: u64,
    pub bytes: u64,
    /// Bytes when unpacked.
    pub size: u64,
    /// Name of the compression; empty for none.
    pub packed_by: String,
    /// Checksum of the unpacked bytes; 0 where there is none.
    pub crc: u32,
}

/// Records of a file.
#[derive(Debug, Default)]
pub(super) struct Contents {
    pub channels: BTreeMap<u32, Channel>,
    /// Names of the types of messages (MCAP).
    pub schemas: HashMap<u16, String>,
    /// The file itself, and the chunks.
    pub chunks: Vec<Chunk>,
    pub lists: Vec<List>,
}

impl Contents {
    pub(super) fn add(&mut self, channel: u32, message: Message) {
        if let Some(channel) = self.channels.get_mut(&channel) {
            channel.count += 1;
            if channel.has_pictures() {
                channel.found.push(message);
            }
        }
    }
}

/// Reader of records, which knows its place.
pub(super) struct Scan<R: Read + Seek> {
    reader: BufReader<R>,
    pub at: u64,
    pub length: u64,
}

impl<R: Read + Seek> Scan<R> {
    /// Begins at the place `at`, at which `reader` is too, of `length` bytes.
    pub(super) fn new(reader: R, at: u64, length: u64) -> Self {
        Self { reader: BufReader::with_capacity(512, reader), at, length }
    }

    pub(super) fn array<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.reader.read_exact(&mut bytes)?;
        self.at += N as u64;
        Ok(bytes)
    }

    pub(super) fn u16(&mut self) -> io::Result<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> io::Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> io::Result<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes after their number, of 32 bits.
    pub(super) fn field(&mut self) -> io::Result<Vec<u8>> {
        let count = self.u32()?;
        self.bytes(count.into())
    }

    pub(super) fn bytes(&mut self, count: u64) -> io::Result<Vec<u8>> {
        if count > self.length.saturating_sub(self.at) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        if count > MAX_FIELD_BYTES {
            return Err(corrupt(format!("a name or header in it announces {count} bytes")));
        }
        let mut bytes = vec![0; count as usize];
        self.reader.read_exact(&mut bytes)?;
        self.at += count;
        Ok(bytes)
    }

    pub(super) fn text(&mut self) -> io::Result<String> {
        Ok(String::from_utf8_lossy(&self.field()?).into_owned())
    }

    /// The place `bytes` behind this one, which must lie in the file.
    pub(super) fn after(&self, bytes: u64) -> io::Result<u64> {
        let end = self.at.checked_add(bytes).filter(|end| *end <= self.length);
        end.ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
    }

    /// Goes to the place `at`; one behind where it is already is damage.
    pub(super) fn skip_to(&mut self, at: u64) -> io::Result<()> {
        let by = at.checked_sub(self.at).ok_or_else(|| corrupt("a record is shorter than its fields"))?;
        self.reader.seek_relative(by as i64)?;
        self.at = at;
        Ok(())
    }

    pub(super) fn rest(mut self, bytes: u64) -> io::Result<Vec<u8>> {
        let mut found = Vec::new();
        (&mut self.reader).take(bytes).read_to_end(&mut found)?;
        Ok(found)
    }
}
