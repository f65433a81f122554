//! Localisation: a feature's exact place, slope and scale, from the pixels of its own and neighbouring slopes.
//!
//! The quadratic fit of [`crate::detector::refine`] uses 27 samples of D one octave pixel apart. That leaves errors of
//! a tenth of an input pixel even without noise, and the long tails of D's Gaussians let neighbours pull. So, starting
//! from the fit:
//!
//! - **Place**: the extremum of a kernel (`crate::kernel::compact_kernel`) whose zero lies where D's own scale puts a
//!   blob's rim, by Newton's steps on the pixels of the feature's own slope. Of the kernel for blobs with a rim and the
//!   soft one, which resembles D, the one with the smaller expected error is taken: its noise over its curvature here.
//!   That is the former for discs, crowded or not, and the latter for most structures of a photograph. The finer octave
//!   is used where there is one: its pixels are sharper.
//! - **Scale**: the largest |D| at that place ([`crate::detector::localise::scale`]).
//! - **Slope**: the peak of the parabola through the logarithms of the kernel's responses at that place at the
//!   neighbouring slopes. Frames that are shifted by a fraction f of a pixel are blurred by linear interpolation, with
//!   variance f(1 − f), which makes responses at slopes of whole pixels stronger than at others: a bias of up to 0.03
//!   px/frame. A blur of variance τ changes a response by τ/2 times its second derivative, so that is subtracted.

pub mod scale;

use crate::detector::describe::patch::{Describing, around};
use crate::detector::feature::{Feature, Keypoint};
use crate::detector::localise::scale::scale_peak;
use crate::detector::params::slope_grid::SlopeGrid;
use crate::detector::params::{DetectorParams, Localisation, SlopeExtrema};
use crate::detector::refine::{peak_offset, peak_offset_2d};
use crate::detector::scale_space::{Base, octave_pixel, octave_size};
use crate::detector::stack::interpolation_blur;
use crate::kernel::compact_kernel::{CompactKernel, KernelResponse, PixelView, RIM, SOFT};
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
    match params.rules.localisation {
        Localisation::Quadratic => 0,
        Localisation::Continuous => grid.neighbour_distance(),
    }
}

impl Describing<'_> {
    /// The keypoint with refined place, slope and scale, or unchanged where the parameters ask for the quadratic fit
    /// alone or the refinement fails. `raw` holds the pixels around it.
    pub(super) fn located(&self, keypoint: &Keypoint, raw: &Patch, from: f64, scratch: &mut LocateScratch) -> Keypoint {
        if self.params.rules.localisation == Localisation::Quadratic {
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
            None if self.params.used_extrema() == SlopeExtrema::Joint => return *keypoint,
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

/// Largest distance of the place from the quadratic fit, octave pixels; beyond it, it is not the same extremum.
pub const FARTHEST_MOVE_PX: usize = 1;
/// Maximum number of Newton steps; two or three are usual.
const MAX_STEPS: usize = 6;
/// Step length, in pixels, below which a step is the last.
const SHORT_PX: f64 = 2e-3;

/// Levels of the default parameters.
const USUAL_LEVELS: usize = 5;

impl Feature {
    /// Radius of the circle that stands for it, input pixels: the rim of the disc to which D responds most strongly at
    /// its scale; 1.51·σ for the usual five levels an octave (four: 1.54·σ, ten: 1.46·σ).
    pub fn circle_radius_px(&self) -> f32 {
        rim_radius(f64::from(self.sigma), USUAL_LEVELS) as f32
    }
}

/// Radius of the rim of a feature of scale `sigma` found with `levels` levels an octave, in the units of `sigma`: that
/// of the disc to which D responds most strongly at that scale.
pub fn rim_radius(sigma: f64, levels: usize) -> f64 {
    let k2 = 2f64.powf(2.0 / levels as f64);
    sigma * (2.0 * k2.ln() / (1.0 - 1.0 / k2)).sqrt()
}

impl CompactKernel {
    /// Radius of the kernel whose zero lies on a rim of radius `rim`.
    pub fn on_rim(&self, rim: f64) -> f64 {
        rim / self.zero_at
    }

    /// Expected error of a place due to noise, up to a factor that all kernels share; infinite where there is no peak.
    fn error(&self, answer: &KernelResponse) -> f64 {
        let sharpness = answer.sharpness();
        if sharpness > 0.0 { self.gradient_noise / sharpness } else { f64::INFINITY }
    }
}

/// Reach of the pixels that a rim of radius `rim` needs around a feature, when `unit` of them make an octave pixel.
pub fn kernel_reach(rim: f64, unit: usize) -> usize {
    SOFT.on_rim(rim).ceil() as usize + FARTHEST_MOVE_PX * unit + 1
}

/// Place of a blob near `start` with a rim of radius `rim`, not farther than `farthest`, and the kernel that found it;
/// all in pixels of `pixels`. `None` where there is none.
pub fn place(
    pixels: &PixelView<'_>,
    start: (f64, f64),
    rim: f64,
    farthest: f64,
) -> Option<((f64, f64), CompactKernel)> {
    let answer = |kernel: &CompactKernel| {
        pixels.kernel_response(kernel, kernel.on_rim(rim), start, pixels.local_mean(kernel.on_rim(rim), start))
    };
    // Where there is no rim, the kernel for rims has a flat peak, or none.
    let kernels: &[CompactKernel] =
        if RIM.error(&answer(&RIM)) <= SOFT.error(&answer(&SOFT)) { &[RIM, SOFT] } else { &[SOFT] };
    kernels
        .iter()
        .find_map(|kernel| extremum(pixels, kernel, start, kernel.on_rim(rim), farthest).map(|at| (at, *kernel)))
}

/// Extremum of the response of `kernel` of `radius` near (x0, y0), not farther than `farthest`.
fn extremum(
    pixels: &PixelView<'_>,
    kernel: &CompactKernel,
    (x0, y0): (f64, f64),
    radius: f64,
    farthest: f64,
) -> Option<(f64, f64)> {
    let (mut x, mut y) = (x0, y0);
    let local_mean = pixels.local_mean(radius, (x, y));
    for _ in 0..MAX_STEPS {
        let answer = pixels.kernel_response(kernel, radius, (x, y), local_mean);
        if answer.sharpness() <= 0.0 {
            return None;
        }
        let KernelResponse { gradient: [gu, gv], hessian: [uu, vv, uv], .. } = answer;
        let determinant = uu * vv - uv * uv;
        let (du, dv) = ((uv * gv - vv * gu) / determinant, (uv * gu - uu * gv) / determinant);
        let length = du.hypot(dv).max(1e-12);
        let damp = (0.1 * radius / length).min(1.0);
        (x, y) = (x + damp * du, y + damp * dv);
        if (x - x0).hypot(y - y0) > farthest {
            return None;
        }
        if length < SHORT_PX {
            break;
        }
    }
    Some((x, y))
}

/// Responses of a kernel at the neighbouring slopes.
pub trait Neighbours {
    /// Response at the neighbouring slope (di, dj) of the grid; `None` beyond the grid.
    fn answer(&self, di: i32, dj: i32) -> Option<KernelResponse>;
    /// Variances (along u, along v) of the blur of linear interpolation at that slope, in square pixels of the
    /// response.
    fn blur(&self, di: i32, dj: i32) -> (f64, f64);
}

/// Offset of the strongest slope from the grid's slope whose response at the feature's place is `here`, in steps along
/// both axes, within ±1; 0 on an axis where a neighbour is missing.
pub fn slope_steps(here: &KernelResponse, neighbours: &impl Neighbours) -> (f32, f32) {
    let sharp = |answer: &KernelResponse, di: i32, dj: i32| {
        let (along_u, along_v) = neighbours.blur(di, dj);
        (answer.value - 0.5 * (along_u * answer.hessian[0] + along_v * answer.hessian[1])) as f32
    };
    let middle = sharp(here, 0, 0);
    let value = |di: i32, dj: i32| neighbours.answer(di, dj).map(|there| sharp(&there, di, dj));
    let peak = |before: Option<f32>, after: Option<f32>| match (before, after) {
        (Some(before), Some(after)) => peak_offset(before, middle, after),
        _ => 0.0,
    };
    let along_i = (value(-1, 0), value(1, 0));
    let along_j = (value(0, -1), value(0, 1));
    match (along_i, along_j) {
        ((Some(left), Some(right)), (Some(above), Some(below))) => {
            let corner = |di, dj| value(di, dj).unwrap_or(0.0);
            peak_offset_2d([
                [corner(-1, -1), above, corner(1, -1)],
                [left, middle, right],
                [corner(-1, 1), below, corner(1, 1)],
            ])
        }
        _ => (peak(along_i.0, along_i.1), peak(along_j.0, along_j.1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Plane;
    use crate::synth::chart::draw_disc;

    fn pixels(plane: &Plane) -> PixelView<'_> {
        PixelView::of(plane)
    }

    /// A dark blob of standard deviation `sigma` at (x, y).
    fn blob(sigma: f64, x: f64, y: f64) -> Plane {
        let s2 = 2.0 * sigma * sigma;
        Plane::from_fn(80, 70, |u, v| {
            (0.3 - 0.2 * (-((u as f64 - x).powi(2) + (v as f64 - y).powi(2)) / s2).exp()) as f32
        })
    }

    #[test]
    fn a_blob_is_found_to_a_thousandth_of_a_pixel() {
        for (x, y) in [(40.0, 35.0), (40.3, 34.6), (39.51, 35.49)] {
            let (found, _) =
                place(&pixels(&blob(2.5, x, y)), (40.2, 34.9), rim_radius(2.5, 3), 1.0).expect("a clean blob");
            assert!((found.0 - x).abs() < 1e-3 && (found.1 - y).abs() < 1e-3, "{found:?} for {x} {y}");
        }
    }

    #[test]
    fn a_neighbour_two_radii_away_does_not_pull() {
        let mut plane = Plane::zeros(80, 70);
        draw_disc(&mut plane, 40.0, 35.0, 6.0, 1.0);
        draw_disc(&mut plane, 58.0, 35.0, 6.0, 1.0);
        let (found, kernel) = place(&pixels(&plane), (40.3, 34.9), 6.0, 1.0).expect("a disc");
        assert_eq!(kernel, RIM);
        assert!((found.0 - 40.0).abs() < 1e-3 && (found.1 - 35.0).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn nothing_is_located_on_a_slope_or_beyond_a_pixel() {
        let ramp = Plane::from_fn(80, 70, |u, v| (u + 2 * v) as f32 * 0.003);
        let at = |plane: &Plane, x: f64| place(&pixels(plane), (x, 35.0), rim_radius(2.5, 3), 1.0);
        assert_eq!(at(&ramp, 40.0), None);
        assert_eq!(at(&blob(2.5, 44.0, 35.0), 40.0), None);
    }

    /// Responses that fall off from a peak like a Gaussian of two steps, blurred as given at even and odd steps.
    struct Bump {
        peak: (f32, f32),
        blur: (f64, f64),
        missing: (i32, i32),
    }

    impl Bump {
        const HESSIAN: [f64; 3] = [-0.08, -0.05, 0.0];

        fn at(&self, di: i32, dj: i32) -> KernelResponse {
            let d2 =
                (f64::from(di) - f64::from(self.peak.0)).powi(2) + (f64::from(dj) - f64::from(self.peak.1)).powi(2);
            let sharp = (-d2 / 8.0).exp();
            let (u, v) = self.blur(di, dj);
            let share = 1.0 + 0.5 * (u * Self::HESSIAN[0] + v * Self::HESSIAN[1]);
            KernelResponse { value: sharp * share, gradient: [0.0; 2], hessian: Self::HESSIAN.map(|h| sharp * h) }
        }
    }

    impl Neighbours for Bump {
        fn answer(&self, di: i32, dj: i32) -> Option<KernelResponse> {
            ((di, dj) != self.missing).then(|| self.at(di, dj))
        }
        fn blur(&self, di: i32, dj: i32) -> (f64, f64) {
            (self.blur.0 * f64::from(di.rem_euclid(2)), self.blur.1 * f64::from((dj + 1).rem_euclid(2)))
        }
    }

    #[test]
    fn slopes_are_interpolated_between_neighbours_whatever_interpolation_blurs() {
        for blur in [(0.0, 0.0), (0.25, 0.0), (0.25, 0.25)] {
            let bump = Bump { peak: (0.3, -0.2), blur, missing: (9, 9) };
            let (i, j) = slope_steps(&bump.at(0, 0), &bump);
            assert!((i - 0.3).abs() < 2e-3 && (j + 0.2).abs() < 2e-3, "{i} {j} {blur:?}");
        }
    }

    #[test]
    fn an_axis_that_ends_keeps_the_slope_of_the_grid() {
        let bump = Bump { peak: (0.3, -0.2), blur: (0.0, 0.0), missing: (0, 1) };
        let (i, j) = slope_steps(&bump.at(0, 0), &bump);
        assert!((i - 0.3).abs() < 2e-3 && j == 0.0, "{i} {j}");
    }
}
