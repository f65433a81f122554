//! `match` and `merge`: two bursts, and one image of a burst.

use super::support::{features, names, run_badly, run_well};
use std::path::Path;

/// Makes two noisy bursts of one scene: equal layers, other noise, and the second one begins three frames later.
fn two_bursts(home: &Path) {
    run_well(
        home,
        &[
            "synth",
            "scene",
            "--out",
            "film",
            "--width",
            "320",
            "--height",
            "240",
            "--frames",
            "12",
            "--max-slope",
            "1.5",
            "--snr",
            "3",
            "--seed",
            "4",
        ],
    );
    for (name, first) in [("a", 0), ("b", 5)] {
        std::fs::create_dir(home.join(name)).expect("made");
        for t in first..first + 7 {
            let frame = format!("frame_{t:03}.png");
            std::fs::copy(home.join("film").join(&frame), home.join(name).join(&frame)).expect("copied");
        }
    }
}

#[test]
fn two_bursts_are_matched_verified_and_drawn() {
    let home = tempfile::tempdir().expect("a folder");
    two_bursts(home.path());
    let search = ["--slopes-u", "-2:2:9", "--threads", "2"];
    let text = run_well(home.path(), &[&["match", "a", "b", "--out", "m"], &search[..]].concat());
    assert_eq!(names(&home.path().join("m")), ["a.csv", "a_b.matches.csv", "a_b.matches.png", "b.csv"]);
    assert!(text.contains("inliers") && text.contains("match score"), "{text}");

    let json = run_well(
        home.path(),
        &[&["match", "a", "b", "--out", "n", "--json", "--images", "merged", "--threads", "1"], &search[..2]].concat(),
    );
    let json: serde_json::Value = serde_json::from_str(&json).expect("one JSON document");
    let count = |key: &str| json[key].as_u64().unwrap_or_else(|| panic!("{key}")) as usize;
    let out = |file: &str| home.path().join("n").join(file);
    let (a, b) = (features(&out("a.csv")), features(&out("b.csv")));
    assert_eq!((count("keypoints_a"), count("keypoints_b")), (a.len(), b.len()));
    assert_eq!((json["command"].as_str(), json["a"]["features"].as_u64()), (Some("match"), Some(a.len() as u64)));

    let text = std::fs::read_to_string(out("a_b.matches.csv")).expect("a file");
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("a,b,u_a,v_a,u_b,v_b,distance,ratio,error_px,inlier,shift_u_b,shift_v_b,correlation")
    );
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|x| x.parse().expect("a number")).collect()).collect();
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
        // The max error of aligned matches, 0.35 times 4 px.
        assert!(row[9] == 0.0 || row[8] <= 1.4);
    }
    let score = json["match_score"].as_f64().expect("a number");
    let expected = 0.5 * (inliers as f64 / a.len() as f64 + inliers as f64 / b.len() as f64);
    assert!((score - expected).abs() < 1e-9);
    assert_eq!(
        (json["model"]["kind"].as_str(), json["model"]["matrix"][2].as_array().map(Vec::len)),
        (Some("fundamental"), Some(3))
    );

    let picture = image::open(out("a_b.matches.png")).expect("a picture").to_rgb8();
    assert_eq!(picture.width(), 2138, "181 mm with 300 pixels an inch");
    assert!(picture.pixels().any(|p| p.0 == burstscope::export::MatchKind::Inlier.color()), "the legend's line");
    // The number of threads changes nothing; --images changes the picture.
    let read = |folder: &str, file: &str| std::fs::read(home.path().join(folder).join(file)).expect("a file");
    assert_eq!(read("m", "a_b.matches.csv"), read("n", "a_b.matches.csv"));
    assert_ne!(read("m", "a_b.matches.png"), read("n", "a_b.matches.png"));
    figure_as_vectors(home.path(), &rows);
}

/// As SVG the figure has the names, the matches that were asked for, of the smallest distance, and their numbers.
fn figure_as_vectors(home: &Path, rows: &[Vec<f64>]) {
    let vectors = ["--picture", "svg", "--drawn", "40", "--width", "88", "--slopes-u", "-2:2:9"];
    run_well(home, &[&["match", "a", "b", "--out", "v"], &vectors[..]].concat());
    let svg = std::fs::read_to_string(home.join("v/a_b.matches.svg")).expect("a file");
    let mut nearest: Vec<&Vec<f64>> = rows.iter().collect();
    nearest.sort_by(|a, b| a[6].total_cmp(&b[6]));
    let inliers = nearest[..40].iter().filter(|row| row[9] == 1.0).count();
    let all = rows.iter().filter(|row| row[9] == 1.0).count();
    for text in ["(a) A: a · motion", "(b) B: b · motion", &format!("{inliers} of {all} inliers"), "of full scale"] {
        assert!(svg.contains(text), "{text}");
    }
    assert_eq!(svg.matches("class=\"match\"").count(), 40);
    assert!(!home.join("v/a_b.matches.png").exists());
}

#[test]
fn matches_may_stay_unverified_and_wrong_use_is_explained() {
    let home = tempfile::tempdir().expect("a folder");
    let json = run_well(
        home.path(),
        &["match", "demo", "demo", "--out", "m", "--geometry", "none", "--json", "--method", "sift"],
    );
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert!(json["inliers"].is_null() && json["match_score"].is_null() && json["model"].is_null());
    // A burst matched with itself: nearly every feature matches itself, except those that look alike.
    assert!(json["match_ratio"].as_f64().is_some_and(|x| x > 0.9), "{}", json["match_ratio"]);
    assert_eq!(
        names(&home.path().join("m")),
        ["demo.csv", "demo_2.csv", "demo_demo_2.matches.csv", "demo_demo_2.matches.png"]
    );
    let text = std::fs::read_to_string(home.path().join("m/demo_demo_2.matches.csv")).expect("a file");
    assert!(text.lines().skip(1).all(|line| line.ends_with(",nan,nan")));
    let cases: [(&[&str], i32, &str); 8] = [
        (&["match", "demo", "demo", "--out", "x", "--drawn", "0"], 2, "give 'all' or"),
        (&["match", "demo", "demo", "--out", "x", "--width", "3"], 2, "88 for one column"),
        (&["match", "demo", "--out", "x"], 2, "<B>"),
        (&["match", "demo", "demo"], 2, "--out"),
        (&["match", "demo", "demo", "--out", "x", "--ratio", "2"], 2, "0.8 is usual"),
        (&["match", "demo", "demo", "--out", "x", "--geometry", "essential"], 2, "intrinsics"),
        (&["match", "demo", "gone", "--out", "x", "--method", "sift"], 1, "gone"),
        (&["merge", "demo", "--out", "x.png"], 2, ".tiff"),
    ];
    for (arguments, code, words) in cases {
        let error = run_badly(home.path(), arguments, code);
        assert!(error.contains(words), "{arguments:?}: {error}");
    }
}

#[test]
fn the_merged_image_is_what_the_method_merge_searches() {
    let home = tempfile::tempdir().expect("a folder");
    let json = run_well(home.path(), &["merge", "demo", "--out", "merged.tiff", "--json", "--frames", "1..10"]);
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!((&json["frames_used"], &json["reference"]), (&serde_json::json!([1, 10]), &"frame 5".into()));
    let ratio = json["merged_noise"].as_f64().expect("a number") / json["frame_noise"].as_f64().expect("a number");
    assert!(ratio < 0.5, "{ratio}");
    run_well(home.path(), &["detect", "merged.tiff", "--method", "sift", "--out", "image", "--quiet"]);
    run_well(home.path(), &["detect", "demo", "--method", "merge", "--frames", "1..10", "--out", "burst", "--quiet"]);
    let (image, burst) =
        (features(&home.path().join("image/merged.csv")), features(&home.path().join("burst/demo.csv")));
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
