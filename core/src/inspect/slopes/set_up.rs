//! From metres to slopes, and from a slope to its depth.
//!
//! A pinhole camera of focal length f (pixels) moves with the speed s (metres per second) parallel to its picture, in a
//! direction φ (degrees from +u towards +v), and turns to the right with ω (radians per second). A still point at the
//! depth z (metres) then moves by
//!
//! ```text
//! λ(z) = −(f·s/z)/r·(cos φ, sin φ) − (f·ω/r)·(1, 0)
//! ```
//!
//! pixels per frame at r frames per second, near the middle of the picture. Motion towards the scene moves points away
//! from the middle, each by its own slope, and has no such line.

use crate::detector::{DetectorParams, Slope, SlopeAxis, SlopeGrid};
use crate::error::{Error, Result};
use crate::{burst::Positions, detector::scale_space::ScaleSpace, inspect::words::number};
use serde::{Deserialize, Serialize};

/// Camera and scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetUp {
    /// Speed of the camera parallel to its picture, metres per second; at least 0.
    pub speed_m_s: f64,
    /// Direction of that motion, degrees from +u (to the right) towards +v (down).
    pub direction_deg: f64,
    /// Turning of the camera to the right, degrees per second.
    pub turn_deg_s: f64,
    /// Frames per second.
    pub frames_per_second: f64,
    /// Focal length, pixels.
    pub focal_px: f64,
    /// Nearest and farthest depth, metres.
    pub depth_m: [f64; 2],
}

impl Default for SetUp {
    /// A walking pace past things one to eight metres away.
    fn default() -> Self {
        let (speed_m_s, direction_deg, turn_deg_s) = (0.5, 0.0, 0.0);
        Self { speed_m_s, direction_deg, turn_deg_s, frames_per_second: 30.0, focal_px: 1200.0, depth_m: [1.0, 8.0] }
    }
}

/// Slopes that a set-up asks for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SetUpSlopes {
    /// Slope of the nearest things, px/frame.
    pub nearest: Slope,
    /// Slope of the farthest things.
    pub farthest: Slope,
    /// Slopes to search: a line that holds both, half a step beyond at either end.
    pub grid: SlopeGrid,
    /// Step that suits the number of frames, px/frame.
    pub step: f32,
}

/// Ranges of the numbers, for options, files and fields of the window.
#[allow(missing_docs)] // each says its unit
pub mod set_up_bounds {
    use crate::detector::params::Bounds;
    use std::ops::Bound::Included;

    pub const SPEED: Bounds = Bounds::new((Included(0.0), Included(1e6)), "give 0 to 1000000 metres per second");
    pub const DIRECTION: Bounds = Bounds::new((Included(-360.0), Included(360.0)), "give -360 to 360 degrees");
    pub const TURN: Bounds =
        Bounds::new((Included(-36_000.0), Included(36_000.0)), "give -36000 to 36000 degrees per second");
    pub const RATE: Bounds = Bounds::new((Included(0.001), Included(1e7)), "give 0.001 to 10000000 frames per second");
    pub const FOCAL: Bounds = Bounds::new((Included(1.0), Included(1e6)), "give 1 to 1000000 pixels, such as 1200");
    pub const DEPTH: Bounds =
        Bounds::new((Included(1e-6), Included(1e6)), "give NEAR:FAR in metres, up to 1000000, such as 1:8");
}

const MAX_COUNT: usize = 1024;

impl SetUp {
    /// Checks the numbers.
    pub fn check(&self) -> Result<()> {
        set_up_bounds::SPEED.check("speed", self.speed_m_s)?;
        set_up_bounds::DIRECTION.check("direction", self.direction_deg)?;
        set_up_bounds::TURN.check("turn-deg-s", self.turn_deg_s)?;
        set_up_bounds::RATE.check("fps", self.frames_per_second)?;
        set_up_bounds::FOCAL.check("focal-px", self.focal_px)?;
        self.depth_m.iter().try_for_each(|&depth| set_up_bounds::DEPTH.check("depth", depth))?;
        let [near, far] = self.depth_m;
        if near > far {
            let remedy = "give NEAR:FAR in metres, such as 1:8".to_owned();
            return Err(Error::param("depth", format!("{near}:{far} is no range"), remedy));
        }
        Ok(())
    }

    /// Slope of a still point at the depth `metres`, near the middle of the picture; infinite for only turning.
    pub fn slope_at(&self, metres: f64) -> Slope {
        let (sin, cos) = self.direction_deg.to_radians().sin_cos();
        let along = -self.focal_px * self.speed_m_s / (metres * self.frames_per_second);
        Slope::new((along * cos + self.turning()) as f32, (along * sin) as f32)
    }

    /// Depth, metres, of a still point that moves at `slope`; `None` where no depth explains it.
    pub fn depth_at(&self, slope: Slope) -> Option<f64> {
        let (sin, cos) = self.direction_deg.to_radians().sin_cos();
        let along = (f64::from(slope.u) - self.turning()) * cos + f64::from(slope.v) * sin;
        let depth = -self.focal_px * self.speed_m_s / (along * self.frames_per_second);
        (depth.is_finite() && depth > 0.0).then_some(depth)
    }

    /// Depth by [`Self::depth_at`], metres, and its standard deviation, of a still point that moves at `slope` with a
    /// standard deviation of `sigma`, pixels per frame.
    pub fn depth_with_error(&self, slope: Slope, sigma: f32) -> Option<[f64; 2]> {
        let depth = self.depth_at(slope)?;
        let along = self.focal_px * self.speed_m_s / (depth * self.frames_per_second);
        Some([depth, depth * (f64::from(sigma) / along).abs()])
    }

    /// Motion by turning, px/frame to the right.
    fn turning(&self) -> f64 {
        -self.focal_px * self.turn_deg_s.to_radians() / self.frames_per_second
    }

    /// The slopes to search in frames at `positions` with the scales of `params`.
    ///
    /// # Errors
    /// As [`Self::check`], and where the motion is too large for a search.
    pub fn slopes(&self, positions: &Positions, params: &DetectorParams) -> Result<SetUpSlopes, String> {
        self.check().map_err(|error| error.to_string())?;
        let [nearest, farthest] = self.depth_m.map(|depth| self.slope_at(depth));
        let space = ScaleSpace::of(params);
        let step = 2.0 * space.sigma_image(space.first_octave, 0.0) / positions.span().max(1.0);
        let (sin, cos) = self.direction_deg.to_radians().sin_cos();
        let along = |slope: Slope| f64::from(slope.u) * cos + f64::from(slope.v) * sin;
        let across = f64::from(farthest.v) * cos - f64::from(farthest.u) * sin;
        let (low, high) = (along(nearest).min(along(farthest)), along(nearest).max(along(farthest)));
        let gaps = ((high - low) / step).ceil();
        if gaps.is_nan() || gaps >= MAX_COUNT as f64 {
            return Err(format!(
                "depth: the motion differs by {high:.0} px/frame less {low:.0}, which takes too many slopes; give a smaller range of depths, or a higher frame rate"
            ));
        }
        let tidy = |x: f64| ((x * 1e3).round() / 1e3) as f32;
        // Half a step beyond at both ends, so that no motion is at the limit.
        let more = 0.5 * step;
        let u = SlopeAxis { min: tidy(low - more), max: tidy(high + more), count: gaps as usize + 2 };
        let v = SlopeAxis { min: tidy(across), max: tidy(across), count: 1 };
        let grid = SlopeGrid { u, v, direction_deg: self.direction_deg as f32 };
        Ok(SetUpSlopes { nearest, farthest, grid, step: step as f32 })
    }
}

impl SetUpSlopes {
    /// Options of the search that set these slopes.
    pub fn options(&self) -> String {
        let SlopeGrid { u, v, direction_deg } = self.grid;
        let across = if v.min == 0.0 { String::new() } else { format!(" --slopes-v {}", v.min) };
        let turned = if direction_deg == 0.0 { String::new() } else { format!(" --slope-direction {direction_deg}") };
        format!("--slopes-u {u}{across}{turned}")
    }

    /// A sentence for people.
    pub fn sentence(&self, set_up: &SetUp) -> String {
        let text = |slope: Slope| format!("({}, {})", number(slope.u, 2), number(slope.v, 2));
        let [near, far] = set_up.depth_m.map(|depth| number(depth as f32, 2));
        let (near_at, far_at) = (text(self.nearest), text(self.farthest));
        let (count, step) = (self.grid.len(), number(self.grid.u.step(), 3));
        format!(
            "things {near} m away move at {near_at} px/frame, things {far} m away at {far_at}; {count} slopes of step {step}"
        )
    }
}
