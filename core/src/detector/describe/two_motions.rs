//! Test of whether a weaker keypoint beside a stronger one of another slope is a separate structure.
//!
//! A blob also appears in the stack of a wrong slope, smeared along its path there: a ghost, which responds only in
//! those frames in which the true blob crosses the ghost's path. A lantern before a wall responds in every frame along
//! its own path. So only the frames are used in which the paths of both keypoints are well apart: there a separate
//! structure still has its full response, well above the noise, and between the two paths there is none. (An elongated
//! structure that slides along itself responds on both paths, but between them too.)

use crate::detector::describe::point_response::point_response;
use crate::detector::keypoint::Keypoint;
use crate::detector::params::Interpolation;
use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::levels::ScaleSpace;
use crate::detector::stack::offsets::FrameTimes;
use crate::detector::stack::refined::OctaveFrames;
use crate::plane::Plane;
use std::sync::OnceLock;

/// Frames count in which the two paths are farther apart than this many σ of the stronger keypoint: at that distance
/// its response has passed through 0.
const APART_SIGMAS: f32 = 2.5;
/// Minimum share of all frames that must count; two frames must in any case.
const FRAMES_SHARE: f32 = 0.2;
/// Minimum fraction of its response that a separate structure keeps in those frames.
const KEPT_RESPONSE: f32 = 0.6;
/// Minimum of that response in standard deviations of its noise. A mean of few frames is noisy, and a false second
/// keypoint makes matches ambiguous.
const FRAMES_SNR: f32 = 5.0;
/// Maximum response between the two paths, as a fraction of the weaker response.
const BETWEEN_RESPONSE: f32 = 0.5;

/// The frames at the resolutions of all octaves, each computed on first use.
pub(in crate::detector) struct FramesOfOctaves<'a> {
    frames: &'a [&'a Plane],
    times: &'a FrameTimes,
    first_octave: i32,
    octaves: Vec<OnceLock<OctaveFrames<'a>>>,
    /// The octaves' means of frames, where they are kept elsewhere.
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

    /// Keeps the means in `means`, one slot an octave, each computed on first use.
    pub(in crate::detector) fn with_means(self, means: &'a [OnceLock<Vec<Plane>>]) -> Self {
        Self { means: Some(means), ..self }
    }

    /// Computes the frames for `keypoints` now, on all threads unless the means are shared.
    pub(in crate::detector) fn make<'k>(&self, keypoints: impl Iterator<Item = &'k Keypoint>) {
        if let Some(last) = keypoints.map(|keypoint| keypoint.octave).max() {
            self.made(last, self.means.is_none());
        }
    }

    /// Frames of `octave`, one of the octaves given.
    pub(in crate::detector) fn of(&self, octave: i32) -> &OctaveFrames<'a> {
        // Many threads may call this at once. The thread that computes must work alone: if it waited for others, it
        // would run other jobs meanwhile, which may need the same frames and so wait for itself.
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

/// Inputs of the test besides the keypoints.
pub(in crate::detector) struct Motions<'a, 'f> {
    pub frames: &'a FramesOfOctaves<'f>,
    pub times: &'a FrameTimes,
    pub size_image: (usize, usize),
    pub space: &'a ScaleSpace,
    pub interpolation: Interpolation,
}

impl Motions<'_, '_> {
    /// Whether `weaker`, which lies near `stronger`, is a separate structure.
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

    /// D of the mean of the `chosen` frames at the octave and level of `keypoint`, on the path through `place` (input
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
