//! Tests of the public functions of `matching`.

use crate::prelude::*;
use burstscope_core::matching::{align::solve::*, camera::*, geometry::RelativePose, *};
use nalgebra::{Rotation3, Vector2, Vector3};

#[test]
fn ratios_are_of_each_images_own_keypoints_and_those_of_its_pairs_are_added_up() {
    let counts =
        MatchCounts { keypoints_a: 100, keypoints_b: 200, putative: 40, inliers: Some(30), ..MatchCounts::default() };
    assert_eq!(counts.keypoints_per_image(), 150.0);
    assert!((counts.match_ratio() - (0.4 + 0.2) / 2.0).abs() < 1e-12);
    assert!((counts.match_score().expect("verified") - (0.3 + 0.15) / 2.0).abs() < 1e-12);
    assert_eq!(counts.inlier_ratio(), Some(0.75));
    let none = MatchCounts { inliers: Some(0), ..MatchCounts::default() };
    assert_eq!((none.match_ratio(), none.match_score(), none.inlier_ratio()), (0.0, Some(0.0), None));
    let unverified = MatchCounts { keypoints_a: 1, keypoints_b: 1, putative: 1, ..MatchCounts::default() };
    assert_eq!((unverified.match_ratio(), unverified.match_score(), unverified.inlier_ratio()), (1.0, None, None));
    let counts = |putative, inliers| MatchCounts { putative, inliers: Some(inliers), ..MatchCounts::default() };
    let pairs = [((0, 1), counts(4, 3)), ((0, 2), counts(6, 0))];
    let all = ImageCounts::of(&[10, 8, 0], &pairs).expect("three images");
    // Image 0 has 10 putative matches, image 1 has 4, image 2 has 6 (and no keypoint to divide them by).
    assert_eq!((all.keypoints_per_image, all.putative_per_image, all.inliers_per_image), (6.0, 20.0 / 3.0, 2.0));
    assert!((all.match_ratio - (1.0 + 0.5) / 3.0).abs() < 1e-12);
    assert!((all.match_score - (0.3 + 0.375) / 3.0).abs() < 1e-12);
    assert_eq!((all.inlier_ratio, all.verified_pairs), (Some(0.3), 1));
    assert_eq!(ImageCounts::of(&[], &[]), None);
    assert_eq!(ImageCounts::of(&[5], &[]).expect("one image").inlier_ratio, None);
}

#[test]
fn pairs_are_in_order_and_each_is_there_once_and_orientations_of_one_place_move_together() {
    assert_eq!(PairSelection::All.pairs(4), [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]);
    assert_eq!(PairSelection::Sequential(2).pairs(4), [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)]);
    assert_eq!(PairSelection::Sequential(usize::MAX).pairs(3).len(), 3);
    assert!(PairSelection::All.pairs(1).is_empty() && PairSelection::Sequential(3).pairs(0).is_empty());
    for choice in [PairSelection::All, PairSelection::Sequential(7), PairSelection::Near(7)] {
        assert_eq!(choice.to_string().parse(), Ok(choice));
    }
    for bad in ["", "some", "sequential", "sequential:0", "sequential:-1", "sequential:x", "near:0", "near", "all:1"] {
        assert!(bad.parse::<PairSelection>().is_err(), "{bad}");
    }
    let features = [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [1.0, 2.0, 3.5], [9.0, 2.0, 3.0], [1.0, 2.0, 3.0]];
    assert_eq!(Places::of(features), Places { of_feature: vec![0, 0, 1, 2, 0], first: vec![0, 2, 3] });
}

/// A descriptor that is far from those of other numbers, and this near to its own.
fn descriptor(number: usize, off: u8) -> Descriptor {
    std::array::from_fn(|k| if k == number { 200 } else { off * u8::from(k == 127) })
}

#[test]
fn each_image_is_paired_with_those_that_most_of_its_features_vote_for() {
    // Image 3 shows what 0 shows, and 2 what 1 shows; 0 and 1 have one thing in common, 4 has nothing at all.
    let image = |of: &[(usize, u8)]| of.iter().map(|&(number, off)| descriptor(number, off)).collect::<Vec<_>>();
    let images = [
        image(&[(1, 0), (2, 0), (3, 0), (9, 0)]),
        image(&[(4, 0), (5, 0), (9, 1)]),
        image(&[(4, 2), (5, 2)]),
        image(&[(1, 3), (2, 3), (3, 3)]),
        Vec::new(),
    ];
    let pairs = |partners| near_pairs(&images, partners, &quiet()).expect("pairs");
    // An image without features has no votes, and of equals the first is taken.
    assert_eq!(pairs(1), [(0, 3), (0, 4), (1, 2)]);
    assert_eq!(pairs(2), [(0, 1), (0, 2), (0, 3), (0, 4), (1, 2), (1, 3), (1, 4)]);
    assert_eq!(pairs(usize::MAX), PairSelection::All.pairs(5));
    assert_eq!(near_pairs(&images[..1], 3, &quiet()), Ok(Vec::new()));
    assert!(near_pairs(&images, 1, &cancelled()).is_err());
    // No more than the strongest vote and are voted for: what 0 and 3 have in common comes after them here.
    let filled = |image: usize| -> Result<Vec<Descriptor>, Cancelled> {
        let many = if image == 0 { vec![descriptor(4, 5); VOTERS] } else { Vec::new() };
        Ok([&many[..], &images[image]].concat())
    };
    assert_eq!(PairSelection::Near(1).pairs_by(4, filled, &quiet()), Ok(vec![(0, 2), (1, 2), (2, 3)]));
    let unasked = |image: usize| -> Result<Vec<Descriptor>, Cancelled> { panic!("the features of {image}") };
    assert_eq!(PairSelection::Sequential(1).pairs_by(3, unasked, &quiet()), Ok(vec![(0, 1), (1, 2)]));
}

proptest! {
    #[test]
    fn each_image_has_as_many_partners_as_asked_for_and_more_contain_fewer(
        images in prop::collection::vec(prop::collection::vec((0..20usize, 0..9u8), 0..6), 0..7), partners in 1..8usize,
    ) {
        let of = |image: &Vec<(usize, u8)>| image.iter().map(|&(number, off)| descriptor(number, off)).collect();
        let images: Vec<Vec<Descriptor>> = images.iter().map(of).collect();
        let pairs = near_pairs(&images, partners, &quiet()).expect("pairs");
        for image in 0..images.len() {
            let has = pairs.iter().filter(|(a, b)| [a, b].contains(&&image)).count();
            prop_assert!(has >= partners.min(images.len() - 1), "{image} in {pairs:?}");
        }
        prop_assert!(pairs.is_sorted() && pairs.iter().all(|(a, b)| a < b && *b < images.len()));
        let more = near_pairs(&images, partners + 1, &quiet()).expect("pairs");
        prop_assert!(pairs.iter().all(|pair| more.contains(pair)));
    }
}

fn opencv() -> Camera {
    "OPENCV 640 480 500 510 321 239 -0.28 0.07 0.0002 -0.0004".parse().expect("a camera")
}

#[test]
fn pixels_centres_are_half_a_pixel_in_and_each_model_sees_what_it_sees_in_colmap() {
    let camera: Camera = "PINHOLE,640,480,500,400,320.5,240.5".parse().expect("a camera");
    assert_eq!(camera.direction_of([320.0, 240.0]), [0.0, 0.0]);
    assert_eq!(camera.pixel_of([1.0, -0.5]), [820.0, 40.0]);
    assert_eq!(Camera::centred(640, 480, 500.0).direction_of([319.5, 239.5]), [0.0, 0.0]);
    // By hand at (x, y) = (0.3, −0.2): r² = 0.13, radial 1 − 0.28·0.13 + 0.07·0.0169.
    let radial = 1.0 - 0.28 * 0.13 + 0.07 * 0.0169;
    let x = 0.3 * radial + 2.0 * 0.0002 * -0.06 - 0.0004 * (0.13 + 0.18);
    let y = -0.2 * radial + 0.0002 * (0.13 + 0.08) + 2.0 * -0.0004 * -0.06;
    let [u, v] = opencv().pixel_of([0.3, -0.2]);
    assert!((u - (500.0 * x + 320.5)).abs() < 1e-9 && (v - (510.0 * y + 238.5)).abs() < 1e-9);
    for (text, [u_0, v_0, u_1, v_1]) in SEEN_BY_COLMAP {
        let camera: Camera = text.parse().expect("a camera");
        assert!(!camera.is_straight());
        for (direction, [u, v]) in [([0.4, -0.3], [u_0, v_0]), ([-0.05, 0.6], [u_1, v_1])] {
            let at = camera.pixel_of(direction);
            assert!((at[0] + 0.5 - u).abs() < 1e-6 && (at[1] + 0.5 - v).abs() < 1e-6, "{text}: {at:?}");
            let [x, y] = camera.direction_of(at);
            assert!((x - direction[0]).abs() < 1e-9 && (y - direction[1]).abs() < 1e-9, "{text}: {x} {y}");
        }
        assert_eq!(camera.pixel_of([0.0, 0.0]), [camera.matrix()[(0, 2)], camera.matrix()[(1, 2)]]);
    }
    let numbers: Vec<u32> = CameraModel::ALL.iter().map(|model| model.id()).collect();
    assert_eq!(numbers, (0..12).collect::<Vec<u32>>());
}

/// Where pycolmap 4.2.1 sees (0.4, −0.3, 1) and (−0.05, 0.6, 1), in COLMAP's convention.
#[rustfmt::skip]
const SEEN_BY_COLMAP: [(&str, [f64; 4]); 8] = [
        ("RADIAL 640 480 500 320 240 -0.2 0.05", [510.625, 97.03125, 296.648242187, 520.22109375]),
        ("OPENCV_FISHEYE 640 480 300 310 320 240 0.05 -0.01 0.003 -0.001", [432.423121446, 152.872080879, 306.310559332, 409.749064289]),
        ("FULL_OPENCV 640 480 500 510 320 240 -0.2 0.05 0.001 -0.0005 0.02 -0.1 0.03 0.004", [514.926547406, 90.960878735, 295.726877588, 536.178643327]),
        ("FOV 640 480 400 410 320 240 0.9", [480.0, 117.0, 300.554938052, 479.174261962]),
        ("SIMPLE_RADIAL_FISHEYE 640 480 300 320 240 -0.03", [430.557802796, 157.081647903, 306.617085557, 400.594973316]),
        ("RADIAL_FISHEYE 640 480 300 320 240 -0.03 0.008", [430.598940623, 157.050794533, 306.607767775, 400.706786705]),
        ("THIN_PRISM_FISHEYE 640 480 300 310 320 240 0.03 -0.01 0.0006 -0.0004 0.002 -0.0005 0.001 -0.002", [431.912247788, 153.204699563, 306.433793763, 408.749042324]),
        ("RAD_TAN_THIN_PRISM_FISHEYE 640 480 300 310 320 240 0.03 -0.01 0.004 -0.002 0.0005 -0.0001 0.0006 -0.0004 0.001 -0.0003 -0.002 0.0005", [432.120960655, 153.029356157, 306.531522404, 408.477834274]),
];

#[test]
fn a_field_of_view_has_no_sign_and_none_bends_nothing() {
    let seen = |omega: &str| {
        let camera: Camera = format!("FOV 640 480 400 410 320 240 {omega}").parse().expect("a camera");
        camera.pixel_of([0.4, -0.3])
    };
    assert_eq!(seen("-0.9"), seen("0.9"));
    let straight: Camera = "PINHOLE 640 480 400 410 320 240".parse().expect("a camera");
    assert_eq!(seen("0"), straight.pixel_of([0.4, -0.3]));
    // Nor is anything endless beyond the edge of a fisheye, or with hopeless distortion.
    for model in [
        "OPENCV_FISHEYE 640 480 100 100 320 240 0 0 0 0",
        "FOV 640 480 100 100 320 240 1.5",
        "SIMPLE_RADIAL 640 480 100 320 240 -3",
    ] {
        let camera: Camera = model.parse().expect("a camera");
        for pixel in [[0.0, 0.0], [639.0, 479.0], [320.0, 479.0], [1e6, -1e6], [320.0, 0.0]] {
            assert!(camera.direction_of(pixel).iter().all(|x| x.is_finite()), "{model}");
        }
    }
}

#[test]
fn a_camera_is_read_back_from_text_and_nonsense_says_what_is_right_and_files_hold_it_by_colmaps_names() {
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
        says(text.parse::<Camera>().expect_err(words), &[words]);
    }
    let text = toml::to_string(&opencv()).expect("plain values");
    assert!(text.contains("model = \"OPENCV\""), "{text}");
    assert_eq!(toml::from_str::<Camera>(&text), Ok(opencv()));
    for model in CameraModel::ALL {
        assert_eq!(serde_json::to_value(model).ok(), Some(serde_json::Value::from(model.name())));
    }
}

proptest! {
    #[test]
    fn directions_and_pixels_are_inverse(u in -0.5f64..639.5, v in -0.5f64..479.5) {
        let of_colmap = SEEN_BY_COLMAP.iter().map(|(text, _)| text.parse().expect("a camera"));
        let simple = "SIMPLE_RADIAL 640 480 500 320 240 0.1".parse().expect("a camera");
        for camera in of_colmap.chain([opencv(), Camera::centred(640, 480, 700.0), simple]) {
            let [back_u, back_v] = camera.pixel_of(camera.direction_of([u, v]));
            prop_assert!((back_u - u).abs() < 1e-8 && (back_v - v).abs() < 1e-8, "{} {}", back_u, back_v);
        }
    }
}

fn camera() -> Camera {
    Camera::centred(640, 480, 600.0)
}

fn params(geometry: Geometry) -> MatchParams {
    let camera = (geometry == Geometry::Essential).then(camera);
    MatchParams { geometry, max_error_px: 3.0, max_iterations: 100_000, camera, ..MatchParams::default() }
}

fn verified(pairs: &[PointPair], params: &MatchParams) -> Verification {
    verify(pairs, None, params, &quiet()).expect("not cancelled").expect("asked for")
}

fn pose() -> RelativePose {
    let rotation = Rotation3::from_euler_angles(0.05, -0.12, 0.03).into_inner();
    RelativePose { rotation, translation: Vector3::new(0.9, 0.1, -0.3).normalize() }
}

/// Matches of `inliers` points in space, seen by both cameras with half a pixel of noise, among `outliers` of
/// random places, and whether each is true.
fn scene(
    random: &mut Stream,
    [a, b]: [&Camera; 2],
    (inliers, outliers): (usize, usize),
) -> (Vec<PointPair>, Vec<bool>) {
    let place = |random: &mut Stream, of: &Camera| {
        [random.within(0.0, of.width as f64 - 1.0), random.within(0.0, of.height as f64 - 1.0)]
    };
    let (pose, mut pairs) = (pose(), Vec::new());
    while pairs.len() < inliers {
        let in_a = place(random, a);
        let [x, y] = a.direction_of(in_a);
        let there = pose.rotation * (Vector3::new(x, y, 1.0) * random.within(3.0, 9.0)) + pose.translation;
        let in_b = b.pixel_of([there.x / there.z, there.y / there.z]);
        let is_inside = in_b[0] > 0.0 && in_b[1] > 0.0 && in_b[0] < b.width as f64 && in_b[1] < b.height as f64;
        if there.z > 0.1 && is_inside {
            let mut moved = |p: [f64; 2]| p.map(|x| x + 0.5 * random.normal());
            pairs.push(PointPair { a: moved(in_a), b: moved(in_b), rank: 0.0 });
        }
    }
    (0..outliers).for_each(|_| pairs.push(PointPair { a: place(random, a), b: place(random, b), rank: 0.0 }));
    // Shuffled, so that no order helps.
    let mut is_true: Vec<bool> = (0..pairs.len()).map(|i| i < inliers).collect();
    for i in (1..pairs.len()).rev() {
        let j = random.within(0.0, (i + 1) as f64) as usize;
        pairs.swap(i, j);
        is_true.swap(i, j);
    }
    (pairs, is_true)
}

fn from_segment(p: [f64; 2], [q, r]: [[f64; 2]; 2]) -> f64 {
    let [p, q, r] = [p, q, r].map(Vector2::from);
    let (along, to) = (r - q, p - q);
    (to - along * (to.dot(&along) / along.norm_squared()).clamp(0.0, 1.0)).norm()
}

#[test]
fn each_image_has_its_own_camera() {
    let other: Camera = "OPENCV 800 600 900 880 410 290 -0.2 0.05 0.001 -0.0005".parse().expect("a camera");
    for seed in 0..3 {
        let mut random = Stream::new(0, 500 + seed);
        let (pairs, is_true) = scene(&mut random, [&camera(), &other], (200, 100));
        let counted = |found: &Verification, truth: bool| {
            is_true.iter().zip(&found.inlier).filter(|(is_true, inlier)| **is_true == truth && **inlier).count()
        };
        let of_one = MatchParams { max_iterations: 2000, ..params(Geometry::Essential) };
        let found = verified(&pairs, &MatchParams { camera_b: Some(other.clone()), ..of_one.clone() });
        let (right, wrong) = (counted(&found, true), counted(&found, false));
        assert!(right >= 195 && wrong <= 10, "seed {seed}: {right} right, {wrong} wrong");
        let inliers = pairs.iter().zip(&found.inlier).filter(|(_, inlier)| **inlier);
        let inliers: Vec<([f64; 2], [f64; 2])> = inliers.map(|(pair, _)| (pair.a, pair.b)).collect();
        let model = found.model.expect("a model");
        let (pose, _) = model.relative_pose(&inliers).expect("a pose");
        let turn = Rotation3::from_matrix_unchecked(pose.rotation.transpose() * self::pose().rotation).angle();
        let shift = pose.translation.angle(&self::pose().translation);
        assert!(turn.to_degrees() < 0.3 && shift.to_degrees() < 1.5, "seed {seed}: {turn}, {shift} rad");
        for (pair, _) in pairs.iter().zip(&is_true).filter(|(_, is_true)| **is_true).take(20) {
            let lines = [model.locus(1, pair.a, (800, 600)), model.locus(0, pair.b, (640, 480))];
            for (point, line) in [pair.b, pair.a].into_iter().zip(&lines) {
                let off = line.windows(2).map(|w| from_segment(point, [w[0], w[1]])).fold(f64::INFINITY, f64::min);
                assert!(off < 6.0, "seed {seed}: {point:?} is {off} px from its line");
            }
        }
        // With the camera of A for both there is no such geometry, and given twice it is the same as given once.
        let with_one = verified(&pairs, &of_one);
        let fewer = counted(&with_one, true);
        assert!(4 * fewer < 3 * right, "seed {seed}: {fewer} of {right}");
        assert_eq!(verified(&pairs, &MatchParams { camera_b: Some(camera()), ..of_one }), with_one);
    }
}

#[test]
fn hopeless_input_has_no_model_and_no_nan_and_random_matches_do_not_pass_for_a_geometry() {
    let mut random = Stream::new(0, 10);
    let place = |random: &mut Stream| [random.within(0.0, 639.0), random.within(0.0, 479.0)];
    let mut inputs: Vec<Vec<PointPair>> = (0..9)
        .map(|n| (0..n).map(|_| PointPair { a: place(&mut random), b: place(&mut random), rank: 0.5 }).collect())
        .collect();
    let same = PointPair { a: [5.0, 6.0], b: [7.0, 8.0], rank: 0.0 };
    inputs.push(vec![same; 40]);
    // All points of A on one line; all points of B in one place; no motion at all.
    let mut forty = |of: fn(f64, [f64; 2]) -> [[f64; 2]; 2]| {
        let pair = |i| of(f64::from(i), place(&mut random));
        inputs.push((0..40).map(pair).map(|[a, b]| PointPair { a, b, rank: 0.0 }).collect());
    };
    forty(|i, place| [[i, 2.0 * i], place]);
    forty(|_, place| [place, [3.0, 3.0]]);
    forty(|i, _| [[i, 3.0], [i, 3.0]]);
    for pairs in &inputs {
        for geometry in [Geometry::Fundamental, Geometry::Essential, Geometry::Homography] {
            let params = MatchParams { max_iterations: 300, min_inliers: 15, ..params(geometry) };
            let found = verified(pairs, &params);
            assert_eq!((found.inlier.len(), found.error_px.len()), (pairs.len(), pairs.len()));
            assert!(found.error_px.iter().all(|e| !e.is_nan() && *e >= 0.0));
            let inliers = found.inlier_count();
            assert!(if found.model.is_some() { inliers >= 15 } else { inliers == 0 });
            if pairs.len() < 15 {
                assert_eq!(found.model, None);
            }
        }
    }
    // Without any motion everything fits.
    let still: Vec<PointPair> = (0..40).map(|_| place(&mut random)).map(|a| PointPair { a, b: a, rank: 0.0 }).collect();
    assert_eq!(verified(&still, &params(Geometry::Homography)).inlier_count(), 40);
    assert_eq!(verify(&still, None, &params(Geometry::None), &quiet()), Ok(None));
    for seed in 0..5 {
        let (pairs, _) = scene(&mut Stream::new(0, 400 + seed), [&camera(), &camera()], (0, 60));
        for geometry in [Geometry::Fundamental, Geometry::Essential, Geometry::Homography] {
            assert_eq!(verified(&pairs, &params(geometry)).inlier_count(), 0, "{geometry:?}, seed {seed}");
        }
    }
}

#[test]
fn the_defaults_are_valid_and_survive_a_file_and_a_pair_has_the_cameras_of_its_images_or_none() {
    let params = MatchParams::default();
    assert_eq!(params.validate(), Ok(()));
    assert_eq!(toml::from_str(&toml::to_string(&params).expect("plain values")), Ok(params));
    assert!(toml::from_str::<MatchParams>("ration = 0.7").is_err());
    let params = MatchParams { camera: Some(Camera::centred(8, 6, 5.0)), ..MatchParams::default() };
    let table = toml::Table::try_from(params).expect("plain values");
    let described: Vec<String> =
        burstscope_core::matching::params::doc::ALL.iter().map(|record| record.name.replace('-', "_")).collect();
    assert!(table.len() == described.len() && table.keys().all(|field| described.contains(field)), "{table:?}");
    // The camera of B alone is no option.
    assert!(toml::from_str::<MatchParams>("[camera_b]\nmodel = \"PINHOLE\"\n").is_err());
    for geometry in Geometry::ALL {
        assert_eq!(serde_json::to_value(geometry).ok(), Some(serde_json::Value::from(geometry.word())));
    }
    let [a, b] = [5.0, 7.0].map(|focal_px| Camera::centred(8, 6, focal_px));
    let all = MatchParams { geometry: Geometry::Essential, camera: Some(b.clone()), ..MatchParams::default() };
    let with = |a, b| all.with_cameras(a, b);
    assert_eq!(with(Some(&a), Some(&b)).cameras(), Some([&a, &b]));
    assert_eq!(with(Some(&a), Some(&a)), MatchParams { camera: Some(a.clone()), ..all.clone() });
    let fundamental = MatchParams { geometry: Geometry::Fundamental, camera: None, ..all.clone() };
    for (a, b) in [(Some(&a), None), (None, Some(&b)), (None, None)] {
        assert_eq!((with(a, b), with(a, b).validate()), (fundamental.clone(), Ok(())));
    }
    let homography = MatchParams { geometry: Geometry::Homography, ..all };
    assert_eq!(homography.with_cameras(Some(&a), None), MatchParams { geometry: Geometry::Homography, ..fundamental });
}

#[test]
fn nonsense_in_the_parameters_is_named() {
    let flat = Camera { width: 0, ..Camera::centred(8, 6, 5.0) };
    type Spoil = fn(&mut MatchParams, Camera);
    let cases: [(&str, Spoil); 8] = [
        ("ratio", |p, _| p.ratio = f32::NAN),
        ("ratio", |p, _| p.ratio = 1.01),
        ("max-error-px", |p, _| p.max_error_px = 0.0),
        ("max-error-px", |p, _| p.max_error_px = f32::INFINITY),
        ("confidence", |p, _| p.confidence = 1.0),
        ("max-iterations", |p, _| p.max_iterations = 0),
        ("camera", |p, _| p.geometry = Geometry::Essential),
        ("camera", |p, flat| p.camera = Some(flat)),
    ];
    for (name, spoil) in cases {
        let mut params = MatchParams::default();
        spoil(&mut params, flat.clone());
        assert_eq!(params.validate().expect_err(name).subject, name);
    }
}
