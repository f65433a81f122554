//! Laws of the times of frames: even ones that are given change no bit, and uneven ones that are given restore what the
//! even burst shows.

use crate::prelude::*;
use burstscope_core::inspect::result::finds;

fn chart(uneven: Uneven, motion: Motion) -> (Burst, Truth) {
    let params = ChartParams { width: 400, height: 300, discs: 30, frames: 12, snr: 1.5, ..ChartParams::default() };
    let params = ChartParams { max_slope: 2.5, ..params };
    synth_chart(&ChartParams { uneven, motion, ..params }, &quiet()).expect("a chart")
}

fn uneven_by(drop: Vec<usize>, jitter: f64) -> Uneven {
    Uneven { drop, jitter, ..Uneven::default() }
}

fn found(burst: &Burst) -> Detection {
    search(burst, &SearchParams::default(), &quiet()).expect("valid parameters").detection
}

/// Discs that a feature finds with their motion, to a tenth of a pixel per frame.
fn with_motion(detection: &Detection, truth: &Truth) -> usize {
    let is_found = |disc: &&burstscope_core::synth::FeatureTruth| {
        let apart = |f: &Feature| (f64::from(f.slope.u) - disc.slope_u).hypot(f64::from(f.slope.v) - disc.slope_v);
        detection.features.iter().any(|feature| finds(feature, disc) && apart(feature) < 0.1)
    };
    truth.features.iter().filter(is_found).count()
}

#[test]
fn even_times_that_are_given_change_no_bit_and_even_times_have_the_bits_of_indices() {
    let (burst, _) = chart(Uneven::default(), Motion::OneD);
    let seconds: Vec<f64> = (0..burst.len()).map(|t| 1_614_636_000.25 + t as f64 / 30.0).collect();
    let timed = Burst { positions: Positions::of_seconds(&seconds).expect("they increase"), ..burst.clone() };
    assert!(timed.positions.interval_s().is_some());
    let (plain, timed) = (found(&burst), found(&timed));
    assert!(plain.features.len() > 20);
    assert_eq!((&plain.features, &plain.descriptors), (&timed.features, &timed.descriptors));
    assert_eq!((plain.slopes, plain.tally, &plain.field), (timed.slopes, timed.tally, &timed.field));
    assert_eq!(plain.noise, timed.noise);
    for count in [1, 2, 3, 7, 10, 40] {
        let even = Positions::even(count);
        let expected: Vec<Offset> = (0..count).map(|t| (t as f64 - (count as f64 - 1.0) / 2.0).into()).collect();
        assert_eq!(even.offsets(), expected);
        assert_eq!((even.reach(), even.is_even()), (0.5 * (count as f64 - 1.0), true));
        assert_eq!(even.span(), count as f64 - 1.0);
        for (start, step) in [(0.0, 1.0), (1_305_031_102.175_304, 1.0 / 30.0), (-3.0, 0.1), (7.0, 3600.0)] {
            let seconds: Vec<f64> = (0..count).map(|t| start + step * t as f64).collect();
            let timed = Positions::of_seconds(&seconds).expect("they increase");
            assert_eq!(timed.offsets(), expected, "{start} {step}");
            assert!(count < 2 || (timed.interval_s().expect("known") / step - 1.0).abs() < 1e-5);
        }
    }
    assert_eq!(Positions::even(9).part(2..6), Positions::even(4));
}

#[test]
fn dropped_frames_with_their_times_give_the_slopes_of_all_and_without_them_do_not() {
    for motion in [Motion::OneD, Motion::TwoD] {
        let (all, truth) = chart(Uneven::default(), motion);
        let of_all = with_motion(&found(&all), &truth);
        assert!(of_all >= 24, "{motion:?}: {of_all} of all frames");
        for uneven in [uneven_by(vec![2, 3, 4, 8], 0.0), uneven_by(Vec::new(), 0.45)] {
            let (timed, truth) = chart(uneven.clone(), motion);
            let untimed = Burst { positions: Positions::even(timed.len()), ..timed.clone() };
            let [with, without] = [&timed, &untimed].map(|burst| with_motion(&found(burst), &truth));
            println!("{motion:?} {uneven:?}: {of_all} of all frames, {with} with times, {without} without");
            assert!(with * 10 >= of_all * 8, "{motion:?} {uneven:?}: {with} of {of_all}");
            if !uneven.drop.is_empty() {
                assert!(without * 2 < with, "{motion:?} {uneven:?}: {without} without times, {with} with");
            }
        }
    }
}

#[test]
fn slopes_are_found_at_the_frames_times_and_frames_that_stay_have_the_bits_of_the_even_burst() {
    let params = DetectorParams::default();
    let find = |burst: &Burst| find_slopes(burst, &params, None, &quiet()).expect("not cancelled");
    let (all, _) = chart(Uneven::default(), Motion::OneD);
    let (timed, _) = chart(uneven_by(vec![3, 4, 5, 8], 0.0), Motion::OneD);
    let [of_all, with] = [&all, &timed].map(find);
    assert_eq!((of_all.verdict, with.verdict), (SlopeVerdict::Found, SlopeVerdict::Found));
    // The burst is as long, so its grid has the same step.
    assert!((of_all.grid.u.step() - with.grid.u.step()).abs() < 1e-6, "{:?} {:?}", of_all.grid, with.grid);
    let step = of_all.grid.u.step();
    let off = (of_all.grid.u.min - with.grid.u.min).abs().max((of_all.grid.u.max - with.grid.u.max).abs());
    assert!(off < 2.5 * step, "{:?} {:?}", of_all.grid, with.grid);
    let even = ChartParams { width: 160, height: 120, discs: 4, frames: 6, ..ChartParams::default() };
    let made = |uneven: Uneven| synth_chart(&ChartParams { uneven, ..even.clone() }, &quiet()).expect("a chart");
    let (all, truth) = made(Uneven::default());
    let (some, moved) = made(uneven_by(vec![1, 5], 0.0));
    assert_eq!(some.positions.since_first(), [0.0, 2.0, 3.0, 4.0]);
    assert!([0, 2, 3, 4].iter().zip(&some.frames).all(|(t, frame)| all.frames[*t] == *frame));
    assert_eq!((moved.frames, moved.t0, &moved.times[..]), (4, 2.25, &[0.0, 2.0, 3.0, 4.0][..]));
    for (a, b) in truth.features.iter().zip(&moved.features) {
        let (u, v) = a.position(2.25 - truth.t0);
        assert!((u - b.u).hypot(v - b.v) < 1e-9 && a.slope_u == b.slope_u);
    }
    let (late, _) = made(uneven_by(Vec::new(), 0.3));
    assert!(!late.positions.is_even() && (late.positions.span() - 5.0).abs() < 1e-9);
}

#[test]
fn nonsense_is_named_and_gaps_are_counted_in_intervals_of_the_camera() {
    for (uneven, name) in [
        (uneven_by(vec![10], 0.0), "drop"),
        (uneven_by((0..10).collect(), 0.0), "drop"),
        (uneven_by(Vec::new(), 0.5), "jitter"),
        (uneven_by(Vec::new(), f64::NAN), "jitter"),
    ] {
        assert_eq!(uneven.taken(10, 1).expect_err("nonsense").subject, name);
    }
    let dropped = Positions::of_seconds(&[0.0, 0.1, 0.3, 0.4, 0.6, 0.7]).expect("they increase");
    assert_eq!(dropped.since_first(), [0.0, 1.0, 3.0, 4.0, 6.0, 7.0]);
    assert!(!dropped.is_even() && (dropped.interval_s().expect("known") - 0.1).abs() < 1e-12);
    assert_eq!(dropped.longest_gap(), Some((2.0, 1)));
    // Times to a millisecond, at 30 Hz.
    let rounded = Positions::of_seconds(&[0.0, 0.033, 0.067, 0.1, 0.133, 0.167, 0.2]).expect("they increase");
    assert!(rounded.since_first().iter().zip(0..).all(|(x, t)| (x - f64::from(t)).abs() < 0.02), "{rounded:?}");
    assert_eq!(rounded.span(), 6.0);
    for wrong in [&[0.0, 0.0][..], &[1.0, 0.0], &[0.0, f64::NAN], &[0.0, f64::INFINITY]] {
        assert_eq!((Positions::of_seconds(wrong), Positions::new(wrong)), (None, None), "{wrong:?}");
    }
    assert_eq!(Positions::of_seconds(&[5.0]).map(|one| one.offsets().to_vec()), Some(vec![Offset::default()]));
    assert_eq!(Positions::of_seconds(&[]).map(|none| none.len()), Some(0));
}

proptest! {
    #[test]
    fn a_part_keeps_the_distances(gaps in prop::collection::vec(0.01f64..9.0, 1..20), from in 0usize..19) {
        let places: Vec<f64> = gaps.iter().scan(0.0, |at, gap| { *at += gap; Some(*at) }).collect();
        let all = Positions::new(&places).expect("they increase");
        let part = all.part(from.min(places.len() - 1)..places.len());
        prop_assert!(part.offsets().iter().map(|at| at.u).sum::<f64>().abs() < 1e-9 * places.len() as f64);
        for (own, whole) in part.offsets().windows(2).zip(all.offsets()[all.len() - part.len()..].windows(2)) {
            prop_assert!(((own[1] - own[0]) - (whole[1] - whole[0])).length() < 1e-9);
        }
    }
}
