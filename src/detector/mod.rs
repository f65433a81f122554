//! The core: from the frames of a burst to features.

pub mod feature;
pub mod motion;
pub mod params;
pub mod slope_grid;
pub mod view;

pub use feature::{Descriptor, Detection, Feature, StageTimes, Tally, Test};
pub use params::{DetectorParams, FrameRange, Interpolation, Method, NoiseGate, ParamDoc, ParamError, SlopeNeighbours};
pub use slope_grid::{Slope, SlopeAxis, SlopeGrid};

use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor};

/// Why there is no detection.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DetectError {
    /// A parameter makes no sense for this burst.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// It was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Finds the features of a burst.
///
/// # Errors
/// [`DetectError::Param`] for parameters that make no sense for the burst, [`DetectError::Cancelled`] once `monitor` was cancelled.
pub fn detect(burst: &Burst, params: &DetectorParams, _monitor: &Monitor) -> Result<Detection, DetectError> {
    params.validate_for(burst.len(), burst.size())?;
    unimplemented!("written in the core's own branch")
}
