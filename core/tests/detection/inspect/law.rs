//! The law of the verdicts (they add up to the detection's tally), on small bursts with all kinds of parameters.

use burstscope_core::detector::keypoint::Keypoint;
use burstscope_core::detector::{
    DetectorParams, Distinct, Interpolation, Localisation, NoiseGate, NoiseModelKind, Sample, SlopeExtrema, SlopeGrid,
    SlopeNeighbours, Tally, Test, Trail, detect, detect_with_trail,
};
use burstscope_core::inspect::telling::fate;
use burstscope_core::inspect::{Fate, Outcome};
use burstscope_core::plane::tile::Region;
use burstscope_core::synth::{SceneParams, synth_scene};
use burstscope_core::{Burst, Monitor};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

pub fn scene(seed: u64, size: (usize, usize), frames: usize, snr: f64) -> Burst {
    let params = SceneParams { width: size.0, height: size.1, frames, layers: 2, snr, seed, ..SceneParams::default() };
    synth_scene(&params, &Monitor::default()).expect("valid parameters").0
}

/// All samples of an octave, whether or not the search examines them.
fn samples(trail: &Trail, octave: i32) -> (Region, Vec<Sample>) {
    let (width, height) = trail.octave_size(octave);
    let region = Region { columns: 0..width, rows: 0..height };
    let mut samples = Vec::new();
    for slope_index in 0..trail.params().used_slopes().len() {
        for level in 0..trail.space().levels as i32 {
            for y in 0..height {
                samples.extend((0..width).map(|x| Sample { octave, level, slope_index, x, y }));
            }
        }
    }
    (region, samples)
}

/// Judges every sample and compares the sum with the detection.
fn assert_law(burst: &Burst, params: &DetectorParams) -> usize {
    let monitor = Monitor::default();
    let detection = detect(burst, params, &monitor).expect("valid parameters");
    let trail = detect_with_trail(burst, params, &monitor).expect("valid parameters");
    assert_eq!(trail.detection().features, detection.features, "keeping the trail changes nothing");
    assert_eq!(trail.detection().descriptors, detection.descriptors);
    assert_eq!(trail.detection().tally, detection.tally);
    let mut tally = Tally::default();
    let mut kept: Vec<Keypoint> = Vec::new();
    for octave in trail.octaves() {
        let (region, samples) = samples(&trail, octave);
        let around = trail.neighbourhood(octave, &region, &monitor).expect("not cancelled");
        let judged = trail.judge(&around, &samples);
        for (sample, judgement) in samples.iter().zip(judged) {
            let Some(judgement) = judgement else { continue };
            tally.samples += 1;
            if let Some(test) = judgement.rejected_by {
                tally.reject(test, 1);
                // The detailed report agrees; for every sample it would take too long.
                if (sample.x + 31 * sample.y).is_multiple_of(53) {
                    assert_agrees(&fate(&trail, &around, sample, &judgement), Some(test));
                }
                continue;
            }
            let keypoint = judgement.keypoint().expect("nothing rejects it");
            let index = trail
                .keypoint_at(octave, sample.level, sample.slope_index, keypoint.sample)
                .expect("the search found it too");
            assert_eq!(trail.keypoints()[index], keypoint, "to the bit");
            let fate = fate(&trail, &around, sample, &judgement);
            match trail.covered_by(index) {
                Some(_) => {
                    tally.reject(Test::Duplicate, 1);
                    assert_agrees(&fate, Some(Test::Duplicate));
                }
                None => {
                    kept.push(keypoint);
                    let cut = params.max_features > 0 && trail.ranks_of(index).all(|r| r >= params.max_features);
                    assert_agrees(&fate, cut.then_some(Test::MaxFeatures));
                    assert_eq!(fate.features.is_empty(), cut);
                }
            }
        }
    }
    // Features beyond the maximum number are cut off; a keypoint may have several.
    tally.reject(Test::MaxFeatures, detection.tally.rejected_by(Test::MaxFeatures));
    tally.kept = kept.len() as u64;
    assert_eq!(tally, detection.tally, "{params:?}");
    for (index, feature) in detection.features.iter().enumerate() {
        let keypoint = trail.keypoints()[trail.keypoint_of_feature(index)];
        assert!(kept.contains(&keypoint));
        assert_eq!((feature.response, feature.snr), (keypoint.value, keypoint.snr));
        assert_eq!(
            (feature.octave, feature.level, feature.slope_index),
            (keypoint.octave, keypoint.level, keypoint.slope_index)
        );
    }
    kept.len()
}

/// Asserts that the reports of the single tests agree with the verdict.
fn assert_agrees(fate: &Fate, first_failed: Option<Test>) {
    assert_eq!(fate.first_failed, first_failed, "{fate:#?}");
    for report in &fate.tests {
        let before = first_failed.is_none_or(|failed| report.test < failed);
        // Samples that are no extrema in the image are only compared with the minimum noise of their level; the gate at
        // their own place is applied to extrema.
        let gate_of_place =
            report.test == Test::NoiseGate && matches!(first_failed, Some(Test::SpaceExtremum | Test::ScaleExtremum));
        if before && !gate_of_place {
            assert_ne!(report.outcome, Outcome::Fails, "{first_failed:?}: {report:?}");
        }
        if Some(report.test) == first_failed {
            assert_eq!(report.outcome, Outcome::Fails, "{report:?}");
        }
    }
    assert!(!fate.verdict.is_empty());
}

fn grids() -> impl Strategy<Value = SlopeGrid> {
    prop_oneof![
        (1usize..6).prop_map(|count| if count == 1 {
            SlopeGrid::single(burstscope_core::detector::Slope::new(0.5, 0.0))
        } else {
            SlopeGrid::line(-1.5..=1.5, count)
        }),
        (2usize..4).prop_map(|count| SlopeGrid::line_along(60.0, -1.0..=1.3, count)),
        (2usize..4, 2usize..4).prop_map(|(u, v)| SlopeGrid::plane(-1.2..=1.0, u, -0.8..=0.9, v)),
    ]
}

prop_compose! {
    fn all_params()(
        slopes in grids(),
        (octaves, levels, first_octave) in (1u32..4, 1u32..5, -1i32..2),
        joint in any::<bool>(),
        all in any::<bool>(),
        quadratic in any::<bool>(),
        local in any::<bool>(),
        distinct in prop_oneof![Just(Distinct::Off), Just(Distinct::Radius(1.25)), Just(Distinct::Radius(3.0))],
        gate in prop_oneof![Just(NoiseGate::Auto), Just(NoiseGate::Factor(0.0)), Just(NoiseGate::Factor(3.0))],
        peak_threshold in prop_oneof![Just(0.0f32), Just(0.002)],
        max_features in prop_oneof![Just(0usize), Just(6)],
        interpolation in prop_oneof![Just(Interpolation::Linear), Just(Interpolation::Nearest), Just(Interpolation::Truncated)],
    ) -> DetectorParams {
        DetectorParams {
            slopes, octaves, levels, first_octave, distinct, peak_threshold, max_features, interpolation,
            noise_gate: gate,
            slope_extrema: if joint { SlopeExtrema::Joint } else { SlopeExtrema::Each },
            slope_neighbours: if all { SlopeNeighbours::All } else { SlopeNeighbours::Adjacent },
            localisation: if quadratic { Localisation::Quadratic } else { Localisation::Continuous },
            noise_model: if local { NoiseModelKind::Local } else { NoiseModelKind::White },
            ..DetectorParams::default()
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, rng_seed: RngSeed::Fixed(13), ..ProptestConfig::default() })]

    #[test]
    fn verdicts_add_up_to_the_tally_and_keep_what_was_kept(seed in 0u64..1000, params in all_params(), snr in prop_oneof![Just(1.0), Just(6.0)]) {
        assert_law(&scene(seed, (56, 44), 5, snr), &params);
    }
}

#[test]
fn the_law_holds_for_the_default_search_on_a_line_and_in_a_plane() {
    let burst = scene(3, (96, 80), 6, 4.0);
    for slopes in [SlopeGrid::line(-2.0..=2.0, 5), SlopeGrid::plane(-2.0..=2.0, 3, -1.0..=1.0, 3)] {
        let kept = assert_law(&burst, &DetectorParams { slopes, ..DetectorParams::default() });
        assert!(kept > 3, "{kept} keypoints: the law would hold for nothing");
    }
}
