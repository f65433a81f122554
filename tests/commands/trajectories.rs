//! `synth trajectory`: bursts, poses and lens that the other commands take.

use crate::support::*;

const SMALL: &str = "synth trajectory --out way --width 240 --height 180 --bursts 3 --frames 5 --max-slope 2";

fn truth(folder: &Path) -> Value {
    let text = fs::read_to_string(folder.join("trajectory.json")).expect("a file");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn a_trajectory_is_bursts_gold_poses_and_a_lens() {
    let home = folder();
    says(home.run_well(SMALL), &["3 bursts of 5 frames of 240×180, 4 planes, SNR 0.30 ("]);
    let way = home.join("way");
    assert_eq!(names(&way), [".burstscope.json", "bursts", "gold", "lens.toml", "poses.txt", "trajectory.json"]);
    assert_eq!(names(&way.join("bursts")), ["burst_000", "burst_001", "burst_002"]);
    assert_eq!(names(&way.join("gold")), ["burst_000.png", "burst_001.png", "burst_002.png"]);
    let truth = truth(&way);
    let burst = Burst::open(way.join("bursts/burst_001")).expect("it opens");
    assert_eq!((burst.len(), burst.size()), (5, (240, 180)));
    // The mean of a burst is the mean of its gold view, in the same exposure.
    let gold = Burst::open(way.join("gold/burst_001.png")).expect("it opens");
    let mean = |burst: &Burst| {
        let values = burst.frames.iter().flat_map(|frame| frame.data());
        values.map(|&x| f64::from(x)).sum::<f64>() / (burst.len() * 240 * 180) as f64
    };
    let number = |path: &str| truth.pointer(path).and_then(Value::as_f64).expect(path);
    let expected = number("/black_level") + mean(&gold) * number("/white") / number("/gold_white");
    let noise = number("/noise/sigma_background");
    assert!((mean(&burst) - expected).abs() < 0.05 * noise, "{} for {expected}", mean(&burst));
}

#[test]
fn its_poses_and_its_lens_are_read_back() {
    let home = folder();
    home.run_well(&[&SMALL.words()[..], &["--snr", "5"]].concat());
    // The truth against itself: every pose is paired, and there are no errors.
    let poses = ["evaluate", "poses", "--estimate", "way/poses.txt", "--truth", "way/poses.txt", "--json"];
    let report = home.run_json(&poses);
    assert_eq!(report["pairs"].as_array().map(Vec::len), Some(3));
    assert!(report["absolute"]["translation"]["max"].as_f64().is_some_and(|x| x < 1e-9), "{report}");
    // An estimate that names images, as COLMAP's, is paired with the poses by the bursts' numbers.
    let lines = home.text("way/poses.txt");
    let mut images = String::new();
    for (id, line) in lines.lines().filter(|line| !line.starts_with('#')).enumerate() {
        let n: Vec<f64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
        // COLMAP writes the transform from world to camera. Only the centres count here, so no camera is rotated.
        images +=
            &format!("{} 1 0 0 0 {} {} {} 1 burst_{:03}.png\n1 1 -1\n", id + 1, -n[1], -n[2], -n[3], n[0] as usize);
    }
    home.make_dir("model");
    home.write("model/images.txt", images);
    home.write("model/points3D.txt", "");
    home.write("model/cameras.txt", "1 PINHOLE 240 180 216 216 120 90\n");
    let poses = "evaluate poses --estimate model --truth way/poses.txt --json";
    let report = home.run_json(poses);
    assert_eq!((&report["associated"], report["pairs"].as_array().map(Vec::len)), (&"time".into(), Some(3)));
    assert!(report["absolute"]["translation"]["max"].as_f64().is_some_and(|x| x < 1e-6), "{report}");
    // The lens is the camera that COLMAP's database is given.
    let colmap = "colmap way/bursts --camera way/lens.toml --slopes-u -2:2:5 --out rec --json";
    let report = home.run_json(colmap);
    assert_eq!(report["known_camera"], true);
    assert_eq!(report["cameras"][0]["model"], "PINHOLE");
    assert_eq!(report["cameras"][0]["params"], truth(&home.join("way"))["camera_params"]);
    let inliers = |pair: &Value| pair["inliers"].as_u64().unwrap_or(0);
    let pairs = report["pairs"].as_array().expect("pairs");
    assert!(pairs.iter().all(|pair| inliers(pair) >= 30), "{pairs:?}");
}

#[test]
fn wrong_use_says_what_would_be_right() {
    let home = folder();
    for (arguments, words) in [
        (&["--snr", "1", "--electrons", "2"][..], "cannot be used with"),
        (&["--electrons", "0"], "--electrons: 0; give a number above 0"),
        (&["--bursts", "0"], "--bursts: 0 bursts; give 1 to 1000"),
        (&["--planes", "99"], "--planes: 99 planes; give 1 to 16"),
        (&["--motion", "3d"], "1d, 2d"),
    ] {
        says(home.run_badly(&[&SMALL.words()[..8], arguments].concat(), 2), &[words]);
    }
    home.make_dir("way");
    home.write("way/thesis.txt", "precious");
    assert!(home.run_badly(SMALL, 1).contains("way"));
    assert_eq!(names(&home.join("way")), ["thesis.txt"]);
}

#[test]
fn matches_are_judged_by_true_poses() {
    let home = folder();
    home.run_well(&[&SMALL.words()[..], &["--snr", "5"]].concat());
    let study = ["evaluate", "matches", "way/bursts", "--methods", "buff-1d", "--slopes-u", "-2:2:5"];
    let truth = ["--by", "angle", "--truth", "way/poses.txt"];
    let camera = ["--camera", "way/lens.toml"];
    let report = home.run_json(&[&study[..], &truth, &camera, &["--json"]].concat());
    let rows = report["truth"]["by_angle"].as_array().expect("bins");
    let sum = |name: &str| rows.iter().filter_map(|row| row[name].as_u64()).sum::<u64>();
    assert_eq!(sum("pairs"), 3);
    // In good light almost all inliers are right, and poses alone say nothing of what both cameras see.
    assert!(sum("right") as f64 > 0.8 * sum("matches") as f64, "{rows:?}");
    assert!(rows.iter().all(|row| row["seen_by_both"].is_null()), "{rows:?}");
    // Poses that are mixed up make the same matches wrong.
    let poses = home.text("way/poses.txt");
    let turned = |line: &str| {
        line.split(' ').enumerate().map(|(k, word)| if k == 2 { "9" } else { word }).collect::<Vec<_>>().join(" ")
    };
    let mixed: Vec<String> =
        poses.lines().enumerate().map(|(k, line)| if k % 2 == 1 { turned(line) } else { line.into() }).collect();
    home.write("mixed.txt", mixed.join("\n"));
    let truth = ["--by", "angle", "--truth", "mixed.txt"];
    let mixed = home.run_json(&[&study[..], &truth, &camera, &["--json"]].concat());
    let right = |report: &Value| {
        let pairs = report["methods"][0]["by_pair"].as_array().expect("pairs");
        pairs.iter().filter_map(|pair| pair["right"].as_u64()).sum::<u64>()
    };
    assert!(2 * right(&mixed) < right(&report), "{} of {}", right(&mixed), right(&report));
    for (more, words) in
        [(&["--by", "angle"][..], "--truth"), (&["--by", "angle", "--truth", "way/poses.txt"], "camera: ")]
    {
        says(home.run_badly(&[&study[..], more].concat(), 2), &[words]);
    }
}

#[test]
fn methods_are_compared_on_a_trajectory() {
    let home = folder();
    home.run_well(&[&SMALL.words()[..], &["--snr", "1"]].concat());
    let study = "evaluate matches way/bursts --gold way/gold";
    let report = home.run_json(&format!("{study} --json"));
    let rows = report["methods"].as_array().expect("rows");
    let methods: Vec<&str> = rows.iter().filter_map(|row| row["method"].as_str()).collect();
    // Without a range of slopes each burst's are found.
    assert_eq!(methods, ["gold", "sift-frame", "sift-merge", "buff-auto"]);
    let found = rows[3]["slopes_found"].as_array().expect("a grid for each burst");
    assert_eq!(found.len(), 3);
    assert!(found.iter().all(|grid| grid["u"]["count"].as_u64().is_some_and(|n| n > 1)), "{found:?}");
    assert!(rows[..3].iter().all(|row| row["slopes_found"].is_null()));
    let inliers = |row: usize| rows[row]["inliers_per_image"].as_f64().expect("a number");
    assert!(inliers(3) > 2.0 * inliers(1), "{} and {} of one frame", inliers(3), inliers(1));
    let text = home.run_well(&format!("{study} --slopes auto --methods buff-auto"));
    assert!(text.contains("slopes found (min:max:count, px/frame)\n  burst_000: u "), "{text}");
    let text = home.run_well(&format!("{study} --slopes-u -2:2:5 --methods buff-1d"));
    assert!(text.contains("slopes of BuFF 1D u -2:2:5 v 0:0:1") && !text.contains("BuFF 2D"), "{text}");
    let error = home.run_badly(&format!("{study} --slopes auto --methods sift-merge,buff-1d"), 2);
    assert!(error.contains("--slopes: ") && error.contains("buff-auto"), "{error}");
}
