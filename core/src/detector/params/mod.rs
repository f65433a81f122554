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
pub use doc::{DetectorParams, SearchParams};
pub(crate) use record::params;
pub use record::{Bounds, Drag, Field, Param, ParamDoc, Stage, TextValue};
pub use rules::Rules;
pub use slope_grid::{AUTO, MAX_SLOPES, Slope, SlopeAxis, SlopeGrid, Slopes, SlopesPart};

impl<S: Clone> DetectorParams<S> {
    /// Indices into the burst of the frames that take part: the whole range, or its middle frame for SIFT.
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

    /// These parameters with those of `other` that change neither a stack nor a sample of D, only the judgement after a
    /// search: see [`Trail::rejudged`](crate::detector::Trail::rejudged).
    pub fn judged_as<T>(&self, other: &DetectorParams<T>) -> Self {
        let &DetectorParams {
            noise_gate, peak_threshold, edge_threshold, distinct, distinct_scale, max_features, ..
        } = other;
        Self { noise_gate, peak_threshold, edge_threshold, distinct, distinct_scale, max_features, ..self.clone() }
    }

    /// These parameters with other `slopes`.
    pub fn with_slopes<T>(self, slopes: T) -> DetectorParams<T> {
        // Field by field, since `..self` cannot change the type of `slopes`; a forgotten field does not compile.
        macro_rules! with_slopes {
            ($($field:ident)*) => { DetectorParams { slopes, $($field: self.$field),* } };
        }
        with_slopes! {
            method frames octaves levels first_octave peak_threshold noise_gate noise_model flicker edge_threshold
            search slope_extrema distinct distinct_scale rules max_features max_orientations describe_scales
        }
    }
}

impl DetectorParams {
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

    /// Texts of the parameters that decide the result of `stage`, of this stage and earlier ones.
    pub fn deciding(&self, stage: Stage) -> Vec<String> {
        let params = SearchParams::from(self.clone());
        doc::ALL.iter().filter(|record| record.stage <= stage).map(|record| record.text(&params)).collect()
    }
}

/// Side in pixels below which an octave is not searched.
pub const MIN_OCTAVE_SIDE: usize = 16;
