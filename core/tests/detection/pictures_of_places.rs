//! The pictures of places, laid over one another, with known truth.

use crate::prelude::*;
use burstscope_core::detector::stack::FrameTimes;
use burstscope_core::matching::align::{Chip, ChipSource, Measured, PairFrame, View, measure, pair::FIT_RADIUS};
use burstscope_core::plane::sample::bilinear;

const SIZE: (usize, usize) = (360, 300);
const FRAMES: usize = 6;
const SIGMA: f32 = 4.0;
/// Noise of a pixel of a frame with which a chip's contrast is 5 times its noise: the texture has a standard deviation
/// of 1, and a sample of a chip averages 4π·(0.55·4)² pixels of 6 frames.
const NOISE: f64 = 3.8;

#[derive(Clone, Copy)]
struct Warp {
    matrix: [[f32; 2]; 2],
    shift: [f32; 2],
}

impl Warp {
    const NONE: Self = Self { matrix: [[1.0, 0.0], [0.0, 1.0]], shift: [0.0, 0.0] };

    fn similarity(angle: f32, scale: f32, shift: [f32; 2]) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { matrix: [[scale * cos, -scale * sin], [scale * sin, scale * cos]], shift }
    }

    fn apply(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|i| self.matrix[i][0] * x + self.matrix[i][1] * y + self.shift[i])
    }

    fn undone(&self, at: [f32; 2]) -> [f32; 2] {
        let ([[a, b], [c, d]], [x, y]) = (self.matrix, [at[0] - self.shift[0], at[1] - self.shift[1]]);
        [d * x - b * y, a * y - c * x].map(|x| x / (a * d - b * c))
    }
}

/// Waves of random directions and phases and of lengths of 3 to 16 σ, of standard deviation 1 in all.
fn texture(at: [f32; 2]) -> f32 {
    let mut random = Stream::new(7, 0);
    let wave = |_| {
        let (angle, phase) = (random.within(0.0, 6.3) as f32, random.within(0.0, 6.3) as f32);
        let length = SIGMA * random.within(3.0, 16.0) as f32;
        ((at[0] * angle.cos() + at[1] * angle.sin()) * std::f32::consts::TAU / length + phase).sin()
    };
    (0..40).map(wave).sum::<f32>() / 20f32.sqrt()
}

/// Frames of the texture seen through `warp`, moving by `slope`, with noise.
fn frames(warp: Warp, slope: Slope, noise: f64, seed: u64) -> Vec<Plane> {
    // The texture is costly: it is computed once and read between its pixels.
    let margin = 20;
    let still = Plane::from_fn(SIZE.0 + 2 * margin, SIZE.1 + 2 * margin, |u, v| {
        texture(warp.undone([u as f32 - margin as f32, v as f32 - margin as f32]))
    });
    let frame = |t: usize| {
        let time = t as f32 - 0.5 * (FRAMES as f32 - 1.0);
        let mut random = Stream::new(seed, t as u64);
        Plane::from_fn(SIZE.0, SIZE.1, |u, v| {
            let at = [u as f32 + margin as f32 - time * slope.u, v as f32 + margin as f32 - time * slope.v];
            let value = bilinear(&still, at[0], at[1]).expect("within the margin");
            value + (noise * random.normal()) as f32
        })
    };
    (0..FRAMES).map(frame).collect()
}

/// Two images of one texture, and chips of places that belong together but for known errors.
struct Scene {
    chips: [Vec<Chip>; 2],
    /// What is to be measured: the shift from B's place to where A's lies in B, pixels.
    shifts: Vec<[f32; 2]>,
    warp: Warp,
}

const TURN: f32 = 0.5;
const RATIO: f32 = 1.25;

impl Scene {
    /// Image B is A under `warp`; the places of B are off by the shifts that `off` gives, σ of B.
    fn new(warp: Warp, noise: f64, off: impl Fn(&mut Stream) -> [f32; 2]) -> Self {
        let slopes = [Slope::new(1.3, -0.4), Slope::new(-0.7, 0.0)];
        let warps = [Warp::NONE, warp];
        let bursts = [0, 1].map(|side| frames(warps[side], slopes[side], noise, 10 + side as u64));
        let times = FrameTimes::all(Positions::even(FRAMES));
        let planes = bursts.each_ref().map(|frames| frames.iter().collect::<Vec<_>>());
        let sources = planes.each_ref().map(|planes| ChipSource::new(planes, &times, 8.0));
        let mut scene = Self { chips: [Vec::new(), Vec::new()], shifts: Vec::new(), warp };
        let mut random = Stream::new(3, 1);
        let centre = [SIZE.0 as f32 / 2.0, SIZE.1 as f32 / 2.0];
        for k in 0..30 {
            let [x, y] = [(k % 6) as f32 - 2.5, (k / 6) as f32 - 2.0].map(|step| 28.3 * step);
            let place = [centre[0] + x, centre[1] + y];
            let (there, off) = (warp.apply(place), off(&mut random).map(|x| x * SIGMA * RATIO));
            let detected = (there[0] - off[0], there[1] - off[1]);
            let mut scale = |sigma: f32| sigma * (0.15 * random.normal() as f32).exp();
            let sigmas = [scale(SIGMA), scale(SIGMA * RATIO)];
            let chips = [
                sources[0].chip((place[0], place[1]), sigmas[0], slopes[0]),
                sources[1].chip(detected, sigmas[1], slopes[1]),
            ];
            let [Some(a), Some(b)] = chips else { continue };
            scene.chips[0].push(a);
            scene.chips[1].push(b);
            scene.shifts.push(off);
        }
        assert!(scene.shifts.len() > 20, "most places are in both images");
        scene
    }

    /// Matches of the sides `from` and `to`, with orientations that are off by 0.2 radians.
    fn views(&self, from: usize, to: usize) -> Vec<[View<'_>; 2]> {
        let mut random = Stream::new(4, 2);
        let mut view = |side: usize, k: usize| {
            let orientation = side as f32 * TURN + 1.0 + 0.2 * random.normal() as f32;
            View { chip: &self.chips[side][k], orientation }
        };
        (0..self.shifts.len()).map(|k| [view(from, k), view(to, k)]).collect()
    }

    fn measured(&self) -> Vec<Option<Measured>> {
        let views = self.views(0, 1);
        measure(&views, PairFrame::of(&views), FIT_RADIUS, &quiet()).expect("not cancelled")
    }

    /// Errors of the measured shifts, σ of B.
    fn errors(&self, measured: &[Option<Measured>]) -> Vec<f32> {
        let error = |(measured, truth): (&Measured, &[f32; 2])| {
            let [u, v] = [0, 1].map(|i| measured.shift_px[i] as f32 - truth[i]);
            u.hypot(v) / (SIGMA * RATIO)
        };
        measured.iter().zip(&self.shifts).filter_map(|(m, truth)| Some(error((m.as_ref()?, truth)))).collect()
    }
}

/// Blobs' places are off by half their σ.
fn as_detected(random: &mut Stream) -> [f32; 2] {
    [0, 1].map(|_| (0.5 * random.normal() as f32).clamp(-1.5, 1.5))
}

fn similar() -> Warp {
    let centre = [SIZE.0 as f32 / 2.0, SIZE.1 as f32 / 2.0];
    let turned = Warp::similarity(TURN, RATIO, [0.0; 2]).apply(centre);
    Warp::similarity(TURN, RATIO, [centre[0] - turned[0] + 3.0, centre[1] - turned[1] - 2.0])
}

#[test]
fn a_shift_a_similarity_and_an_affine_change_are_found() {
    let scene = Scene::new(similar(), NOISE, as_detected);
    let frame = PairFrame::of(&scene.views(0, 1));
    assert!((frame.rotation - TURN).abs() < 0.15 && (frame.log_ratio - RATIO.ln()).abs() < 0.1, "{frame:?}");
    let measured = scene.measured();
    assert!(measured.iter().all(Option::is_some), "{measured:?}");
    let mut errors = scene.errors(&measured);
    errors.sort_by(f32::total_cmp);
    assert!(errors[errors.len() / 2] < 0.1 && errors[errors.len() - 1] < 0.25, "{errors:?}");
    assert!(measured.iter().flatten().all(|m| m.correlation > 0.8), "{measured:?}");
    let [[a, b], [c, d]] = similar().matrix;
    // Sheared, and wider than high.
    let matrix = [[1.12 * a, 1.12 * b], [c + 0.1 * a, d + 0.1 * b]];
    let centre = [SIZE.0 as f32 / 2.0, SIZE.1 as f32 / 2.0];
    let turned = Warp { matrix, shift: [0.0; 2] }.apply(centre);
    let warp = Warp { matrix, shift: [centre[0] - turned[0], centre[1] - turned[1]] };
    let scene = Scene::new(warp, 0.3 * NOISE, as_detected);
    let measured = scene.measured();
    assert!(measured.iter().all(Option::is_some), "{measured:?}");
    let errors = scene.errors(&measured);
    assert!(errors.iter().all(|error| *error < 0.1), "{errors:?}");
    for found in measured.iter().flatten() {
        for (row, truth) in found.jacobian.iter().zip(&scene.warp.matrix) {
            row.iter().zip(truth).for_each(|(x, truth)| assert!((x - f64::from(*truth)).abs() < 0.04, "{found:?}"));
        }
    }
}

#[test]
fn what_lies_beyond_the_search_is_not_measured_and_a_place_at_the_border_is_measured_by_what_is_there() {
    let scene = Scene::new(similar(), 0.3 * NOISE, |_| [3.4 * TURN.cos(), 3.4 * TURN.sin()]);
    let measured = scene.measured();
    let errors = scene.errors(&measured);
    let none = measured.iter().filter(|m| m.is_none()).count();
    assert!(10 * none >= 8 * measured.len(), "{none} of {}: {errors:?}", measured.len());
    let flat = Plane::from_fn(100, 100, |_, _| 0.25);
    let source = ChipSource::new(&[&flat, &flat], &FrameTimes::all(Positions::even(2)), 4.0);
    let chip = source.chip((50.0, 50.0), 3.0, Slope::new(0.0, 0.0)).expect("inside");
    let view = View { chip: &chip, orientation: 0.0 };
    let none = measure(&[[view, view]], PairFrame::of(&[[view, view]]), FIT_RADIUS, &quiet());
    assert_eq!(none, Ok(vec![None]), "a wall without texture");
    let frames = frames(Warp::NONE, Slope::new(0.0, 0.0), 0.0, 1);
    let planes: Vec<&Plane> = frames.iter().collect();
    let source = ChipSource::new(&planes, &FrameTimes::all(Positions::even(FRAMES)), SIGMA);
    let chip = |u: f32, v: f32| source.chip((u, v), SIGMA, Slope::new(0.0, 0.0)).expect("inside");
    let (a, b) = (chip(14.0, 150.0), chip(16.0, 151.0));
    let [a, b] = [&a, &b].map(|chip| View { chip, orientation: 0.0 });
    let found = measure(&[[a, b]], PairFrame::of(&[[a, b]]), FIT_RADIUS, &quiet()).expect("not cancelled");
    let found = found[0].expect("most of it is seen");
    assert!((found.shift_px[0] + 2.0).abs() < 0.1 && (found.shift_px[1] + 1.0).abs() < 0.1, "{found:?}");
    assert_eq!(source.chip((-1.0, 5.0), SIGMA, Slope::new(0.0, 0.0)), None, "outside the image");
    assert_eq!(source.chip((5.0, 5.0), f32::NAN, Slope::new(0.0, 0.0)), None, "no scale");
}

#[test]
fn b_to_a_is_a_to_b_reversed_and_measurements_are_the_same_on_any_number_of_threads() {
    let scene = Scene::new(similar(), NOISE, as_detected);
    let there = scene.measured();
    let views = scene.views(1, 0);
    let back = measure(&views, PairFrame::of(&views), FIT_RADIUS, &quiet()).expect("not cancelled");
    for (there, back) in there.iter().zip(&back) {
        let (there, back) = (there.expect("found"), back.expect("found"));
        let carried =
            [0, 1].map(|i| there.shift_px[i] + (0..2).map(|k| there.jacobian[i][k] * back.shift_px[k]).sum::<f64>());
        assert!(carried[0].hypot(carried[1]) < f64::from(0.1 * SIGMA * RATIO), "{there:?} {back:?}");
    }
    assert_eq!(on_threads(1, || scene.measured()), on_threads(5, || scene.measured()));
    assert_eq!(measure(&scene.views(0, 1), PairFrame::of(&[]), FIT_RADIUS, &cancelled()), Err(Cancelled));
}
