//! The user's own defaults, from the file that `BURSTSCOPE_DEFAULTS` names or from its usual place.

use crate::support::*;
use burstscope::detector::Rules;

/// Runs `case`, whose document has the parameters of a search that it need not make.
fn kept(home: &Path, defaults: &str, more: &[&str]) -> Output {
    let line = [&["case", "demo-tripod", "--out", "a.burstcase", "--json"], more].concat();
    home.program(&line).env("BURSTSCOPE_DEFAULTS", defaults).output().expect("it starts")
}

fn document(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn search(output: &Output) -> SearchParams {
    serde_json::from_value(document(output)["case"]["search"].clone()).expect("parameters")
}

#[test]
fn options_come_before_their_file_before_own_defaults_before_what_is_built_in() {
    let home = folder();
    let write = |name: &str, text: &str| home.write(name, text);
    write("own.toml", "levels = 4\nmax_features = 70\nedge_threshold = 8.0\n[matching]\nratio = 0.6\nseed = 7\n");
    write("p.toml", "levels = 5\nmax_features = 80\n[matching]\nratio = 0.7\nmin_inliers = 5\n");
    write("rules.toml", "rules = \"vlfeat\"\nlevels = 6\n");
    let own = SearchParams { levels: 4, max_features: 70, edge_threshold: 8.0, ..SearchParams::default() };
    let of_file = SearchParams { levels: 5, max_features: 80, ..own.clone() };
    // Rules bring what goes with them, as on the command line, and leave the number of features.
    let of_rules = SearchParams { max_features: 70, ..SearchParams::default() }.under(Rules::VLFEAT);
    for (more, expected) in [
        (&[][..], own.clone()),
        (&["--levels", "6"], SearchParams { levels: 6, ..own }),
        (&["--params", "p.toml"], of_file.clone()),
        (&["--params", "p.toml", "--max-features", "90"], SearchParams { max_features: 90, ..of_file }),
        (&["--params", "rules.toml"], SearchParams { levels: 6, ..of_rules }),
    ] {
        let output = kept(&home, "own.toml", more);
        assert_eq!(search(&output), expected, "{more:?}");
        assert_eq!(stderr(&output), "note: took defaults from own.toml\n", "{more:?}");
    }
    let output = kept(&home, "", &[]);
    assert_eq!((search(&output), stderr(&output).as_str()), (SearchParams::default(), ""));
    let line = ["match", "demo", "demo-later", "--out", "m", "--json", "--params", "p.toml", "--octaves", "2"];
    let line = [&line[..], &["--min-inliers", "9"]].concat();
    let output = home.program(&line).env("BURSTSCOPE_DEFAULTS", "own.toml").output().expect("it starts");
    let matching: MatchParams = serde_json::from_value(document(&output)["matching"].clone()).expect("parameters");
    assert_eq!(matching, MatchParams { ratio: 0.7, seed: 7, min_inliers: 9, ..MatchParams::default() });
    assert_eq!(stderr(&output).matches("took defaults from own.toml").count(), 1, "{}", stderr(&output));
}

#[test]
fn the_usual_place_is_read_unless_the_variable_is_set() {
    let (home, folder) = folder_with("config/burstscope");
    fs::create_dir_all(&folder).expect("made");
    fs::write(folder.join("defaults.toml"), "levels = 4\n").expect("written");
    let run = |variable: Option<&str>| {
        let line = "case demo-tripod --out a.burstcase --json";
        let mut command = home.program(line);
        command.env("XDG_CONFIG_HOME", home.join("config")).env_remove("BURSTSCOPE_DEFAULTS");
        command.envs(variable.map(|value| ("BURSTSCOPE_DEFAULTS", value))).output().expect("it starts")
    };
    if cfg!(all(unix, not(target_os = "macos"))) {
        let output = run(None);
        let told = stderr(&output);
        assert!(search(&output).levels == 4 && told.contains("config/burstscope/defaults.toml"), "{told}");
    }
    assert_eq!(search(&run(Some(""))), SearchParams::default());
}

#[test]
fn what_is_wrong_with_own_defaults_is_told_with_their_file_and_nothing_is_written_over_own_defaults() {
    let home = folder();
    let write = |text: &str| home.write("own.toml", text);
    let fails = |line: &[&str], defaults: &str, code: i32, words: [&str; 2]| {
        let line = [line, &["--out", "x"]].concat();
        let output = home.program(&line).env("BURSTSCOPE_DEFAULTS", defaults).output().expect("it starts");
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
    assert_eq!(names(&home), ["own.toml"]);
    let home = folder();
    home.write("own.tiff", "levels = 4\n");
    let line = "stack demo-tripod --slope 0,0 --out own.tiff --force";
    let output = home.program(line).env("BURSTSCOPE_DEFAULTS", "own.tiff").output().expect("it starts");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert_eq!(fs::read(home.join("own.tiff")).expect("there"), b"levels = 4\n");
}
