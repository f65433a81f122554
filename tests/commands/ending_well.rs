//! Odd names, odd files, a closed terminal, and interruptions: nothing aborts, hangs, or loses finished work.

use crate::support::*;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::{CommandExt, ExitStatusExt};

/// Runs the program with arguments that need not be text.
fn run_os(home: &Path, arguments: &[&OsStr]) -> Output {
    home.program(&[]).args(arguments).output().expect("it starts")
}

fn os(text: &str) -> &OsStr {
    OsStr::new(text)
}

#[cfg_attr(not(target_os = "linux"), ignore = "needs /dev/full")]
#[test]
fn a_full_or_closed_standard_error_stops_nothing() {
    let home = home_with(&["nights/a", "nights/b", "nights/c"]);
    home.write("nights/b/frame_001.png", "broken");
    let arguments = [&["detect", "nights", "--out", "found"][..], &SEARCH].concat();
    let full = File::options().write(true).open("/dev/full").expect("the full device");
    let output = home.program(&arguments).stderr(full).output().expect("it starts");
    assert_eq!((output.status.code(), output.status.signal()), (Some(1), None));
    assert_eq!(names(&home.join("found")), ["a.csv", "c.csv"]);
    let line = format!("exec \"$0\" {} 2>&-", arguments.join(" ").replace("found", "closed"));
    let mut closed = shell(&home, &line);
    closed.arg(env!("CARGO_BIN_EXE_burstscope")).stdout(Stdio::null());
    assert_eq!(closed.status().expect("a shell").code(), Some(1));
    assert_eq!(names(&home.join("closed")), ["a.csv", "c.csv"]);
    for (wrong, code) in [
        (&["detect", "nights", "--out", "x", "--levels", "0"][..], 2),
        (&["stack", "gone", "--slope", "0,0", "--out", "x.tiff"], 1),
    ] {
        let full = File::options().write(true).open("/dev/full").expect("the full device");
        assert_eq!(home.program(wrong).stderr(full).status().expect("it starts").code(), Some(code), "{wrong:?}");
    }
}

#[cfg_attr(not(target_os = "linux"), ignore = "needs a file system that takes names which are not text")]
#[test]
fn names_that_are_no_text_work_everywhere() {
    let home = folder();
    let odd = |text: &[u8]| OsString::from_vec(text.to_vec());
    let folder = odd(b"n\xffight");
    [&b"n\xffight/a\xfe"[..], b"n\xffight/b"].into_iter().for_each(|name| chart(&home, odd(name)));
    let (one, tiff, png, out) = (odd(b"n\xffight/a\xfe"), odd(b"m\xff.tiff"), odd(b"w\xff.png"), odd(b"o\xffut"));
    let small = ["--size", "640x480", "--no-detect"].map(os);
    let search = SEARCH.map(os);
    let runs: [Vec<&OsStr>; 8] = [
        vec![os("stack"), &one, os("--slope"), os("0,0"), os("--out"), &tiff],
        vec![os("merge"), &one, os("--out"), &tiff, os("--json")],
        vec![os("synth"), os("noisy"), &one, os("--out"), OsStr::from_bytes(b"noisy\xff"), os("--json")],
        [&[os("render"), &one, os("--out"), &png][..], &small].concat(),
        [&[os("detect"), &folder, os("--out"), &out, os("--json")][..], &search].concat(),
        [&[os("probe"), &one, os("--at"), os("40,40"), os("--json")][..], &search].concat(),
        [&[os("match"), &one, OsStr::from_bytes(b"n\xffight/b"), os("--out"), &out, os("--json")][..], &search]
            .concat(),
        [&[os("colmap"), &folder, os("--out"), OsStr::from_bytes(b"rec\xff"), os("--json")][..], &search].concat(),
    ];
    for arguments in runs {
        let output = run_os(&home, &arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        if arguments.contains(&os("--json")) {
            let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            assert!(json.to_string().contains("\\\\xFF"), "{arguments:?}: {json}");
        }
    }
    [&tiff, &png].into_iter().for_each(|made| assert!(home.join(made).is_file(), "{made:?}"));
    let rec = home.join(OsStr::from_bytes(b"rec\xff"));
    assert!(rec.join("database.db").is_file() && names(&rec.join("features")).len() == 2);
    let output =
        run_os(&home, &[&[os("colmap"), &folder, os("--out"), OsStr::from_bytes(b"rec\xff")][..], &search].concat());
    assert!(String::from_utf8_lossy(&output.stdout).matches("from an earlier run").count() == 3, "{}", stderr(&output));
}

#[test]
fn one_stray_or_unreadable_entry_does_not_stop_the_others() {
    let home = home_with(&["nights/a", "nights/b", "nights/c"]);
    let nights = home.join("nights");
    fs::copy(nights.join("a/frame_000.png"), nights.join("preview.png")).expect("copied");
    fs::write(nights.join("notes.txt"), "about the nights").expect("written");
    fs::create_dir(nights.join("plots")).expect("made");
    // A user who may read everything, such as root, is refused nothing: then the program runs as another user.
    let closed = nights.join("b");
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o000)).expect("closed");
    let reads_all = fs::read_dir(&closed).is_ok();
    fs::set_permissions(&home, fs::Permissions::from_mode(0o777)).expect("opened");
    for (command, made) in [("detect", "a.csv"), ("colmap", "images")] {
        let out = format!("out {command}");
        let mut running = home.program(&[&[command, "nights", "--out", &out][..], &SEARCH].concat());
        if reads_all {
            running.uid(65_534).gid(65_534);
        }
        let output = running.output().expect("it starts");
        let words = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{words}");
        says(&words, &["preview.png", "belongs to none", "nights/b", "denied"]);
        assert!(names(&home.join(&out)).contains(&made.to_owned()), "{words}");
    }
    assert_eq!(names(&home.join("out detect")), ["a.csv", "c.csv"]);
    assert_eq!(names(&home.join("out colmap/images")), ["a.png", "c.png"]);
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o755)).expect("opened");
}

#[test]
fn a_camera_of_another_size_is_refused_before_the_search() {
    let home = home_with(&["a", "b"]);
    let camera = ["--camera", "SIMPLE_PINHOLE,640,480,600,320,240"];
    for command in [&["match", "a", "b"][..], &["colmap", "a", "b"]] {
        says(home.run_badly(&[command, &["--out", "out"], &camera, &SEARCH].concat(), 1), &["640×480", "96×72"]);
        assert!(!home.join("out/a.csv").exists());
    }
}

#[test]
fn render_checks_its_picture_files_of_settings_are_read_up_to_a_sane_size_and_opengl_draws() {
    let home = home_with(&["a"]);
    for (wrong, word) in [
        (["--kind", "frame", "--frame", "4"], "give 0 to 3"),
        (["--kind", "dog", "--octave", "9"], "no octave 9"),
        (["--kind", "dog", "--level", "77"], "no DoG level 77"),
        (["--kind", "stack", "--slope", "500,0"], "out of the 96×72 image"),
    ] {
        says(home.run_badly(&[&["render", "a", "--no-detect", "--out", "x.png"][..], &wrong].concat(), 2), &[word]);
        assert!(!home.join("x.png").exists());
    }
    let file = home.join("p.toml");
    let detect = || home.run_badly("detect a --out found --params p.toml", 2);
    fs::write(&file, "[slopes]\ndirection = 90\n").expect("written");
    says(detect(), &["p.toml", "`direction`", "direction_deg"]);
    fs::write(&file, "# Written by Burstscope 99.0.0\nwavelets = true\n").expect("written");
    says(detect(), &["written by Burstscope 99.0.0", "wavelets"]);
    File::create(home.join("large.toml")).and_then(|file| file.set_len(3 << 20)).expect("a hole is large");
    std::os::unix::fs::symlink("/dev/zero", home.join("device.toml")).expect("linked");
    assert!(Command::new("mkfifo").arg(home.join("pipe.toml")).status().expect("mkfifo runs").success());
    let refused = |line: &[&str], code: i32| {
        let output = ended(home.start(line));
        assert_eq!(output.status.code(), Some(code), "{line:?}: {}", stderr(&output));
        stderr(&output)
    };
    for (file, word) in [
        ("large.toml", "larger than 1 MiB"),
        ("device.toml", "not a regular file"),
        ("pipe.toml", "not a regular file"),
    ] {
        says(refused(&["detect", "a", "--out", "out", "--params", file], 1), &[file, word]);
        says(refused(&["match", "a", "a", "--out", "out", "--camera", file], 2), &[file, word]);
        // The window refuses them as sessions, too.
        says(refused(&["evaluate", "poses", "--estimate", file, "--truth", file], 1), &[file]);
    }
    let file: PathBuf = home.join("x.png");
    let mut drawing = home.program("render a --no-detect --size 640x480 --out x.png");
    let output = drawing.env("WGPU_BACKEND", "gl").output().expect("it starts");
    match output.status.code() {
        Some(0) => {
            let drawn = image::open(&file).expect("a picture").into_rgb8();
            let colours: std::collections::HashSet<[u8; 3]> = drawn.pixels().map(|p| p.0).collect();
            assert!(colours.len() > 50, "an empty picture is no drawing: {} colours", colours.len());
        }
        Some(1) => assert!(stderr(&output).contains("graphics") && !file.exists(), "{}", stderr(&output)),
        other => panic!("{other:?}: {}", stderr(&output)),
    }
}

#[test]
fn names_of_255_bytes_work_and_commands_to_the_terminal_in_names_do_not_reach_it() {
    let home = folder();
    let [long, other] = ["n", "m"].map(|letter| format!("nights/{}", letter.repeat(255)));
    chart(&home, &long);
    chart(&home, &other);
    home.run_well(&[&["detect", "nights", "--out", "found", "--format", "csv,colmap,npz"][..], &SEARCH].concat());
    assert_eq!(names(&home.join("found")).len(), 6);
    home.run_well(&[&["match", &long, &other, "--out", "matched"][..], &SEARCH].concat());
    assert_eq!(names(&home.join("matched")).len(), 4);
    home.run_well(&[&["colmap", "nights", "--out", "rec"][..], &SEARCH].concat());
    assert_eq!(names(&home.join("rec/images")).len(), 2);
    let tiff = format!("{}.tiff", "t".repeat(250));
    home.run_well(&["stack", &long, "--slope", "0,0", "--out", &tiff]);
    assert!(home.join(tiff).is_file());
    let name = "a\u{1b}]0;owned\u{7}\u{9b}2J";
    chart(&home, name);
    let harmless = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        assert!(!text.contains(|c: char| c.is_control() && c != '\n' && c != '\t'), "{text:?}");
        assert!(text.contains("owned"), "{text}");
    };
    let output = home.run(&[&["detect", name, "--out", "out"][..], &SEARCH].concat());
    assert_eq!(output.status.code(), Some(0));
    harmless(&output.stdout);
    let json = home.run(&[&["detect", name, "--out", "out", "--json"][..], &SEARCH].concat()).stdout;
    harmless(&json);
    assert!(String::from_utf8_lossy(&json).contains("\\u009b"));
    fs::write(home.join(name).join("frame_001.png"), "broken").expect("written");
    harmless(&home.run(&[&["detect", name, "--out", "out"][..], &SEARCH].concat()).stderr);
    harmless(&home.run(&["stack", name, "--slope", "0,0", "--out", "x.tiff"]).stderr);
}

#[test]
fn what_killed_runs_left_is_cleared_by_the_next() {
    let home = folder();
    let hidden =
        |prefix: &str| -> Vec<String> { names(&home).into_iter().filter(|name| name.starts_with(prefix)).collect() };
    let large = ["--width", "2000", "--height", "1500", "--frames", "20", "--threads", "1"];
    let mut making = home.program(&[&["synth", "chart", "--out", "big"][..], &large].concat());
    let mut making = making.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
    // A folder without its mark may be anyone's, and stays.
    let is_ours = |name: &String| fs::metadata(home.join(name).join("in-use")).is_ok_and(|file| file.len() > 0);
    while !hidden(".burstscope-").iter().any(is_ours) && making.try_wait().expect("a state").is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    making.kill().expect("it is ours");
    making.wait().expect("it ends");
    assert_eq!(hidden(".burstscope-").len(), 2, "it was killed while it wrote: the hidden folder, and its lock");
    leave_unfinished(&home);
    home.write(".burstscope-notes.tmp", "mine");
    home.write(".burstscope-notes.lock", "mine");
    home.make_dir(".burstscope-mine.tmp");
    home.write(".burstscope-mine.tmp/in-use", "mine");
    chart(&home, "a");
    home.run_well("stack a --slope 0,0 --out a.tiff");
    let kept = [".burstscope-mine.tmp", ".burstscope-notes.lock", ".burstscope-notes.tmp", "a", "a.tiff"];
    assert_eq!(names(&home), kept);
    assert_eq!(home.text(".burstscope-mine.tmp/in-use"), "mine");
    home.make_dir("own");
    fs::rename(home.join(".burstscope-notes.tmp"), home.join("own/.burstscope-x.tmp")).expect("moved");
    assert!(home.run_badly("synth chart --out own", 1).contains("did not write there"));
    says(home.run_badly("synth chart --out notes", 1), &[".burstscope-notes.lock", "move it away"]);
    assert_eq!(home.text(".burstscope-notes.lock"), "mine");
}

#[test]
fn an_interrupted_render_ends_cleanly() {
    let home = folder();
    // A search that takes long, compared with the waits in this test.
    chart(&home, "a");
    let arguments = "render a --out x.png --slopes-u -3:3:61 --slopes-v -3:3:61 --first-octave -1";
    let drawing = home.start(arguments);
    at_work(&drawing);
    let killed = Command::new("kill").args(["-INT", &drawing.id().to_string()]).status().expect("kill runs");
    assert!(killed.success());
    let output = ended(drawing);
    assert_eq!((output.status.code(), output.status.signal()), (Some(130), None), "{}", stderr(&output));
    // Libraries of the desktop may print something before.
    assert!(stderr(&output).trim().ends_with("interrupted"), "{}", stderr(&output));
    assert!(!stderr(&output).contains("panicked"), "{}", stderr(&output));
    assert_eq!(names(&home), ["a"]);
}

#[test]
fn a_search_beyond_the_memory_is_done_in_groups_of_slopes_or_refused_with_the_number() {
    let home = home_with(&["a"]);
    let search = ["detect", "a", "--out", "found", "--slopes-u", "-2:2:64", "--slopes-v", "-2:2:64"];
    let all = ["--slope-extrema", "joint", "--rules", "buff", "--memory"];
    let words = home.run_badly(&[&search[..], &all, &["30M"]].concat(), 1);
    says(words, &["--memory: this search of 4096 slopes", "30 MB may be used", "other rules than buff"]);
    assert!(!home.join("found").exists());
    let few = "detect a --out few --slopes-u -1:1:3 --memory 50%";
    home.run_well(few);
    says(home.run_badly(&[&search[..], &["--memory", "lots"]].concat(), 2), &["8G or 500M"]);
    // All of these slopes take about 2 MB, and one thread's window 6 MB.
    let some = "detect a --threads 1 --slopes-u -2:2:16 --slopes-v -2:2:16 --out";
    home.run_well(&format!("{some} whole"));
    home.run_well(&format!("{some} grouped --memory 8M"));
    let features = |folder: &str| fs::read_to_string(home.join(folder).join("a.csv")).expect("features");
    assert!(features("whole").lines().count() > 1);
    assert_eq!(features("whole"), features("grouped"));
}

#[test]
fn a_limit_on_the_size_of_files_is_an_error_that_names_the_file() {
    let home = home_with(&["nights/a", "nights/b"]);
    let limited = |blocks: u32, arguments: &str| {
        let script = format!("ulimit -f {blocks}; exec '{}' {arguments}", env!("CARGO_BIN_EXE_burstscope"));
        let output = shell(&home, &script).output().expect("it runs");
        assert_eq!((output.status.code(), output.status.signal()), (Some(1), None), "{arguments}: {}", stderr(&output));
        stderr(&output)
    };
    let search = "--slopes-u -1:1:3 --octaves 2";
    for (arguments, named) in [
        ("stack nights/a --slope 0,0 --out x.tiff".to_owned(), "x.tiff"),
        ("merge nights/a --out x.tiff".to_owned(), "x.tiff"),
        ("render nights/a --no-detect --size 640x480 --out x.png".to_owned(), "x.png"),
        (format!("probe nights/a --at 40,40 --plot x.svg {search}"), "x.svg"),
        (format!("detect nights --out out --format colmap {search}"), "out/a.txt"),
        (format!("match nights/a nights/b --out out --format npz {search}"), "out/a.npz"),
        ("synth chart --out x".to_owned(), "frame_000.png"),
        (format!("colmap nights --out rec {search}"), "manifest.json"),
    ] {
        says(limited(1, &arguments), &[named, "ulimit -f"]);
        assert_eq!(names(&home), ["nights"], "{arguments}");
    }
    // Not even the text of the lock fits.
    assert!(limited(0, "synth chart --out x").contains(".burstscope-x.lock"));
    assert_eq!(names(&home), ["nights"]);
    // Pictures and features fit, but the database does not.
    assert!(limited(64, &format!("colmap nights --out rec {search}")).contains("database.db"));
    let rec = names(&home.join("rec"));
    assert_eq!(rec, ["features", "images", "manifest.json", "records"], "the database is whole or not there");
}

/// In a program with little address space, a refused allocation is reported with its size, and nothing is aborted.
#[cfg_attr(not(target_os = "linux"), ignore = "needs `ulimit -v`, which other systems do not keep")]
#[test]
fn memory_that_is_refused_is_said() {
    use std::io::Write;
    let home = folder();
    // A stack of two frames of 1 GiB each, as a sparse file.
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 16384, 16384), }";
    let header = format!("{header:117}\n");
    let mut file = fs::File::create(home.join("large.npy")).expect("made");
    file.write_all(b"\x93NUMPY\x01\x00").expect("written");
    file.write_all(&(header.len() as u16).to_le_bytes()).expect("written");
    file.write_all(header.as_bytes()).expect("written");
    file.set_len(10 + header.len() as u64 + (2 << 30)).expect("sparse");
    let program = env!("CARGO_BIN_EXE_burstscope");
    let (beyond, refused) = ("MiB, and the limit is 976 MiB", "there is no memory for");
    for (arguments, words_of, named) in [
        ("detect large.npy --out found", beyond, "large.npy"),
        ("stack large.npy --slope 0,0 --out a.tiff", beyond, "large.npy"),
        ("synth chart --width 16384 --height 16384 --frames 2 --max-slope 1 --out chart", refused, "1024 MiB"),
        ("synth scene --width 16384 --height 16384 --frames 2 --max-slope 1 --out scene", refused, "MiB"),
    ] {
        let script = format!("ulimit -v 1000000; exec '{program}' {arguments}");
        let output = shell(&home, &script).env("RAYON_NUM_THREADS", "2").output().expect("it runs");
        let words = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{arguments}: {words}");
        assert!(words.contains(words_of) && words.contains(named), "{arguments}: {words}");
    }
    assert_eq!(names(&home), ["large.npy"]);
}
