//! The arguments of `synth trajectory` as they are written.

use super::output_args::OutputArgs;
use super::synth_values::motions;
use crate::synth::{Light, Motion, TrajectoryParams};
use clap::Args;
use std::path::PathBuf;

fn trajectory() -> TrajectoryParams {
    TrajectoryParams::default()
}

/// Bursts that a camera takes on its way past textured planes at several depths, with its poses.
///
/// The planes are drawn in perspective from the pose that the camera has in each frame, so the apparent motion follows
/// from the depth. The folder holds bursts/ (a folder of frames for each), gold/ (the view at each mid-burst without
/// noise), poses.txt (lines 'timestamp tx ty tz qx qy qz qw': the burst's number, the camera in the world at
/// mid-burst), lens.toml (the camera, for --camera) and trajectory.json (everything else that is known).
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true, after_long_help = HELP)]
pub struct TrajectoryArgs {
    /// Folder to make; an earlier trajectory in it is replaced.
    #[arg(long, short, value_name = "DIR")]
    pub out: PathBuf,
    /// Columns.
    #[arg(long, value_name = "PIXELS", default_value_t = trajectory().width)]
    pub width: usize,
    /// Rows.
    #[arg(long, value_name = "PIXELS", default_value_t = trajectory().height)]
    pub height: usize,
    /// Number of bursts.
    #[arg(long, value_name = "N", default_value_t = trajectory().bursts)]
    pub bursts: usize,
    /// Number of frames of each burst.
    #[arg(long, value_name = "N", default_value_t = trajectory().frames)]
    pub frames: usize,
    /// Number of planes; the farthest fills the frame.
    #[arg(long, value_name = "N", default_value_t = trajectory().planes)]
    pub planes: usize,
    /// How the camera goes: 1d is sideways, so that everything moves horizontally; 2d is forward and sideways.
    #[arg(long, value_name = "DIRECTIONS", default_value = "1d", value_parser = motions())]
    pub motion: Motion,
    /// Largest apparent motion on an axis, pixels per frame; the camera's speed is chosen for it.
    #[arg(long, value_name = "SLOPE", default_value_t = trajectory().max_slope)]
    pub max_slope: f64,
    /// Signal-to-noise ratio of one pixel in one frame: the standard deviation of all pixels of the scene over that of
    /// the noise at their mean; 'inf' makes no noise [default: 0.3].
    #[arg(long, value_name = "RATIO", conflicts_with = "electrons")]
    pub snr: Option<f64>,
    /// Electrons that scene white makes in a pixel of a frame, in place of a ratio.
    #[arg(long, value_name = "ELECTRONS")]
    pub electrons: Option<f64>,
    /// Standard deviation of the read noise, electrons.
    #[arg(long, value_name = "ELECTRONS", default_value_t = trajectory().read_noise)]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[arg(long, value_name = "BITS", default_value_t = trajectory().bits)]
    pub bits: u32,
    /// Seed: the same seed makes the same scene, way and noise on every machine.
    #[arg(long, value_name = "N", default_value_t = trajectory().seed)]
    pub seed: u64,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub output: OutputArgs,
}

const HELP: &str = "\
From there to camera poses and their errors:
  burstscope synth trajectory --out way
  burstscope colmap way/bursts --camera way/lens.toml --slopes-u -3:3:7 --out rec
  mkdir -p rec/sparse
  colmap mapper --database_path rec/database.db --image_path rec/images --output_path rec/sparse
  burstscope evaluate poses --estimate rec/sparse --truth way/poses.txt";

impl TrajectoryArgs {
    /// Parameters of the trajectory.
    pub fn params(&self) -> TrajectoryParams {
        let Self { width, height, bursts, frames, planes, motion, max_slope, read_noise, bits, seed, .. } = *self;
        let light = match (self.snr, self.electrons) {
            (Some(snr), _) => Light::Snr(snr),
            (None, Some(electrons)) => Light::Electrons(electrons),
            (None, None) => trajectory().light,
        };
        TrajectoryParams { width, height, bursts, frames, planes, motion, max_slope, light, read_noise, bits, seed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_says_the_default_light() {
        assert_eq!(trajectory().light, Light::Snr(0.3));
    }
}
