//! Charts: discs on an even background, each with its own motion.
//!
//! A chart is the test target on which detectors are compared: the position, size and motion of every disc is known
//! exactly, and any other feature is false. Discs do not touch at mid-burst and stay inside the image in all frames. In
//! other frames they may cross; then the faster one is in front, as the nearer one would be.

mod drawing;
mod layout;

use super::capture::capture_burst;
use super::noise::Camera;
use super::radius::RadiusLaw;
use super::truth::{FeatureTruth, NoiseTruth, Truth, TruthKind};
use super::{Motion, SynthError, check_common};
use crate::burst::Burst;
use crate::monitor::Monitor;
use crate::plane::Plane;
use layout::place_discs;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

pub use drawing::draw_disc;

/// Parameters of a chart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartParams {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Number of discs.
    pub discs: usize,
    /// Range of the radii, pixels.
    pub radius: RangeInclusive<f64>,
    /// Distribution of the radii over that range.
    pub radius_law: RadiusLaw,
    /// Minimum distance between the rims of two discs at mid-burst, pixels.
    pub gap: f64,
    /// Intensity of a disc over that of the background; above 1 is brighter.
    pub contrast: f64,
    /// Number of frames, N.
    pub frames: usize,
    /// Directions in which discs move.
    pub motion: Motion,
    /// Slopes are drawn from the continuum between −`max_slope` and `max_slope`, pixels per frame, on each axis that
    /// moves.
    pub max_slope: f64,
    /// Per-pixel signal-to-noise ratio, as [`super::noise`] defines it; infinite for no noise.
    pub snr: f64,
    /// Standard deviation of the read noise, electrons.
    pub read_noise: f64,
    /// Bits of the converter, 4 … 16.
    pub bits: u32,
    /// Seed of layout and noise.
    pub seed: u64,
}

impl Default for ChartParams {
    /// The published chart: 90 discs of contrast 1.2, 10 frames, slopes up to ±3 px/frame, at half the size of the
    /// paper's frames.
    fn default() -> Self {
        Self {
            width: 800,
            height: 600,
            discs: 90,
            radius: 3.6..=19.0,
            radius_law: RadiusLaw::Uniform,
            gap: 6.0,
            contrast: 1.2,
            frames: 10,
            motion: Motion::OneD,
            max_slope: 3.0,
            snr: 0.6,
            read_noise: 3.0,
            bits: 12,
            seed: 1,
        }
    }
}

/// Signal levels of a chart and the camera that captures it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Signal of the background, fraction of full scale above black.
    pub background: f64,
    /// Signal of the discs, fraction of full scale above black.
    pub disc: f64,
    /// The camera.
    pub camera: Camera,
}

/// Distance of the noise from black and white, in standard deviations, so that nothing is clipped.
const CLEARANCE_SIGMAS: f64 = 5.0;

impl ChartParams {
    /// The signal levels and the camera. The background's signal is a tenth of full scale, as with a gain that suits
    /// the light, and less where the noise would not fit between black and white otherwise. The black level is a 64th
    /// of full scale, and more where the noise would be clipped at zero.
    ///
    /// # Errors
    /// When contrast or SNR make no sense.
    pub fn exposure(&self) -> Result<Exposure, SynthError> {
        if !(self.contrast.is_finite() && self.contrast > 0.0 && self.contrast <= 8.0)
            || (self.contrast - 1.0).abs() < 1e-3
        {
            return Err(SynthError::param(
                "contrast",
                format!("{} as the ratio of disc to background", self.contrast),
                "give a ratio above 0 and up to 8, other than 1",
            ));
        }
        let amplitude = (self.contrast - 1.0).abs();
        let room = 0.96 / (2.0 * CLEARANCE_SIGMAS / self.snr + 1.0);
        let background = (room / amplitude).min(0.1);
        let disc = background * self.contrast;
        let mut camera = Camera::for_snr(self.snr, background, disc, self.read_noise, 0.0, self.bits)?;
        camera.black_level = (CLEARANCE_SIGMAS * camera.sigma(background) - background.min(disc)).max(1.0 / 64.0);
        Ok(Exposure { background, disc, camera })
    }

    fn check(&self) -> Result<(), SynthError> {
        check_common(self.width, self.height, self.frames, self.max_slope, self.read_noise, self.bits)?;
        let (smallest, largest) = (*self.radius.start(), *self.radius.end());
        if !(smallest.is_finite() && largest.is_finite() && smallest >= 0.5 && smallest <= largest) {
            return Err(SynthError::param(
                "radius",
                format!("{smallest}:{largest}"),
                "give MIN:MAX in pixels, at least 0.5, the smaller one first",
            ));
        }
        if self.discs > 100_000 {
            return Err(SynthError::param("discs", format!("{}", self.discs), "give at most 100000"));
        }
        if !(self.gap.is_finite() && self.gap >= 0.0) {
            return Err(SynthError::param("gap", format!("{}", self.gap), "give 0 or more pixels"));
        }
        Ok(())
    }
}

/// Makes a chart and its truth.
///
/// # Errors
/// A parameter that makes no sense, more discs than fit, or [`SynthError::Cancelled`].
pub fn synth_chart(params: &ChartParams, monitor: &Monitor) -> Result<(Burst, Truth), SynthError> {
    params.check()?;
    let exposure = params.exposure()?;
    let features = place_discs(params, monitor)?;
    // Far (slow) discs first, so that faster ones are drawn over them.
    let mut order: Vec<&FeatureTruth> = features.iter().collect();
    order.sort_by(|a, b| a.slope_u.hypot(a.slope_v).total_cmp(&b.slope_u.hypot(b.slope_v)).then(a.id.cmp(&b.id)));
    let burst = capture_burst("chart", params.frames, params.seed, &exposure.camera, monitor, |dt| {
        let mut signal = Plane::zeros(params.width, params.height);
        signal.data_mut().fill(exposure.background as f32);
        for disc in &order {
            monitor.check()?;
            let (u, v) = disc.position(dt);
            draw_disc(&mut signal, u, v, disc.radius, exposure.disc as f32);
        }
        Ok(signal)
    })?;
    let truth = Truth {
        kind: TruthKind::Chart,
        width: params.width,
        height: params.height,
        frames: params.frames,
        t0: (params.frames as f64 - 1.0) / 2.0,
        seed: params.seed,
        noise: NoiseTruth::of(&exposure.camera, exposure.background, Some(params.snr)),
        black_level: exposure.camera.black_level,
        layers: Vec::new(),
        features,
    };
    Ok((burst, truth))
}

#[cfg(test)]
mod tests;
