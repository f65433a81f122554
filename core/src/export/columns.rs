//! The columns of a feature table, shared by the CSV file and the `features` array of the `.npz` file.

use crate::detector::Feature;

/// Names of the columns, in order. Positions and scale are in input pixels; orientation in radians; slopes in pixels
/// per frame; `response` is the interpolated DoG value with its sign, fraction of full scale; `snr` is |response|/σ_D;
/// `at_slope_limit` is 1 or 0.
pub const COLUMNS: [&str; 11] =
    ["u", "v", "sigma", "orientation", "slope_u", "slope_v", "response", "snr", "octave", "level", "at_slope_limit"];

/// Row of a feature table: the exported values of a feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatureRow {
    /// Column at mid-burst, input pixels.
    pub u: f32,
    /// Row at mid-burst, input pixels.
    pub v: f32,
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Orientation, radians, from +u towards +v.
    pub orientation: f32,
    /// Apparent motion to the right, pixels per frame.
    pub slope_u: f32,
    /// Apparent motion down, pixels per frame.
    pub slope_v: f32,
    /// Interpolated DoG value with its sign, fraction of full scale.
    pub response: f32,
    /// |response| over the noise in D; infinite for a noiseless burst.
    pub snr: f32,
    /// Octave in which the feature was found.
    pub octave: i32,
    /// Level at which the feature was found.
    pub level: i32,
    /// Whether the feature was found on the rim of the slope grid.
    pub at_slope_limit: bool,
}

impl From<&Feature> for FeatureRow {
    fn from(f: &Feature) -> Self {
        Self {
            u: f.u,
            v: f.v,
            sigma: f.sigma,
            orientation: f.orientation,
            slope_u: f.slope.u,
            slope_v: f.slope.v,
            response: f.response,
            snr: f.snr,
            octave: f.octave,
            level: f.level,
            at_slope_limit: f.at_slope_limit,
        }
    }
}

impl FeatureRow {
    /// Values of the row as numbers, in the order of [`COLUMNS`].
    pub fn values(&self) -> [f32; 11] {
        [
            self.u,
            self.v,
            self.sigma,
            self.orientation,
            self.slope_u,
            self.slope_v,
            self.response,
            self.snr,
            self.octave as f32,
            self.level as f32,
            f32::from(u8::from(self.at_slope_limit)),
        ]
    }
}
