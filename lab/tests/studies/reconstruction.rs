//! The use of the features, at a size that takes seconds and without COLMAP: bursts along a camera's path past a dark
//! scene, matched and verified pair by pair.
//!
//! The scene and the path are our own (`synth trajectory`), so the true position of each feature of one burst in
//! another is known, and right matches can be counted, not only those that agree with one another.

use crate::prelude::*;
use burstscope_core::dataset::BurstSide;
use burstscope_core::matching::{Camera, CameraModel, match_pair};
use burstscope_lab::synth::{Light, Trajectory, TrajectoryParams, trajectory::world::nearest_point};

/// Largest distance of a right match from the true position of its point of the world, pixels.
const RIGHT_PX: f64 = 4.0;

/// Counts over all pairs of bursts.
#[derive(Debug, Clone, Copy, Default)]
struct Matched {
    inliers: usize,
    right: usize,
}

/// A dark scene that the camera passes in `motion`: one frame shows almost nothing.
fn dark_way(motion: Motion) -> Trajectory {
    let params = TrajectoryParams {
        width: 400,
        height: 300,
        bursts: 3,
        frames: 10,
        planes: 4,
        motion,
        max_slope: 3.0,
        shake_deg: 0.0,
        light: Light::Electrons(2.0),
        read_noise: 2.0,
        bits: 12,
        seed: 5,
    };
    Trajectory::new(&params, &quiet()).expect("a trajectory")
}

/// Finds the features of every burst and matches each with the next.
fn matched(way: &Trajectory, detector: &DetectorParams) -> Matched {
    matched_again(way, detector, false)
}

/// Finds the features of every burst and matches each with the next, again where their motions put it if `predict`.
fn matched_again(way: &Trajectory, detector: &DetectorParams, predict: bool) -> Matched {
    let monitor = Monitor::default();
    let found: Vec<Detection> = (0..way.cameras.len())
        .map(|index| detect(&way.burst(index, &monitor).expect("a burst"), detector, &monitor).expect("a detection"))
        .collect();
    let camera = Camera {
        model: CameraModel::Pinhole,
        width: way.lens.width,
        height: way.lens.height,
        params: way.lens.colmap_params().to_vec(),
    };
    let matching = MatchParams { geometry: Geometry::Essential, camera: Some(camera), ..MatchParams::default() };
    let matching = MatchParams { predict, align: false, ..matching };
    let mut sum = Matched::default();
    for (index, pair) in found.windows(2).enumerate() {
        let sides = [BurstSide::from(&pair[0]), BurstSide::from(&pair[1])];
        let result = match_pair(sides.each_ref().map(BurstSide::side), &matching, &monitor).expect("matched");
        sum.inliers += result.counts.inliers.unwrap_or(0);
        sum.right += result
            .matches
            .iter()
            .filter(|m| {
                let (a, b) = (&pair[0].features[m.a], &pair[1].features[m.b]);
                let from = &way.cameras[index].world_from_camera;
                let point = nearest_point(&way.planes, &way.lens, from, f64::from(a.u), f64::from(a.v));
                let seen = point.and_then(|point| way.cameras[index + 1].pixel_of(&way.lens, &point, 0.0));
                seen.is_some_and(|[u, v]| (u - f64::from(b.u)).hypot(v - f64::from(b.v)) < RIGHT_PX)
            })
            .count();
    }
    sum
}

/// The merge with its best settings: no peak threshold, two orientations.
fn merge() -> DetectorParams {
    DetectorParams { method: Method::Merge, peak_threshold: 0.0, max_orientations: 2, ..DetectorParams::default() }
}

/// Asserts that in the dark burst features have at least 1.5 times as many inliers as the merged burst, and 1.5 times
/// as many right ones.
fn assert_burst_features_win(way: &Trajectory, slopes: SlopeGrid) {
    let buff = matched(way, &DetectorParams { slopes, ..DetectorParams::default() });
    let merge = matched(way, &merge());
    println!("BuFF {buff:?}, merge {merge:?}");
    assert!(2 * buff.inliers >= 3 * merge.inliers, "BuFF {buff:?}, merge {merge:?}");
    assert!(2 * buff.right >= 3 * merge.right, "BuFF {buff:?}, merge {merge:?}");
    assert!(buff.inliers >= 60 && 10 * buff.right >= 7 * buff.inliers, "BuFF {buff:?}");
}

#[test]
fn past_and_into_a_dark_scene_burst_features_match_where_a_merge_does_not() {
    assert_burst_features_win(&dark_way(Motion::OneD), SlopeGrid::line(-3.0..=0.0, 7));
    assert_burst_features_win(&dark_way(Motion::TwoD), SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7));
}

#[test]
fn pooled_descriptors_and_motions_find_more_right_matches() {
    let way = dark_way(Motion::OneD);
    let pooled = DetectorParams { slopes: SlopeGrid::line(-3.0..=0.0, 7), ..DetectorParams::default() };
    let alone = matched(&way, &DetectorParams { describe_scales: 1, ..pooled.clone() });
    let (plain, predicted) = (matched(&way, &pooled), matched_again(&way, &pooled, true));
    println!("one scale {alone:?}, pooled {plain:?}, predicted {predicted:?}");
    assert!(10 * plain.right >= 11 * alone.right, "one scale {alone:?}, pooled {plain:?}");
    assert!(10 * predicted.right >= 12 * plain.right, "pooled {plain:?}, predicted {predicted:?}");
}
