//! No command: the window. Where there is no display, the window as a picture and the table of features instead.

use super::args::{Cli, OutputArgs};
use super::console::{Console, print};
use super::failure::Failure;
use super::inputs::{DEMO, Input, Place, resolve_one};
use super::render::source_of;
use super::table::feature_table;
use crate::app::{RenderOptions, Startup, render_to_png};
use crate::baseline::detect;
use crate::burst::OpenOptions;
use crate::detector::DetectorParams;
use crate::export::safe_file_name;
use std::path::PathBuf;

/// Features that the table shows.
const TABLE_ROWS: usize = 20;

pub(super) fn open(cli: &Cli) -> Result<(), Failure> {
    let params = cli.params.read()?;
    let input = if cli.inputs.is_empty() {
        Input { name: DEMO.to_owned(), place: Place::Demo }
    } else {
        resolve_one(&cli.inputs, "the window")?
    };
    if !has_display() {
        return without_display(input, params);
    }
    let startup = Startup { source: Some(source_of(input)?), params, ..Startup::default() };
    crate::app::run(startup).map_err(Failure::Failed)
}

/// Whether a window can be shown. Systems other than free Unix ones always have a display.
fn has_display() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(set)
}

fn without_display(input: Input, params: DetectorParams) -> Result<(), Failure> {
    let file = PathBuf::from(format!("burstscope-{}.png", safe_file_name(&input.name)));
    print(&format!(
        "There is no display here (neither DISPLAY nor WAYLAND_DISPLAY is set).\nThe window is drawn into {} instead, and the strongest features are listed.\n\n",
        file.display()
    ))?;
    let console = Console::new(&OutputArgs { json: false, quiet: false, threads: None })?;
    let name = input.name.clone();
    console.begin(format!("{name}: "));
    let paths = input.paths();
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
    let place = if paths.is_empty() { Place::Demo } else { Place::Paths(paths) };
    let options = RenderOptions { source: source_of(Input { name, place })?, params, ..RenderOptions::default() };
    render_to_png(&options, &file)
        .map_err(|e| Failure::Failed(anyhow::Error::new(e).context("the window cannot be drawn")))?;
    console.say(&format!("wrote {}\n", file.display()))
}
