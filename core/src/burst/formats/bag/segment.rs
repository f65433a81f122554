//! One file of a recording: its topics, the places of their messages, and the bytes of these. Chunks of messages are
//! unpacked one at a time by each thread; where nothing is packed, messages are read from their places in the file.

use super::records::{Channel, Checksum, Chunk, Contents, List, Message, Metered, Scan, Work, corrupt};
use super::{Form, mcap, ros1, rows};
use crate::burst::reading::{Ticker, in_order};
use crate::error::{Error, ErrorKind, Result};
use crate::{burst::options::Limits, files, monitor::Cancelled, plane::memory};
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};
use std::collections::BTreeMap;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// First bytes of what Zstandard packed, also a single message of a ROS 2 bag.
const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";
/// Longest file whose checksum of the whole is compared when frames are read that have one of their own, bytes.
const MAX_CHECKED: u64 = 1 << 30;
/// Special numbers of bytes to read of a message: all of it, with or without comparing the checksums around it.
pub(super) const WHOLE: u64 = u64::MAX;
pub(super) const UNCHECKED: u64 = u64::MAX - 1;

#[derive(Debug)]
pub(super) struct Segment {
    pub path: PathBuf,
    pub form: Form,
    pub contents: Contents,
    /// Note on what is not read.
    pub unread: Option<String>,
    /// Largest number of bytes of a chunk or message.
    most: u64,
    work: Arc<Work>,
    /// Unpacked chunks within the memory budget, by index.
    kept: Mutex<BTreeMap<usize, Arc<Vec<u8>>>>,
}

impl Segment {
    /// Reads the file's records, and unpacks only the chunks that no list describes.
    pub(super) fn open(path: &Path, limits: &Limits, work: &Arc<Work>) -> Result<Self> {
        let fail = |e: io::Error| Error::from_io(path, &e);
        let mut file = files::open(path).map_err(fail)?;
        let length = file.metadata().map_err(fail)?.len();
        let start = files::next_bytes(&mut file, 32).map_err(fail)?;
        let Some(form) = Form::of(&start) else { return Err(unknown(path, &start)) };
        work.add_file(length);
        // A picture of four samples of four bytes, and all else that is recorded with it.
        let most = limits.max_pixels.saturating_mul(16).saturating_add(1 << 26);
        let whole = Chunk { at: 0, bytes: length, size: length, packed_by: String::new(), crc: 0 };
        let contents = Contents { chunks: vec![whole], ..Contents::default() };
        let (path, work, kept) = (path.to_owned(), work.clone(), Mutex::default());
        let mut segment = Self { path, form, contents, unread: None, most, work, kept };
        segment.read(&start, length).map_err(|e| segment.failure(&e)).map(|()| segment)
    }

    fn read(&mut self, start: &[u8], length: u64) -> io::Result<()> {
        if self.form == Form::Rows {
            rows::check_length(start, length)?;
            self.unread = rows::beside(&self.path)?;
            self.contents.channels = rows::channels(&self.path, &self.work)?;
            return Ok(());
        }
        let mut found = std::mem::take(&mut self.contents);
        match self.walk(files::open(&self.path)?, length, 0, &mut found) {
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof && found.is_open => {
                // Lists of the last chunk may be missing, so its messages are searched in the chunk itself.
                let last = found.chunks.len() - 1;
                found.lists.retain(|list| list.chunk != last);
                let repair = self.form.repair();
                self.unread = Some(format!(
                    "it was not closed: of its {length} bytes the whole chunks and messages are taken ('{repair}' closes it)"
                ));
            }
            walked => walked?,
        }
        // The summary's checksum first: channels and lists come from the summary.
        if let Some(checksum) = found.summary_checksum {
            self.check(checksum, "its summary")?;
        }
        // Whether the channels of a chunk's lists are known; `None` for one without lists.
        let mut is_known = vec![None; found.chunks.len()];
        for List { channel, chunk, .. } in &found.lists {
            is_known[*chunk] = Some(is_known[*chunk] != Some(false) && found.channels.contains_key(channel));
        }
        let unknown = || (1..is_known.len()).filter(|chunk| is_known[*chunk] != Some(true));
        self.check_unpacked(unknown().map(|chunk| &found.chunks[chunk]))?;
        for chunk in unknown() {
            let unpacked = self.unpacked(chunk, &found.chunks[chunk])?;
            self.walk(Cursor::new(&unpacked[..]), unpacked.len() as u64, chunk, &mut found)?;
        }
        found.lists.retain(|list| is_known[list.chunk] == Some(true));
        for list in &found.lists {
            if let Some(channel) = found.channels.get_mut(&list.channel) {
                channel.count = channel.count.saturating_add(list.count);
            }
        }
        let has_pictures = found.channels.values().any(|channel| channel.has_pictures() && channel.count > 0);
        self.contents = found;
        if has_pictures || self.unread.is_none() { Ok(()) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
    }

    fn walk(&self, reader: impl Read + Seek, length: u64, chunk: usize, found: &mut Contents) -> io::Result<()> {
        let start = |start| if chunk == 0 { start } else { 0 };
        match self.form {
            Form::Ros1 => ros1::walk(Scan::new(reader, start(ros1::START), length, &self.work)?, chunk, found),
            _ => mcap::walk(Scan::new(reader, start(mcap::START), length, &self.work)?, chunk, found),
        }
    }

    /// Error for a file that cannot be read, with the program that mends damage.
    fn failure(&self, error: &io::Error) -> Error {
        if error.get_ref().is_some_and(|inner| inner.is::<Cancelled>()) {
            return Cancelled.into();
        }
        if error.kind() == io::ErrorKind::QuotaExceeded {
            let remedy = format!("write it anew with small chunks, or without compression ('{}')", self.form.rewrite());
            return Error::new(ErrorKind::TooLarge, format!("this is too large: {error}"), remedy).about(&self.path);
        }
        if error.kind() == io::ErrorKind::OutOfMemory {
            let remedy = "take fewer frames, or close other programs";
            return Error::new(ErrorKind::NoMemory, "there is no memory for its messages", remedy).about(&self.path);
        }
        if error.kind() == io::ErrorKind::Unsupported {
            return Error::unsupported(&self.path, self.form.name(), error);
        }
        let error = Error::from_read(&self.path, self.form.name(), error);
        if error.kind != ErrorKind::Damaged {
            return error;
        }
        Error { remedy: format!("copy it again, or save what is whole with '{}'", self.form.repair()), ..error }
    }

    pub(super) fn wrong(&self, reason: impl std::fmt::Display) -> Error {
        Error::corrupt(&self.path, self.form.name(), reason)
    }

    /// Messages of all channels with the topic and type of `like`, in recording order.
    pub(super) fn messages(&self, like: &Channel, limits: &Limits) -> Result<Vec<Message>> {
        let is_like =
            |channel: &Channel| (&channel.topic, &channel.of, channel.wire) == (&like.topic, &like.of, like.wire);
        let of_topic = || self.contents.channels.iter().filter(|(_, channel)| is_like(channel));
        let count = of_topic().fold(0u64, |sum, (_, channel)| sum.saturating_add(channel.count));
        // Counted before they are listed: a file may announce more messages than memory holds.
        limits.check_burst(&self.path, count, 1, 1)?;
        let mut messages = Vec::new();
        of_topic().for_each(|(_, channel)| messages.extend(&channel.found));
        let ids: Vec<u32> = of_topic().map(|(id, _)| *id).collect();
        self.listed(&ids, &mut messages).map_err(|e| self.failure(&e))?;
        messages.sort_by_key(|message| message.recorded_ns);
        Ok(messages)
    }

    fn listed(&self, ids: &[u32], messages: &mut Vec<Message>) -> io::Result<()> {
        if self.form == Form::Rows {
            for id in ids {
                messages.extend(rows::messages(&self.path, *id, self.contents.channels[id].count, &self.work)?);
            }
            return Ok(());
        }
        let mut file = files::open(&self.path)?;
        for list in self.contents.lists.iter().filter(|list| ids.contains(&list.channel)) {
            let mut scan = Scan::new(&mut file, list.at, self.contents.chunks[0].size, &self.work)?;
            for _ in 0..list.count {
                self.work.step(1)?;
                let entry = if self.form == Form::Ros1 { ros1::entry(&mut scan) } else { mcap::entry(&mut scan) };
                let (recorded_ns, at) = entry?;
                messages.push(Message { recorded_ns, chunk: list.chunk, at });
            }
        }
        Ok(())
    }

    /// Computes `f(k, bytes)` of each message in parallel, from its first `most` bytes or more; in their order.
    pub(super) fn each<T: Send>(
        &self,
        messages: &[Message],
        most: u64,
        ticker: &Ticker<'_>,
        f: impl Fn(usize, &[u8]) -> Result<T> + Sync,
    ) -> Result<Vec<T>> {
        // In the file's order neighbours share a chunk.
        let mut order: Vec<usize> = (0..messages.len()).collect();
        order.sort_by_key(|k| (messages[*k].chunk, messages[*k].at));
        let chunk_of = |k: usize| messages[k].chunk;
        let chunk_at = |chunk: usize| &self.contents.chunks[chunk];
        let is_packed = |chunk: usize| !chunk_at(chunk).packed_by.is_empty();
        let is_checked = |chunk: usize| chunk_at(chunk).crc != 0 && (is_packed(chunk) || most == WHOLE);
        // A chunk is unpacked and checked once for all of its messages.
        let together = |chunk: usize| is_packed(chunk) || is_checked(chunk);
        let runs: Vec<&[usize]> =
            order.chunk_by(|a, b| chunk_of(*a) == chunk_of(*b) && together(chunk_of(*a))).collect();
        let chunks = || runs.iter().map(|run| chunk_of(run[0]));
        self.check_unpacked(chunks().filter(|chunk| is_packed(*chunk)).map(chunk_at)).map_err(|e| self.failure(&e))?;
        // The data's checksum costs a pass over the file: a long one whose chunks have their own is spared.
        if let Some(checksum) = self.contents.data_checksum.filter(|_| most == WHOLE)
            && (checksum.to <= MAX_CHECKED || !chunks().all(is_checked))
        {
            self.check(checksum, "its data").map_err(|e| self.failure(&e))?;
        }
        let answers = in_order(runs.len(), |run| {
            let chunk = chunk_of(runs[run][0]);
            let unpacked = self.whole(chunk, together(chunk)).map_err(|e| self.failure(&e))?;
            let of_run = runs[run].iter().map(|k| {
                ticker.check()?;
                let message = self.message(messages[*k], unpacked.as_deref().map(Vec::as_slice), most);
                f(*k, &message.map_err(|e| self.failure(&e))?)
            });
            of_run.collect::<Result<Vec<T>>>()
        })?;
        let mut all: Vec<(usize, T)> = order.into_iter().zip(answers.into_iter().flatten()).collect();
        all.sort_by_key(|(k, _)| *k);
        Ok(all.into_iter().map(|(_, answer)| answer).collect())
    }

    /// The chunk unpacked, if it is packed; otherwise its checksum is compared if `is_checked`.
    fn whole(&self, chunk: usize, is_checked: bool) -> io::Result<Option<Arc<Vec<u8>>>> {
        let found = &self.contents.chunks[chunk];
        if !found.packed_by.is_empty() {
            return self.unpacked(chunk, found).map(Some);
        }
        if is_checked {
            let Chunk { at, bytes, crc, .. } = *found;
            self.check(Checksum { from: at, to: at + bytes, crc }, &format!("the chunk at byte {at}"))?;
        }
        Ok(None)
    }

    /// The first bytes of a message, at least `most`, or all of it; unpacked where it is packed by itself.
    fn message(&self, message: Message, chunk: Option<&[u8]>, most: u64) -> io::Result<Vec<u8>> {
        let mut bytes = self.bytes(message, chunk, most)?;
        if self.form == Form::Ros1 || !bytes.starts_with(ZSTD) {
            return Ok(bytes);
        }
        // The packed length says nothing about `most`, so the whole message is read.
        let packed = self.bytes(message, chunk, self.most)?;
        bytes.clear();
        self.work.add_packed(packed.len() as u64);
        Metered { reader: unpacker("zstd", Box::new(&packed[..]))?, work: &self.work }
            .take(most.min(self.most).saturating_add(1))
            .read_to_end(&mut bytes)?;
        if bytes.len() as u64 > self.most {
            let problem = format!("a message of it unpacks to more than {} bytes", self.most);
            return Err(io::Error::new(io::ErrorKind::QuotaExceeded, problem));
        }
        Ok(bytes)
    }

    /// The first bytes of a message, at most `most`; `unpacked` is its chunk, where that is packed.
    fn bytes(&self, message: Message, unpacked: Option<&[u8]>, most: u64) -> io::Result<Vec<u8>> {
        let most = most.min(self.most);
        if self.form == Form::Rows {
            return rows::bytes(&self.path, message.at, most, &self.work);
        }
        if let Some(unpacked) = unpacked {
            return self.content(Cursor::new(unpacked), message.at, unpacked.len() as u64, most);
        }
        let at = self.contents.chunks[message.chunk].at.saturating_add(message.at);
        self.content(files::open(&self.path)?, at, self.contents.chunks[0].size, most)
    }

    fn content(&self, reader: impl Read + Seek, at: u64, length: u64, most: u64) -> io::Result<Vec<u8>> {
        let mut scan = Scan::new(reader, at, length, &self.work)?;
        let bytes = if self.form == Form::Ros1 { ros1::message(&mut scan)? } else { mcap::message(&mut scan)? };
        scan.after(bytes)?;
        scan.rest(bytes.min(most))
    }

    fn check(&self, checksum: Checksum, name: &str) -> io::Result<()> {
        let Checksum { from, to, crc } = checksum;
        let mut file = files::open(&self.path)?;
        file.seek(SeekFrom::Start(from))?;
        let (mut file, mut hasher, mut part) = (file.take(to - from), crc32fast::Hasher::new(), vec![0; 1 << 16]);
        loop {
            self.work.step(0)?;
            match file.read(&mut part)? {
                0 => break,
                count => hasher.update(&part[..count]),
            }
        }
        if hasher.finalize() == crc { Ok(()) } else { Err(corrupt(format!("{name} is not what its checksum says"))) }
    }

    fn check_unpacked<'a>(&self, chunks: impl Iterator<Item = &'a Chunk>) -> io::Result<()> {
        let sum = |(packed, unpacked): (u64, u64), chunk: &Chunk| {
            (packed.saturating_add(chunk.bytes), unpacked.saturating_add(chunk.size))
        };
        let (packed, unpacked) = chunks.fold((0, 0), sum);
        self.work.check_unpacked(packed, unpacked)
    }

    fn unpacked(&self, index: usize, chunk: &Chunk) -> io::Result<Arc<Vec<u8>>> {
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(unpacked) = kept().get(&index) {
            return Ok(unpacked.clone());
        }
        let Chunk { at, bytes, size, packed_by, crc } = chunk;
        // Before room is made: the size is only announced.
        if *size > self.most {
            let problem = format!("a chunk of it announces {size} bytes, and the limit is {} bytes", self.most);
            return Err(io::Error::new(io::ErrorKind::QuotaExceeded, problem));
        }
        if !["", "none", "lz4", "zstd", "bz2"].contains(&&**packed_by) {
            let reason =
                format!("its chunks are packed by '{packed_by:.40}'; write it anew with '{}'", self.form.rewrite());
            return Err(io::Error::new(io::ErrorKind::Unsupported, reason));
        }
        self.work.check_unpacked(*bytes, *size)?;
        self.work.add_packed(*bytes);
        let mut file = files::open(&self.path)?;
        file.seek(SeekFrom::Start(*at))?;
        let reader = unpacker(packed_by, Box::new(BufReader::new(file.take(*bytes))))?;
        let mut unpacked = memory::with_capacity(*size as usize);
        // The byte behind the last one makes the unpacker read the end, and compare the checksum there.
        Metered { reader, work: &self.work }.take(*size + 1).read_to_end(&mut unpacked)?;
        if unpacked.len() as u64 != *size || (*crc != 0 && crc32fast::hash(&unpacked) != *crc) {
            return Err(corrupt(format!("the chunk at byte {at} is not what was packed")));
        }
        let unpacked = Arc::new(unpacked);
        if self.work.keeps(*size) {
            kept().insert(index, unpacked.clone());
        }
        Ok(unpacked)
    }
}

fn unpacker<'a>(by: &str, packed: Box<dyn Read + 'a>) -> io::Result<Box<dyn Read + 'a>> {
    Ok(match by {
        "lz4" => Box::new(lz4_flex::frame::FrameDecoder::new(packed)),
        "zstd" => Box::new(Checked(StreamingDecoder::new(packed).map_err(io::Error::other)?)),
        "bz2" => Box::new(bzip2_rs::DecoderReader::new(packed)),
        _ => packed,
    })
}

/// Reader of Zstandard that compares the checksum at the end, where there is one.
struct Checked<R: Read>(StreamingDecoder<R, FrameDecoder>);

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let count = self.0.read(to)?;
        let of = &self.0.decoder;
        let is_end = count == 0 && !to.is_empty() && of.get_checksum_from_data().is_some();
        if is_end && of.get_checksum_from_data() != of.get_calculated_checksum() {
            return Err(corrupt("what Zstandard packed is not what its checksum says"));
        }
        Ok(count)
    }
}

fn unknown(path: &Path, start: &[u8]) -> Error {
    if start.starts_with(ZSTD) {
        let reason =
            "the whole file is packed by Zstandard; unpack it (zstd -d) or write the bag anew (ros2 bag convert)";
        return Error::unsupported(path, Form::Rows.name(), reason);
    }
    Error::damaged(path, "this file of a ROS 2 bag is neither a database nor MCAP")
}
