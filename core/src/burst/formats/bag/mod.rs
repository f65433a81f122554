//! Recordings of robots: ROS 1 bags, MCAP, and ROS 2 bags of one or several files, of which one topic of pictures is a
//! burst. Frames are in the order of the stamps in their headers, which are their times.

mod mcap;
mod message;
mod records;
mod ros1;
mod rows;
mod segment;

use super::picture::{self, Source};
use super::{Format, Input, Rank, Record, Start};
use crate::burst::options::{Limits, OpenOptions};
use crate::burst::reading::{Declared, Expected, RawFrame, Reading, Ticker};
use crate::burst::{reading::confined::wire::Part, times::Times};
use crate::error::{Error, ErrorKind, Result};
use crate::files::{self, path_text, read_bytes};
use crate::monitor::Monitor;
use ::image::ImageFormat::{self, Jpeg, Png};
use message::{PictureMessage, STAMP_BYTES, stamp_ns};
use records::{Channel, Message, Wire, Work};
use segment::{Segment, UNCHECKED, WHOLE};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::{io::Cursor, sync::Arc};

pub(super) struct Bag;

impl Format for Bag {
    fn record(&self) -> Record {
        let opens = "one topic of `sensor_msgs/Image` (mono, Bayer mosaic, RGB and float encodings) or `CompressedImage` (JPEG, PNG, also of a mosaic), in the order of its stamps; ROS 1 serialisation and CDR; ROS 2 bags as a database, MCAP, or a folder with `metadata.yaml`; chunks packed by lz4, zstd, bz2; what unpacks to more than 1000 times its length and 256 MiB is refused, and messages in a `-wal` beside a `.db3` are not read, which a note says; of a bag or MCAP file that was not closed the whole messages";
        let options = "`--topic /camera/image_raw` where several have pictures: the error lists them with counts and sizes; `--times header`";
        Record { name: "bag", rank: Rank::Other, extensions: &["bag", "mcap", "db3"], opens, options }
    }

    fn begins(&self, start: &Start<'_>) -> bool {
        Form::of(start.bytes).is_some() || start.bytes.starts_with(METADATA.1)
    }

    fn has_name(&self, path: &Path) -> bool {
        is_metadata(path)
    }

    fn count(&self, _input: Input, reading: Reading<'_>) -> Result<usize> {
        let Reading { path, options, .. } = reading;
        // A quick look may run out of its budget: 2 stands for any number then.
        let quiet = Monitor::default();
        match count(path, options, Work::new(&quiet, true), &quiet) {
            Err(error) if error.kind == ErrorKind::TooLarge => Ok(2),
            count => count,
        }
    }

    fn declared(&self, _input: Input, reading: Reading<'_>) -> Result<Declared> {
        let Reading { path, options, ticker, .. } = reading;
        let monitor = ticker.monitor();
        let segments = segments(path, options, Work::new(monitor, false))?;
        let topic = Topic::chosen(path, &segments, options, monitor)?;
        let (header, silent) = (topic.header(options)?, monitor.silent());
        let (width, height) = (header.width as u64, header.height as u64);
        options.limits.check_burst(path, topic.frames() as u64, width, height)?;
        let mut stamps = Vec::new();
        for (segment, _, messages) in &topic.parts {
            let ticker = Ticker::new(&silent, messages.len());
            let stamp = |_, message: &[u8]| stamp_ns(message, topic.wire).map_err(|reason| segment.wrong(reason));
            stamps.extend(segment.each(messages, STAMP_BYTES, &ticker, stamp)?);
        }
        let others = match &topic.others[..] {
            [] => String::new(),
            others => format!("; the others are {}", few(others.iter().cloned())),
        };
        let mut taken = vec![format!("the topic is {}, of {}{others}", topic.channel.topic, topic.channel.of)];
        taken.extend(header.taken);
        taken.extend(segments.iter().filter_map(|segment| segment.unread.clone()));
        // Stamps, of the exposure, come before times of the recording.
        let times = if are_stamps(stamps.iter()) {
            if !stamps.is_sorted() {
                taken
                    .push("the frames are in the order of their stamps, which is not that of the recording".to_owned());
                stamps.sort_unstable();
            }
            times(&stamps)
        } else {
            taken.push("the pictures have no stamps; their times are those of the recording".to_owned());
            let recorded = topic.parts.iter().flat_map(|(.., messages)| messages.iter().map(|one| one.recorded_ns));
            times(&recorded.collect::<Vec<_>>())
        };
        Ok(Declared { frames: topic.frames(), times, taken, ..header })
    }

    fn frames(&self, _input: Input, reading: Reading<'_>) -> Result<Vec<RawFrame>> {
        let Reading { path, options, ticker, .. } = reading;
        let segments = segments(path, options, Work::new(ticker.monitor(), false))?;
        let topic = Topic::chosen(path, &segments, options, ticker.monitor())?;
        let header = topic.header(options)?;
        let size = (header.width, header.height);
        let mut frames: Vec<(u64, RawFrame)> = Vec::with_capacity(topic.frames());
        for (segment, numbers, messages) in &topic.parts {
            let before = frames.len();
            let number = |k: usize| numbers.get(k).copied().unwrap_or(k);
            let frame =
                |k, message: &[u8]| topic.frame(segment, (number(k), before + k), size, message, options, ticker);
            frames.extend(segment.each(messages, WHOLE, ticker, frame)?);
        }
        if are_stamps(frames.iter().map(|(stamp, _)| stamp)) {
            frames.sort_by_key(|(stamp, _)| *stamp);
        }
        Ok(frames.into_iter().map(|(_, frame)| frame).collect())
    }

    fn only(&self, input: Input, reading: Reading<'_>) -> Result<RawFrame> {
        let Reading { path, options, ticker, .. } = reading;
        match count(path, options, Work::new(ticker.monitor(), false), ticker.monitor())? {
            1 => {
                let frame = self
                    .frames(input, Reading { ticker: &Ticker::new(&ticker.monitor().silent(), 1), ..reading })?
                    .remove(0);
                reading.check(frame.plane.size())?;
                Ok(frame)
            }
            frames => Err(Error::stack_among_frames(path, frames)),
        }
    }

    fn page(&self, _input: Input, reading: Reading<'_>, page: usize, frame: usize) -> Result<RawFrame> {
        let Reading { path, options, ticker, .. } = reading;
        let segments = segments(path, options, Work::new(ticker.monitor(), false))?;
        let topic = Topic::chosen(path, &segments, options, ticker.monitor())?;
        let (segment, _, messages) = &topic.parts[0];
        let message = messages.get(page..=page).ok_or_else(|| segment.wrong("it became shorter"))?;
        let header = topic.header(options)?;
        let size = (header.width, header.height);
        let decode = |_, message: &[u8]| topic.frame(segment, (page, frame), size, message, options, ticker);
        Ok(segment.each(message, UNCHECKED, ticker, decode)?.remove(0).1)
    }
}

/// Name of the file that says which files a ROS 2 bag has, and its first bytes.
const METADATA: (&str, &[u8]) = ("metadata.yaml", b"rosbag2_bagfile_information:");
/// First bytes of each form; the version of a ROS 1 bag follows.
const MAGICS: [(&[u8], Form); 3] =
    [(b"#ROSBAG V", Form::Ros1), (b"\x89MCAP0\r\n", Form::Mcap), (b"SQLite format 3\0", Form::Rows)];

/// Whether `path` lists the files of a ROS 2 bag, which then are taken together.
fn is_metadata(path: &Path) -> bool {
    let start = || files::next_bytes(files::open(path)?, METADATA.1.len() as u64);
    path.file_name().is_some_and(|name| name == METADATA.0) && start().is_ok_and(|start| start == METADATA.1)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Ros1,
    Mcap,
    Rows,
}

impl Form {
    fn of(start: &[u8]) -> Option<Self> {
        MAGICS.into_iter().find(|(magic, _)| start.starts_with(magic)).map(|(_, form)| form)
    }

    fn name(self) -> &'static str {
        ["ROS 1 bag", "MCAP", "ROS 2 bag"][self as usize]
    }

    /// Program that writes a whole file of what is left of a damaged one.
    fn repair(self) -> &'static str {
        ["rosbag reindex", "mcap recover", "ros2 bag reindex"][self as usize]
    }

    /// Program that writes a file anew, with chunks that can be read.
    fn rewrite(self) -> &'static str {
        ["rosbag decompress", "mcap compress", "ros2 bag convert"][self as usize]
    }
}

/// Largest list of files, bytes, and largest number of files in it.
const MAX_METADATA_BYTES: u64 = 1 << 24;
const MAX_FILES: usize = 4096;
/// Nanoseconds of a time that counts from 1970, at least (it is in 1973); smaller ones are those of a simulation.
const SINCE_1970_NS: u64 = 100_000_000_000_000_000;
const FEW: usize = 12;

fn segments(path: &Path, options: &OpenOptions, work: Work) -> Result<Vec<Segment>> {
    let work = Arc::new(work);
    let open = |file: &Path| Segment::open(file, &options.limits, &work);
    if !is_metadata(path) {
        return Ok(vec![open(path)?]);
    }
    let bytes = read_bytes(path, MAX_METADATA_BYTES).map_err(|e| Error::from_io(path, &e))?;
    let text = String::from_utf8_lossy(&bytes);
    let listed = text.lines().map(str::trim).skip_while(|line| *line != "relative_file_paths:").skip(1);
    let names = listed.map_while(|line| line.strip_prefix("- ")).map(|name| name.trim_matches(['"', '\'', ' ']));
    // Old versions write the name of the folder too.
    let files = names.filter_map(|name| Some(path.with_file_name(Path::new(name).file_name()?)));
    let files: Vec<PathBuf> = files.take(MAX_FILES + 1).collect();
    let fault = |fault: String| {
        Err(Error::corrupt(path, Form::Rows.name(), format!("its field 'relative_file_paths' lists {fault}")))
    };
    // A file listed twice would double its frames.
    let mut names = HashSet::new();
    match files.iter().find(|file| !names.insert(*file)) {
        _ if files.is_empty() => return fault("no file".to_owned()),
        _ if files.len() > MAX_FILES => return fault(format!("more than {MAX_FILES} files")),
        Some(twice) => {
            return fault(format!("'{}' twice", path_text(Path::new(twice.file_name().unwrap_or_default()))));
        }
        None => {}
    }
    files.iter().map(|file| open(file)).collect()
}

struct Topic<'a> {
    channel: &'a Channel,
    wire: Wire,
    /// Files, each with the indices of the messages taken (empty: all) and these messages, in recording order.
    parts: Vec<(&'a Segment, Vec<usize>, Vec<Message>)>,
    /// Names of all other topics with their types and numbers of messages.
    others: Vec<String>,
}

impl<'a> Topic<'a> {
    fn of(segments: &'a [Segment], channel: &'a Channel, options: &OpenOptions) -> Result<Self> {
        let part = |segment: &'a Segment| Ok((segment, Vec::new(), segment.messages(channel, &options.limits)?));
        let parts = segments.iter().map(part).collect::<Result<Vec<_>>>()?;
        Ok(Self { channel, wire: channel.wire.unwrap_or(Wire::Cdr), parts, others: Vec::new() })
    }

    /// The topic that the options name, or the only one of pictures.
    fn chosen(path: &Path, segments: &'a [Segment], options: &OpenOptions, monitor: &Monitor) -> Result<Self> {
        let mut topics: BTreeMap<&str, (&Channel, u64)> = BTreeMap::new();
        for channel in segments.iter().flat_map(|segment| segment.contents.channels.values()) {
            topics.entry(&channel.topic).or_insert((channel, 0)).1 += channel.count;
        }
        let pictures: Vec<&(&Channel, u64)> =
            topics.values().filter(|(channel, count)| channel.has_pictures() && *count > 0).collect();
        // Topics are written with and without the leading slash.
        let bare = |topic: &str| topic.trim_start_matches('/').to_owned();
        let chosen = match &options.topic {
            Some(topic) => {
                let named = pictures.iter().find(|(channel, _)| bare(&channel.topic) == bare(topic));
                named.ok_or_else(|| format!("this recording has no pictures in a topic '{topic}'"))
            }
            None => match &pictures[..] {
                [only] => Ok(only),
                [] => Err("this recording has no pictures (sensor_msgs/Image or CompressedImage)".to_owned()),
                all => Err(format!("this recording has {} topics of pictures", all.len())),
            },
        };
        let said =
            |(channel, count): &(&Channel, u64)| format!("{:.200} ({count} of {:.200})", channel.topic, channel.of);
        let problem = match chosen {
            Ok((channel, _)) => {
                let others = topics.values().filter(|(other, _)| other.topic != channel.topic).map(said).collect();
                let topic = Self::of(segments, channel, &options.of_whole())?.part(path, options, monitor)?;
                // No size is known yet: the count alone is checked.
                options.limits.check_burst(path, topic.frames() as u64, 1, 1)?;
                return Ok(Self { others, ..topic });
            }
            Err(problem) => problem,
        };
        let remedy = match &pictures[..] {
            [] => format!("its topics are: {}", few(topics.values().map(said))),
            all => {
                // The error lists sizes: one message of each topic is read, whatever the limit on frames.
                let limits = Limits { max_frames: usize::MAX, ..options.limits };
                let options = OpenOptions { limits, take: None, ..options.clone() };
                let said = all.iter().map(|(channel, count)| {
                    let header = Self::of(segments, channel, &options).and_then(|topic| topic.header(&options));
                    let size = header.map(|header| format!("{}×{}", header.width, header.height));
                    format!(
                        "{:.200} ({count} of {})",
                        channel.topic,
                        size.as_deref().unwrap_or("a kind that is not read")
                    )
                });
                format!("say with --topic NAME which one holds the frames: {}", few(said))
            }
        };
        Err(Error::new(ErrorKind::Unsupported, problem, remedy).about(path))
    }

    /// Restricts the topic to messages by the order of stamps; as recorders are late, some more are read around.
    fn part(self, path: &Path, options: &OpenOptions, monitor: &Monitor) -> Result<Self> {
        const LATE: usize = 64;
        let count = self.frames();
        let range = options.taken_of(path, count, (1, 1))?;
        if range.len() == count {
            return Ok(self);
        }
        let near = range.start.saturating_sub(LATE)..(range.end + LATE).min(count);
        let mut stamps: Vec<(u64, usize)> = Vec::with_capacity(near.len());
        let mut before = 0;
        for (segment, _, messages) in &self.parts {
            let [start, end] = [near.start, near.end].map(|at| at.saturating_sub(before).min(messages.len()));
            let ticker = Ticker::new(monitor, end - start);
            let stamp = |_, message: &[u8]| stamp_ns(message, self.wire).map_err(|reason| segment.wrong(reason));
            let found = segment.each(&messages[start..end], STAMP_BYTES, &ticker, stamp)?;
            stamps.extend(found.into_iter().zip(before + start..));
            before += messages.len();
        }
        // Where stamps are left 0, the order is that of the recording.
        if are_stamps(stamps.iter().map(|(stamp, _)| stamp)) {
            stamps.sort_unstable();
        }
        let wanted: HashSet<usize> =
            stamps[range.start - near.start..][..range.len()].iter().map(|(_, number)| *number).collect();
        let mut before = 0;
        let part = |(segment, _, messages): (&'a Segment, Vec<usize>, Vec<Message>)| {
            let numbers: Vec<usize> = (0..messages.len()).filter(|k| wanted.contains(&(before + k))).collect();
            before += messages.len();
            let messages = numbers.iter().map(|k| messages[*k]).collect();
            (segment, numbers, messages)
        };
        Ok(Self { parts: self.parts.into_iter().map(part).collect(), ..self })
    }

    fn frames(&self) -> usize {
        self.parts.iter().map(|(.., messages)| messages.len()).sum()
    }

    fn header(&self, options: &OpenOptions) -> Result<Declared> {
        let first = self.parts.iter().find_map(|(segment, _, messages)| Some((*segment, messages.first()?)));
        let (segment, first) = first.ok_or_else(|| self.parts[0].0.wrong("the topic has no message"))?;
        let (path, kind, limits) = (&segment.path, segment.form.name(), &options.limits);
        // One message is looked at ahead of the frames: it is no progress.
        let header = segment.each(&[*first], UNCHECKED, &Ticker::new(&Monitor::default(), 1), |_, message| {
            let picture = self.picture(segment, message)?;
            let header = match self.format(segment, &picture)? {
                Some(format) => {
                    let declared = picture::declared_of(path, Cursor::new(picture.data), picture.data, format, limits)?;
                    Declared { mosaic: picture.mosaic().filter(|_| !declared.is_colour), ..declared }
                }
                None => picture.plain(path, kind, limits)?.0.declared(),
            };
            Ok(Declared { kind, taken: vec![format!("the encoding is '{:.40}'", picture.encoding)], ..header })
        });
        Ok(header?.remove(0))
    }

    fn picture<'b>(&self, segment: &Segment, message: &'b [u8]) -> Result<PictureMessage<'b>> {
        PictureMessage::read(message, self.wire, self.channel.is_compressed()).map_err(|reason| segment.wrong(reason))
    }

    /// Format of a compressed picture; `None` for one of plain numbers.
    fn format(&self, segment: &Segment, picture: &PictureMessage<'_>) -> Result<Option<ImageFormat>> {
        if !self.channel.is_compressed() {
            return Ok(None);
        }
        let format = ::image::guess_format(picture.data).ok().filter(|format| [Jpeg, Png].contains(format));
        format.map(Some).ok_or_else(|| {
            let reason = format!(
                "its pictures are compressed as '{:.40}', and JPEG and PNG are read; write them anew with image_transport",
                picture.encoding
            );
            Error::unsupported(&segment.path, segment.form.name(), reason)
        })
    }

    /// Stamp and picture of message number `page` of its file, as frame `frame`; `size` is that of the first frame.
    fn frame(
        &self,
        segment: &Segment,
        (page, frame): (usize, usize),
        size: (usize, usize),
        message: &[u8],
        options: &OpenOptions,
        ticker: &Ticker<'_>,
    ) -> Result<(u64, RawFrame)> {
        let (path, limits) = (&segment.path, &options.limits);
        let picture = self.picture(segment, message)?;
        // Paths with the frame's number, so that an error of different sizes names both frames.
        let named = |frame| format!("{} (frame {frame})", path.display());
        let (first, this) = (PathBuf::from(named(0)), PathBuf::from(named(frame)));
        let reading = Reading { path, expected: Some(Expected { first: &first, size }), options, ticker };
        let decoded = match self.format(segment, &picture)? {
            None => {
                let (plain, data) = picture.plain(path, segment.form.name(), limits)?;
                Reading { path: &this, ..reading }.check(plain.size)?;
                plain.read(reading, frame, &mut &data[..])?
            }
            Some(format) => {
                let (data, part) = (picture.data, Part::Page { page, frame });
                let length = data.len() as u64;
                let source = Source { reader: Cursor::new(data), bytes: data, length, format, part };
                // Another process that decodes opens the recording anew: it must find the same topic and numbers.
                let options = &OpenOptions { topic: Some(self.channel.topic.clone()), take: None, ..options.clone() };
                let decoded = picture::decoded(Reading { options, ..reading }, source)?;
                ticker.tick();
                // A picture that was given its colours before it was compressed has no mosaic any more.
                RawFrame { mosaic: picture.mosaic().filter(|_| !decoded.is_colour), ..decoded }
            }
        };
        Ok((picture.stamp_ns, decoded))
    }
}

fn few(topics: impl Iterator<Item = String>) -> String {
    let mut topics: Vec<String> = topics.take(FEW + 1).collect();
    if topics.len() > FEW {
        topics[FEW] = "…".to_owned();
    }
    topics.join(", ")
}

fn count(path: &Path, options: &OpenOptions, work: Work, monitor: &Monitor) -> Result<usize> {
    Ok(Topic::chosen(path, &segments(path, options, work)?, options, monitor)?.frames())
}

/// Whether pictures have stamps: some programs leave them 0.
fn are_stamps<'a>(mut stamps_ns: impl Iterator<Item = &'a u64>) -> bool {
    stamps_ns.all(|stamp| *stamp > 0)
}

/// Times of frames at `ns` nanoseconds each; none where they are not in their order.
fn times(ns: &[u64]) -> Times {
    let Some(first) = ns.first().filter(|_| ns.is_sorted()) else { return Times::default() };
    let is_absolute = *first >= SINCE_1970_NS;
    let begin = if is_absolute { 0 } else { *first };
    // The whole seconds and the rest each keep their digits.
    let seconds = |ns: u64| (ns / 1_000_000_000) as f64 + (ns % 1_000_000_000) as f64 * 1e-9;
    Times { seconds: ns.iter().map(|ns| seconds(ns - begin)).collect(), is_absolute }
}
