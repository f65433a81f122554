//! On to COLMAP, and back from it.

use super::support::{run_badly, run_well};
use std::fs;
use std::path::Path;

/// A reconstruction of four of five images: twice as large as the truth and moved, one camera 0.1 (of the truth's unit) too high.
fn model(folder: &Path) {
    fs::create_dir_all(folder).expect("made");
    let mut images = String::from("# images\n");
    for (id, centre) in [(1, [0.0, 0.0, 5.0]), (2, [2.0, 0.0, 5.0]), (4, [2.0, 2.0, 5.2]), (5, [0.0, 2.0, 5.0])] {
        // Cameras that are not turned: the translation is the centre's opposite.
        let [x, y, z] = centre;
        images += &format!("{id} 1 0 0 0 {} {} {} 1 image.{:04}.png\n1 1 1 2 2 -1 3 3 2\n", -x, -y, -z, 10 * id);
    }
    fs::write(folder.join("images.txt"), images).expect("written");
    fs::write(folder.join("points3D.txt"), "1 0 0 9 0 0 0 0.4 1 0 2 0 4 0 5 0\n2 0 0 9 0 0 0 0.6 1 2 2 2 4 2 5 2\n")
        .expect("written");
    fs::write(folder.join("cameras.txt"), "1 PINHOLE 640 480 500 500 320 240\n").expect("written");
}

const TRUTH: &str =
    "# t x y z qx qy qz qw\n10 0 0 0 0 0 0 1\n20 1 0 0 0 0 0 1\n30 2 0 0 0 0 0 1\n40 1 1 0 0 0 0 1\n50 0 1 0 0 0 0 1\n";

#[test]
fn a_models_poses_are_compared_with_the_truth() {
    let home = tempfile::tempdir().expect("a folder");
    let at = |name: &str| home.path().join(name);
    model(&at("sparse/0"));
    fs::write(at("truth.txt"), TRUTH).expect("written");
    let arguments = ["evaluate", "poses", "--estimate", "sparse", "--truth", "truth.txt"];
    let text = run_well(home.path(), &arguments);
    assert!(text.contains("4 of 5 images registered (80 %)"), "{text}");
    assert!(
        text.contains("2 3D points, 2.0 an image, seen in 4.00 images each, mean reprojection error 0.500 px"),
        "{text}"
    );
    assert!(text.contains("4 poses paired by time"), "{text}");
    let json = run_well(home.path(), &[&arguments[..], &["--json", "--step", "2"]].concat());
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let number = |path: &str| json.pointer(path).and_then(serde_json::Value::as_f64).expect(path);
    assert!((number("/scale") - 0.5).abs() < 0.01 && number("/images_pass_percent") == 80.0);
    // A plane through four corners of which one is 0.1 too high misses each by 0.025.
    let rmse = number("/absolute/translation/rmse");
    assert!((rmse - 0.025).abs() < 0.001, "{rmse}");
    assert_eq!((number("/relative/count"), json["pairs"][2]["label"].as_str()), (2.0, Some("image.0040.png")));
    // A model is a truth too: the gold standard. Against itself nothing is left over.
    let json = run_well(home.path(), &["evaluate", "poses", "--estimate", "sparse", "--truth", "sparse/0", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["associated"], "name");
    assert!(json["absolute"]["translation"]["max"].as_f64().is_some_and(|x| x < 1e-12), "{json}");
}

#[test]
fn poses_that_cannot_be_compared_say_why() {
    let home = tempfile::tempdir().expect("a folder");
    let at = |name: &str| home.path().join(name);
    model(&at("0"));
    let words = |arguments: &[&str], code| {
        run_badly(
            home.path(),
            &[&["evaluate", "poses", "--estimate", "0", "--truth", "truth.txt"], arguments].concat(),
            code,
        )
    };
    assert!(words(&[], 1).contains("truth.txt"));
    fs::write(at("truth.txt"), "1 2 3\n").expect("written");
    assert!(words(&[], 1).contains("line 1"));
    fs::write(at("truth.txt"), TRUTH).expect("written");
    assert!(words(&["--step", "0"], 2).contains("--step"));
    assert!(words(&["--associate", "luck"], 2).contains("name, time, order"));
    assert!(words(&["--associate", "name"], 1).contains("by name"));
    fs::write(at("truth.txt"), "10 1 1 1 0 0 0 1\n20 1 1 1 0 0 0 1\n40 1 1 1 0 0 0 1\n50 1 1 1 0 0 0 1\n")
        .expect("written");
    assert!(words(&[], 1).contains("all stand in one place"));
}
