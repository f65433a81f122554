//! Opens the window when no command is given; without a display draws it into a file and prints the features.

use super::failure::print;
use super::inputs::DEMO;
use super::opening::{Opening, what_to_open};
use super::render::{drawn, startup_of};
use super::report::unsigned_zero;
use super::search_options::read_params;
use super::{Cli, Console, Failure, Input, Outcome, OutputArgs, commands::Command, signals};
use crate::app::{RenderOptions, Startup};
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::detect::search;
use crate::detector::{Detection, SearchParams};
use crate::export::case::is_case;
use crate::export::{OutputRules, safe_file_name};
use crate::inspect::words::counted;
use crate::requests::BurstSource;
use crate::teach::{Lesson, built_in, built_in_names, lessons_at};
use clap::CommandFactory;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const TABLE_ROWS: usize = 20;

pub(super) fn open(cli: &Cli) -> Outcome {
    let params = match cli.inputs.as_slice() {
        // A case has its own settings. A damaged case is reported when it is opened.
        [case] if is_case(case) && cli.params.params.is_none() => read_params(case).unwrap_or_default(),
        _ => cli.params.read()?,
    };
    let calibration = cli.calibration.clone();
    if let Some(name) = &cli.lesson {
        return lesson(name, params);
    }
    let demo = [PathBuf::from(DEMO)];
    let inputs = if cli.inputs.is_empty() { &demo[..] } else { &cli.inputs };
    mistyped(inputs).map_or(Ok(()), Err)?;
    let opening = what_to_open(inputs, cli.sequence, &calibration)?;
    // Inputs are resolved first: wrong ones are errors with or without a display.
    if let Opening::Burst(Input { source: Err(error), .. }) = &opening {
        return Err(error.clone().into());
    }
    if !has_display() {
        return match opening {
            Opening::Burst(input) => without_display(input, None, params, calibration),
            Opening::Two([a, b]) => without_display(a, Some(b), params, calibration),
            Opening::Dataset(source) => dataset_without_display(source, params, calibration),
            Opening::Session(path) => {
                let name = path.file_name().map_or_else(|| "session".into(), |name| name.to_string_lossy());
                let name = name.split('.').next().unwrap_or("session").to_owned();
                let (file, console) = begin_without_display(&name, "nothing is listed")?;
                draw(Startup { session: Some(path), ..Startup::default() }, &file, &console)
            }
        };
    }
    show(Startup { params, calibration, ..startup_of(opening)? })
}

/// The error for a first input that is nothing, but a command with two letters changed; `None` for others.
fn mistyped(inputs: &[PathBuf]) -> Option<Failure> {
    let first = inputs.first().filter(|first| !first.exists())?.to_str()?;
    let first = Some(first).filter(|first| BurstSource::named(first).is_none())?;
    let distance = |command: &str| strsim::damerau_levenshtein(first, command);
    let cli = Cli::command();
    let nearest = cli.get_subcommands().map(clap::Command::get_name).min_by_key(|name| distance(name))?;
    (distance(nearest) <= 2).then(|| {
        Failure::usage(format!(
            "there is no such file or folder, and no command '{first}'; did you mean 'burstscope {nearest}'?"
        ))
    })
}

fn show(startup: Startup) -> Outcome {
    let (asked, end) = (startup.end.clone(), startup.end.clone());
    signals::on_end(move || end.make())?;
    crate::app::run(startup).map_err(Failure::Failed)?;
    if asked.is_made() { Err(Failure::Interrupted) } else { Ok(()) }
}

/// Opens the window with the lesson of this name, or at this path; without a display draws its first step.
fn lesson(name: &Path, params: SearchParams) -> Outcome {
    let (lesson, others) = lesson_named(name)?;
    let startup = Startup { lesson: Some(lesson.clone()), lessons: others, params, ..Startup::default() };
    if has_display() {
        return show(startup);
    }
    let (file, console) = begin_without_display(&lesson.name, "nothing is listed")?;
    draw(Startup { lesson: Some(lesson), ..Startup::default() }, &file, &console)
}

/// Built in, or the first one of the file or folder, with all others of that folder.
fn lesson_named(name: &Path) -> Outcome<(Arc<Lesson>, Vec<Lesson>)> {
    if let Some(lesson) = built_in().iter().find(|lesson| name.as_os_str() == lesson.name.as_str()) {
        return Ok((lesson.clone(), Vec::new()));
    }
    if !name.exists() {
        let names: Vec<&str> = built_in_names().collect();
        let wrong = format!(
            "--lesson: there is no lesson '{}'; give one of {}, or the path of a lesson's file or folder",
            name.display(),
            names.join(", ")
        );
        return Err(Failure::usage(wrong));
    }
    let lessons = lessons_at(name).map_err(|errors| {
        let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
        Failure::Failed(anyhow::anyhow!(lines.join("\n")))
    })?;
    let first = lessons.first().cloned().map(Arc::new);
    let first = first.ok_or_else(|| Failure::usage(format!("--lesson: {} holds no lesson", name.display())))?;
    Ok((first, lessons))
}

/// Whether a window can be shown. Systems other than free Unix ones always have a display.
pub(super) fn has_display() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(set)
}

/// Starts this program anew, in this process, if `cli` draws a window and there is no folder of displays.
///
/// Mesa's Vulkan driver asks a Wayland display which graphics adapter is the first one, whenever it lists them. Where
/// there is none, and no folder in which it could be, Wayland's library writes "XDG_RUNTIME_DIR is invalid" each time
/// to the standard error. An environment variable, which is read when the driver is loaded, turns this question off.
#[cfg(target_os = "linux")]
pub(super) fn without_messages_on_displays(cli: &Cli) {
    use std::os::unix::process::CommandExt;
    /// Variable that turns off Mesa's choice of the first adapter.
    const NO_CHOICE: &str = "NODEVICE_SELECT";
    /// Variables by which the user has chosen an adapter, or none.
    const CHOICES: [&str; 3] = [NO_CHOICE, "MESA_VK_DEVICE_SELECT", "DRI_PRIME"];
    let draws = cli.command.as_ref().map_or(!has_display(), |command| matches!(command, Command::Render(_)));
    let has_folder = std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_dir());
    let chooses = CHOICES.into_iter().any(|name| std::env::var_os(name).is_some());
    if draws
        && !has_folder
        && !chooses
        && let Ok(program) = std::env::current_exe()
    {
        let mut arguments = std::env::args_os();
        let name = arguments.next().unwrap_or_default();
        // Only returns where it fails: then the messages come.
        let _ = std::process::Command::new(program).arg0(name).args(arguments).env(NO_CHOICE, "1").exec();
    }
}

/// Prints that the window is drawn into a file, and `else_is_done`. Returns the file's path and the console.
fn begin_without_display(name: &str, else_is_done: &str) -> Outcome<(PathBuf, Console)> {
    let file = PathBuf::from(format!("burstscope-{}.png", safe_file_name(name)));
    if OutputRules::default().check(&file).is_err() {
        return Err(Failure::Failed(anyhow::anyhow!(
            "there is no display, and the file into which the window would be drawn is not one that Burstscope wrote; \
             move it away, or name another one with 'burstscope render --out': {}",
            file.display()
        )));
    }
    print(&format!(
        "There is no display here (neither DISPLAY nor WAYLAND_DISPLAY is set).\nThe window is drawn into {} instead, and {else_is_done}.\n\n",
        file.display()
    ))
    .map_err(Failure::output)?;
    Ok((file, Console::new(&OutputArgs { json: false, quiet: false, threads: None, memory: None })?))
}

fn draw(startup: Startup, file: &Path, console: &Console) -> Outcome {
    drawn(&RenderOptions { startup, monitor: console.monitor.clone(), ..RenderOptions::default() }, file)?;
    console.say(&format!("wrote {}\n", file.display()))
}

fn dataset_without_display(source: DatasetSource, params: SearchParams, calibration: OpenOptions) -> Outcome {
    let (file, console) = begin_without_display(&source.label(), "the bursts are listed")?;
    for burst in source.bursts(&calibration)? {
        match burst.files().map(|files| files.len()) {
            Ok(count) => console.say(&format!("{}: {}\n", burst.name, counted(count, "file")))?,
            Err(error) => console.complain(&format!("{}: {error}", burst.name)),
        }
    }
    draw(Startup { dataset: Some(source), params, calibration, ..Startup::default() }, &file, &console)
}

fn without_display(input: Input, second: Option<Input>, params: SearchParams, calibration: OpenOptions) -> Outcome {
    let (file, console) = begin_without_display(&input.name, "the strongest features are listed")?;
    let name = input.name.clone();
    console.begin(format!("{name}: "));
    let burst = input.open(&calibration, &console.monitor)?;
    let detection = search(&burst, &params, &console.monitor)?.detection;
    let ((width, height), frames) = (burst.size(), counted(burst.len(), "frame"));
    let features = counted(detection.features.len(), "feature");
    let table = feature_table(&detection, TABLE_ROWS);
    console.say(&format!("{name}: {frames} of {width}×{height}, {features}\n\n{table}\n"))?;
    let second = second.map(|input| input.source).transpose()?;
    let source = Some(input.source?);
    draw(Startup { source, second, params, calibration, ..Startup::default() }, &file, &console)
}

/// Lists the `count` strongest features, one on each line, under a header with units.
pub(super) fn feature_table(detection: &Detection, count: usize) -> String {
    let mut text = String::from(
        "       u       v   sigma  orientation  slope u  slope v  response     snr  octave  level\n      px      px      px          deg     px/f     px/f             sigma              \n",
    );
    for f in detection.features.iter().take(count) {
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "{:>8.2}{:>8.2}{:>8.2}{:>13.1}{:>9.2}{:>9.2}{:>10.4}{:>8.1}{:>8}{:>7}",
            unsigned_zero(f.u, 2),
            unsigned_zero(f.v, 2),
            f.sigma,
            unsigned_zero(f.orientation.to_degrees(), 1),
            unsigned_zero(f.slope.u, 2),
            unsigned_zero(f.slope.v, 2),
            unsigned_zero(f.response, 4),
            f.snr,
            f.octave,
            f.level
        );
    }
    if detection.features.len() > count {
        let _ = writeln!(text, "     … and {} more", detection.features.len() - count);
    }
    text
}
