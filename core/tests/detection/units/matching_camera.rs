//! Tests of `matching::camera`.

use burstscope_core::matching::camera::*;
use proptest::prelude::*;

fn opencv() -> Camera {
    "OPENCV 640 480 500 510 321 239 -0.28 0.07 0.0002 -0.0004".parse().expect("a camera")
}

#[test]
fn the_first_pixels_centre_is_half_a_pixel_in() {
    let camera: Camera = "PINHOLE,640,480,500,400,320.5,240.5".parse().expect("a camera");
    assert_eq!(camera.direction_of([320.0, 240.0]), [0.0, 0.0]);
    assert_eq!(camera.pixel_of([1.0, -0.5]), [820.0, 40.0]);
    assert_eq!(Camera::centred(640, 480, 500.0).direction_of([319.5, 239.5]), [0.0, 0.0]);
}

#[test]
fn distortion_is_that_of_opencv() {
    // By hand at (x, y) = (0.3, −0.2): r² = 0.13, radial 1 − 0.28·0.13 + 0.07·0.0169.
    let radial = 1.0 - 0.28 * 0.13 + 0.07 * 0.0169;
    let x = 0.3 * radial + 2.0 * 0.0002 * -0.06 - 0.0004 * (0.13 + 0.18);
    let y = -0.2 * radial + 0.0002 * (0.13 + 0.08) + 2.0 * -0.0004 * -0.06;
    let [u, v] = opencv().pixel_of([0.3, -0.2]);
    assert!((u - (500.0 * x + 320.5)).abs() < 1e-9 && (v - (510.0 * y + 238.5)).abs() < 1e-9);
}

#[test]
fn text_is_read_back_and_nonsense_says_what_is_right() {
    for text in ["SIMPLE_PINHOLE 8 6 5 4 3", "SIMPLE_RADIAL 8 6 5 4 3 -0.1", &opencv().to_string()] {
        assert_eq!(text.parse::<Camera>().expect("a camera").to_string(), text);
    }
    for (text, words) in [
        ("", "begin with a model"),
        ("FISHEYE 8 6 1", "OPENCV"),
        ("PINHOLE 8", "PINHOLE WIDTH HEIGHT fx fy cx cy"),
        ("PINHOLE 8 6 1 2 3", "PINHOLE takes fx, fy, cx, cy"),
        ("PINHOLE 8 6 1 2 3 x", "'x' is not a number"),
        ("PINHOLE 8 6 0 2 3 4", "focal length is above 0"),
        ("PINHOLE 0 6 1 2 3 4", "size of its images"),
        ("SIMPLE_RADIAL 8 6 5 4 3 nan", "k is NaN"),
    ] {
        let error = text.parse::<Camera>().expect_err(words);
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn files_hold_it_by_colmaps_names_and_hopeless_distortion_ends_without_nan() {
    let text = toml::to_string(&opencv()).expect("plain values");
    assert!(text.contains("model = \"OPENCV\""), "{text}");
    assert_eq!(toml::from_str::<Camera>(&text), Ok(opencv()));
    for model in CameraModel::ALL {
        assert_eq!(serde_json::to_value(model).ok(), Some(serde_json::Value::from(model.name())));
    }
    let camera: Camera = "SIMPLE_RADIAL 640 480 100 320 240 -3".parse().expect("a camera");
    for pixel in [[0.0, 0.0], [1e6, -1e6], [320.0, 0.0]] {
        assert!(camera.direction_of(pixel).iter().all(|x| x.is_finite()));
    }
}

proptest! {
    #[test]
    fn directions_and_pixels_are_inverse(u in -0.5f64..639.5, v in -0.5f64..479.5) {
        for camera in [opencv(), Camera::centred(640, 480, 700.0), "SIMPLE_RADIAL 640 480 500 320 240 0.1".parse().expect("a camera")] {
            let [back_u, back_v] = camera.pixel_of(camera.direction_of([u, v]));
            prop_assert!((back_u - u).abs() < 1e-8 && (back_v - v).abs() < 1e-8, "{} {}", back_u, back_v);
        }
    }
}
