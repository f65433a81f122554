//! Pixels around one feature, from the frames or from an octave's stored first level, and the values of D at single
//! places that follow from them.
//!
//! A feature lies at a slope of its own, between those of the grid. Neighbouring slopes of a grid misalign the
//! outermost frames by their step times (N − 1)/2 pixels, so a feature half-way between two of them is smeared in both,
//! and a descriptor computed there matches less. The grid's stacks are no help: the frames have to be shifted again.
//! For octaves above 0 that is done on frames of that octave's resolution ([`OctaveFrames`]): each pixel the mean of
//! 2^o × 2^o of a frame's. Averaging before shifting equals averaging after it, except for detail finer than the
//! averages, which no level of that octave shows.
//!
//! D at a place is a weighted patch: the frames are shifted by any slope and averaged in a small patch, and the patch
//! is weighted by two Gaussians. Stacking and filtering commute, so the values are those of a search at that slope, up
//! to interpolation (and, in coarser octaves, the way in which the frames are brought to their resolution).
//!
//! It tests, too, whether a weaker keypoint beside a stronger one of another slope is a separate structure
//! ([`Motions`]). A blob also appears in the stack of a wrong slope, smeared along its path there: a ghost, which
//! responds only in those frames in which the true blob crosses the ghost's path. A lantern before a wall responds in
//! every frame along its own path. So only the frames are used in which the paths of both keypoints are well apart:
//! there a separate structure still has its full response, well above the noise, and between the two paths there is
//! none. (An elongated structure that slides along itself responds on both paths, but between them too.)

use crate::detector::feature::Keypoint;
use crate::detector::params::slope_grid::{Slope, SlopeGrid};
use crate::detector::params::{DetectorParams, Interpolation};
use crate::detector::scale_space::{Base, SIGMA_INPUT, ScaleSpace, octave_pixel, octave_size};
use crate::detector::stack::{FrameTimes, interpolation_blur, shifted_offsets};
use crate::kernel::patch::{Patch, PatchScratch, inside, stack_patch};
use crate::kernel::stack::FrameOffset;
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::blur::GaussianKernel;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::OnceLock;

/// Pixels within `radius` of the pixel in which `place` lies.
pub(in crate::detector) fn around(place: f32, radius: usize) -> Range<i64> {
    let (middle, radius) = ((place + 0.5).floor() as i64, radius as i64);
    middle - radius..middle + radius + 1
}

impl Base<'_> {
    /// Reads columns `columns` and rows `rows` of the octave of `size`, before any blur of this octave and less the
    /// value in the middle, into `patch`. The rectangle must touch the octave.
    pub fn patch(
        &self,
        size: (usize, usize),
        columns: Range<i64>,
        rows: Range<i64>,
        scratch: &mut PatchScratch,
        patch: &mut Patch,
    ) {
        match self {
            Self::Level(level) => {
                patch.reset(columns.clone(), rows.clone());
                let columns = inside(&columns, size.0);
                for v in inside(&rows, size.1) {
                    let from = &level.row(v)[columns.clone()];
                    patch.values_mut(columns.start as i64, v as i64)[..from.len()].copy_from_slice(from);
                }
                patch.repeat_border(size);
            }
            Self::Frames { frames, offsets, octave: 0 } => {
                patch.reset(columns, rows);
                stack_patch(frames, offsets, patch, &mut scratch.sums);
                patch.repeat_border(size);
            }
            Self::Frames { frames, offsets, octave: -1 } => {
                // Pixels between which those of the doubled image lie. Repeated border pixels double to repeated ones.
                let narrow = |range: &Range<i64>| range.start.div_euclid(2)..(range.end - 1).div_euclid(2) + 2;
                scratch.narrow.reset(narrow(&columns), narrow(&rows));
                stack_patch(frames, offsets, &mut scratch.narrow, &mut scratch.sums);
                scratch.narrow.repeat_border(frames[0].size());
                patch.reset(columns, rows);
                patch.double(&scratch.narrow, &mut scratch.row);
            }
            Self::Frames { .. } => {
                patch.reset(columns.clone(), rows.clone());
                let columns = inside(&columns, size.0);
                self.raw_rows(inside(&rows, size.1), columns.clone(), &mut scratch.row, |v, row| {
                    patch.values_mut(columns.start as i64, v as i64)[..row.len()].copy_from_slice(row);
                });
                patch.repeat_border(size);
            }
        }
        patch.centre();
    }
}

/// Inputs for describing the keypoints of one octave.
pub(in crate::detector) struct Describing<'a> {
    /// Source of the octave's first level at a slope of the grid.
    pub base: &'a (dyn Fn(usize) -> Base<'a> + Sync),
    /// Source of the finer octave's first level; `None` for the first octave.
    pub finer: Option<&'a (dyn Fn(usize) -> Base<'a> + Sync)>,
    /// Offsets of the frames at each slope of the grid.
    pub offsets: &'a [Vec<FrameOffset>],
    /// Index of the octave.
    pub octave: i32,
    /// Size (columns, rows) of the octave.
    pub size: (usize, usize),
    /// Size (columns, rows) of the image.
    pub size_image: (usize, usize),
    /// Slopes of the search.
    pub grid: SlopeGrid,
    /// Scales of the search.
    pub space: &'a ScaleSpace,
    /// Parameters of the detection.
    pub params: &'a DetectorParams,
    /// Frames at the octave's resolution, where features are described at their own slope.
    pub own_slopes: Option<&'a OctaveFrames<'a>>,
    /// Monitor for cancellation.
    pub monitor: &'a Monitor,
    /// Called with the number of keypoints described since the last call.
    pub described: &'a (dyn Fn(usize) + Sync),
}

/// D of the mean of the `chosen` frames at each of the DoG `levels` of `octave`, on the path through `place` (input
/// pixels, at mid-burst) at `slope`. The octave's pixel nearest to the place is taken.
pub(in crate::detector) fn point_response(
    frames: &OctaveFrames<'_>,
    (space, octave, levels): (&ScaleSpace, i32, Range<i32>),
    size_image: (usize, usize),
    (place, slope): ((f32, f32), Slope),
    interpolation: Interpolation,
    chosen: &[usize],
) -> Vec<f32> {
    let (planes, offsets) = (frames.planes(), frames.offsets(slope, interpolation));
    let planes: Vec<&Plane> = chosen.iter().map(|&index| planes[index]).collect();
    let offsets: Vec<FrameOffset> = chosen.iter().map(|&index| offsets[index]).collect();
    response_of(frames, (&planes, &offsets), (space, octave, levels), size_image, place)
}

/// As [`point_response`], for the mean of the frames `planes` of `frames`, read at `offsets`.
pub(in crate::detector) fn response_of(
    frames: &OctaveFrames<'_>,
    (planes, offsets): (&[&Plane], &[FrameOffset]),
    (space, octave, levels): (&ScaleSpace, i32, Range<i32>),
    size_image: (usize, usize),
    place: (f32, f32),
) -> Vec<f32> {
    let from = frames.sigma_octave(offsets);
    let kernel = |s: i32| {
        let sigma = space.sigma_octave(f64::from(s));
        GaussianKernel::new((sigma * sigma - from * from).max(0.0).sqrt())
    };
    let kernels: Vec<GaussianKernel> = (levels.start..levels.end + 1).map(kernel).collect();
    let size = octave_size(size_image, octave);
    let pixel = octave_pixel(octave);
    let inside = |x: f32, n: usize| (x / pixel).clamp(0.0, n as f32 - 1.0);
    let (x, y) = (inside(place.0, size.0), inside(place.1, size.1));
    let reach = kernels.last().map_or(0, GaussianKernel::radius);
    let base: Base<'_> = frames.base(planes, offsets);
    let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
    base.patch(size, around(x, reach), around(y, reach), &mut scratch, &mut patch);
    let weighted: Vec<f32> = kernels.iter().map(|kernel| weighted(&patch, kernel, reach)).collect();
    weighted.windows(2).map(|two| two[1] - two[0]).collect()
}

/// Value of `kernel` applied at the middle of `patch`, which reaches `reach` pixels from it.
fn weighted(patch: &Patch, kernel: &GaussianKernel, reach: usize) -> f32 {
    let radius = kernel.radius();
    let half = kernel.half();
    let taps: Vec<f32> = half[1..].iter().rev().chain(half).copied().collect();
    let within = reach - radius..reach + radius + 1;
    let row = |v: i64| -> f32 { patch.row(v)[within.clone()].iter().zip(&taps).map(|(x, w)| x * w).sum() };
    let first = patch.rows().start + (reach - radius) as i64;
    taps.iter().zip(first..).map(|(w, v)| w * row(v)).sum()
}

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

/// Frames at the resolution of one octave.
pub(in crate::detector) struct OctaveFrames<'a> {
    octave: i32,
    /// Means of 2^octave × 2^octave pixels of each frame; empty where the frames are used unchanged.
    means: Cow<'a, [Plane]>,
    frames: &'a [&'a Plane],
    times: &'a FrameTimes,
}

impl<'a> OctaveFrames<'a> {
    /// Makes the frames for `octave`, −1 or more, from `frames` of one size, taken at `times`. Octaves 0 and −1 use the
    /// frames unchanged.
    pub(in crate::detector) fn new(
        frames: &'a [&'a Plane],
        times: &'a FrameTimes,
        octave: i32,
        in_parallel: bool,
    ) -> Self {
        let finest = Self { octave: octave.min(0), means: Cow::Borrowed(&[]), frames, times };
        (0..octave).fold(finest, |finer, _| finer.coarser(in_parallel))
    }

    /// Makes the frames for the next octave from these: on all threads, or on the calling one.
    pub(in crate::detector) fn coarser(&self, in_parallel: bool) -> Self {
        let octave = self.octave + 1;
        let means = match octave > 0 {
            true if in_parallel => self.planes().into_par_iter().map(halved).collect(),
            true => self.planes().into_iter().map(halved).collect(),
            false => Vec::new(),
        };
        Self { octave, means: Cow::Owned(means), frames: self.frames, times: self.times }
    }

    /// Frames for `octave` whose means were computed before: see [`Self::into_means`].
    pub(in crate::detector) fn with_means(
        frames: &'a [&'a Plane],
        times: &'a FrameTimes,
        octave: i32,
        means: &'a [Plane],
    ) -> Self {
        Self { octave, means: Cow::Borrowed(means), frames, times }
    }

    /// Means of 2^octave × 2^octave pixels of each frame; empty where the frames are used unchanged.
    pub(in crate::detector) fn into_means(self) -> Vec<Plane> {
        self.means.into_owned()
    }

    /// The frames by reference, as [`Self::base`] borrows them.
    pub(in crate::detector) fn planes(&self) -> Vec<&Plane> {
        if self.means.is_empty() { self.frames.to_vec() } else { self.means.iter().collect() }
    }

    /// Offsets at which [`Self::planes`] are read at `slope` (input px per frame).
    pub(in crate::detector) fn offsets(&self, slope: Slope, interpolation: Interpolation) -> Vec<FrameOffset> {
        let pixel = 2f64.powi(self.octave.max(0));
        // The mean of 2^o pixels is at their centre, the octave's pixel at the first of them.
        let shift_px = -0.5 * (1.0 - 1.0 / pixel);
        let in_octave = (f64::from(slope.u) / pixel, f64::from(slope.v) / pixel);
        self.times.of(shifted_offsets(self.times.frame_count, in_octave, shift_px, interpolation))
    }

    /// Source of the octave's pixels: `planes` read at `offsets`.
    pub(in crate::detector) fn base<'b>(&self, planes: &'b [&'b Plane], offsets: &'b [FrameOffset]) -> Base<'b> {
        Base::Frames { frames: planes, offsets, octave: self.octave.min(0) }
    }

    /// σ of that source, in octave pixels: of the input, the averages, and the reading between pixels.
    pub(in crate::detector) fn sigma_octave(&self, offsets: &[FrameOffset]) -> f64 {
        let pixel = 2f64.powi(self.octave);
        let average = if self.octave > 0 { (1.0 - 1.0 / (pixel * pixel)) / 12.0 } else { 0.0 };
        let (u, v) = interpolation_blur(offsets);
        // A doubled image is read between the frames' pixels, which are two of its own apart.
        let reading = 0.5 * (u + v) * if self.octave < 0 { 4.0 } else { 1.0 };
        ((SIGMA_INPUT / pixel).powi(2) + average + reading).sqrt()
    }
}

/// Means of 2 × 2 pixels; of the size of the next octave.
fn halved(plane: &Plane) -> Plane {
    let (width, height) = octave_size(plane.size(), 1);
    let mut out = Plane::zeros(width, height);
    for v in 0..height {
        let (upper, lower) = (plane.row(2 * v), plane.row(2 * v + 1));
        for ((out, a), b) in out.row_mut(v).iter_mut().zip(upper.chunks_exact(2)).zip(lower.chunks_exact(2)) {
            *out = 0.25 * ((a[0] + a[1]) + (b[0] + b[1]));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// Frames with a Gaussian blob of σ 6 px that moves by `slope`, at (70, 50) in the middle of the burst.
    fn moving(slope: Slope) -> Vec<Plane> {
        (0..7)
            .map(|t| {
                let dt = t as f32 - 3.0;
                Plane::from_fn(160, 120, |u, v| {
                    let (du, dv) = (u as f32 - 70.0 - dt * slope.u, v as f32 - 50.0 - dt * slope.v);
                    (-(du * du + dv * dv) / 72.0).exp()
                })
            })
            .collect()
    }

    #[test]
    fn every_octave_shows_a_moving_blob_sharp_and_in_its_place() {
        let slope = Slope::new(1.37, -0.61);
        let frames = moving(slope);
        let frames: Vec<&Plane> = frames.iter().collect();
        for octave in [-1, 0, 1, 2] {
            let times = FrameTimes::all(frames.len());
            let of_octave = OctaveFrames::new(&frames, &times, octave, octave % 2 == 0);
            let (planes, offsets) = (of_octave.planes(), of_octave.offsets(slope, Interpolation::Linear));
            let base = of_octave.base(&planes, &offsets);
            let pixel = 2f32.powi(octave);
            let (size, at) = (octave_size((160, 120), octave), |x: f32| (x / pixel) as i64);
            let (mut scratch, mut patch) = (PatchScratch::default(), Patch::default());
            let (columns, rows) = (at(40.0)..at(100.0), at(20.0)..at(80.0));
            base.patch(size, columns.clone(), rows.clone(), &mut scratch, &mut patch);
            let middle = patch.row((rows.start + rows.end) / 2)[columns.clone().count() / 2];
            for y in rows {
                for (x, value) in columns.clone().zip(patch.row(y)) {
                    let (du, dv) = (x as f32 * pixel - 70.0, y as f32 * pixel - 50.0);
                    // Increase of σ² by averages and interpolation.
                    let added = (of_octave.sigma_octave(&offsets).powi(2) as f32
                        - (SIGMA_INPUT as f32 / pixel).powi(2))
                        * pixel
                        * pixel;
                    let variance = 36.0 + added;
                    let truth = |du: f32, dv: f32| 36.0 / variance * (-(du * du + dv * dv) / (2.0 * variance)).exp();
                    let (cu, cv) = ((columns.start + columns.end) / 2, (at(20.0) + at(80.0)) / 2);
                    let centre = truth(cu as f32 * pixel - 70.0, cv as f32 * pixel - 50.0);
                    let expected = truth(du, dv) - centre + middle;
                    assert!((value - expected).abs() < 8e-3, "octave {octave} ({x}, {y}): {value} {expected}");
                }
            }
        }
    }
}
