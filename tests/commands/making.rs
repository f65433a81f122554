//! `synth`: frames that open again, with their truth.

use crate::support::*;
use burstscope::synth::{FeatureTruth, Motion, Truth, TruthKind, synth_chart};

fn truth(folder: &Path) -> Truth {
    serde_json::from_str(&fs::read_to_string(folder.join("truth.json")).expect("a file")).expect("a truth")
}

#[test]
fn a_chart_opens_again_with_the_very_same_values_and_other_peoples_files_are_left_alone() {
    let home = folder();
    let arguments = "synth chart --out chart --width 200 --height 150 --discs 6 --radius 3.6:9 --frames 4 --snr 1.5 \
                     --motion 2d --seed 11";
    says(home.run_well(arguments), &["4 frames of 200×150, 6 features"]);
    let folder = home.join("chart");
    assert_eq!(
        names(&folder),
        [".burstscope.json", "frame_000.png", "frame_001.png", "frame_002.png", "frame_003.png", "truth.json"]
    );
    let params = ChartParams { width: 200, height: 150, discs: 6, radius: 3.6..=9.0, ..ChartParams::default() };
    let params = ChartParams { frames: 4, snr: 1.5, motion: Motion::TwoD, seed: 11, ..params };
    let (made, known) = synth_chart(&params, &Monitor::default()).expect("a chart");
    assert_eq!(Burst::open(&folder).expect("it opens").frames, made.frames);
    let written = fs::read_to_string(folder.join("truth.json")).expect("a file");
    assert_eq!(written.trim_end(), serde_json::to_string_pretty(&known).expect("valid"));
    assert_eq!((known.kind, known.noise.and_then(|n| n.snr)), (TruthKind::Chart, Some(1.5)));
    home.make_dir("mine");
    home.write("mine/thesis.txt", "precious");
    let arguments = "synth chart --out mine --width 64 --height 48 --discs 1 --max-slope 1";
    says(home.run_badly(arguments, 1), &["mine"]);
    assert_eq!(names(&home.join("mine")), ["thesis.txt"]);
    let output = home.run("synth chart --out x --discs 4000");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("fewer or smaller discs"), "{}", stderr(&output));
}

#[test]
fn a_light_field_opens_again_by_its_names_with_its_truth() {
    let home = folder();
    let arguments =
        "synth chart --out field --width 240 --height 200 --discs 8 --radius 4:9 --views 5x4 --max-slope 1.5 --snr 2"
            .words();
    home.run_well(&arguments);
    let folder = home.join("field");
    assert!(folder.join("view_04_03.png").is_file() && !folder.join("times.csv").exists());
    let known = truth(&folder);
    assert_eq!((known.frames, known.views[19]), (20, [3.0, 4.0]));
    says(home.run_well("info field"), &["views   5 rows × 4 columns"]);
    home.run_well("detect field --out found");
    let rows = features(&home.join("found/field.csv"));
    let found = known.features.iter().filter(|disc| {
        rows.iter().any(|row| {
            (row[0] - disc.u).hypot(row[1] - disc.v) < 1.0 && (row[4] - disc.slope_u).abs() < 0.1 && row[5] == 0.0
        })
    });
    assert!(found.count() >= 7, "{rows:?}");
    let badly = home.run_badly("synth chart --views 5x4 --drop 1 --out odd", 2);
    assert!(badly.contains("views: the views of a light field have no times"), "{badly}");
}

#[test]
fn exchanged_frames_and_an_arm_are_made_with_their_truth_and_taken_back() {
    let home = folder();
    let synth = |out: &str, more: &str| {
        let line = format!(
            "synth chart --out {out} --width 320 --height 240 --discs 12 --radius 4:10 --frames 7 --max-slope 2 --snr 2 {more}"
        );
        home.run_well(&line);
        truth(&home.join(out))
    };
    let known = synth("exchanged", "--exchange 1,4");
    assert_eq!(known.times, [0.0, 4.0, 2.0, 3.0, 1.0, 5.0, 6.0]);
    let search = "--slopes-u -2.5:2.5:11 --json --force --out found";
    let found = |more: &str| home.run_json(&format!("detect {more} {search}"));
    let answers = |folder: &str, known: &Truth| {
        let rows = features(&home.join(format!("found/{folder}.csv")));
        let is_found = |disc: &&FeatureTruth| {
            rows.iter().any(|row| (row[0] - disc.u).hypot(row[1] - disc.v) < 1.0 && (row[4] - disc.slope_u).abs() < 0.2)
        };
        (known.features.iter().filter(is_found).count(), known.features.len())
    };
    let burst = &found("exchanged --times found")["bursts"][0];
    says(&burst["taken"][0], &["exchanged"]);
    let names: Vec<&str> = burst["frame_names"].as_array().expect("names").iter().filter_map(|n| n.as_str()).collect();
    let mut in_order = names.clone();
    in_order.sort_unstable();
    in_order.swap(1, 4);
    assert_eq!(names, in_order);
    let (right, all) = answers("exchanged", &known);
    assert!(right + 1 >= all, "{right} of {all}");
    let known = synth("behind", "--mask 0.4");
    assert!(known.mask_columns == 128 && (1..12).contains(&known.features.len()), "{known:?}");
    let at_edge = |folder: &str| {
        let rows = features(&home.join(format!("found/{folder}.csv")));
        rows.iter().filter(|row| row[0] < 128.0).count()
    };
    found("behind");
    let without = at_edge("behind");
    found("behind --mask behind/masks/mask.png");
    let (right, all) = answers("behind", &known);
    assert!(right + 1 >= all && at_edge("behind") < 5 && without > 20, "{right} of {all}, {without} without a mask");
}

#[test]
fn the_features_of_a_chart_are_its_discs_and_a_scene_opens_again_and_can_be_noiseless() {
    let home = folder();
    home.run_well("synth chart --out chart --width 320 --height 240 --discs 12 --radius 4:10 --snr 2");
    home.run_well("detect chart --slopes-u -3.5:3.5:15 --out found");
    let rows = features(&home.join("found/chart.csv"));
    let known = truth(&home.join("chart"));
    let found = known.features.iter().filter(|disc| {
        rows.iter().any(|row| {
            (row[0] - disc.u).hypot(row[1] - disc.v) < 1.0
                && (row[2] / disc.sigma - 1.0).abs() < 0.25
                && (row[4] - disc.slope_u).abs() < 0.2
        })
    });
    assert!(found.count() >= 11, "{rows:?}");
    let home = folder();
    home.run_well("synth scene --out scene --width 240 --height 180 --frames 3 --snr inf --motion 2d");
    let known = truth(&home.join("scene"));
    assert_eq!((known.kind, known.layers.len(), known.noise), (TruthKind::Scene, 4, None));
    let opened = Burst::open(home.join("scene")).expect("it opens");
    assert_eq!((opened.len(), opened.size()), (3, (240, 180)));
}

#[test]
fn noisy_copies_keep_names_and_bursts_apart() {
    let home = folder();
    for seed in ["1", "2"] {
        let out = format!("clean/night {seed}");
        home.run_well(&[
            "synth", "scene", "--out", &out, "--width", "120", "--height", "90", "--frames", "3", "--snr", "inf",
            "--seed", seed,
        ]);
    }
    let copy = |out: &str, more: &[&str]| home.run_well(&[&["synth", "noisy", "clean", "--out", out], more].concat());
    says(copy("dark", &["--snr", "0.5", "--seed", "7"]), &["6 frames of 2 bursts"]);
    assert_eq!(names(&home.join("dark")), [".burstscope.json", "night 1", "night 2", "noise.json"]);
    assert_eq!(names(&home.join("dark/night 2")), ["frame_000.png", "frame_001.png", "frame_002.png"]);
    let json: Value = serde_json::from_str(&copy("dark", &["--snr", "0.5", "--seed", "7", "--json"])).expect("JSON");
    assert_eq!(json["truth"]["snr"], 0.5);
    assert_eq!(json["truth"]["frames"][3].as_str(), Some("night 2/frame_000.png"));
    let frame = |out: &str| fs::read(home.join(out).join("night 1/frame_001.png")).expect("a frame");
    copy("again", &["--snr", "0.5", "--seed", "7", "--threads", "3"]);
    copy("other", &["--snr", "0.5", "--seed", "8"]);
    assert!(frame("dark") == frame("again") && frame("dark") != frame("other"));
    assert!(home.run_well("detect dark --out found").contains("2 of 2 bursts done"));
    assert!(home.run_badly("synth noisy dark --out clean", 1).contains("clean"));
    for (option, value) in [("--snr", "0"), ("--bits", "40"), ("--read-noise", "nan")] {
        let wrong = ["synth", "noisy", "clean", "--out", "x", option, value];
        assert!(home.run_badly(&wrong, 2).contains(&format!("{option}: ")), "{option}");
    }
}
