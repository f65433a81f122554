//! Laws of aligned matches: the order of the bursts changes nothing, and a burst that is shifted by some pixels is
//! found to be shifted by them.

use crate::prelude::*;
use burstscope_core::dataset::{BurstSide, DetectedBurst, match_bursts};
use burstscope_core::matching::align::Measured;
use burstscope_core::matching::aligned::{AlignedImages, Alignment, Inlier, MOST_MOVED_PX, Seen};
use burstscope_core::matching::{Blob, MatchResult, Verification, beside, match_features};
use std::collections::BTreeSet;

fn params() -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, 7), ..DetectorParams::default() }
}

fn found(burst: &Burst) -> Detection {
    detect(burst, &params(), &quiet()).expect("valid parameters")
}

fn matched(bursts: [(&Burst, &Detection); 2], geometry: Geometry) -> MatchResult {
    let params = params();
    let sides = bursts.map(|(burst, detection)| DetectedBurst { burst, params: &params, detection });
    let matching = MatchParams { geometry, ..MatchParams::default() };
    match_bursts(sides, &matching, &quiet()).expect("valid parameters")
}

/// The inliers (a, b), and how far each is shifted in B by the alignment.
fn inliers(result: &MatchResult) -> Vec<((usize, usize), [f64; 2])> {
    let verified = result.verification.as_ref().expect("verified");
    let aligned = result.alignment.as_ref().expect("aligned");
    let all = result.matches.iter().zip(&verified.inlier).enumerate().filter(|(_, (_, inlier))| **inlier);
    let shift = |index: usize| aligned.shift_in_b(index).expect("inliers are measured").0;
    all.map(|(index, (m, _))| ((m.a, m.b), shift(index))).collect()
}

#[test]
fn from_b_to_a_they_are_those_from_a_to_b_and_places_that_the_pictures_correct_fit_the_geometry_exactly() {
    let bursts = [demo_burst(), later_demo_burst()];
    let [a, b] = [found(&bursts[0]), found(&bursts[1])];
    let there = matched([(&bursts[0], &a), (&bursts[1], &b)], Geometry::Fundamental);
    let back = matched([(&bursts[1], &b), (&bursts[0], &a)], Geometry::Fundamental);
    let there: BTreeSet<_> = inliers(&there).into_iter().map(|(pair, _)| pair).collect();
    let back: BTreeSet<_> = inliers(&back).into_iter().map(|((b, a), _)| (a, b)).collect();
    let both = there.intersection(&back).count();
    println!("{} there, {} back, {both} both ways", there.len(), back.len());
    // Samples of the search for a geometry are drawn in another order, and a match is predicted by the motion of the
    // place that it begins from: 92 to 93 of 100 are the same with six seeds.
    assert!(both > 300 && both * 100 >= there.len().max(back.len()) * 91);
    let [a, b, found] = scene(80);
    let (aligned, verified) = confirmed_of(80, |i| Some(measured(found[i], b[i])), [&a, &found]);
    assert!(verified.model.is_some() && verified.inlier_count() == 80, "{}", verified.inlier_count());
    // A prior that is weak beside the measurement leaves a hundredth of the correction.
    let apart = |i: usize| {
        let correction = |side: usize, before: [f64; 2], k: usize| aligned.places[side][i][k] - before[k];
        [0, 1].map(|k| found[i][k] - b[i][k] + correction(1, found[i], k) - correction(0, a[i], k))
    };
    let largest = (0..80).flat_map(apart).map(f64::abs).fold(0.0, f64::max);
    assert!(largest < 0.05, "{largest} px");
    assert!(verified.error_px.iter().all(|error| *error < 0.5), "{:?}", verified.error_px);
}

/// The demo burst, and the same that shows all 11 px farther right and 6 px lower.
fn demo_and_shifted() -> [Burst; 2] {
    let burst = demo_burst();
    let frames = burst.frames.iter().map(|frame| {
        let (width, height) = frame.size();
        Plane::from_fn(width, height, |u, v| frame.get(u as i64 - 11, v as i64 - 6).unwrap_or(0.1))
    });
    let shifted = Burst::from_planes("shifted", frames.collect());
    [burst, shifted]
}

#[test]
fn beside_few_measured_matches_lie_the_others_each_at_its_place_and_once() {
    let bursts = demo_and_shifted();
    let found = [found(&bursts[0]), found(&bursts[1])];
    let side =
        |k: usize| BurstSide::from(&found[k]).with_pictures(&bursts[k], &params(), &quiet()).expect("valid parameters");
    let [mut a, b] = [side(0), side(1)];
    // Half of the places have no match by their descriptors.
    let nothing = a.places.iter().zip(&mut a.descriptors).filter(|(place, _)| (place[0] as usize).is_multiple_of(2));
    nothing.for_each(|(_, descriptor)| descriptor.fill(0));
    let (sides, params) = ([a.side(), b.side()], MatchParams { predict: false, ..MatchParams::default() });
    let few = match_features(sides, &params, &quiet()).expect("valid parameters");
    let verified = few.result.verification.as_ref().expect("verified");
    let new = beside(sides, &few, &params, &quiet()).expect("not cancelled");
    println!("{} beside {} inliers of {} features", new.len(), verified.inlier_count(), found[0].features.len());
    assert!(new.len() > 100 && 2 * new.len() > verified.inlier_count());
    let inliers = few.result.matches.iter().zip(&few.measured).filter(|(_, measured)| measured.is_some());
    let inliers: Vec<[usize; 2]> = inliers.map(|(m, _)| [m.a, m.b]).collect();
    let new: Vec<([usize; 2], Measured)> = new.iter().map(|(m, of)| ([m.a as usize, m.b as usize], *of)).collect();
    for (k, side) in sides.iter().enumerate() {
        let all = inliers.iter().chain(new.iter().map(|(ends, _)| ends)).map(|ends| side.places[ends[k]]);
        let once: BTreeSet<[u64; 2]> = all.clone().map(|place| place.map(f64::to_bits)).collect();
        let of_inliers: BTreeSet<_> = inliers.iter().map(|ends| side.places[ends[k]].map(f64::to_bits)).collect();
        assert_eq!(once.len(), of_inliers.len() + new.len(), "each place is new, and in one match");
    }
    let right = |([i, j], measured): &&([usize; 2], Measured)| {
        let moved = [0, 1].map(|k| sides[1].places[*j][k] + measured.shift_px[k] - sides[0].places[*i][k]);
        (moved[0] - 11.0).hypot(moved[1] - 6.0) < 0.5
    };
    let right = new.iter().filter(right).count();
    assert!(right * 20 > new.len() * 19, "{right} of {} lie where they are", new.len());
    let cancelled = quiet();
    cancelled.cancel();
    assert!(beside(sides, &few, &params, &cancelled).is_err());
    // Without an inlier nothing is known of what lies beside.
    let none = match_features(sides, &MatchParams { geometry: Geometry::None, ..params.clone() }, &quiet());
    assert!(beside(sides, &none.expect("valid parameters"), &params, &quiet()).expect("not cancelled").is_empty());
}

#[test]
fn a_shifted_burst_is_found_to_be_and_places_that_contradict_their_other_matches_lose_them() {
    let [burst, shifted] = demo_and_shifted();
    let [a, b] = [found(&burst), found(&shifted)];
    let result = matched([(&burst, &a), (&shifted, &b)], Geometry::Homography);
    let found = inliers(&result);
    let off = |&((i, j), shift): &((usize, usize), [f64; 2])| {
        let (a, b) = (&a.features[i], &b.features[j]);
        let moved = [f64::from(b.u) + shift[0] - f64::from(a.u), f64::from(b.v) + shift[1] - f64::from(a.v)];
        (moved[0] - 11.0).hypot(moved[1] - 6.0)
    };
    let mut errors_px: Vec<f64> = found.iter().map(off).collect();
    errors_px.sort_by(f64::total_cmp);
    let of = |part: f64| errors_px[(part * (errors_px.len() - 1) as f64) as usize];
    println!("{} inliers, {:.3} px in the median, {:.3} px of 95 in 100", found.len(), of(0.5), of(0.95));
    assert!(found.len() * 2 > result.matches.len() && of(0.5) < 0.02 && of(0.95) < 0.2);
    // Three images; the third sees the first's places 5 px beside where the second one does.
    let [a, b, _] = scene(60);
    let mut alignment = Alignment::default();
    [&a, &b, &b].into_iter().for_each(|places| alignment.add_image(places.clone(), &blobs(60), None));
    let found = |i: usize| Inlier { a: i as u32, b: i as u32, rank: 0.5 };
    let mut pairs = [(0, 1), (0, 2), (1, 2)].map(|images| (images, Vec::new()));
    for (images, matches) in &mut pairs {
        for (i, &at) in b.iter().enumerate() {
            let to = if *images == (0, 2) && i < 20 { [at[0] + 5.0, at[1]] } else { at };
            matches.push((found(i), Some(alignment.add_match(*images, (i, i), measured(at, to)))));
        }
    }
    let aligned = alignment.solve(&quiet()).expect("not cancelled");
    let (images, matches) = &pairs[1];
    let params = MatchParams::default();
    let verified = aligned.confirmed(*images, None, matches, &params, &quiet()).expect("valid").expect("asked");
    assert!(!verified.inlier[..20].contains(&true) && verified.inlier[20..].iter().all(|inlier| *inlier));
}

/// Places of B in an image of 200×100, of which the left 50 columns are hidden, after the alignment with those of A,
/// from which each is `shift` away; A's places are found twice, so that they stay.
fn aligned_with(shifts: &[([f64; 2], [f64; 2], f32)]) -> (Vec<[f64; 2]>, usize, f64) {
    let plane = Plane::zeros(200, 100).masked(Mask::new(Plane::from_fn(200, 100, |u, _| f32::from(u >= 50))));
    let blobs: Vec<Blob> = shifts
        .iter()
        .map(|&(_, _, sigma)| {
            let slope = Slope::default();
            Blob { sigma, orientation: 0.0, slope, motion: slope, motion_sigma: 1.0 }
        })
        .collect();
    let mut alignment = Alignment::default();
    let found: Vec<[f64; 2]> = shifts.iter().map(|(place, ..)| *place).collect();
    let truth: Vec<[f64; 2]> = shifts.iter().map(|([u, v], [du, dv], _)| [u + du, v + dv]).collect();
    alignment.add_image(found, &blobs, Some(Seen::of(&plane)));
    // Forty images that agree on where it is leave their own places.
    for _ in 0..40 {
        alignment.add_image(truth.clone(), &blobs, None);
    }
    let jacobian = [[1.0, 0.0], [0.0, 1.0]];
    for (k, (_, shift, _)) in shifts.iter().enumerate() {
        for image in 1..=40 {
            let shift_px = shift.map(|x| -x);
            alignment.add_match((0, image), (k, k), Measured { shift_px, jacobian, correlation: 1.0 });
            let next = 1 + image % 40;
            alignment.add_match((image, next), (k, k), Measured { shift_px: [0.0; 2], jacobian, correlation: 1.0 });
        }
    }
    let aligned = alignment.solve(&quiet()).expect("not cancelled");
    (aligned.places[0].clone(), aligned.moved.refused, aligned.moved.max_px.unwrap_or(0.0))
}

#[test]
fn no_keypoint_is_moved_far_or_out_of_what_is_seen() {
    let shifts = [
        ([100.0, 50.0], [2.0, 1.0], 2.0),
        ([110.0, 50.0], [7.0, 0.0], 2.0),
        // Less than a scale, but more than any is moved.
        ([120.0, 50.0], [35.0, 0.0], 30.0),
        ([130.0, 50.0], [12.0, 12.0], 30.0),
        // Out of the picture, and under its mask.
        ([197.0, 50.0], [5.0, 0.0], 6.0),
        ([140.0, 98.0], [0.0, 4.0], 6.0),
        ([53.0, 50.0], [-6.0, 0.0], 6.0),
        ([60.0, 50.0], [-6.0, 0.0], 6.0),
    ];
    let (places, refused, max_px) = aligned_with(&shifts);
    let moves = [true, true, false, true, false, false, false, true];
    for ((place, (found, shift, _)), moves) in places.iter().zip(shifts).zip(moves) {
        let moved = [place[0] - found[0], place[1] - found[1]];
        if moves {
            // What all images have in common is left to the weak prior.
            let part = (moved[0] * shift[0] + moved[1] * shift[1]) / (shift[0] * shift[0] + shift[1] * shift[1]);
            assert!((0.6..1.01).contains(&part), "{found:?} is moved by {moved:?}");
        } else {
            assert_eq!(*place, found, "it stays to the bit");
        }
    }
    assert_eq!(refused, moves.iter().filter(|moves| !**moves).count());
    assert!(max_px > 10.0 && max_px <= MOST_MOVED_PX, "{max_px}");
}

fn blobs(count: usize) -> Vec<Blob> {
    let slope = Slope::default();
    vec![Blob { sigma: 4.0, orientation: 0.0, slope, motion: slope, motion_sigma: 1.0 }; count]
}

/// Places of `count` things in space in both images, and where blobs are found in B: some pixels beside them.
fn scene(count: usize) -> [Vec<[f64; 2]>; 3] {
    let mut random = Stream::new(3, 0);
    let seen = |_| {
        let (u, v, near) = (random.within(0.0, 640.0), random.within(0.0, 480.0), 1.0 / random.within(3.0, 9.0));
        // Away from one place, the farther the nearer they are.
        ([u, v], [u + near * (u - 900.0), v + near * (v - 300.0)])
    };
    let (a, b): (Vec<[f64; 2]>, Vec<[f64; 2]>) = (0..count).map(seen).unzip();
    let mut random = Stream::new(4, 0);
    let found = b.iter().map(|place| place.map(|x| x + random.within(-3.0, 3.0))).collect();
    [a, b, found]
}

fn measured(from: [f64; 2], to: [f64; 2]) -> Measured {
    let shift_px = [to[0] - from[0], to[1] - from[1]];
    Measured { shift_px, jacobian: [[1.0, 0.0], [0.0, 1.0]], correlation: 0.9 }
}

/// Matches of the i-th features, measured by `measure`, and their geometry after the alignment.
fn confirmed_of(
    count: usize,
    measure: impl Fn(usize) -> Option<Measured>,
    [a, b]: [&[[f64; 2]]; 2],
) -> (AlignedImages, Verification) {
    let mut alignment = Alignment::default();
    [a, b].into_iter().for_each(|places| alignment.add_image(places.to_vec(), &blobs(count), None));
    let found = |i: usize| Inlier { a: i as u32, b: i as u32, rank: 0.5 };
    let mut link = |i| (found(i), measure(i).map(|measured| alignment.add_match((0, 1), (i, i), measured)));
    let inliers: Vec<(Inlier, Option<usize>)> = (0..count).map(&mut link).collect();
    let aligned = alignment.solve(&quiet()).expect("not cancelled");
    let params = MatchParams::default();
    let verified = aligned.confirmed((0, 1), None, &inliers, &params, &quiet()).expect("valid parameters");
    (aligned, verified.expect("asked for"))
}

#[test]
fn what_is_not_measured_stays_where_it_is_and_is_no_inlier_and_a_pair_that_keeps_few_matches_is_refused() {
    let [a, b, _] = scene(80);
    let (aligned, verified) = confirmed_of(80, |i| (i < 60).then(|| measured(b[i], b[i])), [&a, &b]);
    assert!(aligned.places[0][60..] == a[60..] && aligned.places[1][60..] == b[60..]);
    assert!(verified.inlier[..60].iter().all(|inlier| *inlier) && !verified.inlier[60..].contains(&true));
    assert!(verified.error_px[60..].iter().all(|error| *error < 0.5), "its error is known all the same");
    let [a, b, _] = scene(200);
    for (kept, is_believed) in [(29, false), (49, false), (60, true)] {
        let (_, verified) = confirmed_of(200, |i| (i < kept).then(|| measured(b[i], b[i])), [&a, &b]);
        assert_eq!((verified.model.is_some(), verified.inlier.contains(&true)), (is_believed, is_believed), "{kept}");
    }
}
