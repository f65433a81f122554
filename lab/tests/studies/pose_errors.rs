//! Errors of poses and their report.

use burstscope_lab::evaluate::poses::{Pose, Trajectory, report::*};
use nalgebra::{Isometry3, Vector3};
use std::f64::consts::FRAC_PI_2;

fn trajectory(centres: &[[f64; 3]]) -> Trajectory {
    let pose = |(k, &centre): (usize, &[f64; 3])| Pose {
        label: format!("{k}.png"),
        order: k as u32,
        time: None,
        world_from_camera: Isometry3::new(Vector3::from(centre), Vector3::zeros()),
    };
    Trajectory { poses: centres.iter().enumerate().map(pose).collect(), model: None }
}

#[test]
fn a_square_with_one_corner_off_by_hand() {
    // The estimate is twice as large. One of five cameras, the one in the middle, is too high: by symmetry nothing
    // is turned, and the least-squares fit is a fifth of the height too high.
    let truth = trajectory(&[[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 0.0]]);
    let estimate =
        trajectory(&[[2.0, 2.0, 0.0], [-2.0, 2.0, 0.0], [-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [0.0, 0.0, 1.0]]);
    let report =
        evaluate_poses(&estimate, &truth, &PoseStudy { images: Some(10), ..PoseStudy::default() }).expect("a report");
    // Σ|x|² of the estimate about its mean: 4·(8 + 0.04) + 0.64 = 32.8; Σxy = 16. Scale 16/32.8.
    let scale = 16.0 / 32.8;
    assert!((report.scale - scale).abs() < 1e-12, "{}", report.scale);
    let corner = (2.0 * (1.0 - 2.0 * scale).powi(2) + (0.2 * scale).powi(2)).sqrt();
    let middle = 0.8 * scale;
    assert!(
        (report.absolute.translation.rmse - ((4.0 * corner * corner + middle * middle) / 5.0).sqrt()).abs() < 1e-12
    );
    assert!((report.absolute.translation.median - corner).abs() < 1e-12);
    assert!((report.absolute.translation.max - middle).abs() < 1e-12);
    assert!(report.absolute.rotation_deg.max < 1e-6);
    assert!(report.common_rotation_deg < 1e-6);
    assert_eq!((report.absolute.count, report.relative.count, report.images_pass_percent()), (5, 4, 50.0));
    // By two corners alone the four are laid where they belong, and the middle is 0.5 too high: 18 % of the extent.
    assert_eq!(report.right, 4);
    // Three sides are (1 − 2·scale)·2 too short, the last motion also goes up.
    let side = 2.0 * (1.0 - 2.0 * scale);
    assert!((report.relative.translation.median - side).abs() < 1e-12);
    assert_eq!(report.pairs[4].label, "4.png");
    assert!((report.pairs[4].translation_error - middle).abs() < 1e-12);
}

#[test]
fn a_turn_of_all_cameras_is_told_from_those_of_each() {
    let truth = trajectory(&[[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.5]]);
    let mut estimate = truth.clone();
    let turn = |own: f64| Isometry3::new(Vector3::zeros(), Vector3::new(0.01, own, 0.0));
    let own = [0.002, -0.002, 0.002, -0.002].map(turn);
    estimate.poses.iter_mut().zip(own).for_each(|(pose, turn)| pose.world_from_camera *= turn);
    let report = evaluate_poses(&estimate, &truth, &PoseStudy::default()).expect("a report");
    assert!((report.common_rotation_deg - 0.01f64.to_degrees()).abs() < 1e-4, "{}", report.common_rotation_deg);
    assert!((report.absolute.rotation_deg.mean - 0.0102f64.to_degrees()).abs() < 1e-2);
}

#[test]
fn studies_that_make_no_sense_are_refused_and_summaries_by_hand() {
    let truth = trajectory(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    let error = |study| evaluate_poses(&truth, &truth, &study).expect_err("refused").to_string();
    assert!(error(PoseStudy { step: 0, ..PoseStudy::default() }).starts_with("step: "));
    assert!(error(PoseStudy { images: Some(1), ..PoseStudy::default() }).contains("2 images have a pose"));
    let never = PoseStudy { max_time_difference: f64::NAN, ..PoseStudy::default() };
    assert!(error(never).starts_with("max-time-difference: "));
    let summary = ErrorSummary::of(&[3.0, 1.0, 2.0, 6.0]);
    assert!(near(summary.rmse, 12.5f64.sqrt()) && near(summary.mean, 3.0));
    assert_eq!((summary.median, summary.max), (2.5, 6.0));
    let none = ErrorSummary::of(&[]);
    assert!(none.rmse.is_nan() && none.mean.is_nan() && none.median.is_nan() && none.max.is_nan());
}

fn pose(centre: [f64; 3], about_z: f64) -> Isometry3<f64> {
    Isometry3::new(Vector3::from(centre), Vector3::z() * about_z)
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

#[test]
fn one_false_turn_spoils_one_motion_and_all_places_after_it() {
    // The truth goes one unit along x each time. The estimate turns left once and goes on along y.
    let truth = [0.0, 1.0, 2.0, 3.0].map(|x| pose([x, 0.0, 0.0], 0.0));
    let estimate = [
        pose([0.0, 0.0, 0.0], 0.0),
        pose([1.0, 0.0, 0.0], FRAC_PI_2),
        pose([1.0, 1.0, 0.0], FRAC_PI_2),
        pose([1.0, 2.0, 0.0], FRAC_PI_2),
    ];
    let steps = PoseErrors::of(&relative(&estimate, &truth, 1));
    assert_eq!(steps.count, 3);
    assert!(near(steps.rotation_deg.max, 90.0) && near(steps.rotation_deg.mean, 30.0));
    assert!(near(steps.translation.max, 0.0));
    // Over two poses the first motion ends at (1, 1) in place of (2, 0), the second is a straight one.
    let steps = PoseErrors::of(&relative(&estimate, &truth, 2));
    assert!(steps.count == 2 && near(steps.translation.max, 2.0f64.sqrt()) && near(steps.rotation_deg.mean, 45.0));
    assert!(relative(&estimate, &truth, 4).is_empty());
    assert!(near(PoseErrors::of(&absolute(&estimate, &truth)).translation.max, 8.0f64.sqrt()));
}
