//! One file of a recording: its topics, the places of their messages, and the bytes of these. Chunks of messages are
//! unpacked one at a time by each thread; where nothing is packed, messages are read from their places in the file.

use super::form::Form;
use super::records::{Channel, Chunk, Contents, List, Message, Scan, corrupt};
use super::{mcap, ros1, rows};
use crate::burst::decode::{Ticker, in_order};
use crate::burst::options::Limits;
use crate::error::{Error, ErrorKind, Result};
use crate::plane::memory;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// First bytes of what Zstandard packed, also a single message of a ROS 2 bag.
const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";

/// One file of a recording.
#[derive(Debug)]
pub(super) struct Segment {
    pub path: PathBuf,
    pub form: Form,
    pub contents: Contents,
    /// Largest number of bytes of a chunk or message.
    most: u64,
}

impl Segment {
    /// Reads the file's records, and of its chunks those alone that no list describes.
    pub(super) fn open(path: &Path, limits: &Limits) -> Result<Self> {
        let fail = |e: io::Error| Error::from_io(path, &e);
        let mut file = File::open(path).map_err(fail)?;
        let length = file.metadata().map_err(fail)?.len();
        let mut start = Vec::new();
        (&mut file).take(32).read_to_end(&mut start).map_err(fail)?;
        let Some(form) = Form::of(&start) else { return Err(unknown(path, &start)) };
        // A picture of four samples of four bytes, and all else that is recorded with it.
        let most = limits.max_pixels.saturating_mul(16).saturating_add(1 << 26);
        let whole = Chunk { at: 0, bytes: length, size: length, packed_by: String::new(), crc: 0 };
        let contents = Contents { chunks: vec![whole], ..Contents::default() };
        let mut segment = Self { path: path.to_owned(), form, contents, most };
        if form == Form::Rows {
            let channels = rows::check_length(&start, length).and_then(|()| rows::channels(path));
            segment.contents.channels = channels.map_err(|e| segment.failure(&e))?;
            return Ok(segment);
        }
        let mut found = std::mem::take(&mut segment.contents);
        segment.walk(file, length, 0, &mut found).map_err(|e| segment.failure(&e))?;
        // Whether the channels of a chunk's lists are known; `None` for one without lists.
        let mut is_known = vec![None; found.chunks.len()];
        for List { channel, chunk, .. } in &found.lists {
            is_known[*chunk] = Some(is_known[*chunk] != Some(false) && found.channels.contains_key(channel));
        }
        for chunk in (1..found.chunks.len()).filter(|chunk| is_known[*chunk] != Some(true)) {
            let unpacked = segment.unpacked(&found.chunks[chunk])?;
            let length = unpacked.len() as u64;
            segment.walk(Cursor::new(unpacked), length, chunk, &mut found).map_err(|e| segment.failure(&e))?;
        }
        found.lists.retain(|list| is_known[list.chunk] == Some(true));
        for list in &found.lists {
            if let Some(channel) = found.channels.get_mut(&list.channel) {
                channel.count = channel.count.saturating_add(list.count);
            }
        }
        Ok(Self { contents: found, ..segment })
    }

    fn walk(&self, reader: impl Read + Seek, length: u64, chunk: usize, found: &mut Contents) -> io::Result<()> {
        match self.form {
            Form::Ros1 => ros1::walk(reader, length, chunk, found),
            _ => mcap::walk(reader, length, chunk, found),
        }
    }

    /// Error for a file that cannot be read, with the program that mends damage.
    fn failure(&self, error: &io::Error) -> Error {
        if error.kind() == io::ErrorKind::Unsupported {
            return Error::unsupported(&self.path, self.form.name(), error);
        }
        let error = Error::from_read(&self.path, self.form.name(), error);
        if error.kind != ErrorKind::Damaged {
            return error;
        }
        Error { remedy: format!("copy it again, or save what is whole with '{}'", self.form.repair()), ..error }
    }

    /// Error for a message whose content cannot be read; `reason` names the field.
    pub(super) fn wrong(&self, reason: impl std::fmt::Display) -> Error {
        Error::corrupt(&self.path, self.form.name(), reason)
    }

    /// The messages of the topic and type of `like`, in the order of their recording.
    pub(super) fn messages(&self, like: &Channel, limits: &Limits) -> Result<Vec<Message>> {
        let is_like =
            |channel: &Channel| (&channel.topic, &channel.of, channel.wire) == (&like.topic, &like.of, like.wire);
        let of_topic = || self.contents.channels.iter().filter(|(_, channel)| is_like(channel));
        let count = of_topic().fold(0u64, |sum, (_, channel)| sum.saturating_add(channel.count));
        limits.check_burst(&self.path, count, 1, 1)?;
        let fail = |e: io::Error| self.failure(&e);
        let mut messages = Vec::new();
        for (id, channel) in of_topic() {
            messages.extend(&channel.found);
            if self.form == Form::Rows {
                messages.extend(rows::messages(&self.path, *id, channel.count).map_err(fail)?);
            }
            for list in self.contents.lists.iter().filter(|list| list.channel == *id) {
                let mut file = File::open(&self.path).map_err(fail)?;
                file.seek(SeekFrom::Start(list.at)).map_err(fail)?;
                let mut scan = Scan::new(file, list.at, self.contents.chunks[0].size);
                for _ in 0..list.count {
                    let entry = if self.form == Form::Ros1 { ros1::entry(&mut scan) } else { mcap::entry(&mut scan) };
                    let (recorded_ns, at) = entry.map_err(fail)?;
                    messages.push(Message { recorded_ns, chunk: list.chunk, at });
                }
            }
        }
        messages.sort_by_key(|message| message.recorded_ns);
        Ok(messages)
    }

    /// Computes `f(k, bytes)` of each message in parallel, of its first `most` bytes at least.
    pub(super) fn each<T: Send>(
        &self,
        messages: &[Message],
        most: u64,
        ticker: &Ticker<'_>,
        f: impl Fn(usize, &[u8]) -> Result<T> + Sync,
    ) -> Result<Vec<T>> {
        let mut order: Vec<usize> = (0..messages.len()).collect();
        order.sort_by_key(|k| (messages[*k].chunk, messages[*k].at));
        let chunk_of = |k: usize| messages[k].chunk;
        let is_packed = |chunk: usize| !self.contents.chunks[chunk].packed_by.is_empty();
        // A chunk is unpacked once for all of its messages.
        let runs: Vec<&[usize]> =
            order.chunk_by(|a, b| chunk_of(*a) == chunk_of(*b) && is_packed(chunk_of(*a))).collect();
        let answers = in_order(runs.len(), |run| {
            ticker.check()?;
            let chunk = chunk_of(runs[run][0]);
            let unpacked = is_packed(chunk).then(|| self.unpacked(&self.contents.chunks[chunk])).transpose()?;
            let bytes = |message, most| self.bytes(message, unpacked.as_deref(), most).map_err(|e| self.failure(&e));
            let of_run = runs[run].iter().map(|k| {
                let mut message = bytes(messages[*k], most)?;
                if self.form != Form::Ros1 && message.starts_with(ZSTD) {
                    let packed = bytes(messages[*k], self.most)?;
                    let mut reader = unpacker("zstd", Box::new(&packed[..])).map_err(|e| self.failure(&e))?;
                    message.clear();
                    (&mut reader).take(self.most).read_to_end(&mut message).map_err(|e| self.failure(&e))?;
                }
                f(*k, &message)
            });
            of_run.collect::<Result<Vec<T>>>()
        })?;
        let mut all: Vec<(usize, T)> = order.into_iter().zip(answers.into_iter().flatten()).collect();
        all.sort_by_key(|(k, _)| *k);
        Ok(all.into_iter().map(|(_, answer)| answer).collect())
    }

    /// The first bytes of a message, at most `most`; `unpacked` is its chunk, where that is packed.
    fn bytes(&self, message: Message, unpacked: Option<&[u8]>, most: u64) -> io::Result<Vec<u8>> {
        let most = most.min(self.most);
        if self.form == Form::Rows {
            return rows::bytes(&self.path, message.at, most);
        }
        if let Some(unpacked) = unpacked {
            return self.content(Cursor::new(unpacked), message.at, unpacked.len() as u64, most);
        }
        let at = self.contents.chunks[message.chunk].at.saturating_add(message.at);
        self.content(File::open(&self.path)?, at, self.contents.chunks[0].size, most)
    }

    /// Bytes of the message in the record at the place `at`.
    fn content(&self, mut reader: impl Read + Seek, at: u64, length: u64, most: u64) -> io::Result<Vec<u8>> {
        reader.seek(SeekFrom::Start(at))?;
        let mut scan = Scan::new(reader, at, length);
        let bytes = if self.form == Form::Ros1 { ros1::message(&mut scan)? } else { mcap::message(&mut scan)? };
        scan.after(bytes)?;
        scan.rest(bytes.min(most))
    }

    fn unpacked(&self, chunk: &Chunk) -> Result<Vec<u8>> {
        let Chunk { at, bytes, size, packed_by, crc } = chunk;
        let fail = |e: io::Error| self.failure(&e);
        if *size > self.most {
            let found = format!("a chunk of it announces {size} bytes");
            return Err(Error::too_large(&self.path, found, format!("{} bytes", self.most), "record smaller chunks"));
        }
        if !["", "none", "lz4", "zstd", "bz2"].contains(&&**packed_by) {
            let reason =
                format!("its chunks are packed by '{packed_by:.40}'; write it anew with '{}'", self.form.rewrite());
            return Err(Error::unsupported(&self.path, self.form.name(), reason));
        }
        let mut file = File::open(&self.path).map_err(fail)?;
        file.seek(SeekFrom::Start(*at)).map_err(fail)?;
        let reader = unpacker(packed_by, Box::new(BufReader::new(file.take(*bytes)))).map_err(fail)?;
        let mut unpacked = memory::with_capacity(*size as usize);
        reader.take(*size).read_to_end(&mut unpacked).map_err(fail)?;
        if unpacked.len() as u64 != *size || (*crc != 0 && crc32fast::hash(&unpacked) != *crc) {
            return Err(fail(corrupt(format!("the chunk at byte {at} is not what was packed"))));
        }
        Ok(unpacked)
    }
}

/// Reader of what the compression `by` packed.
fn unpacker<'a>(by: &str, packed: Box<dyn Read + 'a>) -> io::Result<Box<dyn Read + 'a>> {
    Ok(match by {
        "lz4" => Box::new(lz4_flex::frame::FrameDecoder::new(packed)),
        "zstd" => Box::new(ruzstd::decoding::StreamingDecoder::new(packed).map_err(io::Error::other)?),
        "bz2" => Box::new(bzip2_rs::DecoderReader::new(packed)),
        _ => packed,
    })
}

fn unknown(path: &Path, start: &[u8]) -> Error {
    if start.starts_with(ZSTD) {
        let reason =
            "the whole file is packed by Zstandard; unpack it (zstd -d) or write the bag anew (ros2 bag convert)";
        return Error::unsupported(path, Form::Rows.name(), reason);
    }
    Error::damaged(path, "this file of a ROS 2 bag is neither a database nor MCAP")
}
