use super::*;
use crate::burst::Burst;
use crate::detector::NoiseGate;
use crate::detector::feature::{Feature, StageTimes};
use crate::detector::pipeline::search;
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::synth::{ChartParams, Light, Trajectory, TrajectoryParams, synth_chart};

const SIZE: (usize, usize) = (1000, 1000);

/// Detection with features at the given slopes of the grid, and a tally of 10 million samples.
fn detection(grid: SlopeGrid, slope_indices: &[usize], rejected: &[(Test, u64)]) -> Detection {
    let feature = |&slope_index: &usize| {
        let (i, j) = grid.coordinates(slope_index);
        Feature {
            u: 10.0,
            v: 10.0,
            sigma: 2.0,
            orientation: 0.0,
            slope: grid.slope(slope_index),
            response: -0.01,
            snr: 9.0,
            octave: 0,
            level: 1,
            slope_index,
            at_slope_limit: grid.on_rim(i, j),
        }
    };
    let mut tally = Tally { samples: 10_000_000, kept: slope_indices.len() as u64, ..Tally::default() };
    for &(test, count) in rejected {
        tally.reject(test, count);
    }
    Detection {
        features: slope_indices.iter().map(feature).collect(),
        descriptors: vec![[0; 128]; slope_indices.len()],
        tally,
        frame_noise: 0.01,
        noise: std::sync::Arc::default(),
        noise_gate_factor: 4.96,
        slopes: grid,
        frames_used: 0..10,
        octaves: 0..6,
        times: StageTimes::default(),
    }
}

fn advice(params: &DetectorParams, indices: &[usize], rejected: &[(Test, u64)]) -> Option<Advice> {
    explain(&detection(params.used_slopes(), indices, rejected), params, SIZE)
}

#[test]
fn enough_features_away_from_the_limit_need_no_advice() {
    let spread: Vec<usize> = (0..70).map(|k| k % 7).collect();
    assert_eq!(advice(&DetectorParams::default(), &spread, &[(Test::NoiseGate, 9_999_000)]), None);
    // On a plane of 7×7 slopes half of them are on the rim, and half of the features by chance.
    let plane = SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7);
    let spread: Vec<usize> = (0..490).map(|k| k % 49).collect();
    assert_eq!(advice(&DetectorParams { slopes: plane, ..DetectorParams::default() }, &spread, &[]), None);
}

#[test]
fn most_at_the_limit_asks_for_a_wider_range_on_that_side() {
    let most_left: Vec<usize> = (0..100).map(|k| if k < 60 { 0 } else { 1 + k % 6 }).collect();
    let found = advice(&DetectorParams::default(), &most_left, &[]).expect("advice");
    assert_eq!((found.parameter, found.value.as_str()), (doc::SLOPES_U, "-6:3:10"));
    let said = "50 of the 50 strongest features lie at the limit of the slopes, 50 of them at u -3 px/frame";
    assert!(found.problem.starts_with(said), "{}", found.problem);
    let slopes = SlopeGrid::plane(-1.0..=1.0, 5, -2.0..=2.0, 9);
    let params = DetectorParams { slopes, ..DetectorParams::default() };
    let lowest: Vec<usize> = (0..100).map(|k| if k < 90 { 8 * 5 + k % 5 } else { 12 }).collect();
    let found = advice(&params, &lowest, &[]).expect("advice");
    assert_eq!((found.parameter, found.value.as_str()), (doc::SLOPES_V, "-2:4:13"));
    assert!(found.for_window().ends_with("; try Slopes v -2:4:13"), "{}", found.for_window());
    assert!(found.value.parse::<SlopeAxis>().is_ok_and(|axis| (axis.step() - slopes.v.step()).abs() < 1e-6));
    // Too few to mention, and an image that has no slopes.
    assert_eq!(advice(&DetectorParams::default(), &[0; 9], &[]).filter(|a| a.parameter == doc::SLOPES_U), None);
    let sift = DetectorParams { method: Method::Sift, ..DetectorParams::default() };
    assert_eq!(advice(&sift, &[0; 90], &[]), None);
}

#[test]
fn the_peak_threshold_is_to_blame_where_the_gate_had_nothing_left_to_do() {
    let params = DetectorParams { peak_threshold: 0.0003, ..DetectorParams::default() };
    let rejected = [(Test::PeakThreshold, 9_999_926), (Test::NoiseGate, 60), (Test::SpaceExtremum, 14)];
    let found = advice(&params, &[], &rejected).expect("advice");
    assert_eq!((found.parameter, found.value.as_str()), (doc::PEAK_THRESHOLD, "0"));
    assert_eq!(
        found.for_command(),
        "no feature was found: of 10 000 000 samples 9 999 926 were rejected as below the peak threshold of 0.0003; \
         try --peak-threshold 0"
    );
    // Where it let much noise pass, the gate is.
    let rejected = [(Test::PeakThreshold, 4_000_000), (Test::NoiseGate, 5_999_990), (Test::SpaceExtremum, 10)];
    let found = advice(&params, &[], &rejected).expect("advice");
    assert_eq!((found.parameter, found.value.as_str()), (doc::NOISE_GATE, "4"));
    assert!(found.problem.contains("of 6 000 000 samples 5 999 990 were rejected as below the noise gate of 4.96 σ"));
}

#[test]
fn the_gate_names_what_would_see_more() {
    let rejected = [(Test::NoiseGate, 9_999_990), (Test::SpaceExtremum, 10)];
    let none = DetectorParams { peak_threshold: 0.0, ..DetectorParams::default() };
    assert_eq!(advice(&none, &[], &rejected).expect("advice").parameter, doc::NOISE_GATE);
    let sift = DetectorParams { method: Method::Sift, ..none.clone() };
    assert_eq!(advice(&sift, &[], &rejected).expect("advice").value, "buff");
    let low = DetectorParams { noise_gate: NoiseGate::Factor(3.5), ..none };
    let found = Detection { noise_gate_factor: 3.5, ..detection(low.slopes, &[3], &rejected) };
    let found = explain(&found, &low, SIZE).expect("advice");
    assert_eq!((found.parameter, found.value.as_str()), (doc::SLOPES_U, "-6:6:13"));
    assert!(found.problem.starts_with("only 1 feature was found: "), "{}", found.problem);
}

#[test]
fn a_later_test_that_takes_more_than_usual_is_named() {
    let params = DetectorParams::default();
    let above = [(Test::NoiseGate, 9_900_000), (Test::SpaceExtremum, 95_000), (Test::ScaleExtremum, 2_000)];
    let edge = [&above[..], &[(Test::SlopeExtremum, 1_000), (Test::Edge, 1_990)]].concat();
    let found = advice(&params, &[3; 10], &edge).expect("advice");
    assert_eq!((found.parameter, found.value.as_str()), (doc::EDGE_THRESHOLD, "18"));
    assert!(
        found.problem.starts_with("only 10 features were found: of 2 000 samples 1 990 were rejected as on an edge")
    );
    let slope = [&above[..], &[(Test::SlopeExtremum, 2_990)]].concat();
    let found = advice(&params, &[3; 10], &slope).expect("advice");
    assert_eq!((found.parameter, found.value.as_str()), (doc::SLOPES_U, "-3:3:4"));
    // A search that asks for few features has enough.
    let cut = [&above[..], &[(Test::MaxFeatures, 2_990)]].concat();
    assert_eq!(advice(&params, &[3; 10], &cut), None);
}

#[test]
fn made_bursts_are_explained() {
    // A dark scene under the former peak threshold.
    let light = Light::Electrons(1.2);
    let dark = TrajectoryParams { width: 240, height: 180, bursts: 1, light, ..TrajectoryParams::default() };
    let burst = Trajectory::new(&dark, &Monitor::default()).expect("a scene").burst(0, &Monitor::default());
    let burst = burst.expect("a burst");
    let found = |burst: &Burst, params: &DetectorParams| {
        let detection = search(burst, params, &Monitor::default()).expect("a detection");
        explain(&detection, params, burst.size())
    };
    let peak = DetectorParams { peak_threshold: 0.003, ..DetectorParams::default() };
    assert_eq!(found(&burst, &peak).expect("advice").parameter, doc::PEAK_THRESHOLD);
    // Noise alone.
    let chart = ChartParams { width: 240, height: 180, discs: 0, snr: 0.3, ..ChartParams::default() };
    let (noise, _) = synth_chart(&chart, &Monitor::default()).expect("a chart");
    let open = DetectorParams { peak_threshold: 0.0, noise_gate: NoiseGate::Factor(5.5), ..DetectorParams::default() };
    assert_eq!(found(&noise, &open).expect("advice").parameter, doc::NOISE_GATE);
    // Everything moves faster than the range.
    let chart = ChartParams { discs: 16, radius: 3.6..=8.0, max_slope: 0.0, snr: 8.0, ..chart };
    let (still, _) = synth_chart(&chart, &Monitor::default()).expect("a chart");
    let beside = DetectorParams { slopes: SlopeGrid::line(0.3..=2.7, 9), ..open };
    let advice = found(&still, &beside).expect("advice");
    assert_eq!((advice.parameter, advice.value.as_str()), (doc::SLOPES_U, "-0.9:2.7:13"), "{}", advice.problem);
    // An even picture has no remedy, and nothing breaks.
    let even = Burst::from_planes("even", vec![Plane::zeros(64, 48); 4]);
    assert!(found(&even, &DetectorParams::default()).is_none_or(|advice| !advice.problem.is_empty()));
}

#[test]
fn counts_are_grouped_by_thousands() {
    assert_eq!([0, 7, 999, 1000, 12_345_678].map(grouped), ["0", "7", "999", "1 000", "12 345 678"]);
}
