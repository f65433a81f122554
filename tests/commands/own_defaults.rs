//! The user's own defaults, from the file that `BURSTSCOPE_DEFAULTS` names or from its usual place.

use super::support::{names, program, stderr};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

const NONE: &str = "";

fn detect(home: &Path, defaults: &str, more: &[&str]) -> Output {
    let line = [&["detect", "demo-tripod", "--octaves", "2", "--out", "found", "--json"], more].concat();
    program(home, &line).env("BURSTSCOPE_DEFAULTS", defaults).output().expect("it starts")
}

fn document(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn levels(output: &Output) -> Option<u64> {
    document(output)["params"]["levels"].as_u64()
}

#[test]
fn own_defaults_are_taken_and_told_below_files_and_options() {
    let home = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(home.path().join(name), text).expect("written");
    write("own.toml", "levels = 4\nmax_features = 30\n[matching]\nratio = 0.6\nmin_inliers = 5\n");
    write("p.toml", "levels = 5\n");
    let told = "note: took defaults from own.toml\n";
    for (more, expected) in [
        (&[][..], 4),
        (&["--params", "p.toml"], 5),
        (&["--levels", "6"], 6),
        (&["--params", "p.toml", "--levels", "6"], 6),
    ] {
        let output = detect(home.path(), "own.toml", more);
        assert_eq!((levels(&output), stderr(&output).as_str()), (Some(expected), told), "{more:?}");
        assert_eq!(document(&output)["params"]["max_features"], 30);
    }
    let output = detect(home.path(), NONE, &[]);
    assert_eq!((levels(&output), stderr(&output).as_str()), (Some(3), ""));

    let line = ["match", "demo", "demo-later", "--octaves", "2", "--out", "m", "--json", "--min-inliers", "9"];
    let matched = program(home.path(), &line).env("BURSTSCOPE_DEFAULTS", "own.toml").output().expect("it starts");
    let document = document(&matched);
    assert!((document["matching"]["ratio"].as_f64().expect("a number") - 0.6).abs() < 1e-6, "{document}");
    assert_eq!((&document["matching"]["min_inliers"], &document["params"]["levels"]), (&9.into(), &4.into()));
    assert_eq!(stderr(&matched), told, "it is told once");
}

#[test]
fn the_usual_place_is_read_unless_the_variable_is_set() {
    let home = tempfile::tempdir().expect("a folder");
    let folder = home.path().join("config/burstscope");
    std::fs::create_dir_all(&folder).expect("made");
    std::fs::write(folder.join("defaults.toml"), "levels = 4\n").expect("written");
    let run = |variable: Option<&str>| {
        let line = ["detect", "demo-tripod", "--octaves", "2", "--out", "found", "--json"];
        let mut command = program(home.path(), &line);
        command.env("XDG_CONFIG_HOME", home.path().join("config")).env_remove("BURSTSCOPE_DEFAULTS");
        command.envs(variable.map(|value| ("BURSTSCOPE_DEFAULTS", value))).output().expect("it starts")
    };
    if cfg!(all(unix, not(target_os = "macos"))) {
        let output = run(None);
        let told = stderr(&output);
        assert!(levels(&output) == Some(4) && told.contains("config/burstscope/defaults.toml"), "{told}");
    }
    assert_eq!(levels(&run(Some(NONE))), Some(3));
}

#[test]
fn what_is_wrong_with_own_defaults_is_told_with_their_file() {
    let home = tempfile::tempdir().expect("a folder");
    let write = |text: &str| std::fs::write(home.path().join("own.toml"), text).expect("written");
    let fails = |line: &[&str], defaults: &str, code: i32, words: [&str; 2]| {
        let line = [line, &["--out", "x"]].concat();
        let output = program(home.path(), &line).env("BURSTSCOPE_DEFAULTS", defaults).output().expect("it starts");
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{line:?}: {told}");
        assert!(words.iter().chain([&defaults]).all(|word| told.contains(word)), "{line:?}: {told}");
    };
    let (detect, matched) = (["detect", "demo"], ["match", "demo", "demo-later"]);
    write("peak_treshold = 1.0\n");
    fails(&detect, "own.toml", 2, ["peak_treshold", "peak_threshold"]);
    fails(&matched, "own.toml", 2, ["peak_treshold", "peak_threshold"]);
    write("levels = 99\n");
    fails(&detect, "own.toml", 2, ["levels", "99"]);
    write("[matching]\nratoi = 0.7\n");
    fails(&matched, "own.toml", 2, ["line 2", "ratoi"]);
    fails(&detect, "gone.toml", 1, ["cannot read", "parameter file"]);
    assert_eq!(names(home.path()), ["own.toml"]);
}

#[test]
fn nothing_is_written_over_own_defaults() {
    let home = tempfile::tempdir().expect("a folder");
    std::fs::write(home.path().join("own.tiff"), "levels = 4\n").expect("written");
    let line = ["stack", "demo-tripod", "--slope", "0,0", "--out", "own.tiff", "--force"];
    let output = program(home.path(), &line).env("BURSTSCOPE_DEFAULTS", "own.tiff").output().expect("it starts");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert_eq!(std::fs::read(home.path().join("own.tiff")).expect("there"), b"levels = 4\n");
}
