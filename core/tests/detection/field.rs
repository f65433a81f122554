//! Bursts with exact motions: one for all, an ellipse before a background, stripes, nothing.

use crate::prelude::*;
use burstscope_core::detector::{Motion, field::in_focus, field::motion_field, stack::FrameTimes};

const FRAMES: usize = 9;
const SIZE: (usize, usize) = (256, 224);

/// A number in 0 … 1 that looks random, the same for the same place and `seed`.
fn hash(u: i64, v: i64, seed: u64) -> f32 {
    let mut x = (u as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (v as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f) ^ seed;
    for _ in 0..2 {
        x = (x ^ (x >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb);
    }
    (x >> 40) as f32 / (1u64 << 24) as f32
}

fn texture(u: f32, v: f32, grain_px: f32, seed: u64) -> f32 {
    let (u, v) = (u / grain_px, v / grain_px);
    let (i, j) = (u.floor(), v.floor());
    let ease = |x: f32| x * x * (3.0 - 2.0 * x);
    let (fu, fv) = (ease(u - i), ease(v - j));
    let at = |di: i64, dj: i64| hash(i as i64 + di, j as i64 + dj, seed);
    (at(0, 0) * (1.0 - fu) + at(1, 0) * fu) * (1.0 - fv) + (at(0, 1) * (1.0 - fu) + at(1, 1) * fu) * fv
}

/// Frames of `scene`, a function of place and time from mid-burst, with noise of about `noise` in each pixel.
fn frames(noise: f32, scene: impl Fn(f32, f32, f32) -> f32) -> Vec<Plane> {
    let middle = 0.5 * (FRAMES - 1) as f32;
    let frame = |t: usize| {
        Plane::from_fn(SIZE.0, SIZE.1, |u, v| {
            let grain: f32 = (0..4).map(|k| hash(u as i64, v as i64, (t * 4 + k + 99) as u64) - 0.5).sum();
            0.3 + 0.2 * scene(u as f32, v as f32, t as f32 - middle) + 1.7 * noise * grain
        })
    };
    (0..FRAMES).map(frame).collect()
}

fn field_of(frames: &[Plane], grid: &SlopeGrid) -> MotionField {
    let frames: Vec<&Plane> = frames.iter().collect();
    motion_field(&frames, &FrameTimes::all(Positions::even(frames.len())), grid, &Monitor::default())
        .expect("not cancelled")
        .expect("large enough")
}

/// Share of the places, at least 24 pixels inside, that are within 0.35 px/frame of `truth`.
fn right(field: &MotionField, truth: impl Fn(usize, usize) -> Option<Slope>) -> f64 {
    let places = (24..SIZE.1 - 24).step_by(8).flat_map(|v| (24..SIZE.0 - 24).step_by(8).map(move |u| (u, v)));
    let is_right = |(u, v)| {
        let (found, truth) = (field.at(u as f32, v as f32).slope, truth(u, v)?);
        Some((found.u - truth.u).hypot(found.v - truth.v) < 0.35)
    };
    let known: Vec<bool> = places.filter_map(is_right).collect();
    known.iter().filter(|right| **right).count() as f64 / known.len() as f64
}

fn moving(slope: Slope, seed: u64) -> impl Fn(f32, f32, f32) -> f32 {
    move |u, v, t| texture(u - t * slope.u, v - t * slope.v, 12.0, seed)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    #[test]
    fn one_motion_is_found_everywhere_in_the_dark(slope_u in -2.5f32..2.5, slope_v in -2.5f32..2.5, seed in 0u64..1000) {
        let slope = Slope::new(slope_u, slope_v);
        let plane = SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7);
        prop_assert!(right(&field_of(&frames(0.1, moving(slope, seed)), &plane), |_, _| Some(slope)) > 0.98);
    }
}

#[test]
fn a_line_of_slopes_in_any_direction_finds_its_motion_and_a_thing_before_a_background_its_own() {
    for (direction_deg, along) in [(0.0f32, 1.3f32), (90.0, -0.7), (30.0, 2.1)] {
        let (sin, cos) = direction_deg.to_radians().sin_cos();
        let slope = Slope::new(cos * along, sin * along);
        let grid = SlopeGrid::line_along(direction_deg, -3.0..=3.0, 7);
        let field = field_of(&frames(0.1, moving(slope, 4)), &grid);
        assert!(right(&field, |_, _| Some(slope)) > 0.99, "{direction_deg}°");
        let [uu, uv, vv] = field.at(128.0, 100.0).covariance;
        let across = sin * sin * uu - 2.0 * sin * cos * uv + cos * cos * vv;
        assert!(across < 0.01 * (uu + vv) + 0.0025, "{direction_deg}°: {across} of {uu} {vv}");
    }
    let (behind, before) = (Slope::new(-0.8, 0.0), Slope::new(1.6, 0.0));
    let inside = |u: f32, v: f32| ((u - 120.0) / 66.0).hypot((v - 110.0) / 60.0) < 1.0;
    let scene = |u: f32, v: f32, t: f32| {
        if inside(u - t * before.u, v) { moving(before, 1)(u, v, t) } else { moving(behind, 2)(u, v, t) }
    };
    let field = field_of(&frames(0.06, scene), &SlopeGrid::line(-3.0..=3.0, 7));
    let of = |wanted: bool| {
        // Between the two a cell shows both.
        right(&field, |u, v| {
            let r = ((u as f32 - 120.0) / 66.0).hypot((v as f32 - 110.0) / 60.0);
            if wanted { (r < 0.7).then_some(before) } else { (r > 1.5).then_some(behind) }
        })
    };
    assert!(of(true) > 0.85 && of(false) > 0.98, "{} of the thing, {} of the background", of(true), of(false));
}

#[test]
fn one_motion_is_one_layer_and_two_are_two_by_depth_with_what_moves_by_itself_last() {
    let of =
        |scene: &dyn Fn(f32, f32, f32) -> f32| field_of(&frames(0.06, scene), &SlopeGrid::line(-3.0..=3.0, 7)).layers;
    let (left, right) = (Slope::new(-0.8, 0.0), Slope::new(1.6, 0.0));
    let one = of(&moving(left, 2));
    assert!(one.len() == 1 && one[0].share > 0.99 && (one[0].slope.u + 0.8).abs() < 0.1, "{one:?}");
    let halves = |u: f32, v: f32, t: f32| if v < 112.0 { moving(left, 2)(u, v, t) } else { moving(right, 3)(u, v, t) };
    // A few cells beside the border show both, and move like neither.
    let (two, between): (Vec<MotionLayer>, Vec<MotionLayer>) =
        of(&halves).into_iter().partition(|layer| layer.share > 0.2);
    assert!(two.len() == 2 && between.iter().all(|layer| layer.share < 0.1), "{two:?} {between:?}");
    // The nearest first, with the sign that makes the fastest layer the nearest.
    for (layer, slope) in two.iter().zip([right, left]) {
        assert!((layer.slope.u - slope.u).abs() < 0.25 && (layer.share - 0.5).abs() < 0.1, "{layer:?} {slope:?}");
    }
    // Three strips at different depths, the farthest in the middle, and a thing that moves across their motion.
    let slopes = [Slope::new(1.2, 0.0), Slope::new(0.2, 0.0), Slope::new(2.2, 0.0)];
    let across = Slope::new(0.3, -1.5);
    let scene = |u: f32, v: f32, t: f32| {
        let strip = (u / 86.0).clamp(0.0, 2.0) as usize;
        let is_thing = ((u - t * across.u - 60.0) / 48.0).hypot((v - t * across.v - 120.0) / 48.0) < 1.0;
        let (slope, seed) = if is_thing { (across, 9) } else { (slopes[strip], 3 + strip as u64) };
        moving(slope, seed)(u, v, t)
    };
    let grid = SlopeGrid::plane(-2.5..=2.5, 11, -2.5..=2.5, 11);
    let layers: Vec<MotionLayer> =
        field_of(&frames(0.05, scene), &grid).layers.into_iter().filter(|layer| layer.share > 0.04).collect();
    let expected = [slopes[2], slopes[0], slopes[1], across];
    assert_eq!(layers.len(), 4, "{layers:?}");
    for (layer, slope) in layers.iter().zip(expected) {
        assert!((layer.slope.u - slope.u).hypot(layer.slope.v - slope.v) < 0.3, "{layers:?}");
    }
    for (layer, ratio) in layers.iter().zip([1.0, 0.55, 0.09]) {
        assert!((layer.inverse_depth.expect("a still thing") - ratio).abs() < 0.1, "{layers:?}");
    }
    assert_eq!(layers[3].inverse_depth, None);
}

#[test]
fn a_cropped_burst_has_the_cropped_field_and_a_transposed_one_the_transposed() {
    let whole = frames(0.05, moving(Slope::new(1.1, 0.4), 6));
    let cropped: Vec<Plane> =
        whole.iter().map(|frame| Plane::from_fn(176, 160, |u, v| frame.at(u + 48, v + 32))).collect();
    let grid = SlopeGrid::plane(-2.0..=2.0, 5, -2.0..=2.0, 5);
    let (whole, cropped) = (field_of(&whole, &grid), field_of(&cropped, &grid));
    for (u, v) in [(40.0, 40.0), (100.0, 80.0), (140.0, 120.0)] {
        let (a, b) = (whole.at(u + 48.0, v + 32.0), cropped.at(u, v));
        assert!(a.distance(b.slope, b.ellipse().0[0]) < 2.0, "{a:?} {b:?}");
    }
    let slope = Slope::new(1.2, -0.6);
    let upright = frames(0.08, moving(slope, 8));
    let turned: Vec<Plane> = upright.iter().map(|f| Plane::from_fn(SIZE.1, SIZE.0, |u, v| f.at(v, u))).collect();
    let grid = SlopeGrid::plane(-3.0..=3.0, 7, -2.0..=2.0, 5);
    let turned = field_of(&turned, &SlopeGrid { u: grid.v, v: grid.u, ..grid });
    let upright = field_of(&upright, &grid);
    for (u, v) in [(40.0, 40.0), (128.0, 112.0), (200.0, 60.0)] {
        let (a, b) = (upright.at(u, v).slope, turned.at(v, u).slope);
        assert!((a.u - b.v).abs() < 0.02 && (a.v - b.u).abs() < 0.02, "{a:?} {b:?}");
    }
}

#[test]
fn motions_lie_as_far_off_as_they_say() {
    let plane = SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7);
    let (mut within, mut all) = ([0, 0], 0);
    for seed in 0..6 {
        let slope = Slope::new(0.7 * seed as f32 - 1.9, 1.3 - 0.5 * seed as f32);
        let field = field_of(&frames(0.25, moving(slope, seed)), &plane);
        for motion in field.motions.iter().filter(|motion| field.is_known(motion)) {
            let [uu, _, vv] = motion.covariance;
            for error in [(motion.slope.u - slope.u) / uu.sqrt(), (motion.slope.v - slope.v) / vv.sqrt()] {
                all += 1;
                (1..=2).for_each(|sigmas| within[sigmas - 1] += usize::from(error.abs() < sigmas as f32));
            }
        }
    }
    let [one, two] = within.map(|count| count as f64 / f64::from(all));
    assert!(all > 2000 && (0.55..0.97).contains(&one) && two > 0.88, "{one:.2} within 1σ, {two:.2} within 2σ of {all}");
}

#[test]
fn all_in_focus_is_nearer_to_the_scene_than_any_stack() {
    let (left, right) = (Slope::new(-1.2, 0.0), Slope::new(1.6, 0.0));
    let scene = |u: f32, v: f32, t: f32| if v < 112.0 { moving(left, 2)(u, v, t) } else { moving(right, 3)(u, v, t) };
    let frames = frames(0.03, scene);
    let planes: Vec<&Plane> = frames.iter().collect();
    let (field, times) = (field_of(&frames, &SlopeGrid::line(-3.0..=3.0, 7)), FrameTimes::all(Positions::even(FRAMES)));
    let error = |picture: &Plane| {
        let places = (24..SIZE.1 - 24).flat_map(|v| (24..SIZE.0 - 24).map(move |u| (u, v)));
        let off = |(u, v): (usize, usize)| picture.at(u, v) - 0.3 - 0.2 * scene(u as f32, v as f32, 0.0);
        let (sum, squares, count) = places.map(off).fold((0.0, 0.0, 0.0), |(s, q, n), x| (s + x, q + x * x, n + 1.0));
        (squares / count - (sum / count).powi(2)).sqrt()
    };
    let by_place = error(&in_focus(&planes, &times, &field));
    for slope in [left, Slope::default(), right] {
        let still =
            MotionField { motions: vec![Motion { slope, covariance: [0.0; 3] }; field.motions.len()], ..field.clone() };
        let stack = error(&in_focus(&planes, &times, &still));
        assert!(by_place < 0.8 * stack, "{by_place} in focus, {stack} at {slope:?}");
    }
}

#[test]
fn stripes_say_nothing_along_themselves_and_noise_has_no_known_motion() {
    let slope = Slope::new(0.0, 1.0);
    let stripes = |_: f32, v: f32, t: f32| texture(0.5, v - t * slope.v, 10.0, 3);
    let field = field_of(&frames(0.03, stripes), &SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7));
    let motion = field.at(128.0, 112.0);
    let ([long, short], angle) = motion.ellipse();
    assert!((motion.slope.v - 1.0).abs() < 0.2 && angle.sin().abs() < 0.3, "{motion:?}");
    assert!(long > 3.0 * short && !field.is_known(&motion), "{long} along, {short} across");
    for grid in [SlopeGrid::line(-3.0..=3.0, 7), SlopeGrid::plane(-1.0..=1.0, 5, -1.0..=1.0, 5)] {
        let field = field_of(&frames(0.1, |_, _, _| 0.0), &grid);
        let known = field.motions.iter().filter(|motion| field.is_known(motion)).count();
        assert!(known * 20 < field.motions.len(), "{known} of {}", field.motions.len());
    }
}

#[test]
fn threads_change_nothing_and_little_input_has_no_field() {
    let frames = frames(0.1, moving(Slope::new(1.0, 0.0), 5));
    let grid = SlopeGrid::line(-2.0..=2.0, 5);
    let on = |threads| on_threads(threads, || field_of(&frames, &grid));
    assert_eq!(on(1), on(3));
    let of = |planes: &[Plane], grid: &SlopeGrid, monitor: &Monitor| {
        let times = FrameTimes::all(Positions::even(planes.len()));
        motion_field(&planes.iter().collect::<Vec<_>>(), &times, grid, monitor)
    };
    assert_eq!(of(&frames[..2], &grid, &quiet()), Ok(None), "2 frames");
    assert_eq!(of(&vec![Plane::zeros(31, 200); 5], &grid, &quiet()), Ok(None), "7 cells");
    assert_eq!(of(&frames[..5], &SlopeGrid::single(Slope::default()), &quiet()), Ok(None), "one slope");
    assert_eq!(of(&frames, &grid, &cancelled()), Err(Cancelled));
}
