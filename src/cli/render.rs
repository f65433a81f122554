//! `render`: the window, drawn into a PNG file without a display.

use super::console::Console;
use super::failure::Failure;
use super::inputs::{Input, Place};
use super::opening::{Opening, what_to_open};
use super::render_args::RenderArgs;
use crate::app::{RenderOptions, render_to_png};
use crate::dataset::DatasetSource;
use crate::engine::BurstSource;
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;

pub(super) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let params = args.search.params()?;
    let console = Console::new(&args.output)?;
    let Sources { source, second, dataset, session } = sources_of(what_to_open(&args.inputs, args.sequence)?)?;
    let options = RenderOptions {
        source: source.unwrap_or(BurstSource::Demo),
        second,
        dataset,
        session,
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
    // The window's own workers do the work and know nothing of this console; so it waits here for whichever comes
    // first.
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

/// What the window opens: a burst, perhaps with a second one beside it, a dataset, or a session.
pub(super) struct Sources {
    /// The burst.
    pub source: Option<BurstSource>,
    /// The second one.
    pub second: Option<BurstSource>,
    /// The dataset.
    pub dataset: Option<DatasetSource>,
    /// A session, in place of all of these.
    pub session: Option<PathBuf>,
}

/// Where what is to be opened is.
///
/// # Errors
/// Why a burst was not found.
pub(super) fn sources_of(opening: Opening) -> Result<Sources, Failure> {
    let none = Sources { source: None, second: None, dataset: None, session: None };
    match opening {
        Opening::Dataset(source) => Ok(Sources { dataset: Some(source), ..none }),
        Opening::Session(path) => Ok(Sources { session: Some(path), ..none }),
        Opening::Burst(input) => Ok(Sources { source: Some(source_of(input)?), ..none }),
        Opening::Two([a, b]) => Ok(Sources { source: Some(source_of(a)?), second: Some(source_of(b)?), ..none }),
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
        Place::Example(example) => Ok(BurstSource::Example(example)),
        Place::Paths(paths) => Ok(BurstSource::Paths(paths)),
        Place::Broken(error) => Err(error.into()),
    }
}
