//! ROS 1 bags, MCAP and ROS 2 bags. The files in `samples/` were written by the Python packages rosbags and mcap: five
//! frames of 24×16, whose sample number i is 7·i + 1000·t + 3 modulo the range (with padding behind each row in
//! `sqlite.db3` and in the left of `stereo_bz2.bag`), 0, 40, 80, 200 and 240 ms after a whole second, and a topic
//! `/notes` of texts. The values and stamps are those that the same packages read.

use super::{plain::unpacked, support::*};

macro_rules! sample {
    ($name:literal) => {
        ($name, include_bytes!(concat!("samples/", $name)).to_vec())
    };
    ($name:literal, gz) => {
        ($name, unpacked(include_bytes!(concat!("samples/", $name, ".gz"))))
    };
}

/// The samples of one topic of pictures, for the tests with damaged files; the last one has two.
pub fn samples() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        sample!("mono16.bag"),
        sample!("bayer_lz4.bag"),
        sample!("bgr8_lz4.mcap"),
        sample!("bayer16.mcap"),
        sample!("png_loose.mcap"),
        sample!("jpeg_zstd.mcap"),
        sample!("float_big.mcap"),
        sample!("sqlite.db3", gz),
        sample!("squeezed.db3", gz),
    ]
}

pub fn sample_of(name: &str) -> Vec<u8> {
    samples().into_iter().find(|(own, _)| *own == name).expect("a sample").1
}

pub fn stereo() -> (&'static str, Vec<u8>) {
    sample!("stereo_bz2.bag")
}

const TIMES_S: [f64; 5] = [0.0, 0.04, 0.08, 0.2, 0.24];
const METADATA: &str = include_str!("samples/bag_metadata.yaml");

fn named(name: &str) -> Made {
    Made::new(name, &sample_of(name))
}

impl Made {
    fn opened(&self) -> Burst {
        self.open(&OpenOptions::default()).expect("opens")
    }

    fn described(&self) -> Info {
        self.info(&OpenOptions::default())
    }
}

fn topic(name: &str) -> OpenOptions {
    OpenOptions { topic: Some(name.to_owned()), ..OpenOptions::default() }
}

/// Samples of frame `t`, of `channels` in a pixel, in numbers up to `most`.
fn samples_of(t: usize, channels: usize, most: usize) -> Vec<f32> {
    (0..24 * 16 * channels).map(|i| ((7 * i + 1000 * t + 3) % (most + 1)) as f32).collect()
}

/// Asserts that the frames of a burst are `expected`, in the files' unit.
#[track_caller]
fn assert_frames(burst: &Burst, expected: impl Fn(usize) -> Vec<f32>) {
    assert_eq!(burst.len(), 5);
    for (t, frame) in burst.frames.iter().enumerate() {
        let expected = expected(t);
        assert_eq!(frame.data().len(), expected.len());
        for (i, (found, expected)) in frame.data().iter().zip(&expected).enumerate() {
            let found = found * burst.full_scale;
            assert!((found - expected).abs() <= 1e-5 * expected.max(1.0), "frame {t}, {i}: {found}, not {expected}");
        }
    }
}

fn binned(samples: &[f32]) -> Vec<f32> {
    let at = |u: usize, v: usize| samples[24 * v + u];
    let square = |u, v| (at(u, v) + at(u + 1, v) + at(u, v + 1) + at(u + 1, v + 1)) / 4.0;
    (0..8).flat_map(|v| (0..12).map(move |u| (2 * u, 2 * v))).map(|(u, v)| square(u, v)).collect()
}

#[test]
fn frames_of_every_encoding_and_compression_are_those_that_were_sent() {
    let burst = named("mono16.bag").opened();
    assert_eq!((burst.size(), burst.full_scale, burst.encoding), ((24, 16), 65535.0, Encoding::Linear));
    assert_frames(&burst, |t| samples_of(t, 1, 65535));
    for name in ["sqlite.db3", "png_loose.mcap"] {
        assert_frames(&named(name).opened(), |t| samples_of(t, 1, 65535));
    }
    for (name, most) in [("bayer_lz4.bag", 255), ("bayer16.mcap", 65535)] {
        let burst = named(name).opened();
        assert_eq!((burst.size(), burst.binning), ((12, 8), 2), "{name}");
        assert_frames(&burst, |t| binned(&samples_of(t, 1, most)));
    }
    for (name, channels) in [("bgr8_lz4.mcap", 3), ("squeezed.db3", 4)] {
        let burst = named(name).opened();
        assert_eq!(burst.encoding, Encoding::Srgb, "{name}");
        // Blue comes first, and alpha last.
        let luma = |pixel: &[f32]| 0.0722 * pixel[0] + 0.7152 * pixel[1] + 0.2126 * pixel[2];
        assert_frames(&burst, |t| samples_of(t, channels, 255).chunks(channels).map(luma).collect());
    }
    let burst = named("float_big.mcap").opened();
    assert_frames(&burst, |t| samples_of(t, 1, 999_999_999).iter().map(|v| v / 16384.0).collect());
    // Of JPEG about.
    let burst = named("jpeg_zstd.mcap").opened();
    for (t, frame) in burst.frames.iter().enumerate() {
        let expected = |u, v| (20 + 4 * u + 3 * v + 10 * t) as f32;
        let worst = (0..384).map(|i| (255.0 * frame.data()[i] - expected(i % 24, i / 24)).abs()).fold(0.0, f32::max);
        assert!(worst < 4.0, "frame {t} differs by {worst}");
    }
}

#[test]
fn stamps_are_times_and_what_was_taken_is_said() {
    for (name, bytes) in samples() {
        let file = Made::new(name, &bytes);
        let info = file.described();
        assert_eq!((info.frames, info.begins.as_deref()), (5, Some("2023-11-14T22:13:20.000Z")), "{name}");
        assert!(info.times_s.iter().zip(TIMES_S).all(|(found, s)| (found - s).abs() < 1e-6), "{:?}", info.times_s);
        says(info.text(), &["the topic is /", "the others are /notes (5 of std_msgs/String)"]);
        let timed = OpenOptions { times: Some(TimesChoice::Header), ..OpenOptions::default() };
        let burst = file.open(&timed).expect("opens");
        assert!((burst.positions.span() - 6.0).abs() < 1e-4, "{name}: {}", burst.positions.span());
    }
    let info = named("bayer_lz4.bag").described();
    assert_eq!((&*info.kind, &*info.samples, info.binning), ("ROS 1 bag", "8 bit", 2));
    assert!(info.text().contains("is what the file says, grbg: squares of 2×2 pixels become one"), "{}", info.text());
    assert_eq!(named("jpeg_zstd.mcap").described().kind, "MCAP");
    assert_eq!(named("sqlite.db3").described().kind, "ROS 2 bag");
}

#[test]
fn of_several_topics_one_is_chosen_and_what_is_cut_off_is_refused_or_told_wherever_it_is_cut() {
    let file = Made::new(stereo().0, &stereo().1);
    let message = file.open(&OpenOptions::default()).expect_err("two topics").to_string();
    let listed = "--topic NAME which one holds the frames: /left/image_raw (5 of 24×16), /right/image_raw (5 of 24×16)";
    assert!(message.contains("2 topics of pictures") && message.contains(listed), "{message}");
    assert_frames(&file.open(&topic("/left/image_raw")).expect("left"), |t| samples_of(t, 1, 255));
    // A name without its first stroke, and numbers whose high byte comes first.
    assert_frames(&file.open(&topic("right/image_raw")).expect("right"), |t| samples_of(t, 1, 65535));
    for absent in ["/notes", "/middle"] {
        says(file.open(&topic(absent)).expect_err(absent), &[absent, listed]);
    }
    for (name, bytes) in samples().into_iter().chain([stereo()]) {
        let places = (1..bytes.len()).step_by(97).chain(bytes.len() - 40..bytes.len());
        if name.ends_with(".mcap") {
            assert_whole_messages(name, &bytes, places);
            continue;
        }
        for cut in places {
            let file = Made::new(name, &bytes[..cut]);
            let error = file.open(&OpenOptions::default()).map(|burst| burst.len()).expect_err(name);
            assert!(error.kind == ErrorKind::Damaged && error.to_string().contains(name), "{cut}: {error}");
        }
    }
}

#[test]
fn the_files_of_a_ros_2_bag_are_one_burst() {
    let (home, bag) = folder_with("night");
    fs::create_dir(&bag).expect("made");
    let file = |name: &str| samples().into_iter().find(|(own, _)| *own == name).expect("a sample").1;
    fs::write(bag.join("metadata.yaml"), METADATA).expect("written");
    fs::write(bag.join("sqlite.db3"), file("sqlite.db3")).expect("written");
    let options = OpenOptions::default();
    let found = find_bursts(from_ref(&bag), &options).expect("found");
    assert_eq!((found.len(), &*found[0].name), (1, "night"));
    for path in [&bag, &bag.join("metadata.yaml")] {
        assert_frames(&open_with(path, &options).expect("opens"), |t| samples_of(t, 1, 65535));
    }
    // Two files, of which the second has the same stamps: the frames of both are in the order of their stamps.
    let two = METADATA.replace("  - sqlite.db3", "  - 'night/sqlite.db3'\n  - again.db3");
    fs::write(bag.join("metadata.yaml"), two).expect("written");
    says(open_with(&bag, &options).expect_err("a file is missing"), &["again.db3"]);
    fs::write(bag.join("again.db3"), file("sqlite.db3")).expect("written");
    let burst = open_with(&bag, &options).expect("opens");
    assert_eq!((burst.len(), &burst.frames[0], &burst.frames[8]), (10, &burst.frames[1], &burst.frames[9]));
    // A part reaches from one file into the next.
    let take = OpenOptions { take: "4..7".parse().ok(), ..OpenOptions::default() };
    let part = open_with(&bag, &take).expect("opens");
    assert_eq!(part.frames, burst.frames[4..7], "counted in the order of the whole burst");
    // Bags beside one another are bursts.
    let other = home.join("day");
    fs::create_dir(&other).expect("made");
    fs::write(other.join("metadata.yaml"), METADATA).expect("written");
    fs::write(other.join("sqlite.db3"), file("sqlite.db3")).expect("written");
    let found = find_bursts(&[home.to_owned()], &options).expect("found");
    assert_eq!(found.iter().map(|burst| &*burst.name).collect::<Vec<_>>(), ["day", "night"]);
    // Another file of that name is none.
    fs::write(other.join("metadata.yaml"), "camera: left\n").expect("written");
    assert_frames(&open_with(&other, &options).expect("the database"), |t| samples_of(t, 1, 65535));
    fs::write(bag.join("metadata.yaml"), "rosbag2_bagfile_information:\n  version: 5\n").expect("written");
    assert!(open_with(&bag, &options).expect_err("no list").to_string().contains("relative_file_paths"));
    // Names with signs of an address.
    let signs = home.join("a b?c#d%41.db3");
    fs::write(&signs, file("sqlite.db3")).expect("written");
    assert_frames(&open_with(&signs, &options).expect("opens"), |t| samples_of(t, 1, 65535));
    // A bag whose files were packed as a whole.
    fs::write(bag.join("metadata.yaml"), METADATA).expect("written");
    fs::write(bag.join("sqlite.db3"), b"\x28\xb5\x2f\xfd packed").expect("written");
    assert!(open_with(&bag, &options).expect_err("packed").to_string().contains("zstd -d"));
}

/// Bytes with each of `from` replaced by `to`, in their order.
fn replaced(mut bytes: Vec<u8>, from: &[u8], to: &[u8]) -> Vec<u8> {
    let places: Vec<usize> = (0..bytes.len() - from.len()).filter(|at| bytes[*at..].starts_with(from)).collect();
    assert!(!places.is_empty(), "nothing to replace");
    places.into_iter().for_each(|at| bytes[at..at + to.len()].copy_from_slice(to));
    bytes
}

#[test]
fn frames_are_in_the_order_of_their_stamps_and_without_any_in_that_of_the_recording() {
    let stamp = |ns: u32| [1_700_000_000u32.to_le_bytes(), ns.to_le_bytes()].concat();
    let (_, mono) = sample!("mono16.bag");
    // The stamp of the first frame is made the last.
    let late = Made::new("late.bag", &replaced(mono.clone(), &stamp(0), &stamp(900_000_000)));
    assert_frames(&late.opened(), |t| samples_of((t + 1) % 5, 1, 65535));
    let text = late.described().text();
    assert!(text.contains("the order of their stamps, which is not that of the recording"), "{text}");
    let none = Made::new("none.bag", &replaced(mono, &stamp(80_000_000), &[0; 8]));
    assert_frames(&none.opened(), |t| samples_of(t, 1, 65535));
    let info = none.described();
    assert!(info.text().contains("those of the recording"), "{}", info.text());
    assert!(info.times_s.iter().zip(TIMES_S).all(|(found, s)| (found - s).abs() < 1e-6), "{:?}", info.times_s);
}

#[test]
fn damage_names_the_field_and_the_program_that_mends_it() {
    let failure = |name: &str, bytes: Vec<u8>| {
        let file = Made::new(name, &bytes);
        let message = file.open(&OpenOptions::default()).expect_err(name).to_string();
        assert!(message.contains(name), "{message}");
        message
    };
    let (_, mono) = sample!("mono16.bag");
    let changed = |from: &[u8], to: &[u8]| failure("bad.bag", replaced(mono.clone(), from, to));
    assert!(failure("cut.bag", mono[..mono.len() - 1].to_vec()).contains("rosbag reindex"));
    assert!(changed(b"mono16", b"yuv422").contains("encoding 'yuv422'"));
    assert!(
        changed(b"compression=none", b"compression=lzma").contains("by 'lzma'; write it anew with 'rosbag decompress'")
    );
    assert!(changed(b"topic=", b"topiz=").contains("'topic'"));
    assert!(changed(b"sensor_msgs/Image", b"sensor_msgs/Joint").contains("its topics are: /camera/image_raw (5 of"));
    assert!(changed(b"V2.0", b"V1.2").contains("version is not 2.0"));
    // Rows, columns, text, byte order, step.
    let shape = |rows: u32, columns: u32, step: u32| {
        let numbers = [&rows.to_le_bytes()[..], &columns.to_le_bytes(), &6u32.to_le_bytes(), b"mono16\0"];
        [&numbers.concat()[..], &step.to_le_bytes()].concat()
    };
    let shaped = |rows, columns, step| changed(&shape(16, 24, 48), &shape(rows, columns, step));
    assert!(shaped(16, 25, 48).contains("'step' is 48"));
    assert!(shaped(17, 24, 48).contains("'data' has 768 bytes, and 816"));
    assert!(shaped(u32::MAX, u32::MAX, u32::MAX).contains("4294967295×4294967295"));
    assert!(shaped(0, 24, 48).contains("no pixels"));
    let at = mono.windows(shape(16, 24, 48).len()).rposition(|part| part == shape(16, 24, 48)).expect("a shape");
    let odd = [&mono[..at], &shape(8, 48, 96), &mono[at + shape(8, 48, 96).len()..]].concat();
    says(failure("odd.bag", odd), &["24×16", "odd.bag (frame 4)"]);
    let (_, jpeg) = sample!("jpeg_zstd.mcap");
    assert!(failure("cut.mcap", jpeg[..400].to_vec()).contains("mcap recover"));
    let (_, loose) = sample!("png_loose.mcap");
    let other = replaced(loose, b"\x89PNG\r\n\x1a\n\0", b"\x89PNX\r\n\x1a\n\0");
    assert!(failure("bad.mcap", other).contains("compressed as 'mono16; png compressed '"));
    // A database that is no bag.
    let (_, rows) = sample!("sqlite.db3", gz);
    assert!(failure("bad.db3", replaced(rows, b"TABLE messages", b"TABLE massages")).contains("bad.db3"));
}

/// Asserts that what is left of a recording opens to its last whole message, and says so, or has none. Returns the
/// number of frames at each place.
fn assert_whole_messages(name: &str, bytes: &[u8], places: impl Iterator<Item = usize>) -> Vec<usize> {
    let whole = Made::new(name, bytes).opened();
    let at = |cut: usize| {
        let file = Made::new(name, &bytes[..cut]);
        match file.open(&OpenOptions::default()) {
            Ok(burst) => {
                assert!(whole.frames.starts_with(&burst.frames), "{name}: {cut}");
                assert!(
                    file.described().text().contains("it was not closed"),
                    "{name}: {cut}: {}",
                    file.described().text()
                );
                burst.len()
            }
            Err(error) => {
                assert!(error.kind == ErrorKind::Damaged && error.to_string().contains(name), "{cut}: {error}");
                0
            }
        }
    };
    let frames: Vec<usize> = places.map(at).collect();
    assert!(frames.is_sorted() && frames.last() == Some(&whole.len()), "{name}: {frames:?}");
    frames
}

#[test]
fn a_recording_that_was_stopped_opens_to_its_last_whole_message() {
    // Messages without chunks, or in chunks that are not packed, as of a writer that was ended at any time.
    for (name, bytes) in [sample!("png_loose.mcap"), sample!("bayer16.mcap")] {
        let frames = assert_whole_messages(name, &bytes, (0..bytes.len()).step_by(13));
        assert!((0..=5).all(|count| frames.contains(&count)), "{name}: {frames:?}");
    }
    // ROS 1 writes numbers and places into the header, and lengths into that of a chunk, when it closes them.
    for (name, mut bag) in [sample!("mono16.bag"), sample!("bayer_lz4.bag")] {
        let value = |bag: &[u8], field: &[u8]| {
            bag.windows(field.len()).position(|part| part == field).expect("a field") + field.len()
        };
        let index = value(&bag, b"index_pos=");
        let end = u64::from_le_bytes(*bag[index..].first_chunk().expect("eight bytes")) as usize;
        bag[index..index + 8].fill(0);
        for field in [&b"chunk_count="[..], b"conn_count="] {
            let at = value(&bag, field);
            bag[at..at + 4].fill(0);
        }
        bag.truncate(end);
        assert_whole_messages(name, &bag, (1..end).step_by(97).chain([end]));
        if name == "mono16.bag" {
            let (chunk, compression) = (value(&bag, b"size="), value(&bag, b"compression=none"));
            let length = chunk.max(compression) + 4 * usize::from(chunk > compression);
            bag[chunk..chunk + 4].fill(0);
            bag[length..length + 4].fill(0);
            let frames = assert_whole_messages(name, &bag, (1..end).step_by(97).chain([end]));
            assert!((0..=5).all(|count| frames.contains(&count)), "{frames:?}");
        }
    }
}
