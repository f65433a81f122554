//! `synth`: writes bursts with exactly known truth, and noisy copies of real ones.

use super::{Console, INPUT_HELP, Input, Outcome, OutputArgs, document, open_options, opened, resolve};
use crate::burst::{Burst, OpenOptions};
use crate::error::Error;
use crate::export::{OutputRules, Overwrite, safe_file_name};
use crate::files::path_text;
use crate::inspect::words::counted;
use crate::monitor::Monitor;
use crate::synth::{
    ChartParams, FrameLevels, Light, NoiseCase, NoiseKind, NoiseTruth, NoisyParams, SceneParams, Trajectory,
    TrajectoryParams, Truth, synth_chart, synth_scene, write_burst, write_noisy, write_trajectory,
};
use clap::{Args, Subcommand};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::str::FromStr;

pub(super) fn run(args: &SynthArgs) -> Outcome {
    match &args.kind {
        SynthKind::Chart(args) => one_burst(&args.out, &args.output, |monitor| synth_chart(&args.params, monitor)),
        SynthKind::Scene(args) => one_burst(&args.out, &args.output, |monitor| synth_scene(&args.params, monitor)),
        SynthKind::Noise(args) => noise(args),
        SynthKind::Noisy(args) => noisy(args),
        SynthKind::Trajectory(args) => trajectory(args),
    }
}

/// Writes noisy copies of real frames: a first pass over the bursts measures their levels, a second one writes.
fn noisy(args: &NoisyArgs) -> Outcome {
    let console = Console::new(&args.output)?;
    let inputs = resolve(&args.inputs, &args.calibration);
    let options = open_options(&inputs, &args.calibration)?;
    // Before the pass over all frames, which takes long.
    OutputRules::new(opened(&inputs, &options, &[]), Overwrite::Refuse).check_folder(&args.out)?;
    let exposure = args.params.exposure(&levels_of(&inputs, &options, &console)?)?;
    let names: Vec<String> = inputs.iter().map(|i| safe_file_name(&i.name)).collect();
    let open = |k: usize| -> Outcome<Burst> { inputs[k].open(&options, &console.monitor.silent()) };
    let truth = write_noisy(&args.out, &names, names.len() > 1, &args.params, &exposure, open, &console.monitor)?;
    let at_mean = if truth.noise.is_some() { " at the mean" } else { "" };
    let (frames, bursts) = (counted(truth.frames.len(), "frame"), counted(names.len(), "burst"));
    let noise = noise_words(truth.noise);
    let made = format!("{frames} of {bursts}, values times {:.4}, {noise}{at_mean}", truth.gain);
    say_made(&args.out, &made, &truth, &console)
}

pub(super) fn levels_of(inputs: &[Input], options: &OpenOptions, console: &Console) -> Outcome<FrameLevels> {
    let mut levels = FrameLevels::default();
    for input in inputs {
        console.begin(format!("{}: ", input.name));
        levels.add(&input.open(options, &console.monitor)?, &console.monitor)?;
    }
    console.begin(String::new());
    Ok(levels)
}

fn trajectory(args: &TrajectoryArgs) -> Outcome {
    let console = Console::new(&args.output)?;
    let light = args.snr.map(Light::Snr).or(args.electrons.map(Light::Electrons)).unwrap_or_default();
    let trajectory = Trajectory::new(&TrajectoryParams { light, ..args.params.clone() }, &console.monitor)?;
    write_trajectory(&args.out, &trajectory, &console.monitor)?;
    let truth = trajectory.truth();
    let light = truth.noise.map_or_else(String::new, |_| {
        format!("SNR {:.2} ({:.2} electrons at scene white), ", trajectory.snr, trajectory.electrons)
    });
    let (bursts, planes) = (counted(truth.bursts.len(), "burst"), counted(truth.planes.len(), "plane"));
    let frames = format!("{} of {}×{}", counted(truth.frames, "frame"), truth.width, truth.height);
    let made = format!("{bursts} of {frames}, {planes}, {light}{}", noise_words(truth.noise));
    say_made(&args.out, &made, &truth, &console)
}

fn one_burst(out: &Path, output: &OutputArgs, made: impl FnOnce(&Monitor) -> Result<(Burst, Truth), Error>) -> Outcome {
    let console = Console::new(output)?;
    let (burst, truth) = made(&console.monitor)?;
    write_burst(out, &burst, &truth, &console.monitor)?;
    let Truth { frames, width, height, features, noise, .. } = &truth;
    let known = format!("{} with known place and slope", counted(features.len(), "feature"));
    let made = format!("{} of {width}×{height}, {known}, {}", counted(*frames, "frame"), noise_words(*noise));
    say_made(out, &made, &truth, &console)
}

fn noise(BurstArgs { out, params, output }: &BurstArgs<NoiseArgs>) -> Outcome {
    let console = Console::new(output)?;
    let [width, height, frames] = [params.width, params.height, params.frames].map(|n| n as usize);
    let NoiseArgs { level, sigma, seed, .. } = *params;
    let burst = params.case.burst_at(level, (width, height), frames, sigma, seed, &console.monitor)?;
    let truth = Truth { width, height, frames, t0: 0.5 * (frames as f64 - 1.0), seed, ..Truth::default() };
    write_burst(out, &burst, &truth, &console.monitor)?;
    let made = format!("{} of {width}×{height}, noise alone: {}", counted(frames, "frame"), params.case.name());
    say_made(out, &made, &truth, &console)
}

fn noise_words(noise: Option<NoiseTruth>) -> String {
    let words = |noise: NoiseTruth| format!("noise {:.5} of full scale in a frame", noise.sigma_background);
    noise.map_or_else(|| "no noise".to_owned(), words)
}

fn say_made(out: &Path, made: &str, truth: &impl Serialize, console: &Console) -> Outcome {
    console.say(&format!("{made}\nwrote {}\n", out.display()))?;
    console.say_document("synth", &document! { folder: path_text(out), truth })
}

/// Make a burst with exactly known truth (16-bit PNG frames and truth.json), or noisy copies of real frames.
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
    Chart(BurstArgs<ChartParams>),
    /// Textured layers at several depths, each with its own slope.
    Scene(BurstArgs<SceneParams>),
    /// Noise alone, as cameras and files make it.
    Noise(BurstArgs<NoiseArgs>),
    Noisy(NoisyArgs),
    Trajectory(TrajectoryArgs),
}

const OUT_HELP: &str = "Folder to make, for frame_000.png … or view_00_00.png … (16 bit) and truth.json; an earlier synthetic burst in it is replaced";
/// A burst of one kind, with the parameters of that kind.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct BurstArgs<P: Args> {
    #[arg(long, short, value_name = "DIR", help = OUT_HELP)]
    pub out: PathBuf,
    #[command(flatten)]
    pub params: P,
    #[command(flatten)]
    pub output: OutputArgs,
}

/// A burst of noise, in which 'evaluate noise' counts.
#[derive(Debug, Clone, Args)]
pub struct NoiseArgs {
    /// Kind of the noise, as 'evaluate noise --case' takes it.
    #[arg(long, value_name = "CASE", value_parser = NoiseKind::from_str, default_value = "white")]
    pub case: NoiseKind,
    /// Standard deviation of a frame, fraction of full scale.
    #[arg(long, default_value_t = 0.02)]
    pub sigma: f64,
    /// Grey level, fraction of full scale.
    #[arg(long, default_value_t = NoiseCase::LEVEL)]
    pub level: f64,
    /// Columns.
    #[arg(long, default_value_t = 800, value_parser = sides())]
    pub width: u64,
    /// Rows.
    #[arg(long, default_value_t = 600, value_parser = sides())]
    pub height: u64,
    /// Frames.
    #[arg(long, default_value_t = 10, value_parser = sides())]
    pub frames: u64,
    /// Seed: the same seed makes the same burst on every machine.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

fn sides() -> clap::builder::RangedU64ValueParser {
    clap::value_parser!(u64).range(1..=8192)
}

/// Noisy copies of real frames, as our camera would have taken them in the dark.
///
/// The frames are the signal, and one camera with shot noise, read noise and rounding captures them all anew. The
/// originals are then the gold standard for the copies. Frames keep their names and order; a dataset's bursts stay
/// apart, each in a subfolder.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct NoisyArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    pub inputs: Vec<PathBuf>,
    /// Folder to make, for the frames (16-bit PNG) and noise.json; earlier noisy copies in it are replaced.
    #[arg(long, short, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub params: NoisyParams,
    #[command(flatten)]
    pub calibration: OpenOptions,
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Bursts along a camera's way past textured planes, with its poses.
///
/// The planes lie at several depths and are drawn in perspective from the pose that the camera has in each frame, so
/// the apparent motion follows from the depth. The folder holds bursts/ (a folder of frames for each), gold/ (the view
/// at each mid-burst without noise), poses.txt (lines 'timestamp tx ty tz qx qy qz qw': the burst's number, the camera
/// in the world at mid-burst), lens.toml (the camera, for --camera) and trajectory.json (everything else that is
/// known).
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true, after_long_help = HELP)]
pub struct TrajectoryArgs {
    /// Folder to make; an earlier trajectory in it is replaced.
    #[arg(long, short, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub params: TrajectoryParams,
    /// Signal-to-noise ratio of one pixel in one frame: the standard deviation of all pixels of the scene over that of
    /// the noise at their mean; 'inf' makes no noise [default: 0.3].
    #[arg(long, value_name = "RATIO", conflicts_with = "electrons")]
    pub snr: Option<f64>,
    /// Electrons that scene white makes in a pixel of a frame, in place of a ratio.
    #[arg(long, value_name = "ELECTRONS")]
    pub electrons: Option<f64>,
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
