//! Judgement of what a search left: after a change of thresholds, of the rule for distinct keypoints or of the number
//! of features it gives the bits of a new search.

use crate::prelude::*;
use proptest::test_runner::RngSeed;

/// A scene; with `tails` a pixel in fifty has a large error, so that σ_D depends on the gate's factor.
fn scene(seed: u64, size: (usize, usize), tails: bool) -> Burst {
    let params =
        SceneParams { width: size.0, height: size.1, frames: 6, layers: 2, snr: 6.0, seed, ..SceneParams::default() };
    let mut burst = synth_scene(&params, &quiet()).expect("valid parameters").0;
    let mut state = seed as u32;
    for frame in burst.frames.iter_mut().filter(|_| tails) {
        let damaged = |u, v| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let error = if state >> 8 < (1 << 24) / 50 { 0.05 * ((state >> 16) % 3) as f32 - 0.05 } else { 0.0 };
            frame.row(v)[u] + error
        };
        *frame = Arc::new(Plane::from_fn(size.0, size.1, damaged));
    }
    burst
}

fn searched(burst: &Burst, params: &DetectorParams) -> ProbeCache {
    ProbeCache::new(burst, &params.clone().into(), &quiet()).expect("valid parameters")
}

fn rejudged(trail: &Trail, params: &DetectorParams) -> Option<Trail> {
    trail.rejudged(params, &quiet()).expect("nobody cancels it")
}

fn assert_same(judged: &Trail, burst: &Burst, params: &DetectorParams) {
    let new = &searched(burst, params).trail;
    assert_eq!(judged.params(), params);
    assert_eq!(judged.keypoints(), new.keypoints(), "{params:?}");
    let (found, expected) = (judged.detection(), new.detection());
    assert_eq!(found.features, expected.features, "{params:?}");
    assert!(found.descriptors == expected.descriptors, "{params:?}");
    assert_eq!(found.noise_gate_factor, expected.noise_gate_factor);
    assert_eq!((&found.noise, found.slopes, &found.octaves), (&expected.noise, expected.slopes, &expected.octaves));
    for index in 0..new.keypoints().len() {
        assert_eq!(judged.is_cut(index), new.is_cut(index));
        assert_eq!(judged.covered_by(index), new.covered_by(index));
        let keypoint = &new.keypoints()[index];
        let at =
            |trail: &Trail| trail.keypoint_at(keypoint.octave, keypoint.level, keypoint.slope_index, keypoint.sample);
        assert_eq!(at(judged), at(new));
    }
    for index in 0..expected.features.len() {
        assert_eq!(judged.keypoint_of_feature(index), new.keypoint_of_feature(index));
    }
    // Keypoints are counted as a new search counts them, samples that are none as the earlier one did.
    assert_eq!((found.tally.samples, found.tally.kept), (expected.tally.samples, expected.tally.kept));
    assert_eq!(found.tally.samples, found.tally.rejected.iter().sum::<u64>() + found.tally.kept);
    for test in [Test::Duplicate, Test::MaxFeatures] {
        assert_eq!(found.tally.rejected_by(test), expected.tally.rejected_by(test), "{test:?}");
    }
}

#[derive(Debug, Clone)]
struct Change {
    gate: Option<f32>,
    peak: f32,
    edge: f32,
    distinct: Option<f32>,
    distinct_scale: f32,
    max_features: usize,
}

impl Change {
    fn applied(&self, params: &DetectorParams) -> DetectorParams {
        DetectorParams {
            noise_gate: self.gate.map_or(NoiseGate::Auto, NoiseGate::Factor),
            peak_threshold: self.peak,
            edge_threshold: self.edge,
            distinct: self.distinct.map_or(Distinct::Off, Distinct::Radius),
            distinct_scale: self.distinct_scale,
            max_features: self.max_features,
            ..params.clone()
        }
    }
}

fn changes() -> impl Strategy<Value = Change> {
    (
        prop_oneof![Just(None), (3.0f32..7.0).prop_map(Some)],
        prop_oneof![Just(0.0f32), 0.0f32..0.01],
        1.5f32..20.0,
        prop_oneof![Just(None), (0.3f32..3.0).prop_map(Some)],
        1.05f32..3.0,
        prop_oneof![Just(0usize), 1usize..30, 30usize..300],
    )
        .prop_map(|(gate, peak, edge, distinct, distinct_scale, max_features)| Change {
            gate,
            peak,
            edge,
            distinct,
            distinct_scale,
            max_features,
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, rng_seed: RngSeed::Fixed(25), ..ProptestConfig::default() })]

    #[test]
    fn a_judgement_is_a_new_search(
        grid in prop_oneof![
            (1usize..8).prop_map(|count| SlopeGrid::line(-1.5..=1.5, count)),
            (2usize..4, 2usize..4).prop_map(|(u, v)| SlopeGrid::plane(-1.0..=1.0, u, -1.0..=0.5, v)),
        ],
        joint in any::<bool>(),
        continuous in any::<bool>(),
        white in any::<bool>(),
        tails in any::<bool>(),
        changes in prop::collection::vec(changes(), 3),
        seed in 1u64..500,
    ) {
        let burst = scene(seed, (110, 90), tails);
        let params = DetectorParams {
            slopes: grid,
            slope_extrema: if joint { SlopeExtrema::Joint } else { SlopeExtrema::Each },
            rules: if continuous { Rules::BURSTSCOPE } else { Rules::VLFEAT },
            noise_model: if white { NoiseModelKind::White } else { NoiseModelKind::Local },
            noise_gate: NoiseGate::Factor(3.0),
            edge_threshold: 20.0,
            octaves: 3,
            levels: 3,
            ..DetectorParams::default()
        };
        let first = searched(&burst, &params);
        let mut before: Option<Trail> = None;
        for change in changes {
            // A judgement goes back to the search, whatever was judged in between.
            let changed = change.applied(&params);
            let judged = rejudged(before.as_ref().unwrap_or(&first.trail), &changed).expect("nothing is less strict");
            assert_same(&judged, &burst, &changed);
            before = Some(judged);
        }
        let back = rejudged(&before.expect("judged"), &params).expect("as strict as the search");
        assert_same(&back, &burst, &params);
        prop_assert_eq!(back.detection().tally, first.detection().tally);
    }
}

#[test]
fn what_the_search_did_not_leave_needs_another_and_a_cancelled_judgement_has_no_result() {
    let burst = scene(3, (110, 90), false);
    let params = DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 5), ..DetectorParams::default() };
    let params = DetectorParams { noise_gate: NoiseGate::Factor(5.0), peak_threshold: 0.001, octaves: 3, ..params };
    let first = searched(&burst, &params).trail;
    assert!(rejudged(&first, &params).is_some());
    for changed in [
        DetectorParams { noise_gate: NoiseGate::Factor(4.9), ..params.clone() },
        DetectorParams { peak_threshold: 0.0009, ..params.clone() },
        DetectorParams { edge_threshold: params.edge_threshold + 0.1, ..params.clone() },
        DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 6), ..params.clone() },
        DetectorParams { slope_extrema: SlopeExtrema::Joint, ..params.clone() },
        DetectorParams { max_orientations: params.max_orientations - 1, ..params.clone() },
        // Refused by a search too.
        DetectorParams { distinct_scale: -1.0, ..params.clone() },
    ] {
        assert!(rejudged(&first, &changed).is_none(), "{changed:?}");
    }
    let first =
        searched(&burst, &DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 5), ..DetectorParams::default() });
    let changed = DetectorParams { distinct: Distinct::Radius(0.4), ..first.params().clone() };
    assert!(first.trail.rejudged(&changed, &cancelled()).is_err());
}

#[test]
fn slopes_that_were_found_stay() {
    let burst = scene(7, (160, 120), false);
    let asked = SearchParams::default();
    let first = ProbeCache::new(&burst, &asked, &quiet()).expect("valid parameters");
    let judged = |asked: &SearchParams| first.rejudged(asked, &quiet()).expect("nobody cancels it");
    let asked = SearchParams { noise_gate: NoiseGate::Factor(9.0), max_features: 20, ..asked };
    let (found, new) = (judged(&asked).expect("stricter"), ProbeCache::new(&burst, &asked, &quiet()));
    let new = new.expect("valid parameters");
    assert_eq!(found.detection().features, new.detection().features);
    assert_eq!((found.made_with(), &found.asked, &found.finding), (new.made_with(), &new.asked, &new.finding));
    assert!(judged(&found.made_with().into()).is_none(), "given slopes are others");
}
