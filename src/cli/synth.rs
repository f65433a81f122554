//! `synth`: writes bursts with exactly known truth, and noisy copies of real ones.

use super::console::Console;
use super::failure::Failure;
use super::inputs::{open_options, resolve};
use super::output_args::OutputArgs;
use super::outputs::opened;
use super::synth_args::{ChartArgs, NoisyArgs, SceneArgs, SynthArgs, SynthKind};
use super::trajectory_args::TrajectoryArgs;
use crate::burst::Burst;
use crate::export::{OutputRules, Overwrite, safe_file_name};
use crate::files::path_text;
use crate::synth::{
    ChartParams, FrameLevels, NoisyParams, SceneParams, Trajectory, Truth, synth_chart, synth_scene, write_burst,
    write_noisy, write_trajectory,
};
use serde_json::json;
use std::path::Path;

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
        levels.add(&input.open(&options, &console.monitor)?);
    }
    let exposure = params.exposure(&levels)?;
    let names: Vec<String> = inputs.iter().map(|i| safe_file_name(&i.name)).collect();
    let open = |k: usize| -> Result<Burst, Failure> { Ok(inputs[k].open(&options, &console.monitor.silent())?) };
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

fn chart_params(args: &ChartArgs) -> ChartParams {
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

fn scene_params(args: &SceneArgs) -> SceneParams {
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
