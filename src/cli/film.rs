//! `film` writes a sweep over slope, scale or frames as an animation.

use super::args::parse_slope;
use super::{BurstsArgs, Failure, OneBurst, Outcome, document};
use crate::detect::search;
use crate::detector::{Method, Slope};
use crate::export::film::{check_film, estimated_film_bytes, film_files, is_film};
use crate::export::rasterise;
use crate::files::path_text;
use crate::inspect::words::counted;
use crate::requests::{BurstSource, Film, OpenBurst, Sweep};
use clap::Args;
use std::path::PathBuf;
use std::sync::Arc;

/// Write a sweep over slope, scale or frames as an animation.
///
/// Each picture has the features of its step in the colours of their slopes, the numbers of the step, and a legend.
/// Pictures share one range of values. The command prints number, size and rate of the pictures, and the estimated size
/// of the file (not of an MP4), before it writes.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = FILM_HELP)]
pub struct FilmArgs {
    /// What changes from picture to picture: slope-u=MIN:MAX:COUNT or slope-v=MIN:MAX:COUNT in pixels per frame; scale,
    /// the DoG of every octave and level; or frames, added one by one.
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
    /// The file to write: .gif; .mp4, by the ffmpeg in PATH; or .png for a picture each, sweep-000.png, sweep-001.png,
    /// … for sweep.png.
    #[arg(long, short, value_name = "FILE")]
    pub out: PathBuf,
    #[command(flatten)]
    pub bursts: BurstsArgs,
}

const FILM_HELP: &str = "\
Examples:
  burstscope film night/ --sweep slope-u=-3:3:49 --out sweep.gif
  burstscope film night/ --sweep frames --slope -2.1,0 --out frames.gif
  burstscope film night/ --sweep scale --out scale.mp4

JSON (--json): {\"version\", \"commit\", \"detector_revision\", \"command\": \"film\", \"file\", \"pictures\", \"width\", \"height\", \"rate\", \"features\", \"estimated_bytes\" (null for MP4), \"bytes\"}";

pub(super) fn run(args: &FilmArgs) -> Outcome {
    let mut params = args.bursts.run.search.params()?;
    if !is_film(&args.out) {
        return Err(Failure::usage(format!(
            "--out: films are GIF, MP4, or a PNG file for each picture; name the file .gif, .mp4 or .png: {}",
            args.out.display()
        )));
    }
    check_film(&args.out)?;
    if !args.no_features {
        // Marks of a film have slopes, whichever method the options name.
        params.method = Method::Buff;
    }
    // The names of a series are known once its pictures are counted, which needs the burst.
    let named = film_files(&args.out, 0);
    let OneBurst { console, input, options, rules } = args.bursts.begin("film", &[named.first()])?;
    let burst = input.open(&options, &console.monitor.part(0.0, 0.1))?;
    params.at_given().validate_for(&burst.positions, burst.size())?;
    let mut film = Film {
        burst: OpenBurst::new(burst, BurstSource::Paths(input.paths().to_vec())),
        params: params.at_given(),
        sweep: args.sweep,
        slope: args.slope,
        detection: None,
        max_side_px: args.max_side as usize,
    };
    let count = film.steps().len();
    let files = film_files(&args.out, count);
    // Asked again when the pictures are made, because somebody may have written there meanwhile.
    let may_write = || files.iter().try_for_each(|file| rules.check(file));
    may_write()?;
    if !args.no_features {
        let searched = search(&film.burst.burst, &params, &console.monitor.part(0.1, 0.3))?;
        (film.params, film.detection) = (searched.params, Some(Arc::new(searched.detection)));
    }
    let features = film.detection.as_ref().map_or(0, |detection| detection.features.len());
    // Two pictures come first, because the size of the file is reported before the long work.
    let [first, middle] = film.samples(&rasterise, &console.monitor.part(0.4, 0.1))?;
    let (width, height) = first.dimensions();
    let estimated = estimated_film_bytes(&args.out, [&first, &middle], count);
    let megabytes = |bytes: u64| format!("{:.1} MB", bytes as f64 * 1e-6);
    console.say(&format!(
        "{} of {width}×{height}, {} a second{}\n",
        counted(count, "picture"),
        args.rate,
        estimated.map_or_else(String::new, |bytes| format!(", about {}", megabytes(bytes)))
    ))?;
    film.write(&args.out, args.rate, &rasterise, &may_write, &console.monitor.part(0.5, 0.5))?;
    let bytes: u64 = files.iter().filter_map(|file| Some(std::fs::metadata(file).ok()?.len())).sum();
    let names = match &files[..] {
        [first, .., last] => format!("{} to {}", first.display(), last.display()),
        _ => files[0].display().to_string(),
    };
    console.say(&format!("wrote {names}, {}\n", megabytes(bytes)))?;
    let document = document! {
        file: path_text(&files[0]), pictures: count, width, height, rate: args.rate, features,
        estimated_bytes: estimated, bytes,
    };
    console.say_document("film", &document)
}
