//! Localisation of one keypoint: applies the [kernels](crate::kernel::compact_kernel) to pixels of its own and
//! neighbouring slopes.

pub mod place;
pub mod scale;

use crate::detector::describe::octave_inputs::Describing;
use crate::detector::describe::patch::around;
use crate::detector::keypoint::Keypoint;
use crate::detector::localise::place::{FARTHEST_MOVE_PX, Neighbours, kernel_reach, place, rim_radius, slope_steps};
use crate::detector::localise::scale::scale_peak;
use crate::detector::params::slope_grid::SlopeGrid;
use crate::detector::params::{DetectorParams, Localisation, SlopeExtrema};
use crate::detector::scale_space::levels::{octave_pixel, octave_size};
use crate::detector::scale_space::octave::Base;
use crate::detector::stack::offsets::interpolation_blur;
use crate::kernel::compact_kernel::{CompactKernel, KernelResponse, PixelView, SOFT};
use crate::kernel::patch::{Patch, PatchScratch};
use crate::plane::Plane;
use std::cell::RefCell;

/// Buffers for the pixels around a keypoint at other slopes or of a finer octave; reused from keypoint to keypoint.
#[derive(Debug, Default)]
pub(super) struct LocateScratch {
    patch: PatchScratch,
    pixels: Patch,
}

/// Pixels around a keypoint at one slope: a patch made for it, or the octave's first level.
enum Around<'p> {
    Made(&'p Patch),
    Level(&'p Plane),
}

impl Around<'_> {
    /// Pixels of `base`, `reach` to each side of `at`, of an octave of `size`.
    fn of<'p>(
        base: &Base<'p>,
        size: (usize, usize),
        at: (f64, f64),
        reach: usize,
        scratch: &'p mut LocateScratch,
    ) -> Around<'p> {
        match base {
            Base::Level(plane) => Around::Level(plane),
            Base::Frames { .. } => {
                let (columns, rows) = (around(at.0 as f32, reach), around(at.1 as f32, reach));
                base.patch(size, columns, rows, &mut scratch.patch, &mut scratch.pixels);
                Around::Made(&scratch.pixels)
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

/// Source of a kernel's responses at the slopes around a keypoint's own.
struct Around3x3<'d, 'a> {
    describing: &'d Describing<'a>,
    /// Grid coordinates of the keypoint's own slope.
    own: (usize, usize),
    /// Place of the keypoint, octave pixels.
    at: (f64, f64),
    /// Radius of the blob's rim, octave pixels.
    rim: f64,
    kernel: CompactKernel,
    scratch: RefCell<&'d mut LocateScratch>,
}

impl Around3x3<'_, '_> {
    fn answered(&self, pixels: &PixelView<'_>) -> KernelResponse {
        let radius = self.kernel.on_rim(self.rim);
        pixels.kernel_response(&self.kernel, radius, self.at, pixels.local_mean(radius, self.at))
    }

    fn index(&self, di: i32, dj: i32) -> Option<usize> {
        let grid = &self.describing.grid;
        let i = self.own.0.checked_add_signed(di as isize).filter(|&i| i < grid.u.count)?;
        let j = self.own.1.checked_add_signed(dj as isize).filter(|&j| j < grid.v.count)?;
        Some(j * grid.u.count + i)
    }
}

impl Neighbours for Around3x3<'_, '_> {
    fn answer(&self, di: i32, dj: i32) -> Option<KernelResponse> {
        let base = (self.describing.base)(self.index(di, dj)?);
        let radius = self.kernel.on_rim(self.rim);
        let mut scratch = self.scratch.borrow_mut();
        let around = Around::of(&base, self.describing.size, self.at, radius.ceil() as usize + 1, &mut scratch);
        Some(self.answered(&around.pixels()))
    }

    fn blur(&self, di: i32, dj: i32) -> (f64, f64) {
        let pixel = f64::from(octave_pixel(self.describing.octave));
        let (u, v) = self.index(di, dj).map_or((0.0, 0.0), |index| interpolation_blur(&self.describing.offsets[index]));
        (u / (pixel * pixel), v / (pixel * pixel))
    }
}

/// Distance, in running slope indices, from a keypoint's slope to the farthest one that its localisation uses.
pub(in crate::detector) fn slopes_around(params: &DetectorParams, grid: &SlopeGrid) -> usize {
    match params.localisation {
        Localisation::Quadratic => 0,
        Localisation::Continuous => grid.neighbour_distance(),
    }
}

impl Describing<'_> {
    /// The keypoint with refined place, slope and scale, or unchanged where the parameters ask for the quadratic fit
    /// alone or the refinement fails. `raw` holds the pixels around it.
    pub(super) fn located(&self, keypoint: &Keypoint, raw: &Patch, from: f64, scratch: &mut LocateScratch) -> Keypoint {
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
                let around = Around::of(&finer(keypoint.slope_index), size, at, kernel_reach(rim, 2), scratch);
                place(&around.pixels(), at, rim, 2.0 * FARTHEST_MOVE_PX as f64)
                    .map(|((x, y), kernel)| ((0.5 * x, 0.5 * y), kernel))
            }
        };
        let (at, kernel) = match placed {
            Some(found) => found,
            // Where no kernel gives a place, that of the fit is kept. A joint search has refined the slope; otherwise
            // it is refined here.
            None if self.params.slope_extrema == SlopeExtrema::Joint => return *keypoint,
            None => (at, SOFT),
        };
        let own = self.grid.coordinates(keypoint.slope_index);
        let slopes = Around3x3 { describing: self, own, at, rim, kernel, scratch: RefCell::new(scratch) };
        let (i, j) = slope_steps(&slopes.answered(&raw.pixels()), &slopes);
        let slope = self.grid.at(own.0 as f32 + i, own.1 as f32 + j);
        if placed.is_none() {
            return Keypoint { slope, ..*keypoint };
        }
        Keypoint {
            x: at.0 as f32,
            y: at.1 as f32,
            sigma_octave: scale_peak(&raw.pixels(), at, sigma, self.space.levels, from).unwrap_or(sigma) as f32,
            slope,
            ..*keypoint
        }
    }
}
