//! The candidates of a whole picture, and maps of the winning slopes.

use super::law::scene;
use super::probing::{blobs, cache};
use burstscope_core::Monitor;
use burstscope_core::detector::{DetectorParams, NoiseGate, Slope, SlopeExtrema, SlopeGrid, Test};
use burstscope_core::inspect::candidates::{SurveyOptions, coverage_map, survey, winning_slopes};
use burstscope_core::inspect::probe::fate_of;

fn params(slope_extrema: SlopeExtrema) -> DetectorParams {
    DetectorParams {
        slopes: SlopeGrid::line(-2.0..=2.0, 5),
        octaves: 2,
        slope_extrema,
        noise_gate: NoiseGate::Factor(3.0),
        ..DetectorParams::default()
    }
}

#[test]
fn candidates_account_for_everything_that_was_an_extremum() {
    let burst = scene(4, (200, 190), 5, 3.0);
    for rule in [SlopeExtrema::Each, SlopeExtrema::Joint] {
        let cache = cache(&burst, &params(rule));
        let all = SurveyOptions { min_snr: 0.0, test: None };
        let survey = survey(&cache.trail, &all, &Monitor::default()).expect("not cancelled");
        assert_eq!(survey.marks.len() as u64, survey.candidates);
        assert_eq!(survey.candidates, survey.kept + survey.counts.iter().map(|c| c.candidates).sum::<u64>());
        assert_eq!(survey.kept, cache.detection().tally.kept);
        for count in &survey.counts {
            match count.test {
                // Only candidates reach these tests.
                Test::SlopeExtremum
                | Test::Refinement
                | Test::InterpolatedContrast
                | Test::Edge
                | Test::Outside
                | Test::Duplicate => assert_eq!(count.samples, count.candidates, "{rule:?} {count:?}"),
                // These tests reject samples that are no candidates.
                Test::SpaceExtremum | Test::ScaleExtremum => assert_eq!(count.candidates, 0, "{count:?}"),
                Test::PeakThreshold | Test::NoiseGate => assert!(count.candidates <= count.samples, "{count:?}"),
                Test::MaxFeatures => assert_eq!(count.candidates, 0),
            }
        }
        // Each mark agrees with the detailed report.
        for mark in survey.marks.iter().filter(|m| m.snr > 2.0).step_by(37) {
            let fate = fate_of(&cache.trail, &mark.of_sample(), &Monitor::default()).expect("not cancelled");
            let fate = fate.expect("examined");
            assert_eq!((fate.first_failed, fate.value, fate.snr), (mark.first_failed, mark.value, mark.snr));
            let margin = mark.first_failed.and_then(|test| fate.report(test).margin()).map(|m| m as f32);
            assert_eq!(margin, mark.margin);
            assert!(mark.margin.is_none_or(|m| m <= 0.0), "{mark:?}");
        }
        let gated = SurveyOptions { min_snr: 2.5, test: Some(Test::NoiseGate) };
        let gated =
            burstscope_core::inspect::candidates::survey(&cache.trail, &gated, &Monitor::default()).expect("done");
        assert!(!gated.marks.is_empty());
        assert!(gated.marks.iter().all(|m| m.first_failed == Some(Test::NoiseGate) && (2.5..=3.0).contains(&m.snr)));
        assert_eq!(gated.counts, survey.counts, "all are counted, whatever is listed");
    }
}

#[test]
fn a_cancelled_survey_has_no_result() {
    let cache = cache(&scene(4, (60, 50), 4, 3.0), &params(SlopeExtrema::Each));
    let monitor = Monitor::default();
    monitor.cancel();
    assert!(survey(&cache.trail, &SurveyOptions::default(), &monitor).is_err());
    assert!(winning_slopes(&cache.trail, 0, 1, &monitor).is_err());
}

#[test]
fn the_winning_slope_is_the_one_that_a_blob_moves_with() {
    let slopes = [Slope::new(-2.0, 0.0), Slope::new(2.0, 0.0)];
    let burst = blobs(9, 0.005, &[(40.0, 48.0, 3.0, 0.2, slopes[0]), (90.0, 48.0, 3.0, 0.2, slopes[1])]);
    let cache = cache(&burst, &params(SlopeExtrema::Each));
    let won = winning_slopes(&cache.trail, 0, 2, &Monitor::default()).expect("not cancelled");
    assert_eq!(won.snr.size(), (128, 96));
    assert_eq!((won.slope_index.at(40, 48), won.slope_index.at(90, 48)), (0.0, 4.0));
    assert!(won.confidence.at(40, 48) > 0.2 && won.confidence.at(90, 48) > 0.2);
    assert_eq!(won.confidence.at(65, 10), 0.0, "nothing is there");
}

#[test]
fn coverage_counts_the_frames_that_show_a_pixel() {
    let cache = cache(&blobs(5, 0.01, &[]), &params(SlopeExtrema::Each));
    let map = coverage_map(&cache.trail, Slope::new(2.0, 0.0));
    assert_eq!((map.at(64, 48), map.at(0, 48), map.at(127, 48)), (5.0, 3.0, 3.0));
    assert_eq!(map.at(2, 0), 4.0);
}
