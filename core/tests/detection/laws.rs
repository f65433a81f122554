//! The laws of the detector: properties that hold for every burst.
//!
//! The bursts are textures of random blobs that move at two slopes under a little noise, so that there are features at
//! several scales and slopes. Features are compared as sets: equal count, each with a partner near the position that
//! the law predicts.

use super::inspect::probing::blobs as gaussians;
use crate::prelude::*;
use burstscope_core::detector::view::{dog_view, stack_view};
use proptest::test_runner::RngSeed;

const SIZE: (usize, usize) = (128, 96);

/// A burst of `n` frames of random blobs, half of them moving by `slope_a`, half by `slope_b`.
fn blobs(seed: u64, n: usize, slope_a: Slope, slope_b: Slope) -> Burst {
    let mut rng = Stream::new(seed, 0);
    let blobs: Vec<(f32, f32, f32, f32, Slope)> = (0..28)
        .map(|i| {
            let sign = if rng.uniform() < 0.5 { 1.0 } else { -1.0 };
            (
                rng.within(14.0, SIZE.0 as f64 - 14.0) as f32,
                rng.within(14.0, SIZE.1 as f64 - 14.0) as f32,
                rng.within(1.8, 5.0) as f32,
                sign * rng.within(0.05, 0.3) as f32,
                if i % 2 == 0 { slope_a } else { slope_b },
            )
        })
        .collect();
    let frames = (0..n)
        .map(|t| {
            let dt = t as f32 - (n as f32 - 1.0) / 2.0;
            Plane::from_fn(SIZE.0, SIZE.1, |u, v| {
                let mut value = 0.5 + 0.004 * (rng.uniform() as f32 - 0.5);
                for &(bu, bv, radius, height, slope) in &blobs {
                    let (du, dv) = (u as f32 - bu - dt * slope.u, v as f32 - bv - dt * slope.v);
                    let r2 = (du * du + dv * dv) / (2.0 * radius * radius);
                    if r2 < 12.0 {
                        value += height * (-r2).exp();
                    }
                }
                value
            })
        })
        .collect();
    Burst::from_planes("blobs", frames)
}

fn two_slopes(seed: u64, n: usize) -> Burst {
    // Not half-way between slopes of the grids below, where rounding decides which of two neighbours is the larger.
    blobs(seed, n, Slope::new(0.8, 0.1), Slope::new(-0.7, 0.7))
}

fn map_frames(burst: &Burst, f: impl Fn(&Plane) -> Plane) -> Burst {
    Burst::from_planes("mapped", burst.frames.iter().map(|p| f(p)).collect())
}

fn found(burst: &Burst, params: &DetectorParams) -> Detection {
    detect(burst, params, &quiet()).expect("valid parameters")
}

fn inside(detection: &Detection, margin: f32) -> Vec<Feature> {
    let keep = |f: &&Feature| {
        f.u >= margin && f.v >= margin && f.u <= SIZE.0 as f32 - 1.0 - margin && f.v <= SIZE.1 as f32 - 1.0 - margin
    };
    detection.features.iter().filter(keep).copied().collect()
}

/// Features well above the thresholds: sums in another order round differently, which may change the outcome for a
/// feature at a threshold.
fn clear(detection: &Detection, params: &DetectorParams) -> Vec<Feature> {
    let keep =
        |f: &&Feature| f.response.abs() > 1.1 * params.peak_threshold && f.snr > 1.1 * detection.noise_gate_factor;
    detection.features.iter().filter(keep).copied().collect()
}

/// Tolerance where rounding decides whether the refinement moves on by a pixel: the fit around another sample differs
/// by up to a tenth of a pixel.
const ROUNDING_PX: f32 = 0.1;

/// Asserts that each of `theirs`, after `mapped`, has a partner in `ours` within `tolerance` px, 1 % of scale, and
/// `tolerance` px/frame.
fn assert_all_found(ours: &[Feature], theirs: &[Feature], mapped: impl Fn(&Feature) -> Feature, tolerance: f32) {
    assert!(theirs.len() >= 4, "only {} features: the law would hold for nothing", theirs.len());
    let are_one = |f: &Feature, t: &Feature| {
        (f.u - t.u).hypot(f.v - t.v) <= tolerance
            && (f.sigma / t.sigma - 1.0).abs() <= 0.01 + 0.1 * tolerance
            && (f.slope.u - t.slope.u).hypot(f.slope.v - t.slope.v) <= tolerance
            && (f.response / t.response - 1.0).abs() <= 0.01
    };
    let missing: Vec<&Feature> =
        theirs.iter().filter(|theirs| !ours.iter().any(|f| are_one(f, &mapped(theirs)))).collect();
    // About one feature in ten thousand lies on the limit of a test (edge ratio, convergence) and is decided by
    // rounding.
    assert!(missing.len() <= usize::from(tolerance >= ROUNDING_PX), "of {} none for {missing:?}", theirs.len());
}

/// Parameters with the white noise model. The laws are about the search; the other noise model depends on the squares
/// and frames that it measures, and these do not move with the burst.
fn plane_grid() -> DetectorParams {
    DetectorParams {
        noise_model: NoiseModelKind::White,
        slopes: SlopeGrid::plane(-1.5..=1.5, 4, -1.0..=1.0, 3),
        peak_threshold: 0.004,
        max_orientations: 1,
        ..DetectorParams::default()
    }
}

/// The joint rule of the paper, all keypoints kept.
fn joint(params: DetectorParams) -> DetectorParams {
    DetectorParams { slope_extrema: SlopeExtrema::Joint, distinct: Distinct::Off, ..params }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, rng_seed: RngSeed::Fixed(2209_09470), ..ProptestConfig::default() })]

    #[test]
    fn shifting_the_burst_shifts_the_features(seed in 0u64..1000) {
        let burst = two_slopes(seed, 5);
        // Eight pixels are whole pixels of octaves 0 to 3, so that the sampling of coarse octaves moves along.
        let shifted = map_frames(&burst, |p| Plane::from_fn(SIZE.0, SIZE.1, |u, v| p.get(u as i64 - 8, v as i64 - 8).unwrap_or(0.5)));
        let params = DetectorParams { octaves: 3, ..plane_grid() };
        let (a, b) = (found(&burst, &params), found(&shifted, &params));
        let far: Vec<Feature> = inside(&a, 34.0).into_iter().filter(|f| f.sigma < 4.0 && f.response.abs() > 0.01).collect();
        prop_assume!(far.len() >= 4);
        assert_all_found(&b.features, &far, |f| Feature { u: f.u + 8.0, v: f.v + 8.0, ..*f }, 0.02);
    }

    #[test]
    fn reversing_time_turns_the_slopes_round(seed in 0u64..1000) {
        let burst = two_slopes(seed, 4);
        let mut reversed = burst.clone();
        reversed.frames.reverse();
        let grid = SlopeGrid::plane(-1.5..=1.5, 4, -1.0..=1.0, 3);
        let params = DetectorParams { slopes: grid, ..plane_grid() };
        let (a, b) = (found(&burst, &params), found(&reversed, &params));
        prop_assert!(a.features.len().abs_diff(b.features.len()) <= 2, "{} {}", a.features.len(), b.features.len());
        let turned = |f: &Feature| Feature { slope: Slope::new(-f.slope.u, -f.slope.v), ..*f };
        assert_all_found(&b.features, &clear(&a, &params), turned, ROUNDING_PX);
    }

    #[test]
    fn transposing_the_frames_transposes_the_features(seed in 0u64..1000) {
        let burst = two_slopes(seed, 4);
        let transposed = map_frames(&burst, |p| Plane::from_fn(SIZE.1, SIZE.0, |u, v| p.at(v, u)));
        let params = plane_grid();
        let other = DetectorParams { slopes: SlopeGrid { u: params.slopes.v, v: params.slopes.u, direction_deg: 0.0 }, ..plane_grid() };
        let (a, b) = (found(&burst, &params), found(&transposed, &other));
        prop_assert!(a.features.len().abs_diff(b.features.len()) <= 2, "{} {}", a.features.len(), b.features.len());
        let flipped = |f: &Feature| Feature { u: f.v, v: f.u, slope: Slope::new(f.slope.v, f.slope.u), ..*f };
        assert_all_found(&b.features, &clear(&a, &params), flipped, ROUNDING_PX);
    }

    #[test]
    fn turning_the_frames_turns_the_features(seed in 0u64..1000) {
        // By 90° from +u towards +v: (u, v) goes to (H−1−v, u). One octave, since coarser ones start from the top-left
        // pixel.
        let burst = two_slopes(seed, 4);
        let turned = map_frames(&burst, |p| Plane::from_fn(SIZE.1, SIZE.0, |u, v| p.at(v, SIZE.1 - 1 - u)));
        let params = DetectorParams { octaves: 1, ..plane_grid() };
        let grid = SlopeGrid { direction_deg: 90.0, ..params.slopes };
        let (a, b) = (found(&burst, &params), found(&turned, &DetectorParams { slopes: grid, ..params.clone() }));
        prop_assert!(a.features.len().abs_diff(b.features.len()) <= 2, "{} {}", a.features.len(), b.features.len());
        let turn = |f: &Feature| Feature {
            u: SIZE.1 as f32 - 1.0 - f.v, v: f.u, slope: Slope::new(-f.slope.v, f.slope.u), ..*f
        };
        assert_all_found(&b.features, &clear(&a, &params), turn, ROUNDING_PX);
    }

    #[test]
    fn brighter_frames_have_the_same_features(seed in 0u64..1000, gain in 0.3f32..3.0) {
        let burst = two_slopes(seed, 4);
        let brighter = map_frames(&burst, |p| Plane::from_fn(SIZE.0, SIZE.1, |u, v| gain * p.at(u, v)));
        let params = plane_grid();
        let scaled = DetectorParams { peak_threshold: gain * params.peak_threshold, ..plane_grid() };
        let (a, b) = (found(&burst, &params), found(&brighter, &scaled));
        prop_assert!(a.features.len().abs_diff(b.features.len()) <= 1, "{} {}", a.features.len(), b.features.len());
        let louder = |f: &Feature| Feature { response: gain * f.response, ..*f };
        assert_all_found(&b.features, &clear(&a, &params), louder, ROUNDING_PX);
    }

    #[test]
    fn a_slope_more_outside_loses_nothing_inside(seed in 0u64..1000) {
        let burst = two_slopes(seed, 5);
        // The gate is fixed: the automatic one rises with the size of the search.
        // Nor are keypoints compared with stronger ones, which the new slope may have.
        let base = DetectorParams { noise_gate: NoiseGate::Factor(5.0), distinct: Distinct::Off, ..plane_grid() };
        let narrow = DetectorParams { slopes: SlopeGrid::line(-1.5..=1.5, 7), ..base.clone() };
        let wide = DetectorParams { slopes: SlopeGrid::line(-2.0..=1.5, 8), ..base };
        let (a, b) = (found(&burst, &narrow), found(&burst, &wide));
        let interior: Vec<Feature> = a.features.iter().filter(|f| !f.is_on_rim(&narrow)).copied().collect();
        assert_all_found(&b.features, &interior, |f| *f, 0.001);
    }
}

/// Asserts that there are more than `least` features, with the same bits on one thread and on as many as are given.
fn assert_same_on_threads(burst: &Burst, params: &DetectorParams, least: usize, counts: &[usize]) {
    let one = on_threads(1, || found(burst, params));
    assert!(one.features.len() > least, "{}", one.features.len());
    for threads in counts {
        let many = on_threads(*threads, || found(burst, params));
        assert_eq!((&one.features, &one.descriptors, one.tally), (&many.features, &many.descriptors, many.tally));
    }
}

#[test]
fn tiles_and_any_number_of_threads_give_the_same_bits() {
    let burst = two_slopes(3, 6);
    let rules = Rules { slope_neighbours: SlopeNeighbours::All, ..Rules::default() };
    for params in [
        plane_grid(),
        DetectorParams { first_octave: -1, max_orientations: 4, ..plane_grid() },
        joint(plane_grid()),
        DetectorParams { rules, ..joint(plane_grid()) },
    ] {
        assert_same_on_threads(&burst, &params, 10, &[2, 3, 7]);
    }
    // Wide enough for a few tiles, whose height depends on the number of threads.
    let scene = SceneParams { width: 640, height: 440, snr: 8.0, seed: 5, ..SceneParams::default() };
    let (burst, _) = synth_scene(&scene, &quiet()).expect("valid parameters");
    // Whole and half columns a frame, and other fractions.
    for slopes in [SlopeGrid::line(-3.0..=3.0, 7), SlopeGrid::line(-1.7..=2.0, 5)] {
        let params = DetectorParams { slopes, peak_threshold: 0.0015, ..DetectorParams::default() };
        assert_same_on_threads(&burst, &params, 100, &[2, 16]);
    }
}

#[test]
fn one_frame_is_sift_and_the_tally_accounts_for_every_sample_unless_it_is_cancelled() {
    let burst = two_slopes(11, 5);
    let sift = found(&burst, &DetectorParams { method: Method::Sift, ..plane_grid() });
    let alone = Burst { frames: vec![burst.frames[2].clone()], ..burst.clone() };
    let buff = found(&alone, &DetectorParams { slopes: SlopeGrid::single(Slope::default()), ..plane_grid() });
    assert!(sift.features.len() > 5);
    assert_eq!((sift.features, sift.descriptors), (buff.features, buff.descriptors));
    let detection = found(&two_slopes(9, 5), &plane_grid());
    let tally = detection.tally;
    assert_eq!(tally.samples, tally.rejected.iter().sum::<u64>() + tally.kept);
    assert_eq!(tally.kept as usize, detection.features.len());
    assert!(detect(&two_slopes(1, 3), &plane_grid(), &cancelled()).is_err_and(|error| error.is_cancelled()));
}

#[test]
fn stacking_and_filtering_commute() {
    // Away from borders the DoG of the stack is the stack of the frames' DoGs.
    let burst = two_slopes(5, 5);
    let (params, slope) = (plane_grid(), Slope::new(0.7, -0.4));
    let dog = |burst: &Burst, slope| dog_view(burst, &params, slope, 0, 1, &quiet()).expect("valid");
    let one = |frame: &Arc<Plane>| Burst { frames: vec![frame.clone()], ..burst.clone() };
    let filtered = burst.frames.iter().map(|frame| dog(&one(frame), Slope::default())).collect();
    let filtered = Burst::from_planes("dogs", filtered);
    let (stacked_first, filtered_first) =
        (dog(&burst, slope), stack_view(&filtered, &params, slope, &quiet()).expect("valid"));
    for (u, v) in (24..SIZE.0 - 24).flat_map(|u| (24..SIZE.1 - 24).map(move |v| (u, v))) {
        assert!((stacked_first.at(u, v) - filtered_first.at(u, v)).abs() < 1e-4);
    }
}

#[test]
fn a_blob_beyond_the_grid_is_marked() {
    let burst = blobs(2, 6, Slope::new(2.4, 0.0), Slope::new(2.4, 0.0));
    let params = DetectorParams { slopes: SlopeGrid::line(-1.5..=1.5, 7), ..plane_grid() };
    let detection = found(&burst, &joint(params.clone()));
    assert!(!detection.features.is_empty());
    let strong = &detection.features[..detection.features.len().div_ceil(2)];
    assert!(strong.iter().all(|f| f.is_on_rim(&params) || f.slope.u < 1.0), "{strong:?}");
    assert!(strong.iter().any(|f| f.at_slope_limit));
    // When each slope is searched for itself a blob also leaves weaker smears at slopes farther from its own. Its slope
    // is refined to the end of the grid, from the last slope or the one before.
    let detection = found(&burst, &params);
    assert_eq!(detection.features[0].slope.u, 1.5);
    assert!(detection.features[0].at_slope_limit);
    let grid = params.slopes;
    let on_rim = |f: &&Feature| grid.on_rim(f.slope_index, 0);
    for feature in &detection.features {
        assert_eq!(feature.is_on_rim(&params), on_rim(&feature) || grid.nearest_on_rim(feature.slope), "{feature:?}");
        assert!(!feature.at_slope_limit || feature.is_on_rim(&params), "{feature:?}");
    }
    let from_before_the_rim = detection.features.iter().filter(|f| f.is_on_rim(&params) && !on_rim(f));
    assert!(from_before_the_rim.count() > 0, "a smear whose slope leads to the rim");
    // One that moves just as fast as the range reaches is on the rim, and not at the limit.
    let detection = found(&blobs(2, 6, Slope::new(1.5, 0.0), Slope::new(1.5, 0.0)), &params);
    assert!(detection.features[0].is_on_rim(&params) && !detection.features[0].at_slope_limit);
}

#[test]
fn one_blob_has_one_keypoint_whatever_its_place_scale_and_slope() {
    // Across levels and octaves, on the grid's slopes and between them, at the middle and beside a tile's border.
    for radius in [2.0f32, 2.4, 2.9, 3.4, 4.1, 4.9, 5.8] {
        for slope in [Slope::new(0.0, 0.0), Slope::new(0.25, 0.0), Slope::new(-0.5, 0.5), Slope::new(1.0, -1.0)] {
            let (u, v) = (64.3 + radius, 48.0 - 0.7 * radius);
            let burst = gaussians(7, 0.01, &[(u, v, radius, 0.3, slope)]);
            let params = DetectorParams { noise_gate: NoiseGate::Factor(12.0), peak_threshold: 0.0, ..plane_grid() };
            let near = |params: &DetectorParams| {
                let detection = found(&burst, params);
                let near = |f: &&Feature| (f.u - u).hypot(f.v - v) < 1.2 * radius && f.response < 0.0;
                detection.features.iter().filter(near).count()
            };
            assert_eq!(near(&params), 1, "radius {radius}, {slope:?}");
            // Without this step there are more, so the test can fail.
            assert!(near(&DetectorParams { distinct: Distinct::Off, ..params }) > 1, "radius {radius}, {slope:?}");
        }
    }
}

#[test]
fn two_motions_at_one_place_both_stay() {
    // A lantern passes before a brighter spot of a wall, right over it at mid-burst.
    let (wall, lantern) = (Slope::new(-1.5, 0.0), Slope::new(1.5, 1.0));
    let both = gaussians(10, 0.01, &[(64.0, 48.0, 2.5, 0.25, wall), (64.8, 48.5, 2.5, 0.2, lantern)]);
    let params = DetectorParams { noise_gate: NoiseGate::Factor(8.0), peak_threshold: 0.0, ..plane_grid() };
    let has = |burst: &Burst, slope: Slope| {
        let near = |f: &&Feature| {
            (f.u - 64.4).hypot(f.v - 48.2) < 2.0 && (f.slope.u - slope.u).hypot(f.slope.v - slope.v) < 0.3
        };
        found(burst, &params).features.iter().filter(near).count()
    };
    assert_eq!((has(&both, wall), has(&both, lantern)), (1, 1));
    // Alone, the spot leaves no feature at the lantern's slope.
    let alone = gaussians(10, 0.01, &[(64.0, 48.0, 2.5, 0.25, wall)]);
    assert_eq!((has(&alone, wall), has(&alone, lantern)), (1, 0));
}

#[test]
fn a_binned_start_finds_a_blob_where_the_frames_themselves_show_it() {
    let slope = Slope::new(0.6, -0.4);
    // Blobs of scales of the first octave itself.
    for (first_octave, sigma, most_px) in [(1, 7.0, 0.02), (2, 11.0, 0.05)] {
        let frame = |t: usize| {
            let (u0, v0) = (91.3 + (t as f32 - 3.0) * slope.u, 72.6 + (t as f32 - 3.0) * slope.v);
            let square = move |u, v| ((u as f32 - u0).powi(2) + (v as f32 - v0).powi(2)) / (sigma * sigma);
            Plane::from_fn(190, 150, |u, v| 0.2 + 0.5 * (-0.5 * square(u, v)).exp())
        };
        let burst = Burst::from_planes("blob", (0..7).map(frame).collect());
        let strongest = |first_octave| {
            let slopes = SlopeGrid::plane(-1.0..=1.0, 5, -1.0..=1.0, 5);
            // In frames without noise a local model takes the blob's motion for it.
            let noise_model = NoiseModelKind::White;
            let params = DetectorParams { slopes, first_octave, noise_model, ..DetectorParams::default() };
            // By the response: without noise the ratio to it means nothing.
            let found = detect(&burst, &params, &quiet()).expect("valid parameters").features;
            found.into_iter().max_by(|a, b| a.response.abs().total_cmp(&b.response.abs())).expect("the blob")
        };
        let (fine, coarse) = (strongest(0), strongest(first_octave));
        for (place, truth, fine) in [(coarse.u, 91.3, fine.u), (coarse.v, 72.6, fine.v)] {
            assert!((place - truth).abs() < most_px && (place - fine).abs() < most_px, "{coarse:?}");
        }
        assert!((coarse.sigma / fine.sigma - 1.0).abs() < 0.02, "{} {}", coarse.sigma, fine.sigma);
        assert!((coarse.response / fine.response - 1.0).abs() < 0.02, "{} {}", coarse.response, fine.response);
        let off = (coarse.slope.u - slope.u).hypot(coarse.slope.v - slope.v);
        assert!(off < 0.02 && coarse.octave == first_octave, "{coarse:?}");
    }
}
