//! Order and times of frames: stamps in names, counters, copies, lists of loggers and of several cameras, parts of a
//! burst, and what cannot be true.

use super::support::*;

fn options(times: &str, take: &str) -> OpenOptions {
    OpenOptions { times: times.parse().ok(), take: take.parse().ok(), ..OpenOptions::default() }
}

/// A folder of frames of these names, each of its own grey.
fn frames(names: &[impl AsRef<str>]) -> Folder {
    let home = folder();
    for (t, name) in names.iter().enumerate() {
        let path = home.join(name.as_ref());
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        save(&path, &grey8(8, 8, 20 * t as u8));
    }
    home
}

fn info(folder: &Path, options: &OpenOptions) -> Result<Info, Error> {
    Info::of(&[folder.to_owned()], options, &quiet())
}

fn pictures(list: &str) -> Vec<String> {
    list.split(", ").map(|name| format!("{name}.png")).collect()
}

/// Asserts that the names of `list`, which are in the order of their times, open in it by `--times names`, `seconds`
/// after the first.
#[track_caller]
fn assert_seconds(list: &str, seconds: &[f64]) {
    let names = pictures(list);
    let home = frames(&names);
    let burst = open_with(&home, &options("names", "")).unwrap_or_else(|error| panic!("{list}: {error}"));
    assert_eq!(burst.frame_names, names, "{:?}", burst.taken);
    let interval = burst.positions.interval_s().unwrap_or_else(|| panic!("{list}: {:?}", burst.taken));
    for (position, second) in burst.positions.since_first().iter().zip(seconds) {
        assert!((position * interval - second).abs() < 1e-6 + 2e-4 * interval, "{list}: {position} of {interval} s");
    }
    assert_eq!(info(&home, &options("names", "")).expect("described").positions, burst.positions.since_first());
}

#[test]
fn seconds_and_their_fractions_are_read_with_and_without_leading_zeros() {
    for (list, seconds) in [
        // Nanoseconds without leading zeros, after a point, a line or a hyphen, and over the end of a second.
        ("12_9658000, 12_45788000, 12_145716000, 13_5000000", [0.0, 0.03613, 0.136058, 0.995342]),
        ("a-12-9658000, a-12-45788000, a-12-145716000, a-13-5000000", [0.0, 0.03613, 0.136058, 0.995342]),
        (
            "1738133056.9658000, 1738133056.45788000, 1738133056.77710000, 1738133056.145716000",
            [0.0, 0.03613, 0.068052, 0.136058],
        ),
        (
            "f_1600000000_966666666, f_1600000001_0, f_1600000001_33333333, f_1600000001_66666666",
            [0.0, 0.033333, 0.066667, 0.1],
        ),
        ("1600000000-966666, 1600000001-000000, 1600000001-033333, 1600000001-066666", [0.0, 0.033334, 0.066667, 0.1]),
        // Numbers as programs print them, without zeros at their ends.
        ("1341846313.5592, 1341846313.592, 1341846313.6255, 1341846313.66", [0.0, 0.0328, 0.0663, 0.1008]),
        ("1341846313.9, 1341846314.05, 1341846314.2, 1341846314.35", [0.0, 0.15, 0.3, 0.45]),
        ("0.04, 0.08, 0.12, 0.2", [0.0, 0.04, 0.08, 0.16]),
        ("t9.5, t10.0, t10.25, t10.5", [0.0, 0.5, 0.75, 1.0]),
        // Dates with milliseconds, padded or not.
        (
            "20210301_220000_940, 20210301_220000_973, 20210301_220001_006, 20210301_220001_040",
            [0.0, 0.033, 0.066, 0.1],
        ),
        ("20210301_220000_940, 20210301_220000_973, 20210301_220001_6, 20210301_220001_40", [0.0, 0.033, 0.066, 0.1]),
        (
            "2021-03-01 22.00.00.25, 2021-03-01 22.00.00.5, 2021-03-01 22.00.00.75, 2021-03-01 22.00.01",
            [0.0, 0.25, 0.5, 0.75],
        ),
        ("2021-03-01_220000, 2021-03-01_220002, 2021-03-01_220004, 2021-03-01_220006", [0.0, 2.0, 4.0, 6.0]),
        (
            "IMG_20210301_235959900_BURST0_COVER, IMG_20210302_000000000_BURST1, IMG_20210302_000000100_BURST2, \
             IMG_20210302_000000200_BURST3",
            [0.0, 0.1, 0.2, 0.3],
        ),
    ] {
        assert_seconds(list, &seconds);
    }
}

#[test]
fn counters_are_no_fractions_of_a_second() {
    for (list, positions) in [
        (
            "IMG_20180914_094602055_BURST000_COVER, IMG_20180914_094602055_BURST001, IMG_20180914_094602055_BURST002",
            Some([0.0, 1.0, 2.0]),
        ),
        ("IMG_20210301_220000_Burst1, IMG_20210301_220000_Burst2, IMG_20210301_220000_Burst3", Some([0.0, 1.0, 2.0])),
        ("20210301_220000_001, 20210301_220000_002, 20210301_220000_004", Some([0.0, 1.0, 3.0])),
        ("20210301_220000_009, 20210301_220000_010, 20210301_220001_011", Some([0.0, 1.0, 2.0])),
        ("2021-03-01-22-00-00-1, 2021-03-01-22-00-00-2, 2021-03-01-22-00-00-3", Some([0.0, 1.0, 2.0])),
        (
            "00001IMG_00001_BURST20210301220000123_COVER, 00002IMG_00002_BURST20210301220000123, \
             00003IMG_00003_BURST20210301220000123",
            Some([0.0, 1.0, 2.0]),
        ),
        ("20210301_000001, 20210301_000002, 20210301_000003", Some([0.0, 1.0, 2.0])),
        ("1600000000_1, 1600000000_2, 1600000000_3", Some([0.0, 1.0, 2.0])),
        // Pairs, a copy without a number, and counters of each second: nothing tells when they were taken.
        ("PXL_20210301_220000123.RAW-01, PXL_20210301_220000123.RAW-02, PXL_20210301_220000456.RAW-01", None),
        ("20210301_220000, 20210301_220000(1), 20210301_220000(2)", None),
        ("20210301_220000_001, 20210301_220000_002, 20210301_220001_001", None),
    ] {
        let home = frames(&pictures(list));
        let described = info(&home, &OpenOptions::default()).expect("described");
        assert_eq!(described.interval_s, None, "{list}: {described:?}");
        match (open_with(&home, &options("names", "")), positions) {
            (Ok(burst), Some(positions)) => {
                assert_eq!(burst.positions.since_first(), positions, "{list}");
                assert_eq!(burst.positions.interval_s(), None, "{list}");
            }
            (Err(error), None) => assert!(error.to_string().contains("names have the same time"), "{error}"),
            (found, _) => panic!("{list}: {found:?}"),
        }
    }
    // Seconds that differ are times.
    assert_seconds("IMG_2021-03-01_22-00-19_0, IMG_2021-03-01_22-00-20_1", &[0.0, 1.0]);
}

#[test]
fn a_name_without_number_stands_before_its_copies_and_what_a_list_leaves_open_is_asked() {
    for names in [
        ["20210301_220000.png", "20210301_220000(1).png", "20210301_220000(2).png", "20210301_220000(10).png"],
        ["x.png", "x (2).png", "x (3).png", "x (10).png"],
        ["x.png", "x - Copy.png", "x - Copy (2).png", "x - Copy (3).png"],
        ["x.png", "x copy.png", "x copy 2.png", "x copy 10.png"],
        ["x.png", "x!1.png", "x!2.png", "x+1.png"],
        ["frame_1.png", "frame_2.png", "frame_002.png", "frame_10.png"],
        ["a_.png", "a_1.png", "a_1.tif.png", "a_2.png"],
        ["a.png", "frame_.png", "frame_1.png", "frame_2.png"],
    ] {
        assert_eq!(Burst::open(frames(&names)).expect("a burst").frame_names, names);
    }
    for (list, words) in [
        ("0,10\n1,20\n2,30\n3,40\n4,50\n", "several numbers"),
        ("59000.00100\n59000.00200\n59000.00300\n59000.00400\n59000.00500\n", "time_s or MJD"),
        ("22:00:00\n1.5\n2.5\n3.5\n4.5\n", "mixed"),
        ("time_ns\n0\n1\n2\n3\n4\n", "frames would be 1e-9 s apart"),
        ("a/00000.png,1\nb/00000.png,2\nc/00001.png,3\nc/00002.png,4\nc/00003.png,5\nc/00004.png,6\n", "lines 1 and 2"),
    ] {
        says(listed(list).expect_err(list), &[words, "t.txt"]);
    }
}

/// Opens five frames by a list beside them: positions, seconds of an interval, and notes.
fn listed(list: impl AsRef<[u8]>) -> Result<(Vec<f64>, f64, String), Error> {
    let home = frames(&["00000.png", "00001.png", "00002.png", "00003.png", "00004.png"]);
    fs::write(home.join("t.txt"), &list).expect("written");
    let burst = open_with(&home, &options("t.txt", ""))?;
    assert!(burst.frame_names.is_sorted(), "{}: {:?}", String::from_utf8_lossy(list.as_ref()), burst.frame_names);
    Ok((burst.positions.since_first(), burst.positions.interval_s().unwrap_or_default(), burst.taken.join("; ")))
}

/// A list of five lines, with the third frame interval twice as long.
fn lines(heading: &str, line: impl Fn(usize, u64) -> String) -> String {
    let rows = [0, 1, 2, 4, 5].into_iter().enumerate().map(|(frame, at)| line(frame, at) + "\n");
    heading.to_owned() + &rows.collect::<String>()
}

#[test]
fn lists_of_loggers_spreadsheets_and_subtitles_are_read() {
    let ms = |at: u64| 980 + 40 * at;
    let second = |at: u64| format!("{:02}", ms(at) / 1000);
    let point = |at: u64, by: char| format!("{}{by}{:03}", second(at), ms(at) % 1000);
    let hundredth = |at: u64| format!("{},{:02}", at * 4 / 100, at * 4 % 100);
    for (list, interval_s) in [
        (lines("", |k, at| format!("{k:05}.png 2021-03-01 22:00:{}", point(at, ','))), 0.04),
        (lines("", |k, at| format!("{k:05}.png,2021-03-01 22:00:{}", point(at, ','))), 0.04),
        (lines("", |_, at| format!("2021-03-01 22:00:{}", point(at, ','))), 0.04),
        (lines("", |_, at| format!("2021-03-01T22:00:{}+02:00", point(at, '.'))), 0.04),
        (lines("", |k, at| format!("2021-03-01 22:00:{} INFO saved {k:05}.png", point(at, ','))), 0.04),
        (lines("", |k, at| format!("[2021-03-01 22:00:{}] [INFO] saved {k:05}.png, gain 7", point(at, ','))), 0.04),
        (lines("", |_, at| format!("22:00:{}", point(at, ','))), 0.04),
        (lines("", |k, at| format!("22:00:{}\t{k:05}.png", point(at, '.'))), 0.04),
        (
            lines("", |k, at| {
                format!("{}\n00:00:{} --> 00:00:{}\ntext 7\n", k + 1, point(at, ','), point(at + 1, ','))
            }),
            0.04,
        ),
        (lines("WEBVTT\n\n", |_, at| format!("00:{} --> 00:{}\n", point(at, '.'), point(at + 1, '.'))), 0.04),
        (lines("", |_, at| hundredth(at)), 0.04),
        (lines("time_s\n", |_, at| hundredth(at)), 0.04),
        (lines("", |k, at| format!("{k:05}.png;{}", hundredth(at))), 0.04),
        (lines("", |k, at| format!("{k:05}.png\t{}", hundredth(at))), 0.04),
        (lines("", |k, at| format!("{} {k:05}.png", hundredth(at))), 0.04),
        (lines("", |k, at| format!("\"{k:05}.png\",\"{}\"", hundredth(at))), 0.04),
        (lines("Frame;Timestamp (ms)\n", |k, at| format!("{k};{},3", 33 * at)), 0.033),
        (lines("# timestamp [ms] filename\n", |k, at| format!("{}.5 {k:05}.png", 33 * at)), 0.033),
        (lines("name,time_h\n", |k, at| format!("{k:05}.png,{}", 0.5 * at as f64)), 1800.0),
        (lines("name,Time [min]\n", |k, at| format!("{k:05}.png,{}", 0.5 * at as f64)), 30.0),
        (lines("name,h,time\n", |k, at| format!("{k:05}.png,480,{:.2}", 0.04 * at as f64)), 0.04),
        (
            lines("name,exposure time [s],timestamp [s]\n", |k, at| format!("{k:05}.png,0.5,{:.2}", 0.04 * at as f64)),
            0.04,
        ),
        (lines("name,MJD\n", |k, at| format!("{k:05}.png,59000.{:012}", 10_000_000_000 + 462_962_963 * at)), 40.0),
        (lines("JD\n", |_, at| format!("2459000.5{:010}", 4_629_630 * at)), 4.0),
        (lines("", |k, at| format!("{k:05}.png 59000.{:06}", 1000 + 463 * at)), 40.0),
        (lines("", |_, at| format!("2459000.{:06}", 1000 + 463 * at)), 40.0),
    ] {
        let (positions, interval, note) = listed(&list).unwrap_or_else(|error| panic!("{list}: {error}"));
        let is_near = |(found, expected): (&f64, f64)| (found - expected).abs() < 0.005;
        assert!(positions.iter().zip([0.0, 1.0, 2.0, 4.0, 5.0]).all(is_near), "{list}: {positions:?}; {note}");
        assert!((interval / interval_s - 1.0).abs() < 2e-3, "{list}: {interval}; {note}");
    }
    let list = "23:59:59.90\n23:59:59.95\n00:00:00.00\n00:00:00.05\n00:00:00.10\n";
    assert_eq!(listed(list).expect("a burst").0, [0.0, 1.0, 2.0, 3.0, 4.0]);
    // As shells on Windows write what a program prints.
    for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
        let list: Vec<u8> = format!("\u{feff}{list}").encode_utf16().flat_map(bytes).collect();
        assert_eq!(listed(list).expect("a burst").0, [0.0, 1.0, 2.0, 3.0, 4.0]);
    }
}

#[test]
fn a_list_of_several_cameras_is_matched_by_folder_and_found_above_the_frames() {
    let cameras = ["cam0", "cam1", "cam2"];
    let names: Vec<String> = cameras.iter().flat_map(|cam| (0..3).map(move |k| format!("{cam}/{k}.png"))).collect();
    let time = |cam: usize, k: usize| 0.1 * ((cam + 1) * k * k) as f64 + 0.03 * cam as f64;
    let all = || (0..3).flat_map(|cam| (0..3).map(move |k| (cam, k)));
    for list in [
        all().map(|(cam, k)| format!("{:.3} cam{cam}/{k}.png\n", time(cam, k))).collect::<String>(),
        all().map(|(cam, k)| format!("C:\\rig\\cam{cam}\\{k}.png,{:.3}\n", time(cam, k))).collect(),
        all().map(|(cam, k)| format!("cam{cam},{k}.png,{:.3}\n", time(cam, k))).collect(),
        all().map(|(cam, k)| format!("rig/cam{cam}/{k};{:.3}\n", time(cam, k))).collect(),
    ] {
        let home = frames(&names);
        fs::write(home.join("list.txt"), &list).expect("written");
        for (cam, name) in cameras.iter().enumerate() {
            let burst = open_with(&home.join(name), &options("list.txt", "")).unwrap_or_else(|e| panic!("{list}: {e}"));
            let interval = burst.positions.interval_s().expect("seconds");
            assert!((interval - 0.1 * (cam + 1) as f64).abs() < 1e-9, "{list}: {name} {interval}");
            assert_eq!(burst.positions.since_first(), [0.0, 1.0, 4.0]);
        }
    }
    // A list beside the frames is nearer.
    let home = frames(&["mav0/a.png", "mav0/b.png"]);
    fs::write(home.join("list.csv"), "a.png,0\nb.png,0.5\n").expect("written");
    fs::write(home.join("mav0/list.csv"), "a.png,0\nb.png,0.25\n").expect("written");
    let burst = open_with(&home.join("mav0"), &options("list.csv", "")).expect("a burst");
    assert_eq!(burst.positions.interval_s(), Some(0.25));
}

#[test]
fn a_part_is_counted_in_the_order_of_the_whole() {
    let names =
        ["1341846313.7.png", "1341846313.66.png", "1341846313.592.png", "1341846313.6255.png", "1341846313.5592.png"];
    let home = frames(&names);
    let list: String = [9, 7, 5, 1, 3].iter().zip(0..).map(|(ms, _)| format!("0.{ms}\n")).collect();
    fs::write(home.join("plain.txt"), list).expect("written");
    let named: String = names.iter().zip([4, 3, 1, 2, 0]).map(|(name, at)| format!("{name},0.{at}\n")).collect();
    fs::write(home.join("named.txt"), named).expect("written");
    for times in ["names", "plain.txt", "named.txt", "even"] {
        let whole = open_with(&home, &options(times, "")).expect("a burst");
        for take in ["0..2", "1..4", "2..5", "0..5"] {
            let options = options(times, take);
            let range = options.take.expect("a part");
            let part = open_with(&home, &options).expect("a part");
            assert_eq!(part.frame_names, whole.frame_names[range.start..range.end], "{times} {take}");
            let gaps = |burst: &Burst| {
                let unit = burst.positions.interval_s().unwrap_or(1.0);
                let at = burst.positions.since_first();
                at.windows(2).map(|two| (two[1] - two[0]) * unit).collect::<Vec<f64>>()
            };
            for (a, b) in gaps(&part).iter().zip(&gaps(&whole)[range.start..]) {
                assert!((a - b).abs() < 1e-9, "{times} {take}: {a} {b}");
            }
            let info = info(&home, &options).expect("described");
            assert_eq!((info.frames, info.files), (part.len(), part.len()), "{times} {take}");
        }
        says(open_with(&home, &options(times, "3..6")).expect_err("there are five"), &["beyond the 5 frames"]);
    }
    fs::write(home.join("two.txt"), "0.5\n0.75\n").expect("written");
    assert_eq!(open_with(&home, &options("two.txt", "1..3")).expect("a part").positions.interval_s(), Some(0.25));
    let (other, stack) = folder_with("stack.npy");
    write_npy(&stack, &Array3::<u8>::from_shape_fn((5, 8, 8), |(t, v, u)| (t + u + v) as u8)).expect("written");
    fs::write(other.join("five.txt"), "0\n0.5\n1\n2\n4\n").expect("written");
    let part = open_with(&stack, &options("five.txt", "2..5")).expect("a part");
    assert_eq!((part.positions.since_first(), part.positions.interval_s()), (vec![0.0, 1.0, 3.0], Some(1.0)));
    let sequence = find_bursts(&[home.to_owned()], &OpenOptions::default()).expect("a sequence").remove(0);
    let cut = SequenceCut::new(2, None).expect("a cut");
    let bursts = cut_sequence(&sequence, cut, &options("names", "")).expect("bursts");
    let first: Vec<_> = bursts[0].paths.iter().filter_map(|path| path.file_name()).collect();
    assert_eq!(first, ["1341846313.5592.png", "1341846313.592.png"]);
}

#[test]
fn an_order_that_contradicts_names_or_headers_is_told() {
    let plain = OpenOptions::default();
    let told = |home: &Folder, option: &str| {
        let described = info(home, &plain).expect("described");
        assert_eq!((described.interval_s, described.positions.len()), (None, 0), "{described:?}");
        for notes in [described.taken, open_with(home, &plain).expect("a burst").taken] {
            assert!(
                notes.iter().any(|note| note.contains("the order of the frames is not that") && note.contains(option)),
                "{notes:?}"
            );
        }
    };
    told(
        &frames(&["1341846313.5592.png", "1341846313.592.png", "1341846313.66.png", "1341846313.7.png"]),
        "--times names",
    );
    told(&frames(&["b_20210301_220000.png", "a_20210301_220001.png"]), "--times names");
    let home = folder();
    for (name, bytes) in [
        ("0.jpg", include_bytes!("samples/exif_1.jpg").as_slice()),
        ("1.jpg", include_bytes!("samples/exif_0.jpg")),
        ("2.jpg", include_bytes!("samples/exif_2.jpg")),
    ] {
        fs::write(home.join(name), bytes).expect("written");
    }
    told(&home, "--times header");
    fs::copy(home.join("2.jpg"), home.join("3.jpg")).expect("copied");
    fs::remove_file(home.join("0.jpg")).expect("removed");
    let twice = info(&home, &plain).expect("described");
    assert!(
        twice.taken.iter().any(|note| note.contains("frames 1 and 2, counted from 0, have the same time")),
        "{twice:?}"
    );
    // The times that were asked for are shown, whatever the headers beside them say.
    let home = folder();
    for (name, bytes) in [
        ("20210301_220000.jpg", include_bytes!("samples/exif_0.jpg").as_slice()),
        ("20210301_220500.jpg", include_bytes!("samples/exif_1.jpg")),
        ("20210301_221000.jpg", include_bytes!("samples/exif_2.jpg")),
    ] {
        fs::write(home.join(name), bytes).expect("written");
    }
    let [named, headed] = ["names", "header"].map(|times| info(&home, &options(times, "")).expect("described").text());
    assert!(named.contains("times   600.000 s in all, an interval of 300.000000 s"), "{named}");
    assert!(headed.contains("times   from ") && !headed.contains("600.000"), "{headed}");
    // What is in order, what has no times for sure, and what was asked for, is told nothing.
    for (names, times) in [
        (["1341846313.1.png", "1341846313.2.png", "1341846313.3.png"], ""),
        (["a_9000.png", "b_5000.png", "c_1.png"], ""),
        (["b_20210301_220000.png", "a_20210301_220001.png", "c_20210301_220002.png"], "even"),
    ] {
        let home = frames(&names);
        let notes = info(&home, &options(times, "")).expect("described").taken;
        assert!(!notes.iter().any(|note| note.contains("the order of the frames")), "{notes:?}");
    }
}

/// Names of empty files in the order in which a folder of them is listed.
fn order_of(names: &[&String]) -> Vec<PathBuf> {
    let home = folder();
    names.iter().for_each(|name| fs::write(home.join(format!("{name}.png")), b"").expect("written"));
    let listed = files_at(&[home.to_path_buf()]).expect("listed");
    listed.iter().map(|file| file.strip_prefix(&home).expect("within").to_path_buf()).collect()
}

proptest! {
    // If this were not a total order, sorting could panic, and would depend on the file system.
    #[test]
    fn natural_order_is_total(
        names in prop::collection::btree_set("[0-9a_é٣\u{ff11}( -][0-9a_.é٣\u{ff11}() -]{0,6}|[0-9]{15,25}", 3),
    ) {
        let names: Vec<&String> = names.iter().collect();
        let all = order_of(&names);
        for without in 0..3 {
            let two: Vec<&String> = (0..3).filter(|k| *k != without).map(|k| names[k]).collect();
            let pair = order_of(&two);
            let within: Vec<_> = all.iter().filter(|file| pair.contains(file)).collect();
            prop_assert_eq!(within, pair.iter().collect::<Vec<_>>());
        }
    }
}

proptest! {
    #[test]
    fn seconds_in_names_are_read_in_any_form(
        begin in 1_000_000_000i64..4_000_000_000, nanoseconds in 0i64..1_000_000_000, gap in 5_000_000i64..200_000_000,
        form in 0usize..5, count in 3i64..9,
    ) {
        let times: Vec<(i64, i64)> = (0..count)
            .map(|k| nanoseconds + k * gap)
            .map(|ns| (begin + ns / 1_000_000_000, ns % 1_000_000_000))
            .collect();
        let names: Vec<String> = times.iter().map(|(s, ns)| match form {
            0 => format!("{s}_{ns}"),
            1 => format!("cam_{s}.{ns:09}"),
            2 => format!("{s}-{ns:09}"),
            3 => format!("cam2_{s}_{:06}_left", ns / 1000),
            _ => format!("{s}{ns:09}"),
        } + ".png").collect();
        let home = frames(&names);
        let burst = open_with(&home, &options("names", "")).expect("a burst");
        prop_assert_eq!(&burst.frame_names, &names);
        // Few nanoseconds of few digits may be any fraction.
        let is_open = form == 0 && times.iter().all(|(_, ns)| *ns < 1_000_000);
        let interval = burst.positions.interval_s().expect("seconds");
        prop_assert!(is_open || (interval / (gap as f64 * 1e-9) - 1.0).abs() < 1e-3, "{names:?}: {interval}");
    }
    // Whatever names and lists hold, there is a burst with an interval that a camera can have, or an error.
    #[test]
    fn no_name_and_no_list_gives_times_that_cannot_be(
        names in prop::collection::btree_set("[0-9_.-]{0,3}(20210301|1600000000|12)?[_.T-]?(2200[0-5]{2})?[_.]?[0-9]{0,9}[a-z(1)]{0,2}", 2..5),
        text in "(([0-9]{1,2}:){0,2}[-#0-9.,;:\" \ta-zTZ>+é]{0,20}\n){0,6}",
    ) {
        let names: Vec<String> = names.iter().map(|name| format!("a{name}.png")).collect();
        let home = frames(&names);
        fs::write(home.join("t.txt"), &text).expect("written");
        for times in ["names", "t.txt"] {
            match open_with(&home, &options(times, "")) {
                Ok(burst) => {
                    let at = burst.positions.since_first();
                    prop_assert!(at.windows(2).all(|two| two[0] < two[1]), "{at:?}");
                    prop_assert!(burst.positions.interval_s().is_none_or(|interval| interval >= 5e-6), "{names:?} {text:?}");
                }
                Err(error) => prop_assert!(error.to_string().len() > 20, "{error}"),
            }
        }
    }
}
