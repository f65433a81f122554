//! Order of the candidates near a place.

use super::fate::Fate;
use crate::detector::{Slope, Trail};
use serde::Serialize;

/// Distance from the place, input pixels, within which candidates count as equally near: a click is no more exact.
pub const AT_PLACE_PX: f32 = 3.0;
/// Distance and σ, input pixels, above which a candidate beside the place is a larger blob.
pub(super) const LARGE_PX: f32 = 8.0;
/// Ratio of two scales within which they count as the same.
const SAME_SCALE: f32 = 1.3;
/// Largest ratio of two scales of one blob.
const LIKE_SCALE: f32 = 2.5;

/// Motion of a place, known apart from the search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PlaceMotion {
    /// Its slope, px/frame.
    pub slope: Slope,
    /// Standard deviation of that slope in each direction, px/frame.
    pub sigma: f32,
}

/// Place, scale and slopes near which candidates come first.
#[derive(Debug, Clone)]
pub(super) struct Nearness {
    /// (u, v), input pixels.
    pub place: [f32; 2],
    /// Scale σ, input pixels; `None` for all alike.
    pub sigma: Option<f32>,
    /// Slopes, px/frame, those of the first candidates first.
    pub slopes: Vec<Slope>,
}

impl Nearness {
    pub fn distance(&self, fate: &Fate) -> f32 {
        (fate.pos_image[0] - self.place[0]).hypot(fate.pos_image[1] - self.place[1])
    }

    pub fn is_here(&self, fate: &Fate) -> bool {
        self.distance(fate) <= AT_PLACE_PX
    }

    /// Index of the first of the slopes that the candidate moves by; their number for any other motion.
    pub fn class(&self, trail: &Trail, fate: &Fate) -> usize {
        let moves_by = |slope: &Slope| is_same_motion(trail, fate.slope, *slope, fate.sigma);
        self.slopes.iter().position(moves_by).unwrap_or(self.slopes.len())
    }

    /// The larger of the candidate's scale and the given one over the smaller; 1 without a given one.
    fn scale_ratio(&self, fate: &Fate) -> f32 {
        self.sigma.map_or(1.0, |sigma| ratio(fate.sigma, sigma))
    }

    fn is_larger(&self, fate: &Fate) -> bool {
        let own_scale = self.sigma.filter(|_| self.scale_ratio(fate) <= SAME_SCALE);
        match own_scale {
            _ if self.is_here(fate) => false,
            Some(sigma) => self.distance(fate) > sigma.max(LARGE_PX),
            None => self.distance(fate) > LARGE_PX || fate.sigma > LARGE_PX,
        }
    }

    /// Distance in place and scale together, at least 1.
    fn apart(&self, fate: &Fate) -> f32 {
        (self.distance(fate) / AT_PLACE_PX).max(1.0) * (self.scale_ratio(fate) / SAME_SCALE).max(1.0)
    }

    /// Sorts candidates as [`super::Probe::fates`]; returns the number of those before the larger blobs.
    pub fn sort(&self, trail: &Trail, fates: &mut [Fate]) -> usize {
        let motion = |fate: &Fate| if self.is_here(fate) { self.class(trail, fate) } else { self.slopes.len() + 1 };
        fates.sort_by(|a, b| {
            (self.is_larger(a).cmp(&self.is_larger(b)))
                .then(motion(a).cmp(&motion(b)))
                .then(self.apart(a).total_cmp(&self.apart(b)))
                .then(b.is_kept().cmp(&a.is_kept()))
                .then(strength(b).total_cmp(&strength(a)))
        });
        fates.partition_point(|fate| !self.is_larger(fate))
    }
}

/// Strength of a candidate among others: its SNR, or |D| in a burst without noise.
pub(super) fn strength(fate: &Fate) -> f32 {
    if fate.snr.is_finite() { fate.snr } else { fate.value.abs() }
}

/// Whether two scales σ may be of one blob.
pub(super) fn is_like_scale(a: f32, b: f32) -> bool {
    ratio(a, b) <= LIKE_SCALE
}

fn ratio(a: f32, b: f32) -> f32 {
    (a / b).max(b / a)
}

/// Whether two slopes are under a step of the grid apart on each axis, or a blob of `sigma` input px cannot tell them.
pub(crate) fn is_same_motion(trail: &Trail, a: Slope, b: Slope, sigma: f32) -> bool {
    let grid = trail.params().used_slopes();
    let ((i, j), (k, l)) = (grid.position(a), grid.position(b));
    let is_near = (i - k).abs() < 1.0 && (j - l).abs() < 1.0;
    is_near || (a.u - b.u).hypot(a.v - b.v) <= motion_limit(sigma, trail.frames().2.span())
}

/// Largest difference, pixels per frame, of a feature's slope from a disc's that counts as the same motion.
pub const MOTION_PX: f32 = 0.35;

/// Largest difference of slopes, pixels per frame, that counts as the same motion for a blob of scale `sigma` (pixels)
/// in a burst of `span` frame intervals from its first to its last frame: [`MOTION_PX`], or that by which the burst
/// smears it over one σ, if this is more.
pub fn motion_limit(sigma: f32, span: f64) -> f32 {
    MOTION_PX.max(sigma / span.max(1.0) as f32)
}
