//! Tests of `dataset::camera`.

use burstscope_core::dataset::camera::*;
use burstscope_core::matching::*;

#[test]
fn a_guess_is_colmaps_and_a_known_camera_is_for_its_own_images() {
    let camera = CameraChoice::default().for_images((640, 480)).expect("a guess");
    assert_eq!(camera.to_string(), "SIMPLE_RADIAL 640 480 768 320 240 0");
    let camera = CameraChoice::Guessed(CameraModel::OpenCv).for_images((480, 640)).expect("a guess");
    assert_eq!(camera.params, [768.0, 768.0, 240.0, 320.0, 0.0, 0.0, 0.0, 0.0]);
    let choice = CameraChoice::Known(Camera::centred(64, 48, 50.0));
    assert_eq!(choice.for_images((64, 48)).map(|c| c.params[0]), Ok(50.0));
    let error = choice.for_images((48, 64)).expect_err("another size").to_string();
    assert!(error.contains("64×48") && error.contains("48×64"), "{error}");
}

#[test]
fn camera_files_are_read_or_explained() {
    let home = tempfile::tempdir().expect("a folder");
    let path = home.path().join("camera.toml");
    let read = |text: &str| {
        std::fs::write(&path, text).expect("written");
        read_camera(&path)
    };
    let text = "model = \"OPENCV\"\nwidth = 8\nheight = 6\nparams = [5, 5, 4, 3, 0.1, 0, 0, 0]\n";
    assert_eq!(read(text).expect("a camera").to_string(), "OPENCV 8 6 5 5 4 3 0.1 0 0 0");
    for (text, words) in [
        ("model = \"FISHEYE\"\nwidth = 8\nheight = 6\nparams = [5, 4, 3]\n", "FISHEYE"),
        ("model = \"PINHOLE\"\nwidth = 8\nheight = 6\n", "params"),
        ("model = \"PINHOLE\"\nwidth = 8\nheight = 6\nparams = [5]\n", "fx, fy, cx, cy"),
        ("model = \"PINHOLE\"\nfocal = 3\n", "focal"),
    ] {
        let error = read(text).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
    assert!(read_camera(&home.path().join("gone.toml")).expect_err("absent").to_string().contains("gone.toml"));
}
