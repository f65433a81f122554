//! Probes of places whose explanation is known, the candidates of a whole picture, and maps of the winning slopes.

use super::law::scene;
use crate::prelude::*;
use burstscope_core::detector::coherence::Shape;
use burstscope_core::inspect::place::{self, *};
use std::collections::BTreeMap;

/// Gaussian blobs (column and row at mid-burst, σ px, height, slope) over an even background with a little noise.
pub fn blobs(frames: usize, noise: f32, blobs: &[(f32, f32, f32, f32, Slope)]) -> Burst {
    let mut rng = Stream::new(5, 0);
    let frame = |t: usize| {
        let dt = t as f32 - (frames as f32 - 1.0) / 2.0;
        Plane::from_fn(128, 96, |u, v| {
            let mut value = 0.3 + noise * (rng.normal() as f32);
            for &(bu, bv, sigma, height, slope) in blobs {
                let (du, dv) = (u as f32 - bu - dt * slope.u, v as f32 - bv - dt * slope.v);
                value += height * (-(du * du + dv * dv) / (2.0 * sigma * sigma)).exp();
            }
            value
        })
    };
    Burst::from_planes("blobs", (0..frames).map(frame).collect())
}

pub fn slopes_of(example: Example) -> SlopeGrid {
    let (range, count) = example.slopes_u();
    SlopeGrid::line(range, count)
}

pub fn cache(burst: &Burst, params: &DetectorParams) -> ProbeCache {
    ProbeCache::new(burst, &SearchParams::from(params.clone()), &quiet()).expect("valid parameters")
}

fn probed(cache: &ProbeCache, place: [f32; 2]) -> Probe {
    probe(cache, place, &ProbeOptions::default(), &quiet()).expect("inside")
}

fn line() -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 9), octaves: 3, ..DetectorParams::default() }
}

#[test]
fn a_kept_blob_is_level_and_its_peak_is_in_the_map() {
    let slope = Slope::new(1.0, 0.0);
    let cache = cache(&blobs(8, 0.01, &[(60.0, 48.0, 3.0, 0.2, slope)]), &line());
    let probe = probed(&cache, [60.0, 48.0]);
    let fate = probe.subject_fate().expect("it was kept");
    assert!(fate.is_kept() && !fate.features.is_empty(), "{fate:#?}");
    assert!((fate.slope.u - 1.0).abs() < 0.05, "{fate:?}");
    assert_eq!(probe.shares.evenness.shape, Shape::Level, "{}", probe.shares.meaning);
    assert!(probe.shares.evenness.coherence.expect("clear") > 0.95);
    assert!(probe.summary.contains("kept"), "{}", probe.summary);
    // The map peaks where the feature is, in the unit of its snr.
    let map = &probe.response;
    let row = map.row_of(fate.octave, fate.level).expect("a row of the map");
    let column = (0..map.columns.len()).max_by(|&a, &b| map.snr.at(a, row).abs().total_cmp(&map.snr.at(b, row).abs()));
    let column = column.expect("columns");
    assert!((map.columns[column].u - 1.0).abs() < 0.2, "{:?}", map.columns[column]);
    assert!((map.snr.at(column, row).abs() / fate.snr - 1.0).abs() < 0.1, "{} {}", map.snr.at(column, row), fate.snr);
    // A coarser scale has less noise, so in this unit the peak is not finer than the feature.
    assert!(map.scales[map.strongest().1].sigma > 0.9 * fate.sigma);
    // In the slice along its motion it runs along the line that its slope says.
    let slice = &probe.slices[0];
    for row in 0..slice.plane.height() {
        let wanted = slice.column_at(fate.slope, row);
        let brightest =
            (0..slice.plane.width()).max_by(|&a, &b| slice.plane.at(a, row).total_cmp(&slice.plane.at(b, row)));
        assert!((brightest.expect("columns") as f32 - wanted).abs() < 2.0, "row {row}: {brightest:?} {wanted}");
    }
    // Keypoints at the other slopes have it as their rival.
    let mut covered = probe.fates.iter().filter(|f| f.first_failed == Some(Test::Duplicate));
    assert!(covered.any(|f| f.report(Test::Duplicate).rival.is_some_and(|r| r.feature == Some(fate.features[0]))));
}

#[test]
fn a_faint_blob_is_below_the_gate_and_the_remedy_keeps_it() {
    let burst = blobs(8, 0.05, &[(60.0, 48.0, 3.0, 0.09, Slope::new(1.0, 0.0))]);
    let open = DetectorParams { noise_gate: NoiseGate::Factor(4.0), ..line() };
    let strongest = probed(&cache(&burst, &open), [60.0, 48.0]).fates.iter().map(|f| f.snr).fold(0.0, f32::max);
    let gate = (1.2 * strongest).round();
    let params = DetectorParams { noise_gate: NoiseGate::Factor(gate), ..line() };
    let first = cache(&burst, &params);
    let probe_before = probed(&first, [60.0, 48.0]);
    let fate = probe_before.subject_fate().expect("a candidate");
    assert_eq!(fate.first_failed, Some(Test::NoiseGate), "{fate:#?}");
    let report = fate.report(Test::NoiseGate);
    assert_eq!(report.limit, Some(f64::from(gate)));
    assert!(report.margin().is_some_and(|margin| (-1.0..0.0).contains(&margin)), "{report:?}");
    // The later tests are also evaluated.
    assert_eq!(fate.report(Test::Refinement).outcome, Outcome::Passes);
    let remedy = fate.remedy.as_ref().expect("a lower gate");
    assert_eq!((remedy.change.parameter.name, remedy.then_fails), ("noise-gate", None), "{remedy:?}");
    assert!(remedy.sentence.contains(&format!("instead of {gate}")), "{}", remedy.sentence);
    let changed = remedy.change.applied(first.params()).expect("valid");
    let after = probed(&cache(&burst, &changed), [60.0, 48.0]);
    assert!(after.fates.iter().any(|f| f.of_sample() == fate.of_sample() && f.is_kept()), "{:#?}", after.summary);
}

/// Applies the remedy of every fate near some places, and checks that the failed test is then passed.
#[test]
fn every_remedy_does_what_it_says() {
    let burst = scene(11, (128, 96), 6, 2.0);
    let joint = DetectorParams { slope_extrema: burstscope_core::detector::SlopeExtrema::Joint, ..line() };
    let mut tried = BTreeMap::new();
    for params in [
        line(),
        joint,
        DetectorParams { peak_threshold: 0.02, noise_gate: NoiseGate::Factor(2.0), ..line() },
        DetectorParams { edge_threshold: 1.5, noise_gate: NoiseGate::Factor(2.0), ..line() },
        DetectorParams { max_features: 2, ..line() },
        DetectorParams { noise_gate: NoiseGate::Factor(30.0), ..line() },
    ] {
        let before = cache(&burst, &params);
        let mut done = BTreeMap::new();
        for place in [[40.0, 30.0], [64.0, 48.0], [90.0, 60.0], [30.0, 70.0], [100.0, 20.0]] {
            for fate in probed(&before, place).fates {
                let remedy = fate.remedy.clone().or_else(|| duplicate_remedy(&before.trail, &fate));
                let (Some(test), Some(remedy)) = (fate.first_failed, &remedy) else { continue };
                // Widened slopes form another grid, in which the sample has another index.
                if remedy.change.parameter.name.starts_with("slopes-") || done.get(&test).is_some_and(|n| *n >= 2) {
                    continue;
                }
                *done.entry(test).or_insert(0) += 1;
                *tried.entry(test).or_insert(0) += 1;
                let after = cache(&burst, &remedy.change.applied(&params).expect("valid"));
                let again = fate_of(&after.trail, &fate.of_sample(), &quiet());
                let again = again.expect("not cancelled").expect("examined");
                assert_ne!(again.report(test).outcome, Outcome::Fails, "{test:?}: {:?}\n{again:#?}", remedy);
            }
        }
    }
    for test in [Test::PeakThreshold, Test::NoiseGate, Test::SlopeExtremum, Test::Edge, Test::MaxFeatures] {
        assert!(tried.contains_key(&test), "{test:?} was not tried: {tried:?}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_and_the_winning_slope_is_the_one_a_blob_moves_with() {
    let empty = cache(&blobs(4, 0.01, &[]), &line());
    let asked = |place, wanted| {
        let options = ProbeOptions { wanted, ..ProbeOptions::default() };
        probe(&empty, place, &options, &quiet()).expect_err("refused")
    };
    for place in [[-3.0, 5.0], [128.0, 5.0], [5.0, 96.0], [f32::NAN, 5.0]] {
        assert_eq!(asked(place, ProbeSubject::Best).subject, "at");
    }
    assert!(asked([200.0, 5.0], ProbeSubject::Best).to_string().contains("128×96"));
    assert_eq!(asked([5.0, 5.0], ProbeSubject::Feature(9999)).subject, "feature");
    let scale = ProbeSubject::Scale { octave: 9, level: 0, slope_index: 0 };
    assert!(asked([5.0, 5.0], scale).problem.contains("no octave 9"));
    // Every corner can be probed.
    for place in [[0.0, 0.0], [127.0, 95.0], [0.0, 95.0], [127.4, -0.4]] {
        assert!(probe(&empty, place, &ProbeOptions::default(), &quiet()).is_ok());
    }
    let change = ParamChange::new(burstscope_core::detector::params::doc::OCTAVES, 99);
    assert!(change.applied(&DetectorParams::default()).is_err());
    let slopes = [Slope::new(-2.0, 0.0), Slope::new(2.0, 0.0)];
    let burst = blobs(9, 0.005, &[(40.0, 48.0, 3.0, 0.2, slopes[0]), (90.0, 48.0, 3.0, 0.2, slopes[1])]);
    let cache = cache(&burst, &params(SlopeExtrema::Each));
    let won = winning_slopes(&cache.trail, 0, 2, &quiet()).expect("not cancelled");
    assert_eq!(won.snr.size(), (128, 96));
    assert_eq!((won.slope_index.at(40, 48), won.slope_index.at(90, 48)), (0.0, 4.0));
    assert!(won.confidence.at(40, 48) > 0.2 && won.confidence.at(90, 48) > 0.2);
    assert_eq!(won.confidence.at(65, 10), 0.0, "nothing is there");
}

fn params(slope_extrema: SlopeExtrema) -> DetectorParams {
    let rest = DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 5), octaves: 2, ..DetectorParams::default() };
    DetectorParams { slope_extrema, noise_gate: NoiseGate::Factor(3.0), ..rest }
}

#[test]
fn candidates_account_for_everything_that_was_an_extremum() {
    let burst = scene(4, (200, 190), 5, 3.0);
    for rule in [SlopeExtrema::Each, SlopeExtrema::Joint] {
        let cache = cache(&burst, &params(rule));
        let all = SurveyOptions { min_snr: 0.0, test: None };
        let survey = survey(&cache.trail, &all, &quiet()).expect("not cancelled");
        assert_eq!(survey.marks.len() as u64, survey.candidates);
        assert_eq!(survey.candidates, survey.kept + survey.counts.iter().map(|c| c.candidates).sum::<u64>());
        assert_eq!(survey.kept, cache.detection().tally.kept);
        for count in &survey.counts {
            match count.test {
                // These tests reject samples that are no candidates.
                test @ (Test::SpaceExtremum | Test::ScaleExtremum) => {
                    assert!(count.candidates == 0 && !test.takes_candidates(), "{count:?}");
                }
                Test::PeakThreshold | Test::NoiseGate => assert!(count.candidates <= count.samples, "{count:?}"),
                Test::MaxFeatures => assert_eq!(count.candidates, 0),
                // Only candidates reach the others.
                _ => assert_eq!(count.samples, count.candidates, "{rule:?} {count:?}"),
            }
        }
        // Each mark agrees with the detailed report.
        for mark in survey.marks.iter().filter(|m| m.snr > 2.0).step_by(37) {
            let fate = fate_of(&cache.trail, &mark.sample, &quiet()).expect("not cancelled");
            let fate = fate.expect("examined");
            assert_eq!((fate.first_failed, fate.value, fate.snr), (mark.first_failed, mark.value, mark.snr));
            let margin = mark.first_failed.and_then(|test| fate.report(test).margin()).map(|m| m as f32);
            assert_eq!(margin, mark.margin);
            assert!(mark.margin.is_none_or(|m| m <= 0.0), "{mark:?}");
        }
        let gated = SurveyOptions { min_snr: 2.5, test: Some(Test::NoiseGate) };
        let gated = place::survey(&cache.trail, &gated, &quiet()).expect("done");
        assert!(!gated.marks.is_empty());
        assert!(gated.marks.iter().all(|m| m.first_failed == Some(Test::NoiseGate) && (2.5..=3.0).contains(&m.snr)));
        assert_eq!(gated.counts, survey.counts, "all are counted, whatever is listed");
    }
    let cache = cache(&scene(4, (60, 50), 4, 3.0), &params(SlopeExtrema::Each));
    assert!(survey(&cache.trail, &SurveyOptions::default(), &cancelled()).is_err());
    assert!(winning_slopes(&cache.trail, 0, 1, &cancelled()).is_err());
}

/// On the built-in demo: candidates at the place come first, those that move as it does before the others; near a
/// scale, each in order of their distance in place and scale together. Larger blobs are last, and nothing beyond a
/// click's exactness is examined unasked.
#[test]
fn on_the_demo_the_nearest_candidate_near_the_scale_in_view_comes_first_and_large_blobs_last() {
    let slopes = SlopeGrid::line(-3.0..=3.0, 13);
    let cache = cache(&demo_burst(), &DetectorParams { slopes, ..DetectorParams::default() });
    let (mut larger, mut nothing_here) = (0, 0);
    for place in [[92.0, 58.0], [200.0, 90.0], [300.0, 40.0], [240.0, 180.0], [60.0, 250.0], [410.0, 300.0]] {
        for sigma in [2.3f32, 6.4, 13.0] {
            let options = ProbeOptions { near_sigma: Some(sigma), ..ProbeOptions::default() };
            let probe = probe(&cache, place, &options, &quiet()).expect("inside");
            let away = |fate: &Fate| (fate.pos_image[0] - place[0]).hypot(fate.pos_image[1] - place[1]);
            let scales = |fate: &Fate| (fate.sigma / sigma).max(sigma / fate.sigma);
            let apart = |fate: &Fate| (away(fate) / 3.0).max(1.0) * (scales(fate) / 1.3).max(1.0);
            let here = probe.near_fates().partition_point(|fate| away(fate) <= 3.0);
            let (here, beyond) = probe.near_fates().split_at(here);
            assert!(beyond.iter().all(|fate| away(fate) > 3.0) && beyond.iter().map(apart).is_sorted(), "{place:?}");
            // Those of its own motion, and the rest.
            let falls = here.windows(2).filter(|two| apart(&two[0]) > apart(&two[1])).count();
            assert!(falls <= 1, "{place:?} {sigma}: {falls}");
            assert!(probe.near_fates().iter().all(|fate| away(fate) <= sigma.max(8.0)), "{place:?} {sigma}");
            assert!(probe.larger_fates().iter().all(|fate| away(fate) > 3.0), "{place:?} {sigma}");
            larger += probe.larger_fates().len();
            let [u, v] = probe.subject.pos_image;
            assert!((u - place[0]).hypot(v - place[1]) <= 3.0, "a click moves by three pixels at most");
            nothing_here += usize::from(probe.subject.fate.is_none());
        }
    }
    assert!(larger > 20 && nothing_here > 0, "{larger} {nothing_here}: it would hold for nothing");
}
