//! A run that is killed at any moment goes on where it was, and never takes features of other parameters for its own.

use super::support::{names, program, run, run_badly, run_well, stderr};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, SystemTime};

/// Twenty small bursts, one film.
fn film(home: &Path) {
    let size = ["--width", "96", "--height", "72", "--frames", "60", "--max-slope", "1", "--snr", "10"];
    run_well(home, &[&["synth", "scene", "--out", "film"][..], &size].concat());
}

fn arguments<'a>(out: &'a str, edge_threshold: &'a str) -> Vec<&'a str> {
    let search = ["--slopes-u", "-1:1:3", "--octaves", "2", "--edge-threshold", edge_threshold];
    [&["colmap", "film", "--burst-length", "3", "--pairs", "sequential:1", "--out", out][..], &search].concat()
}

/// Pictures and features by their names, and the rows of the database.
fn made(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut made = BTreeMap::new();
    for part in ["images", "features"] {
        for name in names(&folder.join(part)) {
            made.insert(format!("{part}/{name}"), fs::read(folder.join(part).join(&name)).expect("a file"));
        }
    }
    let database = rusqlite::Connection::open(folder.join("database.db")).expect("a database");
    for (table, columns) in [
        ("cameras", "camera_id, model, width, height, params"),
        ("images", "image_id, name, camera_id"),
        ("keypoints", "image_id, rows, cols, data"),
        ("descriptors", "image_id, rows, cols, data"),
        ("matches", "pair_id, rows, cols, data"),
        ("two_view_geometries", "pair_id, rows, cols, data, config"),
    ] {
        let text = format!("SELECT {columns} FROM {table} ORDER BY 1");
        let mut statement = database.prepare(&text).expect("COLMAP's tables");
        let count = statement.column_count();
        let row = |row: &rusqlite::Row<'_>| {
            Ok((0..count).map(|i| format!("{:?}", row.get_ref(i).expect("a column"))).collect::<String>())
        };
        let rows: Vec<String> = statement.query_map([], row).expect("rows").map(|row| row.expect("a row")).collect();
        made.insert(table.to_owned(), rows.join("\n").into_bytes());
    }
    made
}

fn same(folder: &Path, expected: &BTreeMap<String, Vec<u8>>, what: &str) {
    let made = made(folder);
    assert!(made.keys().eq(expected.keys()), "{what}: {:?}", made.keys().collect::<Vec<_>>());
    for (name, content) in &made {
        assert!(*content == expected[name], "{what}: {name} differs");
    }
}

/// The files in `folder` and its parts, with the times at which they were written last.
fn written(folder: &Path) -> BTreeSet<(String, SystemTime)> {
    let mut written = BTreeSet::new();
    for part in ["", "images", "features", "records"] {
        // A file may go away between the two looks at it.
        for entry in fs::read_dir(folder.join(part)).into_iter().flatten().flatten() {
            if let Some(at) = entry.metadata().ok().filter(|data| data.is_file()).and_then(|data| data.modified().ok())
            {
                written.insert((format!("{part}/{}", entry.file_name().to_string_lossy()), at));
            }
        }
    }
    written
}

/// Starts a run into `out`, and kills it once it has written `count` files, and `later` after that. Returns whether it
/// was killed before it ended.
fn kill_after(home: &Path, line: &[&str], out: &Path, count: usize, later: Duration) -> bool {
    let before = written(out);
    let mut running = program(home, line);
    let mut running = running.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
    while written(out).difference(&before).count() < count && running.try_wait().expect("a state").is_none() {
        std::thread::sleep(Duration::from_micros(500));
    }
    std::thread::sleep(later);
    let ended = running.try_wait().expect("a state").is_some();
    running.kill().expect("it is ours");
    running.wait().expect("it ends");
    !ended
}

#[test]
fn killed_at_any_moment_it_goes_on_to_the_same_end() {
    let home = tempfile::tempdir().expect("a folder");
    film(home.path());
    run_well(home.path(), &arguments("whole", "12"));
    let whole = home.path().join("whole");
    let expected = made(&whole);
    assert!(expected["keypoints"].len() > 1000 && expected.len() == 46, "twenty bursts with features");
    let files = written(&whole).len();
    // From before the first file to the last ones, which are written when all bursts are done.
    let mut killed = 0;
    for round in 0..4 {
        let out = format!("killed {round}");
        let folder = home.path().join(&out);
        for kill in 0..3 {
            // Every other run looks for other features.
            let line = arguments(&out, if kill % 2 == 0 { "12" } else { "3" });
            let moment = 3 * round + kill;
            let later = Duration::from_millis(moment as u64 % 4);
            killed += usize::from(kill_after(home.path(), &line, &folder, moment * files / 11, later));
        }
        let output = run(home.path(), &arguments(&out, "12"));
        assert_eq!(output.status.code(), Some(0), "round {round}: {}", stderr(&output));
        same(&folder, &expected, &format!("round {round}"));
        for part in ["", "images", "features", "records"] {
            let left: Vec<_> = names(&folder.join(part)).into_iter().filter(|name| name.ends_with(".tmp")).collect();
            assert!(left.is_empty(), "round {round}: {part} holds {left:?}");
        }
    }
    assert!(killed >= 8, "{killed} of 12 runs were killed before they ended");
}

#[test]
fn what_was_altered_is_made_again_and_what_is_whole_is_kept() {
    let home = tempfile::tempdir().expect("a folder");
    film(home.path());
    run_well(home.path(), &arguments("rec", "12"));
    let folder = home.path().join("rec");
    let expected = made(&folder);
    let first = folder.join("features").join(&names(&folder.join("features"))[0]);
    // As many features and as long a file, but other numbers.
    let text = fs::read_to_string(&first).expect("text");
    let digit = text.char_indices().filter(|(_, c)| c.is_ascii_digit()).nth(40).expect("numbers").0;
    let other = if text[digit..].starts_with('7') { "8" } else { "7" };
    fs::write(&first, format!("{}{other}{}", &text[..digit], &text[digit + 1..])).expect("written");
    let resumed = |home: &Path| {
        let json = run_well(home, &[&arguments("rec", "12")[..], &["--json"]].concat());
        let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        json["images"].as_array().expect("images").iter().filter(|image| image["resumed"] == true).count()
    };
    assert_eq!(resumed(home.path()), 19);
    same(&folder, &expected, "altered");
    assert_eq!(resumed(home.path()), 20);
    // A folder in the way of a record: the burst is said to fail, and its features are not taken for finished.
    let record = folder.join("records").join(&names(&folder.join("records"))[0]);
    fs::remove_file(&record).expect("removed");
    fs::create_dir(&record).expect("made");
    let words = run_badly(home.path(), &arguments("rec", "3"), 1);
    assert!(words.contains("records"), "{words}");
    fs::remove_dir(&record).expect("removed");
    run_well(home.path(), &arguments("rec", "12"));
    same(&folder, &expected, "in the way");
}

#[test]
fn two_processes_do_not_write_into_one_folder() {
    let home = tempfile::tempdir().expect("a folder");
    film(home.path());
    fs::create_dir(home.path().join("rec")).expect("made");
    let lock = home.path().join("rec/.burstscope-lock");
    fs::write(&lock, "process 4711 on lighthouse\n").expect("written");
    let file = fs::OpenOptions::new().read(true).write(true).open(&lock).expect("opened");
    file.try_lock().expect("free");
    let words = run_badly(home.path(), &arguments("rec", "12"), 1);
    assert!(words.contains("process 4711 on lighthouse writes into this folder"), "{words}");
    drop(file);
    std::thread::sleep(Duration::from_millis(1));
    run_well(home.path(), &arguments("rec", "12"));
}

#[test]
fn what_several_runs_have_found_is_gathered() {
    let home = tempfile::tempdir().expect("a folder");
    for name in ["a", "b", "c", "d"] {
        let size =
            ["--width", "96", "--height", "72", "--frames", "4", "--discs", "4", "--radius", "3:6", "--seed", name];
        let size = size.map(|word| if word == name { if name == "a" { "1" } else { "2" } } else { word });
        run_well(home.path(), &[&["synth", "chart", "--out", &format!("nights/{name}")][..], &size].concat());
    }
    let search = ["--slopes-u", "-1:1:3", "--octaves", "2"];
    let colmap = |inputs: &[&str], more: &[&str]| run_well(home.path(), &[&["colmap"], inputs, &search, more].concat());
    colmap(&["nights"], &["--out", "whole"]);
    // Two machines, two bursts each; the second one lost a file.
    colmap(&["nights/a", "nights/b"], &["--out", "one"]);
    colmap(&["nights/c", "nights/d"], &["--out", "two"]);
    fs::write(home.path().join("two/features/d.png.txt"), "0 128\n").expect("altered");
    let text = colmap(&["nights"], &["--out", "all", "--gather", "one", "--gather", "two"]);
    assert!(text.contains("gathered the features of 3 of 4 bursts"), "{text}");
    assert_eq!(text.matches("from an earlier run").count(), 3, "{text}");
    same(&home.path().join("all"), &made(&home.path().join("whole")), "gathered");
    // Features of other parameters are not taken.
    let text = colmap(&["nights"], &["--out", "other", "--gather", "one", "--edge-threshold", "5"]);
    assert!(text.contains("gathered the features of 0 of 4 bursts"), "{text}");
    let words = run_badly(home.path(), &["colmap", "nights", "--out", "none", "--gather", "gone"], 1);
    assert!(words.contains("gone"), "{words}");
}
