//! `synth`: bursts with exactly known truth.

use super::args::{ChartArgs, OutputArgs, SceneArgs, SynthArgs, SynthKind};
use super::console::Console;
use super::failure::Failure;
use crate::burst::Burst;
use crate::synth::{ChartParams, SceneParams, Truth, synth_chart, synth_scene, write_burst};
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
    }
}

fn chart_params(args: &ChartArgs) -> ChartParams {
    let ChartArgs {
        out: _,
        width,
        height,
        discs,
        radius,
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
    ChartParams { width, height, discs, radius, gap, contrast, frames, motion, max_slope, snr, read_noise, bits, seed }
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
        "folder": out,
        "truth": truth,
    }))
}
