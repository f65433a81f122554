//! `render`: the window, drawn into a PNG file without a display.

use super::args::RenderArgs;
use super::console::Console;
use super::failure::Failure;
use super::inputs::{Input, Place, resolve_one, two_of};
use crate::app::{RenderOptions, render_to_png};
use crate::engine::BurstSource;
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;

pub(super) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let params = args.search.params()?;
    let console = Console::new(&args.output)?;
    let (source, second) = sources_of(&args.inputs, "render")?;
    let options = RenderOptions {
        source,
        second,
        params,
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
        max_duration: Duration::from_secs(args.timeout),
    };
    console.begin("Drawing the window: ".to_owned());
    // The window's own workers do the work and know nothing of this console; so it waits here for whichever comes first.
    let out = args.out.clone();
    let drawing = std::thread::spawn(move || render_to_png(&options, &out));
    while !drawing.is_finished() {
        console.monitor.check()?;
        std::thread::sleep(Duration::from_millis(20));
    }
    match drawing.join() {
        Ok(result) => result.map_err(|e| Failure::Failed(e.into()))?,
        Err(_) => return Err(Failure::Failed(anyhow::anyhow!("drawing the window failed; see the message above"))),
    }
    console.say(&format!("wrote {}\n", args.out.display()))?;
    console.say_json(&json!({ "version": env!("CARGO_PKG_VERSION"), "command": "render", "file": args.out }))
}

/// What the window opens for `arguments`: one burst, or two side by side.
///
/// # Errors
/// When they name more, or one was not found.
pub(super) fn sources_of(arguments: &[PathBuf], command: &str) -> Result<(BurstSource, Option<BurstSource>), Failure> {
    match two_of(arguments) {
        Some([a, b]) => Ok((source_of(a)?, Some(source_of(b)?))),
        None => Ok((source_of(resolve_one(arguments, command)?)?, None)),
    }
}

/// What the window opens for `input`.
///
/// # Errors
/// Why the input was not found.
pub(super) fn source_of(input: Input) -> Result<BurstSource, Failure> {
    match input.place {
        Place::Demo { later: false } => Ok(BurstSource::Demo),
        Place::Demo { later: true } => Ok(BurstSource::DemoLater),
        Place::Paths(paths) => Ok(BurstSource::Paths(paths)),
        Place::Broken(error) => Err(error.into()),
    }
}
