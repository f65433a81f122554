//! No command: the window. Where there is no display, the window as a picture and the table of features instead.

use super::args::OutputArgs;
use super::commands::Cli;
use super::console::{Console, print};
use super::failure::Failure;
use super::inputs::{DEMO, Input};
use super::opening::{Opening, what_to_open};
use super::render::{Sources, source_of, sources_of};
use super::table::feature_table;
use crate::app::{RenderOptions, Startup, render_to_png};
use crate::baseline::search;
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::export::safe_file_name;
use std::path::{Path, PathBuf};

/// Features that the table shows.
const TABLE_ROWS: usize = 20;

pub(super) fn open(cli: &Cli) -> Result<(), Failure> {
    let params = cli.params.read()?;
    let demo = [PathBuf::from(DEMO)];
    let inputs = if cli.inputs.is_empty() { &demo[..] } else { &cli.inputs };
    let opening = what_to_open(inputs, cli.sequence)?;
    if !has_display() {
        return match opening {
            Opening::Burst(input) => without_display(input, None, params),
            Opening::Two([a, b]) => without_display(a, Some(b), params),
            Opening::Dataset(source) => dataset_without_display(source, params),
            Opening::Session(path) => session_without_display(path),
        };
    }
    let Sources { source, second, dataset, session } = sources_of(opening)?;
    let startup = Startup { source, second, dataset, params, session, ..Startup::default() };
    crate::app::run(startup).map_err(Failure::Failed)
}

/// Whether a window can be shown. Systems other than free Unix ones always have a display.
fn has_display() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(set)
}

/// Says that the window becomes a picture, and what `else_is_done`. Answers the picture's file and the console.
fn begin_without_display(name: &str, else_is_done: &str) -> Result<(PathBuf, Console), Failure> {
    let file = PathBuf::from(format!("burstscope-{}.png", safe_file_name(name)));
    print(&format!(
        "There is no display here (neither DISPLAY nor WAYLAND_DISPLAY is set).\nThe window is drawn into {} instead, and {else_is_done}.\n\n",
        file.display()
    ))?;
    Ok((file, Console::new(&OutputArgs { json: false, quiet: false, threads: None })?))
}

fn draw(options: &RenderOptions, file: &Path, console: &Console) -> Result<(), Failure> {
    render_to_png(options, file)
        .map_err(|e| Failure::Failed(anyhow::Error::new(e).context("the window cannot be drawn")))?;
    console.say(&format!("wrote {}\n", file.display()))
}

fn dataset_without_display(source: DatasetSource, params: SearchParams) -> Result<(), Failure> {
    let (file, console) = begin_without_display(&source.label(), "the bursts are listed")?;
    for burst in source.bursts()? {
        let frames = burst.files()?.len();
        console.say(&format!("{}: {frames} {}\n", burst.name, if frames == 1 { "file" } else { "files" }))?;
    }
    draw(&RenderOptions { dataset: Some(source), params, ..RenderOptions::default() }, &file, &console)
}

fn session_without_display(session: PathBuf) -> Result<(), Failure> {
    let name = session.file_name().map_or_else(|| "session".into(), |name| name.to_string_lossy());
    let name = name.split('.').next().unwrap_or("session").to_owned();
    let (file, console) = begin_without_display(&name, "nothing is listed")?;
    draw(&RenderOptions { session: Some(session), ..RenderOptions::default() }, &file, &console)
}

/// The features listed are those of `input`; the picture shows `second` beside it, if there is one.
fn without_display(input: Input, second: Option<Input>, params: SearchParams) -> Result<(), Failure> {
    let (file, console) = begin_without_display(&input.name, "the strongest features are listed")?;
    let name = input.name.clone();
    console.begin(format!("{name}: "));
    let burst = input.open(&OpenOptions::default(), &console.monitor)?;
    let detection = search(&burst, &params, &console.monitor)?.detection;
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
    draw(&options, &file, &console)
}
