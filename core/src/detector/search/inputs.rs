//! Inputs of a search: the frames that take part, the noise, the scales, checked and owned.

use crate::burst::Burst;
use crate::detector::error::DetectError;
use crate::detector::noise::estimate::frame_noise;
use crate::detector::noise_model::{Examined, ForSearch, NoiseModel, examine};
use crate::detector::params::slope_grid::Slope;
use crate::detector::params::{DetectorParams, NoiseModelKind};
use crate::detector::scale_space::levels::{ScaleSpace, searched_octaves};
use crate::detector::stack::offsets::FrameTimes;
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use std::ops::Range;
use std::sync::Arc;

/// Owned inputs of a search.
#[derive(Debug)]
pub(crate) struct Inputs {
    /// Frames that take part, cleaned by the noise model.
    pub(crate) frames: Vec<Arc<Plane>>,
    pub(crate) times: FrameTimes,
    pub(crate) frames_used: Range<usize>,
    pub(crate) size_image: (usize, usize),
    pub(crate) space: ScaleSpace,
    pub(crate) params: DetectorParams,
    pub(crate) noise: Arc<NoiseModel>,
}

impl Inputs {
    /// Checks the parameters and examines the noise.
    pub(crate) fn new(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Self, DetectError> {
        params.validate_for(burst.len(), burst.size())?;
        let frames_used = params.used_frames(burst.len());
        monitor.report(Stage::Noise, 0.0);
        let space = ScaleSpace::of(params);
        let Examined { model, frames, kept } = known_noise(burst, params, &space, monitor)?;
        let times = FrameTimes { frame_count: frames_used.len(), kept };
        let (size_image, noise, params) = (burst.size(), Arc::new(model), params.clone());
        Ok(Self { frames, times, frames_used, size_image, space, params, noise })
    }

    /// The frames by reference, as [`Search::new`] borrows them.
    pub(crate) fn planes(&self) -> Vec<&Plane> {
        self.frames.iter().map(|frame| &**frame).collect()
    }

    /// Octaves that are searched.
    pub(crate) fn octaves(&self) -> Range<i32> {
        searched_octaves(&self.params, self.size_image)
    }
}

/// Noise of the burst by the model in the parameters, and the frames that are searched: with [`NoiseModelKind::White`],
/// or where there is too little data for a local model, all that are used, unchanged.
pub(in crate::detector) fn known_noise(
    burst: &Burst,
    params: &DetectorParams,
    space: &ScaleSpace,
    monitor: &Monitor,
) -> Result<Examined, Cancelled> {
    let used = params.used_frames(burst.len());
    let frames = &burst.frames[used.clone()];
    let local = match params.noise_model {
        NoiseModelKind::Local => {
            let slopes: Vec<Slope> = params.used_slopes().slopes().collect();
            let octaves = searched_octaves(params, burst.size());
            let search = ForSearch { space, octaves, slopes: &slopes, flicker: params.flicker };
            examine(frames, burst.quantisation_step, &search, monitor)?
        }
        NoiseModelKind::White => None,
    };
    match local {
        Some(examined) => Ok(examined),
        None => {
            let model = NoiseModel::white(frame_noise(burst, used, monitor)?);
            Ok(Examined { model, frames: frames.to_vec(), kept: (0..frames.len()).collect() })
        }
    }
}
