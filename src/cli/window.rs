//! No command: the window. Where there is no display, the window as a picture and the table of features instead.

use super::args::{Cli, OutputArgs};
use super::console::{Console, print};
use super::failure::Failure;
use super::inputs::{Input, resolve_one, two_of};
use super::render::{source_of, sources_of};
use super::table::feature_table;
use crate::app::{RenderOptions, Startup, render_to_png};
use crate::burst::OpenOptions;
use crate::detector::{DetectorParams, detect};
use crate::export::safe_file_name;
use std::path::PathBuf;

/// Features that the table shows.
const TABLE_ROWS: usize = 20;

pub(super) fn open(cli: &Cli) -> Result<(), Failure> {
    let params = cli.params.read()?;
    if has_display() {
        let (source, second) = match cli.inputs.as_slice() {
            [] => (source_of(Input::demo(false))?, None),
            inputs => sources_of(inputs, "the window")?,
        };
        let startup = Startup { source: Some(source), second, params, ..Startup::default() };
        return crate::app::run(startup).map_err(Failure::Failed);
    }
    match cli.inputs.as_slice() {
        [] => without_display(Input::demo(false), None, params),
        inputs => match two_of(inputs) {
            Some([a, b]) => without_display(a, Some(b), params),
            None => without_display(resolve_one(inputs, "the window")?, None, params),
        },
    }
}

/// Whether a window can be shown. Systems other than free Unix ones always have a display.
fn has_display() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(set)
}

/// The features listed are those of `input`; the picture shows `second` beside it, if there is one.
fn without_display(input: Input, second: Option<Input>, params: DetectorParams) -> Result<(), Failure> {
    let file = PathBuf::from(format!("burstscope-{}.png", safe_file_name(&input.name)));
    print(&format!(
        "There is no display here (neither DISPLAY nor WAYLAND_DISPLAY is set).\nThe window is drawn into {} instead, and the strongest features are listed.\n\n",
        file.display()
    ))?;
    let console = Console::new(&OutputArgs { json: false, quiet: false, threads: None })?;
    let name = input.name.clone();
    console.begin(format!("{name}: "));
    let burst = input.open(&OpenOptions::default(), &console.monitor)?;
    let detection = detect(&burst, &params, &console.monitor)?;
    console.say(&format!(
        "{name}: {} frames of {}×{}, {} features\n\n{}\n",
        burst.len(),
        burst.size().0,
        burst.size().1,
        detection.features.len(),
        feature_table(&detection, TABLE_ROWS)
    ))?;
    let second = second.map(source_of).transpose()?;
    let options = RenderOptions { source: source_of(input)?, second, params, ..RenderOptions::default() };
    render_to_png(&options, &file)
        .map_err(|e| Failure::Failed(anyhow::Error::new(e).context("the window cannot be drawn")))?;
    console.say(&format!("wrote {}\n", file.display()))
}
