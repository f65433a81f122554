//! Localisation: a feature's exact place, slope and scale, from the pixels of its own and neighbouring slopes.
//!
//! The quadratic fit of `refine` errs by a tenth of an input pixel even without noise, and neighbours pull. So:
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

use crate::detector::along::around;
use crate::detector::feature::{Feature, Keypoint};
use crate::detector::localise::scale::scale_peak;
use crate::detector::params::{DetectorParams, Localisation, SlopeExtrema, SlopeGrid};
use crate::detector::refine::{peak_offset, peak_offset_2d};
use crate::detector::scale_space::{Base, octave_pixel, octave_size};
use crate::detector::search::setup::{FirstLevels, Search};
use crate::detector::stack::{FrameTimes, interpolation_blur};
use crate::kernel::compact_kernel::{CompactKernel, KernelResponse, PixelView, RIM, SOFT};
use crate::kernel::patch::{Patch, PatchScratch};

/// Buffers for the pixels around a keypoint at other slopes or of a finer octave; reused from keypoint to keypoint.
#[derive(Debug, Default)]
pub(super) struct LocateScratch {
    patch: PatchScratch,
    pixels: Patch,
}

/// Pixels `reach` to each side of `at` at least: a patch made for it, or the octave's first level.
fn pixels_around<'p>(
    base: &Base<'p>,
    size: (usize, usize),
    at: (f64, f64),
    reach: usize,
    scratch: &'p mut LocateScratch,
) -> PixelView<'p> {
    // A held level is read in place; others are made around the keypoint alone.
    if let Base::Level(plane) = base {
        return PixelView::of(plane);
    }
    let (columns, rows) = (around(at.0 as f32, reach), around(at.1 as f32, reach));
    base.patch(size, columns, rows, &mut scratch.patch, &mut scratch.pixels);
    scratch.pixels.pixels()
}

/// Distance, in running slope indices, from a keypoint's slope to the farthest one that its localisation uses.
pub(super) fn slopes_around(params: &DetectorParams, grid: &SlopeGrid) -> usize {
    match params.rules.localisation {
        Localisation::Quadratic => 0,
        Localisation::Continuous => grid.neighbour_distance(),
    }
}

/// Keypoint with refined place, slope and scale, or unchanged with the quadratic fit alone or a failed refinement; and
/// its [width](motion_width) in slope. `raw`: pixels around it, of σ `from`; `bases`: first levels of all octaves.
pub(super) fn located(
    search: &Search<'_>,
    bases: &[FirstLevels],
    keypoint: &Keypoint,
    raw: &Patch,
    from: f64,
    scratch: &mut LocateScratch,
) -> (Keypoint, f32) {
    let spread_frames = search.inputs.times.spread_frames();
    let pixel = octave_pixel(keypoint.octave);
    let round = keypoint.sigma_octave * pixel / spread_frames;
    if search.params.rules.localisation == Localisation::Quadratic {
        return (*keypoint, round);
    }
    let (octave, levels) = (keypoint.octave, search.space.levels);
    let sigma = f64::from(keypoint.sigma_octave);
    let rim = rim_radius(sigma, levels);
    let at = (f64::from(keypoint.x), f64::from(keypoint.y));
    let size = |octave: i32| octave_size(search.inputs.size_image, octave);
    let placed = if octave == search.space.first_octave {
        place(&raw.pixels(), at, rim, FARTHEST_MOVE_PX as f64)
    } else {
        // Pixels of the finer octave are half as large, and less blurred.
        let finer = search.base(bases, octave - 1, keypoint.slope_index);
        let (at, rim) = ((2.0 * at.0, 2.0 * at.1), 2.0 * rim);
        let pixels = pixels_around(&finer, size(octave - 1), at, kernel_reach(rim, 2), scratch);
        place(&pixels, at, rim, 2.0 * FARTHEST_MOVE_PX as f64).map(|((x, y), kernel)| ((0.5 * x, 0.5 * y), kernel))
    };
    let (at, kernel) = match placed {
        Some(found) => found,
        // Without a place by a kernel that of the fit is kept. A joint search has refined the slope already.
        None if search.params.used_extrema() == SlopeExtrema::Joint => return (*keypoint, round),
        None => (at, SOFT),
    };
    let radius = kernel.on_rim(rim);
    let answer_in = |pixels: &PixelView<'_>| pixels.response(&kernel, radius, at, pixels.local_mean(radius, at));
    let sharp = |answer: &KernelResponse, slope_index: usize| {
        let pixel = f64::from(pixel);
        let (u, v) = interpolation_blur(&search.offsets[slope_index]);
        sharpened(answer, (u / (pixel * pixel), v / (pixel * pixel)))
    };
    let grid = &search.grid;
    let own = grid.coordinates(keypoint.slope_index);
    let answer = answer_in(&raw.pixels());
    let width = motion_width(&answer, grid, &search.inputs.times) * pixel / spread_frames;
    let (i, j) = slope_steps(sharp(&answer, keypoint.slope_index), |di, dj| {
        let i = own.0.checked_add_signed(di).filter(|&i| i < grid.u.count)?;
        let j = own.1.checked_add_signed(dj).filter(|&j| j < grid.v.count)?;
        let slope_index = j * grid.u.count + i;
        let base = search.base(bases, octave, slope_index);
        let pixels = pixels_around(&base, size(octave), at, radius.ceil() as usize + 1, scratch);
        Some(sharp(&answer_in(&pixels), slope_index))
    });
    let slope = grid.beside(keypoint.slope_index, i, j);
    // The scale is read at the new place, so without one it stays.
    if placed.is_none() {
        return (Keypoint { slope, ..*keypoint }, width);
    }
    let scale = scale_peak(&raw.pixels(), at, sigma, levels, from).unwrap_or(sigma);
    let keypoint = Keypoint { x: at.0 as f32, y: at.1 as f32, sigma_octave: scale as f32, slope, ..*keypoint };
    (keypoint, width)
}

/// Distance, in pixels of `answer`, at which a wrong motion weakens the response by e^−½, as the standard deviation of
/// its blur: along the line of `grid`, or in a plane in the worst direction. A small blur of variance ε along a
/// direction changes a response R by ε/2 times its second derivative, so the distance is √(−R/R″): σ for a blob of
/// scale σ, infinite along an edge. Views of a light field blur in each direction by their variance there.
fn motion_width(answer: &KernelResponse, grid: &SlopeGrid, times: &FrameTimes) -> f32 {
    let [uu, vv, uv] = answer.hessian.map(|second| -second / answer.value);
    let sharpness = if times.positions.are_views() {
        let [views_uu, views_vv, views_uv] = times.moments().map(f64::from);
        (views_uu * uu + views_vv * vv + 2.0 * views_uv * uv) / (views_uu + views_vv)
    } else if grid.is_plane() {
        // The smaller eigenvalue: the direction in which the motion is known worst.
        0.5 * (uu + vv) - (0.5 * (uu - vv)).hypot(uv)
    } else {
        let (sin, cos) = f64::from(grid.direction_deg).to_radians().sin_cos();
        let (cos, sin) = if grid.u.count < 2 && grid.v.count > 1 { (-sin, cos) } else { (cos, sin) };
        uu * cos * cos + 2.0 * uv * cos * sin + vv * sin * sin
    };
    if sharpness > 0.0 { (1.0 / sharpness).sqrt() as f32 } else { f32::INFINITY }
}

/// Largest distance of the place from the quadratic fit, octave pixels; farther extrema are others.
pub const FARTHEST_MOVE_PX: usize = 1;
/// Maximum number of Newton steps; two or three are usual.
const MAX_STEPS: usize = 6;
/// Step length, in pixels, below which a step is the last.
const SHORT_PX: f64 = 2e-3;

const USUAL_LEVELS: usize = 5;

impl Feature {
    /// Radius of the circle to draw for a feature, input pixels: the rim of the disc to which D responds most strongly
    /// at this scale; 1.51·σ for the usual five levels an octave (four: 1.54·σ, ten: 1.46·σ).
    pub fn circle_radius_px(&self) -> f32 {
        rim_radius(f64::from(self.sigma), USUAL_LEVELS) as f32
    }
}

/// Radius of the rim of the disc to which D with `levels` levels an octave responds most at `sigma`, in its unit.
pub fn rim_radius(sigma: f64, levels: usize) -> f64 {
    let k2 = 2f64.powf(2.0 / levels as f64);
    sigma * (2.0 * k2.ln() / (1.0 - 1.0 / k2)).sqrt()
}

impl CompactKernel {
    /// Radius of the kernel whose zero lies on a rim of radius `rim`.
    pub fn on_rim(&self, rim: f64) -> f64 {
        rim / self.zero_at
    }

    /// Expected error of a place due to noise, up to a common factor of all kernels; infinite where there is no peak.
    fn error(&self, answer: &KernelResponse) -> f64 {
        let sharpness = answer.sharpness();
        if sharpness > 0.0 { self.gradient_noise / sharpness } else { f64::INFINITY }
    }
}

/// Reach, in pixels of which `unit` make an octave pixel, that a rim of radius `rim` needs around a feature.
pub fn kernel_reach(rim: f64, unit: usize) -> usize {
    SOFT.on_rim(rim).ceil() as usize + FARTHEST_MOVE_PX * unit + 1
}

/// Place of a blob of rim radius `rim` within `farthest` of `from`, and the kernel that found it, in `pixels`.
pub fn place(pixels: &PixelView<'_>, from: (f64, f64), rim: f64, farthest: f64) -> Option<((f64, f64), CompactKernel)> {
    let answer = |kernel: &CompactKernel| {
        pixels.response(kernel, kernel.on_rim(rim), from, pixels.local_mean(kernel.on_rim(rim), from))
    };
    // Without a rim, the kernel for rims has a flat peak or none.
    let kernels: &[CompactKernel] =
        if RIM.error(&answer(&RIM)) <= SOFT.error(&answer(&SOFT)) { &[RIM, SOFT] } else { &[SOFT] };
    kernels
        .iter()
        .find_map(|kernel| extremum(pixels, kernel, from, kernel.on_rim(rim), farthest).map(|at| (at, *kernel)))
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
    // One local mean for all steps, so that Newton's method climbs one function.
    let local_mean = pixels.local_mean(radius, (x, y));
    for _ in 0..MAX_STEPS {
        let answer = pixels.response(kernel, radius, (x, y), local_mean);
        if answer.sharpness() <= 0.0 {
            return None;
        }
        let KernelResponse { gradient: [gu, gv], hessian: [uu, vv, uv], .. } = answer;
        let determinant = uu * vv - uv * uv;
        let (du, dv) = ((uv * gv - vv * gu) / determinant, (uv * gu - uu * gv) / determinant);
        let length = du.hypot(dv).max(1e-12);
        // Far steps leave the range in which the quadratic of a compact kernel holds.
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

/// Response without the blur of linear interpolation, of variances `blur` (u, v), square pixels.
fn sharpened(answer: &KernelResponse, blur: (f64, f64)) -> f32 {
    (answer.value - 0.5 * (blur.0 * answer.hessian[0] + blur.1 * answer.hessian[1])) as f32
}

/// Offset of the strongest slope from the slope with response `middle`, in steps along both axes, within ±1; 0 on an
/// axis without two neighbours. `value` is the response (di, dj) steps away, `None` beyond the grid.
fn slope_steps(middle: f32, mut value: impl FnMut(isize, isize) -> Option<f32>) -> (f32, f32) {
    let along_i = (value(-1, 0), value(1, 0));
    let along_j = (value(0, -1), value(0, 1));
    let peak = |(before, after): (Option<f32>, Option<f32>)| {
        before.zip(after).map_or(0.0, |(before, after)| peak_offset(before, middle, after))
    };
    match (along_i, along_j) {
        ((Some(left), Some(right)), (Some(above), Some(below))) => {
            let mut corner = |di, dj| value(di, dj).unwrap_or(0.0);
            peak_offset_2d([
                [corner(-1, -1), above, corner(1, -1)],
                [left, middle, right],
                [corner(-1, 1), below, corner(1, 1)],
            ])
        }
        // On a line or at the edge of a plane each axis is by itself.
        _ => (peak(along_i), peak(along_j)),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::plane::Plane;
    use crate::synth::chart::draw_disc;

    /// A dark blob of standard deviation `sigma` at (x, y).
    pub fn blob(sigma: f64, x: f64, y: f64) -> Plane {
        let s2 = 2.0 * sigma * sigma;
        Plane::from_fn(80, 70, |u, v| {
            (0.3 - 0.2 * (-((u as f64 - x).powi(2) + (v as f64 - y).powi(2)) / s2).exp()) as f32
        })
    }

    #[test]
    fn a_blob_is_found_to_a_thousandth_of_a_pixel() {
        for (x, y) in [(40.0, 35.0), (40.3, 34.6), (39.51, 35.49)] {
            let (found, _) =
                place(&PixelView::of(&blob(2.5, x, y)), (40.2, 34.9), rim_radius(2.5, 3), 1.0).expect("a clean blob");
            assert!((found.0 - x).abs() < 1e-3 && (found.1 - y).abs() < 1e-3, "{found:?} for {x} {y}");
        }
    }

    #[test]
    fn a_neighbour_two_radii_away_does_not_pull() {
        let mut plane = Plane::zeros(80, 70);
        draw_disc(&mut plane, 40.0, 35.0, 6.0, 1.0);
        draw_disc(&mut plane, 58.0, 35.0, 6.0, 1.0);
        let (found, kernel) = place(&PixelView::of(&plane), (40.3, 34.9), 6.0, 1.0).expect("a disc");
        assert_eq!(kernel, RIM);
        assert!((found.0 - 40.0).abs() < 1e-3 && (found.1 - 35.0).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn nothing_is_located_on_a_slope_or_beyond_a_pixel() {
        let ramp = Plane::from_fn(80, 70, |u, v| (u + 2 * v) as f32 * 0.003);
        let at = |plane: &Plane, x: f64| place(&PixelView::of(plane), (x, 35.0), rim_radius(2.5, 3), 1.0);
        assert_eq!(at(&ramp, 40.0), None);
        assert_eq!(at(&blob(2.5, 44.0, 35.0), 40.0), None);
    }

    /// Steps to the peak (0.3, −0.2) of responses that fall off like a Gaussian of two steps, with a `blur` at odd
    /// steps along u and at even ones along v, but none at the step `missing`.
    fn steps_to_peak(blur: (f64, f64), missing: (isize, isize)) -> (f32, f32) {
        let value = |di: isize, dj: isize| {
            let sharp = (-((di as f64 - 0.3).powi(2) + (dj as f64 + 0.2).powi(2)) / 8.0).exp();
            let blur = (blur.0 * di.rem_euclid(2) as f64, blur.1 * (dj + 1).rem_euclid(2) as f64);
            let hessian = [-0.08 * sharp, -0.05 * sharp, 0.0];
            let value = sharp + 0.5 * (blur.0 * hessian[0] + blur.1 * hessian[1]);
            sharpened(&KernelResponse { value, gradient: [0.0; 2], hessian }, blur)
        };
        slope_steps(value(0, 0), |di, dj| ((di, dj) != missing).then(|| value(di, dj)))
    }

    #[test]
    fn slopes_are_interpolated_between_neighbours_whatever_interpolation_blurs() {
        for blur in [(0.0, 0.0), (0.25, 0.0), (0.25, 0.25)] {
            let (i, j) = steps_to_peak(blur, (9, 9));
            assert!((i - 0.3).abs() < 2e-3 && (j + 0.2).abs() < 2e-3, "{i} {j} {blur:?}");
        }
        // An axis that ends keeps the slope of the grid.
        let (i, j) = steps_to_peak((0.0, 0.0), (0, 1));
        assert!((i - 0.3).abs() < 2e-3 && j == 0.0, "{i} {j}");
    }
}
