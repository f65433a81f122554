use super::*;
use proptest::prelude::*;

const IMAGES: &str = "# Image list with two lines of data per image:\n\
    3 1 0 0 0 1 2 3 1 a/second one.png\n10.5 20.5 7 11 21 -1 12 22 8\n\
    2 0.70710678118654757 0 0 0.70710678118654757 1 0 0 1 first.png\n\n";
const POINTS: &str = "# 3D point list\n7 1 2 3 255 0 0 0.5 3 0 2 5\n8 1 2 4 0 0 0 1.5 3 2 2 1 5 9 4 4\n";

/// The model of the text files in binary.
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
fn text_and_binary_say_the_same() {
    let home = tempfile::tempdir().expect("a folder");
    for format in ["bin", "txt"] {
        let folder = home.path().join(format);
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
        let poses = model.poses();
        assert_eq!((poses[0].order, poses[0].label.as_str(), poses[0].time), (1, "first.png", None));
    }
}

#[test]
fn the_largest_part_of_a_reconstruction_is_taken() {
    let home = tempfile::tempdir().expect("a folder");
    written(&home.path().join("1"), "txt");
    std::fs::create_dir(home.path().join("notes")).expect("made");
    let small = home.path().join("0");
    written(&small, "txt");
    std::fs::write(small.join("images.txt"), "1 1 0 0 0 0 0 0 1 a.png\n\n").expect("written");
    let model = read_sparse_model(home.path()).expect("a model");
    assert_eq!((model.images.len(), model.other_models, model.folder), (2, 1, home.path().join("1")));
}

#[test]
fn a_file_of_a_model_stands_for_its_folder() {
    let home = tempfile::tempdir().expect("a folder");
    written(home.path(), "txt");
    let whole = crate::evaluate::poses::read_trajectory(home.path()).expect("a model");
    let by_file = crate::evaluate::poses::read_trajectory(&home.path().join("images.txt")).expect("the same");
    assert_eq!(whole, by_file);
    assert_eq!(super::folder_of_file(Path::new("truth.txt")), None);
}

#[test]
fn what_is_no_model_says_so() {
    let home = tempfile::tempdir().expect("a folder");
    let words = |folder: &Path| read_sparse_model(folder).expect_err("no model").to_string();
    assert!(words(home.path()).contains("no sparse model"));
    assert!(words(&home.path().join("gone")).contains("no such file"));
    written(home.path(), "txt");
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
        written(home.path(), "txt");
        std::fs::write(home.path().join(file), text).expect("written");
        let error = words(home.path());
        assert!(error.contains(message) && error.contains(home.path().to_str().expect("plain")), "{error}");
    }
}

#[test]
fn counts_that_cannot_be_are_not_believed() {
    let (mut images, mut points) = binary_files();
    images[..8].copy_from_slice(&u64::MAX.to_le_bytes());
    points[..8].copy_from_slice(&(1u64 << 40).to_le_bytes());
    let path = Path::new("x.bin");
    let error = binary::images(&images[..], images.len() as u64, path).expect_err("too many").to_string();
    assert!(error.starts_with("the number of images: it announces 18446744073709551615 entries"), "{error}");
    let error = binary::points(&points[..], points.len() as u64, path).expect_err("too many").to_string();
    assert!(error.contains("1099511627776"), "{error}");
    // A name without an end.
    let mut endless = binary_files().0;
    endless.truncate(8 + 4 + 56 + 4);
    endless.extend([b'a'; 10_000]);
    let error = binary::images(&endless[..], endless.len() as u64, path).expect_err("no name").to_string();
    assert!(error.contains("image 1 of 2") && error.contains("4096"), "{error}");
}

proptest! {
    #[test]
    fn truncated_files_say_so(part in 0.0f64..1.0) {
        let (images, points) = binary_files();
        let cut = |bytes: &[u8]| bytes[..(bytes.len() as f64 * part) as usize].to_vec();
        let (images, points) = (cut(&images), cut(&points));
        let path = Path::new("x.bin");
        prop_assert!(binary::images(&images[..], images.len() as u64, path).is_err());
        prop_assert!(binary::points(&points[..], points.len() as u64, path).is_err());
    }

    #[test]
    fn damaged_files_never_panic(at in any::<prop::sample::Index>(), bytes in prop::collection::vec(any::<u8>(), 1..9)) {
        let path = Path::new("x");
        let (mut images, mut points) = binary_files();
        let (mut image_text, mut point_text) = (IMAGES.as_bytes().to_vec(), POINTS.as_bytes().to_vec());
        for file in [&mut images, &mut points, &mut image_text, &mut point_text] {
            let start = at.index(file.len());
            let end = file.len().min(start + bytes.len());
            file[start..end].copy_from_slice(&bytes[..end - start]);
        }
        if let Ok(images) = binary::images(&images[..], images.len() as u64, path) {
            prop_assert!(images.len() <= 2);
        }
        let _ = binary::points(&points[..], points.len() as u64, path);
        let _ = text::images(&image_text[..], path);
        let _ = text::points(&point_text[..], path);
    }

    #[test]
    fn noise_is_no_model(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let path = Path::new("x");
        let _ = binary::images(&bytes[..], bytes.len() as u64, path);
        let _ = binary::points(&bytes[..], bytes.len() as u64, path);
        let _ = text::images(&bytes[..], path);
        let _ = text::points(&bytes[..], path);
    }
}
