//! Localising and describing the keypoints that the search found in an octave, in parallel.

use super::describe::{GradientPatch, gradient_radius, span};
use super::feature::{Descriptor, Feature};
use super::locate::{FARTHEST_MOVE_PX, filter_reach, filter_scales, locate};
use super::octave::Base;
use super::params::{DetectorParams, Localisation};
use super::patch::RawPatch;
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

impl Describing<'_> {
    /// The keypoint at its place and slope on the continuous D, where the parameters ask for that and it has one. `raw` holds the pixels around it.
    fn located(&self, keypoint: &Keypoint, raw: &RawPatch, scales: (f64, f64)) -> Keypoint {
        if self.params.localisation == Localisation::Quadratic {
            return *keypoint;
        }
        let (i, j) = self.grid.coordinates(keypoint.slope_index);
        let reach = filter_reach(scales);
        let (columns, rows) = (span(keypoint.x, reach, raw.size.0), span(keypoint.y, reach, raw.size.1));
        let neighbour = |di: i32, dj: i32| {
            let i = i.checked_add_signed(di as isize).filter(|&i| i < self.grid.u.count)?;
            let j = j.checked_add_signed(dj as isize).filter(|&j| j < self.grid.v.count)?;
            let base = (self.base)(j * self.grid.u.count + i);
            Some(base.patch(raw.size, columns.clone(), rows.clone()))
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

    /// Orientations and descriptors of the octave's keypoints, in their order.
    ///
    /// # Errors
    /// [`Cancelled`] once the monitor was cancelled.
    pub fn describe(&self, keypoints: &[Keypoint]) -> Result<Vec<(Feature, Descriptor)>, Cancelled> {
        let described: Vec<Vec<(Feature, Descriptor)>> = keypoints
            .par_iter()
            .map(|keypoint| {
                self.monitor.check()?;
                Ok(self.described(keypoint))
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(described.into_iter().flatten().collect())
    }

    /// The features of one keypoint: one for each of its orientations.
    fn described(&self, keypoint: &Keypoint) -> Vec<(Feature, Descriptor)> {
        let (size, pixel) = (self.size, octave_pixel(self.octave));
        let base = (self.base)(keypoint.slope_index);
        let from = base.sigma_octave();
        let scales = filter_scales(f64::from(keypoint.sigma_octave), self.space.levels, from);
        let sigma_level = self.space.sigma_octave(f64::from(keypoint.level));
        let blur = (sigma_level * sigma_level - from * from).max(0.0).sqrt();
        let kernel = GaussianKernel::with_cut(blur, self.space.kernel_cut);
        let reach =
            filter_reach(scales).max(gradient_radius(keypoint.sigma_octave) + kernel.radius() + FARTHEST_MOVE_PX);
        let raw = base.patch(size, span(keypoint.x, reach, size.0), span(keypoint.y, reach, size.1));
        let Keypoint { x, y, sigma_octave: sigma, level, slope_index, slope, .. } =
            self.located(keypoint, &raw, scales);
        let patch = GradientPatch::around(&raw, (x, y), sigma, &kernel);
        let (i, j) = self.grid.coordinates(slope_index);
        let feature = |angle: f32| Feature {
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
        let orientations = patch.orientations(x, y, sigma, self.params.max_orientations);
        orientations.into_iter().map(|angle| (feature(angle), patch.descriptor(x, y, sigma, angle))).collect()
    }
}
