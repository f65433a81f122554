//! `probe`: reports why a place has a feature, or why not.

use super::console::Console;
use super::failure::Failure;
use super::inputs::{open_options, resolve_one};
use super::inspect_args::ProbeArgs;
use super::outputs;
use crate::export::{ExportError, write_whole};
use crate::files::path_text;
use crate::inspect::figure::probe_svg;
use crate::inspect::probe::{ProbeError, Wanted};
use crate::inspect::report::probe_text;
use crate::inspect::{ProbeCache, ProbeOptions, probe};
use crate::monitor::Stage;
use serde_json::json;
use std::io::Write;
use std::path::Path;

pub(super) fn run(args: &ProbeArgs) -> Result<(), Failure> {
    let params = args.run.search.params()?;
    if let Some(path) = &args.plot {
        check_svg(path)?;
    }
    let console = Console::new(&args.run.output)?;
    let input = resolve_one(&args.inputs, "probe")?;
    let options = open_options(std::slice::from_ref(&input), &args.run.calibration)?;
    let rules = args.overwrite.rules(std::slice::from_ref(&input), &options, &[args.run.search.file.params.as_ref()]);
    outputs::check(&rules, args.plot.as_deref())?;
    console.begin(format!("{}: ", input.name));
    let burst = input.open_to_search(&options, &params, &console.monitor)?;
    let (width, height) = burst.size();
    if let Some([u, v]) = args.at {
        // Checked before the long search.
        let inside = |x: f32, n: usize| x >= -0.5 && x <= n as f32 - 0.5;
        if !(inside(u, width) && inside(v, height)) {
            return Err(ProbeError::Outside { u, v, width, height }.into());
        }
    }
    let cache = ProbeCache::new(&burst, &params, &console.monitor)?;
    let wanted = args.feature.map_or(Wanted::Best, Wanted::Feature);
    let asked = ProbeOptions { wanted, ..ProbeOptions::default() };
    let answer = probe(&cache, args.at.unwrap_or_default(), &asked, &console.monitor)?;
    console.monitor.check()?;
    if let Some(path) = &args.plot {
        console.monitor.report(Stage::Write, 0.0);
        rules.check(path)?;
        write_text(path, &probe_svg(&answer, &input.name))?;
    }
    let mut text = String::new();
    if let Some(finding) = &cache.finding {
        text += &format!("slopes {}\n", finding.summary());
    }
    text += &probe_text(&answer, &input.name);
    if let Some(path) = &args.plot {
        text += &format!("wrote {}\n", path.display());
    }
    console.say(&text)?;
    console.say_json(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": "probe",
        "params": params,
        "name": input.name,
        "inputs": input.path_texts(),
        "width": width,
        "height": height,
        "frames": burst.len(),
        "slope_grid": cache.params().used_slopes(),
        "noise_gate_factor": cache.detection().noise_gate_factor,
        "features": cache.detection().features.len(),
        "plot": args.plot.as_deref().map(path_text),
        "probe": answer,
    }))
}

impl From<ProbeError> for Failure {
    fn from(error: ProbeError) -> Self {
        match error {
            ProbeError::Cancelled(_) => Self::Interrupted,
            ProbeError::Outside { .. } => Self::usage(format!("--at: {error}")),
            ProbeError::NoFeature { .. } => Self::usage(format!("--feature: {error}")),
            ProbeError::NoScale { .. } => Self::usage(error.to_string()),
        }
    }
}

/// Checks that a figure's name ends in `.svg`.
///
/// # Errors
/// When it is not.
pub(super) fn check_svg(path: &Path) -> Result<(), Failure> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if extension == "svg" {
        return Ok(());
    }
    Err(Failure::usage(format!("--plot: figures are written as SVG; name the file .svg: {}", path.display())))
}

/// Writes a text file whole or not at all.
pub(super) fn write_text(path: &Path, text: &str) -> Result<(), ExportError> {
    write_whole(path, |out| out.write_all(text.as_bytes()))
}
