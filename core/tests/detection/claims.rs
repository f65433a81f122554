//! Claims about bursts from their frames alone: none that is false of noise, of still, flickering and orderly bursts
//! and of several motions, while real events are reported.
//!
//! More bursts: `CLAIMS=20 cargo test -p burstscope-core --test detection claims -- --nocapture` takes 20 times as
//! many.

use super::found_slopes::{find, waves};
use crate::prelude::*;
use burstscope_core::detect::Searched;
use burstscope_core::detector::slopes::MotionWarningKind;
use burstscope_core::inspect::place::CauseKind;
use burstscope_core::inspect::slopes::{AdviceSubject, SlopeJudgement, judgement};
use std::ops::Range;

/// Seeds, more of them on request.
fn seeds(count: u64) -> Range<u64> {
    let times = std::env::var("CLAIMS").map_or(1, |times| times.parse::<u64>().expect("a number"));
    0..count * times
}

/// Times of frames after an event, in half frame intervals: each frame shows where things are then.
fn times(happened: &str, frames: usize, stream: &mut Stream) -> Vec<i32> {
    let mut times: Vec<i32> = (0..frames as i32).map(|t| 2 * t).collect();
    match happened {
        "exchanged" => {
            let a = stream.below(frames);
            times.swap(a, (a + 1 + stream.below(frames - 1)) % frames);
        }
        "dropped" => {
            let after = 1 + stream.below(frames - 1);
            times[after..].iter_mut().for_each(|time| *time += 2);
        }
        "late" => times[1 + stream.below(frames - 2)] += 1,
        _ => {}
    }
    times
}

/// Places of frames of a camera held by hand, whose motion is not along the one of the burst: drawn for each frame, or
/// a walk.
fn by_hand(happened: &str, frames: usize, stream: &mut Stream) -> Vec<(f64, f64)> {
    let sigma = if happened.starts_with("by hand") { stream.within(0.2, 1.5) } else { 0.0 };
    let mut at = (0.0, 0.0);
    let mut next = |_| {
        let by = (sigma * stream.normal(), sigma * stream.normal());
        at = if happened == "by hand" { by } else { (at.0 + by.0, at.1 + by.1) };
        at
    };
    (0..frames).map(&mut next).collect()
}

/// A small burst of waves that fade with their frequency. It stands still, flickers by up to a half, moves as a whole,
/// or in four parts each with a motion of its own; or it moves, and something happened to its frames.
fn small(happened: &str, seed: u64) -> (Burst, Vec<i32>) {
    let mut stream = Stream::new(seed, 41);
    let (width, height) = [(128, 96), (96, 128), (200, 150)][stream.below(3)];
    let frames = 5 + stream.below(7);
    let noise = [0.003, 0.01, 0.03, 0.1, 0.2, 0.4];
    let is_event = ["exchanged", "dropped", "late"].contains(&happened);
    let noise = if is_event { noise[stream.below(4)] } else { noise[stream.below(6)] };
    let waves = waves(&mut stream, 40);
    let mut slope = || {
        let (speed, direction) = (stream.within(0.8, 2.5), stream.within(0.0, std::f64::consts::TAU));
        (speed * direction.cos(), speed * direction.sin())
    };
    let slopes = [slope(), slope(), slope(), slope()];
    let gains: Vec<f64> =
        (0..frames).map(|_| if happened == "flickering" { stream.within(0.5, 1.5) } else { 1.0 }).collect();
    let times = times(happened, frames, &mut stream);
    let hand = by_hand(happened, frames, &mut stream);
    let slope_at = |u: usize, v: usize| match happened {
        "still" | "flickering" => (0.0, 0.0),
        "several" => slopes[usize::from(2 * u > width) + 2 * usize::from(2 * v > height)],
        _ => slopes[0],
    };
    let planes = times.iter().zip(&gains).zip(&hand).map(|((time, gain), hand)| {
        Plane::from_fn(width, height, |u, v| {
            let (slope, time) = (slope_at(u, v), 0.5 * f64::from(*time));
            let (x, y) = (u as f64 - slope.0 * time - hand.0, v as f64 - slope.1 * time - hand.1);
            let value: f64 = waves.iter().map(|w| w[3] * (w[0] * x + w[1] * y + w[2]).cos()).sum();
            (gain * (0.5 + value) + noise * stream.normal()) as f32
        })
    });
    (Burst::from_planes(happened, planes.collect()), times)
}

fn noise(frames: usize, (width, height): (usize, usize), is_masked: bool, seed: u64) -> Burst {
    let mut stream = Stream::new(seed, 1_000 + width as u64);
    let mut frame = || {
        let plane = Plane::from_fn(width, height, |_, v| {
            let value = (0.5 + 0.1 * stream.normal()) as f32;
            if is_masked && (v % 7 == 3 || (20..26).contains(&v)) { f32::NAN } else { value }
        });
        if is_masked { plane.with_nan_masked() } else { plane }
    };
    Burst::from_planes("noise", (0..frames).map(|_| frame()).collect())
}

fn is_of_time(kind: MotionWarningKind) -> bool {
    !matches!(kind, MotionWarningKind::Turns | MotionWarningKind::Grows)
}

#[test]
fn nothing_is_said_of_noise_alone_and_nothing_false_of_the_times_of_good_bursts() {
    // As many of each with `NOISE=1000`.
    let all = std::env::var("NOISE").ok().map(|count| count.parse::<u64>().expect("a number"));
    for (count, frames, size) in [(60, 5, (64, 64)), (16, 10, (128, 128)), (4, 8, (240, 240)), (3, 10, (240, 240))] {
        let mut seen = 0;
        for (seed, is_masked) in (0..all.unwrap_or(count)).flat_map(|seed| [(seed, false), (seed, true)]) {
            let finding = find(&noise(frames, size, is_masked, seed));
            seen += usize::from(finding.verdict != SlopeVerdict::NothingSeen);
            assert!(finding.warnings.is_empty() && finding.uniform.is_none(), "{seed}: {}", finding.irregularities());
        }
        println!("{frames} {size:?}: motion is seen in {seen}");
        assert!(seen as u64 <= all.unwrap_or(count) / 200, "{frames} {size:?}: {seen}");
    }
    for kind in ["still", "flickering", "orderly", "several"] {
        for seed in seeds(25) {
            let finding = find(&small(kind, seed).0);
            let said = finding.warnings.iter().any(|warning| is_of_time(warning.kind));
            assert!(!said && finding.uniform.is_none(), "{kind} {seed}: {}", finding.irregularities());
            assert_ne!(finding.verdict, SlopeVerdict::NotStraight, "{kind} {seed}: {:?}", finding.deviation_px);
        }
    }
    for kind in ["by hand", "by hand, a walk"] {
        let told = seeds(25).filter(|seed| find(&small(kind, *seed).0).uniform.is_some());
        assert_eq!(told.count(), 0, "{kind}");
    }
}

#[test]
fn what_did_happen_to_frames_is_told() {
    let mut failed = false;
    for kind in ["exchanged", "dropped", "late"] {
        let (mut right, mut wrong, all) = (0, 0, seeds(25));
        for seed in all.clone() {
            let (burst, times) = small(kind, seed);
            let Some(uniform) = find(&burst).uniform else { continue };
            let first = f64::from(times[uniform.frames[0]]);
            let since = |frame: usize| 0.5 * (f64::from(times[frame]) - first);
            let mut times = uniform.frames.iter().zip(&uniform.times);
            let is_right = times.all(|(frame, time)| (since(*frame) - time).abs() < 0.3);
            *(if is_right { &mut right } else { &mut wrong }) += 1;
        }
        println!("{kind}: {right} right and {wrong} wrong of {all:?}");
        failed |= 100 * right < if kind == "late" { 92 } else { 95 } * all.end || 50 * wrong > all.end;
    }
    assert!(!failed);
}

fn dark(snr: f64, seed: u64) -> Burst {
    let chart = ChartParams { snr, motion: Motion::TwoD, seed, ..ChartParams::default() };
    synth_chart(&chart, &quiet()).expect("a chart").0
}

fn judged(burst: &Burst, params: &SearchParams) -> (SlopeJudgement, SlopeFinding, DetectorParams) {
    let monitor = Monitor::default();
    let Searched { detection, params, finding, .. } = search(burst, params, &monitor).expect("valid");
    let finding = finding.map_or_else(|| find_slopes(burst, &params, None, &monitor), Ok).expect("not cancelled");
    let judgement = judgement(&detection, &params, Some(&finding), burst, &monitor).expect("not cancelled");
    (judgement.expect("it has slopes"), finding, params)
}

/// Parameters that find the same slopes sooner.
fn coarse() -> DetectorParams {
    DetectorParams { octaves: 2, max_orientations: 1, ..DetectorParams::default() }
}

#[test]
fn a_change_that_is_offered_leaves_no_fault() {
    let lines = [(-1.0, 0.0, 3, 0.0), (-9.0, 9.0, 7, 0.0), (-1.5, 3.0, 40, 0.0), (-2.0, 2.0, 9, 90.0)];
    let line =
        |(min, max, count, direction): (f32, f32, usize, f32)| SlopeGrid::line_along(direction, min..=max, count);
    let plane = SlopeGrid::plane(-9.0..=9.0, 4, 1.0..=1.4, 2);
    let grids: Vec<SlopeGrid> = lines.map(line).into_iter().chain([plane]).collect();
    let (mut offered, mut failed) = (0, Vec::new());
    for seed in seeds(3) {
        for (motion, snr) in [(Motion::OneD, 2.0), (Motion::TwoD, 2.0), (Motion::OneD, 0.4), (Motion::TwoD, 0.25)] {
            let chart =
                ChartParams { width: 240, height: 180, discs: 10, frames: 8, max_slope: 2.0, ..Default::default() };
            let (burst, _) = synth_chart(&ChartParams { motion, snr, seed, ..chart }, &quiet()).expect("a chart");
            for slopes in &grids {
                let params = DetectorParams { slopes: *slopes, ..coarse() };
                let (before, _, params) = judged(&burst, &params.into());
                let Some(advice) = before.advice.filter(|advice| !advice.changes.is_empty()) else { continue };
                let params = ParamChange::all_applied(&advice.changes, &params).expect("valid");
                let (after, ..) = judged(&burst, &params.into());
                offered += 1;
                if after.advice.is_some() {
                    let (said, options, then) = (&advice.sentence, advice.options(), &after.sentence);
                    failed.push(format!("{motion:?} {snr} {seed} {slopes:?}: {said} {options}; then {then}"));
                }
            }
        }
    }
    println!("{offered} offered, {} failed\n{}", failed.len(), failed.join("\n"));
    assert!(offered >= 20 && failed.is_empty(), "{offered} {failed:#?}");
}

#[test]
fn several_motions_are_not_a_crooked_one_and_slopes_fit_only_if_most_that_moves_has_them() {
    for (snr, seed) in seeds(8).map(|seed| ([0.2, 0.25, 0.15][seed as usize % 3], seed + 1)) {
        let finding = find(&dark(snr, seed));
        assert_ne!(finding.verdict, SlopeVerdict::NotStraight, "{snr} {seed}: {}", finding.summary());
        assert!(finding.uniform.is_none(), "{snr} {seed}: {}", finding.summary());
    }
    let mut doubted = 0;
    for (snr, seed) in [(0.15, 3), (0.2, 2), (0.1, 1), (0.08, 1)] {
        let (judged, finding, _) = judged(&dark(snr, seed), &coarse().with_slopes(Slopes::AUTO));
        assert!(!judged.fits || finding.confidence >= 0.8, "{snr} {seed}: {} {}", judged.sentence, finding.confidence);
        doubted += usize::from(!judged.fits && judged.advice.is_none());
    }
    assert!(doubted >= 2, "{doubted}");
}

#[needs::shared("data/buff-demo-1d")]
#[test]
fn the_order_of_frames_is_judged_whatever_slopes_are_searched() {
    let frames: Vec<_> = (1..6).map(|k| shared("data/buff-demo-1d").join(format!("{k}.png"))).collect();
    let burst = Burst::open_with(&frames, &OpenOptions::default(), &quiet()).expect("a burst");
    for axis in [SlopeAxis { min: 0.0, max: 1.0, count: 2 }, SlopeAxis { min: -20.0, max: 20.0, count: 5 }] {
        let slopes = SlopeGrid { u: axis, ..SlopeGrid::default() };
        let (judged, ..) = judged(&burst, &DetectorParams { slopes, ..coarse() }.into());
        let advice = judged.advice.expect("the frames are out of order");
        assert!(advice.subject == AdviceSubject::Frames && advice.times == Some(TimesChoice::Found), "{advice:?}");
        assert!(judged.sentence.contains("in the order 2, 3, 1, 0, 4"), "{}", judged.sentence);
    }
}

#[needs::shared("data/buff-demo-2d")]
#[test]
fn several_things_that_move_are_no_picture_that_grows() {
    let data = shared("data/buff-demo-2d");
    let files = names(&data).into_iter().filter(|name| name.ends_with(".png")).map(|name| data.join(name));
    let burst = Burst::open_with(&files.collect::<Vec<_>>(), &OpenOptions::default(), &quiet()).expect("a burst");
    assert_eq!(find(&burst).warnings, []);
    for seed in seeds(12) {
        let discs = 4 + seed as usize % 8;
        let chart = ChartParams { width: 320, height: 240, discs, frames: 8, snr: 5.0, ..ChartParams::default() };
        let chart = ChartParams { motion: Motion::TwoD, seed, ..chart };
        let (burst, _) = synth_chart(&chart, &quiet()).expect("a chart");
        assert_eq!(find(&burst).warnings, [], "{seed}");
    }
}

#[test]
fn a_finer_octave_is_offered_where_it_keeps_what_rises_beyond_the_smallest_scale() {
    let burst = demo_burst();
    let found = |params: SearchParams| ProbeCache::new(&burst, &params, &quiet()).expect("valid");
    let cache = found(SearchParams::default());
    // A lamp whose response still rises at the smallest scale of that octave, at its own slope.
    let place = [257.4, 150.5];
    let probe = probe(&cache, place, &ProbeOptions::default(), &quiet()).expect("inside");
    let small = probe.reasons.iter().find(|reason| reason.kind == CauseKind::TooSmall).expect("too small");
    let change = small.change.as_ref().expect("a first octave of -1");
    let finer = found(change.applied(&cache.made_with()).expect("valid").into());
    let is_it = |feature: &&Feature| (feature.u - place[0]).hypot(feature.v - place[1]) < 3.0 && feature.sigma < 1.9;
    let kept = finer.detection().features.iter().find(is_it);
    let (sigma, snr) = small.sigma_and_snr.expect("measured");
    assert!(kept.is_some_and(|f| (f.sigma / sigma - 1.0).abs() < 0.3 && f.snr > 0.5 * snr), "{small:?} {kept:?}");
}
