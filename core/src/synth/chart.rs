//! Charts: discs on an even background, each with its own motion.
//!
//! The test target on which detectors are compared: any feature that is no disc is false. Discs do not touch at
//! mid-burst and stay inside the image in all frames. Where they cross the faster one is in front, as if nearer.

#[cfg(feature = "cli")]
use super::options::{SNR_HELP, motions, parse_range, words};
use super::truth::{FeatureTruth, Truth, TruthKind};
use super::{Motion, capture_burst, check_common, check_snr, outermost, uneven::Uneven};
use super::{arm::Arm, noise::Camera};
use crate::error::{Error, Result};
use crate::synth::{random::Stream, truth::disc_sigma};
use crate::{burst::Burst, monitor::Monitor, plane::Plane};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Parameters of a chart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(deny_unknown_fields)]
pub struct ChartParams {
    /// Columns.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().width))]
    pub width: usize,
    /// Rows.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().height))]
    pub height: usize,
    /// Number of discs.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().discs))]
    pub discs: usize,
    /// Range of the discs' radii, pixels.
    #[cfg_attr(feature = "cli", arg(long, value_name = "MIN:MAX", default_value = "3.6:19", value_parser = parse_range))]
    pub radius: RangeInclusive<f64>,
    /// Law of the radii: uniform, or log, by which every octave of radii is equally likely.
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "LAW", default_value = "uniform", value_parser = words::<RadiusLaw>(&["uniform", "log"]))
    )]
    pub radius_law: RadiusLaw,
    /// Least distance between two discs at mid-burst, pixels.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().gap))]
    pub gap: f64,
    /// Intensity of the discs over that of the background.
    #[cfg_attr(feature = "cli", arg(long, value_name = "RATIO", default_value_t = Self::default().contrast))]
    pub contrast: f64,
    /// Number of frames.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().frames))]
    pub frames: usize,
    /// Times of the frames.
    #[cfg_attr(feature = "cli", command(flatten))]
    #[serde(default, skip_serializing_if = "Uneven::is_even")]
    pub uneven: Uneven,
    /// Share of the columns that a textured thing hides, on the left, which stands still in all frames, as a robot's
    /// arm. Its mask is written to masks/mask.png, and what it hides is not among the known features.
    #[cfg_attr(feature = "cli", arg(long, value_name = "SHARE", default_value_t = 0.0))]
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub mask: f64,
    /// Directions of motion: 1d is horizontal, 2d any.
    #[cfg_attr(feature = "cli", arg(long, value_name = "DIRECTIONS", default_value = "1d", value_parser = motions()))]
    pub motion: Motion,
    /// Largest slope on each axis, pixels per frame.
    #[cfg_attr(feature = "cli", arg(long, value_name = "SLOPE", default_value_t = Self::default().max_slope))]
    pub max_slope: f64,
    /// Signal-to-noise ratio of one pixel in one frame, as [`super::noise`] defines it; infinite for no noise.
    #[cfg_attr(feature = "cli", arg(long, value_name = "RATIO", default_value_t = Self::default().snr, help = SNR_HELP))]
    pub snr: f64,
    /// Standard deviation of the read noise, electrons.
    #[cfg_attr(feature = "cli", arg(long, value_name = "ELECTRONS", default_value_t = Self::default().read_noise))]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[cfg_attr(feature = "cli", arg(long, value_name = "BITS", default_value_t = Self::default().bits))]
    pub bits: u32,
    /// Seed: the same seed makes the same burst on every machine.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().seed))]
    pub seed: u64,
}

impl Default for ChartParams {
    /// The published chart, at half the size of the paper's frames.
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
            uneven: Uneven::default(),
            mask: 0.0,
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

/// Distance of the noise from black and white, in standard deviations, so that nothing, or little, is clipped.
pub(super) const CLEARANCE_SIGMAS: f64 = 5.0;

impl ChartParams {
    /// The signal levels and the camera. The background's signal is a tenth of full scale, less where the noise would
    /// not fit below white; the black level is a 64th of full scale, more where the noise would be clipped at zero.
    ///
    /// # Errors
    /// When contrast or SNR make no sense.
    pub fn exposure(&self) -> Result<Exposure> {
        if !(self.contrast.is_finite() && self.contrast > 0.0 && self.contrast <= 8.0)
            || (self.contrast - 1.0).abs() < 1e-3
        {
            let problem = format!("{} as the ratio of disc to background", self.contrast);
            return Err(Error::param("contrast", problem, "give a ratio above 0 and up to 8, other than 1"));
        }
        // As a share of the background's signal, for brighter and darker discs alike.
        let amplitude = (self.contrast - 1.0).abs();
        // Largest difference of the levels that leaves room for the noise on both sides.
        let room = 0.96 / (2.0 * CLEARANCE_SIGMAS / self.snr + 1.0);
        let background = (room / amplitude).min(0.1);
        let disc = background * self.contrast;
        let mut camera = Camera::for_snr(self.snr, background, disc, self.read_noise, 0.0, self.bits)?;
        camera.black_level = (CLEARANCE_SIGMAS * camera.sigma(background) - background.min(disc)).max(1.0 / 64.0);
        Ok(Exposure { background, disc, camera })
    }

    /// Checks the parameters; the error is of the first one that makes no sense.
    pub fn check(&self) -> Result<()> {
        check_snr(self.snr)?;
        let frames = self.uneven.count_and_span(self.frames);
        check_common(self.width, self.height, frames, self.max_slope, self.read_noise, self.bits)?;
        let (smallest, largest) = (*self.radius.start(), *self.radius.end());
        if !(smallest.is_finite() && largest.is_finite() && smallest >= 0.5 && smallest <= largest) {
            let remedy = "give MIN:MAX in pixels, at least 0.5, the smaller one first";
            return Err(Error::param("radius", format!("{smallest}:{largest}"), remedy));
        }
        if self.discs > 100_000 {
            return Err(Error::param("discs", self.discs.to_string(), "give at most 100000"));
        }
        if !(self.gap.is_finite() && self.gap >= 0.0) {
            return Err(Error::param("gap", format!("{}", self.gap), "give 0 or more pixels"));
        }
        Ok(())
    }
}

/// Makes a chart and its truth, to measure a search against.
///
/// ```
/// use burstscope_core::{Monitor, synth::{ChartParams, synth_chart}};
/// let params = ChartParams { discs: 9, snr: 0.5, ..ChartParams::default() };
/// let (burst, truth) = synth_chart(&params, &Monitor::default())?;
/// assert_eq!((burst.len(), truth.features.len()), (params.frames, 9));
/// # Ok::<(), burstscope_core::Error>(())
/// ```
///
/// # Errors
/// A parameter that makes no sense, more discs than fit, or cancellation.
pub fn synth_chart(params: &ChartParams, monitor: &Monitor) -> Result<(Burst, Truth)> {
    params.check()?;
    let exposure = params.exposure()?;
    let taken = params.uneven.taken(params.frames, params.seed)?;
    let arm = Arm::new(params.mask, params.width, exposure.background, params.seed)?;
    let features = place_discs(params, monitor)?;
    // Far (slow) discs first: near (fast) discs hide them.
    let mut order: Vec<&FeatureTruth> = features.iter().collect();
    order.sort_by(|a, b| a.slope_u.hypot(a.slope_v).total_cmp(&b.slope_u.hypot(b.slope_v)).then(a.id.cmp(&b.id)));
    let burst = capture_burst("chart", &taken, params.seed, &exposure.camera, monitor, |at| {
        let mut signal = Plane::zeros(params.width, params.height);
        signal.data_mut().fill(exposure.background as f32);
        for disc in &order {
            monitor.check()?;
            let (u, v) = disc.position(at);
            draw_disc(&mut signal, u, v, disc.radius, exposure.disc as f32);
        }
        arm.draw_over(&mut signal);
        Ok(signal)
    })?;
    let (size, noise) = ((params.width, params.height), (exposure.background, Some(params.snr)));
    let truth = Truth::captured(TruthKind::Chart, size, (params.frames, params.seed), &exposure.camera, noise);
    Ok((burst, arm.truth(taken.truth(Truth { features, ..truth }))))
}

/// Blends a disc of level `value` into `plane` by the share of each pixel's area, in 16 thin strips, exact along rows.
pub fn draw_disc(plane: &mut Plane, u: f64, v: f64, radius: f64, value: f32) {
    const STRIPS: usize = 16;
    let clip = |x: f64, size: usize| x.clamp(0.0, size as f64) as usize;
    let rows = clip((v - radius + 0.5).floor(), plane.height())..clip((v + radius + 0.5).floor() + 1.0, plane.height());
    let columns =
        clip((u - radius + 0.5).floor(), plane.width())..clip((u + radius + 0.5).floor() + 1.0, plane.width());
    for row in rows {
        // By area, not by centres of pixels: a disc of whole pixels would move in jumps.
        let mut chords = [0.0f64; STRIPS];
        for (k, half_chord) in chords.iter_mut().enumerate() {
            let dv = row as f64 - 0.5 + (k as f64 + 0.5) / STRIPS as f64 - v;
            *half_chord = (radius * radius - dv * dv).max(0.0).sqrt();
        }
        for column in columns.clone() {
            let (left, right) = (column as f64 - 0.5 - u, column as f64 + 0.5 - u);
            let covered: f64 = chords.iter().map(|&c| (right.min(c) - left.max(-c)).max(0.0)).sum();
            let share = (covered / STRIPS as f64) as f32;
            if share > 0.0 {
                let pixel = &mut plane.row_mut(row)[column];
                *pixel += share * (value - *pixel);
            }
        }
    }
}

/// Draws positions, radii and slopes at random; large discs first, because they are hardest to place.
fn place_discs(params: &ChartParams, monitor: &Monitor) -> Result<Vec<FeatureTruth>> {
    let mut stream = Stream::new(params.seed, 0);
    let mut radii: Vec<f64> = (0..params.discs).map(|_| params.radius_law.draw(&params.radius, &mut stream)).collect();
    radii.sort_by(|a, b| b.total_cmp(a));
    // Frames that are left out count too: an uneven burst shows the things of the even one.
    let all = params.uneven.whole(params.frames);
    let mut placed: Vec<FeatureTruth> = Vec::with_capacity(params.discs);
    for (id, &radius) in radii.iter().enumerate() {
        let mut place = None;
        // Attempts end: a chart too full for its discs must fail, not hang.
        for _ in 0..2000 {
            monitor.check()?;
            let slope_u = stream.within(-params.max_slope, params.max_slope);
            let slope_v = match params.motion {
                Motion::OneD => 0.0,
                Motion::TwoD => stream.within(-params.max_slope, params.max_slope),
            };
            let (x, y) = (stream.uniform(), stream.uniform());
            // The disc stays inside in all frames, with two pixels to spare.
            let rim = radius + 2.0;
            let (reach_u, reach_v) = outermost(all.offsets(), (slope_u, slope_v));
            let (du, dv) = (rim + reach_u, rim + reach_v);
            let (room_u, room_v) = ((params.width - 1) as f64 - 2.0 * du, (params.height - 1) as f64 - 2.0 * dv);
            if room_u < 0.0 || room_v < 0.0 {
                continue;
            }
            let (u, v) = (du + x * room_u, dv + y * room_v);
            if placed.iter().all(|d| (d.u - u).hypot(d.v - v) >= d.radius + radius + params.gap) {
                place = Some((u, v, slope_u, slope_v));
                break;
            }
        }
        let Some((u, v, slope_u, slope_v)) = place else {
            let ChartParams { discs, width, height, .. } = params;
            let problem = format!("only {id} of {discs} discs fit into {width}×{height} pixels");
            let remedy = "ask for fewer or smaller discs, smaller slopes or a larger image";
            return Err(Error::param("discs", problem, remedy));
        };
        let (sigma, contrast_sign) = (disc_sigma(radius), if params.contrast > 1.0 { 1 } else { -1 });
        placed.push(FeatureTruth { id, layer: None, u, v, radius, sigma, slope_u, slope_v, contrast_sign });
    }
    Ok(placed)
}

/// Distribution of radii over their range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RadiusLaw {
    /// Uniform in the radius: most discs are large.
    #[default]
    Uniform,
    /// Uniform in the logarithm of the radius: equally many fine and coarse discs, like the sampling of a scale space.
    Log,
}

impl RadiusLaw {
    /// Both distributions take one number from `stream`, so charts of the same seed differ only in their radii.
    pub(super) fn draw(self, range: &RangeInclusive<f64>, stream: &mut Stream) -> f64 {
        let (smallest, largest) = (*range.start(), *range.end());
        match self {
            Self::Uniform => stream.within(smallest, largest),
            Self::Log => {
                // Rounding in the exponential must not leave the range.
                libm::exp(stream.within(libm::log(smallest), libm::log(largest))).clamp(smallest, largest)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_law_spreads_radii_as_it_says() {
        for (law, middle) in [(RadiusLaw::Uniform, 0.5 * (3.6 + 19.0)), (RadiusLaw::Log, (3.6f64 * 19.0).sqrt())] {
            let mut stream = Stream::new(3, 0);
            let radii: Vec<f64> = (0..40_000).map(|_| law.draw(&(3.6..=19.0), &mut stream)).collect();
            assert!(radii.iter().all(|radius| (3.6..=19.0).contains(radius)), "{law:?}");
            let share = radii.iter().filter(|radius| **radius < middle).count() as f64 / 40_000.0;
            // Five standard errors.
            assert!((share - 0.5).abs() < 5.0 * (0.25f64 / 40_000.0).sqrt(), "{law:?}: {share}");
            assert_eq!(law.draw(&(5.3..=5.3), &mut Stream::new(1, 0)), 5.3);
        }
    }
}
