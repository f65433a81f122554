//! Records that both formats with chunks have: channels, messages, chunks, lists of messages; the reader of their
//! numbers and texts, which reads and reserves no more than the file has; and the work that all may take.

pub(super) use crate::burst::reading::corrupt;
use crate::{error::one_line, files::next_bytes, monitor::Monitor};
use std::collections::{BTreeMap, HashMap};
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Longest name, or header of a record of a ROS 1 bag, bytes.
const MAX_FIELD_BYTES: u64 = 1 << 24;

/// Bytes that a recording of any length may unpack to, and for each packed byte: frames are packed to a tenth at best.
const UNPACKED_BYTES: u64 = 1 << 28;
const UNPACKED_PER_BYTE: u64 = 1000;
/// Times that all may be unpacked: to look for messages, for their stamps, and for frames.
const PASSES: u64 = 3;
/// Records and instructions of a database that may be looked at whatever the length, and for each byte.
const STEPS: u64 = 1 << 26;
const STEPS_PER_BYTE: u64 = 256;
/// Bytes of unpacked chunks that are kept, so that those of a small recording are unpacked once.
const KEPT_BYTES: u64 = 1 << 26;

/// Budget of work for reading a recording; counts down from any thread, and ends at a cancellation.
#[derive(Debug)]
pub(super) struct Work {
    monitor: Monitor,
    bytes: AtomicU64,
    steps: AtomicU64,
    kept: AtomicU64,
    /// Whether the budget is fixed, whatever the file's length.
    is_quick: bool,
}

impl Work {
    /// Work for a recording, or for a quick look at it, which takes about a second and leaves the rest.
    pub(super) fn new(monitor: &Monitor, is_quick: bool) -> Self {
        let part = if is_quick { 4 } else { 1 };
        let [bytes, steps, kept] = [UNPACKED_BYTES * PASSES / part, STEPS / part, KEPT_BYTES].map(AtomicU64::new);
        Self { monitor: monitor.silent(), bytes, steps, kept, is_quick }
    }

    fn add(&self, of: &AtomicU64, count: u64, each: u64) {
        let count = if self.is_quick { 0 } else { count.saturating_mul(each) };
        let _ = of.fetch_update(Relaxed, Relaxed, |left| Some(left.saturating_add(count)));
    }

    pub(super) fn add_file(&self, length: u64) {
        self.add(&self.steps, length, STEPS_PER_BYTE);
    }

    /// Raises the budget by what `bytes` packed bytes allow, before they are unpacked.
    pub(super) fn add_packed(&self, bytes: u64) {
        self.add(&self.bytes, bytes, UNPACKED_PER_BYTE);
    }

    fn spent(of: &AtomicU64, count: u64) -> bool {
        of.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(count)).is_ok()
    }

    /// Takes `count` records or instructions; fails when the budget is spent or the work cancelled.
    pub(super) fn step(&self, count: u64) -> io::Result<()> {
        self.monitor.check().map_err(io::Error::other)?;
        match Self::spent(&self.steps, count) {
            true => Ok(()),
            false => {
                Err(io::Error::new(io::ErrorKind::QuotaExceeded, "it has far more records than its length allows"))
            }
        }
    }

    /// Fails early where `packed` bytes announce more unpacked bytes than they may.
    pub(super) fn check_unpacked(&self, packed: u64, unpacked: u64) -> io::Result<()> {
        let most = packed.saturating_mul(UNPACKED_PER_BYTE).saturating_add(UNPACKED_BYTES);
        let most = if self.is_quick { UNPACKED_BYTES / 4 } else { most };
        if unpacked <= most { Ok(()) } else { Err(Self::unpacks_to_too_much()) }
    }

    fn unpacks_to_too_much() -> io::Error {
        let (times, least) = (UNPACKED_PER_BYTE, UNPACKED_BYTES >> 20);
        let problem = format!("its packed parts become more than {times} times their length and {least} MiB");
        io::Error::new(io::ErrorKind::QuotaExceeded, problem)
    }

    /// Whether `bytes` unpacked bytes may stay in memory; they then count as kept.
    pub(super) fn keeps(&self, bytes: u64) -> bool {
        Self::spent(&self.kept, bytes)
    }
}

/// Reader of unpacked bytes, which counts them as work.
pub(super) struct Metered<'a, R> {
    pub reader: R,
    pub work: &'a Work,
}

impl<R: Read> Read for Metered<'_, R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        self.work.step(0)?;
        // Small blocks, so that no more than one is unpacked beyond the budget.
        let room = to.len().min(1 << 20);
        let count = self.reader.read(&mut to[..room])?;
        if Work::spent(&self.work.bytes, count as u64) { Ok(count) } else { Err(Work::unpacks_to_too_much()) }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wire {
    Ros1,
    Cdr,
}

#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub topic: String,
    /// Type of the messages, such as `sensor_msgs/Image`.
    pub of: String,
    /// `None` for serialisations that are not read.
    pub wire: Option<Wire>,
    pub count: u64,
    /// Messages of pictures that no list names.
    pub found: Vec<Message>,
}

impl Channel {
    pub(super) fn new(topic: String, of: &str, wire: Option<Wire>) -> Self {
        Self { topic, of: of.replace("/msg/", "/"), wire, count: 0, found: Vec::new() }
    }

    pub(super) fn has_pictures(&self) -> bool {
        self.wire.is_some() && (self.of == "sensor_msgs/Image" || self.is_compressed())
    }

    pub(super) fn is_compressed(&self) -> bool {
        self.of == "sensor_msgs/CompressedImage"
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Message {
    pub recorded_ns: u64,
    /// Index of its chunk; 0 is the file itself.
    pub chunk: usize,
    /// Offset of the record in the unpacked chunk, bytes; of a database, the row's id.
    pub at: u64,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct List {
    pub channel: u32,
    pub chunk: usize,
    /// Offset of the first entry in the file, bytes.
    pub at: u64,
    pub count: u64,
}

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

/// Checksum (CRC-32) of the bytes from `from` to `to` of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Checksum {
    pub from: u64,
    pub to: u64,
    pub crc: u32,
}

#[derive(Debug, Default)]
pub(super) struct Contents {
    pub channels: BTreeMap<u32, Channel>,
    /// Names of the types of messages (MCAP).
    pub schemas: HashMap<u16, String>,
    /// Index 0 is the file itself; the chunks follow.
    pub chunks: Vec<Chunk>,
    pub lists: Vec<List>,
    /// Of all before the summary, and of the summary, where the file has them (MCAP).
    pub data_checksum: Option<Checksum>,
    pub summary_checksum: Option<Checksum>,
    /// Whether the recording was stopped before its end was written, or that is cut off.
    pub is_open: bool,
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

pub(super) struct Scan<'a, R: Read + Seek> {
    reader: BufReader<R>,
    pub at: u64,
    pub length: u64,
    work: &'a Work,
}

impl<'a, R: Read + Seek> Scan<'a, R> {
    pub(super) fn new(mut reader: R, at: u64, length: u64, work: &'a Work) -> io::Result<Self> {
        reader.seek(SeekFrom::Start(at))?;
        Ok(Self { reader: BufReader::with_capacity(512, reader), at, length, work })
    }

    pub(super) fn ends_with<const N: usize>(&mut self, end: &[u8; N]) -> io::Result<bool> {
        let Some(before) = self.length.checked_sub(N as u64) else { return Ok(false) };
        self.reader.seek(SeekFrom::Start(before))?;
        let mut last = [0; N];
        self.reader.read_exact(&mut last)?;
        self.reader.seek(SeekFrom::Start(self.at))?;
        Ok(last == *end)
    }

    pub(super) fn goes_on(&self) -> io::Result<bool> {
        self.work.step(1)?;
        Ok(self.at < self.length)
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

    /// Bytes preceded by their 32-bit length.
    pub(super) fn field(&mut self) -> io::Result<Vec<u8>> {
        let count = self.u32()?;
        self.bytes(count.into())
    }

    pub(super) fn bytes(&mut self, count: u64) -> io::Result<Vec<u8>> {
        // Compared with the file before room is made: damage may announce gigabytes.
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
        Ok(one_line(&String::from_utf8_lossy(&self.field()?)))
    }

    /// Place `bytes` further on in the file; an error past the file's end.
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
        next_bytes(&mut self.reader, bytes)
    }
}
