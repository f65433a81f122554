//! A run that is killed at any moment continues where it was, and never takes features of other parameters or frames
//! for its own.

use crate::support::*;
use std::time::SystemTime;

/// A folder with one film of twenty small bursts.
fn film() -> Folder {
    let home = folder();
    home.run_well("synth scene --out film --width 96 --height 72 --frames 60 --max-slope 1 --snr 10");
    home
}

fn arguments<'a>(out: &'a str, edge_threshold: &'a str) -> Vec<&'a str> {
    let search = ["--slopes-u", "-1:1:3", "--octaves", "2", "--edge-threshold", edge_threshold];
    [&["colmap", "film", "--burst-length", "3", "--pairs", "sequential:1", "--out", out][..], &search].concat()
}

/// Pictures and features by name, and the rows of the database.
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
    made.iter().for_each(|(name, content)| assert!(*content == expected[name], "{what}: {name} differs"));
}

fn parts(folder: &Path) -> Vec<String> {
    let pairs = fs::read_dir(folder.join("records/pairs")).into_iter().flatten().flatten();
    let of_pairs = pairs.map(|entry| format!("records/pairs/{}", entry.file_name().to_string_lossy()));
    ["", "images", "features", "records", "records/pairs"].map(str::to_owned).into_iter().chain(of_pairs).collect()
}

/// Files in `folder` and its parts, with the times of their last writing.
fn written(folder: &Path) -> BTreeSet<(String, SystemTime)> {
    let mut written = BTreeSet::new();
    for part in parts(folder) {
        // A file may disappear between listing and reading it.
        for entry in fs::read_dir(folder.join(&part)).into_iter().flatten().flatten() {
            let at = entry.metadata().ok().filter(|data| data.is_file()).and_then(|data| data.modified().ok());
            written.extend(at.map(|at| (format!("{part}/{}", entry.file_name().to_string_lossy()), at)));
        }
    }
    written
}

/// Starts a run into `out`, and kills it `later` after it has written `count` files. Returns whether it was killed
/// before it ended.
fn kill_after(home: &Path, line: &[&str], out: &Path, count: usize, later: Duration, is_asked: bool) -> bool {
    let before = written(out);
    let mut running = home.program(line);
    let mut running = running.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
    while written(out).difference(&before).count() < count && running.try_wait().expect("a state").is_none() {
        std::thread::sleep(Duration::from_micros(500));
    }
    std::thread::sleep(later);
    let ended = running.try_wait().expect("a state").is_some();
    if is_asked && !ended {
        let sent = Command::new("kill").args(["-TERM", &running.id().to_string()]).status();
        assert!(sent.expect("kill runs").success());
    } else {
        running.kill().expect("it is ours");
    }
    running.wait().expect("it ends");
    !ended
}

#[test]
fn killed_at_any_moment_it_goes_on_to_the_same_end() {
    let home = film();
    home.run_well(&arguments("whole", "12"));
    let whole = home.join("whole");
    let expected = made(&whole);
    assert!(expected["keypoints"].len() > 1000 && expected.len() == 46, "twenty bursts with features");
    let files = written(&whole).len();
    assert!(files > 80 && parts(&whole).len() == 24, "nineteen pairs, and their first bursts");
    // From before the first file to the last ones, which are written when all bursts are finished.
    let mut killed = 0;
    for round in 0..4 {
        let out = format!("killed {round}");
        let folder = home.join(&out);
        for kill in 0..3 {
            // Every other run searches other features.
            let line = arguments(&out, if kill % 2 == 0 { "12" } else { "3" });
            let moment = 3 * round + kill;
            let later = Duration::from_millis(moment as u64 % 4);
            let is_asked = cfg!(unix) && kill % 2 == 1;
            killed += usize::from(kill_after(&home, &line, &folder, moment * files / 11, later, is_asked));
        }
        let output = home.run(&arguments(&out, "12"));
        assert_eq!(output.status.code(), Some(0), "round {round}: {}", stderr(&output));
        same(&folder, &expected, &format!("round {round}"));
        for part in parts(&folder) {
            let left: Vec<_> = names(&folder.join(&part)).into_iter().filter(|name| name.ends_with(".tmp")).collect();
            assert!(left.is_empty(), "round {round}: {part} holds {left:?}");
        }
    }
    assert!(killed >= 8, "{killed} of 12 runs were killed before they ended");
}

#[test]
fn what_was_altered_is_made_again_and_what_is_whole_is_kept() {
    let home = film();
    home.run_well(&arguments("rec", "12"));
    let folder = home.join("rec");
    let expected = made(&folder);
    let first = folder.join("features").join(&names(&folder.join("features"))[0]);
    // The same number of features and length of file, but other numbers.
    let text = fs::read_to_string(&first).expect("text");
    let digit = text.char_indices().filter(|(_, c)| c.is_ascii_digit()).nth(40).expect("numbers").0;
    let other = if text[digit..].starts_with('7') { "8" } else { "7" };
    fs::write(&first, format!("{}{other}{}", &text[..digit], &text[digit + 1..])).expect("written");
    let count = || resumed(&home, &arguments("rec", "12")).into_iter().filter(|is| *is).count();
    assert_eq!(count(), 19);
    same(&folder, &expected, "altered");
    assert_eq!(count(), 20);
    fs::remove_file(&first).expect("removed");
    assert_eq!(count(), 19, "a file that is gone is made again");
    // A folder in the way of a record: the burst is reported as failed, and its features do not count as finished.
    let record = folder.join("records").join(&names(&folder.join("records"))[0]);
    fs::remove_file(&record).expect("removed");
    fs::create_dir(&record).expect("made");
    says(home.run_badly(&arguments("rec", "3"), 1), &["records"]);
    fs::remove_dir(&record).expect("removed");
    home.run_well(&arguments("rec", "12"));
    same(&folder, &expected, "in the way");
}

fn small_chart(home: &Path, out: &str, seed: u32, more: &str) {
    let size = "--width 96 --height 72 --discs 4 --radius 3:6";
    home.run_well(&format!("synth chart --out {out} --seed {seed} {size} {more}"));
}

fn nights() -> Folder {
    let home = folder();
    for (night, seed) in [("a", 1), ("b", 2)] {
        small_chart(&home, night, seed, "--frames 3 --snr 5");
        home.make_dir(&format!("nights/{night}"));
        for t in 0..3 {
            let frame = image::open(home.join(format!("{night}/frame_00{t}.png"))).expect("a frame");
            frame.save(home.join(format!("nights/{night}/{t}.pgm"))).expect("written");
        }
    }
    home
}

/// For each burst whether it was taken from an earlier run.
fn resumed(home: &Path, line: &[&str]) -> Vec<bool> {
    let json = home.run_json(&[line, &["--json"]].concat());
    json["images"].as_array().expect("images").iter().map(|image| image["resumed"] == true).collect()
}

/// Runs `nights` into the folder `rec`.
fn rec(home: &Path, more: &[&str]) -> Vec<bool> {
    resumed(home, &[&["colmap", "nights", "--out", "rec", "--slopes-u", "-1:1:3", "--octaves", "2"], more].concat())
}

#[test]
fn colmap_keeps_faint_features_unless_told_otherwise() {
    let home = nights();
    home.write("mine.toml", "levels = 4\n");
    let gate = |out: &str, more: &[&str]| {
        let arguments = ["colmap", "nights", "--slopes-u", "-1:1:3", "--octaves", "2", "--json", "--out", out];
        let json = home.run_json(&[&arguments, more].concat());
        let features = json["images"].as_array().expect("images").iter().map(|image| image["features"].as_u64());
        let text = json.to_string();
        let word = ["matching", "auto"].into_iter().find(|word| text.contains(&format!("\"noise_gate\":\"{word}\"")));
        (word, features.map(|count| count.expect("a number")).sum::<u64>())
    };
    let (of_command, kept) = gate("rec", &[]);
    let (as_told, fewer) = gate("rec2", &["--noise-gate", "auto"]);
    assert!((of_command, as_told) == (Some("matching"), Some("auto")) && kept > fewer, "{kept} {fewer}");
    assert_eq!(gate("rec3", &["--params", "mine.toml"]).0, Some("auto"), "a parameter file has the usual defaults");
    assert_eq!(home.run_json("colmap nights --octaves 2 --json --out rec4")["params"]["slopes"], "auto");
    says(home.run_well("colmap --help"), &["[default of this command: matching]"]);
}

#[test]
fn features_are_kept_for_frames_of_the_same_content() {
    let home = nights();
    let at = |name: &str| home.join(name);
    assert_eq!(rec(&home, &[]), [false, false]);
    let first = made(&at("rec"));
    // Other access rights, another date, a copy in the frame's place: the content is the same.
    let frame = at("nights/a/1.pgm");
    let (content, modified) = (fs::read(&frame).expect("read"), fs::metadata(&frame).and_then(|f| f.modified()));
    let modified = modified.expect("a time");
    let set_modified = |time| fs::File::options().write(true).open(&frame).and_then(|file| file.set_modified(time));
    set_modified(modified - Duration::from_secs(60)).expect("set");
    assert_eq!(rec(&home, &[]), [true, true]);
    fs::write(at("copy.pgm"), &content).and_then(|()| fs::rename(at("copy.pgm"), &frame)).expect("replaced");
    assert_eq!(rec(&home, &[]), [true, true]);
    assert_eq!(rec(&home, &["--check-content"]), [true, true]);
    let other = fs::read(at("nights/b/1.pgm")).expect("read");
    assert!(other.len() == content.len() && other != content);
    set_modified(modified).expect("set");
    rec(&home, &[]);
    fs::write(&frame, &other).and_then(|()| set_modified(modified)).expect("replaced");
    if cfg!(unix) {
        assert_eq!(rec(&home, &[]), [false, true]);
        assert!(made(&at("rec")) != first, "other frames have other features");
    }
    fs::write(&frame, &content).expect("put back");
    rec(&home, &["--check-content"]);
    same(&at("rec"), &first, "put back");
}

#[test]
fn the_content_decides_when_it_is_asked_for_and_a_picture_that_was_emptied_or_altered_is_written_again() {
    let home = nights();
    rec(&home, &[]);
    let record = home.join("rec/records/a.png.json");
    // As if the frame had changed, with length and times unchanged.
    let text = fs::read_to_string(&record).expect("a record");
    let mut json: Value = serde_json::from_str(&text).expect("JSON");
    json["files"][1]["crc32"] = serde_json::json!(1);
    fs::write(&record, json.to_string()).expect("written");
    assert_eq!(rec(&home, &[]), [true, true]);
    assert_eq!(rec(&home, &["--check-content"]), [false, true]);
    assert_eq!(rec(&home, &["--check-content"]), [true, true]);
    let home = nights();
    rec(&home, &[]);
    let first = made(&home.join("rec"));
    let picture = home.join("rec/images/b.png");
    let whole = fs::read(&picture).expect("a picture");
    let mut altered = whole.clone();
    altered[whole.len() / 2] ^= 1;
    for wrong in [&b""[..], &whole[..whole.len() / 2], &altered] {
        fs::write(&picture, wrong).expect("written");
        assert_eq!(rec(&home, &[]), [true, true], "its features are whole");
        same(&home.join("rec"), &first, "written again");
    }
    fs::remove_file(&picture).expect("removed");
    assert_eq!(rec(&home, &[]), [true, true]);
    same(&home.join("rec"), &first, "made again");
}

#[test]
fn what_several_runs_have_found_is_gathered() {
    let home = folder();
    for (name, seed) in [("a", 1), ("b", 2), ("c", 2), ("d", 2)] {
        small_chart(&home, &format!("nights/{name}"), seed, "--frames 4");
    }
    let search = ["--slopes-u", "-1:1:3", "--octaves", "2"];
    let colmap = |inputs: &[&str], more: &[&str]| home.run_well(&[&["colmap"], inputs, &search, more].concat());
    colmap(&["nights"], &["--out", "whole"]);
    // Two machines, two bursts each; the second one lost a file.
    colmap(&["nights/a", "nights/b"], &["--out", "one"]);
    colmap(&["nights/c", "nights/d"], &["--out", "two"]);
    home.write("two/features/d.png.txt", "0 128\n");
    let text = colmap(&["nights"], &["--out", "all", "--gather", "one", "--gather", "two"]);
    assert!(text.contains("gathered the features of 3 of 4 bursts"), "{text}");
    assert_eq!(text.matches("from an earlier run").count(), 3, "{text}");
    same(&home.join("all"), &made(&home.join("whole")), "gathered");
    let manifest = home.json("all/manifest.json");
    assert_eq!(manifest["claims"]["settings"]["export"]["pairs"], "all", "{manifest}");
    // A burst that is not taken is named with the reason, on the standard error and in the JSON.
    let gather = |more: &[&str]| home.run(&[&["colmap", "nights"][..], &search, more].concat());
    let output = gather(&["--out", "again", "--gather", "one", "--gather", "two"]);
    assert!(
        stderr(&output).contains("note: --gather two: d not taken: its file of features is missing or was altered")
    );
    home.make_dir("film");
    let output = gather(&["--out", "other", "--gather", "one", "--gather", "film", "--edge-threshold", "5", "--json"]);
    let words = stderr(&output);
    assert!(words.contains("--gather one: a, b not taken"), "{words}");
    says(&words, &["other options (edge-threshold)", "--gather film: it holds none of these bursts"]);
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let (gathered, left_out) = (&json["gathered"], &json["gathered"]["left_out"][1]);
    assert_eq!((&gathered["brought"], &left_out["burst"]), (&serde_json::json!([]), &"b".into()));
    assert!(left_out["reason"].as_str().is_some_and(|why| why.contains("edge-threshold")));
    assert_eq!(gathered["strange_folders"], serde_json::json!(["film"]));
    says(home.run_badly("colmap nights --out none --gather gone", 1), &["gone"]);
}
