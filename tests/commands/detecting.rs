//! `detect`, and options that all commands share.

use crate::support::*;
use burstscope::inspect::words::grouped;
use burstscope::synth::demo_truth;
use ndarray_npy::NpzReader;

#[test]
fn the_demo_gives_features_in_all_formats_and_json_is_one_document_that_agrees_with_the_files() {
    let (home, out) = folder_with("found");
    let text = home.run_well("detect demo --out found --format csv,colmap,npz");
    let rows = features(&out.join("demo.csv"));
    assert!(rows.len() > 100, "{} features", rows.len());
    says(text, &[&format!("features  {}", rows.len()), "by slope", "the same blob as a stronger one"]);
    let colmap = fs::read_to_string(out.join("demo.txt")).expect("a file");
    let mut lines = colmap.lines();
    assert_eq!(lines.next(), Some(format!("{} 128", rows.len()).as_str()));
    let first: Vec<f64> = lines.next().expect("a feature").split(' ').map(|x| x.parse().expect("a number")).collect();
    assert_eq!(first.len(), 4 + 128);
    assert!((first[0] - rows[0][0] - 0.5).abs() < 1e-3, "COLMAP's first pixel centre is at 0.5");
    let mut npz = NpzReader::new(fs::File::open(out.join("demo.npz")).expect("a file")).expect("an archive");
    let array: ndarray::Array2<f32> = npz.by_name("features").expect("an array");
    let descriptors: ndarray::Array2<u8> = npz.by_name("descriptors").expect("an array");
    assert_eq!((array.dim(), descriptors.dim()), ((rows.len(), 17), (rows.len(), 128)));
    let home = folder();
    let json = home.run_json("detect demo --out found --json --noise-gate 6 --slopes-u -3:3:7");
    let burst = &json["bursts"][0];
    let rows = features(&home.join("found").join("demo.csv"));
    assert_eq!(burst["features"], rows.len());
    assert_eq!((&burst["frames"], &burst["width"], &burst["height"]), (&10.into(), &480.into(), &360.into()));
    assert_eq!(burst["noise_gate_factor"], 6.0);
    assert_eq!(json["params"]["noise_gate"], 6.0);
    let slopes = burst["slopes"].as_array().expect("a list");
    assert_eq!(slopes.len(), 7);
    assert_eq!(slopes.iter().map(|s| s["features"].as_u64().expect("a count")).sum::<u64>(), rows.len() as u64);
    let tally = &burst["tally"];
    let rejected: u64 = tally["rejected"].as_object().expect("a map").values().filter_map(|x| x.as_u64()).sum();
    assert_eq!(rejected + tally["kept"].as_u64().expect("a count"), tally["samples"].as_u64().expect("a count"));
    assert!(burst["times"]["search_secs"].as_f64().expect("a time") > 0.0);
    assert_eq!(burst["files"]["csv"], Path::new("found").join("demo.csv").to_str().expect("text"));
}

#[test]
fn films_are_cut_and_their_bursts_named_apart() {
    let home = folder();
    for (film, frames) in [("day", 5), ("night", 4), ("dusk", 1)] {
        home.make_dir(film);
        let picture = image::GrayImage::from_pixel(24, 24, image::Luma([9]));
        (0..frames).for_each(|t| picture.save(home.join(format!("{film}/f{t}.png"))).expect("written"));
    }
    let names = |report: &Value| -> Vec<String> {
        let bursts = report["bursts"].as_array().expect("a list").iter();
        bursts.map(|burst| burst["name"].as_str().expect("a name").to_owned()).collect()
    };
    let report = home.run_json("detect day --burst-length 3 --burst-step 1 --slopes-u -1:1:3 --out a --json");
    assert_eq!(names(&report), ["f1", "f2", "f3"]);
    let output = home.run("detect day dusk night --burst-length 2 --slopes-u -1:1:3 --out b --json");
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(names(&report), ["day_f1", "day_f3", "night_f1", "night_f3"]);
    says(report["failures"][0].to_string(), &["dusk", "too few frames (1) for a burst of 2"]);
    says(home.run_badly("detect day --burst-length 0 --out c", 2), &["--burst-length"]);
    says(home.run_badly("detect demo --burst-length 2 --out c", 2), &["built-in bursts cannot be cut"]);
}

#[test]
fn the_demos_landmarks_are_found_with_their_motion() {
    let home = folder();
    home.run_well("detect demo --slopes-u -3:3:7 --slopes-v -2:2:5 --out found --quiet");
    let rows = features(&home.join("found").join("demo.csv"));
    // Bright and dark discs that are large enough to stand out well.
    let truth = demo_truth();
    let discs: Vec<_> = truth.features.iter().filter(|f| f.radius >= 3.0).collect();
    let found = discs
        .iter()
        .filter(|disc| {
            rows.iter().any(|row| {
                (row[0] - disc.u).hypot(row[1] - disc.v) < 1.5
                    && (row[4] - disc.slope_u).hypot(row[5] - disc.slope_v) < 0.3
                    && row[6] * f64::from(disc.contrast_sign) < 0.0
            })
        })
        .count();
    assert!(discs.len() >= 20 && found * 10 >= discs.len() * 8, "{found} of {} found", discs.len());
}

#[test]
fn nothing_found_and_slopes_that_do_not_fit_are_explained() {
    let home = folder();
    let nothing = ["detect", "demo", "--peak-threshold", "0.5", "--out", "found"];
    let text = home.run_well(&nothing);
    says(&text, &["note      no feature was found: of ", "; try --peak-threshold 0, which finds "]);
    let report = |arguments: &[&str]| home.run_json(&[arguments, &["--json"]].concat())["bursts"][0].clone();
    let said = &report(&nothing)["advice"];
    assert_eq!((&said["parameter"], &said["value"]), (&"peak-threshold".into(), &"0".into()));
    let finds = report(&["detect", "demo", "--peak-threshold", "0", "--out", "found"])["features"].clone();
    let finds = format!(", which finds {}", grouped(finds.as_u64().expect("a number")));
    assert!(said["message"].as_str().is_some_and(|text| text.ends_with(&finds)), "{said} {finds}");
    // Nothing moves, and slope 0 is not searched.
    let still = ["synth", "chart", "--out", "still", "--width", "240", "--height", "180", "--discs", "16"];
    home.run_well(&[&still[..], &["--radius", "4:8", "--max-slope", "0", "--snr", "8"]].concat());
    let beside = ["detect", "still", "--slopes-u", "0.3:2.7:9", "--out", "found"];
    let said = &report(&beside)["slopes_judged"];
    assert!(said["sentence"].as_str().is_some_and(|text| text.contains("one slope, 0, is enough")), "{said}");
    let change = serde_json::json!([{"parameter": "slopes-u", "value": "0:0:1"}]);
    assert_eq!(said["advice"]["changes"], change, "{said}");
    says(home.run_well(&beside), &["try --slopes-u 0:0:1\n"]);
    let fits = report(&["detect", "still", "--slopes-u", "0:0:1", "--out", "found"]);
    assert_eq!((&fits["slopes_judged"]["advice"], &fits["advice"]), (&Value::Null, &Value::Null));
}

#[test]
fn wrong_use_is_2_and_says_what_would_be_right_and_failures_are_1_and_name_the_file() {
    let home = folder();
    for (arguments, words) in [
        (&["detect", "demo"][..], "--out"),
        (&["detect", "--out", "x"], "<INPUT>"),
        (&["detect", "demo", "--out", "x", "--method", "surf"], "buff, sift"),
        (&["detect", "demo", "--out", "x", "--slopes-u", "3:-3:7"], "give the smaller slope first"),
        (&["detect", "demo", "--out", "x", "--slopes-u", "fast"], "'fast' is not a number"),
        (&["detect", "demo", "--out", "x", "--slopes", "auto", "--slopes-u", "0:2:3"], "cannot be used with"),
        (&["match", "demo", "demo-later", "--out", "x", "--slopes", "all"], "auto"),
        (&["evaluate", "chart", "--slopes", "auto"], "--slopes-u"),
        (&["detect", "demo", "--out", "x", "--frames", "4"], "A..B"),
        (&["detect", "demo", "--out", "x", "--format", "xlsx"], "csv, colmap and npz"),
        (&["detect", "demo", "--out", "x", "--threads", "0"], "1..=1024"),
        (&["detect", "demo", "--out", "x", "--bias", "b.png"], "no calibration"),
        (&["stack", "demo", "--slope", "1", "--out", "x.tiff"], "U,V"),
        (&["stack", "demo", "--slope", "1,0", "--octave", "0", "--out", "x.tiff"], "--level"),
        (&["stack", "demo", "--slope", "1,0", "--out", "x.png"], ".tiff"),
        (&["synth", "chart", "--out", "x", "--motion", "3d"], "1d, 2d"),
        (&["synth", "scene", "--out", "x", "--snr", "-1"], "snr"),
    ] {
        says(home.run_badly(arguments, 2), &[words, "--help"]);
    }
    assert!(names(&home).is_empty(), "wrong use writes nothing");
    home.write("a file", "no picture");
    for (arguments, words) in [
        (&["detect", "no such folder", "--out", "x"][..], "no such folder"),
        (&["detect", "a file", "--out", "x"], "a file"),
        (&["detect", "demo", "--out", "a file/x"], "a file"),
        (&["detect", "demo", "--out", "x", "--params", "no.toml"], "no.toml"),
        (&["detect", "demo", "--out", "x", "--frames", "0..99"], "give A..B with B at most 10"),
        (&["no such input"], "no such input"),
    ] {
        says(home.run_badly(arguments, 1), &[words]);
    }
    assert_eq!(names(&home), ["a file"]);
}

#[test]
fn slopes_are_found_unless_they_are_given() {
    let home = folder();
    let few = ["--octaves", "3", "--max-features", "200"];
    let json =
        |more: &[&str]| home.run_json(&[&["detect", "demo", "--out", "found", "--json"], &few[..], more].concat());
    let found = json(&[]);
    assert_eq!(found["params"]["slopes"], "auto");
    let burst = &found["bursts"][0];
    let finding = &burst["slopes_found"];
    assert_eq!((&finding["verdict"], &finding["grid"]), (&"found".into(), &burst["slope_grid"]));
    assert!(finding["confidence"].as_f64().is_some_and(|c| c > 0.8), "{finding}");
    let axis = |name: &str| ["min", "max"].map(|end| burst["slope_grid"][name][end].as_f64().expect("a number"));
    let ([u_min, u_max], [v_min, v_max]) = (axis("u"), axis("v"));
    // The sign's slope is -2.1, the lanterns' (1.6, -1.2).
    assert!(u_min < -2.1 && u_max > 1.6 && v_min < -1.2 && v_max > 0.0, "{}", burst["slope_grid"]);
    assert!(burst["times"]["slopes_secs"].as_f64().is_some_and(|secs| secs > 0.0));
    assert_eq!(json(&["--slopes", "auto"])["bursts"][0]["slope_grid"], burst["slope_grid"]);
    let line = json(&["--slope-direction", "0"]);
    assert_eq!(line["params"]["slopes"]["direction_deg"], 0.0);
    assert_eq!(line["bursts"][0]["slope_grid"]["v"]["count"], 1);
    let given = json(&["--slopes-u", "-1:1:3"]);
    assert!(given["bursts"][0]["slopes_found"].is_null() && given["params"]["slopes"]["u"]["count"] == 3);
    assert!(json(&["--method", "sift"])["bursts"][0]["slopes_found"].is_null(), "nothing is searched");
    home.write("auto.toml", "slopes = \"auto\"\noctaves = 2\n");
    let text = home.run_well("detect demo --out found --params auto.toml");
    assert!(text.contains("slopes    found: u ") && text.contains("of what is seen agrees"), "{text}");
}

#[test]
fn a_broken_burst_does_not_stop_the_others() {
    let home = folder();
    for (name, seed) in [("a", "1"), ("b", "2"), ("c", "3")] {
        let size = "--width 160 --height 120 --discs 4 --radius 3:8";
        home.run_well(&format!("synth chart --out nights/{name} {size} --seed {seed}"));
    }
    home.write("nights/b/frame_004.png", "broken");
    let output = home.run("detect nights gone demo --out found");
    assert_eq!(output.status.code(), Some(1));
    let (text, error) = (String::from_utf8_lossy(&output.stdout), stderr(&output));
    assert!(error.contains("frame_004.png") && error.contains("gone"), "{error}");
    assert!(text.contains("3 of 5 bursts done"), "{text}");
    assert_eq!(names(&home.join("found")), ["a.csv", "c.csv", "demo.csv"]);
    let output = home.run("detect nights --out again --json");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON in spite of the failure");
    assert_eq!((json["bursts"].as_array().map(Vec::len), &json["failures"][0]["name"]), (Some(2), &"b".into()));
}

#[test]
fn quiet_is_quiet_pipes_are_clean_and_help_and_version_are_answers_not_errors() {
    let home = folder();
    let output = home.run("detect demo --out found --quiet");
    assert_eq!((output.status.code(), output.stdout.len(), output.stderr.len()), (Some(0), 0, 0));
    let output = home.run("detect demo --out found");
    assert!(output.stderr.is_empty() && !output.stdout.contains(&0x1b), "{}", stderr(&output));
    assert_eq!(
        home.run_well("--version"),
        format!("burstscope {} (detector {})\n", env!("CARGO_PKG_VERSION"), burstscope::detector::REVISION)
    );
    let (short, long) = (home.run_well("detect -h"), home.run_well("detect --help"));
    let words = long.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.starts_with("Find the features of one or many bursts.") && words.contains("A burst that fails is"));
    assert!(short.starts_with("Find the features of one or many bursts\n") && !short.contains("that fails is"));
    for doc in burstscope::detector::params::doc::ALL {
        assert!(short.contains(&format!("--{}", doc.name)), "{}", doc.name);
    }
    // Only commands that exist are offered.
    let commands = home.run_well("--help");
    for command in
        ["detect", "match", "merge", "stack", "slopes", "probe", "synth", "evaluate", "figures", "colmap", "render"]
    {
        assert!(commands.contains(&format!("\n  {command} ")), "{command}");
        home.run_well(&[command, "--help"]);
    }
    assert!(!commands.contains("\n  compare "));
}
