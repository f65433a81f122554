//! `render`: draws the window into a PNG file, without a display.

use super::args::parse_slope;
use super::opening::{Opening, what_to_open};
use super::{
    Console, Failure, INPUT_HELP, Outcome, OutputArgs, OverwriteArgs, SearchArgs, SequenceArgs, document, resolve,
};
use crate::app::document::journal::read_steps;
use crate::app::document::{Action, Steps};
use crate::app::{RenderOptions, Startup, render_to_png};
use crate::app::{actions::registry::ActionId, document::cursor::ViewKind};
use crate::burst::OpenOptions;
use crate::detector::{SearchParams, Slope};
use crate::files::{MAX_SESSION_BYTES, path_text, read_text};
use crate::plane::memory;
use crate::synth::options::words;
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Duration;

pub(super) fn run(args: &RenderArgs) -> Outcome {
    let params = args.search.params_of_window()?;
    let console = Console::new(&args.output)?;
    let calibration = args.calibration.clone();
    let sets = params != SearchParams::default() || calibration != OpenOptions::default();
    if args.play.is_some() && (sets || args.sequence.burst_length.is_some()) {
        let problem = "--play: parameters and calibration come from the list, which begins with the defaults; leave their options out";
        return Err(Failure::usage(problem.to_owned()));
    }
    let play = args.play.as_deref().map(steps_of).transpose()?;
    let settings = [args.search.file.params.as_ref(), args.play.as_ref()].into_iter();
    // Inputs are read: a session or a case among them must not be replaced by the picture.
    let settings = settings.chain(args.inputs.iter().map(Some));
    let rules = args.overwrite.rules(&resolve(&args.inputs, &calibration), &calibration, &settings.collect::<Vec<_>>());
    let startup = match play {
        Some(_) => Startup { source: None, play, ..Startup::default() },
        None => {
            let begins = startup_of(what_to_open(&args.inputs, args.sequence, &calibration)?)?;
            Startup { params, calibration, ..begins }
        }
    };
    let options = RenderOptions {
        startup,
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
    console.say_document("render", &document! { file: path_text(&args.out) })
}

/// Draws the window into `file`. A panic of the graphics driver is returned as a failure.
pub(super) fn drawn(options: &RenderOptions, file: &Path) -> Outcome {
    let drawing =
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| memory::refusable(|| render_to_png(options, file))));
    match drawing {
        Ok(drawn) => drawn?.map_err(|error| match Failure::from(error) {
            Failure::Failed(error) => Failure::Failed(error.context("the window cannot be drawn")),
            other => other,
        }),
        Err(_) => {
            Err(Failure::Failed(anyhow::anyhow!("the graphics adapter or its driver failed; see the message above")))
        }
    }
}

fn steps_of(path: &Path) -> Outcome<Steps> {
    let read = read_text(path, MAX_SESSION_BYTES).map_err(|error| error.to_string());
    // A list may come from a stranger, and would choose the folder.
    let writes = |action: &Action| matches!(action, Action::Do(ActionId::DetectAll) | Action::DetectAllAnyway);
    let harmless = |steps: Steps| match steps.iter().flatten().any(writes) {
        true => Err("'detect_all' writes files, and a list writes nothing but the picture; take it out".to_owned()),
        false => Ok(steps),
    };
    read.and_then(|text| read_steps(&text).and_then(harmless))
        .map_err(|error| Failure::usage(format!("--play: {error}: {}", path.display())))
}

pub(super) fn startup_of(opening: Opening) -> Outcome<Startup> {
    let none = Startup { source: None, ..Startup::default() };
    match opening {
        Opening::Dataset(source) => Ok(Startup { dataset: Some(source), ..none }),
        Opening::Session(path) => Ok(Startup { session: Some(path), ..none }),
        Opening::Burst(input) => Ok(Startup { source: Some(input.source?), ..none }),
        Opening::Two([a, b]) => Ok(Startup { source: Some(a.source?), second: Some(b.source?), ..none }),
    }
}

/// Draw the window into a PNG file, without a display.
///
/// Of two bursts the window shows both side by side, with the matches between them; of a dataset it shows the first.
/// The window is drawn as it is on a screen, with a software graphics driver if need be (Mesa's lavapipe on Linux).
/// Without --slope the picture is taken at the slope with the most features.
#[derive(Debug, Args)]
pub struct RenderArgs {
    #[arg(value_name = "INPUT", default_value = "demo", help = INPUT_HELP)]
    pub inputs: Vec<PathBuf>,
    /// Repeat the actions of a window, and draw it then: the list that Help > Copy what I did gives.
    ///
    /// It begins in a window with default settings. Only the picture is written.
    #[arg(long, value_name = "TOML", conflicts_with_all = ["inputs", "kind", "slope", "frame", "octave", "level", "no_detect", "light"])]
    pub play: Option<PathBuf>,
    /// The PNG file to write.
    #[arg(long, short, value_name = "PNG")]
    pub out: PathBuf,
    /// Kind of picture.
    #[arg(long, value_name = "KIND", default_value = "stack", value_parser = words::<ViewKind>(&["frame", "stack", "dog"]))]
    pub kind: ViewKind,
    /// The slope, pixels per frame to the right and down.
    #[arg(long, value_name = "U,V", allow_hyphen_values = true, value_parser = parse_slope)]
    pub slope: Option<Slope>,
    /// The frame, counted from 0 [default: the middle one].
    #[arg(long, value_name = "T")]
    pub frame: Option<usize>,
    /// Octave of the DoG response [default: the finest].
    #[arg(long, value_name = "O", allow_hyphen_values = true)]
    pub octave: Option<i32>,
    /// Level of the DoG response.
    #[arg(long, value_name = "S", allow_hyphen_values = true, default_value_t = 0)]
    pub level: i32,
    /// Size of the window, in points.
    #[arg(long, value_name = "WxH", default_value = "1280x800", value_parser = parse_size)]
    pub size: (f32, f32),
    /// Pixels for each point; 2 for a HiDPI screen.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = parse_scale)]
    pub scale: f32,
    /// Light colours instead of dark ones.
    #[arg(long)]
    pub light: bool,
    /// Draw no features, so that nothing is searched.
    #[arg(long)]
    pub no_detect: bool,
    /// Select the strongest feature, so that the side panel shows it.
    #[arg(long, conflicts_with = "no_detect")]
    pub select_strongest: bool,
    /// Give up after this many seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 600, value_parser = clap::value_parser!(u64).range(1..))]
    pub timeout: u64,
    #[command(flatten)]
    pub sequence: SequenceArgs,
    #[command(flatten)]
    pub calibration: OpenOptions,
    #[command(flatten)]
    pub search: SearchArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

fn parse_size(text: &str) -> Result<(f32, f32), String> {
    let bad = || format!("'{text}' is not WIDTHxHEIGHT from 200x150 to 8192x8192, such as 1280x800");
    let (width, height) = text.split_once(['x', '×']).ok_or_else(bad)?;
    let number = |s: &str, min: u32| {
        s.trim().parse::<u32>().ok().filter(|x| (min..=8192).contains(x)).map(|x| x as f32).ok_or_else(bad)
    };
    Ok((number(width, 200)?, number(height, 150)?))
}

fn parse_scale(text: &str) -> Result<f32, String> {
    let scale = text.parse().ok().filter(|x| (0.5..=4.0).contains(x));
    scale.ok_or_else(|| format!("'{text}' is not a factor from 0.5 to 4"))
}
