//! Maps: pictures of what decides in the search, by place.

use super::fault::JobError;
use super::picture::job_error;
use crate::baseline::prepare;
use crate::burst::Burst;
use crate::detector::view::{coverage_view, gate_noise_map};
use crate::detector::{DetectorParams, Slope};
use crate::monitor::Monitor;
use crate::plane::Plane;
use serde::{Deserialize, Serialize};

/// The kinds of map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapKind {
    /// σ of the noise in D at the slope, octave and level, as the noise gate takes it; fraction of full scale.
    Noise,
    /// The share (0 … 1) of the frames that see each place at the slope.
    Coverage,
}

impl MapKind {
    /// All of them, in the order of menus.
    pub const ALL: [Self; 2] = [Self::Noise, Self::Coverage];

    /// Its name.
    pub fn label(self) -> &'static str {
        match self {
            Self::Noise => "Local noise",
            Self::Coverage => "Coverage",
        }
    }

    /// What it shows.
    pub fn help(self) -> &'static str {
        match self {
            Self::Noise => {
                "σ of the noise in the DoG at the slope, octave and level, by place, as the noise gate takes it: \
                 a candidate must be several times as large"
            }
            Self::Coverage => {
                "The share of the frames that see each place at the slope: \
                 where it is small, fewer frames are averaged and the noise is stronger"
            }
        }
    }

    /// Whether it depends on octave and level, and has the octave's pixels.
    pub fn is_of_octave(self) -> bool {
        match self {
            Self::Noise => true,
            Self::Coverage => false,
        }
    }

    /// Makes the map.
    pub(super) fn compute(
        self,
        burst: &Burst,
        params: &DetectorParams,
        (slope, octave, level): (Slope, i32, i32),
        monitor: &Monitor,
    ) -> Result<Plane, JobError> {
        let (burst, params) = prepare(burst, params, monitor).map_err(job_error)?;
        match self {
            Self::Noise => gate_noise_map(&burst, &params, slope, octave, level, monitor),
            Self::Coverage => coverage_view(&burst, &params, slope, monitor),
        }
        .map_err(job_error)
    }
}
