//! Times of frames: lists, names and what files hold. The photographs in `samples/` were written by Pillow.

use super::support::*;

fn options(times: &str) -> OpenOptions {
    OpenOptions { times: times.parse().ok(), ..OpenOptions::default() }
}

fn open(folder: &Path, times: &str) -> Result<Burst, Error> {
    Burst::open_with(&[folder.to_owned()], &options(times), &quiet())
}

/// Opens frames of these names in a folder that also holds `list` as `list.txt`.
fn with_list(names: &[&str], list: &str, times: &str) -> Result<Burst, Error> {
    let home = folder();
    names.iter().enumerate().for_each(|(t, name)| save(&home.join(name), &grey8(16, 16, 30 * t as u8)));
    fs::write(home.join("list.txt"), list).expect("written");
    open(&home, times)
}

fn timed(burst: Result<Burst, Error>) -> (Vec<f64>, f64, String) {
    let burst = burst.expect("a burst");
    let note = burst.taken.last().cloned().unwrap_or_default();
    (burst.positions.since_first(), burst.positions.interval_s().unwrap_or_default(), note)
}

#[test]
fn lists_of_robots_are_read_beside_the_frames_and_frames_are_in_the_order_of_their_times() {
    let tum = "# color images\n# timestamp filename\n5.25 rgb/5.25.png\n5.5 rgb/5.5.png\n6.0 rgb/6.0.png\n6.25 rgb/6.25.png\n";
    let (positions, interval_s, note) = timed(with_list(&["5.25.png", "5.5.png", "6.25.png"], tum, "list.txt"));
    assert_eq!((positions, interval_s), (vec![0.0, 1.0, 4.0], 0.25), "lines of other frames do not count");
    assert!(note.contains("seconds by their fractions") && note.contains("the longest gap is 3.00"), "{note}");
    let euroc = "#timestamp [ns],filename\n1403636579763555584,1403636579763555584.png\n1403636579813555584,1403636579813555584.png\n";
    let (positions, interval_s, note) =
        timed(with_list(&["1403636579763555584.png", "1403636579813555584.png"], euroc, "list.txt"));
    assert_eq!((positions, interval_s), (vec![0.0, 1.0], 0.05));
    assert!(note.contains("nanoseconds as their heading says; they are even"), "{note}");
    let frames = ["0.png", "1.png", "2.png"];
    for (list, interval_s, unit) in [
        ("0.000000e+00\n1.0e-01\n3.0e-01\n", 0.1, "seconds by their fractions"),
        (
            "2011-09-26 13:02:25.964389445\n2011-09-26 13:02:26.064389445\n2011-09-26 13:02:26.264389445\n",
            0.1,
            "as dates",
        ),
        ("index;time_ms;file\n0;12;0.png\n1;45;1.png\n2;111;2.png\n", 0.033, "milliseconds as their heading says"),
        ("0\n33\n99\n", 0.033, "milliseconds by the distance"),
        ("0\n33333\n99999\n", 0.033_333, "microseconds by the distance"),
        ("7\n8\n10\n", 0.0, "numbers of frames by the distance"),
        ("secs,nsecs,file\n5,900000000,0.png\n6,0,1.png\n6,200000000,2.png\n", 0.1, "seconds as their heading says"),
        ("time_us,time_s\n900000,15\n000000,16\n200000,16\n", 0.1, "seconds as their heading says"),
        ("name,frames\n2.png,3\n0.png,0\n1.png,1\n", 0.0, "numbers of frames as their heading says"),
    ] {
        let (positions, interval, note) = timed(with_list(&frames, list, "list.txt"));
        assert_eq!(positions, [0.0, 1.0, 3.0], "{list}");
        assert!((interval - interval_s).abs() < 1e-9 && note.contains(unit), "{list}: {interval} {note}");
    }
    let burst = with_list(&["a.png", "b.png", "c.png"], "c.png,0.5\na.png,1.5\nb.png,1\n", "list.txt");
    let burst = burst.expect("a burst");
    assert_eq!(burst.frame_names, ["c.png", "b.png", "a.png"]);
    assert!(burst.taken.last().is_some_and(|note| note.contains("in the order of their times")), "{:?}", burst.taken);
}

#[test]
fn names_have_stamps_and_units_are_guessed() {
    for (names, last, interval_s) in [
        (["1305031102.175304.png", "1305031102.185304.png", "1305031102.205304.png"], 3.0, 0.01),
        (["c0_1403636579763555584.png", "c0_1403636579813555584.png", "c0_1403636579913555584.png"], 3.0, 0.05),
        (["1614636000123.png", "1614636000223.png", "1614636000423.png"], 3.0, 0.1),
        (["IMG_20210301_220000123.png", "IMG_20210301_220000623.png", "IMG_20210301_220001623.png"], 3.0, 0.5),
        (["2021-03-01T22-00-00.5.png", "2021-03-01T22-00-02.25.png", "2021-03-01T22-00-04.png"], 2.0, 1.75),
        (["20210228235958.png", "20210301000000.png", "20210301000002.png"], 2.0, 2.0),
        (["frame_0001.png", "frame_0002.png", "frame_0004.png"], 3.0, 0.0),
        (["img_0.1s.png", "img_0.2s.png", "img_1.0s.png"], 9.0, 0.1),
        (["12.png", "12.5.png", "13.25.png"], 3.0, 0.416_666_7),
        (["f_0,5.png", "f_1,0.png", "f_2,5.png"], 4.0, 0.5),
        (["run2_000033_a7.png", "run2_000066_b8.png", "run2_000099_c9.png"], 2.0, 0.033),
    ] {
        let (positions, interval, note) = timed(with_list(&names, "", "names"));
        assert!((positions[2] - last).abs() < 1e-4, "{names:?}: {positions:?} {interval}");
        assert!((interval - interval_s).abs() < 1e-6, "{names:?}: {positions:?} {interval}");
        assert!(note.contains("in the names"), "{note}");
    }
}

#[test]
fn files_hold_times() {
    let home = folder();
    for (name, bytes) in [
        ("0.jpg", include_bytes!("samples/exif_0.jpg").as_slice()),
        ("1.jpg", include_bytes!("samples/exif_1.jpg")),
        ("2.jpg", include_bytes!("samples/exif_2.jpg")),
    ] {
        fs::write(home.join(name), bytes).expect("written");
    }
    let (positions, interval_s, _) = timed(open(&home, "exif"));
    assert_eq!(positions, [0.0, 1.0, 3.0]);
    assert!((interval_s - 0.25).abs() < 1e-6, "{interval_s}");
    assert!(open(&home, "even").expect("a burst").positions.is_even());
    let info = Info::of(&[home.to_owned()], &OpenOptions::default(), &quiet()).expect("described");
    assert_eq!((info.positions.clone(), info.are_times_used), (vec![0.0, 1.0, 3.0], false));
    let text = info.text();
    for part in
        ["from 2021-03-01T22:00:00.100Z", "the longest gap is 2.00 frame intervals", "--times header", "4.00 px/s"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let home = folder();
    for (name, bytes) in [
        ("0.tif", include_bytes!("samples/dated_0.tif").as_slice()),
        ("1.tif", include_bytes!("samples/dated_1.tif")),
        ("2.tif", include_bytes!("samples/dated_2.tif")),
    ] {
        fs::write(home.join(name), bytes).expect("written");
    }
    assert_eq!(timed(open(&home, "header")).0, [0.0, 1.0, 3.0]);
    let film = home.join("film.ser");
    fs::write(&film, include_bytes!("samples/mono12.ser")).expect("written");
    let info = Info::of(from_ref(&film), &options("header"), &quiet()).expect("described");
    assert!(info.are_times_used && info.interval_s.is_some(), "{info:?}");
    let burst = Burst::open_with(&[film], &options("header"), &quiet()).expect("a film");
    assert_eq!(burst.positions.since_first(), info.positions);
}

#[test]
fn what_is_wrong_is_named_with_file_and_line() {
    let names = ["a.png", "b.png"];
    for (list, times, says) in [
        ("", "list.txt", "no line with a time"),
        ("0.0\nlater\n", "list.txt", "line 2: 'later' is no time"),
        ("name,time\na.png,0\nb.png\n", "list.txt", "line 3: '' is no time"),
        ("0 0.1 0.2\n1 0.3 0.4\n", "list.txt", "line 1 has several numbers"),
        ("a.png,1\nb.png,1e99\n", "list.txt", "line 2: '1e99' is no time"),
        ("0\n1\n2\n", "list.txt", "the list has 3 times for 2 frames"),
        ("a.png,1\nc.png,2\n", "list.txt", "the list has no line for b.png"),
        ("a.png,1.5\n\nb.png,1.5\n", "list.txt", "lines 1 and 3: a.png and b.png have the same time"),
        ("", "names", "the name 'a.png' has no time of its own"),
        ("", "header", "a.png does not say when it was taken"),
        ("", "gone.csv", "there is no such file"),
    ] {
        let error = with_list(&names, list, times).expect_err(says).to_string();
        assert!(error.contains(says), "{list}: {error}");
        assert!(times != "list.txt" || error.contains("list.txt"), "{error}");
    }
    let (home, film) = folder_with("film.ser");
    fs::write(&film, include_bytes!("samples/mono12.ser")).expect("written");
    fs::write(home.join("list.txt"), "3\n2\n1\n0\n").expect("written");
    let opened = |times: &str| Burst::open_with(from_ref(&film), &options(times), &quiet());
    let count = opened("even").expect("a film").len();
    let falling: String = (0..count).map(|t| format!("{}\n", count - t)).collect();
    fs::write(home.join("list.txt"), falling).expect("written");
    let error = opened("list.txt").expect_err("it falls").to_string();
    assert!(error.contains("lines 1 and 2: frame 0 and frame 1 are not in the order of their times"), "{error}");
    assert!(opened("names").expect_err("one file").to_string().contains("holds all"), "one name");
}

proptest! {
    // Whatever a list and names hold, there is a burst, or an error that says why there is none.
    #[test]
    fn any_list_and_any_names_are_times_or_an_error(
        text in "([-#0-9.,; \ta-zTZ:e+\u{b5}]{0,24}\n){0,8}", name in "[a-z0-9._-]{1,12}",
        known in prop::sample::select(vec!["", "# time,name\n", "1403636579763555584,q.png\n", "5.25 rgb/q.png\n", "0.0e+00\n"]),
    ) {
        let names = [format!("a{name}.png"), format!("a{name}7.png")];
        for times in ["list.txt", "names"] {
            match with_list(&[&names[0], &names[1]], &format!("{known}{text}"), times) {
                Ok(burst) => {
                    let offsets = burst.positions.since_first();
                    prop_assert!(offsets.len() == 2 && offsets[0] < offsets[1] && offsets[1].is_finite());
                }
                Err(error) => prop_assert!(error.to_string().len() > 20, "{error}"),
            }
        }
    }

    #[test]
    fn a_written_list_is_read_as_it_was(gaps in prop::collection::vec(10_000u64..2_000_000_000, 2..9)) {
        let times: Vec<u64> = gaps.iter().scan(1_403_636_579_763_555_584, |at, gap| { *at += gap; Some(*at) }).collect();
        let text: String = times.iter().map(|time| format!("{time},f{time}.png\n")).collect();
        let names: Vec<String> = times.iter().map(|time| format!("f{time}.png")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let (positions, interval_s, _) = timed(with_list(&names, &text, "list.txt"));
        for (position, time) in positions.iter().zip(&times) {
            let expected = (time - times[0]) as f64 * 1e-9;
            prop_assert!((position * interval_s - expected).abs() <= 2e-4 * interval_s, "{position} {interval_s}: {expected}");
        }
    }
}
