//! `match` and `merge`: two bursts, and one image of a burst.

use crate::support::*;
use burstscope::dataset::{
    BurstCameras, ColmapJob, DatasetSource, DetectedBurst, FeatureJob, FeatureStore, ImageKind, KeptBursts,
    MatchedPair, export_colmap, export_detections, match_bursts, match_pairs,
};
use burstscope::error::{Error, Result};
use burstscope::evaluate::{BurstMethod, MatchStudy, Searches, Shot};
use burstscope::matching::{Geometry, MatchCounts};
use burstscope::{Detection, detect};

/// Two noisy bursts of one scene in a folder: equal layers, other noise, and the second one begins three frames later.
fn two_bursts() -> Folder {
    let home = folder();
    home.run_well("synth scene --out film --width 320 --height 240 --frames 12 --max-slope 1.5 --snr 3 --seed 4");
    for (name, first) in [("a", 0), ("b", 5)] {
        home.make_dir(name);
        for t in first..first + 7 {
            let frame = format!("frame_{t:03}.png");
            fs::copy(home.join("film").join(&frame), home.join(name).join(&frame)).expect("copied");
        }
    }
    home
}

#[test]
fn two_bursts_are_matched_verified_and_drawn() {
    let home = two_bursts();
    let search = ["--slopes-u", "-2:2:9", "--threads", "2"];
    let text = home.run_well(&[&["match", "a", "b", "--out", "m"], &search[..]].concat());
    assert_eq!(names(&home.join("m")), ["a.csv", "a_b.matches.csv", "a_b.matches.png", "b.csv"]);
    assert!(text.contains("inliers") && text.contains("match score"), "{text}");
    let json = home.run_json(
        &[&["match", "a", "b", "--out", "n", "--json", "--images", "merged", "--threads", "1"], &search[..2]].concat(),
    );
    let count = |key: &str| json[key].as_u64().unwrap_or_else(|| panic!("{key}")) as usize;
    let out = |file: &str| home.join("n").join(file);
    let (a, b) = (features(&out("a.csv")), features(&out("b.csv")));
    assert_eq!((count("keypoints_a"), count("keypoints_b")), (a.len(), b.len()));
    assert_eq!((json["command"].as_str(), json["a"]["features"].as_u64()), (Some("match"), Some(a.len() as u64)));
    let text = fs::read_to_string(out("a_b.matches.csv")).expect("a file");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(burstscope::export::MATCH_COLUMNS));
    // Empty cells are NaN here, and predicted matches 1 in the column `how`, which alone has words.
    let cell = |(k, cell): (usize, &str)| match cell {
        "" if k > 5 => f64::NAN,
        "sure" | "predicted" if k == 13 => f64::from(u8::from(cell == "predicted")),
        cell => cell.parse().ok().filter(|x: &f64| x.is_finite()).unwrap_or_else(|| panic!("{k}: '{cell}'")),
    };
    let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').enumerate().map(cell).collect()).collect();
    let inliers = rows.iter().filter(|r| r[9] == 1.0).count();
    assert_eq!((count("putative"), count("inliers")), (rows.len(), inliers));
    assert!(inliers >= 30 && inliers * 10 >= rows.len() * 7, "{inliers} of {}", rows.len());
    // The scene moves along u only, by 1.5 px/frame at most, and five frames lie between the bursts.
    let moves_so = |r: &&Vec<f64>| (r[5] + r[11] - r[3]).abs() < 1.0 && (r[4] + r[10] - r[2]).abs() < 5.0 * 1.5 + 1.0;
    let right = rows.iter().filter(|r| r[9] == 1.0).filter(moves_so).count();
    // Measured: 288 of 306.
    assert!(right * 100 >= inliers * 94, "{right} of {inliers}");
    for row in &rows {
        let (of_a, of_b) = (&a[row[0] as usize], &b[row[1] as usize]);
        assert_eq!([row[2], row[3], row[4], row[5]], [of_a[0], of_a[1], of_b[0], of_b[1]]);
        // The max error of aligned matches, 0.35 times 4 px; moved by at most 20 px, and both ends agree with what
        // the pictures say.
        assert!(row[9] == 0.0 || row[8] <= 1.4);
        for k in [0, 2] {
            let moved = (row[16 + k] - row[2 + k]).hypot(row[17 + k] - row[3 + k]);
            assert!(moved <= 20.001, "{moved} px");
        }
        // One predicted among a single place has nothing to compare with; every ratio is one.
        assert_eq!(row[14].is_nan(), row[13] == 0.0);
        assert!(row[7].is_nan() && row[14] == 1.0 || row[7] > 0.0 && row[7] <= 0.9, "{row:?}");
    }
    assert!(rows.iter().any(|row| row[13] == 1.0) && rows.iter().any(|row| row[13] == 0.0));
    let aligned = rows.iter().filter(|row| row[9] == 1.0 && row[8] < row[20]).count();
    assert!(aligned * 2 > inliers, "{aligned} of {inliers} fit better after the alignment");
    let score = json["match_score"].as_f64().expect("a number");
    let expected = 0.5 * (inliers as f64 / a.len() as f64 + inliers as f64 / b.len() as f64);
    assert!((score - expected).abs() < 1e-9);
    assert_eq!(json["model"]["kind"].as_str(), Some("fundamental"));
    assert_eq!(json["model"]["matrix"][2].as_array().map(Vec::len), Some(3));
    let picture = image::open(out("a_b.matches.png")).expect("a picture").to_rgb8();
    assert_eq!(picture.width(), 2138, "181 mm with 300 pixels an inch");
    assert!(picture.pixels().any(|p| p.0 == burstscope::export::MatchKind::Inlier.color()), "the legend's line");
    let read = |folder: &str, file: &str| fs::read(home.join(folder).join(file)).expect("a file");
    assert_eq!(read("m", "a_b.matches.csv"), read("n", "a_b.matches.csv"));
    assert_ne!(read("m", "a_b.matches.png"), read("n", "a_b.matches.png"));
    figure_as_vectors(&home, &rows);
}

/// As SVG the figure has the names, the matches that were asked for, of the smallest distance, and their numbers.
fn figure_as_vectors(home: &Path, rows: &[Vec<f64>]) {
    let vectors = ["--picture", "svg", "--drawn", "40", "--width", "88", "--slopes-u", "-2:2:9"];
    home.run_well(&[&["match", "a", "b", "--out", "v"], &vectors[..]].concat());
    let svg = home.text("v/a_b.matches.svg");
    let mut nearest: Vec<&Vec<f64>> = rows.iter().collect();
    nearest.sort_by(|a, b| a[6].total_cmp(&b[6]));
    let inliers = nearest[..40].iter().filter(|row| row[9] == 1.0).count();
    let all = rows.iter().filter(|row| row[9] == 1.0).count();
    let legend = format!("{inliers} of {all} inliers");
    says(&svg, &["(a) A: a · motion", "(b) B: b · motion", &legend, "of full scale"]);
    assert_eq!(svg.matches("class=\"match\"").count(), 40);
    assert!(!home.join("v/a_b.matches.png").exists());
}

#[test]
fn matches_may_stay_unverified_and_wrong_use_is_explained() {
    let home = folder();
    let json = home.run_json("match demo demo --out m --geometry none --json --method sift");
    assert!(json["inliers"].is_null() && json["match_score"].is_null() && json["model"].is_null());
    // A burst matched with itself: nearly every feature matches itself, except those that look alike.
    assert!(json["match_ratio"].as_f64().is_some_and(|x| x > 0.9), "{}", json["match_ratio"]);
    assert_eq!(
        names(&home.join("m")),
        ["demo.csv", "demo_2.csv", "demo_demo_2.matches.csv", "demo_demo_2.matches.png"]
    );
    let text = home.text("m/demo_demo_2.matches.csv");
    let is_empty = |line: &str| [8, 9, 10, 11, 12, 20].iter().all(|k| line.split(',').nth(*k) == Some(""));
    assert!(text.lines().skip(1).all(is_empty) && !text.contains("nan") && !text.contains("inf,"));
    for (arguments, code, words) in [
        (&["match", "demo", "demo", "--out", "x", "--drawn", "0"][..], 2, "give 'all' or"),
        (&["match", "demo", "demo", "--out", "x", "--width", "3"], 2, "88 for one column"),
        (&["match", "demo", "--out", "x"], 2, "<B>"),
        (&["match", "demo", "demo"], 2, "--out"),
        (&["match", "demo", "demo", "--out", "x", "--ratio", "2"], 2, "0.8 is usual"),
        (&["match", "demo", "demo", "--out", "x", "--geometry", "essential"], 2, "intrinsics"),
        (&["match", "demo", "gone", "--out", "x", "--method", "sift"], 1, "gone"),
        (&["merge", "demo", "--out", "x.png"], 2, ".tiff"),
    ] {
        says(home.run_badly(arguments, code), &[words]);
    }
}

#[test]
fn every_option_of_matching_reaches_its_parameter() {
    let home = folder();
    let camera = "SIMPLE_PINHOLE,480,360,500,240,180";
    let matched = |options: &str| -> MatchParams {
        let line = format!("match demo demo-later --method sift --out m --json --camera {camera} {options}");
        let json = home.run_json(&line);
        serde_json::from_value(json["matching"].clone()).expect("parameters")
    };
    let got = matched(
        "--ratio 0.7 --mutual false --geometry homography --predict false --align false --max-error-px 2 \
         --min-inliers 9 --confidence 0.99 --max-iterations 77 --seed 5",
    );
    let expected = MatchParams {
        ratio: 0.7,
        mutual: false,
        predict: false,
        align: false,
        geometry: Geometry::Homography,
        max_error_px: 2.0,
        min_inliers: 9,
        confidence: 0.99,
        max_iterations: 77,
        seed: 5,
        camera: Some(camera.parse().expect("a camera")),
        camera_b: None,
    };
    assert_eq!(got, expected);
    assert_eq!(matched("").geometry, Geometry::Essential, "with a camera and no geometry");
    // The same from a file, whose table other commands leave alone, and under what is given.
    let table = toml::to_string(&expected).expect("TOML").replace("[camera]", "[matching.camera]");
    let write = |text: &str| home.write("p.toml", text);
    write(&format!("levels = 3\n[matching]\n{table}"));
    assert_eq!(matched("--params p.toml"), expected);
    assert_eq!(matched("--params p.toml --ratio 0.6"), MatchParams { ratio: 0.6, ..expected });
    write("levels = 3\n[matching]\ngeometry = \"fundamental\"\n");
    assert_eq!(matched("--params p.toml").geometry, Geometry::Fundamental, "it is named");
    home.run_well("probe demo --at 9,9 --params p.toml");
    write("[matching]\nratoi = 0.7\n");
    says(home.run_badly("match demo demo-later --out o --params p.toml", 2), &["line 2", "ratoi"]);
}

#[test]
fn the_merged_image_is_what_the_method_merge_searches() {
    let home = folder();
    let json = home.run_json("merge demo --out merged.tiff --json --frames 1..10");
    assert_eq!((&json["frames_used"], &json["reference"]), (&serde_json::json!([1, 10]), &"frame 5".into()));
    let ratio = json["merged_noise"].as_f64().expect("a number") / json["frame_noise"].as_f64().expect("a number");
    assert!(ratio < 0.5, "{ratio}");
    home.run_well("detect merged.tiff --method sift --out image --quiet");
    home.run_well("detect demo --method merge --frames 1..10 --out burst --quiet");
    let (image, burst) = (features(&home.join("image/merged.csv")), features(&home.join("burst/demo.csv")));
    assert!(image.len() > 50, "{}", image.len());
    assert_eq!(image.len(), burst.len());
    for (a, b) in image.iter().zip(&burst) {
        // The file does not say how finely its values are rounded, so its noise, and with it the SNR, differs slightly.
        let near = |(column, (a, b)): (usize, (&f64, &f64))| {
            a == b || a.is_nan() && b.is_nan() || (a - b).abs() < if column == 7 { 0.01 * b } else { 1e-4 }
        };
        assert!(a.iter().zip(b).enumerate().all(near), "{a:?} {b:?}");
    }
}

#[test]
fn a_pair_is_matched_alike_by_all_who_match_with_each_option_on_and_off() {
    let home = folder();
    let scene =
        "synth scene --out film --width 240 --height 180 --frames 14 --max-slope 1.5 --snr 1.2 --seed 4".words();
    home.run_well(&scene);
    for (name, first) in [("a", 0), ("b", 4), ("c", 7)] {
        let folder = home.join("nights").join(name);
        fs::create_dir_all(&folder).expect("made");
        for t in first..first + 7 {
            let frame = format!("frame_{t:03}.png");
            fs::copy(home.join("film").join(&frame), folder.join(&frame)).expect("copied");
        }
    }
    let monitor = Monitor::default();
    let params = DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 9), ..DetectorParams::default() };
    let source = DatasetSource::of_bursts(vec![home.join("nights")]);
    let files = source.bursts(&OpenOptions::default()).expect("three bursts");
    let bursts: Vec<Burst> = files.iter().map(|file| Burst::open(&file.paths[0]).expect("opened")).collect();
    let found: Vec<Detection> =
        bursts.iter().map(|burst| detect(burst, &params, &monitor).expect("detected")).collect();
    let of = |index: usize| DetectedBurst { burst: &bursts[index], params: &params, detection: &found[index] };
    let images = ImageKind::default();
    let job = FeatureJob { detector: params.clone().into(), open: OpenOptions::default(), images };
    let pairs = PairSelection::All.pairs(3);
    let searches = Searches { detector: params.clone(), slopes_1d: params.slopes, ..Searches::default() };
    let default = MatchParams::default;
    let options = [
        default(),
        MatchParams { align: false, ..default() },
        MatchParams { predict: false, ..default() },
        MatchParams { align: false, predict: false, ..default() },
        MatchParams { mutual: false, ..default() },
        MatchParams { ratio: 0.95, max_error_px: 3.0, ..default() },
        MatchParams { geometry: Geometry::Homography, seed: 3, ..default() },
        MatchParams { min_inliers: 60, align: false, ..default() },
    ];
    let mut all: Vec<Vec<MatchCounts>> = Vec::new();
    for (number, matching) in options.into_iter().enumerate() {
        // `match`, the window's two bursts, and Python.
        let pair =
            |&(a, b): &(usize, usize)| match_bursts([of(a), of(b)], &matching, &monitor).expect("matched").counts;
        let expected: Vec<MatchCounts> = pairs.iter().map(pair).collect();
        // `evaluate matches`, and the tables of `figures`.
        let methods = vec![BurstMethod::Buff1d];
        let (searches, of_study) = (searches.clone(), matching.clone());
        let all_pairs = PairSelection::All;
        let study =
            MatchStudy { methods, has_gold: false, searches, matching: of_study, pairs: all_pairs, truth: None };
        let names: Vec<String> = files.iter().map(|file| file.name.clone()).collect();
        let open = |k: usize, _: Shot| -> Result<Burst> { Ok(bursts[k].clone()) };
        let report = study.run(&names, open, &monitor).expect("studied");
        let counts: Vec<MatchCounts> = report.methods[0].by_pair.iter().map(|pair| pair.counts).collect();
        assert_eq!(counts, expected, "evaluate matches, {matching:?}");
        // `colmap`, whose solution is of all pairs together: of two bursts it is that of the pair.
        let cameras = BurstCameras::default();
        let job = ColmapJob { features: job.clone(), matching: matching.clone(), pairs: PairSelection::All, cameras };
        let mut store = FeatureStore::open(&home.join("two"), &job.features).expect("a folder");
        let report = export_colmap(&mut store, &files[..2], &job, &mut |_| {}, &monitor).expect("exported");
        // Files do not say which check a feature without a match failed.
        let in_files = |counts: &MatchCounts| MatchCounts { not_mutual: None, ..*counts };
        assert_eq!(report.pairs[0].counts, in_files(&expected[0]), "colmap of two, {matching:?}");
        assert_eq!(report.moved.is_some(), matching.align);
        let mut store = FeatureStore::open(&home.join("three"), &job.features).expect("a folder");
        let report = export_colmap(&mut store, &files, &job, &mut |_| {}, &monitor).expect("exported");
        let counts: Vec<MatchCounts> = report.pairs.iter().map(|pair| pair.counts).collect();
        if !matching.align {
            assert_eq!(counts, expected.iter().map(in_files).collect::<Vec<_>>(), "colmap of three, {matching:?}");
        }
        let in_memory = [of(0), of(1), of(2)];
        let again = export_detections(&home.join(format!("memory{number}")), &in_memory, &job, &monitor).expect("done");
        assert_eq!((again.pairs, again.moved), (report.pairs, report.moved), "{matching:?}");
        // The window's dataset, from the features in that folder.
        let mut of_window = vec![MatchCounts::default(); pairs.len()];
        let mut on = |pair: MatchedPair<'_>| {
            let index = pairs.iter().position(|of| *of == pair.indices).expect("a pair");
            of_window[index] = pair.aligned(&matching, &monitor)?.counts;
            Ok(())
        };
        let mut kept = KeptBursts { store: &store, bursts: &files, monitor: &monitor };
        match_pairs::<Error>(&pairs, &matching, &mut kept, &mut on, &monitor).expect("matched");
        assert_eq!(of_window, expected, "the window's dataset, {matching:?}");
        all.push(expected);
    }
    assert!(all.iter().enumerate().all(|(k, one)| k == 0 || *one != all[0]), "{all:?}");
    let inliers = |k: usize| all[k].iter().filter_map(|counts| counts.inliers).sum::<usize>();
    assert!(inliers(0) > 100, "the alignment leaves some out: {} {}", inliers(1), inliers(0));
    assert!(inliers(1) > inliers(0), "the alignment leaves some out: {} {}", inliers(1), inliers(0));
    let search = ["--slopes-u", "-2:2:9", "--json"];
    let told = home.run_json(&[&["evaluate", "matches", "nights", "--methods", "buff-1d"], &search[..]].concat());
    let pair = home.run_json(&[&["match", "nights/a", "nights/b", "--out", "m"], &search[..]].concat());
    for key in ["keypoints_a", "putative", "inliers"] {
        assert_eq!(told["methods"][0]["by_pair"][0][key], pair[key], "{key}");
    }
    assert_eq!((&told["matching"], pair["inliers"].as_u64()), (&pair["matching"], all[0][0].inliers.map(|n| n as u64)));
    assert!(told["methods"][0]["inlier_ratio"].is_number() && pair["inlier_ratio"].is_number());
    assert!(told["methods"][0]["precision"].is_null() && pair["precision"].is_null());
}

/// Every method sees the same noise of a burst, also where its pictures are opened again: that of written copies.
#[test]
fn noise_that_is_added_is_that_of_written_copies_for_each_method() {
    let home = two_bursts();
    home.make_dir("night");
    for name in ["a", "b"] {
        fs::rename(home.join(name), home.join("night").join(name)).expect("moved");
    }
    let noise = ["--snr", "2"];
    home.run_well(&[&["synth", "noisy", "night", "--out", "dark", "--seed", "3"], &noise[..]].concat());
    let counted = |methods: &str, more: &[&str]| {
        let line = [&["evaluate", "matches", "--slopes-u", "-2:2:9", "--json", "--methods", methods], more].concat();
        home.run_json(&line)["methods"].clone()
    };
    let added = [&["night", "--noise-seed", "3"], &noise[..]].concat();
    let methods = ["sift-frame", "sift-merge", "buff-1d"];
    let together = counted(&methods.join(","), &added);
    for (index, method) in methods.into_iter().enumerate() {
        assert_eq!(together[index], counted(method, &added)[0], "{method} alone, and after others");
    }
    assert_eq!(together[0], counted(methods[0], &["dark", "--gold", "night"])[0]);
}
