//! Noisy copies of real frames: the same view as captured by our camera with less light.
//!
//! The frames are taken as the signal: their own noise, small in a picture taken in good light, is part of the scene. A
//! [`Camera`] captures each frame again with shot noise, read noise and rounding, so that methods compare on real
//! structure and motion at any noise level; the clean frames are the gold standard.
//!
//! # Signal-to-noise ratio
//! As in [`super::noise`], for two levels half a standard deviation of all pixels below and above their mean: the ratio
//! of the pixels' standard deviation to that of the noise at the mean.

use super::write::{io, write_folder, write_frame, write_json};
use burstscope_core::error::{Error, Result};
use burstscope_core::monitor::{Cancelled, Monitor, Stage};
use burstscope_core::synth::{check_camera, check_snr, noise::Camera, random::Stream, truth::NoiseTruth};
use burstscope_core::{burst::Burst, files::mark::OutputKind, plane::Plane};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::{collections::BTreeSet, sync::Arc};

/// Parameters of the noise of the copies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(deny_unknown_fields)]
pub struct NoisyParams {
    /// Signal-to-noise ratio of one pixel in one frame: the standard deviation of all pixels of the frames over that of
    /// the noise at their mean; 'inf' makes no noise.
    #[cfg_attr(feature = "cli", arg(long, value_name = "RATIO", default_value_t = Self::default().snr))]
    pub snr: f64,
    /// Standard deviation of the read noise, electrons.
    #[cfg_attr(feature = "cli", arg(long, value_name = "ELECTRONS", default_value_t = Self::default().read_noise))]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[cfg_attr(feature = "cli", arg(long, value_name = "BITS", default_value_t = Self::default().bits))]
    pub bits: u32,
    /// Seed of the noise: the same seed makes the same copies on every machine.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().seed))]
    pub seed: u64,
}

impl Default for NoisyParams {
    fn default() -> Self {
        Self { snr: 1.0, read_noise: 3.0, bits: 12, seed: 1 }
    }
}

/// Brightness statistics of frames, as fractions of full scale, from which the exposure is computed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameLevels {
    pixels: f64,
    sum: f64,
    sum_of_squares: f64,
    max: f64,
}

impl FrameLevels {
    /// Adds all frames of `burst`. The result does not depend on the order of the bursts, up to rounding.
    pub fn add(&mut self, burst: &Burst, monitor: &Monitor) -> Result<(), Cancelled> {
        for frame in &burst.frames {
            for v in 0..frame.height() {
                monitor.check()?;
                for &value in frame.row(v) {
                    // Calibrated values may lie below black, but light does not.
                    let value = f64::from(value).max(0.0);
                    self.sum += value;
                    self.sum_of_squares += value * value;
                    self.max = self.max.max(value);
                }
            }
            self.pixels += frame.data().len() as f64;
        }
        Ok(())
    }

    /// The mean of all pixels.
    pub fn mean(&self) -> f64 {
        self.sum / self.pixels
    }

    /// The maximum of all pixels.
    pub fn max(&self) -> f64 {
        self.max
    }

    /// The standard deviation of all pixels.
    pub fn standard_deviation(&self) -> f64 {
        (self.sum_of_squares / self.pixels - self.mean().powi(2)).max(0.0).sqrt()
    }
}

/// Camera of the copies and the gain of the frames' values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoisyExposure {
    /// Factor from the frame's value to the signal, at most 1: less where the brightest pixels' noise would clip.
    pub gain: f64,
    /// The camera.
    pub camera: Camera,
    /// Mean of the signal, fraction of full scale above black.
    pub mean_signal: f64,
}

/// Distance of the noise from black and white, in standard deviations.
pub(super) const CLEARANCE_SIGMAS: f64 = 5.0;

impl NoisyParams {
    /// Checks the parameters alone, without frames; the first one that makes no sense is the error.
    pub fn check(&self) -> Result<()> {
        check_snr(self.snr)?;
        check_camera(self.read_noise, self.bits)
    }

    /// Computes the camera for frames of these levels, one for all bursts of a dataset.
    ///
    /// # Errors
    /// Parameters that make no sense, or frames without any contrast.
    pub fn exposure(&self, levels: &FrameLevels) -> Result<NoisyExposure> {
        self.check()?;
        let (mean, contrast) = (levels.mean(), levels.standard_deviation());
        if contrast.is_nan() || contrast <= 1e-6 {
            let problem = "all pixels of the frames are alike, and a ratio to their contrast means nothing";
            return Err(Error::param("snr", problem, "give frames that show something"));
        }
        let camera = |gain: f64| {
            let level = |sign: f64| (gain * (mean + sign * 0.5 * contrast)).max(0.0);
            Camera::for_snr(self.snr, level(-1.0), level(1.0), self.read_noise, 0.0, self.bits)
        };
        // Noise is proportional to the gain, except for rounding, which is small beside it: so the range that the noise
        // needs at gain 1 determines the gain at which it fits.
        let full = camera(1.0)?;
        let needed = levels.max + CLEARANCE_SIGMAS * (full.sigma(levels.max) + full.sigma(0.0));
        let gain = ((1.0 - 1.0 / 64.0) / needed).min(1.0);
        let mut camera = camera(gain)?;
        // The pedestal keeps the noise of black pixels above 0.
        camera.black_level = (CLEARANCE_SIGMAS * camera.sigma(0.0)).max(1.0 / 64.0);
        Ok(NoisyExposure { gain, camera, mean_signal: gain * mean })
    }
}

impl NoisyExposure {
    /// Captures the frames of `burst`. Frame t takes its noise from stream `first_stream + t`, whatever the threads.
    pub fn capture(&self, burst: &Burst, seed: u64, first_stream: u64, monitor: &Monitor) -> Result<Burst, Cancelled> {
        let frames = burst.frames.par_iter().enumerate().map(|(t, frame)| {
            let (width, height) = frame.size();
            let signal: Vec<f32> = frame.data().iter().map(|&x| (f64::from(x) * self.gain) as f32).collect();
            let mut stream = Stream::new(seed, first_stream + t as u64);
            Ok(Arc::new(self.camera.capture(&Plane::from_vec(width, height, signal), &mut stream, monitor)?))
        });
        Ok(Burst {
            frames: frames.collect::<Result<_, Cancelled>>()?,
            full_scale: 65535.0,
            quantisation_step: self.camera.quantisation_step() as f32,
            ..burst.clone()
        })
    }
}

/// Truth of a folder of noisy copies: the content of its `noise.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoisyTruth {
    /// Requested per-pixel signal-to-noise ratio; absent (null) for none.
    pub snr: Option<f64>,
    /// Seed of the noise.
    pub seed: u64,
    /// Factor from the original frame's value to the signal.
    pub gain: f64,
    /// Pedestal under all values, fraction of full scale.
    pub black_level: f64,
    /// The camera's noise, at the mean of the signal; `None` (null) for noiseless copies.
    pub noise: Option<NoiseTruth>,
    /// Files of the frames, relative to the folder, with `/` between folder and file.
    pub frames: Vec<String>,
}

/// Writes noisy copies of bursts into the folder `dir`: 16-bit PNG frames under the originals' names, those of each
/// burst in a subfolder of its name if `subfolders` is true, and `noise.json`. `open` opens burst k of `names`. Earlier
/// noisy copies in `dir` are replaced as a whole; a folder that holds anything else is left unchanged.
///
/// # Errors
/// An error of `open`, or of writing; the folder is then unchanged.
pub fn write_noisy<E: From<Error>>(
    dir: &Path,
    names: &[String],
    subfolders: bool,
    params: &NoisyParams,
    exposure: &NoisyExposure,
    mut open: impl FnMut(usize) -> Result<Burst, E>,
    monitor: &Monitor,
) -> Result<NoisyTruth, E> {
    let mut truth = NoisyTruth {
        snr: params.snr.is_finite().then_some(params.snr),
        seed: params.seed,
        gain: exposure.gain,
        black_level: exposure.camera.black_level,
        noise: NoiseTruth::of(&exposure.camera, exposure.mean_signal, None),
        frames: Vec::new(),
    };
    // `write_folder` takes errors of the core only: one of `open` waits here, and cancelling leaves `dir` unchanged.
    let mut failure = None;
    let written = write_folder(dir, OutputKind::NoisyCopies, |fresh| {
        for (k, name) in names.iter().enumerate() {
            let part = subfolders.then_some(name.as_str());
            let burst = match open(k) {
                Ok(burst) => burst,
                Err(error) => {
                    failure = Some(error);
                    return Err(Cancelled.into());
                }
            };
            // Frames are counted through all bursts, so that each has a random stream of its own.
            let noisy = exposure.capture(&burst, params.seed, 1 + truth.frames.len() as u64, monitor)?;
            truth.frames.extend(write_frames(fresh, part, &noisy)?);
            monitor.report(Stage::Write, (k + 1) as f32 / names.len() as f32);
            monitor.check()?;
        }
        write_json(&fresh.join("noise.json"), &truth)
    });
    match (failure, written) {
        (Some(error), _) => Err(error),
        (None, Err(error)) => Err(error.into()),
        (None, Ok(())) => Ok(truth),
    }
}

/// Writes the frames of a burst into `dir`, or its subfolder `part`; returns their names for [`NoisyTruth::frames`].
fn write_frames(dir: &Path, part: Option<&str>, burst: &Burst) -> Result<Vec<String>> {
    let folder = part.map_or_else(|| dir.to_owned(), |part| dir.join(part));
    std::fs::create_dir_all(&folder).map_err(io(&folder))?;
    let names = frame_files(&burst.frame_names);
    names.par_iter().zip(&burst.frames).try_for_each(|(name, frame)| write_frame(&folder.join(name), frame))?;
    Ok(names.into_iter().map(|name| part.map_or_else(|| name.clone(), |part| format!("{part}/{name}"))).collect())
}

/// The copies' file names: the originals' as PNG, or numbers where these are not different names of files.
fn frame_files(originals: &[String]) -> Vec<String> {
    let png = |name: &String| PathBuf::from(name).with_extension("png").to_string_lossy().into_owned();
    let names: Vec<String> = originals.iter().map(png).collect();
    // Case does not tell files apart on every system.
    let different: BTreeSet<String> = names.iter().map(|n| n.to_lowercase()).collect();
    let plain = |name: &String| !name.contains(['/', '\\', '[', ':']) && !name.starts_with('.') && name != ".png";
    if different.len() == names.len() && names.iter().all(plain) {
        names
    } else {
        (0..originals.len()).map(super::write::frame_name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_keep_their_names_unless_two_would_share_one() {
        let named = |names: [&str; 2]| frame_files(&names.map(str::to_owned));
        assert_eq!(named(["a.jpg", "b.jpg"]), ["a.png", "b.png"]);
        for names in [["x/s.tif [0]", "x/s.tif [1]"], ["a.tif", "A.png"]] {
            assert_eq!(named(names), ["frame_000.png", "frame_001.png"]);
        }
    }
}
