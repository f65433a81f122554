//! Each piece of advice on a burst that needs it, and none on one that needs none.

use super::probing::{cache, slopes_of};
use crate::prelude::*;
use burstscope_core::inspect::report::{spectrum_figure, spectrum_text};
use burstscope_core::inspect::slopes::{AdviceSubject, SlopeAdvice, Spectrum, spectrum};
use burstscope_core::synth::examples::{ALIASING_SLOPE, Example, GARLAND_PERIOD};

/// Smooth texture without a period that moves by `place(dt)`, with a little noise.
fn moving(size: (usize, usize), frames: usize, place: impl Fn(f32) -> (f32, f32)) -> Burst {
    let mut stream = Stream::new(21, 0);
    let waves: Vec<[f32; 4]> = (0..160)
        .map(|_| {
            let (angle, frequency) = (stream.within(0.0, std::f64::consts::TAU), stream.within(0.15, 0.9));
            [
                (frequency * angle.cos()) as f32,
                (frequency * angle.sin()) as f32,
                stream.within(0.0, std::f64::consts::TAU) as f32,
                stream.normal() as f32,
            ]
        })
        .collect();
    let t0 = 0.5 * (frames as f32 - 1.0);
    let frame = |t: usize| {
        let (du, dv) = place(t as f32 - t0);
        Plane::from_fn(size.0, size.1, |u, v| {
            let (x, y) = (u as f32 - du, v as f32 - dv);
            let texture: f32 = waves.iter().map(|[a, b, c, height]| height * (a * x + b * y + c).cos()).sum();
            0.4 + 0.008 * texture + 0.01 * stream_noise(u, v, t)
        })
    };
    Burst::from_planes("moving", (0..frames).map(frame).collect())
}

/// Noise that depends only on its position, so that frames can be made in any order.
fn stream_noise(u: usize, v: usize, t: usize) -> f32 {
    let mut x = (u as u64) << 40 ^ (v as u64) << 20 ^ t as u64 ^ 0x9e37_79b9_7f4a_7c15;
    let mut sum = 0.0;
    for _ in 0..4 {
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x ^= x >> 27;
        sum += (x >> 40) as f32 / (1u64 << 24) as f32 - 0.5;
    }
    1.73 * sum
}

pub fn uniform(slope: Slope, frames: usize) -> Burst {
    moving((200, 160), frames, |dt| (dt * slope.u, dt * slope.v))
}

pub fn asked(burst: &Burst, slopes: SlopeGrid) -> Spectrum {
    let params = DetectorParams { slopes, octaves: 2, ..DetectorParams::default() };
    spectrum(&cache(burst, &params), &quiet()).expect("not cancelled")
}

pub fn about(spectrum: &Spectrum, subject: AdviceSubject) -> Option<&SlopeAdvice> {
    spectrum.advice.iter().find(|advice| advice.subject == subject)
}

pub fn applied(slopes: SlopeGrid, changes: &[ParamChange]) -> DetectorParams {
    let params = DetectorParams { slopes, octaves: 2, ..DetectorParams::default() };
    changes.iter().fold(params, |params, change| change.applied(&params).expect("valid"))
}

#[test]
fn a_search_that_fits_needs_no_advice_and_a_step_that_is_too_coarse_is_refined() {
    let burst = uniform(Slope::new(1.2, 0.0), 8);
    let spectrum = asked(&burst, SlopeGrid::line(0.2..=2.2, 5));
    assert_eq!(spectrum.advice, [], "{:#?}", spectrum.advice);
    assert!(spectrum.features > 20);
    assert!((spectrum.most_features().expect("features").u - 1.2).abs() <= 0.5);
    says(spectrum_text(&spectrum, "moving"), &["the slopes fit the burst"]);
    let burst = uniform(Slope::new(1.0, 0.0), 10);
    let grid = SlopeGrid::line(-1.5..=3.0, 4);
    let advice = about(&asked(&burst, grid), AdviceSubject::Step).cloned().expect("a step of 1.5 px/frame smears");
    assert!(advice.number > 0.3 && advice.sentence.contains('%'), "{advice:?}");
    let finer = applied(grid, &advice.changes).slopes;
    assert!(finer.u.step() < 0.5 && finer.u.min < 1.0 && finer.u.max > 1.0, "{finer:?}");
    assert_eq!(asked(&burst, finer).advice, [], "the whole range would be more than is needed");
}

#[test]
fn too_narrow_a_range_is_widened_to_the_motion_and_one_that_nearly_fits_keeps_its_slopes() {
    let burst = uniform(Slope::new(4.2, 0.0), 8);
    let grid = SlopeGrid::line(-3.0..=3.0, 13);
    let spectrum = asked(&burst, grid);
    let advice = about(&spectrum, AdviceSubject::Range).unwrap_or_else(|| panic!("{:#?}", spectrum.advice));
    assert!(advice.number > 0.5, "{advice:?}");
    let wider = applied(grid, &advice.changes).slopes;
    assert!(wider.u.max > 4.2 && wider.u.min < 4.2 && wider.u.count < 9, "straight to what was found: {wider:?}");
    // Evidence beyond the range is shown.
    assert!(spectrum.bars.iter().any(|bar| !bar.is_searched && bar.evidence > 0.1 && (bar.slope.u - 4.2).abs() < 0.6));
    // After the change the advice is gone.
    let again = asked(&burst, wider);
    assert!(about(&again, AdviceSubject::Range).is_none(), "{:#?}", again.advice);
    let grid = SlopeGrid::line(2.4..=3.6, 4);
    let advice = about(&asked(&burst, grid), AdviceSubject::Range).cloned().expect("the motion is beyond the range");
    let wider = applied(grid, &advice.changes).slopes;
    assert!(wider.u.max > 4.2 && wider.u.count < 9, "{wider:?}");
    assert!(grid.slopes().all(|slope| wider.slopes().any(|other| other == slope)), "{wider:?}");
}

#[test]
fn after_advice_is_applied_nothing_more_is_said() {
    let line = |min: f32, max: f32, count| SlopeGrid::line(min..=max, count);
    let plane = |end: f32, count| SlopeGrid::plane(-end..=end, count, -end..=end, count);
    let grids = [
        line(-40.0, 40.0, 5),
        line(-0.5, 0.5, 3),
        line(1.0, 6.0, 8),
        line(-3.0, 3.0, 4),
        plane(40.0, 5),
        plane(12.0, 3),
        plane(0.5, 3),
        SlopeGrid { v: SlopeAxis::new(1.0..=1.4, 2), ..line(-30.0, 30.0, 7) },
    ];
    let mut told = 0;
    for (seed, motion) in [(1, Motion::OneD), (2, Motion::TwoD), (3, Motion::OneD), (4, Motion::TwoD)] {
        let scene =
            SceneParams { width: 320, height: 240, frames: 8, snr: 3.0, seed, motion, ..SceneParams::default() };
        let (burst, _) = synth_scene(&scene, &quiet()).expect("valid parameters");
        for grid in grids {
            let Some(advice) = asked(&burst, grid).judgement.and_then(|judgement| judgement.advice) else { continue };
            assert!(!advice.changes.is_empty(), "{motion:?} {seed}, {grid:?}: {advice:?}");
            let after = applied(grid, &advice.changes).slopes;
            // All motions are within 3.5 px/frame of 0 on each axis.
            assert!(after.max_magnitude() < 8.0, "{motion:?} {seed}, {grid:?}: {advice:?}");
            assert_eq!(asked(&burst, after).advice, [], "{motion:?} {seed}, {grid:?}, then {after:?}");
            told += 1;
        }
    }
    assert!(told > 24, "{told}");
}

#[test]
fn motion_across_the_line_asks_for_another_direction_and_a_garland_answers_again_a_period_away() {
    let burst = uniform(Slope::new(0.0, 1.8), 8);
    let grid = SlopeGrid::line(-2.0..=2.0, 9);
    let spectrum = asked(&burst, grid);
    let advice = about(&spectrum, AdviceSubject::Direction).unwrap_or_else(|| panic!("{:#?}", spectrum.advice));
    assert!(advice.sentence.contains("90°"), "{}", advice.sentence);
    let turned = applied(grid, &advice.changes).slopes;
    let holds = |slope: Slope| turned.slopes().any(|s| (s.u - slope.u).hypot(s.v - slope.v) < 0.5);
    assert!(holds(Slope::new(0.0, 1.8)), "{turned:?}");
    assert!(about(&asked(&burst, turned), AdviceSubject::Direction).is_none());
    let example = Example::Aliasing;
    let spectrum = asked(&example.burst(), slopes_of(example));
    // There are features at the alias, as the paper says.
    let near = |spectrum: &Spectrum, slope: f32| {
        spectrum.bars.iter().filter(|bar| (bar.slope.u - slope).abs() < 0.6).map(|bar| bar.features).sum::<usize>()
    };
    assert!(near(&spectrum, ALIASING_SLOPE - GARLAND_PERIOD) >= 5);
    assert!(roxmltree::Document::parse(&spectrum_figure(&spectrum, "garlands").drawing.svg()).is_ok());
}

#[test]
fn motion_that_leaves_the_picture_or_is_not_straight_asks_for_fewer_frames() {
    let burst = moving((160, 160), 14, |dt| (4.0 * dt, 0.0));
    let grid = SlopeGrid::line(3.0..=5.0, 9);
    let spectrum = asked(&burst, grid);
    let advice = about(&spectrum, AdviceSubject::Coverage)
        .or_else(|| about(&spectrum, AdviceSubject::Frames))
        .unwrap_or_else(|| panic!("{:?} {:#?}", spectrum.finding.verdict, spectrum.advice));
    let fewer = applied(grid, &advice.changes).frames.expect("a range of frames");
    assert!(fewer.end - fewer.start < 14 && fewer.start > 0, "{fewer}");
    // The motion reverses: after ten frames it is 8 px from a uniform motion.
    let burst = moving((200, 160), 11, |dt| (1.0 * dt + 0.32 * dt * dt, 0.0));
    let grid = SlopeGrid::line(-2.0..=4.0, 19);
    let spectrum = asked(&burst, grid);
    let advice = about(&spectrum, AdviceSubject::Frames)
        .unwrap_or_else(|| panic!("{:?} {:#?}", spectrum.finding.verdict, spectrum.advice));
    assert!(advice.number >= 2.0, "{advice:?}");
    let fewer = applied(grid, &advice.changes).frames.expect("a range of frames");
    assert_eq!(fewer.end - fewer.start, 11 - advice.number as usize);
}

#[test]
fn slopes_searched_for_nothing_are_told_and_coverage_is_what_all_frames_show() {
    let burst = uniform(Slope::new(1.0, 0.0), 8);
    let spectrum = asked(&burst, SlopeGrid::plane(-2.0..=2.0, 9, -2.0..=2.0, 9));
    let advice = about(&spectrum, AdviceSubject::Cost).unwrap_or_else(|| panic!("{:#?}", spectrum.advice));
    assert!(advice.number < 0.4 && advice.sentence.contains("81"), "{advice:?}");
    assert!(roxmltree::Document::parse(&spectrum_figure(&spectrum, "a & b").drawing.svg()).is_ok());
    use burstscope_core::inspect::slopes::coverage_share;
    assert_eq!(coverage_share(Slope::default(), &Positions::even(10), (100, 50)), 1.0);
    assert!((coverage_share(Slope::new(-1.0, 2.0), &Positions::even(11), (100, 50)) - 0.9 * 0.6).abs() < 1e-6);
    assert_eq!(coverage_share(Slope::new(50.0, 0.0), &Positions::even(11), (100, 50)), 0.0);
}
