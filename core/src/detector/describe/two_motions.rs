//! Two motions at one place: whether a weaker keypoint beside a stronger one of another slope is a thing of its own.
//!
//! A blob also shows in the stack of a wrong slope, smeared along the way it moves there: a ghost, which answers only
//! in those frames in which the true blob crosses the ghost's way. A lantern before a wall answers in every frame along
//! its own way. So the frames are asked in which the ways of both keypoints are well apart: there a thing of its own
//! still answers at full strength, well above the noise, and between the two ways there is nothing. (An elongated
//! structure that slides along itself answers on both ways, but between them too.)

use crate::detector::describe::point_response::point_response;
use crate::detector::keypoint::Keypoint;
use crate::detector::params::Interpolation;
use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::levels::ScaleSpace;
use crate::detector::stack::offsets::FrameTimes;
use crate::detector::stack::refined::OctaveFrames;
use crate::plane::Plane;
use std::sync::OnceLock;

/// Frames count in which the two ways are farther apart than this many σ of the stronger keypoint: there its response
/// has passed through 0.
const APART_SIGMAS: f32 = 2.5;
/// At least this share of all frames must count, and two of them.
const FRAMES_SHARE: f32 = 0.2;
/// The part of its response that a thing of its own keeps in those frames.
const KEPT_RESPONSE: f32 = 0.6;
/// What that must be in standard deviations of its noise. A mean of few frames is noisy, and a false second thing makes
/// matches ambiguous.
const FRAMES_SNR: f32 = 5.0;
/// The part of the weaker response that may lie between the two ways.
const BETWEEN_RESPONSE: f32 = 0.5;

/// The frames at the resolutions of all octaves, each made when it is first asked for.
pub(in crate::detector) struct FramesOfOctaves<'a> {
    frames: &'a [&'a Plane],
    times: &'a FrameTimes,
    first_octave: i32,
    octaves: Vec<OnceLock<OctaveFrames<'a>>>,
    /// The octaves' means of frames, where somebody keeps them.
    means: Option<&'a [OnceLock<Vec<Plane>>]>,
}

impl<'a> FramesOfOctaves<'a> {
    pub(in crate::detector) fn new(
        frames: &'a [&'a Plane],
        times: &'a FrameTimes,
        octaves: std::ops::Range<i32>,
    ) -> Self {
        let first_octave = octaves.start;
        Self { frames, times, first_octave, octaves: octaves.map(|_| OnceLock::new()).collect(), means: None }
    }

    /// The same with means that are kept in `means`, one place an octave, and made there when they are first asked for.
    pub(in crate::detector) fn with_means(self, means: &'a [OnceLock<Vec<Plane>>]) -> Self {
        Self { means: Some(means), ..self }
    }

    /// Makes what is needed of `keypoints` now, on all threads where the means are nobody else's.
    pub(in crate::detector) fn make<'k>(&self, keypoints: impl Iterator<Item = &'k Keypoint>) {
        if let Some(last) = keypoints.map(|keypoint| keypoint.octave).max() {
            self.made(last, self.means.is_none());
        }
    }

    /// Those of `octave`, one of the octaves given.
    pub(in crate::detector) fn of(&self, octave: i32) -> &OctaveFrames<'a> {
        // Many threads may ask at once. The one that makes them must do so alone: were it to wait for others, it would
        // take up other work meanwhile, which may ask for the same frames and then wait for itself.
        self.made(octave, false)
    }

    fn made(&self, octave: i32, in_parallel: bool) -> &OctaveFrames<'a> {
        let slot = (octave - self.first_octave) as usize;
        let make = || match slot {
            0 => OctaveFrames::new(self.frames, self.times, octave, in_parallel),
            _ => self.made(octave - 1, in_parallel).coarser(in_parallel),
        };
        self.octaves[slot].get_or_init(|| match self.means {
            None => make(),
            Some(means) => {
                let means = means[slot].get_or_init(|| make().into_means());
                OctaveFrames::with_means(self.frames, self.times, octave, means)
            }
        })
    }
}

/// What the judgement needs besides the keypoints.
pub(in crate::detector) struct Motions<'a, 'f> {
    pub frames: &'a FramesOfOctaves<'f>,
    pub times: &'a FrameTimes,
    pub size_image: (usize, usize),
    pub space: &'a ScaleSpace,
    pub interpolation: Interpolation,
}

impl Motions<'_, '_> {
    /// Whether `weaker`, which lies near `stronger`, is a thing of its own.
    pub(in crate::detector) fn are_two(&self, stronger: &Keypoint, weaker: &Keypoint) -> bool {
        let ((su, sv, sigma), (wu, wv, _)) = (stronger.in_image(), weaker.in_image());
        let between = |a: f32, b: f32| 0.5 * (a + b);
        let (du, dv) = (wu - su, wv - sv);
        let (slope_u, slope_v) = (weaker.slope.u - stronger.slope.u, weaker.slope.v - stronger.slope.v);
        let t0 = 0.5 * (self.times.frame_count as f32 - 1.0);
        let count = self.times.kept.len();
        let apart: Vec<usize> = (0..count)
            .filter(|&index| {
                let dt = self.times.kept[index] as f32 - t0;
                (du + dt * slope_u).hypot(dv + dt * slope_v) > APART_SIGMAS * sigma
            })
            .collect();
        if apart.len() < 2 || (apart.len() as f32) < FRAMES_SHARE * count as f32 {
            return false;
        }
        let own = self.response(weaker, (wu, wv), weaker.slope, &apart) * weaker.value.signum();
        let noise = weaker.value.abs() / weaker.snr * (count as f32 / apart.len() as f32).sqrt();
        if own < KEPT_RESPONSE * weaker.value.abs() || own < FRAMES_SNR * noise {
            return false;
        }
        let slope = Slope::new(between(stronger.slope.u, weaker.slope.u), between(stronger.slope.v, weaker.slope.v));
        let middle = self.response(weaker, (between(su, wu), between(sv, wv)), slope, &apart);
        middle * weaker.value.signum() < BETWEEN_RESPONSE * weaker.value.abs()
    }

    /// D of the mean of the `chosen` frames at the octave and level of `keypoint`, along the way through `place` (input
    /// pixels, at mid-burst) at `slope`.
    fn response(&self, keypoint: &Keypoint, place: (f32, f32), slope: Slope, chosen: &[usize]) -> f32 {
        let levels = keypoint.level..keypoint.level + 1;
        point_response(
            self.frames.of(keypoint.octave),
            (self.space, keypoint.octave, levels),
            self.size_image,
            (place, slope),
            self.interpolation,
            chosen,
        )[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn frames_are_the_same_whoever_makes_them() {
        let frames: Vec<Plane> = (0..9).map(|t| Plane::from_fn(64, 48, |u, v| (u * v + t) as f32)).collect();
        let frames: Vec<&Plane> = frames.iter().collect();
        let times = FrameTimes::all(9);
        let alone = FramesOfOctaves::new(&frames, &times, 0..4);
        let expected: Vec<Plane> = alone.of(3).planes().into_iter().cloned().collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().expect("a pool");
        for _ in 0..20 {
            let means: Vec<OnceLock<Vec<Plane>>> = (0..4).map(|_| OnceLock::new()).collect();
            let are_those = |_| {
                let kept = FramesOfOctaves::new(&frames, &times, 0..4).with_means(&means);
                kept.of(3).planes().into_iter().eq(&expected)
            };
            assert!(pool.install(|| (0..100).into_par_iter().with_max_len(1).all(are_those)));
        }
        let together = FramesOfOctaves::new(&frames, &times, 0..4);
        pool.install(|| together.made(3, true));
        assert!(together.of(3).planes().into_iter().eq(&expected));
    }
}
