//! Parameters of the detector, their descriptions and checks.
//!
//! The command line, the window and the parameter file use these names, and their help texts come from [`ParamDoc`].
//! A parameter file is TOML with the fields of [`DetectorParams`]; a missing field has its default.

mod change;
mod choices;
pub mod doc;
mod searched;
pub mod slope_grid;
mod validate;

pub use change::ParamChange;
pub use choices::{
    DescribeSlope, Distinct, Flicker, FrameRange, Interpolation, Localisation, Method, NoiseGate, NoiseModelKind,
    SlopeExtrema, SlopeNeighbours,
};
pub use doc::ParamDoc;
pub use searched::{AUTO, SearchParams, SlopeChoice};
pub use validate::{MAX_SLOPES, ParamError};

use crate::detector::params::slope_grid::SlopeGrid;
use serde::{Deserialize, Serialize};

/// Parameters of the detector. The same burst and the same parameters give bitwise equal results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetectorParams {
    /// See [`doc::METHOD`].
    pub method: Method,
    /// See [`doc::FRAMES`]; `None` uses all frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<FrameRange>,
    /// See [`doc::OCTAVES`].
    pub octaves: u32,
    /// See [`doc::LEVELS`].
    pub levels: u32,
    /// See [`doc::FIRST_OCTAVE`].
    pub first_octave: i32,
    /// See [`doc::PEAK_THRESHOLD`].
    pub peak_threshold: f32,
    /// See [`doc::NOISE_GATE`].
    pub noise_gate: NoiseGate,
    /// See [`doc::NOISE_MODEL`].
    pub noise_model: NoiseModelKind,
    /// See [`doc::FLICKER`].
    pub flicker: Flicker,
    /// See [`doc::EDGE_THRESHOLD`].
    pub edge_threshold: f32,
    /// See [`doc::SLOPE_EXTREMA`].
    pub slope_extrema: SlopeExtrema,
    /// See [`doc::SLOPE_NEIGHBOURS`].
    pub slope_neighbours: SlopeNeighbours,
    /// See [`doc::DISTINCT`].
    pub distinct: Distinct,
    /// See [`doc::DISTINCT_SCALE`].
    pub distinct_scale: f32,
    /// See [`doc::INTERPOLATION`].
    pub interpolation: Interpolation,
    /// See [`doc::KERNEL_CUT`].
    pub kernel_cut: f32,
    /// See [`doc::LOCALISATION`].
    pub localisation: Localisation,
    /// See [`doc::MAX_FEATURES`]; 0 keeps all.
    pub max_features: usize,
    /// See [`doc::MAX_ORIENTATIONS`].
    pub max_orientations: usize,
    /// See [`doc::DESCRIBE_SLOPE`].
    pub describe_slope: DescribeSlope,
    /// See [`doc::SLOPES_U`], [`doc::SLOPES_V`] and [`doc::SLOPE_DIRECTION`].
    pub slopes: SlopeGrid,
}

impl Default for DetectorParams {
    fn default() -> Self {
        Self {
            method: Method::Buff,
            frames: None,
            octaves: 6,
            // In the dark five levels with an edge threshold of 12 gave 5 to 7 % more inliers than the paper's four
            // with 10, for 4 % more time; six gave another 3 to 4 % for 7 to 12 % more time (docs/MEASUREMENTS.md).
            levels: 5,
            first_octave: 0,
            // An absolute threshold removes everything in the dark; the noise gate replaces it.
            peak_threshold: 0.0,
            noise_gate: NoiseGate::Auto,
            noise_model: NoiseModelKind::Local,
            flicker: Flicker::Auto,
            edge_threshold: 12.0,
            slope_extrema: SlopeExtrema::Each,
            slope_neighbours: SlopeNeighbours::Adjacent,
            distinct: Distinct::default(),
            distinct_scale: 1.75,
            interpolation: Interpolation::Linear,
            kernel_cut: 4.0,
            localisation: Localisation::Continuous,
            max_features: 0,
            max_orientations: 2,
            describe_slope: DescribeSlope::Refined,
            slopes: SlopeGrid::default(),
        }
    }
}

impl DetectorParams {
    /// Indices into the burst of the frames that take part: the whole range for BuFF and the merge, its middle frame
    /// for SIFT.
    pub fn used_frames(&self, frame_count: usize) -> std::ops::Range<usize> {
        let range = self.frames.map_or(0..frame_count, |r| r.start..r.end.min(frame_count));
        match self.method {
            Method::Buff | Method::Merge => range,
            Method::Sift => {
                let middle = range.start + range.len() / 2;
                middle..middle + 1
            }
        }
    }

    /// Slopes that take part: the grid for BuFF, slope 0 for a single image.
    pub fn used_slopes(&self) -> SlopeGrid {
        match self.method {
            Method::Buff => self.slopes,
            Method::Sift | Method::Merge => SlopeGrid::single(crate::detector::params::slope_grid::Slope::default()),
        }
    }

    /// Reads a parameter file.
    ///
    /// # Errors
    /// TOML's error with its place, or the first parameter that makes no sense.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let params: Self = toml::from_str(text).map_err(|e| e.to_string())?;
        params.validate().map_err(|e| e.to_string())?;
        Ok(params)
    }

    /// Text of the parameter file, which [`Self::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        let body = toml::to_string(self).expect("parameters are plain values, which TOML can always hold");
        format!("# Burstscope detector parameters. Slopes are in pixels of the input image per frame.\n{body}")
    }
}

/// Side in pixels below which an octave is not searched.
pub const MIN_OCTAVE_SIDE: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_valid_and_survive_a_file() {
        let params = DetectorParams::default();
        assert_eq!(params.validate(), Ok(()));
        assert_eq!(DetectorParams::from_toml(&params.to_toml()), Ok(params));
        assert_eq!(DetectorParams::from_toml(""), Ok(DetectorParams::default()));
    }

    #[test]
    fn a_file_may_fix_the_gate_and_the_frames() {
        let text =
            "noise_gate = 4.5\nframes = { start = 2, end = 9 }\n[slopes]\nv = { min = -1.0, max = 1.0, count = 3 }\n";
        let params = DetectorParams::from_toml(text).expect("valid");
        assert_eq!(params.noise_gate, NoiseGate::Factor(4.5));
        assert_eq!(params.used_frames(20), 2..9);
        assert!(params.slopes.is_plane());
        assert_eq!(DetectorParams::from_toml(&params.to_toml()), Ok(params));
    }

    #[test]
    fn a_misspelt_field_is_an_error_that_names_it() {
        let error = DetectorParams::from_toml("peak_treshold = 1.0").expect_err("misspelt");
        assert!(error.contains("peak_treshold"), "{error}");
    }

    #[test]
    fn nonsense_is_named_with_its_remedy() {
        let good = DetectorParams::default;
        let cases: [(DetectorParams, &str); 9] = [
            (DetectorParams { slopes: SlopeGrid::line(3.0..=-3.0, 7), ..good() }, "slopes-u"),
            (DetectorParams { slopes: SlopeGrid::line(0.0..=0.0, 2), ..good() }, "slopes-u"),
            (DetectorParams { slopes: SlopeGrid::plane(0.0..=1.0, 100, 0.0..=1.0, 100), ..good() }, "slopes-v"),
            (DetectorParams { frames: Some(FrameRange { start: 3, end: 3 }), ..good() }, "frames"),
            (DetectorParams { octaves: 0, ..good() }, "octaves"),
            (DetectorParams { levels: 11, ..good() }, "levels"),
            (DetectorParams { peak_threshold: f32::NAN, ..good() }, "peak-threshold"),
            (DetectorParams { edge_threshold: 0.5, ..good() }, "edge-threshold"),
            (DetectorParams { noise_gate: NoiseGate::Factor(-1.0), ..good() }, "noise-gate"),
        ];
        for (params, name) in cases {
            assert_eq!(params.validate().expect_err(name).parameter, name);
        }
        let one_frame = DetectorParams::default().validate_for(1, (100, 100)).expect_err("one frame");
        assert_eq!(one_frame.parameter, "frames");
        let too_fast = DetectorParams { slopes: SlopeGrid::line(-99.0..=99.0, 3), ..good() };
        assert_eq!(too_fast.validate_for(10, (100, 100)).expect_err("too fast").parameter, "slopes-u");
    }

    #[test]
    fn sift_uses_the_middle_frame_and_slope_zero() {
        let params = DetectorParams { method: Method::Sift, ..DetectorParams::default() };
        assert_eq!(params.used_frames(5), 2..3);
        assert_eq!(params.used_slopes().len(), 1);
        assert_eq!(params.validate_for(1, (64, 64)), Ok(()));
    }

    #[test]
    fn every_field_has_a_description() {
        let text =
            DetectorParams { frames: Some(FrameRange { start: 0, end: 1 }), ..DetectorParams::default() }.to_toml();
        let table: toml::Table = text.parse().expect("valid");
        for field in table.keys().filter(|k| *k != "slopes") {
            assert!(doc::ALL.iter().any(|d| d.name.replace('-', "_") == *field), "{field} has no description");
        }
    }
}
