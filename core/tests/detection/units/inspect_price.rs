//! Tests of `inspect::price`.

use burstscope_core::detector::params::doc;
use burstscope_core::detector::*;
use burstscope_core::detector::{NoiseGate, SlopeGrid};
use burstscope_core::inspect::price::*;
use burstscope_core::inspect::*;
use burstscope_core::monitor::*;
use burstscope_core::synth::{ChartParams, synth_chart};

#[test]
fn a_price_says_what_happens_to_this_one_and_how_many_others_there_are_then() {
    let price = |now, then, own| Price { now, then, own }.sentence();
    assert_eq!(price(10, 1_111, Some((0, 1))), "keeps this one, and 1 100 more");
    assert_eq!(price(10, 11, Some((0, 1))), "keeps this one, and as many others as now");
    assert_eq!(price(10, 7, Some((2, 0))), "removes this one, and 1 other");
    assert_eq!(price(10, 9, Some((0, 1))), "keeps this one, and 2 fewer others");
    assert_eq!(price(10, 12, Some((0, 0))), "does not keep this one, and 2 more");
    assert_eq!([price(3, 5, None), price(3, 3, None)], ["2 more features", "the number of features stays"]);
}

#[test]
fn prices_are_what_the_search_finds_with_the_change() {
    let chart = ChartParams { width: 240, height: 180, discs: 20, frames: 7, snr: 0.5, ..ChartParams::default() };
    let (burst, _) = synth_chart(&chart, &Monitor::default()).expect("a chart");
    let slopes = SlopeGrid::line(-3.0..=3.0, 9);
    let gate = NoiseGate::Factor(6.0);
    let params = DetectorParams { slopes, noise_gate: gate, max_features: 9, ..DetectorParams::default() };
    let cache = |params: &DetectorParams| {
        ProbeCache::new(&burst, &SearchParams::from(params.clone()), &Monitor::default()).expect("valid")
    };
    let open = DetectorParams { max_features: 0, ..params.clone() };
    for (before, change, is_at_once) in [
        (&params, ParamChange::new(doc::NOISE_GATE, 4.2), false),
        (&params, ParamChange::new(doc::NOISE_GATE, 7), true),
        (&params, ParamChange::new(doc::MAX_FEATURES, 12), true),
        (&params, ParamChange::new(doc::MAX_FEATURES, 0), true),
        (&open, ParamChange::new(doc::DISTINCT, 3), true),
        (&open, ParamChange::new(doc::LEVELS, 3), false),
    ] {
        let (of, after) = (cache(before), cache(&change.applied(before).expect("valid")));
        let sample_of = |cache: &ProbeCache, rank: usize| {
            let k = cache.trail.keypoints()[cache.trail.keypoint_of_feature(rank)];
            let [x, y] = k.sample.map(|at| at as usize);
            Sample { octave: k.octave, level: k.level, slope_index: k.slope_index, x, y }
        };
        let sample = sample_of(&of, 0);
        let found = price(&of, &burst, &change, Some(sample), &Monitor::default()).expect("valid");
        let at_once = price_at_once(&of.trail, &change, Some(sample), &Monitor::default()).expect("not cancelled");
        assert_eq!(at_once, is_at_once.then_some(found), "{change:?}");
        let count = |cache: &ProbeCache| cache.detection().features.len();
        assert_eq!((found.now, found.then), (count(&of), count(&after)), "{change:?}");
        let own_then = (0..found.then).filter(|rank| sample_of(&after, *rank) == sample).count();
        assert_eq!(found.own.map(|own| own.1), Some(own_then), "{change:?}");
    }
}

#[test]
fn twice_the_slopes_take_twice_the_time() {
    let with = |count, first_octave| DetectorParams {
        slopes: SlopeGrid::line(-3.0..=3.0, count),
        first_octave,
        ..DetectorParams::default()
    };
    assert!((time_factor(&with(7, 0), &with(14, 0), (640, 480)) - 2.0).abs() < 1e-5);
    let finer = time_factor(&with(7, 0), &with(7, -1), (640, 480));
    assert!((3.5..4.5).contains(&finer), "{finer}");
}
