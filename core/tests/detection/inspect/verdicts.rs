//! Features that are said to be real move as the picture does, on scenes whose motion is known at each place.

use super::probing::cache;
use crate::prelude::*;
use burstscope_core::inspect::place::{Verdict, judged};

const SIZE: (usize, usize) = (400, 300);
const FRAMES: usize = 9;
/// Columns of a second layer in front of the first, which moves otherwise.
const IN_FRONT: std::ops::Range<f64> = 140.0..260.0;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Things {
    /// Gaussians of this σ, px.
    Stars(f64),
    /// Gaussians of σ 1 to 10 px, light or dark.
    Blobs,
    /// Squares of 3 to 40 px, light or dark.
    Squares,
}

/// Column, row, size and height of each thing.
type Drawn = Vec<[f64; 4]>;

impl Things {
    fn drawn(self, count: usize, stream: &mut Stream) -> Drawn {
        let (sizes, heights) = match self {
            Self::Stars(sigma) => ([sigma, sigma], [30.0, 200.0]),
            Self::Blobs => ([1.0, 10.0], [-60.0, 60.0]),
            Self::Squares => ([1.5, 20.0], [-60.0, 60.0]),
        };
        let size = |stream: &mut Stream| stream.within(sizes[0].ln(), sizes[1].ln() + 1e-9).exp();
        let place = |stream: &mut Stream, end: usize| stream.within(-40.0, end as f64 + 40.0);
        let mut one =
            |_| [place(stream, SIZE.0), place(stream, SIZE.1), size(stream), stream.within(heights[0], heights[1])];
        (0..count).map(&mut one).collect()
    }

    /// Light of the things in each pixel, row by row, when they have moved by (`du`, `dv`).
    fn light(self, things: &Drawn, (du, dv): (f64, f64)) -> Vec<f64> {
        let mut light = vec![0.0; SIZE.0 * SIZE.1];
        for &[x, y, size, height] in things {
            let near = |at: f64, end: usize| {
                let first = (at - 5.0 * size).clamp(0.0, end as f64) as usize;
                first..((at + 5.0 * size).clamp(0.0, end as f64) as usize)
            };
            for (row, column) in near(y + dv, SIZE.1).flat_map(|v| near(x + du, SIZE.0).map(move |u| (v, u))) {
                let away = [column as f64 - x - du, row as f64 - y - dv];
                let share = match self {
                    Self::Squares => away.map(|px| (size + 0.5 - px.abs()).clamp(0.0, 1.0)).iter().product::<f64>(),
                    _ => (-0.5 * away.map(|px| (px / size).powi(2)).iter().sum::<f64>()).exp(),
                };
                light[row * SIZE.0 + column] += height * share;
            }
        }
        light
    }
}

/// A scene of 12 bits with noise of `sigma` steps, and the slopes of its one or two layers.
fn scene(things: Things, count: usize, layers: usize, sigma: f64, in_plane: bool, seed: u64) -> (Burst, Vec<Slope>) {
    let mut stream = Stream::new(seed, 1);
    let mut slopes: Vec<Slope> = Vec::new();
    while slopes.len() < layers {
        let (u, v) = (stream.within(-2.5, 2.5), if in_plane { stream.within(-1.5, 1.5) } else { 0.0 });
        let slope = Slope::new(u as f32, v as f32);
        if slopes.iter().all(|other| (slope.u - other.u).hypot(slope.v - other.v) > 0.8) {
            slopes.push(slope);
        }
    }
    let drawn: Vec<Drawn> = slopes.iter().map(|_| things.drawn(count, &mut stream)).collect();
    let frame = |t: usize| {
        let (from_middle, mut noise) = (t as f64 - 0.5 * (FRAMES as f64 - 1.0), Stream::new(seed + 100, t as u64));
        let moved = |slope: &Slope| (from_middle * f64::from(slope.u), from_middle * f64::from(slope.v));
        let lights: Vec<Vec<f64>> =
            drawn.iter().zip(&slopes).map(|(drawn, slope)| things.light(drawn, moved(slope))).collect();
        Plane::from_fn(SIZE.0, SIZE.1, |u, v| {
            let is_there = |layer: &usize| *layer == 0 || IN_FRONT.contains(&(u as f64 - moved(&slopes[*layer]).0));
            let layer = (0..layers).rev().find(is_there).expect("the first is everywhere");
            let steps = 220.0 + 10.0 * layer as f64 + lights[layer][v * SIZE.0 + u] + sigma * noise.normal();
            (steps.round().clamp(0.0, 4095.0) / 4095.0) as f32
        })
    };
    let mut burst = Burst::from_planes("things", (0..FRAMES).map(frame).collect());
    burst.quantisation_step = 1.0 / 4095.0;
    (burst, slopes)
}

/// Numbers of features by how far their slope shifts the picture over half of the burst: less than 0.3 σ, more than
/// 0.75 σ, and between.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    right: usize,
    wrong: usize,
    between: usize,
}

impl Counts {
    fn add(&mut self, shift_sigmas: f32) {
        *match shift_sigmas {
            ..0.3 => &mut self.right,
            0.75.. => &mut self.wrong,
            _ => &mut self.between,
        } += 1;
    }

    /// Share of those that are not wrong.
    fn precision(self) -> f64 {
        1.0 - self.wrong as f64 / (self.right + self.wrong + self.between).max(1) as f64
    }
}

#[test]
fn what_is_said_to_be_real_moves_as_the_picture_around_it() {
    println!(
        "things, layers, noise (steps), plane: precision before the picture around is asked, after; right ones kept"
    );
    let ([mut all_before, mut all_after], mut named) = ([Counts::default(); 2], Counts::default());
    for (things, count, layers, sigma, in_plane, first_octave, least) in [
        (Things::Stars(1.4), 60, 1, 2.0, false, 0, 0.97),
        (Things::Stars(1.4), 60, 1, 2.0, false, -1, 0.97),
        (Things::Blobs, 300, 1, 5.0, false, 0, 0.95),
        (Things::Blobs, 300, 1, 25.0, false, 0, 0.92),
        (Things::Blobs, 300, 2, 10.0, false, 0, 0.9),
        (Things::Squares, 300, 1, 5.0, false, 0, 0.97),
        (Things::Squares, 300, 1, 25.0, false, 0, 0.95),
        (Things::Squares, 300, 2, 15.0, false, 0, 0.9),
        (Things::Squares, 300, 1, 15.0, true, 0, 0.92),
    ] {
        let [mut before, mut after] = [Counts::default(); 2];
        for seed in [41, 42] {
            let (burst, slopes) = scene(things, count, layers, sigma, in_plane, seed);
            let line = SlopeGrid::line(-3.0..=3.0, 13);
            let slopes_searched = if in_plane { SlopeGrid::plane(-3.0..=3.0, 13, -2.0..=2.0, 9) } else { line };
            let params = DetectorParams { slopes: slopes_searched, first_octave, ..DetectorParams::default() };
            let cache = cache(&burst, &params);
            let verdicts = judged(&cache.trail, &quiet()).expect("not cancelled");
            for (feature, judged) in cache.detection().features.iter().zip(&verdicts) {
                let is_in_front = layers > 1 && IN_FRONT.contains(&f64::from(feature.u));
                let shift = |slope: Slope| {
                    let true_one = slopes[usize::from(is_in_front)];
                    0.5 * (FRAMES as f32 - 1.0) * (slope.u - true_one.u).hypot(slope.v - true_one.v) / feature.sigma
                };
                let is_of_picture = judged.why.contains("the picture around it") && judged.verdict != Verdict::Real;
                if judged.verdict == Verdict::Real || is_of_picture {
                    before.add(shift(feature.slope));
                }
                if judged.verdict == Verdict::Real {
                    after.add(shift(feature.slope));
                }
                if let Some((_, slope)) = judged.why.split_once(", and moves by slope ").filter(|_| !in_plane) {
                    let slope = slope.split_once(' ').expect("and its coherence").0.replace('−', "-");
                    named.add(shift(Slope::new(slope.parse().expect("a number"), 0.0)));
                }
            }
        }
        let kept = after.right as f64 / before.right as f64;
        println!(
            "{things:?} {layers} {sigma} {in_plane} from octave {first_octave}: {:.3} {:.3} {kept:.3}",
            before.precision(),
            after.precision()
        );
        assert!(after.precision() >= least && kept >= 0.85, "{things:?} {layers} {sigma}: {before:?} {after:?}");
        assert!(after.right > 50 && before.wrong > 50, "{before:?} {after:?}");
        for (all, one) in [(&mut all_before, before), (&mut all_after, after)] {
            *all = Counts {
                right: all.right + one.right,
                wrong: all.wrong + one.wrong,
                between: all.between + one.between,
            };
        }
    }
    let kept = all_after.right as f64 / all_before.right as f64;
    println!(
        "all: {:.3} {:.3} {kept:.3}; slopes named instead: {:.3} right",
        all_before.precision(),
        all_after.precision(),
        named.precision()
    );
    assert!(all_after.precision() > 0.95 && kept > 0.93, "{all_before:?} {all_after:?}");
    assert!(named.precision() > 0.93 && named.right + named.between > 300, "{named:?}");
}

#[test]
fn brightness_that_changes_is_no_other_motion_and_without_noise_the_right_slope_is_real() {
    let slope = Slope::new(1.0, 0.0);
    let dots: Vec<(f32, f32, f32, f32, Slope)> =
        (0..12).map(|i| (16.0 + 32.0 * (i % 4) as f32, 20.0 + 28.0 * (i / 4) as f32, 2.5, 0.2, slope)).collect();
    for noise in [0.0, 0.004] {
        let burst = super::probing::blobs(9, noise, &dots);
        let faded = |t: usize| {
            let (frame, factor) = (&burst.frames[t], 0.5 + t as f32 / 8.0);
            Plane::from_fn(128, 96, |u, v| 0.3 + factor * (frame.at(u, v) - 0.3))
        };
        // Without noise frames that fade are told from others by nothing.
        let fading = (noise > 0.0).then(|| Burst::from_planes("fading", (0..9).map(faded).collect()));
        for burst in std::iter::once(&burst).chain(&fading) {
            let params = DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, 13), ..DetectorParams::default() };
            let cache = cache(burst, &params);
            let verdicts = judged(&cache.trail, &quiet()).expect("not cancelled");
            let is_dot = |f: &Feature| {
                dots.iter().any(|dot| (f.u - dot.0).hypot(f.v - dot.1) < 1.0)
                    && (f.slope.u - 1.0).abs() < 0.1
                    && f.sigma < 4.0
            };
            let of_dots = cache.detection().features.iter().zip(&verdicts).filter(|(feature, _)| is_dot(feature));
            let real: Vec<bool> = of_dots.map(|(_, judged)| judged.verdict == Verdict::Real).collect();
            assert!(real.len() >= 12 && real.iter().all(|real| *real), "{noise}: {real:?}");
        }
    }
}
