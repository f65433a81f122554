//! Raw files decoded by a process of their own: values and messages equal those without one, and any end of that
//! process is an error about the file.
//!
//! The process is set for the whole program of these tests.

#[allow(dead_code)] // other tests use more of them
#[path = "../../core/tests/files/opening/crafted.rs"]
mod crafted;
#[allow(dead_code)]
#[path = "../../core/tests/files/opening/dng.rs"]
mod dng;

use crate::support::*;
use burstscope::burst::{DecodeWorker, Limits};
use burstscope::error::{Error, ErrorKind};
use dng::Dng;
use proptest::prelude::*;
use std::sync::Once;

fn with_worker() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let program = PathBuf::from(env!("CARGO_BIN_EXE_burstscope"));
        assert!(DecodeWorker { program, arguments: vec![burstscope::cli::DECODE_WORKER.into()] }.install());
        let other = DecodeWorker { program: "another".into(), arguments: Vec::new() };
        assert!(!other.install(), "the first one stays");
    });
}

fn open(path: &Path) -> Result<Burst, Error> {
    with_worker();
    Burst::open(path)
}

/// What `look` finds, as soon as it does; `what` says that it never did.
fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(started.elapsed() < Duration::from_secs(120), "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Whether a child of this process is decoding; `false` where the system does not say.
fn is_decoding() -> bool {
    let tasks = fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let mut lists = tasks.filter_map(|task| fs::read_to_string(task.path().join("children")).ok());
    let of_worker = |process: &str| {
        let line = fs::read_to_string(format!("/proc/{process}/cmdline"));
        line.is_ok_and(|line| line.contains(burstscope::cli::DECODE_WORKER))
    };
    lists.any(|list| list.split_whitespace().any(of_worker))
}

#[cfg(target_os = "linux")]
fn decoder_of(file: &str) -> Option<String> {
    let is_it = |process: &fs::DirEntry| {
        let line = fs::read_to_string(process.path().join("cmdline"));
        line.is_ok_and(|line| line.contains(burstscope::cli::DECODE_WORKER) && line.contains(file))
    };
    let found = fs::read_dir("/proc").expect("a list").flatten().find(is_it)?;
    Some(found.file_name().to_string_lossy().into_owned())
}

#[test]
fn values_come_through_as_they_are_and_large_tiles_are_unpacked_in_a_process() {
    let folder = folder();
    for t in 0..5usize {
        let dng = Dng::new((24, 16), |u, v| (64 + 31 * t + 7 * u + 3 * v) as u16);
        folder.write(&format!("{t}.dng"), dng.bytes());
    }
    let burst = open(&folder).expect("five frames");
    assert_eq!((burst.len(), burst.size(), burst.binning, burst.full_scale), (5, (12, 8), 2, 1023.0));
    for (t, frame) in burst.frames.iter().enumerate() {
        for v in 0..8 {
            for u in 0..12 {
                // Mean of the square, whose centre is half a pixel to the right and down.
                let value = (31 * t + 14 * u + 6 * v) as f32 + 5.0;
                let found = frame.at(u, v) * (1023.0 - 64.0);
                assert!((found - value).abs() < 1e-2, "{t} {u} {v}: {found} instead of {value}");
            }
        }
    }
    let (_folder, path) = folder_with("large.fits");
    let sides = [("ZNAXIS1", "8192"), ("ZNAXIS2", "4096"), ("ZTILE1", "8192"), ("ZTILE2", "4096")];
    fs::write(&path, crafted::tile_fits(&sides, &[], &crafted::gzip_of_zeros(8192 * 4096))).expect("written");
    let burst = open(&path).expect("unpacked");
    assert!(burst.size() == (8192, 4096) && burst.frames[0].data().iter().all(|value| *value == 0.0));
    let packed = crafted::gzip_of_zeros(8192 * 4096 + 1);
    fs::write(&path, crafted::tile_fits(&sides, &[], &packed)).expect("written");
    says(open(&path).expect_err("too much"), &["unpacks to", "its pixels"]);
}

#[test]
fn errors_say_what_they_say_without_a_process() {
    let (folder, path) = folder_with("a.dng");
    let sound = Dng::new((24, 16), |u, v| (64 + u + v) as u16).bytes();
    fs::write(&path, &sound[..sound.len() - 9]).expect("written");
    let error = open(&path).expect_err("cut");
    assert!(error.kind == ErrorKind::Damaged && error.to_string().contains("a.dng"), "{error}");
    fs::write(&path, b"FUJIFILM and nothing more").expect("written");
    let error = open(&path.with_extension("raf")).expect_err("missing");
    assert_eq!(error.kind, ErrorKind::NotFound, "{error}");
    fs::write(&path, &sound).expect("written");
    let options = OpenOptions { black_level: Some(5000.0), ..OpenOptions::default() };
    let error =
        Burst::open_with(std::slice::from_ref(&path), &options, &Monitor::default()).expect_err("black above white");
    assert!(error.problem.contains("this raw file cannot be opened"), "{error:?}");
    let limits = Limits { max_side_px: 20, ..Limits::default() };
    let options = OpenOptions { limits, ..OpenOptions::default() };
    let error = Burst::open_with(std::slice::from_ref(&path), &options, &Monitor::default()).expect_err("too wide");
    assert!(error.kind == ErrorKind::TooLarge && error.to_string().contains("24×16"), "{error:?}");
    let second = folder.join("b.dng");
    fs::write(&second, Dng::new((24, 18), |_, _| 70).bytes()).expect("written");
    let error = open(&folder).expect_err("two sizes");
    let named = [("12×8", &path), ("12×9", &second)].map(|(size, path)| format!("{size}: {}", path.display()));
    assert!(named.iter().all(|name| error.problem.contains(name)), "{error:?}");
}

#[test]
fn a_decoder_that_takes_all_memory_or_answers_nothing_is_an_error_about_the_file() {
    let (_folder, path) = folder_with("bad.raf");
    fs::write(&path, crafted::huge_count_raf()).expect("written");
    let error = open(&path).expect_err("34 GB");
    assert_eq!(error.kind, ErrorKind::Damaged, "{error:?}");
    let words = error.to_string();
    assert!(words.contains("bad.raf") && words.contains("damaged"), "{words}");
    if cfg!(target_os = "linux") {
        assert!(words.contains("its decoder asked for 32768 MiB of memory"), "{words}");
    }
    // The decoding process alone, on a missing file: no answer at all.
    let output = Command::new(env!("CARGO_BIN_EXE_burstscope"))
        .args([burstscope::cli::DECODE_WORKER, "nowhere.dng"])
        .stdin(Stdio::null())
        .output()
        .expect("it starts");
    assert!(!output.status.success() && output.stdout.is_empty(), "{output:?}");
}

#[test]
fn cancelling_ends_the_process() {
    let folder = folder();
    // Enough pixels to keep a decoder busy.
    let path = folder.join("large.dng");
    fs::write(&path, Dng::new((6000, 4000), |u, v| (64 + (u * v) % 900) as u16).bytes()).expect("written");
    with_worker();
    let monitor = Monitor::default();
    let answer = std::thread::scope(|scope| {
        let opening = scope.spawn(|| Burst::open_with(std::slice::from_ref(&path), &OpenOptions::default(), &monitor));
        let is_told = Path::new("/proc/thread-self/children").exists();
        until("no process was started", || (!is_told || is_decoding() || opening.is_finished()).then_some(()));
        monitor.cancel();
        opening.join().expect("no panic")
    });
    assert!(answer.is_err_and(|error| error.is_cancelled()));
}

#[cfg(target_os = "linux")]
#[test]
fn a_decoder_that_somebody_ends_is_no_damage_of_the_file() {
    let (_folder, path) = folder_with("ended.dng");
    fs::write(&path, Dng::new((6000, 4000), |u, v| (64 + (u * v) % 900) as u16).bytes()).expect("written");
    with_worker();
    for (signal, number) in [("-KILL", "signal 9"), ("-TERM", "signal 15")] {
        let error = std::thread::scope(|scope| {
            let opening = scope.spawn(|| open(&path));
            let child = until("no process was started", || decoder_of(path.to_str().expect("text")));
            assert!(Command::new("kill").args([signal, &child]).status().expect("kill").success());
            opening.join().expect("no panic").expect_err("it was ended")
        });
        let words = error.to_string();
        assert_eq!(error.kind, ErrorKind::System, "{error:?}");
        assert!(words.contains(number) && words.contains("ended.dng") && !words.contains("damaged"), "{words}");
    }
}

#[test]
fn a_harmful_file_loses_neither_the_other_bursts_nor_the_program() {
    let home = folder();
    home.write("bad.dng", crafted::huge_count_dng(5));
    home.make_dir("night");
    home.write("night/bad.raf", crafted::huge_count_raf());
    let arguments = ["detect", "bad.dng", "night", "demo", "--out", "found", "--slopes-u", "-1:1:3", "--octaves", "1"];
    let words = home.run_badly(&arguments, 1);
    assert!(words.contains("bad.dng") && words.contains("bad.raf"), "{words}");
    assert!(!words.contains("panicked") && !words.contains("memory allocation of"), "{words}");
    assert_eq!(names(&home.join("found")), ["demo.csv"]);
    // Files that announce more frames than there is memory, beside a good one in a folder.
    home.make_dir("arrays");
    let at = |name: &str| home.join("arrays").join(name);
    let good: Vec<u8> = (0..2 * 96 * 72u32).map(|i| (i * i % 251) as u8).collect();
    let good = crafted::npy("2, 72, 96", &good);
    fs::write(at("good.npz"), crafted::npz(&good, good.len() as u32, None, None)).expect("written");
    let many = crafted::npy("4294967000, 1, 1", &[7; 600]);
    fs::write(at("many.npz"), crafted::npz(&many, 4_294_967_290, None, None)).expect("written");
    let arguments = ["detect", "arrays", "--out", "arrays-found", "--slopes-u", "-1:1:3", "--octaves", "1"];
    says(home.run_badly(&arguments, 1), &["many.npz", "announces"]);
    assert_eq!(names(&home.join("arrays-found")), ["good.csv"]);
    for more in [
        &["info"][..],
        &["info", "--take", "0..2"],
        &["detect", "--out", "x", "--burst-length", "5"],
        &["colmap", "--out", "y"],
    ] {
        let arguments = [&more[..1], &["arrays/many.npz"], &more[1..]].concat();
        let words = home.run_badly(&arguments, 1);
        assert!(words.contains("error: ") && !words.contains("memory allocation of"), "{arguments:?}: {words}");
    }
}

#[test]
fn damaged_jpegs_are_taken_on_demand_and_named_in_the_report() {
    let home = folder();
    home.make_dir("night");
    let frame = |t: u32| home.join(format!("night/{t}.jpg"));
    for t in 0..4 {
        let picture = image::GrayImage::from_fn(64, 48, |u, v| image::Luma([((u + t) * 37 + v * 91) as u8]));
        picture.save(frame(t)).expect("written");
    }
    let sound = fs::read(frame(2)).expect("read");
    fs::write(frame(2), &sound[..sound.len() / 2]).expect("written");
    let arguments = ["detect", "night", "--out", "found", "--slopes-u", "-1:1:3", "--octaves", "1"];
    says(home.run_badly(&arguments, 1), &["2.jpg", "truncated or damaged"]);
    let accepting = [&arguments[..], &["--accept-damaged"]].concat();
    says(home.run_well(&accepting), &["1 of 4 frames are damaged", "2.jpg"]);
    let json = home.run_json(&[&accepting[..], &["--json"]].concat());
    assert_eq!(json["bursts"][0]["damaged_frames"], serde_json::json!(["2.jpg"]));
}

/// A killed program cannot end its children: they notice the closed pipe. Until then they may do nothing but decode.
#[cfg(target_os = "linux")]
#[test]
fn a_process_that_decodes_has_few_rights_and_ends_when_the_program_is_killed() {
    let home = folder();
    // Enough pixels to keep a decoder busy.
    let large = Dng::new((6000, 4000), |u, v| (64 + (u * v) % 900) as u16).bytes();
    home.write("large.dng", large);
    let mut running = home.program("stack large.dng --slope 0,0 --out a.tiff --quiet").spawn().expect("it starts");
    let decoding = || {
        let tasks = fs::read_dir(format!("/proc/{}/task", running.id())).into_iter().flatten().flatten();
        let mut lists = tasks.filter_map(|task| fs::read_to_string(task.path().join("children")).ok());
        lists.find_map(|list| list.split_whitespace().next().map(str::to_owned))
    };
    let child = until("no process was started", decoding);
    // What it may still do is tested beside the code; the kernel says that it gave up the rest before it decodes.
    if cfg!(any(target_arch = "x86_64", target_arch = "aarch64")) {
        let status = || fs::read_to_string(format!("/proc/{child}/status")).unwrap_or_default();
        let is_confined = |status: &str| ["NoNewPrivs:\t1", "Seccomp:\t2"].iter().all(|line| status.contains(line));
        until("it keeps its rights", || {
            assert!(running.try_wait().expect("its state").is_none(), "it is done, and was not seen confined");
            is_confined(&status()).then_some(())
        });
    }
    running.kill().expect("killed");
    running.wait().expect("an end");
    let alive = || fs::read_to_string(format!("/proc/{child}/cmdline")).is_ok_and(|line| !line.is_empty());
    until("it goes on for nobody", || (!alive()).then_some(()));
}

fn samples() -> &'static [(&'static str, Vec<u8>)] {
    static SAMPLES: OnceLock<Vec<(&'static str, Vec<u8>)>> = OnceLock::new();
    SAMPLES.get_or_init(|| {
        let sound = Dng::new((12, 10), |u, v| (64 + 31 * u + 7 * v) as u16).bytes();
        vec![
            ("raw.dng", sound.clone()),
            ("raw.nef", sound),
            ("count.dng", crafted::huge_count_dng(5)),
            ("count.raf", crafted::huge_count_raf()),
        ]
    })
}

proptest! {
    // Each input starts a process; `PROPTEST_CASES` runs more cases.
    #![proptest_config(ProptestConfig { cases: if std::env::var_os("PROPTEST_CASES").is_some() { ProptestConfig::default().cases } else { 48 }, ..ProptestConfig::default() })]

    #[test]
    fn damaged_raw_files_end_nothing(
        sample in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        words in prop::collection::vec((any::<prop::sample::Index>(), prop_oneof![Just(u32::MAX), Just(0), any::<u32>()]), 0..3),
        cut in prop::option::weighted(0.3, any::<prop::sample::Index>()),
    ) {
        with_worker();
        let (name, sound) = sample.get(samples());
        let mut bytes = sound.clone();
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        for (place, value) in words {
            let place = place.index(bytes.len() - 4);
            bytes[place..place + 4].copy_from_slice(&value.to_le_bytes());
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let folder = folder();
        let path = folder.join(name);
        fs::write(&path, bytes).expect("written");
        let limits = Limits { max_side_px: 512, max_pixels: 1 << 16, max_frames: 16, max_bytes: 1 << 22 };
        match Burst::open_with(&[path], &OpenOptions { limits, ..OpenOptions::default() }, &Monitor::default()) {
            Ok(burst) => prop_assert!(burst.frames[0].data().iter().all(|v| v.is_finite())),
            Err(error) => prop_assert!(error.to_string().contains(name), "{error}"),
        }
    }
}
