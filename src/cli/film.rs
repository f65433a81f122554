//! `film` writes a sweep over slope, scale or frames as an animation.

use super::args::{BurstSearchArgs, INPUT_HELP, OverwriteArgs, parse_slope};
use super::console::Console;
use super::failure::Failure;
use super::inputs::{open_options, resolve_one};
use crate::baseline::search;
use crate::detector::Slope;
use crate::export::film::{FilmFormat, estimated_film_bytes, write_film};
use crate::files::path_text;
use crate::requests::{BurstSource, Film, OpenBurst, Sweep};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Write a sweep over slope, scale or frames as an animation.
///
/// The pictures share one range of values. Features of each step are drawn in the colours of their slopes, and a scale
/// below the picture says which step it is. Number, size and rate are said before the file is written.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = FILM_HELP)]
pub struct FilmArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    #[allow(missing_docs)]
    pub inputs: Vec<PathBuf>,
    /// What changes from picture to picture: slope-u=MIN:MAX:COUNT or slope-v=MIN:MAX:COUNT in pixels per frame; scale,
    /// the DoG of every octave and level; frames, added one by one; flip, the middle frame and the motion stack in
    /// turn.
    #[arg(long, value_name = "WHAT", value_parser = <Sweep as std::str::FromStr>::from_str)]
    pub sweep: Sweep,
    /// Slope of the pictures, where that does not change, pixels per frame to the right and down.
    #[arg(long, value_name = "U,V", allow_hyphen_values = true, value_parser = parse_slope, default_value = "0,0")]
    pub slope: Slope,
    /// Draw no features, which takes no search.
    #[arg(long)]
    pub no_features: bool,
    /// Pictures per second.
    #[arg(long, value_name = "RATE", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub rate: u16,
    /// Longest side of the pictures, pixels; larger ones are made smaller by a whole number.
    #[arg(long, value_name = "PX", default_value_t = 640, value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub max_side: u32,
    /// The file to write: .gif, or .apng or .png for an animated PNG.
    #[arg(long, short, value_name = "FILE")]
    pub out: PathBuf,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

const FILM_HELP: &str = "\
Examples:
  burstscope film night/ --sweep slope-u=-3:3:49 --out sweep.gif
  burstscope film night/ --sweep frames --slope -2.1,0 --out frames.apng

JSON (--json): {\"version\", \"command\": \"film\", \"file\", \"pictures\", \"width\", \"height\", \"rate\", \"features\", \"estimated_bytes\", \"bytes\"}";

pub(super) fn run(args: &FilmArgs) -> Result<(), Failure> {
    let mut params = args.run.search.params()?;
    let format = FilmFormat::of(&args.out).ok_or_else(|| {
        Failure::usage(format!(
            "--out: films are GIF or animated PNG; name the file .gif or .apng: {}",
            args.out.display()
        ))
    })?;
    let console = Console::new(&args.run.output)?;
    let input = resolve_one(&args.inputs, "film")?;
    let options = open_options(std::slice::from_ref(&input), &args.run.calibration)?;
    let rules = args.overwrite.rules(std::slice::from_ref(&input), &options, &[args.run.search.file.params.as_ref()]);
    rules.check(&args.out)?;
    console.begin(format!("{}: ", input.name));
    let burst = input.open(&options, &console.monitor.part(0.0, 0.1))?;
    let mut detection = None;
    if !args.no_features {
        let searched = search(&burst, &params, &console.monitor.part(0.1, 0.4))?;
        params.detector = searched.params;
        detection = Some(searched.detection);
    }
    params.detector.validate_for(burst.len(), burst.size())?;
    let features = detection.as_ref().map_or(0, |detection| detection.features.len());
    let source = BurstSource::Paths(input.paths().to_vec());
    let film = Film {
        burst: OpenBurst::new(burst, source),
        params: params.detector,
        sweep: args.sweep,
        slope: args.slope,
        detection,
        max_side_px: args.max_side as usize,
    };
    let pictures = film.pictures(&console.monitor.part(0.5, 0.3))?;
    let (width, height) = pictures[0].dimensions();
    let sample = [&pictures[0], &pictures[pictures.len() / 2]];
    let estimated = estimated_film_bytes(format, sample, pictures.len());
    let megabytes = |bytes: u64| format!("{:.1} MB", bytes as f64 * 1e-6);
    console.say(&format!(
        "{} pictures of {width}×{height}, {} a second, about {}\n",
        pictures.len(),
        args.rate,
        megabytes(estimated)
    ))?;
    rules.check(&args.out)?;
    write_film(&args.out, format, &pictures, args.rate, &console.monitor.part(0.8, 0.2))?;
    console.monitor.check()?;
    let bytes = std::fs::metadata(&args.out).map_or(0, |file| file.len());
    console.say(&format!("wrote {}, {}\n", args.out.display(), megabytes(bytes)))?;
    console.say_json(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": "film",
        "file": path_text(&args.out),
        "pictures": pictures.len(),
        "width": width,
        "height": height,
        "rate": args.rate,
        "features": features,
        "estimated_bytes": estimated,
        "bytes": bytes,
    }))
}
