//! Localising and describing the keypoints that the search found in an octave, in parallel.

use super::describe::{GradientPatch, gradient_radius, span};
use super::feature::{Descriptor, Feature};
use super::hat::{Answer, Hat, PixelView};
use super::locate::{FARTHEST_MOVE_PX, Neighbours, hat_reach, place, rim_radius, slope_steps};
use super::motion::{FrameOffset, interpolation_blur};
use super::octave::Base;
use super::params::{DetectorParams, Localisation};
use super::patch::RawPatch;
use super::scale_peak::{self, scale_peak};
use super::scale_space::{ScaleSpace, octave_pixel, octave_size};
use super::slope_grid::{Slope, SlopeGrid};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
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
    /// The same for the octave before; the first octave has none.
    pub finer: Option<&'a (dyn Fn(usize) -> Base<'a> + Sync)>,
    /// Where the frames are read at each slope of the grid.
    pub offsets: &'a [Vec<FrameOffset>],
    /// The octave.
    pub octave: i32,
    /// Its size.
    pub size: (usize, usize),
    /// The image's size.
    pub size_image: (usize, usize),
    /// The slopes searched.
    pub grid: SlopeGrid,
    /// The scales searched.
    pub space: &'a ScaleSpace,
    /// The detection's parameters.
    pub params: &'a DetectorParams,
    /// Tells of a cancel.
    pub monitor: &'a Monitor,
}

/// The pixels around a keypoint at one slope: those that were made for it, or the octave's first level.
enum Around<'a> {
    Made(RawPatch),
    Level(&'a Plane),
}

impl Around<'_> {
    /// Those of `base`, `reach` to each side of `at`, of an octave of `size`.
    fn of<'a>(base: &Base<'a>, size: (usize, usize), at: (f64, f64), reach: usize) -> Around<'a> {
        match base {
            Base::Level(plane) => Around::Level(plane),
            Base::Frames { .. } => {
                Around::Made(base.patch(size, span(at.0 as f32, reach, size.0), span(at.1 as f32, reach, size.1)))
            }
        }
    }

    fn pixels(&self) -> PixelView<'_> {
        match self {
            Self::Made(patch) => patch.pixels(),
            Self::Level(plane) => PixelView::of(plane),
        }
    }
}

/// The slopes around a keypoint's own.
struct Around3x3<'d, 'a> {
    describing: &'d Describing<'a>,
    /// Grid coordinates of its own slope.
    own: (usize, usize),
    /// The place, octave pixels.
    at: (f64, f64),
    /// The radius of its rim, octave pixels.
    rim: f64,
    hat: Hat,
}

impl Around3x3<'_, '_> {
    fn answered(&self, pixels: &PixelView<'_>) -> Answer {
        let radius = self.hat.on_rim(self.rim);
        pixels.hat(&self.hat, radius, self.at, pixels.ground(radius, self.at))
    }

    fn index(&self, di: i32, dj: i32) -> Option<usize> {
        let grid = &self.describing.grid;
        let i = self.own.0.checked_add_signed(di as isize).filter(|&i| i < grid.u.count)?;
        let j = self.own.1.checked_add_signed(dj as isize).filter(|&j| j < grid.v.count)?;
        Some(j * grid.u.count + i)
    }
}

impl Neighbours for Around3x3<'_, '_> {
    fn answer(&self, di: i32, dj: i32) -> Option<Answer> {
        let base = (self.describing.base)(self.index(di, dj)?);
        let radius = self.hat.on_rim(self.rim);
        let around = Around::of(&base, self.describing.size, self.at, radius.ceil() as usize + 1);
        Some(self.answered(&around.pixels()))
    }

    fn blur(&self, di: i32, dj: i32) -> (f64, f64) {
        let pixel = f64::from(octave_pixel(self.describing.octave));
        let (u, v) = self.index(di, dj).map_or((0.0, 0.0), |index| interpolation_blur(&self.describing.offsets[index]));
        (u / (pixel * pixel), v / (pixel * pixel))
    }
}

impl Describing<'_> {
    /// The keypoint at its place and slope and with its scale, where the parameters ask for that and it has them. `raw` holds the pixels around it.
    fn located(&self, keypoint: &Keypoint, raw: &RawPatch, from: f64) -> Keypoint {
        if self.params.localisation == Localisation::Quadratic {
            return *keypoint;
        }
        let sigma = f64::from(keypoint.sigma_octave);
        let rim = rim_radius(sigma, self.space.levels);
        let at = (f64::from(keypoint.x), f64::from(keypoint.y));
        let placed = match self.finer {
            None => place(&raw.pixels(), at, rim, FARTHEST_MOVE_PX as f64),
            Some(finer) => {
                let (at, rim) = ((2.0 * at.0, 2.0 * at.1), 2.0 * rim);
                let size = octave_size(self.size_image, self.octave - 1);
                let around = Around::of(&finer(keypoint.slope_index), size, at, hat_reach(rim, 2));
                place(&around.pixels(), at, rim, 2.0 * FARTHEST_MOVE_PX as f64)
                    .map(|((x, y), hat)| ((0.5 * x, 0.5 * y), hat))
            }
        };
        let Some((at, hat)) = placed else {
            return *keypoint;
        };
        let own = self.grid.coordinates(keypoint.slope_index);
        let slopes = Around3x3 { describing: self, own, at, rim, hat };
        let (i, j) = slope_steps(&slopes.answered(&raw.pixels()), &slopes);
        Keypoint {
            x: at.0 as f32,
            y: at.1 as f32,
            sigma_octave: scale_peak(&raw.pixels(), at, sigma, self.space.levels, from).unwrap_or(sigma) as f32,
            slope: self.grid.at(own.0 as f32 + i, own.1 as f32 + j),
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
        let sigma_level = self.space.sigma_octave(f64::from(keypoint.level));
        let blur = (sigma_level * sigma_level - from * from).max(0.0).sqrt();
        let kernel = GaussianKernel::with_cut(blur, self.space.kernel_cut);
        let wanted_sigma = f64::from(keypoint.sigma_octave);
        let reach = (scale_peak::reach(wanted_sigma, self.space.levels) + FARTHEST_MOVE_PX)
            .max(hat_reach(rim_radius(wanted_sigma, self.space.levels), 1))
            .max(gradient_radius(keypoint.sigma_octave) + kernel.radius() + FARTHEST_MOVE_PX + 1);
        let made = |x: f32, y: f32, reach: usize| base.patch(size, span(x, reach, size.0), span(y, reach, size.1));
        let mut raw = made(keypoint.x, keypoint.y, reach);
        let Keypoint { x, y, sigma_octave: sigma, level, slope_index, slope, .. } = self.located(keypoint, &raw, from);
        // A scale that grew much needs a larger patch.
        let needed = gradient_radius(sigma) + kernel.radius();
        if needed + FARTHEST_MOVE_PX > reach {
            raw = made(x, y, needed);
        }
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
