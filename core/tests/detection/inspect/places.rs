//! Probes of small things whose places and motions are known: the reason said is the true one, the setting proposed
//! finds them, and no setting is proposed that keeps a ghost.

use super::probing::{blobs, cache};
use crate::prelude::*;
use burstscope_core::detector::coherence::Shape;
use burstscope_core::inspect::place::{Cause, CauseKind, Fate, PlaceMotion, Probe, ProbeSubject};
use burstscope_core::inspect::result::{against_truth, truth_of};
use burstscope_core::synth::{Camera, chart::draw_disc};

/// Stars of the demo's sky, which moves by 0.95 px/frame.
const STARS: [[f32; 2]; 5] = [[159.9, 23.6], [238.0, 36.0], [23.6, 30.2], [139.6, 103.8], [390.0, 60.0]];
const SKY: Slope = Slope { u: 0.95, v: 0.0 };
/// Light dots of σ 1 to 1.2 px that move by −2 px/frame.
const DOTS: [([f64; 2], f64); 5] =
    [([60.0, 40.0], 1.4), ([119.3, 63.2], 1.7), ([139.0, 64.5], 1.45), ([180.6, 120.4], 1.6), ([90.2, 140.7], 1.5)];
const DOTS_MOVE: Slope = Slope { u: -2.0, v: 0.0 };

/// Dots over a field of larger discs that move faster, as a camera on a rail sees them in poor light.
fn dots() -> Burst {
    const FRAMES: usize = 11;
    let camera = Camera { full_scale_electrons: 60.0, read_noise_electrons: 1.5, black_level: 0.05, bits: Some(12) };
    let frame = |t: usize| {
        let dt = t as f64 - 0.5 * (FRAMES as f64 - 1.0);
        let mut signal = Plane::from_fn(240, 180, |_, _| 0.15);
        for k in 0..12 {
            let (column, row) = (f64::from(k % 4), f64::from(k / 4));
            draw_disc(&mut signal, 20.0 + 62.0 * column - 3.6 * dt, 15.0 + 72.0 * row, 5.0, 0.3);
        }
        for ([u, v], radius) in DOTS {
            draw_disc(&mut signal, u + f64::from(DOTS_MOVE.u) * dt, v, radius, 0.8);
        }
        camera.capture(&signal, &mut Stream::new(7, t as u64 + 1), &quiet()).expect("not cancelled")
    };
    Burst::from_planes("dots", (0..FRAMES).map(frame).collect())
}

fn probed(cache: &ProbeCache, place: [f32; 2], options: ProbeOptions) -> Probe {
    probe(cache, place, &options, &quiet()).expect("inside")
}

fn too_small(probe: &Probe) -> Option<&Cause> {
    probe.reasons.iter().find(|reason| reason.kind == CauseKind::TooSmall)
}

fn apart(a: Slope, b: Slope) -> f32 {
    (a.u - b.u).hypot(a.v - b.v)
}

/// Each place is told to be too small, with its scale and motion, whatever slope is looked at; nothing is kept there by
/// its motion, and the proposed setting finds it.
fn assert_too_small(cache: &ProbeCache, burst: &Burst, places: &[[f32; 2]], motion: Slope) {
    let finds = |cache: &ProbeCache, [u, v]: [f32; 2]| {
        let is_it = |f: &&Feature| (f.u - u).hypot(f.v - v) < 1.5 && f.sigma < 2.6 && apart(f.slope, motion) < 0.35;
        cache.detection().features.iter().any(|f| is_it(&f))
    };
    let mut finer: Option<ProbeCache> = None;
    for &place in places {
        for in_view in [None, Some(motion), Some(Slope::default())] {
            let probe = probed(cache, place, ProbeOptions { in_view, ..ProbeOptions::default() });
            let Some(reason) = too_small(&probe) else {
                assert!(finds(cache, place), "{place:?} {in_view:?}: {} {:?}", probe.summary, probe.reasons);
                continue;
            };
            assert!(!finds(cache, place), "{place:?}: it was found");
            assert!(apart(reason.slope, motion) < 0.35, "{place:?} {reason:?}");
            let (sigma, snr) = reason.sigma_and_snr.unwrap_or_else(|| panic!("{place:?} {in_view:?}: {reason:?}"));
            assert!((0.9..1.7).contains(&sigma) && snr > 5.0, "{place:?} {reason:?}");
            let words = ["too small for the smallest scale", "first octave −1 finds it", "about 4 times as long"];
            says(&reason.sentence, &words);
            says(&probe.summary, &["too small"]);
            assert_eq!(probe.own_slope.map(|own| apart(own, motion) < 0.7), Some(true), "{:?}", probe.own_slope);
            let change = reason.change.as_ref().expect("a setting");
            let finer = finer.get_or_insert_with(|| {
                let params = change.applied(&cache.made_with()).expect("valid");
                ProbeCache::new(burst, &SearchParams::from(params), &quiet()).expect("valid")
            });
            assert!(finds(finer, place), "{place:?}: first octave −1 does not find it");
            let after = probed(finer, place, ProbeOptions { in_view, ..ProbeOptions::default() });
            assert!(too_small(&after).is_none_or(|reason| reason.change.is_none()), "{:?}", after.reasons);
        }
    }
    assert!(finer.is_some(), "one of them is too small");
}

#[test]
fn the_stars_of_the_demo_are_too_small_for_the_smallest_scale() {
    let burst = demo_burst();
    let cache = ProbeCache::new(&burst, &SearchParams::default(), &quiet()).expect("valid");
    assert_too_small(&cache, &burst, &STARS, SKY);
    // The subject is the place at its own motion, along which all frames respond.
    for place in STARS {
        let probe = probed(&cache, place, ProbeOptions::default());
        assert!(apart(probe.subject.slope, SKY) < 0.7, "{place:?}: {:?}", probe.subject);
        assert_ne!(probe.shares.evenness.shape, Shape::Bump, "{place:?}: {}", probe.shares.meaning);
    }
    // A star that was kept at slopes with which it does not move is told to be found there.
    let probe = probed(&cache, STARS[1], ProbeOptions { in_view: Some(SKY), ..ProbeOptions::default() });
    let others: Vec<_> = probe.reasons.iter().filter(|r| r.kind == CauseKind::AtAnotherSlope).collect();
    assert!(!others.is_empty(), "{:?}", probe.reasons);
    for other in others {
        let feature = cache.detection().features[other.feature.expect("a feature")];
        assert!(apart(feature.slope, SKY) > 0.35 && other.sentence.contains("found at another slope: feature"));
    }
    // The truth says the same of stars that were missed, and such as were found at wrong slopes are not found.
    let truth = truth_of(&burst).expect("sound").expect("known");
    let against = against_truth(&cache, &truth, &quiet()).expect("not cancelled");
    assert!(!against.at_wrong_motion.is_empty() && !against.found.is_empty(), "{}", against.summary());
    let limit = |sigma: f64| f64::max(0.35, sigma / 9.0);
    for (pairs, is_right) in [(&against.found, true), (&against.at_wrong_motion, false)] {
        for &(feature, disc) in pairs {
            let (feature, disc) = (&cache.detection().features[feature], &truth.features[disc]);
            let own = Slope::new(disc.slope_u as f32, disc.slope_v as f32);
            assert_eq!(f64::from(apart(feature.slope, own)) <= limit(disc.sigma), is_right, "{feature:?} {disc:?}");
        }
    }
    let small = |[u, v]: [f32; 2]| {
        let is_it = |disc: usize| (truth.features[disc].u as f32 - u).hypot(truth.features[disc].v as f32 - v) < 1.5;
        against.missed.iter().any(|miss| is_it(miss.disc) && miss.why.starts_with("too small"))
            || against.at_wrong_motion.iter().any(|(_, disc)| is_it(*disc))
    };
    assert!(STARS.into_iter().all(small), "{:?}", against.missed.iter().map(|miss| &miss.why).collect::<Vec<_>>());
}

#[test]
fn small_dots_of_a_rail_are_too_small_for_the_smallest_scale() {
    let burst = dots();
    let slopes = SlopeGrid::line(-6.6..=0.6, 13);
    let cache = cache(&burst, &DetectorParams { slopes, ..DetectorParams::default() });
    assert_too_small(&cache, &burst, &DOTS.map(|([u, v], _)| [u as f32, v as f32]), DOTS_MOVE);
    // Where octave −1 was searched it is not proposed.
    let finest = DetectorParams { slopes, first_octave: -1, ..DetectorParams::default() };
    let finest = ProbeCache::new(&burst, &SearchParams::from(finest), &quiet()).expect("valid");
    for ([u, v], _) in DOTS {
        let probe = probed(&finest, [u as f32, v as f32], ProbeOptions::default());
        assert!(probe.reasons.iter().all(|reason| reason.change.is_none()), "{:?}", probe.reasons);
    }
}

#[test]
fn candidates_come_by_the_slope_in_view_then_the_motion_given_then_others() {
    let burst = blobs(8, 0.02, &[(60.0, 48.0, 3.0, 0.3, Slope::new(1.0, 0.0))]);
    let params = DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 9), octaves: 3, ..DetectorParams::default() };
    let cache = cache(&burst, &params);
    let (in_view, motion) = (Slope::new(-1.5, 0.0), PlaceMotion { slope: Slope::new(0.5, 0.0), sigma: 0.1 });
    let options = ProbeOptions { in_view: Some(in_view), motion: Some(motion), ..ProbeOptions::default() };
    let probe = probed(&cache, [60.0, 48.0], options);
    assert_eq!((probe.motion, probe.own_slope), (Some(motion), Some(motion.slope)));
    // A step of the grid, or what the burst smears over one σ.
    let class = |fate: &Fate| {
        let is_near = |slope: Slope| apart(fate.slope, slope) < 0.5 || apart(fate.slope, slope) <= fate.sigma / 7.0;
        if is_near(in_view) { 0 } else { 2 - u8::from(is_near(motion.slope)) }
    };
    let here = |fate: &&Fate| (fate.pos_image[0] - 60.0).hypot(fate.pos_image[1] - 48.0) <= 3.0;
    let classes: Vec<u8> = probe.near_fates().iter().filter(here).map(class).collect();
    assert!(classes.is_sorted() && classes.contains(&2) && classes.contains(&1), "{classes:?}");
    // Of the blob's own slope nothing is said but that it was found there.
    let other = probe.reasons.iter().find(|reason| reason.kind == CauseKind::AtAnotherSlope).expect("it was found");
    assert!(apart(other.slope, Slope::new(1.0, 0.0)) < 0.1, "{other:?}");
    let own = ProbeOptions { in_view: Some(Slope::new(1.0, 0.0)), ..ProbeOptions::default() };
    let own = probed(&cache, [60.0, 48.0], own);
    assert!(own.reasons.is_empty() && own.subject_fate().is_some_and(|fate| fate.is_kept()), "{:?}", own.reasons);
}

#[test]
fn no_setting_is_proposed_that_keeps_a_ghost() {
    // At other slopes only the frames around mid-burst respond, or those at an end of the way.
    let way = Slope::new(1.5, 0.0);
    let burst = blobs(9, 0.01, &[(64.0, 48.0, 2.5, 0.3, way)]);
    let params = DetectorParams {
        slopes: SlopeGrid::line(-3.0..=3.0, 13),
        octaves: 2,
        noise_gate: NoiseGate::Factor(60.0),
        ..DetectorParams::default()
    };
    let cache = cache(&burst, &params);
    let (mut ghosts, mut listed) = (0, 0);
    for u in (52..=76).step_by(4) {
        let place = [u as f32, 48.0];
        for fate in probed(&cache, place, ProbeOptions::default()).fates {
            let wanted = ProbeSubject::Candidate(fate.of_sample());
            let probe = probed(&cache, place, ProbeOptions { wanted, ..ProbeOptions::default() });
            let own = probe.subject_fate().expect("it is listed");
            let is_ghost = probe.reasons.iter().any(|reason| reason.kind == CauseKind::Ghost);
            if is_ghost {
                assert!(!own.is_kept() && own.remedy.is_none() && probe.outlook.is_none(), "{own:?}");
                assert!(apart(own.would_move, way) > 0.3, "{own:?}");
            } else if own.first_failed == Some(Test::NoiseGate) && own.snr > 8.0 {
                assert!(own.remedy.is_some(), "{own:?}");
            }
            (ghosts, listed) = (ghosts + usize::from(is_ghost), listed + 1);
        }
    }
    assert!(ghosts > 0 && listed > ghosts, "{ghosts} of {listed}");
}

#[test]
fn a_candidate_on_an_edge_along_its_motion_is_told_to_be_one() {
    // Wavy bright bands along the rows, in which no slope can be told from another.
    let mut stream = Stream::new(3, 0);
    let band = |u: f32, v: f32| (-(v - 48.0 - 0.4 * (0.21 * u).sin()).powi(2) / 18.0).exp();
    let frames = (0..6)
        .map(|_| Plane::from_fn(160, 96, |u, v| 0.2 + 0.2 * band(u as f32, v as f32) + 0.01 * stream.normal() as f32));
    let burst = Burst::from_planes("band", frames.collect());
    let params = DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 9), octaves: 2, ..DetectorParams::default() };
    let cache = cache(&burst, &params);
    let mut told = 0;
    for u in (20..140).step_by(6) {
        let probe = probed(&cache, [u as f32, 48.0], ProbeOptions::default());
        for fate in &probe.fates {
            let Some(edge) = fate.edge else { continue };
            assert!(matches!(fate.first_failed, Some(Test::Refinement | Test::Edge)), "{fate:?}");
            if edge.along_motion {
                assert!(edge.direction[0].abs() > 0.8, "{edge:?}");
                assert!(fate.verdict.contains("an edge along its motion"), "{}", fate.verdict);
                told += 1;
            }
        }
    }
    assert!(told > 5, "{told}");
}
