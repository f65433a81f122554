//! Ascent: the exact maximum of |D| over place and scale, from the pixels of an octave's first level.
//!
//! The samples of a coarse octave lie 2^o input pixels apart, and a fit depends on where they fall on a blob: a burst
//! cropped by a pixel would keep other keypoints. So in octaves after the first the fit only starts an ascent. D at any
//! place and scale is the difference of two sums of pixels under Gaussians; their jets (`crate::kernel::gaussian_jet`)
//! give its derivatives over place and, by ∂G/∂σ = σ∇²G, over ln σ. Newton's steps reach the maximum.

use crate::detector::scale_space::ScaleSpace;
use crate::kernel::compact_kernel::{PixelView, RIM};
use crate::kernel::gaussian_jet::{Jet, JetPixels};
use nalgebra::{Cholesky, Matrix3, Vector3};
use std::cell::RefCell;
use std::ops::Range;

/// Source of exact values of D: an octave's first level at one slope.
#[derive(Debug, Clone, Copy)]
pub struct FirstLevel<'a> {
    pub pixels: PixelView<'a>,
    /// Octave pixels.
    pub sigma: f64,
    pub space: &'a ScaleSpace,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Octave pixels.
    pub x: f64,
    pub y: f64,
    /// DoG level index (1 is level 0).
    pub level: f64,
    pub value: f64,
    /// Second derivatives of D in the image: uu, uv, vv.
    pub curvature: [f64; 3],
}

/// Radius at which the Gaussians are cut, in standard deviations of the wider one at the start.
const CUT: f64 = 3.5;
/// Smallest variance beyond the first level's, octave pixels²: finer Gaussians show too little of the structure.
const MIN_VARIANCE: f64 = 0.3;
const MAX_STEPS: usize = 4;
/// Length of a step after which no other evaluation is needed: the parabola's peak is exact to a thousandth.
const SHORT_PX: f64 = 0.1;
const LONGEST_PX: f64 = 0.7;
/// Largest distance from the start, octave pixels.
pub const FARTHEST_PX: f64 = 2.5;

thread_local! {
    static PIXELS: RefCell<JetPixels> = RefCell::default();
}

impl FirstLevel<'_> {
    /// Maximum of sign·D to which the ascent from column `x`, row `y` and DoG level index `level` leads; `None` where D
    /// is not peaked on the way, or the ascent leaves the level indices `within` or does not converge nearby.
    pub fn ascend(&self, start: (f64, f64), level: f64, within: Range<f64>, sign: f64) -> Option<Peak> {
        PIXELS.with_borrow_mut(|pixels| {
            let levels = self.space.levels as f64;
            let k2 = 4f64.powf(1.0 / levels);
            let own = self.sigma * self.sigma;
            let log_sigma = |level: f64| self.space.sigma_octave(level - 1.0).ln();
            let finest = 0.5 * (own + MIN_VARIANCE).ln();
            let begin = log_sigma(level).max(finest);
            let unit = begin.exp();
            let radius = (CUT * (k2 * unit * unit - own).sqrt()).ceil() as usize + 1;
            // Without the local mean, cutting the Gaussians off would count as structure.
            let local_mean = self.pixels.local_mean(RIM.on_rim(std::f64::consts::SQRT_2 * unit), start);
            pixels.read(&self.pixels, (start.0.round() as i64, start.1.round() as i64), radius, local_mean);
            let (mut x, mut y, mut log) = (start.0, start.1, begin);
            for _ in 0..MAX_STEPS {
                let sigma2 = (2.0 * log).exp();
                let [fine, coarse] = pixels.jets((x, y), [sigma2 - own, k2 * sigma2 - own]);
                let d = Derivatives::of(&fine, sigma2, &coarse, k2 * sigma2);
                if sign * d.value <= 0.0 {
                    return None;
                }
                // Lengths along ln σ in units of σ, so that all three axes are alike.
                let gradient = Vector3::new(d.x, d.y, d.log / unit) * sign;
                let (x_log, y_log, log_log) = (d.x_log / unit, d.y_log / unit, d.log_log / (unit * unit));
                let bend = -sign * Matrix3::new(d.xx, d.xy, x_log, d.xy, d.yy, y_log, x_log, y_log, log_log);
                // Cholesky fails exactly where D is no peak in place and scale: there Newton's step leads nowhere.
                let step = Cholesky::new(bend)?.solve(&gradient);
                let level = 1.0 + levels * ((log + step.z / unit).exp() / self.space.sigma_octave(0.0)).log2();
                if !within.contains(&level) {
                    return None;
                }
                let length = step.norm();
                // Beyond the finest scale that the pixels show, the parabola's peak is taken as it is.
                let ends_there = log <= finest && step.z < 0.0 && step.xy().norm() < SHORT_PX;
                if length < SHORT_PX || ends_there {
                    let value = d.value + 0.5 * sign * gradient.dot(&step);
                    return Some(Peak { x: x + step.x, y: y + step.y, level, value, curvature: [d.xx, d.xy, d.yy] });
                }
                // Longer steps leave the range of the quadratic, and might end on another blob.
                let step = step * (LONGEST_PX / length).min(1.0);
                (x, y, log) = (x + step.x, y + step.y, (log + step.z / unit).max(finest));
                if (x - start.0).hypot(y - start.1) > FARTHEST_PX {
                    return None;
                }
            }
            None
        })
    }
}

/// D and its derivatives over place and `log` = ln σ.
struct Derivatives {
    value: f64,
    x: f64,
    y: f64,
    log: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    x_log: f64,
    y_log: f64,
    log_log: f64,
}

impl Derivatives {
    /// Derivatives of a difference of Gaussians by its jets and squared scales, with ∂G/∂ln σ = σ²∇²G.
    fn of(fine: &Jet, fine2: f64, coarse: &Jet, coarse2: f64) -> Self {
        let both = |of: &dyn Fn(&Jet, f64) -> f64| of(coarse, coarse2) - of(fine, fine2);
        // A Gaussian changes with ln σ by σ² times its Laplacian: derivatives in place give those in scale.
        let laplacian = |j: &Jet, p: usize, q: usize| j[p + 2][q] + j[p][q + 2];
        Self {
            value: both(&|j, _| j[0][0]),
            x: both(&|j, _| j[1][0]),
            y: both(&|j, _| j[0][1]),
            log: both(&|j, s2| s2 * laplacian(j, 0, 0)),
            xx: both(&|j, _| j[2][0]),
            xy: both(&|j, _| j[1][1]),
            yy: both(&|j, _| j[0][2]),
            x_log: both(&|j, s2| s2 * laplacian(j, 1, 0)),
            y_log: both(&|j, s2| s2 * laplacian(j, 0, 1)),
            log_log: both(&|j, s2| 2.0 * s2 * laplacian(j, 0, 0) + s2 * s2 * (laplacian(j, 2, 0) + laplacian(j, 0, 2))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::localise::tests::blob;
    use crate::plane::Plane;

    fn space() -> ScaleSpace {
        ScaleSpace::new(5, 0, 4.0)
    }

    /// Ascends to the maximum of sign·D on `plane`, a first level.
    fn ascend(plane: &Plane, start: (f64, f64), level: f64, sign: f64) -> Option<Peak> {
        let space = space();
        FirstLevel { pixels: PixelView::of(plane), sigma: 1.6, space: &space }.ascend(start, level, -9.0..9.0, sign)
    }

    #[test]
    fn a_blob_has_its_place_scale_and_value_wherever_the_samples_fall() {
        let k = 2f64.powf(0.2);
        for sigma in [2.6, 3.1, 3.7] {
            let own2 = sigma * sigma - 1.6 * 1.6;
            let (expected_sigma, expected) = ((own2 / k).sqrt(), 0.2 * sigma * sigma / own2 * (k - 1.0) / (k + 1.0));
            let level = 1.0 + 5.0 * (expected_sigma / space().sigma_octave(0.0)).log2();
            for (x, y) in [(40.0, 35.0), (40.5, 35.5), (40.3, 34.6), (39.51, 35.49)] {
                for start_level in [level - 0.6, level, level + 0.6] {
                    let found = ascend(&blob(sigma, x, y), (40.0, 35.0), start_level, 1.0).expect("a clean blob");
                    assert!((found.x - x).abs() < 0.01 && (found.y - y).abs() < 0.01, "{found:?} for {x} {y}");
                    assert!((found.level - level).abs() < 0.06, "{found:?} for level {level}");
                    assert!((found.value / expected - 1.0).abs() < 0.01, "{found:?} for {expected}");
                    let [uu, uv, vv] = found.curvature;
                    assert!(uu < 0.0 && (uu / vv - 1.0).abs() < 0.01 && (uv / uu).abs() < 0.01, "{found:?}");
                }
            }
        }
    }

    #[test]
    fn a_blob_finer_than_the_octave_is_placed_below_its_first_level() {
        let found = ascend(&blob(2.1, 40.2, 34.9), (40.0, 35.0), 1.0, 1.0).expect("a clean blob");
        assert!(found.level < 0.5, "{found:?}");
    }

    #[test]
    fn there_is_no_peak_of_the_other_sign_on_a_ramp_or_far_away() {
        let ramp = Plane::from_fn(80, 70, |u, v| (u + 2 * v) as f32 * 0.003);
        assert_eq!(ascend(&ramp, (40.0, 35.0), 2.0, 1.0), None);
        assert_eq!(ascend(&blob(3.0, 40.0, 35.0), (40.0, 35.0), 2.0, -1.0), None);
        assert_eq!(ascend(&blob(3.0, 45.0, 35.0), (40.5, 35.0), 2.0, 1.0), None);
    }
}
