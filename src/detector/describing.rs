//! Localising and describing the keypoints that the search found in an octave, in parallel.

use super::blur_patch::BlurScratch;
use super::descriptor::{DescriptorScratch, descriptor, descriptor_radius};
use super::feature::{Descriptor, Feature};
use super::locate::{FARTHEST_MOVE_PX, filter_reach, filter_scales, locate};
use super::octave::Base;
use super::orientation::{OrientationScratch, orientations};
use super::params::{DetectorParams, Localisation};
use super::patch::{Patch, PatchScratch, around};
use super::scale_space::{ScaleSpace, octave_pixel};
use super::slope_grid::{Slope, SlopeGrid};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::blur::GaussianKernel;
use rayon::prelude::*;

/// A feature before orientation and descriptor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Keypoint {
    /// Column, octave pixels.
    pub x: f32,
    /// Row, octave pixels.
    pub y: f32,
    /// Scale, octave pixels.
    pub sigma_octave: f32,
    /// DoG level.
    pub level: i32,
    /// Index in the slope grid.
    pub slope_index: usize,
    /// The slope between those of the grid.
    pub slope: Slope,
    /// D.
    pub value: f32,
    /// |D| over its noise.
    pub snr: f32,
}

/// What is needed to describe the keypoints of one octave.
pub(super) struct Describing<'a> {
    /// Where the octave's first level at a slope of the grid comes from.
    pub base: &'a (dyn Fn(usize) -> Base<'a> + Sync),
    /// The octave.
    pub octave: i32,
    /// Its size.
    pub size: (usize, usize),
    /// The slopes searched.
    pub grid: SlopeGrid,
    /// The scales searched.
    pub space: &'a ScaleSpace,
    /// The detection's parameters.
    pub params: &'a DetectorParams,
    /// Tells of a cancel.
    pub monitor: &'a Monitor,
}

/// Keypoints are described in strips of this many columns, each from top to bottom: what their patches share of the frames is then still in the cache.
const STRIP_COLUMNS: f32 = 200.0;
/// Keypoints that one thread describes in a row.
const TOGETHER: usize = 32;

/// Space that a thread reuses from keypoint to keypoint.
#[derive(Default)]
struct Scratch {
    raw: Patch,
    level: Patch,
    patch: PatchScratch,
    blur: BlurScratch,
    orientation: OrientationScratch,
    descriptor: DescriptorScratch,
}

impl Describing<'_> {
    /// The keypoint at its place and slope on the continuous D, where the parameters ask for that and it has one. `raw` holds the pixels around it.
    fn located(&self, keypoint: &Keypoint, raw: &Patch, scales: (f64, f64)) -> Keypoint {
        if self.params.localisation == Localisation::Quadratic {
            return *keypoint;
        }
        let (i, j) = self.grid.coordinates(keypoint.slope_index);
        let reach = filter_reach(scales);
        let neighbour = |di: i32, dj: i32| {
            let i = i.checked_add_signed(di as isize).filter(|&i| i < self.grid.u.count)?;
            let j = j.checked_add_signed(dj as isize).filter(|&j| j < self.grid.v.count)?;
            let base = (self.base)(j * self.grid.u.count + i);
            let (columns, rows) = (around(keypoint.x, reach), around(keypoint.y, reach));
            let mut patch = Patch::default();
            base.patch(self.size, columns, rows, &mut PatchScratch::default(), &mut patch);
            Some(patch)
        };
        let at = (f64::from(keypoint.x), f64::from(keypoint.y));
        let Some(found) = locate(raw, neighbour, at, scales) else {
            return *keypoint;
        };
        Keypoint {
            x: found.x as f32,
            y: found.y as f32,
            slope: self.grid.at(i as f32 + found.slope_step_i, j as f32 + found.slope_step_j),
            ..*keypoint
        }
    }

    /// Orientations and descriptors of the octave's keypoints, in an order that depends on the keypoints alone.
    ///
    /// # Errors
    /// [`Cancelled`] once the monitor was cancelled.
    pub fn describe(&self, keypoints: &[Keypoint]) -> Result<Vec<(Feature, Descriptor)>, Cancelled> {
        let mut order: Vec<&Keypoint> = keypoints.iter().collect();
        let strip = |keypoint: &Keypoint| (keypoint.x / STRIP_COLUMNS) as i64;
        order.sort_by(|a, b| strip(a).cmp(&strip(b)).then(a.y.total_cmp(&b.y)).then(a.x.total_cmp(&b.x)));
        let kernels: Vec<GaussianKernel> = (0..self.space.levels as i32).map(|level| self.kernel(level)).collect();
        let described: Vec<Vec<(Feature, Descriptor)>> = order
            .par_chunks(TOGETHER)
            .map_init(Scratch::default, |scratch, keypoints| {
                let mut out = Vec::with_capacity(TOGETHER + TOGETHER / 2);
                for keypoint in keypoints {
                    self.monitor.check()?;
                    self.describe_one(keypoint, &kernels, scratch, &mut out);
                }
                Ok(out)
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(described.into_iter().flatten().collect())
    }

    /// From what the octave is made from to Gaussian level `level`.
    fn kernel(&self, level: i32) -> GaussianKernel {
        // All slopes' bases have one scale.
        let from = (self.base)(0).sigma_octave();
        let sigma = self.space.sigma_octave(f64::from(level));
        GaussianKernel::with_cut((sigma * sigma - from * from).max(0.0).sqrt(), self.space.kernel_cut)
    }

    /// Appends the features of one keypoint: one for each of its orientations. `kernels` lead to the levels.
    fn describe_one(
        &self,
        keypoint: &Keypoint,
        kernels: &[GaussianKernel],
        scratch: &mut Scratch,
        out: &mut Vec<(Feature, Descriptor)>,
    ) {
        let (size, pixel) = (self.size, octave_pixel(self.octave));
        let base = (self.base)(keypoint.slope_index);
        let scales = filter_scales(f64::from(keypoint.sigma_octave), self.space.levels, base.sigma_octave());
        let kernel = &kernels[keypoint.level as usize];
        // The descriptor's square and the neighbours that its gradients need.
        let reach_level = descriptor_radius(keypoint.sigma_octave) + 1;
        let reach = filter_reach(scales).max(reach_level + kernel.radius() + FARTHEST_MOVE_PX);
        let Scratch { raw, level: patch, .. } = scratch;
        base.patch(size, around(keypoint.x, reach), around(keypoint.y, reach), &mut scratch.patch, raw);
        let Keypoint { x, y, sigma_octave: sigma, level, slope_index, slope, .. } = self.located(keypoint, raw, scales);
        raw.blurred(around(x, reach_level), around(y, reach_level), kernel, &mut scratch.blur, patch);
        let (i, j) = self.grid.coordinates(slope_index);
        let most = self.params.max_orientations;
        for angle in orientations(patch, size, (x, y), sigma, most, &mut scratch.orientation) {
            let feature = Feature {
                u: x * pixel,
                v: y * pixel,
                sigma: sigma * pixel,
                orientation: if angle > std::f32::consts::PI { angle - std::f32::consts::TAU } else { angle },
                slope,
                response: keypoint.value,
                snr: keypoint.snr,
                octave: self.octave,
                level,
                slope_index,
                at_slope_limit: self.grid.on_rim(i, j),
            };
            out.push((feature, descriptor(patch, size, (x, y), sigma, angle, &mut scratch.descriptor)));
        }
    }
}
