//! The arguments of `synth` as they are written.

use super::args::INPUT_HELP;
use super::calibration_args::CalibrationArgs;
use super::charts_args::DiscsArgs;
use super::output_args::OutputArgs;
use super::synth_values::motions;
use super::trajectory_args::TrajectoryArgs;
use crate::synth::{ChartParams, Motion, NoisyParams, SceneParams};
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Make a burst with exactly known truth, or noisy copies of real frames.
#[derive(Debug, Args)]
pub struct SynthArgs {
    /// What to make.
    #[command(subcommand)]
    pub kind: SynthKind,
}

/// The kinds of synthetic bursts.
#[derive(Debug, Subcommand)]
pub enum SynthKind {
    /// Discs on an even background, each with its own slope.
    Chart(ChartArgs),
    /// Textured layers at several depths, each with its own slope.
    Scene(SceneArgs),
    /// Noisy copies of real frames, as our camera would have taken them in the dark.
    Noisy(NoisyArgs),
    /// Bursts along a camera's way past textured planes, with its poses.
    Trajectory(TrajectoryArgs),
}

fn chart() -> ChartParams {
    ChartParams::default()
}

fn noisy() -> NoisyParams {
    NoisyParams::default()
}

fn scene() -> SceneParams {
    SceneParams::default()
}

const OUT_HELP: &str =
    "Folder to make, for frame_000.png … (16 bit) and truth.json; an earlier synthetic burst in it is replaced";
const SNR_HELP: &str = "Signal-to-noise ratio of one pixel in one frame: the difference of the two levels over the standard deviation of the noise \
    at their mean; 'inf' makes no noise";

/// Discs on an even background, each with its own slope.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct ChartArgs {
    #[arg(long, short, value_name = "DIR", help = OUT_HELP)]
    #[allow(missing_docs)]
    pub out: PathBuf,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub discs: DiscsArgs,
    /// Least distance between two discs at mid-burst, pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = chart().gap)]
    pub gap: f64,
    /// Intensity of the discs over that of the background.
    #[arg(long, value_name = "RATIO", default_value_t = chart().contrast)]
    pub contrast: f64,
    /// Number of frames.
    #[arg(long, value_name = "N", default_value_t = chart().frames)]
    pub frames: usize,
    /// Directions of motion: 1d is horizontal, 2d any.
    #[arg(long, value_name = "DIRECTIONS", default_value = "1d", value_parser = motions())]
    pub motion: Motion,
    /// Largest slope on each axis, pixels per frame.
    #[arg(long, value_name = "SLOPE", default_value_t = chart().max_slope)]
    pub max_slope: f64,
    #[arg(long, value_name = "RATIO", default_value_t = chart().snr, help = SNR_HELP)]
    #[allow(missing_docs)]
    pub snr: f64,
    /// Standard deviation of the read noise, electrons.
    #[arg(long, value_name = "ELECTRONS", default_value_t = chart().read_noise)]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[arg(long, value_name = "BITS", default_value_t = chart().bits)]
    pub bits: u32,
    /// Seed: the same seed makes the same burst on every machine.
    #[arg(long, value_name = "N", default_value_t = chart().seed)]
    pub seed: u64,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Textured layers at several depths, each with its own slope.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct SceneArgs {
    #[arg(long, short, value_name = "DIR", help = OUT_HELP)]
    #[allow(missing_docs)]
    pub out: PathBuf,
    /// Columns.
    #[arg(long, value_name = "PIXELS", default_value_t = scene().width)]
    pub width: usize,
    /// Rows.
    #[arg(long, value_name = "PIXELS", default_value_t = scene().height)]
    pub height: usize,
    /// Number of layers; the farthest fills the frame.
    #[arg(long, value_name = "N", default_value_t = scene().layers)]
    pub layers: usize,
    /// Number of frames.
    #[arg(long, value_name = "N", default_value_t = scene().frames)]
    pub frames: usize,
    /// Directions of motion: 1d is horizontal, 2d any.
    #[arg(long, value_name = "DIRECTIONS", default_value = "1d", value_parser = motions())]
    pub motion: Motion,
    /// Largest slope on each axis, pixels per frame.
    #[arg(long, value_name = "SLOPE", default_value_t = scene().max_slope)]
    pub max_slope: f64,
    #[arg(long, value_name = "RATIO", default_value_t = scene().snr, help = SNR_HELP)]
    #[allow(missing_docs)]
    pub snr: f64,
    /// Standard deviation of the read noise, electrons.
    #[arg(long, value_name = "ELECTRONS", default_value_t = scene().read_noise)]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[arg(long, value_name = "BITS", default_value_t = scene().bits)]
    pub bits: u32,
    /// Seed: the same seed makes the same burst on every machine.
    #[arg(long, value_name = "N", default_value_t = scene().seed)]
    pub seed: u64,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Noisy copies of real frames, as our camera would have taken them in the dark.
///
/// The frames are taken for the signal, and a camera with shot noise, read noise and rounding captures them anew, the
/// same camera for all. The originals are then the gold standard that the copies are compared with. Frames keep their
/// names and order; a dataset's bursts stay apart, each in a subfolder.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct NoisyArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    #[allow(missing_docs)]
    pub inputs: Vec<PathBuf>,
    /// Folder to make, for the frames (16-bit PNG) and noise.json; earlier noisy copies in it are replaced.
    #[arg(long, short, value_name = "DIR")]
    pub out: PathBuf,
    /// Signal-to-noise ratio of one pixel in one frame: the standard deviation of all pixels of the frames over that of
    /// the noise at their mean; 'inf' makes no noise.
    #[arg(long, value_name = "RATIO", default_value_t = noisy().snr)]
    pub snr: f64,
    /// Standard deviation of the read noise, electrons.
    #[arg(long, value_name = "ELECTRONS", default_value_t = noisy().read_noise)]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[arg(long, value_name = "BITS", default_value_t = noisy().bits)]
    pub bits: u32,
    /// Seed of the noise: the same seed makes the same copies on every machine.
    #[arg(long, value_name = "N", default_value_t = noisy().seed)]
    pub seed: u64,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub calibration: CalibrationArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub output: OutputArgs,
}
