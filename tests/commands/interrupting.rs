//! Ctrl-C and the signals that schedulers and closed terminals send: exit code 130, and nothing half-written.
#![cfg(unix)]

use crate::support::*;

/// Signals that ask a program to end. Where the tests themselves were started with SIGHUP ignored, the program ignores
/// it too; a line says so.
fn signals() -> Vec<&'static str> {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    if ignored.is_some_and(|mask| mask & 1 == 0) {
        vec!["-INT", "-TERM", "-HUP"]
    } else {
        println!("SIGHUP is not heard here and was left out");
        vec!["-INT", "-TERM"]
    }
}

fn send(signal: &str, process: u32) {
    let sent = Command::new("kill").args([signal, &process.to_string()]).status().expect("kill runs");
    assert!(sent.success());
}

/// Starts a command whose work takes many minutes, sends `signal` while it works, and returns its exit code.
fn interrupt(home: &Path, arguments: &[&str], signal: &str) -> Option<i32> {
    let mut child = home.start(arguments);
    at_work(&child);
    assert!(child.try_wait().expect("a state").is_none(), "{arguments:?} ended before it could be interrupted");
    send(signal, child.id());
    ended(child).status.code()
}

#[test]
fn long_work_stops_and_leaves_nothing_and_a_second_request_ends_it_at_once() {
    for (line, there) in [
        ("synth chart --out big --width 3000 --height 2000 --frames 350 --threads 1", &[][..]),
        ("detect chart --slopes-u -3:3:61 --slopes-v -3:3:61 --first-octave -1 --threads 1 --out found", &["chart"]),
        ("evaluate chart --motion 2d --seeds 500 --threads 1 --plot roc.svg --json", &[]),
    ] {
        let home = folder();
        for name in there {
            home.run_well(&["synth", "chart", "--out", name, "--frames", "8", "--quiet"]);
        }
        for signal in signals() {
            assert_eq!(interrupt(&home, &line.words(), signal), Some(130), "{line}: {signal}");
            assert_eq!(names(&home), there, "{line}");
        }
    }
    let home = folder();
    let child = home.start("evaluate chart --motion 2d --seeds 500 --threads 1");
    at_work(&child);
    send("-TERM", child.id());
    send("-INT", child.id());
    assert_eq!(ended(child).status.code(), Some(130));
}

#[test]
fn figures_stop_and_leave_none_half_made_and_a_burst_in_a_dataset_stops_and_the_folder_goes_on_later() {
    let home = folder();
    let arguments = ["figures", "--out", "paper", "--only", "fig5", "--no-colmap", "--threads", "1"];
    for signal in signals() {
        assert_eq!(interrupt(&home, &arguments, signal), Some(130), "{signal}");
        let left = names(&home.join("paper"));
        assert!(left.iter().all(|name| name == "records" || name.starts_with('.')), "{left:?}");
    }
    let home = folder();
    for name in ["a", "b"] {
        home.run_well(&["synth", "chart", "--out", &format!("nights/{name}"), "--frames", "4", "--quiet"]);
    }
    let slopes = ["--slopes-u", "-3:3:41", "--slopes-v", "-3:3:41"];
    let arguments = [&["colmap", "nights", "--out", "rec", "--threads", "1"][..], &slopes].concat();
    for signal in signals() {
        assert_eq!(interrupt(&home, &arguments, signal), Some(130), "{signal}");
        let left = home.join("rec");
        assert!(!left.exists() || !names(&left).contains(&"database.db".to_owned()), "{signal}");
    }
    home.run_well("colmap nights --out rec --slopes-u -1:1:3 --octaves 2");
}

#[test]
fn a_film_or_a_case_that_is_written_stops_and_leaves_nothing() {
    let home = folder();
    let size = ["--width", "480", "--height", "360", "--frames", "60", "--max-slope", "1"];
    home.run_well(&[&["synth", "chart", "--out", "a", "--quiet"][..], &size].concat());
    let film = ["film", "a", "--sweep", "frames", "--no-features", "--out", "x.gif"];
    let pictures = ["film", "a", "--sweep", "frames", "--no-features", "--out", "x.png"];
    let case = ["case", "a", "--out", "x.burstcase"];
    for command in [&film[..], &pictures, &case] {
        let mut child = home.start(command);
        while !names(&home).iter().any(|name| name.ends_with(".tmp")) {
            assert!(child.try_wait().expect("a state").is_none(), "{command:?} ended before it wrote");
            std::thread::sleep(Duration::from_millis(1));
        }
        send("-TERM", child.id());
        let output = ended(child);
        assert_eq!(output.status.code(), Some(130), "{command:?}: {}", stderr(&output));
        assert_eq!(names(&home), ["a"], "{command:?}");
    }
}

/// A run started by `nohup` outlives its terminal.
#[cfg(target_os = "linux")]
#[test]
fn where_a_closed_terminal_is_to_be_ignored_it_is() {
    let home = folder();
    home.run_well("synth chart --out a --frames 8 --quiet");
    let program = env!("CARGO_BIN_EXE_burstscope");
    let script =
        format!("trap '' HUP; exec '{program}' detect a --slopes-u -3:3:21 --slopes-v -3:3:9 --threads 1 --out out");
    let mut child = shell(&home, &script);
    let mut child = child.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    for _ in 0..3 {
        std::thread::sleep(Duration::from_millis(200));
        send("-HUP", child.id());
    }
    assert_eq!(child.wait().expect("an end").code(), Some(0));
    assert_eq!(names(&home.join("out")), ["a.csv"]);
}

/// A program in the place of `ffmpeg` that waits, with a process of its own: both end with the work.
#[test]
fn work_on_a_film_stops_also_where_ffmpeg_hangs() {
    use std::os::unix::fs::PermissionsExt;
    let home = folder();
    home.make_dir("bin");
    home.write("bin/ffmpeg", "#!/bin/sh\n: > started\nsleep 600\necho late\n");
    fs::set_permissions(home.join("bin/ffmpeg"), fs::Permissions::from_mode(0o755)).expect("a program");
    home.write("a.mp4", b"\0\0\0\x18ftypisom\0\0\x02\0isomiso2");
    let path = format!("{}:{}", home.join("bin").display(), std::env::var("PATH").expect("a path"));
    for arguments in [
        &["film", "demo", "--sweep", "frames", "--no-features", "--out", "x.mp4"][..],
        &["info", "a.mp4"],
        &["detect", "a.mp4", "--out", "found"],
        &["stack", "a.mp4", "--slope", "0,0", "--out", "a.tiff"],
    ] {
        for signal in ["-INT", "-TERM"] {
            let mut command = home.program(arguments);
            let child =
                command.env("PATH", &path).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
            let begun = Instant::now();
            while !home.join("started").exists() {
                assert!(begun.elapsed() < Duration::from_secs(120), "{arguments:?} starts no ffmpeg");
                std::thread::sleep(Duration::from_millis(2));
            }
            send(signal, child.id());
            assert_eq!(ended(child).status.code(), Some(130), "{arguments:?} {signal}");
            fs::remove_file(home.join("started")).expect("removed");
            let left = names(&home);
            assert!(left.iter().all(|name| ["a.mp4", "bin", "found"].contains(&name.as_str())), "{left:?}");
        }
    }
}

/// Programs in the place of `ffmpeg`, and none.
#[test]
fn an_mp4_without_ffmpeg_or_with_one_that_fails_is_an_error_with_its_words() {
    use std::os::unix::fs::PermissionsExt;
    let (home, bin) = folder_with("bin");
    fs::create_dir(&bin).expect("made");
    let film = "film demo --sweep frames --no-features --out x.mp4";
    let fails = || {
        let output = home.program(film).env("PATH", &bin).output().expect("it starts");
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert_eq!(names(&home), ["bin"]);
        stderr(&output)
    };
    let words = fails();
    assert!(words.contains("MP4 needs ffmpeg") && words.contains("or .png") && words.contains("x.mp4"), "{words}");
    assert!(!words.contains("pictures of"), "before any picture is made: {words}");
    // The pictures meet a closed pipe.
    let script = "#!/bin/sh\nexec 0<&-\necho 'a first line' >&2\necho 'no room for it' >&2\nexit 1\n";
    fs::write(bin.join("ffmpeg"), script).expect("written");
    fs::set_permissions(bin.join("ffmpeg"), fs::Permissions::from_mode(0o755)).expect("a program");
    says(fails(), &["says: no room for it", "x.mp4"]);
}
