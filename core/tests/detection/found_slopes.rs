//! Slopes found of pictures that move in a known way, of charts in the dark, and of noise.

use crate::prelude::*;
use burstscope_core::detector::slopes::{MotionWarningKind, UniformTimes, resolve};

pub fn find(burst: &Burst) -> SlopeFinding {
    find_slopes(burst, &DetectorParams::default(), None, &quiet()).expect("not cancelled")
}

/// The step of the search at the default levels, pixels per frame.
fn step(burst: &Burst) -> f64 {
    3.2 * 2f64.powf(0.25) / (burst.len() - 1) as f64
}

pub fn holds(grid: &SlopeGrid, slope: Slope, around: f64) -> bool {
    let (sin, cos) = f64::from(grid.direction_deg).to_radians().sin_cos();
    let (u, v) = (f64::from(slope.u), f64::from(slope.v));
    let (along, across) = (u * cos + v * sin, v * cos - u * sin);
    let within = |x: f64, axis: &SlopeAxis| {
        // A slope less than about half a step beside a line is on it.
        let around = if axis.count == 1 { 0.3 } else { around };
        x >= f64::from(axis.min) - around && x <= f64::from(axis.max) + around
    };
    within(along, &grid.u) && within(across, &grid.v)
}

/// Frames of a picture made of waves that fade with their frequency, moved by `at`, each with its own noise.
pub fn moved(size: (usize, usize), noise: f32, frames: usize, at: impl Fn(usize) -> (f64, f64)) -> Burst {
    seen_from(size, noise, frames, |t, u, v| {
        let (du, dv) = at(t);
        (u - du, v - dv)
    })
}

/// Waves that fade with their frequency: their numbers along u and v, radians per pixel, phase, and height.
pub fn waves(stream: &mut Stream, count: usize) -> Vec<[f64; 4]> {
    let mut wave = || {
        let (frequency, direction) = (stream.within(0.05, 0.9), stream.within(0.0, std::f64::consts::PI));
        let phase = stream.within(0.0, std::f64::consts::TAU);
        [frequency * direction.cos(), frequency * direction.sin(), phase, 0.05 / (1.0 + 3.0 * frequency)]
    };
    (0..count).map(|_| wave()).collect()
}

/// Frames of the same picture; frame t shows at (u, v) its place `from(t, u, v)`.
fn seen_from(size: (usize, usize), noise: f32, frames: usize, from: impl Fn(usize, f64, f64) -> (f64, f64)) -> Burst {
    let mut stream = Stream::new(5, 0);
    let waves = waves(&mut stream, 60);
    let value = |u: f64, v: f64| waves.iter().map(|w| w[3] * (w[0] * u + w[1] * v + w[2]).cos()).sum::<f64>();
    let planes = (0..frames)
        .map(|t| {
            Plane::from_fn(size.0, size.1, |u, v| {
                let (x, y) = from(t, u as f64, v as f64);
                (0.5 + value(x, y)) as f32 + noise * stream.normal() as f32
            })
        })
        .collect();
    Burst::from_planes("moved", planes)
}

#[test]
fn the_demo_needs_a_plane_that_holds_all_its_layers_and_dark_charts_show_the_range_of_their_discs() {
    let burst = demo_burst();
    let finding = find(&burst);
    assert_eq!(finding.verdict, SlopeVerdict::Found, "{finding:?}");
    assert!(finding.grid.is_plane(), "{:?}", finding.grid);
    for (u, v) in [(0.95, 0.0), (-1.05, 0.0), (-2.1, 0.0), (1.6, -1.2)] {
        assert!(holds(&finding.grid, Slope::new(u, v), -0.5 * step(&burst)), "{u} {v}: {:?}", finding.grid);
    }
    let (u, v) = (finding.grid.u, finding.grid.v);
    assert!(u.min > -3.3 && u.max < 2.9 && v.min > -2.4 && v.max < 1.2, "{:?}", finding.grid);
    assert!(finding.confidence > 0.8, "{}", finding.confidence);
    for (motion, snr) in [(Motion::OneD, 0.35), (Motion::TwoD, 0.35), (Motion::OneD, 0.6)] {
        let chart = ChartParams { motion, snr, ..ChartParams::default() };
        let (burst, truth) = synth_chart(&chart, &quiet()).expect("a chart");
        let finding = find(&burst);
        assert_eq!(finding.verdict, SlopeVerdict::Found, "{motion:?} {snr}: {finding:?}");
        assert_eq!(finding.grid.is_plane(), motion == Motion::TwoD, "{snr}: {:?}", finding.grid);
        let slopes = truth.features.iter().map(|f| Slope::new(f.slope_u as f32, f.slope_v as f32));
        let held = slopes.filter(|s| holds(&finding.grid, *s, 0.0)).count();
        assert!(held * 100 >= 96 * truth.features.len(), "{motion:?} {snr}: {held}, {:?}", finding.grid);
        let max = f64::from(finding.grid.u.max.max(-finding.grid.u.min));
        assert!(max < 3.0 + 2.6 * step(&burst), "{motion:?} {snr}: {:?}", finding.grid);
    }
}

#[test]
fn uniform_motion_is_a_short_line_a_bent_way_is_not_straight_and_a_long_one_a_film() {
    for (u, v, noise) in [(1.0, 0.0, 0.05), (-4.2, 0.1, 0.2), (0.0, -2.5, 0.1), (-1.4, 0.9, 0.1), (9.0, 0.0, 0.05)] {
        let burst = moved((320, 240), noise, 8, |t| (u * t as f64, v * t as f64));
        let finding = find(&burst);
        let (grid, half) = (finding.grid, 0.5 * step(&burst));
        assert_eq!(finding.verdict, SlopeVerdict::Found, "{u} {v}: {finding:?}");
        assert!(!grid.is_plane() && grid.u.count <= 6, "{u} {v}: {grid:?}");
        let direction = f64::from(finding.direction_deg.expect("it moves"));
        assert!((v.atan2(u).to_degrees() - direction).abs() < 5.0, "{u} {v}: {direction}");
        // The grid holds the slope with half a step to spare and ends one to two steps beyond what is seen of it.
        assert!(holds(&grid, Slope::new(u as f32, v as f32), -half), "{u} {v}: {grid:?}");
        assert!(f64::from(grid.u.max - grid.u.min) <= 5.0 * step(&burst), "{u} {v}: {grid:?}");
        assert!(finding.deviation_px.is_some_and(|d| d < 0.5), "{u} {v}: {:?}", finding.deviation_px);
    }
    let shifts = [0.0, 1.0, 3.0, 2.0, -1.0];
    let finding = find(&moved((320, 240), 0.02, 5, |t| (shifts[t], 0.0)));
    assert_eq!(finding.verdict, SlopeVerdict::NotStraight, "{finding:?}");
    assert!((finding.deviation_px.expect("seen") - 2.0).abs() < 0.4, "{:?}", finding.deviation_px);
    assert!(finding.summary().contains("out of order"), "{}", finding.summary());
    let bent = find(&moved((320, 240), 0.02, 6, |t| (0.5 * (t * t) as f64, 0.0)));
    assert!(bent.verdict == SlopeVerdict::NotStraight && bent.warnings.is_empty(), "{}", bent.summary());
    let film = find(&moved((240, 180), 0.02, 30, |t| (-4.0 * t as f64, 0.0)));
    assert_eq!(film.verdict, SlopeVerdict::Film, "{film:?}");
    assert!((film.moved_px - 116.0).abs() < 6.0, "{}", film.moved_px);
}

#[test]
fn what_a_still_camera_sees_is_slope_0_and_pure_noise_shows_nothing_and_gets_the_usual_grid() {
    let dark = |seed| {
        let params = ChartParams { snr: 0.2, max_slope: 0.0, seed, ..ChartParams::default() };
        synth_chart(&params, &quiet()).expect("a chart").0
    };
    for burst in [moved((300, 220), 0.3, 10, |_| (0.0, 0.0)), moved((100, 100), 0.0, 1, |_| (0.0, 0.0))]
        .into_iter()
        .chain((0..3).map(dark))
    {
        let finding = find(&burst);
        assert_eq!((finding.verdict, finding.grid.len()), (SlopeVerdict::Still, 1), "{}", finding.summary());
        assert_eq!(finding.grid.slope(0), Slope::default());
    }
    for seed in 0..12 {
        let mut noise = Stream::new(seed, 7);
        let frames = (0..10).map(|_| Plane::from_fn(320, 240, |_, _| 0.5 + 0.1 * noise.normal() as f32)).collect();
        let finding = find(&Burst::from_planes("noise", frames));
        assert_eq!((finding.verdict, finding.grid), (SlopeVerdict::NothingSeen, SlopeGrid::default()), "{seed}");
        assert!(!finding.evidence.is_empty() && finding.significance == 0.0, "{seed}");
    }
    for burst in
        [moved((20, 20), 0.0, 4, |t| (t as f64, 0.0)), Burst::from_planes("black", vec![Plane::zeros(90, 80); 4])]
    {
        assert_eq!(find(&burst).verdict, SlopeVerdict::NothingSeen);
    }
}

#[test]
fn a_picture_that_turns_or_grows_is_named() {
    let turned = |degrees: f64, growth: f64| {
        let burst = seen_from((480, 360), 0.02, 8, |t, u, v| {
            let part = t as f64 / 7.0;
            let (sin, cos) = (-degrees * part).to_radians().sin_cos();
            let scale = 1.0 / (1.0 + growth * part);
            let (x, y) = (u - 239.5, v - 179.5);
            (239.5 + scale * (x * cos - y * sin) - 1.5 * t as f64, 179.5 + scale * (x * sin + y * cos))
        });
        find(&burst)
    };
    for (degrees, growth, kind, number, text) in [
        (1.2, 0.0, MotionWarningKind::Turns, 1.2, "the frames turn by 1."),
        (0.0, 0.03, MotionWarningKind::Grows, 3.0, "the picture grows by "),
    ] {
        let finding = turned(degrees, growth);
        assert!(finding.warnings.len() == 1 && finding.warnings[0].kind == kind, "{}", finding.summary());
        assert!((finding.warnings[0].number / number - 1.0).abs() < 0.1, "{}", finding.summary());
        assert!(finding.summary().contains(text), "{}", finding.summary());
    }
    assert_eq!(turned(0.0, 0.0).warnings, []);
}

#[test]
fn a_crop_by_a_pixel_leaves_the_grids_points_in_place() {
    let cropped = |burst: &Burst, (du, dv): (usize, usize)| {
        let (width, height) = burst.size();
        let crop = |frame: &Plane| Plane::from_fn(width - du, height - dv, |u, v| frame.at(u + du, v + dv));
        find(&Burst::from_planes("cropped", burst.frames.iter().map(|f| crop(f)).collect())).grid
    };
    for burst in [demo_burst(), moved((320, 240), 0.1, 8, |t| (1.3 * t as f64, 0.0))] {
        let grid = cropped(&burst, (0, 0));
        for by in [(1, 0), (0, 1), (1, 1)] {
            let other = cropped(&burst, by);
            assert_eq!(grid.direction_deg, other.direction_deg, "{by:?}");
            for (axis, other) in [(grid.u, other.u), (grid.v, other.v)] {
                assert!((axis.step() - other.step()).abs() < 1e-5, "{by:?}: {axis:?} {other:?}");
                let moved = (other.min - axis.min) / axis.step().max(1e-6);
                assert!((moved - moved.round()).abs() < 1e-3 && moved.abs() < 1.5, "{by:?}: {axis:?} {other:?}");
            }
        }
    }
}

#[test]
fn periodic_texture_does_not_take_its_alias() {
    // A fine checked pattern with a weak irregularity, 2 px/frame to the right; its period is 10 px.
    let mut stream = Stream::new(8, 0);
    let weak: Vec<f32> = (0..400 * 300).map(|_| 0.02 * stream.normal() as f32).collect();
    let pattern = |u: f64, v: f64| {
        0.5 + 0.2 * ((u * 0.2 * std::f64::consts::PI).sin() * (v * 0.2 * std::f64::consts::PI).sin()) as f32
    };
    let planes = (0..8)
        .map(|t| {
            let at = |u: usize, v: usize| pattern(u as f64 - 2.0 * t as f64, v as f64) + weak[v * 400 + u + 50 - 2 * t];
            Plane::from_fn(320, 240, at)
        })
        .collect();
    let finding = find(&Burst::from_planes("checked", planes));
    assert_eq!(finding.verdict, SlopeVerdict::Found, "{finding:?}");
    assert!(holds(&finding.grid, Slope::new(2.0, 0.0), 0.0), "{:?}", finding.grid);
    assert!(!holds(&finding.grid, Slope::new(-8.0, 0.0), 0.0) && !holds(&finding.grid, Slope::new(12.0, 0.0), 0.0));
}

#[test]
fn a_direction_that_is_asked_for_is_searched_threads_change_nothing_and_parameters_are_checked() {
    let burst = moved((320, 240), 0.1, 8, |t| (1.5 * t as f64, 1.5 * t as f64));
    let params = DetectorParams::default();
    let finding = find_slopes(&burst, &params, Some(45.0), &quiet()).expect("not cancelled");
    assert_eq!((finding.verdict, finding.grid.direction_deg), (SlopeVerdict::Found, 45.0));
    assert!(holds(&finding.grid, Slope::new(1.5, 1.5), 0.0) && !finding.grid.is_plane(), "{:?}", finding.grid);
    let (burst, _) =
        synth_scene(&SceneParams { width: 320, height: 240, ..SceneParams::default() }, &quiet()).expect("a scene");
    assert_eq!(on_threads(1, || find(&burst)), on_threads(3, || find(&burst)));
    assert!(find_slopes(&burst, &DetectorParams::default(), None, &cancelled()).is_err());
    let frames = Some(FrameRange { start: 2, end: 99 });
    let past = SearchParams { frames, ..SearchParams::default() };
    assert!(resolve(&demo_burst(), &past, &quiet()).is_err_and(|error| error.subject == "frames"));
}

#[test]
fn frames_in_no_order_and_copies_are_put_in_order() {
    for order in [[4, 0, 1, 3, 2], [2, 0, 4, 1, 3]] {
        let burst = moved((320, 240), 0.02, 5, |t| (1.7 * order[t] as f64, -0.6 * order[t] as f64));
        let uniform = find(&burst).uniform.expect("out of order");
        let mut at: Vec<usize> = uniform.frames.iter().map(|t| order[*t]).collect();
        if at[0] > at[4] {
            at.reverse();
        }
        assert_eq!(at, [0, 1, 2, 3, 4], "{uniform:?}");
    }
    let burst = moved((320, 240), 0.05, 8, |t| (1.7 * t as f64, 0.4 * t as f64));
    // A copy between frames, and one in place of a frame.
    for (frames, left, times) in [
        (vec![0, 1, 2, 2, 3, 4, 5], vec![0, 1, 2, 4, 5, 6], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]),
        (vec![0, 1, 2, 2, 4, 5, 6], vec![0, 1, 2, 4, 5, 6], vec![0.0, 1.0, 2.0, 4.0, 5.0, 6.0]),
    ] {
        let copied = burst.clone().of_frames(&frames, Positions::even(frames.len()));
        let finding = find(&copied);
        assert_eq!(finding.uniform.clone(), Some(UniformTimes { frames: left, times }), "{}", finding.summary());
        assert!(finding.summary().contains("frame 3, counted from 0, is a copy"), "{}", finding.summary());
    }
}
