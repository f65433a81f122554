//! Features compared with discs: which finds which, and the curves of true against false.

use crate::prelude::*;
use burstscope_core::{inspect::result::*, synth::truth::disc_sigma};

fn feature(u: f64, v: f64, sigma: f64, response: f32) -> Feature {
    let [u, v, sigma] = [u, v, sigma].map(|x| x as f32);
    Feature { u, v, sigma, response, snr: 4.0, ..Feature::default() }
}

fn disc(u: f64, v: f64, radius: f64) -> FeatureTruth {
    let sigma = disc_sigma(radius);
    FeatureTruth { id: 0, layer: None, u, v, radius, sigma, slope_u: 0.0, slope_v: 0.0, contrast_sign: 1 }
}

fn discs_of(judged: &[Scored]) -> Vec<(usize, Option<usize>)> {
    judged.iter().map(|j| (j.feature, j.disc)).collect()
}

#[test]
fn a_feature_finds_a_disc_within_half_its_radius_and_a_pixel_and_a_half_and_twice_its_scale() {
    // 0.5·8 + 1.5 = 5.5 px, in any direction.
    for (du, dv, factor, found) in [
        (5.5, 0.0, 1.0, true),
        (0.0, -5.5, 1.0, true),
        (5.51, 0.0, 1.0, false),
        (4.0, 4.0, 1.0, false),
        (0.0, 0.0, 0.499, false),
        (0.0, 0.0, 0.501, true),
        (0.0, 0.0, 1.999, true),
        (0.0, 0.0, 2.001, false),
    ] {
        let feature = feature(50.0 + du, 40.0 + dv, factor * disc_sigma(8.0), 1.0);
        assert_eq!(finds(&feature, &disc(50.0, 40.0, 8.0)), found, "{du} {dv} {factor}");
    }
}

#[test]
fn repeats_and_strays_are_false_and_the_strongest_counts() {
    let discs = [disc(20.0, 20.0, 5.0), disc(60.0, 60.0, 10.0)];
    let features = [
        feature(60.5, 60.0, disc_sigma(10.0), -0.2),
        feature(20.0, 21.0, disc_sigma(5.0), 0.9),
        feature(20.0, 20.0, disc_sigma(5.0), -0.5), // again
        feature(90.0, 5.0, 3.0, 0.7),               // nothing there
    ];
    let judged = judge_by_discs(&features, &discs, Ranking::Response);
    assert_eq!(discs_of(&judged), [(1, Some(0)), (3, None), (2, None), (0, Some(1))]);
    let curve = Curve::of(&judged);
    let counts: Vec<_> = curve.points.iter().map(|p| (p.false_features, p.true_positives)).collect();
    assert_eq!(counts, [(0, 0), (0, 1), (1, 1), (2, 1), (2, 2)]);
    assert_eq!(curve.points[3].threshold, 0.5);
    assert_eq!((curve.at_false_fraction(0.1).true_positives, curve.at_false_fraction(0.5).true_positives), (1, 2));
    // Between two discs a feature takes the nearer one that is free.
    let discs = [disc(20.0, 20.0, 8.0), disc(26.0, 20.0, 8.0)];
    let features = [0.9, 0.8, 0.7].map(|response| feature(24.0, 20.0, disc_sigma(8.0), response));
    let judged = judge_by_discs(&features, &discs, Ranking::Strength);
    assert_eq!(discs_of(&judged), [(0, Some(1)), (1, Some(0)), (2, None)]);
}

#[test]
fn each_ranking_has_its_own_order_and_a_tenth_false_includes_exactly_a_tenth() {
    let mut features = [0.3, -0.4, 0.1].map(|response| feature(0.0, 0.0, 2.0, response));
    (features[0].snr, features[1].snr, features[2].snr) = (9.0, 4.0, 25.0);
    let order = |ranking| judge_by_discs(&features, &[], ranking).iter().map(|j| j.feature).collect::<Vec<_>>();
    assert_eq!(order(Ranking::Response), [1, 0, 2]);
    assert_eq!(order(Ranking::Snr), [2, 0, 1]);
    assert_eq!(order(Ranking::Strength), [0, 1, 2]); // 0.9, 0.8, 0.5
    // The next false one is too many, even though a true one follows.
    let curve = ranked("tttttfttttftt");
    let point = curve.at_false_fraction(0.10);
    assert_eq!((point.true_positives, point.false_features), (9, 1));
    assert_eq!([0, 1, 99].map(|count| curve.true_positives_at(count)), [5, 9, 11]);
    // A bad start is compensated later.
    let late = ranked("ftttttttttttttttttttt");
    assert_eq!(late.at_false_fraction(0.10).true_positives, 20);
    assert_eq!(ranked("").at_false_fraction(0.1).true_positives, 0);
    assert_eq!(mean_curve(&[&curve, &late], 1), [2.5, 14.5]);
}

fn ranked(pattern: &str) -> Curve {
    let judged = pattern.chars().enumerate();
    let judged = judged.map(|(i, c)| Scored { feature: i, worth: -(i as f32), disc: (c == 't').then_some(i) });
    Curve::of(&judged.collect::<Vec<_>>())
}

proptest! {
    #[test]
    fn curves_rise_and_end_at_everything(found in proptest::collection::vec((0u8..20, any::<bool>()), 0..60)) {
        let judged = |(i, &(worth, hit)): (usize, &(u8, bool))| {
            Scored { feature: i, worth: f32::from(worth), disc: hit.then_some(i) }
        };
        let mut judged: Vec<Scored> = found.iter().enumerate().map(judged).collect();
        judged.sort_by(|a, b| b.worth.total_cmp(&a.worth));
        let curve = Curve::of(&judged);
        for pair in curve.points.windows(2) {
            // Features of equal worth come together.
            prop_assert!(pair[0].threshold > pair[1].threshold);
            prop_assert!(pair[0].false_features <= pair[1].false_features);
            prop_assert!(pair[0].true_positives <= pair[1].true_positives);
        }
        prop_assert_eq!(curve.end().true_positives, found.iter().filter(|(_, hit)| *hit).count());
        prop_assert_eq!(curve.end().false_features, found.iter().filter(|(_, hit)| !*hit).count());
        for fraction in [0.0, 0.1, 0.5, 1.0] {
            let qualifies = |p: &&CurvePoint| {
                p.false_features as f64 <= fraction * (p.false_features + p.true_positives) as f64 + 1e-9
            };
            // No threshold that qualifies finds more.
            let most = curve.points.iter().filter(qualifies).map(|p| p.true_positives).max();
            prop_assert_eq!(Some(curve.at_false_fraction(fraction).true_positives), most);
        }
    }
}
