//! `render`: draws the window into a PNG file, without a display.

use super::console::Console;
use super::failure::Failure;
use super::inputs::{Input, Place, resolve};
use super::opening::{Opening, what_to_open};
use super::render_args::RenderArgs;
use crate::app::{RenderOptions, render_to_png};
use crate::dataset::DatasetSource;
use crate::files::path_text;
use crate::plane::memory;
use crate::requests::BurstSource;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Duration;

pub(super) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let params = args.search.params()?;
    let console = Console::new(&args.output)?;
    let calibration = args.calibration.options();
    let settings = [args.search.file.params.as_ref()].into_iter().chain(args.inputs.iter().map(Some));
    let rules = args.overwrite.rules(&resolve(&args.inputs), &calibration, &settings.collect::<Vec<_>>());
    let Sources { source, second, dataset, session } = sources_of(what_to_open(&args.inputs, args.sequence)?)?;
    let options = RenderOptions {
        source: source.unwrap_or(BurstSource::Demo),
        second,
        dataset,
        session,
        lesson: None,
        params,
        calibration,
        size_points: args.size,
        scale: args.scale,
        light: args.light,
        kind: args.kind,
        slope: args.slope,
        frame: args.frame,
        octave: args.octave,
        level: args.level,
        detect: !args.no_detect,
        select_strongest: args.select_strongest,
        rules,
        max_duration: Duration::from_secs(args.timeout),
        monitor: console.monitor.clone(),
    };
    console.begin("Drawing the window: ".to_owned());
    drawn(&options, &args.out)?;
    console.say(&format!("wrote {}\n", args.out.display()))?;
    console
        .say_json(&json!({ "version": env!("CARGO_PKG_VERSION"), "command": "render", "file": path_text(&args.out) }))
}

/// Draws the window into `file`. A panic of the graphics driver is returned as a failure.
pub(super) fn drawn(options: &RenderOptions, file: &Path) -> Result<(), Failure> {
    let drawing =
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| memory::refusable(|| render_to_png(options, file))));
    match drawing {
        Ok(result) => Ok(result.map_err(|refused| Failure::Failed(refused.into()))??),
        Err(_) => {
            Err(Failure::Failed(anyhow::anyhow!("the graphics adapter or its driver failed; see the message above")))
        }
    }
}

/// Content that the window opens: a burst, perhaps with a second one beside it, a dataset, or a session.
pub(super) struct Sources {
    /// First burst.
    pub source: Option<BurstSource>,
    /// Second burst, shown beside the first.
    pub second: Option<BurstSource>,
    /// Dataset.
    pub dataset: Option<DatasetSource>,
    /// Session file, in place of all others.
    pub session: Option<PathBuf>,
}

/// Turns `opening` into the window's sources.
///
/// # Errors
/// When a burst was not found.
pub(super) fn sources_of(opening: Opening) -> Result<Sources, Failure> {
    let none = Sources { source: None, second: None, dataset: None, session: None };
    match opening {
        Opening::Dataset(source) => Ok(Sources { dataset: Some(source), ..none }),
        Opening::Session(path) => Ok(Sources { session: Some(path), ..none }),
        Opening::Burst(input) => Ok(Sources { source: Some(input.source?), ..none }),
        Opening::Two([a, b]) => Ok(Sources { source: Some(a.source?), second: Some(b.source?), ..none }),
    }
}
