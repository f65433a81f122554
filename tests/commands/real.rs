//! `detect` on real pictures, where they are installed; the folder's own notes describe them.

use crate::support::*;

/// Options of the paper's joint rule, which leaves few features at wrong slopes: with each slope for itself, bright
/// blobs also leave smeared features at other slopes.
const JOINT: &str = "--slope-extrema joint --distinct off --rules vlfeat --max-orientations 1 \
                     --peak-threshold 0.0003 --noise-gate strict";

#[needs::shared("data")]
#[test]
fn the_graffiti_burst_moves_by_one_pixel_to_the_right() {
    let data = shared("data");
    let home = folder();
    // In this order the motion is uniform.
    let frames: Vec<String> =
        [5, 1, 2, 4, 3].map(|k| data.join(format!("buff-demo-1d/{k}.png")).to_string_lossy().into_owned()).to_vec();
    let mut arguments = vec!["detect", "--slopes-u", "-2:2:5", "--out", "found"];
    arguments.extend(JOINT.words());
    arguments.extend(frames.iter().map(String::as_str));
    home.run_well(&arguments);
    let rows = features(&home.join("found/buff-demo-1d.csv"));
    let right = rows.iter().filter(|r| (r[4] - 1.0).abs() < 0.5 && r[5] == 0.0).count();
    assert!(rows.len() > 500 && right * 10 > rows.len() * 9, "{right} of {} features at slope (1, 0)", rows.len());
}

#[needs::shared("data")]
#[test]
fn the_eight_discs_have_their_true_slopes() {
    let data = shared("data");
    let home = folder();
    let input = data.join("buff-demo-2d");
    home.run_well(&[
        "detect",
        &input.to_string_lossy(),
        "--slopes-u",
        "-2:2:5",
        "--slopes-v",
        "-2:2:5",
        "--max-orientations",
        "1",
        "--out",
        "found",
    ]);
    let rows = features(&home.join("found/buff-demo-2d.csv"));
    let discs = &rows.iter().filter(|r| r[6] < 0.0).collect::<Vec<_>>()[..8];
    for (k, a) in discs.iter().enumerate() {
        discs[..k].iter().for_each(|b| assert!((a[0] - b[0]).hypot(a[1] - b[1]) > 8.0, "two features on one disc"));
    }
    for ((u, v), count) in [((1.0, -1.0), 3), ((-1.0, -1.0), 2), ((2.0, 2.0), 3)] {
        let near = discs.iter().filter(|r| (r[4] - u).abs() <= 0.5 && (r[5] - v).abs() <= 0.5).count();
        assert_eq!(near, count, "discs at slope ({u}, {v}): {discs:?}");
    }
}

#[needs::shared("data")]
#[test]
fn a_real_cameras_features_pile_up_at_its_motion() {
    let data = shared("data");
    let home = folder();
    let mut frames: Vec<String> = fs::read_dir(data.join("slider-far"))
        .expect("a folder")
        .map(|e| e.expect("an entry").path().to_string_lossy().into_owned())
        .filter(|p| p.ends_with(".png"))
        .collect();
    frames.sort();
    let mut arguments = vec!["detect", "--slopes-u", "-6:6:25", "--levels", "3", "--out", "found"];
    arguments.extend(JOINT.words());
    arguments.extend(frames[20..29].iter().map(String::as_str));
    home.run_well(&arguments);
    let rows = features(&home.join("found/slider-far.csv"));
    // The densest interval of slopes, half a pixel per frame wide.
    let near = |centre: f64| rows.iter().filter(|r| (r[4] - centre).abs() < 0.25).count();
    let (peak, count) =
        (-60..=60).map(|k| f64::from(k) * 0.1).map(|c| (c, near(c))).max_by_key(|x| x.1).expect("some slope");
    assert!((peak.abs() - 4.2).abs() < 0.35, "most slopes are near {peak}");
    let mirrored = near(-peak);
    assert!(count > 100 && count > 5 * mirrored, "{count} features near {peak}, {mirrored} near {}", -peak);
}
