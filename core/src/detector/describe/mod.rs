//! Localisation and description of the keypoints of an octave, in parallel.

pub mod descriptor;
mod pooling;

use crate::detector::along::{OctaveFrames, around};
use crate::detector::describe::descriptor::{DescriptorScratch, Square, Sums, descriptor_radius, pool, quantise, sums};
use crate::detector::feature::{Descriptor, Feature, Keypoint};
use crate::detector::localise::{FARTHEST_MOVE_PX, LocateScratch, kernel_reach, located, rim_radius, scale};
use crate::detector::orient::{OrientationScratch, orientations};
use crate::detector::params::Slope;
use crate::detector::scale_space::{octave_pixel, octave_size};
use crate::detector::search::setup::{FirstLevels, Search};
use crate::kernel::machine::{KEYPOINTS_TOGETHER as TOGETHER, STRIP_COLUMNS};
use crate::kernel::patch::{BlurScratch, Patch, PatchScratch};
use crate::kernel::stack::FrameOffset;
use crate::monitor::Cancelled;
use crate::plane::blur::GaussianKernel;
use pooling::{CoarseScratch, CoarserScales};
use rayon::prelude::*;

/// Misplacement of the outermost frame, in σ, above which a feature is described at its own slope. Chosen, not tuned.
const MISALIGNED_SIGMAS: f32 = 0.1;

/// Whether a misplacement of an outermost frame by `px` matters to a feature of scale `sigma_px`.
pub(super) fn misaligned(px: f32, sigma_px: f32) -> bool {
    px > MISALIGNED_SIGMAS * sigma_px
}

/// Key of the place (`x`, `y`) in `octave` in an order in which neighbours share most of the pixels around them: by
/// strips of columns, and down each of them.
pub(super) fn place_order(octave: i32, x: f32, y: f32) -> (i32, i64, i64) {
    (octave, (x / STRIP_COLUMNS) as i64, y as i64)
}

#[derive(Default)]
pub(super) struct DescribeScratch {
    raw: Patch,
    level: Patch,
    patch: PatchScratch,
    locate: LocateScratch,
    blur: BlurScratch,
    orientation: OrientationScratch,
    descriptor: DescriptorScratch,
    coarse: CoarseScratch,
}

#[derive(Debug, Clone)]
pub(super) struct Described {
    pub feature: Feature,
    pub descriptor: Descriptor,
    pub keypoint: usize,
    /// Distance from its slope at which the response is e^−½ of its peak, pixels per frame; infinite along an edge.
    pub slope_width: f32,
}

pub(super) struct Describing<'a> {
    pub search: &'a Search<'a>,
    pub bases: &'a [FirstLevels],
    pub octave: i32,
    /// Frames at the octave's resolution, where features are described at their own slope.
    pub own_slopes: Option<OctaveFrames<'a>>,
    /// Called with the number of keypoints described since the last call.
    pub described: &'a (dyn Fn(usize) + Sync),
}

impl Describing<'_> {
    /// Localises, orients and describes keypoints, numbered from `first`; the features' order depends on them alone.
    pub fn describe(&self, keypoints: &[Keypoint], first: usize) -> Result<Vec<Described>, Cancelled> {
        let mut order: Vec<(usize, &Keypoint)> = keypoints.iter().enumerate().collect();
        order.sort_by_cached_key(|(_, one)| place_order(0, one.x, one.y));
        let from = self.search.space.sigma_before(self.octave);
        let kernels: Vec<GaussianKernel> =
            (0..self.search.space.levels as i32).map(|level| self.kernel(level, from)).collect();
        let described: Vec<Vec<Described>> = order
            .par_chunks(TOGETHER)
            .map_init(DescribeScratch::default, |scratch, keypoints| {
                let mut out = Vec::with_capacity(TOGETHER + TOGETHER / 2);
                for &(number, keypoint) in keypoints {
                    self.search.monitor.check()?;
                    self.describe_one(first + number, keypoint, &kernels, scratch, &mut out);
                }
                (self.described)(keypoints.len());
                Ok(out)
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(described.into_iter().flatten().collect())
    }

    /// Kernel from σ `from`, octave pixels, to Gaussian level `level`.
    fn kernel(&self, level: i32, from: f64) -> GaussianKernel {
        let space = self.search.space;
        let sigma = space.sigma_octave(f64::from(level));
        GaussianKernel::with_cut((sigma * sigma - from * from).max(0.0).sqrt(), space.kernel_cut)
    }

    /// The coarser scales of the descriptors of features of Gaussian level `level`, from σ `from`, octave pixels.
    fn coarser_scales(&self, level: i32, from: f64) -> CoarserScales {
        let Search { space, params, .. } = self.search;
        CoarserScales::new(params.describe_scales, space.sigma_octave(f64::from(level)), from, space.kernel_cut)
    }

    /// The octave's frames, and their offsets at a keypoint's own slope if it is described there, not at the grid's.
    fn own_slope(&self, keypoint: &Keypoint) -> Option<(&OctaveFrames<'_>, Vec<FrameOffset>)> {
        let frames = self.own_slopes.as_ref()?;
        let grid = self.search.grid.slope(keypoint.slope_index);
        let off = Slope::new(keypoint.slope.u - grid.u, keypoint.slope.v - grid.v);
        let outermost_px = off.magnitude() * 0.5 * (self.search.planes.len() as f32 - 1.0);
        let sigma_px = keypoint.sigma_octave * octave_pixel(self.octave);
        misaligned(outermost_px, sigma_px).then(|| (frames, frames.offsets(keypoint.slope)))
    }

    /// Appends one feature for each orientation of a keypoint. `kernels` lead from the first level to each level.
    fn describe_one(
        &self,
        number: usize,
        keypoint: &Keypoint,
        kernels: &[GaussianKernel],
        scratch: &mut DescribeScratch,
        out: &mut Vec<Described>,
    ) {
        let Search { inputs, space, params, .. } = self.search;
        let (size, pixel) = (octave_size(inputs.size_image, self.octave), octave_pixel(self.octave));
        let base = self.search.base(self.bases, self.octave, keypoint.slope_index);
        let from = space.sigma_before(self.octave);
        let kernel = &kernels[keypoint.level as usize];
        // The first patch must hold the descriptor's square, the neighbours of its gradients, and the kernels.
        let level_reach = |sigma: f32| descriptor_radius(sigma) + 1;
        let wanted_sigma = f64::from(keypoint.sigma_octave);
        let mut reach = (scale::reach(wanted_sigma, space.levels) + FARTHEST_MOVE_PX)
            .max(kernel_reach(rim_radius(wanted_sigma, space.levels), 1));
        let mut coarser = self.coarser_scales(keypoint.level, from);
        let needed = |kernel: &GaussianKernel, coarser: &CoarserScales, sigma: f32| {
            (level_reach(sigma) + kernel.radius()).max(coarser.reach(sigma))
        };
        // With own slopes the patch is read again at the refined slope, so that the first one may be small.
        if self.own_slopes.is_none() {
            reach = reach.max(needed(kernel, &coarser, keypoint.sigma_octave) + FARTHEST_MOVE_PX + 1);
        }
        let DescribeScratch { raw, level: patch, .. } = scratch;
        base.patch(size, around(keypoint.x, reach), around(keypoint.y, reach), &mut scratch.patch, raw);
        let (located, slope_width) = located(self.search, self.bases, keypoint, raw, from, &mut scratch.locate);
        let Keypoint { x, y, sigma_octave: sigma, .. } = located;
        let reach_level = level_reach(sigma);
        // The grid's slope would smear the patch: the frames are read again at the feature's own.
        if let Some((frames, offsets)) = self.own_slope(&located) {
            let kernel = self.kernel(keypoint.level, frames.sigma_octave(&offsets));
            coarser = self.coarser_scales(keypoint.level, frames.sigma_octave(&offsets));
            let needed = needed(&kernel, &coarser, sigma);
            let own = frames.base(&frames.planes, &offsets);
            own.patch(size, around(x, needed), around(y, needed), &mut scratch.patch, raw);
            raw.blurred(around(x, reach_level), around(y, reach_level), &kernel, &mut scratch.blur, patch);
        } else {
            // A scale that grew much needs a larger patch.
            let needed = needed(kernel, &coarser, sigma);
            if needed + FARTHEST_MOVE_PX > reach {
                base.patch(size, around(x, needed), around(y, needed), &mut scratch.patch, raw);
            }
            raw.blurred(around(x, reach_level), around(y, reach_level), kernel, &mut scratch.blur, patch);
        }
        // All orientations share one level and patch; only the sums are turned.
        let angles = orientations(patch, size, (x, y), sigma, params.max_orientations, &mut scratch.orientation);
        let finest = |angle: &f32| sums(patch, size, &Square::of((x, y), sigma, *angle), &mut scratch.descriptor);
        let mut sums: Vec<Vec<Sums>> = angles.iter().map(finest).map(|sums| vec![sums]).collect();
        let buffers = (&mut scratch.coarse, &mut scratch.blur, &mut scratch.descriptor);
        coarser.append(raw, size, (x, y), sigma, (&angles, &mut sums), buffers);
        for (angle, sums) in angles.into_iter().zip(sums) {
            let feature = Feature {
                u: x * pixel,
                v: y * pixel,
                sigma: sigma * pixel,
                orientation: if angle > std::f32::consts::PI { angle - std::f32::consts::TAU } else { angle },
                slope: located.slope,
                response: keypoint.value,
                snr: keypoint.snr,
                octave: self.octave,
                level: located.level,
                slope_index: located.slope_index,
                // The mark at the limit and the field's values follow once the features are ranked.
                ..Feature::default()
            };
            let descriptor = if let [alone] = sums[..] { quantise(alone) } else { pool(&sums) };
            out.push(Described { feature, descriptor, keypoint: number, slope_width });
        }
    }
}
