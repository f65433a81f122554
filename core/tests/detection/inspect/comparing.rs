//! Comparison of a detection with another one, with the truth, and with that of another picture.

use super::probing::{cache, slopes_of};
use burstscope_core::detector::{DetectorParams, Distinct, NoiseGate, SlopeGrid, Test};
use burstscope_core::inspect::changes::{Spot, compare};
use burstscope_core::inspect::truth::{AgainstTruth, TruthError, against_truth, read_truth, truth_of};
use burstscope_core::inspect::unmatched::{ComparedPair, Losses, Lost};
use burstscope_core::matching::{Geometry, MatchParams, match_detections};
use burstscope_core::synth::examples::{Example, disc_place};
use burstscope_core::synth::{ChartParams, demo_burst, later_demo_burst, synth_chart, write_burst};
use burstscope_core::{Burst, Monitor};

fn chart() -> (Burst, burstscope_core::synth::Truth) {
    let params =
        ChartParams { width: 320, height: 240, discs: 24, frames: 7, snr: 0.3, seed: 3, ..ChartParams::default() };
    synth_chart(&params, &Monitor::default()).expect("valid parameters")
}

fn params() -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, 9), ..DetectorParams::default() }
}

#[test]
fn a_higher_gate_only_loses_and_a_shorter_list_too() {
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
}

#[test]
fn found_missed_repeated_and_false_add_up_and_each_miss_has_a_reason() {
    let (burst, truth) = chart();
    // A gate that rejects some of the discs, and no suppression of repeated features.
    let params = DetectorParams { noise_gate: NoiseGate::Factor(7.0), distinct: Distinct::Off, ..params() };
    let cache = cache(&burst, &params);
    let against = against_truth(&cache, &truth, &Monitor::default()).expect("not cancelled");
    let AgainstTruth { found, missed, repeated, elsewhere, is_whole_truth } = &against;
    assert_eq!(found.len() + missed.len(), truth.features.len());
    assert!(!found.is_empty() && !missed.is_empty() && !repeated.is_empty(), "{}", against.summary());
    let mut all: Vec<usize> =
        found.iter().map(|f| f.0).chain(repeated.iter().copied()).chain(elsewhere.iter().copied()).collect();
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count, "each feature is one of the three");
    assert!(*is_whole_truth && against.summary().ends_with(&format!("{} false", elsewhere.len())));
    let gated = missed.iter().filter(|m| m.fate.as_ref().is_some_and(|f| f.first_failed == Some(Test::NoiseGate)));
    assert!(2 * gated.count() > missed.len(), "most were taken by the gate: {missed:#?}");
    assert!(missed.iter().all(|m| !m.why.is_empty()));
}

#[test]
fn the_faint_discs_of_the_example_are_lost_to_the_gate() {
    let example = Example::LowContrast;
    let params = DetectorParams { slopes: slopes_of(example), ..DetectorParams::default() };
    let cache = cache(&example.burst(), &params);
    let found = |index: usize| {
        let [u, v] = disc_place(index);
        cache.detection().features.iter().any(|f| (f.u - u).hypot(f.v - v) < 4.0 && (2.5..8.0).contains(&f.sigma))
    };
    assert!((0..3).all(found), "the bright ones are found");
    assert!(!found(6) && !found(8), "the faint ones are not");
    let probe = burstscope_core::inspect::probe(&cache, example.place(), &Default::default(), &Monitor::default())
        .expect("inside");
    assert!(!probe.fates.is_empty());
    let gated = |f: &&burstscope_core::inspect::Fate| f.first_failed == Some(Test::NoiseGate) && f.remedy.is_some();
    assert!(probe.fates.iter().any(|f| gated(&f)), "{}", probe.summary);
}

#[test]
fn the_truth_beside_a_burst_is_found_and_a_wrong_one_refused() {
    let home = tempfile::tempdir().expect("a folder");
    let (burst, truth) = chart();
    let folder = home.path().join("chart");
    write_burst(&folder, &burst, &truth, &Monitor::default()).expect("written");
    let opened = Burst::open(&folder).expect("a burst");
    // Numbers are equal up to the last bit.
    let read = truth_of(&opened).expect("sound").expect("there");
    assert_eq!((read.width, read.seed, read.features.len()), (truth.width, truth.seed, truth.features.len()));
    assert!(read.features.iter().zip(&truth.features).all(|(a, b)| (a.u - b.u).abs() < 1e-9 && a.id == b.id));
    let elsewhere = Burst { sources: vec![home.path().to_path_buf()], ..opened.clone() };
    assert_eq!(truth_of(&elsewhere), Ok(None));
    assert!(
        truth_of(&demo_burst()).expect("known").is_some() && truth_of(&later_demo_burst()).expect("known").is_none()
    );
    let small = burstscope_core::synth::Truth { width: 9, ..truth };
    std::fs::write(folder.join("truth.json"), serde_json::to_string(&small).expect("JSON")).expect("written");
    assert!(matches!(truth_of(&opened), Err(TruthError::Size { .. })));
    std::fs::write(folder.join("truth.json"), "{").expect("written");
    let error = truth_of(&opened).expect_err("broken").to_string();
    assert!(error.contains("truth.json") && error.contains("burstscope synth"), "{error}");
    assert!(matches!(read_truth(&home.path().join("gone.json")), Err(TruthError::Read { .. })));
}

#[test]
fn every_feature_was_lost_somewhere_or_not_at_all() {
    let params = params();
    let (a, b) = (cache(&demo_burst(), &params), cache(&later_demo_burst(), &params));
    for geometry in [Geometry::Fundamental, Geometry::Homography, Geometry::None] {
        let matching = MatchParams { geometry, ..MatchParams::default() };
        let result = match_detections(a.detection(), b.detection(), &matching, &Monitor::default()).expect("matched");
        let pair =
            ComparedPair { a: a.detection(), b: b.detection(), size_b: (480, 360), result: &result, params: &matching };
        let losses = Losses::new(pair, &Monitor::default()).expect("not cancelled");
        let counts = losses.counts(&Monitor::default()).expect("not cancelled");
        let of = |lost: Lost| counts[lost as usize].1;
        assert_eq!(counts.iter().map(|c| c.1).sum::<usize>(), a.detection().features.len());
        let inliers = result.counts.inliers.unwrap_or(result.counts.putative);
        assert_eq!(of(Lost::Not), inliers);
        assert_eq!(of(Lost::Not) + of(Lost::Geometry), result.counts.putative);
        assert!(of(Lost::RatioTest) + of(Lost::MutualCheck) > 0);
        // The detailed explanation for some features of each kind.
        let mut seen = std::collections::BTreeMap::new();
        for index in (0..a.detection().features.len()).step_by(7) {
            let why = losses.of(index, 4);
            *seen.entry(why.lost).or_insert(0) += 1;
            assert!(!why.sentence.is_empty() && why.candidates.len() == 4);
            assert!(why.candidates.windows(2).all(|w| w[0].distance <= w[1].distance));
            let matched = result.matches.iter().find(|m| m.a == index);
            match why.lost {
                Lost::Not | Lost::Geometry => assert_eq!(matched.map(|m| m.b), Some(why.candidates[0].feature)),
                Lost::MutualCheck => assert!(why.preferred.is_some_and(|other| other != index)),
                Lost::RatioTest => assert!(matched.is_none()),
                Lost::NoKeypoint => assert!(why.there.is_empty()),
            }
        }
        assert!(seen.len() >= 2, "{seen:?}");
    }
}
