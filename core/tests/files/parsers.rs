//! All readers of a text or a table that somebody else may have written, with randomly damaged input: the result is a
//! valid value or an error with a message, never a panic, and never takes much time or memory.
//!
//! `PROPTEST_CASES` sets the number of inputs of each test (256 without it); docs/FUZZING.md lists the runs. Files of
//! frames have similar tests in `opening/fuzz.rs`, lessons and sessions in `tests/commands/lessons_and_sessions.rs` of
//! the program.

use crate::damage::{absurd_tomls, damage, damaged, damaged_text, says_something};
use crate::prelude::*;
use burstscope_core::dataset::camera::read_camera;
use burstscope_core::export::case::{self, Case, Enclosed, read_case, write_case};
use burstscope_core::export::{parse_colmap, read_features_csv, write_colmap, write_csv};
use burstscope_core::inspect::result::{read_features, read_truth};
use burstscope_lab::evaluate::{accuracy::stands_apart, poses::read_sparse_model, poses::read_trajectory};
use burstscope_lab::synth::{ChartParams, synth_chart, write_burst};
use std::sync::OnceLock;

/// Writes a file of this name with these bytes into the test's own folder.
fn file(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).expect("written");
    path
}

macro_rules! folder {
    () => {{
        static FOLDER: OnceLock<Folder> = OnceLock::new();
        FOLDER.get_or_init(folder)
    }};
}

/// Sound files of a small burst with known truth: its truth, its features in both formats, and a case of it.
struct Sound {
    case: Vec<u8>,
    truth: Vec<u8>,
    csv: Vec<u8>,
    colmap: String,
}

fn sound() -> &'static Sound {
    static SOUND: OnceLock<Sound> = OnceLock::new();
    SOUND.get_or_init(|| {
        let home = folder();
        let params = ChartParams { width: 96, height: 80, discs: 4, frames: 3, snr: 20.0, ..ChartParams::default() };
        let params = ChartParams { radius: 4.0..=6.0, max_slope: 1.0, ..params };
        let (burst, truth) = synth_chart(&params, &quiet()).expect("a chart");
        let folder = home.join("chart");
        write_burst(&folder, &burst, &truth, &quiet()).expect("written");
        let search = DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 3), ..DetectorParams::default() };
        let mut detection = detect(&burst, &search, &quiet()).expect("features");
        detection.features.truncate(3);
        detection.descriptors.truncate(3);
        let (csv, colmap) = (home.join("f.csv"), home.join("f.txt"));
        write_csv(&csv, &detection.features, None).expect("written");
        write_colmap(&colmap, &detection.features, &detection.descriptors).expect("written");
        let read = |path: &Path| fs::read(path).expect("read");
        let colmap = String::from_utf8(read(&colmap)).expect("text");
        let (of_case, whole) = (home.join("a.burstcase"), (None, None));
        let (case, part) = Case::of(&burst, &search.into(), whole, "", &quiet()).expect("a case");
        let enclosed = Enclosed { session: Some("version = 3\n".repeat(20)), truth: Some(truth) };
        write_case(&of_case, (&case, &part), &enclosed, &quiet()).expect("written");
        Sound { case: read(&of_case), truth: read(&folder.join("truth.json")), csv: read(&csv), colmap }
    })
}

const CAMERA: &str =
    "model = \"OPENCV\"\nwidth = 640\nheight = 480\nparams = [500.0, 501.0, 320.0, 240.0, 0.1, -0.02, 0.0, 1e-4]\n";

const TRAJECTORY: &str =
    "# time x y z qx qy qz qw\n0.5 1 2 3 0 0 0 1\n1.5,0,0,0.25,0,0,0.7071068,0.7071068\n2.5 1 1 1 0 1 0 0\n";

const IMAGES: &str = "# Image list\n3 1 0 0 0 1 2 3 1 a/second one.png\n10.5 20.5 7 11 21 -1 12 22 8\n2 0.7071067811865476 0 0 0.7071067811865476 1 0 0 1 first.png\n\n";

const POINTS: &str = "# 3D points\n7 1 2 3 255 0 0 0.5 3 0 2 5\n8 1 2 4 0 0 0 1.5 3 2 2 1 5 9 4 4\n";

/// A sparse model of COLMAP in binary: two images, two points.
fn binary_model() -> (Vec<u8>, Vec<u8>) {
    let mut images = 2u64.to_le_bytes().to_vec();
    for (id, name, points) in [(3u32, "a/second.png", vec![7u64, u64::MAX]), (2, "first.png", vec![])] {
        images.extend(id.to_le_bytes());
        [1.0f64, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0].iter().for_each(|x| images.extend(x.to_le_bytes()));
        images.extend(1u32.to_le_bytes());
        images.extend(name.as_bytes());
        images.push(0);
        images.extend((points.len() as u64).to_le_bytes());
        for point in points {
            [10.5f64, 20.5].iter().for_each(|x| images.extend(x.to_le_bytes()));
            images.extend(point.to_le_bytes());
        }
    }
    let mut points = 2u64.to_le_bytes().to_vec();
    for (id, track) in [(7u64, vec![(3u32, 0u32), (2, 5)]), (8, vec![(3, 2)])] {
        points.extend(id.to_le_bytes());
        [1.0f64, 2.0, 3.0].iter().for_each(|x| points.extend(x.to_le_bytes()));
        points.extend([255, 0, 0]);
        points.extend(0.5f64.to_le_bytes());
        points.extend((track.len() as u64).to_le_bytes());
        for (image, keypoint) in track {
            points.extend(image.to_le_bytes());
            points.extend(keypoint.to_le_bytes());
        }
    }
    (images, points)
}

/// Undamaged inputs are read: the tests below start from sound ones.
#[test]
fn sound_inputs_are_read() {
    let folder = folder!();
    assert!(read_camera(&file(folder, "camera.toml", CAMERA.as_bytes())).is_ok());
    assert!(read_truth(&file(folder, "truth.json", &sound().truth)).is_ok());
    assert!(read_case(&file(folder, "a.burstcase", &sound().case), &Limits::default(), &quiet()).is_ok());
    assert_eq!(read_features_csv(&file(folder, "f.csv", &sound().csv)).expect("features").len(), 3);
    assert_eq!(parse_colmap(Path::new("f.txt"), &sound().colmap).expect("features").0.len(), 3);
    assert_eq!(read_trajectory(&file(folder, "poses.txt", TRAJECTORY.as_bytes())).expect("poses").poses.len(), 3);
    param_files().into_iter().for_each(|text| assert!(SearchParams::from_toml(&text).is_ok(), "{text}"));
    for extension in ["txt", "bin"] {
        let folder = folder.join(extension);
        fs::create_dir_all(&folder).expect("made");
        let (images, points) = model_files(extension);
        file(&folder, &format!("images.{extension}"), &images);
        file(&folder, &format!("points3D.{extension}"), &points);
        assert_eq!(read_sparse_model(&folder).expect("a model").images.len(), 2);
    }
}

fn param_files() -> [String; 2] {
    let given = Slopes::Given(SlopeGrid::line(-2.0..=2.0, 5));
    let line = Slopes::Auto { direction_deg: Some(30.0) };
    [given, line].map(|slopes| SearchParams { slopes, ..SearchParams::default() }.to_toml())
}

fn model_files(extension: &str) -> (Vec<u8>, Vec<u8>) {
    if extension == "txt" { (IMAGES.into(), POINTS.into()) } else { binary_model() }
}

#[test]
fn any_number_of_a_parameter_file_is_refused_by_its_name_or_does_no_harm() {
    let slopes = Slopes::Given(SlopeGrid::plane(-1.0..=1.0, 3, -1.0..=0.0, 2));
    let small = SearchParams { slopes, octaves: 1, max_features: 5, ..SearchParams::default() };
    let chart = ChartParams { width: 64, height: 48, discs: 1, frames: 3, radius: 4.0..=5.0, ..ChartParams::default() };
    let (burst, _) = synth_chart(&ChartParams { max_slope: 1.0, snr: 20.0, ..chart }, &quiet()).expect("a chart");
    let (mut refused, mut taken) = (0, 0);
    let file = small.to_toml();
    let gates = ["noise_gate = 4.0", "distinct = 2.0"];
    let numbers = gates.iter().fold(file, |file, gate| {
        let key = gate.split(' ').next().expect("a key");
        let of_key = |line: &&str| line.starts_with(key) && line[key.len()..].trim_start().starts_with('=');
        let old = file.lines().find(of_key).expect("a line").to_owned();
        file.replacen(&old, gate, 1)
    });
    for (path, text, value) in absurd_tomls(&numbers) {
        match SearchParams::from_toml(&text) {
            Err(error) => {
                refused += 1;
                let named = path.split('.').any(|key| error.replace('-', "_").contains(key)) || error.contains("slope");
                assert!(named && says_something(&error), "{path} = {value}: {error}");
            }
            Ok(params) => {
                taken += 1;
                if let Err(error) = detect(&burst, &params.at_given(), &quiet()) {
                    assert!(says_something(&error.to_string()), "{path} = {value}: {error}");
                }
            }
        }
    }
    assert!(refused > 60 && taken > 15, "{refused} {taken}");
}

#[test]
fn any_number_of_a_truth_is_refused_by_its_name_or_does_no_harm() {
    let text = std::str::from_utf8(&sound().truth).expect("text");
    let whole: serde_json::Value = serde_json::from_str(text).expect("JSON");
    let whole = toml::to_string(&without_nulls(whole)).expect("plain values");
    let (mut refused, mut taken) = (Vec::new(), 0);
    for (path, changed, value) in absurd_tomls(&whole) {
        let changed: toml::Value = toml::from_str(&changed).expect("TOML");
        let json = serde_json::to_vec(&changed).expect("plain values");
        match read_truth(&file(folder!(), "truth.json", &json)) {
            Err(error) => {
                let words = error.to_string();
                assert!(words.contains("truth.json") && says_something(&words), "{path} = {value}: {words}");
                refused.push((path, value, words));
            }
            Ok(truth) => {
                taken += 1;
                assert!(truth.frames <= 1_000_000, "{path} = {value}");
                assert!(
                    truth.features.iter().filter(|disc| stands_apart(disc, &truth)).count() <= truth.features.len()
                );
            }
        }
    }
    assert!(refused.len() > 100 && taken > 20, "{} {taken}", refused.len());
    let said = refused.iter().find(|(path, value, _)| path == "frames" && value == "1000000000").expect("too many");
    assert!(said.2.contains("frames is 1000000000, which is not in the range of 1 to 1000000"), "{}", said.2);
}

/// The value without what has none, which TOML does not hold.
fn without_nulls(value: serde_json::Value) -> serde_json::Value {
    match value {
        serde_json::Value::Object(all) => all
            .into_iter()
            .filter(|(_, value)| !value.is_null())
            .map(|(key, value)| (key, without_nulls(value)))
            .collect(),
        serde_json::Value::Array(all) => all.into_iter().map(without_nulls).collect(),
        value => value,
    }
}

proptest! {
    #[test]
    fn parameters(which in 0..2usize, damages in damage()) {
        static FILES: OnceLock<[String; 2]> = OnceLock::new();
        match SearchParams::from_toml(&damaged_text(&FILES.get_or_init(param_files)[which], &damages)) {
            Ok(params) => {
                prop_assert_eq!(params.validate(), Ok(()));
                // Parameters that were read can be written and read again.
                let again = SearchParams::from_toml(&params.to_toml());
                prop_assert!(again.is_ok(), "{:?}: {:?}", params, again);
            }
            Err(error) => prop_assert!(says_something(&error)),
        }
    }

    #[test]
    fn cameras(damages in damage()) {
        match read_camera(&file(folder!(), "camera.toml", &damaged(CAMERA.as_bytes(), &damages))) {
            Ok(camera) => prop_assert!(camera.validate("camera").is_ok()),
            Err(error) => prop_assert!(says_something(&error)),
        }
    }

    #[test]
    fn rotations(damages in damage()) {
        let folder = folder!();
        file(folder, "camera.toml", b"model = \"SIMPLE_PINHOLE\"\nwidth = 16\nheight = 12\nparams = [20.0, 8.0, 6.0]\n");
        let list = file(folder, "turns.csv", &damaged(b"#t,x,y,z,qw,qx,qy,qz\n1,0,0,0,1,0,0,0\n2,0,0,0,0.8,0.6,0,0\n", &damages));
        let frames: Vec<PathBuf> = (0..2).map(|t| folder.join(format!("turned_{t}.pgm"))).collect();
        frames.iter().for_each(|frame| fs::write(frame, [&b"P5 16 12 255\n"[..], &[7; 16 * 12]].concat()).expect("written"));
        let options = OpenOptions { rotations: Some(list), ..OpenOptions::default() };
        match Burst::open_with(&frames, &options, &quiet()) {
            Ok(burst) => prop_assert!(burst.frames.iter().all(|frame| frame.data().iter().all(|x| x.is_finite()))),
            Err(error) => prop_assert!(says_something(&error)),
        }
    }

    #[test]
    fn truths(damages in damage()) {
        if let Err(error) = read_truth(&file(folder!(), "truth.json", &damaged(&sound().truth, &damages))) {
            prop_assert!(error.to_string().contains("truth.json"));
        }
    }

    #[test]
    fn cases(damages in damage()) {
        let path = file(folder!(), "a.burstcase", &damaged(&sound().case, &damages));
        let others = [case::read_session(&path).err(), case::read_truth(&path).err()];
        prop_assert!(others.iter().flatten().all(|error| error.to_string().contains("a.burstcase")));
        match read_case(&path, &Limits::default(), &quiet()) {
            Ok((read, burst)) => prop_assert_eq!(burst.len(), read.frames),
            Err(error) => prop_assert!(error.to_string().contains("a.burstcase")),
        }
    }

    #[test]
    fn features_as_csv(damages in damage()) {
        match read_features_csv(&file(folder!(), "f.csv", &damaged(&sound().csv, &damages))) {
            Ok(features) => prop_assert!(features.len() <= 3 + 4),
            Err(error) => prop_assert!(error.to_string().contains("f.csv")),
        }
    }

    #[test]
    fn features_of_others(which in any::<bool>(), damages in damage()) {
        let bytes = if which { &sound().csv[..] } else { sound().colmap.as_bytes() };
        if let Err(error) = read_features(&file(folder!(), "theirs", &damaged(bytes, &damages))) {
            prop_assert!(error.to_string().contains("theirs"));
        }
    }

    #[test]
    fn features_as_colmap_text(damages in damage()) {
        match parse_colmap(Path::new("f.txt"), &damaged_text(&sound().colmap, &damages)) {
            Ok((keypoints, descriptors)) => {
                prop_assert_eq!(keypoints.len(), descriptors.len());
                prop_assert!(keypoints.iter().all(|k| [k.x, k.y, k.scale, k.orientation].iter().all(|x| x.is_finite())));
            }
            Err(error) => prop_assert!(error.to_string().contains("f.txt")),
        }
    }

    #[test]
    fn trajectories(damages in damage()) {
        match read_trajectory(&file(folder!(), "poses.txt", &damaged(TRAJECTORY.as_bytes(), &damages))) {
            Ok(read) => {
                let finite = |pose: &burstscope_lab::evaluate::poses::Pose| {
                    pose.world_from_camera.translation.vector.iter().all(|x| x.is_finite())
                };
                prop_assert!(read.poses.iter().all(finite));
            }
            Err(error) => prop_assert!(error.to_string().contains("poses.txt")),
        }
    }

    #[test]
    fn sparse_models(binary in any::<bool>(), damage_images in damage(), damage_points in damage()) {
        let extension = if binary { "bin" } else { "txt" };
        let folder = folder!().join(extension);
        fs::create_dir_all(&folder).expect("made");
        let (images, points) = model_files(extension);
        file(&folder, &format!("images.{extension}"), &damaged(&images, &damage_images));
        file(&folder, &format!("points3D.{extension}"), &damaged(&points, &damage_points));
        match read_sparse_model(&folder) {
            Ok(model) => prop_assert!(model.images.len() < 200 && model.points.len() < 200),
            Err(error) => prop_assert!(says_something(&error)),
        }
    }
}
