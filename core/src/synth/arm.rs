//! An arm: a textured thing that hides the left of all frames and stands still, as a robot's arm before its camera.

use super::paint::fractal_relief;
use super::truth::{FeatureTruth, Truth};
use crate::burst::Burst;
use crate::error::{Error, Result};
use crate::plane::{Mask, Plane};
use std::sync::Arc;

/// Edge of an arm, which covers the columns before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arm {
    columns: usize,
    /// Signal in its middle.
    level: f32,
    seed: u64,
}

/// Share of the columns that an arm may hide.
const LARGEST: f64 = 0.9;
/// Largest spots of the texture, pixels.
const SPOTS_PX: f32 = 24.0;
/// Share of a disc of twice a thing's σ that must be seen over all frames, as the detector asks for.
const SEEN: f64 = 0.8;

impl Arm {
    /// The arm that hides a `share` of `width` columns of a scene of about `level`; an error if too little is left.
    pub(super) fn new(share: f64, width: usize, level: f64, seed: u64) -> Result<Self> {
        if !(0.0..=LARGEST).contains(&share) {
            let remedy = format!("give 0 to {LARGEST}, the share of the columns that is hidden");
            return Err(Error::param("mask", format!("{share} of the columns"), remedy));
        }
        Ok(Self { columns: (share * width as f64).round() as usize, level: level as f32, seed })
    }

    pub(super) fn draw_over(&self, signal: &mut Plane) {
        for v in 0..signal.height() {
            for (u, value) in signal.row_mut(v)[..self.columns].iter_mut().enumerate() {
                // Textured, so that a search without the mask finds features in it, all at slope 0.
                let relief = fractal_relief(self.seed ^ 0xa2, u as f32, v as f32, SPOTS_PX, 4);
                *value = self.level * (0.2 + 1.6 * relief);
            }
        }
    }

    pub(super) fn truth(&self, truth: Truth) -> Truth {
        let offsets = truth.offsets();
        let edge = self.columns as f64 - 0.5;
        let is_seen = |feature: &FeatureTruth| {
            // The mean over the frames, as the detector judges places below masks.
            let shares = offsets.iter().map(|at| share_right_of(edge, feature.position(*at).0, 2.0 * feature.sigma));
            self.columns == 0 || shares.sum::<f64>() >= SEEN * offsets.len() as f64
        };
        let features = truth.features.into_iter().filter(is_seen).collect();
        Truth { mask_columns: self.columns, features, ..truth }
    }
}

/// Share of a disc around column `u` that lies right of an `edge`.
fn share_right_of(edge: f64, u: f64, radius: f64) -> f64 {
    let x = ((edge - u) / radius).clamp(-1.0, 1.0);
    (libm::acos(x) - x * (1.0 - x * x).sqrt()) / std::f64::consts::PI
}

impl Truth {
    /// Mask of what the arm hides in all frames; `None` without one.
    pub fn mask(&self) -> Option<Arc<Mask>> {
        let seen = |u: usize, _| f32::from(u >= self.mask_columns);
        (self.mask_columns > 0).then(|| Mask::new(Plane::from_fn(self.width, self.height, seen))).flatten()
    }

    /// This burst of the truth with what the arm hides masked.
    #[must_use]
    pub fn masked(&self, burst: Burst) -> Burst {
        let Some(mask) = self.mask() else { return burst };
        let frame = |frame: &Arc<Plane>| Arc::new(Plane::clone(frame).masked(Some(mask.clone())));
        Burst { frames: burst.frames.iter().map(frame).collect(), ..burst }
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn shares_of_discs_are_those_of_their_areas() {
        for (u, share) in [(20.0, 1.0), (10.0, 0.5), (0.0, 0.0)] {
            assert!((share_right_of(10.0, u, 5.0) - share).abs() < 1e-12);
        }
        let sides = share_right_of(10.0, 12.0, 5.0) + share_right_of(10.0, 8.0, 5.0);
        assert!((sides - 1.0).abs() < 1e-12 && share_right_of(10.0, 12.0, 5.0) > 0.7);
    }
}
