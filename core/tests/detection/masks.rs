//! Masks: what they hide gives no features, and what they show is found as without them.

use crate::prelude::*;
use burstscope_core::detector::view::{coverage_view, stack_view};

fn masked(burst: &Burst, sees: impl Fn(usize, usize, usize) -> bool) -> Burst {
    let frame = |(t, frame): (usize, &Arc<Plane>)| {
        let weights = Plane::from_fn(frame.width(), frame.height(), |u, v| f32::from(sees(t, u, v)));
        Arc::new(Plane::clone(frame).masked(Mask::new(weights)))
    };
    Burst { frames: burst.frames.iter().enumerate().map(frame).collect(), ..burst.clone() }
}

fn found(burst: &Burst, params: &DetectorParams) -> Detection {
    detect(burst, params, &quiet()).expect("valid parameters")
}

fn scene(seed: u64) -> Burst {
    let params = SceneParams { width: 320, height: 240, frames: 8, snr: 1.5, seed, ..SceneParams::default() };
    synth_scene(&params, &quiet()).expect("valid parameters").0
}

/// White noise and a given gate: the local model measures other squares where some are hidden.
fn fixed() -> DetectorParams {
    DetectorParams {
        slopes: SlopeGrid::line(-1.5..=1.5, 5),
        noise_model: NoiseModelKind::White,
        noise_gate: NoiseGate::Factor(4.5),
        octaves: 3,
        max_orientations: 1,
        ..DetectorParams::default()
    }
}

fn is_partner(a: &Feature, b: &Feature) -> bool {
    (a.u - b.u).hypot(a.v - b.v) < 0.02
        && (a.sigma / b.sigma - 1.0).abs() < 0.01
        && (a.response / b.response - 1.0).abs() < 0.01
}

#[test]
fn far_from_the_edge_of_a_mask_features_are_those_without_it() {
    let (burst, params) = (scene(3), fixed());
    let (before, after) = (found(&burst, &params), found(&masked(&burst, |_, u, _| u >= 120), &params));
    // Filters read 4 σ of the next level but one, and frames are shifted by up to 5 pixels.
    let is_far = |f: &&Feature| f.u - 120.0 > 6.0 + 8.0 * f.sigma;
    // The noise is measured on fewer pixels: what only just passes one gate may not pass the other.
    let sure = |f: &&Feature| is_far(f) && f.snr > 4.7;
    let (of_before, of_after): (Vec<&Feature>, Vec<&Feature>) =
        (before.features.iter().filter(sure).collect(), after.features.iter().filter(sure).collect());
    assert!(of_before.len() > 60, "{}", of_before.len());
    let kept = |all: &[Feature], f: &Feature| all.iter().any(|other| is_partner(f, other));
    for (name, sure, all) in [("lost", &of_before, &after.features), ("new", &of_after, &before.features)] {
        let odd: Vec<_> = sure.iter().filter(|f| !kept(all, f)).map(|f| (f.u, f.v, f.sigma, f.snr)).collect();
        assert!(odd.is_empty(), "{name}: {odd:?}");
    }
    // A slope moves the mask with the frames: a disc that is mostly hidden in all frames lies left of all edges.
    assert!(after.features.iter().all(|f| f.u > 120.0 - 6.0 - f.sigma), "nothing is found behind the mask");
    assert!(before.features.iter().filter(|f| f.u < 105.0).count() > 50);
    assert!(after.tally.rejected_by(Test::Seen) > 0);
    assert_eq!(before.tally.rejected_by(Test::Seen), 0);
}

#[test]
fn a_transposed_mask_gives_transposed_features() {
    let sees = |t: usize, u: usize, v: usize| (u as f32 - 150.0 - 3.0 * t as f32).hypot(v as f32 - 110.0) > 45.0;
    let burst = masked(&scene(5), sees);
    let transposed = |plane: &Plane| Plane::from_fn(plane.height(), plane.width(), |u, v| plane.at(v, u));
    let turned = burst.frames.iter().map(|frame| {
        let mask = frame.mask().and_then(|mask| Mask::new(transposed(mask.weights())));
        Arc::new(transposed(frame).masked(mask))
    });
    let turned = Burst { frames: turned.collect(), ..burst.clone() };
    let params = fixed();
    let other =
        DetectorParams { slopes: SlopeGrid { u: params.slopes.v, v: params.slopes.u, direction_deg: 0.0 }, ..fixed() };
    let (a, b) = (found(&burst, &params), found(&turned, &other));
    let flipped = |f: &Feature| Feature { u: f.v, v: f.u, ..*f };
    let kept = a.features.iter().filter(|f| b.features.iter().any(|other| is_partner(&flipped(f), other))).count();
    assert!(a.features.len() > 80 && kept as f32 > 0.98 * a.features.len() as f32, "{kept} of {}", a.features.len());
}

#[test]
fn the_stack_is_of_the_frames_that_see_and_a_masked_half_does_not_change_the_noise() {
    let frames = (0..4).map(|t| Plane::from_fn(60, 40, |_, _| 0.1 * (t + 1) as f32)).collect();
    // Frames 0 and 1 are hidden in the middle, all frames in a corner.
    let hides = |t: usize, u: usize, v: usize| (t < 2 && (20..40).contains(&u)) || (u < 5 && v < 5);
    let burst = masked(&Burst::from_planes("steps", frames), |t, u, v| !hides(t, u, v));
    let params = DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 3), ..fixed() };
    let (slope, monitor) = (Slope::default(), Monitor::default());
    let stack = stack_view(&burst, &params, slope, &monitor).expect("not cancelled");
    let share = coverage_view(&burst, &params, slope, &monitor).expect("valid");
    for ((u, v), value, covered) in [((10, 20), 0.25, 1.0), ((30, 20), 0.35, 0.5), ((2, 2), 0.25, 0.0)] {
        assert!((stack.at(u, v) - value).abs() < 1e-3, "({u}, {v}): {}", stack.at(u, v));
        assert_eq!(share.at(u, v), covered, "({u}, {v})");
    }
    for noise_model in [NoiseModelKind::White, NoiseModelKind::Local] {
        let params = DetectorParams { noise_model, ..fixed() };
        let burst = scene(9);
        let [whole, half] =
            [burst.clone(), masked(&burst, |t, u, _| u > 100 + 4 * t)].map(|burst| found(&burst, &params).frame_noise);
        assert!((half / whole - 1.0).abs() < 0.05, "{noise_model:?}: {half} {whole}");
    }
}

/// A textured arm over the left half of a dark chart, still in all frames.
fn with_arm(burst: &Burst, edge: usize) -> Burst {
    let mut stream = Stream::new(7, 1);
    let (width, height) = burst.size();
    let spots: Vec<[f32; 4]> = (0..900)
        .map(|_| {
            let mut within = |min: f64, max: f64| stream.within(min, max) as f32;
            [within(0.0, edge as f64), within(0.0, height as f64), within(1.5, 6.0), within(-0.06, 0.12)]
        })
        .collect();
    let arm = Plane::from_fn(edge, height, |u, v| {
        spots
            .iter()
            .map(|[x, y, radius, light]| {
                let r2 = ((u as f32 - x).powi(2) + (v as f32 - y).powi(2)) / (2.0 * radius * radius);
                if r2 < 12.0 { light * (-r2).exp() } else { 0.0 }
            })
            .sum::<f32>()
    });
    let frame = |frame: &Arc<Plane>| {
        Arc::new(Plane::from_fn(width, height, |u, v| frame.at(u, v) + if u < edge { arm.at(u, v) } else { 0.0 }))
    };
    Burst { frames: burst.frames.iter().map(frame).collect(), ..burst.clone() }
}

/// Numbers of discs right of the edge that are found, and of features up to 40 pixels from it that are none.
fn right_of(edge: usize, found: &Detection, truth: &Truth) -> (usize, usize) {
    let is_of = |f: &Feature, u: f64, v: f64, radius: f64, sigma: f64| {
        (f64::from(f.u) - u).hypot(f64::from(f.v) - v) < radius && (f64::from(f.sigma) / sigma).ln().abs() < 0.5
    };
    let features: Vec<&Feature> = found.features.iter().filter(|f| f.u > edge as f32).collect();
    let discs = truth.features.iter().filter(|disc| disc.u - disc.radius > edge as f64 + 20.0);
    let seen = discs.filter(|d| features.iter().any(|f| is_of(f, d.u, d.v, d.radius, d.sigma))).count();
    let beside = |f: &&&Feature| f.u < edge as f32 + 40.0;
    let no_disc = |f: &&&Feature| !truth.features.iter().any(|d| is_of(f, d.u, d.v, d.radius, d.sigma));
    (seen, features.iter().filter(beside).filter(no_disc).count())
}

#[test]
fn an_arm_that_is_masked_gives_no_features_at_its_edge() {
    let (edge, seeds) = (400, 1..=3);
    let mut sums = [(0, 0); 3];
    for seed in seeds.clone() {
        let chart = ChartParams { snr: 0.35, seed, ..ChartParams::default() };
        let (burst, truth) = synth_chart(&chart, &quiet()).expect("a chart");
        let params = DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, 13), ..DetectorParams::default() };
        let arm = with_arm(&burst, edge);
        let hidden = masked(&arm, |_, u, _| u >= edge);
        for (sum, burst) in sums.iter_mut().zip([&burst, &arm, &hidden]) {
            let (discs, others) = right_of(edge, &found(burst, &params), &truth);
            *sum = (sum.0 + discs, sum.1 + others);
        }
    }
    let mean = |count: usize| count as f64 / seeds.clone().count() as f64;
    let [alone, arm, hidden] = sums.map(|(discs, others)| (mean(discs), mean(others)));
    println!("discs and false features beside the edge: {alone:?} without an arm, {arm:?} with it, {hidden:?} masked");
    assert!(hidden.1 < 0.6 * arm.1 && hidden.1 < 1.2 * alone.1, "{alone:?} {arm:?} {hidden:?}");
    assert!(hidden.0 > 0.9 * alone.0, "{alone:?} {hidden:?}");
}
