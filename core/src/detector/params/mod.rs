//! Parameters of the detector, their records and checks.
//!
//! Each parameter has one record ([`Param`], all of them in [`doc::ALL`]), from which its option, its row in the
//! window, its checks and its help are made. A parameter file is TOML with the fields of [`DetectorParams`]; a missing
//! field has its default, or what goes with the rules that the file chooses.

mod change;
mod choices;
pub mod doc;
mod record;
mod rules;
mod searched;
pub mod slope_grid;
mod validate;

pub use crate::burst::FrameRange;
pub use change::ParamChange;
pub(crate) use choices::words;
pub use choices::{
    CoarseStart, DescribeSlope, Distinct, Flicker, Interpolation, Localisation, Method, NoiseGate, NoiseModelKind,
    SearchSlopes, SlopeExtrema, SlopeNeighbours, Word,
};
pub use doc::DetectorParams;
pub(crate) use record::params;
pub use record::{Bounds, Drag, Field, Param, ParamDoc, Stage, TextValue};
pub use rules::Rules;
pub use searched::{AUTO, SearchParams, SlopeChoice};
pub use slope_grid::{MAX_SLOPES, Slope, SlopeAxis, SlopeGrid};

use toml::Table;

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
            Method::Sift | Method::Merge => SlopeGrid::single(Slope::default()),
        }
    }

    /// Rule for candidates that takes part: with one slope there is no other to compare with.
    pub fn used_extrema(&self) -> SlopeExtrema {
        if self.used_slopes().len() == 1 { SlopeExtrema::Each } else { self.slope_extrema }
    }

    /// These parameters with those of `other` that change neither a stack nor a sample of D, only the judgement of what
    /// a search left: see [`Trail::rejudged`](crate::detector::Trail::rejudged).
    pub fn judged_as(&self, other: &Self) -> Self {
        let &Self { noise_gate, peak_threshold, edge_threshold, distinct, distinct_scale, max_features, .. } = other;
        Self { noise_gate, peak_threshold, edge_threshold, distinct, distinct_scale, max_features, ..self.clone() }
    }

    /// Texts of the parameters that decide the result of `stage`: those of this stage and of the ones before it.
    pub fn deciding(&self, stage: Stage) -> Vec<String> {
        doc::ALL.iter().filter(|record| record.stage <= stage).map(|record| record.text(self)).collect()
    }

    /// Reads a parameter file.
    ///
    /// # Errors
    /// TOML's error with its place, or the first parameter that makes no sense.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let _: Self = toml::from_str(text).map_err(|e| e.to_string())?;
        // Errors of the text have a place, those of a table have none.
        let params = Self::of_table(text.parse().map_err(|e: toml::de::Error| e.to_string())?)?;
        params.validate().map_err(|e| e.to_string())?;
        Ok(params)
    }

    /// Parameters of a file's table. What is missing is that of the rules it chooses.
    fn of_table(table: Table) -> Result<Self, String> {
        let given: Self = table.clone().try_into().map_err(|e: toml::de::Error| e.to_string())?;
        let base = Self::default().under(given.rules);
        let mut whole = Table::try_from(&base).expect("parameters are plain values, which TOML can always hold");
        whole.extend(table);
        whole.try_into().map_err(|e: toml::de::Error| e.to_string())
    }

    /// Text of the parameter file, which [`Self::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        let body = toml::to_string(self).expect("parameters are plain values, which TOML can always hold");
        format!("# Burstscope detector parameters. Slopes are in pixels of the input image per frame.\n{body}")
    }
}

/// Side in pixels below which an octave is not searched.
pub const MIN_OCTAVE_SIDE: usize = 16;
