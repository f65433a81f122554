//! The law of the verdicts (they add up to the detection's tally), on small bursts with all kinds of parameters; and
//! the comparison of a detection with another one, with the truth, and with that of another picture.

use super::probing::{cache, slopes_of};
use crate::prelude::*;
use burstscope_core::dataset::BurstSide;
use burstscope_core::detector::feature::Keypoint;
use burstscope_core::inspect::pair::{ComparedPair, Losses, Lost};
use burstscope_core::inspect::place::{Fate, Outcome, fate};
use burstscope_core::inspect::result::{AgainstTruth, Spot, against_truth, compare, read_truth, truth_of};
use burstscope_core::matching::{Prediction, match_pair};
use burstscope_core::plane::statistics::Region;
use burstscope_core::synth::examples::{Example, disc_place};
use burstscope_lab::synth::{
    ChartParams, SceneParams, demo_burst, later_demo_burst, synth_chart, synth_scene, write_burst,
};
use proptest::test_runner::RngSeed;

pub fn scene(seed: u64, size: (usize, usize), frames: usize, snr: f64) -> Burst {
    let params = SceneParams { width: size.0, height: size.1, frames, layers: 2, snr, seed, ..SceneParams::default() };
    synth_scene(&params, &quiet()).expect("valid parameters").0
}

/// All samples of an octave, whether or not the search examines them.
fn samples(trail: &Trail, octave: i32) -> (Region, Vec<Sample>) {
    let (width, height) = trail.octave_size(octave);
    let region = Region { columns: 0..width, rows: 0..height };
    let mut samples = Vec::new();
    for slope_index in 0..trail.params().used_slopes().len() {
        for level in 0..trail.space().levels as i32 {
            (0..height).for_each(|y| samples.extend((0..width).map(|x| Sample { octave, level, slope_index, x, y })));
        }
    }
    (region, samples)
}

/// Judges every sample and compares the sum with the detection.
fn assert_law(burst: &Burst, params: &DetectorParams) -> usize {
    let monitor = Monitor::default();
    let detection = detect(burst, params, &monitor).expect("valid parameters");
    let trail = ProbeCache::new(burst, &params.clone().into(), &monitor).expect("valid parameters").trail;
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
            let Some(judgement) = judgement else {
                let (width, height) = trail.octave_size(octave);
                let is_inner = |at: usize, n: usize| at > 0 && at + 1 < n;
                tally.not_searched += u64::from(is_inner(sample.x, width) && is_inner(sample.y, height));
                continue;
            };
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
                None if trail.is_cut(index) => {
                    tally.reject(Test::MaxFeatures, 1);
                    assert_agrees(&fate, Some(Test::MaxFeatures));
                    assert!(fate.features.is_empty());
                    assert!(fate.report(Test::MaxFeatures).value.is_some_and(|rank| rank > params.max_features as f64));
                }
                None => {
                    kept.push(keypoint);
                    assert_agrees(&fate, None);
                    assert!(!fate.features.is_empty());
                }
            }
        }
    }
    tally.kept = kept.len() as u64;
    assert_eq!(tally, detection.tally, "{params:?}");
    for (index, feature) in detection.features.iter().enumerate() {
        let keypoint = trail.keypoints()[trail.keypoint_of_feature(index)];
        assert!(kept.contains(&keypoint));
        assert_eq!((feature.response, feature.snr), (keypoint.value, keypoint.snr));
        assert_eq!(feature.octave, keypoint.octave);
        assert_eq!((feature.level, feature.slope_index), (keypoint.level, keypoint.slope_index));
    }
    kept.len()
}

/// Asserts that the reports of the single tests agree with the verdict.
fn assert_agrees(fate: &Fate, first_failed: Option<Test>) {
    assert_eq!(fate.first_failed, first_failed, "{fate:#?}");
    for report in &fate.tests {
        let before = first_failed.is_none_or(|failed| report.test < failed);
        // Samples that are no extrema in the image are only compared with the minimum noise of their level; the gate at
        // their own place is applied to extrema, and to the refined value after the comparison with other slopes.
        let gate_of_place = report.test == Test::NoiseGate
            && matches!(
                first_failed,
                Some(Test::SpaceExtremum | Test::ScaleExtremum | Test::SlopeExtremum | Test::Refinement)
            );
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
            SlopeGrid::single(Slope::new(0.5, 0.0))
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
        (joint, field) in any::<(bool, bool)>(),
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
            slopes, octaves, levels, first_octave, distinct, peak_threshold, max_features,
            noise_gate: gate,
            search: if field { SearchSlopes::Field } else { SearchSlopes::All },
            slope_extrema: if joint { SlopeExtrema::Joint } else { SlopeExtrema::Each },
            rules: Rules {
                slope_neighbours: if all { SlopeNeighbours::All } else { SlopeNeighbours::Adjacent },
                coarse_start: if quadratic { CoarseStart::Skipped } else { CoarseStart::Binned },
                localisation: if quadratic { Localisation::Quadratic } else { Localisation::Continuous },
                interpolation,
                ..Rules::default()
            },
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
    let slopes = SlopeGrid::line(-6.0..=6.0, 25);
    assert!(
        assert_law(&burst, &DetectorParams { slopes, search: SearchSlopes::Field, ..DetectorParams::default() }) > 3
    );
}

fn chart() -> (Burst, burstscope_core::synth::Truth) {
    let params =
        ChartParams { width: 320, height: 240, discs: 24, frames: 7, snr: 0.3, seed: 3, ..ChartParams::default() };
    synth_chart(&params, &quiet()).expect("valid parameters")
}

fn params() -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, 9), ..DetectorParams::default() }
}

#[test]
fn a_higher_gate_only_loses_and_the_faint_discs_of_the_example_are_lost_to_it() {
    let (burst, _) = chart();
    let with = |gate: f32| {
        let params = DetectorParams { noise_gate: NoiseGate::Factor(gate), ..params() };
        let cache = cache(&burst, &params);
        cache.detection().features.iter().map(Spot::from).collect::<Vec<_>>()
    };
    let (low, high) = (with(4.0), with(7.0));
    let changes = compare(&low, &high);
    // Some of the lost features covered a few others, which come back.
    assert!(changes.gained.len() * 10 <= changes.lost.len() && !changes.lost.is_empty(), "{}", changes.summary());
    let back = compare(&high, &low);
    // Of two near ones each direction of the comparison may choose another.
    assert!(back.gained.len().abs_diff(changes.lost.len()) <= 2 && back.lost.len().abs_diff(changes.gained.len()) <= 2);
    // A few are matched with another one that is nearer now; the others have not moved.
    assert!(changes.moved().count() * 20 <= changes.same.len(), "{}", changes.summary());
    let example = Example::LowContrast;
    let params = DetectorParams { slopes: slopes_of(example), ..DetectorParams::default() };
    let cache = cache(&example.burst(), &params);
    let found = |index: usize| {
        let [u, v] = disc_place(index);
        cache.detection().features.iter().any(|f| (f.u - u).hypot(f.v - v) < 4.0 && (2.5..8.0).contains(&f.sigma))
    };
    assert!((0..3).all(found), "the bright ones are found");
    assert!(!found(7) && !found(8), "the faint ones are not");
    let probe =
        burstscope_core::inspect::place::probe(&cache, example.place(), &Default::default(), &quiet()).expect("inside");
    assert!(!probe.fates.is_empty());
    let gated =
        |f: &&burstscope_core::inspect::place::Fate| f.first_failed == Some(Test::NoiseGate) && f.remedy.is_some();
    assert!(probe.fates.iter().any(|f| gated(&f)), "{}", probe.summary);
}

#[test]
fn found_missed_repeated_and_false_add_up_and_each_miss_has_a_reason() {
    let (burst, truth) = chart();
    // A gate that rejects some of the discs, and no suppression of repeated features.
    let params = DetectorParams { noise_gate: NoiseGate::Factor(7.0), distinct: Distinct::Off, ..params() };
    let against = against_truth(&cache(&burst, &params), &truth, &quiet()).expect("not cancelled");
    let AgainstTruth { found, at_wrong_motion, missed, repeated, elsewhere, is_whole_truth } = &against;
    assert_eq!(found.len() + at_wrong_motion.len() + missed.len(), truth.features.len());
    assert!(!found.is_empty() && !missed.is_empty() && !repeated.is_empty(), "{}", against.summary());
    let mut all: Vec<usize> = found
        .iter()
        .chain(at_wrong_motion)
        .map(|f| f.0)
        .chain(repeated.iter().copied())
        .chain(elsewhere.iter().copied())
        .collect();
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count, "each feature is one of the four");
    assert!(*is_whole_truth && against.summary().ends_with(&format!("{} false", elsewhere.len())));
    let gated = missed.iter().filter(|m| m.fate.as_ref().is_some_and(|f| f.first_failed == Some(Test::NoiseGate)));
    // In coarse octaves the candidate that is told may be a sample at the level beside that of a disc's peak, which its
    // ascent shows before its value is compared with the gate.
    assert!(2 * gated.count() >= missed.len(), "half were taken by the gate: {missed:#?}");
    assert!(missed.iter().all(|m| !m.why.is_empty()));
}

#[test]
fn the_truth_beside_a_burst_is_found_and_a_wrong_one_refused() {
    let home = folder();
    let (burst, truth) = chart();
    let folder = home.join("chart");
    write_burst(&folder, &burst, &truth, &quiet()).expect("written");
    let opened = Burst::open(&folder).expect("a burst");
    // Numbers are equal up to the last bit.
    let read = truth_of(&opened).expect("sound").expect("there");
    assert_eq!((read.width, read.seed, read.features.len()), (truth.width, truth.seed, truth.features.len()));
    assert!(read.features.iter().zip(&truth.features).all(|(a, b)| (a.u - b.u).abs() < 1e-9 && a.id == b.id));
    assert_eq!(truth_of(&Burst { sources: vec![home.to_path_buf()], ..opened.clone() }), Ok(None));
    assert!(truth_of(&demo_burst()).expect("known").is_some());
    assert!(truth_of(&later_demo_burst()).expect("known").is_none());
    let small = burstscope_core::synth::Truth { width: 9, ..truth };
    fs::write(folder.join("truth.json"), serde_json::to_string(&small).expect("JSON")).expect("written");
    assert!(truth_of(&opened).is_err_and(|error| error.problem.contains("the burst has")));
    fs::write(folder.join("truth.json"), "{").expect("written");
    let error = truth_of(&opened).expect_err("broken").to_string();
    assert!(error.contains("truth.json") && error.contains("burstscope synth"), "{error}");
    assert!(read_truth(&home.join("gone.json")).is_err_and(|error| error.problem.starts_with("cannot be read")));
}

#[test]
fn every_feature_was_lost_somewhere_or_not_at_all() {
    let params = params();
    let (a, b) = (cache(&demo_burst(), &params), cache(&later_demo_burst(), &params));
    for (geometry, predict) in [
        (Geometry::Fundamental, true),
        (Geometry::Fundamental, false),
        (Geometry::Homography, false),
        (Geometry::None, true),
    ] {
        let matching = MatchParams { geometry, predict, align: false, ..MatchParams::default() };
        let sides = [a.detection(), b.detection()].map(BurstSide::from);
        let sides = sides.each_ref().map(BurstSide::side);
        let result = match_pair(sides, &matching, &quiet()).expect("matched");
        let is_predicted = result.prediction.as_ref().is_some_and(Prediction::is_believed);
        assert_eq!(is_predicted, predict && geometry != Geometry::None);
        let pair =
            ComparedPair { a: a.detection(), b: b.detection(), size_b: (480, 360), result: &result, params: &matching };
        let losses = Losses::new(pair, &quiet()).expect("not cancelled");
        let counts = losses.counts(&quiet()).expect("not cancelled");
        let of = |lost: Lost| counts[lost as usize].1;
        assert_eq!(counts.iter().map(|c| c.1).sum::<usize>(), a.detection().features.len());
        assert_eq!(of(Lost::Not), result.counts.inliers.unwrap_or(result.counts.putative));
        // By their motions some lose their match to others, or to what they would have to move like.
        assert_eq!(of(Lost::Not) + of(Lost::Geometry), result.counts.putative);
        let gave_way = of(Lost::Motion);
        assert!(if is_predicted { gave_way < result.counts.putative / 5 } else { gave_way == 0 }, "{gave_way}");
        assert!(of(Lost::RatioTest) + of(Lost::MutualCheck) > 0);
        // With a geometry some of them have no keypoint where it expects them, which is told first.
        let not_mutual = result.counts.not_mutual.expect("counted");
        assert!(not_mutual >= of(Lost::MutualCheck));
        assert!(geometry != Geometry::None || not_mutual == of(Lost::MutualCheck));
        // The detailed explanation for some features of each kind.
        let mut seen = std::collections::BTreeMap::new();
        for index in (0..a.detection().features.len()).step_by(7) {
            let why = losses.of(index, 4);
            *seen.entry(why.lost).or_insert(0) += 1;
            assert!(!why.sentence.is_empty() && why.candidates.len() == 4);
            assert!(why.candidates.windows(2).all(|w| w[0].distance <= w[1].distance));
            let matched = result.matches.iter().find(|m| m.a == index);
            match why.lost {
                Lost::Not if is_predicted => assert!(matched.is_some()),
                Lost::Motion => assert!(is_predicted && why.sentence.starts_with("motion: its match, feature ")),
                Lost::Geometry if is_predicted => assert!(why.sentence.starts_with("geometry: its match, feature ")),
                Lost::Not | Lost::Geometry => assert_eq!(matched.map(|m| m.b), Some(why.candidates[0].feature)),
                Lost::MutualCheck => assert!(why.preferred.is_some_and(|other| other != index)),
                Lost::RatioTest => {
                    assert!(matched.is_none());
                    let tells = why.sentence.contains("its motion");
                    assert_eq!(tells, is_predicted, "{}", why.sentence);
                }
                Lost::NoKeypoint => assert!(why.there.is_empty()),
            }
        }
        assert!(seen.len() >= 2, "{seen:?}");
    }
}
