//! `synth`: writes bursts with exactly known truth, and noisy copies of real ones.

use super::args::{CalibrationArgs, INPUT_HELP, OutputArgs};
use super::charts_args::{DiscsArgs, motions};
use super::console::Console;
use super::failure::Failure;
use super::inputs::{open_options, opened, resolve};
use crate::burst::Burst;
use crate::export::{OutputRules, Overwrite, safe_file_name};
use crate::files::path_text;
use crate::synth::{
    ChartParams, FrameLevels, Light, Motion, NoisyParams, SceneParams, Trajectory, TrajectoryParams, Truth,
    synth_chart, synth_scene, write_burst, write_noisy, write_trajectory,
};
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::{Path, PathBuf};

pub(super) fn run(args: &SynthArgs) -> Result<(), Failure> {
    match &args.kind {
        SynthKind::Chart(args) => {
            let console = Console::new(&args.output)?;
            let (burst, truth) = synth_chart(&chart_params(args), &console.monitor)?;
            finish(&args.out, &burst, &truth, &console)
        }
        SynthKind::Scene(args) => {
            let console = Console::new(&args.output)?;
            let (burst, truth) = synth_scene(&scene_params(args), &console.monitor)?;
            finish(&args.out, &burst, &truth, &console)
        }
        SynthKind::Noisy(args) => noisy(args),
        SynthKind::Trajectory(args) => trajectory(args),
    }
}

/// Writes noisy copies of real frames: a first pass over the bursts measures their levels, a second one writes.
fn noisy(args: &NoisyArgs) -> Result<(), Failure> {
    let NoisyArgs { snr, read_noise, bits, seed, .. } = *args;
    let params = NoisyParams { snr, read_noise, bits, seed };
    let console = Console::new(&args.output)?;
    let inputs = resolve(&args.inputs);
    let options = open_options(&inputs, &args.calibration)?;
    OutputRules::new(opened(&inputs, &options, &[]), Overwrite::Refuse).check_folder(&args.out)?;
    let mut levels = FrameLevels::default();
    for input in &inputs {
        console.begin(format!("{}: ", input.name));
        levels.add(&input.open(&options, &console.monitor)?, &console.monitor)?;
    }
    let exposure = params.exposure(&levels)?;
    let names: Vec<String> = inputs.iter().map(|i| safe_file_name(&i.name)).collect();
    let open = |k: usize| -> Result<Burst, Failure> { inputs[k].open(&options, &console.monitor.silent()) };
    console.begin(String::new());
    let truth = write_noisy(&args.out, &names, names.len() > 1, &params, &exposure, open, &console.monitor)?;
    let noise = truth.noise.map_or_else(
        || "no noise".to_owned(),
        |n| format!("noise {:.5} of full scale in a frame at the mean", n.sigma_background),
    );
    console.say(&format!(
        "{} frames of {} bursts, values times {:.4}, {noise}\nwrote {}\n",
        truth.frames.len(),
        names.len(),
        truth.gain,
        args.out.display()
    ))?;
    console.say_json(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": "synth",
        "folder": path_text(&args.out),
        "truth": truth,
    }))
}

/// Writes bursts along a camera's trajectory, with its poses.
fn trajectory(args: &TrajectoryArgs) -> Result<(), Failure> {
    let console = Console::new(&args.output)?;
    let trajectory = Trajectory::new(&args.params(), &console.monitor)?;
    write_trajectory(&args.out, &trajectory, &console.monitor)?;
    let truth = trajectory.truth();
    let light = match truth.noise {
        Some(noise) => format!(
            "SNR {:.2} ({:.2} electrons at scene white), noise {:.5} of full scale in a frame",
            trajectory.snr, trajectory.electrons, noise.sigma_background
        ),
        None => "no noise".to_owned(),
    };
    console.say(&format!(
        "{} bursts of {} frames of {}×{}, {} planes, {light}\nwrote {}\n",
        truth.bursts.len(),
        truth.frames,
        truth.width,
        truth.height,
        truth.planes.len(),
        args.out.display()
    ))?;
    console.say_json(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": "synth",
        "folder": path_text(&args.out),
        "truth": truth,
    }))
}

/// Parameters of the chart that `args` describe.
pub(super) fn chart_params(args: &ChartArgs) -> ChartParams {
    let ChartArgs {
        out: _,
        discs,
        gap,
        contrast,
        frames,
        motion,
        max_slope,
        snr,
        read_noise,
        bits,
        seed,
        output: OutputArgs { .. },
    } = args.clone();
    let chart =
        ChartParams { gap, contrast, frames, motion, max_slope, snr, read_noise, bits, seed, ..ChartParams::default() };
    discs.put_on(chart)
}

/// Parameters of the scene that `args` describe.
pub(super) fn scene_params(args: &SceneArgs) -> SceneParams {
    let SceneArgs {
        out: _,
        width,
        height,
        layers,
        frames,
        motion,
        max_slope,
        snr,
        read_noise,
        bits,
        seed,
        output: OutputArgs { .. },
    } = args.clone();
    SceneParams { width, height, layers, frames, motion, max_slope, snr, read_noise, bits, seed }
}

fn finish(out: &Path, burst: &Burst, truth: &Truth, console: &Console) -> Result<(), Failure> {
    write_burst(out, burst, truth, &console.monitor)?;
    let noise = truth
        .noise
        .map_or_else(|| "no noise".to_owned(), |n| format!("noise {:.5} of full scale in a frame", n.sigma_background));
    console.say(&format!(
        "{} frames of {}×{}, {} features with known place and slope, {noise}\nwrote {}\n",
        truth.frames,
        truth.width,
        truth.height,
        truth.features.len(),
        out.display()
    ))?;
    console.say_json(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": "synth",
        "folder": path_text(out),
        "truth": truth,
    }))
}

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

fn noisy_params() -> NoisyParams {
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
    #[arg(long, value_name = "RATIO", default_value_t = noisy_params().snr)]
    pub snr: f64,
    /// Standard deviation of the read noise, electrons.
    #[arg(long, value_name = "ELECTRONS", default_value_t = noisy_params().read_noise)]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[arg(long, value_name = "BITS", default_value_t = noisy_params().bits)]
    pub bits: u32,
    /// Seed of the noise: the same seed makes the same copies on every machine.
    #[arg(long, value_name = "N", default_value_t = noisy_params().seed)]
    pub seed: u64,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub calibration: CalibrationArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub output: OutputArgs,
}

fn trajectory_params() -> TrajectoryParams {
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
    #[arg(long, value_name = "PIXELS", default_value_t = trajectory_params().width)]
    pub width: usize,
    /// Rows.
    #[arg(long, value_name = "PIXELS", default_value_t = trajectory_params().height)]
    pub height: usize,
    /// Number of bursts.
    #[arg(long, value_name = "N", default_value_t = trajectory_params().bursts)]
    pub bursts: usize,
    /// Number of frames of each burst.
    #[arg(long, value_name = "N", default_value_t = trajectory_params().frames)]
    pub frames: usize,
    /// Number of planes; the farthest fills the frame.
    #[arg(long, value_name = "N", default_value_t = trajectory_params().planes)]
    pub planes: usize,
    /// How the camera goes: 1d is sideways, so that everything moves horizontally; 2d is forward and sideways.
    #[arg(long, value_name = "DIRECTIONS", default_value = "1d", value_parser = motions())]
    pub motion: Motion,
    /// Largest apparent motion on an axis, pixels per frame; the camera's speed is chosen for it.
    #[arg(long, value_name = "SLOPE", default_value_t = trajectory_params().max_slope)]
    pub max_slope: f64,
    /// Signal-to-noise ratio of one pixel in one frame: the standard deviation of all pixels of the scene over that of
    /// the noise at their mean; 'inf' makes no noise [default: 0.3].
    #[arg(long, value_name = "RATIO", conflicts_with = "electrons")]
    pub snr: Option<f64>,
    /// Electrons that scene white makes in a pixel of a frame, in place of a ratio.
    #[arg(long, value_name = "ELECTRONS")]
    pub electrons: Option<f64>,
    /// Standard deviation of the read noise, electrons.
    #[arg(long, value_name = "ELECTRONS", default_value_t = trajectory_params().read_noise)]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[arg(long, value_name = "BITS", default_value_t = trajectory_params().bits)]
    pub bits: u32,
    /// Seed: the same seed makes the same scene, way and noise on every machine.
    #[arg(long, value_name = "N", default_value_t = trajectory_params().seed)]
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
            (None, None) => trajectory_params().light,
        };
        TrajectoryParams { width, height, bursts, frames, planes, motion, max_slope, light, read_noise, bits, seed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_says_the_default_light() {
        assert_eq!(trajectory_params().light, Light::Snr(0.3));
    }
}
