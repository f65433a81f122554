//! Poses: the alignment of trajectories and the planes in which they are drawn, pairs of poses, trajectory files, and
//! sparse models.

use crate::prelude::*;
use burstscope_core::error::Result;
use burstscope_lab::evaluate::poses::tum::{parse_tum, read_tum};
use burstscope_lab::evaluate::poses::{
    Alignment, Association, Pairing, PlaneAxes, Pose, Projection, Similarity, SparseModel, align, associate,
    read_sparse_model,
};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::FRAC_PI_2;

fn pose(centre: [f64; 3], axis_angle: [f64; 3]) -> Isometry3<f64> {
    Isometry3::new(Vector3::from(centre), Vector3::from(axis_angle))
}

#[test]
fn no_mirror_lays_on_a_mirrored_estimate_and_cameras_on_a_rail_turn_by_where_they_look() {
    let centres = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
    let truth = centres.map(|c| pose(c, [0.0; 3]));
    let mirror = centres.map(|[x, y, z]| pose([-x, y, z], [0.0; 3]));
    let Alignment { straight, truth_from_estimate } = align(&mirror, &truth).expect("aligned");
    let rotation = truth_from_estimate.rotation;
    assert!(!straight && (rotation.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-12);
    // The cameras look along the world's y; the estimate's world is turned by 1.1 about the rail.
    let roll = UnitQuaternion::new(Vector3::x() * 1.1);
    let looks = UnitQuaternion::new(Vector3::new(-FRAC_PI_2, 0.0, 0.0));
    let truth = [0.0, 1.0, 2.5].map(|x| Isometry3::from_parts(Translation3::new(x, 0.0, 0.0), looks));
    let estimate = truth.map(|t| Isometry3::from_parts(t.translation, roll * t.rotation));
    let alignment = align(&estimate, &truth).expect("aligned");
    assert!(alignment.straight);
    for (e, t) in estimate.iter().zip(&truth) {
        let laid = alignment.truth_from_estimate.apply(e);
        assert!((laid.translation.vector - t.translation.vector).norm() < 1e-12);
        assert!(laid.rotation.angle_to(&t.rotation) < 1e-7);
    }
}

#[test]
fn what_cannot_be_aligned_says_why() {
    let here = pose([1.0, 2.0, 3.0], [0.0; 3]);
    let there = pose([4.0, 2.0, 3.0], [0.0; 3]);
    let words = |estimate: &[_], truth: &[_]| align(estimate, truth).expect_err("degenerate").to_string();
    assert!(words(&[here], &[here]).contains("two or more"));
    assert!(words(&[here, here], &[here, there]).contains("estimated cameras all stand in one place"));
    assert!(words(&[here, there], &[here, here]).contains("true cameras all stand in one place"));
    // One trajectory goes back and forth twice while the other goes once.
    let line = |xs: [f64; 4]| xs.map(|x| pose([x, 0.0, 0.0], [0.0; 3]));
    assert!(words(&line([-1.0, 1.0, -1.0, 1.0]), &line([-1.0, -1.0, 1.0, 1.0])).contains("independently"));
}

proptest! {
    #[test]
    fn any_similarity_is_found_again(
        centres in prop::collection::vec(prop::array::uniform3(-10.0f64..10.0), 3..12),
        turns in prop::array::uniform3(-3.0f64..3.0),
        move_by in prop::array::uniform3(-100.0f64..100.0),
        scale in 0.01f64..100.0,
    ) {
        let truth: Vec<_> = centres.iter().map(|&c| pose(c, [c[1] * 0.1, c[0] * 0.2, c[2] * 0.1])).collect();
        let rotation = UnitQuaternion::new(Vector3::from(turns) * 0.6);
        let there = Similarity { scale, rotation, translation: Vector3::from(move_by) };
        let estimate: Vec<_> = truth.iter().map(|t| there.apply(t)).collect();
        let middle = truth.iter().map(|t| t.translation.vector).sum::<Vector3<f64>>() / truth.len() as f64;
        prop_assume!(truth.iter().any(|t| (t.translation.vector - middle).norm() > 0.05));
        let alignment = align(&estimate, &truth).expect("aligned");
        for (e, t) in estimate.iter().zip(&truth) {
            let laid = alignment.truth_from_estimate.apply(e);
            prop_assert!((laid.translation.vector - t.translation.vector).norm() < 1e-6, "{alignment:?}");
            prop_assert!(laid.rotation.angle_to(&t.rotation) < 1e-4, "{alignment:?}");
        }
    }
}

#[test]
fn the_principal_plane_shows_the_way_and_a_free_view_begins_as_the_cameras_look_and_goes_around() {
    // Along (−1, 0, −1) mostly, then along y.
    let centres = (0..9).map(|k| k as f64).map(|k| [-k, 0.1 * (k - 4.0).powi(2), -k]);
    let axes = Projection::Principal.axes(&centres.map(|centre| pose(centre, [0.0; 3])).collect::<Vec<_>>());
    let half = 0.5f64.sqrt();
    assert!((axes.right - Vector3::new(half, 0.0, half)).norm() < 1e-9, "{axes:?}");
    assert!((axes.up - Vector3::y()).norm() < 1e-9);
    assert!((axes.project([-1.0, 2.0, -1.0])[0] + 2.0f64.sqrt()).abs() < 1e-9);
    // The cameras look along −z: a half turn about y puts x to the left in the world.
    let cameras = [0.0, 1.0].map(|x| pose([x, 0.0, 0.0], [0.0, 2.0 * FRAC_PI_2, 0.0]));
    let axes = Projection::Free.axes(&cameras);
    let near = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() < 1e-9;
    assert!(near(axes.right, -Vector3::x()) && near(axes.up, -Vector3::y()) && near(axes.ahead(), -Vector3::z()));
    // From the right the viewer looks to the left; from above it looks down.
    assert!(near(axes.turned(90.0, 0.0).ahead(), -axes.right));
    assert!(near(axes.turned(0.0, 90.0).ahead(), -axes.up) && near(axes.turned(0.0, 90.0).up, axes.ahead()));
}

proptest! {
    #[test]
    fn axes_are_of_length_one_and_at_right_angles(centres in prop::collection::vec(prop::array::uniform3(-1e6f64..1e6), 0..9)) {
        let cameras: Vec<_> = centres.iter().map(|&c| pose(c, c)).collect();
        for projection in [Projection::Principal, Projection::Free] {
            let PlaneAxes { right, up } = projection.axes(&cameras).turned(30.0, 20.0);
            prop_assert!((right.norm() - 1.0).abs() < 1e-9 && (up.norm() - 1.0).abs() < 1e-9 && right.dot(&up).abs() < 1e-9);
        }
    }
}

fn named_pose(label: &str, order: u32, time: Option<f64>) -> Pose {
    Pose { label: label.to_owned(), order, time, world_from_camera: Isometry3::identity() }
}

fn named(names: &[&str]) -> Vec<Pose> {
    names.iter().enumerate().map(|(k, name)| named_pose(name, k as u32, None)).collect()
}

fn timed(times: &[f64]) -> Vec<Pose> {
    times.iter().enumerate().map(|(k, &time)| named_pose(&time.to_string(), k as u32, Some(time))).collect()
}

fn paired(estimate: &[Pose], truth: &[Pose]) -> Pairing {
    associate(estimate, truth, None, 0.02).expect("paired")
}

#[test]
fn images_of_one_name_belong_together_and_the_last_number_of_a_name_is_its_time() {
    let pairing = paired(&named(&["c.png", "a.png", "x.png"]), &named(&["a.png", "b.png", "c.png"]));
    assert_eq!(pairing, Pairing { by: Association::Name, pairs: vec![(1, 0), (0, 2)] });
    // Folders and endings count only as long as some whole names agree.
    let pairing = paired(&named(&["gold/a.png", "gold/b.png"]), &named(&["b.tiff", "a.tiff"]));
    assert_eq!(pairing.pairs, [(1, 0), (0, 1)]);
    let pairing = paired(&named(&["a.png", "b.png"]), &named(&["a.png", "b.tiff"]));
    assert_eq!(pairing.pairs, [(0, 0)]);
    // A name that could be either of two is left out.
    let pairing = paired(&named(&["a.png", "b.png"]), &named(&["1/a.jpg", "2/a.jpg", "b.jpg"]));
    assert_eq!(pairing.pairs, [(1, 2)]);
    let error = associate(&named(&["a.png"]), &named(&["b.png"]), None, 0.02).expect_err("none").to_string();
    assert!(error.contains("by name") && error.contains("'a.png'") && error.contains("--associate"), "{error}");
    for (name, number) in [
        ("image.0023", Some(23.0)),
        ("1305031102.175304", Some(1305031102.175304)),
        ("frame_007_left", Some(7.0)),
        ("v2.5", Some(2.5)),
        ("7", Some(7.0)),
        (".5", Some(5.0)),
        ("left", None),
        ("", None),
    ] {
        let image = [named_pose(&format!("{name}.png"), 0, None)];
        let at = |time| associate(&image, &timed(&[time]), Some(Association::Time), 0.0).is_ok();
        assert_eq!((at(number.unwrap_or(0.0)), at(-1.0)), (number.is_some(), false), "{name}");
    }
}

#[test]
fn nearest_times_belong_together_once_and_places_count_where_times_say_nothing() {
    let pairing = paired(&timed(&[0.011, 1.0, 1.004, 2.5]), &timed(&[0.0, 1.003, 3.0]));
    assert_eq!(pairing, Pairing { by: Association::Time, pairs: vec![(0, 0), (2, 1)] });
    // The numbers in the names of a model's images are times.
    let model = [named_pose("i/image.0023.png", 2, None), named_pose("i/image.0030.png", 3, None)];
    let pairing = paired(&model, &timed(&[16.0, 23.0, 30.0]));
    assert_eq!(pairing, Pairing { by: Association::Time, pairs: vec![(0, 1), (1, 2)] });
    let model = [named_pose("a.png", 0, None), named_pose("c.png", 2, None)];
    let truth = timed(&[100.5, 101.5, 102.5]);
    assert_eq!(paired(&model, &truth), Pairing { by: Association::Order, pairs: vec![(0, 0), (1, 2)] });
    // An image beyond the truth shows that the order was not meant.
    let model = [named_pose("a.png", 0, None), named_pose("z.png", 7, None)];
    let error = associate(&model, &truth, None, 0.02).expect_err("unclear").to_string();
    assert!(error.contains("0 and places in the sequence for 1 of the estimate's 2"), "{error}");
    assert_eq!(associate(&model, &truth, Some(Association::Order), 0.02).expect("forced").pairs, [(0, 0)]);
}

proptest! {
    #[test]
    fn no_pose_is_in_two_pairs(
        estimate in prop::collection::vec((0u32..6, prop::option::of(0.0f64..3.0)), 0..8),
        truth in prop::collection::vec((0u32..6, prop::option::of(0.0f64..3.0)), 0..8),
        by in prop::option::of(prop::sample::select(vec![Association::Name, Association::Time])),
    ) {
        let poses = |v: &[(u32, Option<f64>)]| -> Vec<Pose> {
            v.iter().enumerate().map(|(k, &(name, time))| named_pose(&format!("é{name}"), k as u32, time)).collect()
        };
        if let Ok(Pairing { pairs, .. }) = associate(&poses(&estimate), &poses(&truth), by, 0.5) {
            for (k, a) in pairs.iter().enumerate() {
                prop_assert!(a.0 < estimate.len() && a.1 < truth.len());
                prop_assert!(pairs[..k].iter().all(|b| a.0 != b.0 && a.1 > b.1));
            }
        }
    }
}

fn parse(text: &str) -> Result<Vec<Pose>> {
    parse_tum(text, Path::new("truth.txt"))
}

#[test]
fn a_line_is_the_camera_in_the_world_by_time_or_name_and_others_are_named() {
    // A quarter turn about z: the camera's x axis points along the world's y.
    let text = "# a comment\n\n1.5 1 2 3 0 0 0.70710678 0.70710678\n2.5,0,0,0,0,0,0,1\r\n";
    let poses = parse(text).expect("two poses");
    assert_eq!((poses.len(), poses[0].time, poses[1].time), (2, Some(1.5), Some(2.5)));
    assert_eq!((poses[0].order, poses[1].order), (0, 1));
    let tip = poses[0].world_from_camera * Point3::new(1.0, 0.0, 0.0);
    assert!((tip.coords - Vector3::new(1.0, 3.0, 3.0)).norm() < 1e-7, "{tip}");
    let poses = parse("a/0001.png 1 2 3 0 0 0 1\n").expect("one pose");
    assert_eq!((poses[0].label.as_str(), poses[0].time), ("a/0001.png", None));
    let error = parse("a.png 0 0 0 0 0 0 1\n3.5 0 0 0 0 0 0 1\n").expect_err("mixed").to_string();
    assert!(error.starts_with("line 2: ") && error.ends_with("truth.txt"), "{error}");
    for (line, words) in [
        ("1 2 3", "3 values"),
        ("1 0 0 0 0 0 0 1 7", "9 values"),
        ("1 0 0 x 0 0 0 1", "'x' is not a number"),
        ("1 0 0 nan 0 0 0 1", "'nan' is not a number"),
        ("1 0 0 0 0 0 0 0", "length is 0.000"),
        ("1 0 0 0 2 0 0 1", "length is 2.236"),
    ] {
        says(parse(&format!("0 0 0 0 0 0 0 1\n{line}\n")).expect_err(line), &["line 2", words]);
    }
    let error = parse("# nothing\n").expect_err("empty").to_string();
    assert!(error.starts_with("there is no pose in this") && error.ends_with("truth.txt"), "{error}");
    says(read_tum(Path::new("/nowhere/truth.txt")).expect_err("absent"), &["no such file"]);
}

const IMAGES: &str = "# Image list with two lines of data per image:\n\
3 1 0 0 0 1 2 3 1 a/second one.png\n10.5 20.5 7 11 21 -1 12 22 8\n\
2 0.70710678118654757 0 0 0.70710678118654757 1 0 0 1 first.png\n\n";
const POINTS: &str = "# 3D point list\n7 1 2 3 255 0 0 0.5 3 0 2 5\n8 1 2 4 0 0 0 1.5 3 2 2 1 5 9 4 4\n";

fn binary_files() -> (Vec<u8>, Vec<u8>) {
    let mut images = 2u64.to_le_bytes().to_vec();
    let half = 0.5f64.sqrt();
    for (id, pose, name, keypoints) in [
        (3u32, [1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0], "a/second one.png", vec![7u64, u64::MAX, 8]),
        (2, [half, 0.0, 0.0, half, 1.0, 0.0, 0.0], "first.png", vec![]),
    ] {
        images.extend(id.to_le_bytes());
        pose.iter().for_each(|x: &f64| images.extend(x.to_le_bytes()));
        images.extend(1u32.to_le_bytes());
        images.extend(name.as_bytes());
        images.push(0);
        images.extend((keypoints.len() as u64).to_le_bytes());
        for (k, point) in keypoints.iter().enumerate() {
            [10.5 + k as f64, 20.5 + k as f64].iter().for_each(|x| images.extend(x.to_le_bytes()));
            images.extend(point.to_le_bytes());
        }
    }
    let mut points = 2u64.to_le_bytes().to_vec();
    for (id, error, track) in [(7u64, 0.5f64, 2u64), (8, 1.5, 4)] {
        points.extend(id.to_le_bytes());
        [1.0, 2.0, 3.0].iter().for_each(|x: &f64| points.extend(x.to_le_bytes()));
        points.extend([255, 0, 0]);
        points.extend(error.to_le_bytes());
        points.extend(track.to_le_bytes());
        (0..track).for_each(|k| points.extend([(k as u32).to_le_bytes(), 0u32.to_le_bytes()].concat()));
    }
    (images, points)
}

fn binary(home: &Path, images: &[u8], points: &[u8]) -> String {
    std::fs::write(home.join("images.bin"), images).expect("written");
    std::fs::write(home.join("points3D.bin"), points).expect("written");
    read_sparse_model(home).expect_err("damaged").to_string()
}

fn written(folder: &Path, format: &str) {
    std::fs::create_dir_all(folder).expect("made");
    let (images, points) = match format {
        "bin" => binary_files(),
        _ => (IMAGES.into(), POINTS.into()),
    };
    std::fs::write(folder.join(format!("images.{format}")), images).expect("written");
    std::fs::write(folder.join(format!("points3D.{format}")), points).expect("written");
}

#[test]
fn text_and_binary_say_the_same_and_the_largest_part_of_a_reconstruction_is_taken() {
    let home = folder();
    for format in ["bin", "txt"] {
        let folder = home.join(format);
        written(&folder, format);
        let model = read_sparse_model(&folder).expect(format);
        let [first, second] = &model.images[..] else { panic!("two images") };
        assert_eq!((first.id, second.id, second.name.as_str()), (2, 3, "a/second one.png"));
        assert_eq!((second.keypoints, second.points, first.keypoints), (3, 2, 0));
        // The world is turned a quarter about z and moved by (1, 0, 0): the centre −Rᵀt is (0, 1, 0).
        let centre = first.world_from_camera.translation.vector;
        assert!((centre - nalgebra::Vector3::new(0.0, 1.0, 0.0)).norm() < 1e-12, "{centre}");
        let summary = model.summary();
        assert_eq!((summary.registered_images, summary.points, summary.points_per_image), (2, 2, 1.0));
        assert_eq!((summary.mean_track_length, summary.mean_reprojection_error_px), (3.0, 1.0));
        assert!(model.points.iter().all(|p| p.position[..2] == [1.0, 2.0]), "{:?}", model.points);
        // Its other images are not in the model.
        let seen: Vec<(usize, usize)> = model.points.iter().flat_map(|point| model.seen_by(point)).collect();
        assert_eq!(seen, if format == "bin" { &[(0, 0), (1, 0)][..] } else { &[(1, 0), (0, 5), (1, 2), (0, 1)] });
        let poses = model.poses();
        assert_eq!((poses[0].order, poses[0].label.as_str(), poses[0].time), (1, "first.png", None));
    }
    let home = folder();
    written(&home.join("1"), "txt");
    std::fs::create_dir(home.join("notes")).expect("made");
    let small = home.join("0");
    written(&small, "txt");
    std::fs::write(small.join("images.txt"), "1 1 0 0 0 0 0 0 1 a.png\n\n").expect("written");
    let model = read_sparse_model(&home).expect("a model");
    assert_eq!((model.images.len(), &model.folder), (2, &home.join("1")));
    assert_eq!(model.taken(), Some(format!("took {}, the largest of 2 parts", model.folder.display())));
    assert_eq!(SparseModel { other_models: 0, ..model }.taken(), None);
}

#[test]
fn what_is_no_model_says_so_and_counts_that_cannot_be_are_not_believed() {
    let home = folder();
    let words = |folder: &Path| read_sparse_model(folder).expect_err("no model").to_string();
    assert!(words(&home).contains("no sparse model"));
    assert!(words(&home.join("gone")).contains("no such file"));
    written(&home, "txt");
    for (file, text, message) in [
        ("images.txt", "# nothing\n", "no pose"),
        ("images.txt", "1 1 0 0 0 0 0 0 1\n", "line 1: it ends too early"),
        ("images.txt", "1 1 0 0 0 x 0 0 1 a.png\n", "'x' is not a number"),
        ("images.txt", "1 0 0 0 0 0 0 0 1 a.png\n", "length is 0.000"),
        ("images.txt", "1 1 0 0 0 inf 0 0 1 a.png\n", "value inf"),
        ("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n1 2\n", "line 2: 2 values"),
        ("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n1 1 0 0 0 0 0 0 1 b.png\n\n", "two images of the id 1"),
        ("points3D.txt", "1 1 1 1 0 0 0\n", "line 1: it ends too early"),
        ("points3D.txt", "1 1 1 1 0 0 0 0.5 1 2 3\n", "track has 3 values"),
    ] {
        written(&home, "txt");
        std::fs::write(home.join(file), text).expect("written");
        says(words(&home), &[message, home.to_str().expect("plain")]);
    }
    let home = folder();
    let (mut images, mut points) = binary_files();
    points[..8].copy_from_slice(&(1u64 << 40).to_le_bytes());
    assert!(binary(&home, &images, &points).contains("1099511627776"));
    images[..8].copy_from_slice(&u64::MAX.to_le_bytes());
    let error = binary(&home, &images, &points);
    assert!(error.starts_with("the number of images: it announces 18446744073709551615 entries"), "{error}");
    // A name without an end.
    let mut endless = binary_files().0;
    endless.truncate(8 + 4 + 56 + 4);
    endless.extend([b'a'; 10_000]);
    says(binary(&home, &endless, &points), &["image 1 of 2", "4096"]);
}

proptest! {
    #[test]
    fn truncated_files_say_so(part in 0.0f64..1.0) {
        let home = folder();
        let (images, points) = binary_files();
        let cut = |bytes: &[u8]| bytes[..(bytes.len() as f64 * part) as usize].to_vec();
        prop_assert!(binary(&home, &cut(&images), &points).contains("images.bin"));
        prop_assert!(binary(&home, &images, &cut(&points)).contains("points3D.bin"));
    }
}
