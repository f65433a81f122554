//! Recordings that are made to do harm, or were damaged where only a checksum tells: each is refused with an error that
//! says why, before much is unpacked, and when the work is cancelled.

use super::{bags::sample_of, support::*};
use rusqlite::Connection;
use std::io::{Read, Write};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

fn record(kind: u8, fields: &[&[u8]]) -> Vec<u8> {
    let body = fields.concat();
    [&[kind][..], &(body.len() as u64).to_le_bytes(), &body].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

fn numbers(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// Picture `t`, of 4×3 pixels, in CDR: stamp, frame, rows, columns, encoding, byte order, step, pixels.
fn picture(t: u32) -> Vec<u8> {
    let head = [&[0, 1, 0, 0][..], &numbers(&[1_700_000_000 + t, 5, 2]), b"a\0\0\0", &numbers(&[3, 4, 6])].concat();
    [&head[..], b"mono8\0\0\0", &numbers(&[4, 12]), &[t as u8 * 20; 12]].concat()
}

/// An MCAP of one chunk, with what can be wrong about it.
struct Recording {
    wire: &'static str,
    packed_by: &'static str,
    chunk: Vec<u8>,
    size: u64,
    crc: u32,
    /// Whether a list names its messages, so that the chunk is not looked through.
    lists: Vec<u64>,
    has_data_crc: bool,
    has_summary_crc: bool,
}

impl Recording {
    /// Three pictures of 4×3 in a chunk that is not packed, without checksums.
    fn plain() -> Self {
        Self::of("cdr", &[0, 1, 2].map(picture))
    }

    fn of(wire: &'static str, messages: &[Vec<u8>]) -> Self {
        let (mut chunk, mut lists) = (Vec::new(), Vec::new());
        for (t, message) in messages.iter().enumerate() {
            lists.push(chunk.len() as u64);
            let (number, ns) = ((t as u32).to_le_bytes(), (t as u64).to_le_bytes());
            chunk.extend(record(5, &[&1u16.to_le_bytes(), &number, &ns, &ns, message]));
        }
        let (size, packed_by) = (chunk.len() as u64, "");
        Self { wire, packed_by, chunk, size, crc: 0, lists, has_data_crc: false, has_summary_crc: false }
    }

    /// A chunk of `size` zeros, packed by Zstandard to a thirty-thousandth.
    fn bomb(size: u64) -> Self {
        Self { packed_by: "zstd", chunk: zeros_by_zstd(size), size, lists: Vec::new(), ..Self::plain() }
    }

    fn bytes(&self) -> Vec<u8> {
        let schema = record(3, &[&1u16.to_le_bytes(), &text("sensor_msgs/msg/Image"), &text("ros2msg"), &text("")]);
        let numbers = [1u16.to_le_bytes(), 1u16.to_le_bytes()].concat();
        let channel = record(4, &[&numbers, &text("/eye"), &text(self.wire), &text("")]);
        let length = (self.chunk.len() as u64).to_le_bytes();
        let (crc, packed_by) = (self.crc.to_le_bytes(), text(self.packed_by));
        let chunk = record(6, &[&[0; 16], &self.size.to_le_bytes(), &crc, &packed_by, &length, &self.chunk]);
        let entries: Vec<u8> = self.lists.iter().flat_map(|at| [[0; 8], at.to_le_bytes()].concat()).collect();
        let list = record(7, &[&1u16.to_le_bytes(), &(entries.len() as u32).to_le_bytes(), &entries]);
        let list = if self.lists.is_empty() { Vec::new() } else { list };
        let mut file = [MAGIC, &record(1, &[&text(""), &text("test")]), &schema, &channel, &chunk, &list].concat();
        let data = if self.has_data_crc { crc32fast::hash(&file) } else { 0 };
        file.extend(record(15, &[&data.to_le_bytes()]));
        let start = file.len();
        file.extend([schema, channel].concat());
        let footer = record(2, &[&(start as u64).to_le_bytes(), &[0; 8], &[0; 4]]);
        file.extend(&footer[..footer.len() - 4]);
        let summary = if self.has_summary_crc { crc32fast::hash(&file[start..]) } else { 0 };
        file.extend(summary.to_le_bytes());
        [&file, MAGIC].concat()
    }
}

/// A frame of Zstandard that repeats one byte, in blocks of the largest size.
fn zeros_by_zstd(size: u64) -> Vec<u8> {
    const BLOCK: u64 = 1 << 17;
    // No length, no checksum, and a window of one block.
    let mut frame = b"\x28\xb5\x2f\xfd\0\x38".to_vec();
    for start in (0..size).step_by(BLOCK as usize) {
        let (is_last, count) = (size - start <= BLOCK, BLOCK.min(size - start));
        let head = (count as u32) << 3 | 1 << 1 | u32::from(is_last);
        frame.extend([&head.to_le_bytes()[..3], &[0]].concat());
    }
    frame
}

fn failure(path: &Path) -> Error {
    Burst::open(path).expect_err("it is refused")
}

fn written(folder: &Folder, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).expect("written");
    path
}

#[test]
fn checksums_that_are_there_are_compared() {
    let home = folder();
    let plain = || Recording { crc: crc32fast::hash(&Recording::plain().chunk), ..Recording::plain() };
    for (words, recording) in [
        ("the chunk at byte", plain()),
        ("its data", Recording { has_data_crc: true, ..Recording::plain() }),
        ("the chunk at byte", Recording { lists: Vec::new(), ..plain() }),
    ] {
        let mut bytes = recording.bytes();
        let burst = Burst::open(written(&home, "a.mcap", &bytes)).expect("it is whole");
        assert_eq!((burst.len(), burst.size()), (3, (4, 3)));
        let pixel = bytes.windows(12).position(|part| part == [20; 12]).expect("the pixels of the second frame");
        bytes[pixel + 5] ^= 1;
        let error = failure(&written(&home, "a.mcap", &bytes));
        assert!(error.kind == ErrorKind::Damaged && error.problem.contains(words), "{words}: {error}");
    }
    let mut bytes = Recording { has_summary_crc: true, ..Recording::plain() }.bytes();
    Burst::open(written(&home, "a.mcap", &bytes)).expect("it is whole");
    let topic = bytes.windows(4).rposition(|part| part == b"/eye").expect("the topic in the summary");
    bytes[topic + 1] = b'E';
    assert!(failure(&written(&home, "a.mcap", &bytes)).problem.contains("its summary"));
    // The checksum of what LZ4 packed in a bag of ROS 1 lies behind the last block.
    let bag = sample_of("bayer_lz4.bag");
    let start = bag.windows(4).position(|part| part == b"\x04\x22\x4d\x18").expect("a chunk");
    let end = start + u32::from_le_bytes(bag[start - 4..start].try_into().expect("four")) as usize;
    let mut unpacked = Vec::new();
    lz4_flex::frame::FrameDecoder::new(&bag[start..end]).read_to_end(&mut unpacked).expect("unpacked");
    let info = lz4_flex::frame::FrameInfo::new().content_checksum(true);
    let mut packer = lz4_flex::frame::FrameEncoder::with_frame_info(info, Vec::new());
    packer.write_all(&unpacked).expect("packed");
    let mut packed = packer.finish().expect("packed");
    let again = |packed: &[u8]| {
        let length = (packed.len() as u32).to_le_bytes();
        [&bag[..start - 4], &length, packed, &bag[end..]].concat()
    };
    open_with(&written(&home, "a.bag", &again(&packed)), &OpenOptions::default()).expect("it is whole");
    *packed.last_mut().expect("bytes") ^= 1;
    assert_eq!(failure(&written(&home, "a.bag", &again(&packed))).kind, ErrorKind::Damaged);
}

#[test]
fn each_cut_field_of_a_picture_is_named_and_a_list_of_files_names_each_once() {
    let home = folder();
    // As ROS 1 serialises it: with a number, without padding.
    let head = [&numbers(&[3, 1_700_000_000, 5, 1])[..], b"a", &numbers(&[3, 4, 5]), b"mono8\0"].concat();
    let of_ros_1 = [&head[..], &numbers(&[4, 12]), &[60; 12]].concat();
    for (wire, whole) in [("cdr", picture(3)), ("ros1", of_ros_1)] {
        let opened = |message: &[u8]| {
            Burst::open(written(&home, "a.mcap", &Recording::of(wire, &[message.to_vec(), message.to_vec()]).bytes()))
        };
        let burst = opened(&whole).expect(wire);
        assert!(burst.frames[1].data().iter().all(|value| (value * 255.0 - 60.0).abs() < 1e-3));
        for cut in 0..whole.len() {
            let error = opened(&whole[..cut]).expect_err("cut").to_string();
            assert!(error.contains("field") || error.contains("no bytes"), "{wire} {cut}: {error}");
        }
    }
    fs::write(home.join("a.db3"), sample_of("sqlite.db3")).expect("written");
    let listed = |files: &str| {
        let text = format!("rosbag2_bagfile_information:\n  relative_file_paths:\n{files}");
        failure(&written(&home, "metadata.yaml", text.as_bytes())).to_string()
    };
    assert!(listed("    - a.db3\n    - bag/a.db3\n").contains("lists 'a.db3' twice"));
    assert!(listed(&"    - a.db3\n".repeat(5)).contains("lists 'a.db3' twice"));
    let many: String = (0..5000).map(|k| format!("    - {k}.db3\n")).collect();
    assert!(listed(&many).contains("more than 4096 files"));
}

#[test]
fn what_unpacks_to_far_more_than_its_length_is_refused() {
    let home = folder();
    let refused = |path: &Path| {
        let error = failure(path);
        assert_eq!((error.kind, error.problem.contains("packed parts")), (ErrorKind::TooLarge, true), "{error}");
        // A look that tells whether it is a burst reads no more.
        let found = find_bursts(&[path.to_owned()], &OpenOptions::default()).expect("found");
        assert_eq!(found.len(), 1);
    };
    refused(&written(&home, "one.mcap", &Recording::bomb(1 << 30).bytes()));
    // A list that names its messages does not help it.
    let listed = Recording { lists: vec![0], ..Recording::bomb(1 << 30) };
    refused(&written(&home, "listed.mcap", &listed.bytes()));
    // A message that is packed by itself announces nothing.
    let path = written(&home, "rows.db3", &sample_of("squeezed.db3"));
    let changed = "UPDATE messages SET data = ?1 WHERE topic_id IN (SELECT id FROM topics WHERE type LIKE '%Image%')";
    Connection::open(&path).and_then(|rows| rows.execute(changed, [zeros_by_zstd(1 << 30)])).expect("changed");
    refused(&path);
    // Work that was cancelled ends before.
    for path in ["one.mcap", "rows.db3"].map(|name| home.join(name)) {
        let error = Info::of(&[path], &OpenOptions::default(), &cancelled()).expect_err("cancelled");
        assert!(error.is_cancelled(), "{error}");
    }
}

#[test]
fn a_database_whose_columns_compute_is_refused_and_what_lies_beside_one_is_said() {
    let home = folder();
    for (table, column) in [("messages", "VIRTUAL"), ("topics", "VIRTUAL")] {
        let path = written(&home, "rows.db3", &sample_of("sqlite.db3"));
        let change = format!("ALTER TABLE {table} ADD COLUMN x AS (length(hex(zeroblob(100000000)))) {column}");
        Connection::open(&path).and_then(|rows| rows.execute_batch(&change)).expect("changed");
        let error = failure(&path);
        assert!(error.kind == ErrorKind::Unsupported && error.problem.contains("stored columns"), "{error}");
    }
    let path = written(&home, "rows.db3", &sample_of("sqlite.db3"));
    let info = |path: &Path| Info::of(&[path.to_owned()], &OpenOptions::default(), &quiet());
    let notes = || info(&path).expect("described").text();
    assert!(!notes().contains("-wal"));
    let recorder = Connection::open(&path).expect("opened");
    recorder.pragma_update(None, "journal_mode", "WAL").expect("a log");
    recorder.execute("DELETE FROM messages WHERE timestamp = (SELECT max(timestamp) FROM messages)", []).expect("done");
    says(notes(), &["messages in 'rows.db3-wal' beside it are not read"]);
    // Once it is taken in, there is nothing to say.
    drop(recorder);
    assert!(!notes().contains("-wal"));
    let path = written(&home, "other.db3", &sample_of("sqlite.db3"));
    let journal = home.join("other.db3-journal");
    fs::write(&journal, [0; 512]).expect("written");
    assert!(info(&path).is_ok(), "the write was finished");
    fs::write(&journal, [&b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7"[..], &[0; 504]].concat()).expect("written");
    let error = failure(&path);
    assert!(error.problem.contains("was not finished") && error.subject.ends_with("other.db3"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_pipe_in_the_place_of_a_file_is_not_waited_for() {
    let home = folder();
    let pipe = |name: &str| {
        let path = home.join(name);
        rustix::fs::mkfifoat(rustix::fs::CWD, &path, rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR).expect("made");
        path
    };
    fs::write(home.join("a.db3"), sample_of("sqlite.db3")).expect("written");
    let list = pipe("metadata.yaml");
    assert!(failure(&list).to_string().contains("regular file"));
    assert_eq!(Burst::open(&home).expect("the database").len(), 5);
    fs::remove_file(&list).expect("removed");
    let listed = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - pipe.db3\n";
    fs::write(&list, listed).expect("written");
    let pipe = pipe("pipe.db3");
    assert!(failure(&home).to_string().contains("regular file"));
    let times = OpenOptions { times: pipe.to_str().and_then(|path| path.parse().ok()), ..OpenOptions::default() };
    assert!(open_with(&home.join("a.db3"), &times).is_err());
}

proptest! {
    /// Counts, lengths and checksums of a recording that is built field by field.
    #[test]
    fn recordings_of_odd_numbers_are_opened_or_refused(
        packed_by in prop::sample::select(&["", "none", "lz4", "zstd", "bz2"][..]),
        size in prop_oneof![Just(0), Just(u64::MAX), Just(1 << 32), 0..4096u64],
        crc in prop_oneof![Just(0), any::<u32>()],
        lists in prop::collection::vec(prop_oneof![Just(u64::MAX), 0..4096u64], 0..5),
        sums in any::<[bool; 2]>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
    ) {
        let whole = Recording::plain();
        let size = if size == 0 { whole.size } else { size };
        let lists = if lists.is_empty() { whole.lists.clone() } else { lists };
        let chunk = if packed_by == "zstd" { zeros_by_zstd(size % (1 << 22)) } else { whole.chunk.clone() };
        let mut bytes =
            Recording { packed_by, chunk, size, crc, lists, has_data_crc: sums[0], has_summary_crc: sums[1], ..whole }.bytes();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        let home = folder();
        match Burst::open(written(&home, "a.mcap", &bytes)) {
            Ok(burst) => prop_assert!(burst.len() <= 4096),
            Err(error) => prop_assert!(
                error.to_string().contains("a.mcap") && !error.to_string().contains("unexpectedly"), "{}", error
            ),
        }
    }
}
