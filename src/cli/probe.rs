//! Questions about one burst: `probe` reports why a place has a feature, or why not; `slopes` the slopes that it needs;
//! `decoys` how much of its features is found as well when the frames are in other orders.

use super::args::two;
use super::set_up::{SetUpArgs, depths, depths_text, say_slopes};
use super::study::{FIGURE_FILE, figure_file};
use super::{
    Both, BurstSearchArgs, BurstsArgs, Console, Failure, INPUT_HELP, OneBurst, Outcome, OverwriteArgs, document,
};
use crate::burst::Positions;
use crate::error::Error;
use crate::files::path_text;
use crate::inspect::ProbeCache;
use crate::inspect::place::{Probe, ProbeOptions, ProbeSubject, check_place, outside, probe};
use crate::inspect::report::{decoys_text, probe_figure, probe_text, spectrum_figure, spectrum_text};
use crate::inspect::result::{DecoyStudy, decoys};
use crate::inspect::slopes::{Spectrum, spectrum};
use crate::monitor::Stage;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

pub(super) fn run(args: &ProbeArgs) -> Outcome {
    let params = args.bursts.run.search.params()?;
    let OneBurst { console, input, options, rules } = args.bursts.begin("probe", &[args.plot.as_ref()])?;
    let burst = input.open_to_search(&options, &params, &console.monitor)?;
    if let Some(place) = args.at {
        // Checked before the long search.
        check_place(place, burst.size())?;
    }
    let cache = ProbeCache::new(&burst, &params, &console.monitor)?;
    let wanted = args.feature.map_or(ProbeSubject::Best, ProbeSubject::Feature);
    let asked = ProbeOptions { wanted, ..ProbeOptions::default() };
    let answer = probe(&cache, args.at.unwrap_or_default(), &asked, &console.monitor)?;
    console.monitor.check()?;
    if let Some(path) = &args.plot {
        console.monitor.report(Stage::Write, 0.0);
        rules.check(path)?;
        probe_figure(&answer, &input.name).write(path)?;
    }
    let mut text = String::new();
    text.extend(cache.finding.iter().map(|finding| format!("slopes {}\n", finding.summary())));
    text += &probe_text(&answer, &input.name);
    text.extend(args.plot.iter().map(|path| format!("wrote {}\n", path.display())));
    console.say(&text)?;
    let (width, height) = burst.size();
    let other = document! {
        name: &input.name, inputs: input.path_texts(), width, height, frames: burst.len(),
        plot: args.plot.as_deref().map(path_text),
    };
    console.say_document("probe", &Both { one: probe_document(&cache, &answer), other })
}

/// Part of `probe --json` about a search in memory.
pub fn probe_document(cache: &ProbeCache, answer: &Probe) -> impl Serialize {
    let detection = cache.detection();
    document! {
        params: &cache.asked, slope_grid: cache.params().used_slopes(),
        noise_gate_factor: detection.noise_gate_factor, features: detection.features.len(), probe: answer,
    }
}

const SEARCH_SHARE: f32 = 0.8;

pub(super) fn run_slopes(args: &SlopesArgs) -> Outcome {
    let mut params = args.run.search.params()?;
    let set_up = args.set_up.set_up();
    // The set-up alone gives slopes: no burst is opened.
    if args.inputs.is_empty() {
        let set_up = set_up.ok_or_else(|| {
            Failure::usage("slopes: name a burst, or give the set-up with --speed, --fps, --focal-px and --depth")
        })?;
        let console = Console::new(&args.run.output)?;
        let slopes = SetUpArgs::slopes(&set_up, &Positions::even(args.set_up.frame_count), &params.at_given())?;
        return say_slopes(&console, &set_up, &slopes);
    }
    let bursts = BurstsArgs { inputs: args.inputs.clone(), run: args.run.clone(), overwrite: args.overwrite };
    let OneBurst { console, input, options, rules } = bursts.begin("slopes", &[args.plot.as_ref()])?;
    let burst = input.open_to_search(&options, &params, &console.monitor)?;
    let mut asked = None;
    if let Some(set_up) = &set_up {
        let positions = burst.positions.part(params.used_frames(burst.len()));
        let slopes = SetUpArgs::slopes(set_up, &positions, &params.at_given())?;
        // A range that the user gave is searched and judged; otherwise the slopes of the set-up are searched.
        if params.slopes.is_auto() {
            params.slopes = slopes.grid.into();
        }
        asked = Some(slopes);
    }
    let cache = ProbeCache::new(&burst, &params, &console.monitor.part(0.0, SEARCH_SHARE))?;
    let answer = spectrum(&cache, &console.monitor.part(SEARCH_SHARE, 1.0 - SEARCH_SHARE))?;
    console.monitor.check()?;
    let mut text = spectrum_text(&answer, &input.name);
    let depths = set_up.as_ref().map(|set_up| depths(set_up, &answer));
    if let (Some(set_up), Some(slopes), Some(depths)) = (&set_up, &asked, &depths) {
        text += &format!("{}\n  {}\n{}", slopes.sentence(set_up), slopes.options(), depths_text(depths));
    }
    if let Some(path) = &args.plot {
        console.monitor.report(Stage::Write, 0.0);
        rules.check(path)?;
        spectrum_figure(&answer, &input.name).write(path)?;
        text += &format!("wrote {}\n", path.display());
    }
    console.say(&text)?;
    let (width, height) = burst.size();
    let other = document! {
        name: &input.name, inputs: input.path_texts(), width, height, set_up, set_up_slopes: asked, depths,
        plot: args.plot.as_deref().map(path_text),
    };
    console.say_document("slopes", &Both { one: slopes_document(&cache, &answer), other })
}

/// Part of `slopes --json` about a search in memory.
pub fn slopes_document(cache: &ProbeCache, answer: &Spectrum) -> impl Serialize {
    document! { params: &cache.asked, most_features_at: answer.most_features(), spectrum: answer }
}

/// Say which slopes a burst needs: its spectrum, what lies at the limit, and what to change.
///
/// Give the ranges that you search to have them judged; otherwise slopes are found. The features at each slope stand
/// beside the evidence: what the frames have in common there, before any threshold, also beyond the range. Advice is
/// about range, step, direction, frames that add nothing, repeating textures, and cost.
#[derive(Debug, Args)]
#[command(after_long_help = SLOPES_HELP)]
pub struct SlopesArgs {
    #[arg(value_name = "INPUT", help = INPUT_HELP)]
    pub inputs: Vec<PathBuf>,
    /// Draw the answer as a figure, or write its numbers as CSV or LaTeX (.tex): those at each slope.
    #[arg(long, value_name = FIGURE_FILE, value_parser = figure_file())]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    pub set_up: SetUpArgs,
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

const SLOPES_HELP: &str = "\
Examples:
  burstscope slopes night/                                which slopes, and why
  burstscope slopes night/ --slopes-u -3:3:7              is this range right?
  burstscope slopes night/ --slopes-u -3:3:7 --plot slopes.svg
  burstscope slopes --speed 0.5 --fps 30 --focal-px 1200 --depth 1:8 --turn-deg-s 3    from the set-up; with night/ also the depths of its slopes

JSON (--json), beside version, params, name and inputs:
  \"set_up\", \"set_up_slopes\": {\"nearest\", \"farthest\", \"grid\", \"step\"}, \"depths\": [{\"slope\", \"features\", \"depth_m\" or null}], with --speed
  \"most_features_at\": {\"u\", \"v\"} or null, not counting the ends of the range
  \"spectrum\": {\"grid\", \"frames\", \"features\", \"at_limit\", \"judgement\": {\"sentence\", \"fits\", \"advice\" or null}, \"finding\" (as slopes_found of detect), \"cost\": {\"slopes\", \"samples\", \"search_secs\"},
    \"bars\": [{\"at\": [i, j], \"slope\": {\"u\", \"v\"}, \"is_searched\", \"is_on_rim\", \"features\", \"at_limit\", \"evidence\" (0 … 1), \"coverage\" (0 … 1)}],
    \"advice\": [{\"subject\": range, step, direction, frames, coverage or cost, \"number\", \"sentence\", \"changes\": [{\"parameter\", \"value\"}]}]}";

/// Say why there is a feature at a place, or why there is none.
///
/// Every candidate near the place (a sample that stands out in place and scale at its own slope, however weak) goes
/// through the tests of the search again: what it has, what is required, what beat it, all tests that it fails, and the
/// one option that would keep it. Candidates at the place's own motion, the slope of its strongest response, come
/// first. Of the place itself the command reports a thing too small for the smallest scale, with the option that finds
/// it, and a feature at another slope. The shares of single frames along the motion show whether one thing moves, or
/// two cross in a ghost.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("place").required(true).args(["at", "feature"])), after_long_help = PROBE_HELP)]
pub struct ProbeArgs {
    /// The place, in pixels at mid-burst: column and row; the centre of the first pixel is 0,0.
    #[arg(long, value_name = "U,V", allow_hyphen_values = true, value_parser = parse_place)]
    pub at: Option<[f32; 2]>,
    /// The place of this feature, counted from 0 in the order of 'detect'.
    #[arg(long, value_name = "N")]
    pub feature: Option<usize>,
    /// Draw the answer as a figure: the response over slope and scale, each frame's share, a slice along the motion,
    /// and the tests; or write its numbers as CSV or LaTeX (.tex): the response over slopes and frames.
    #[arg(long, value_name = FIGURE_FILE, value_parser = figure_file())]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    pub bursts: BurstsArgs,
}

const PROBE_HELP: &str = "\
Examples:
  burstscope probe night/ --at 412,230
  burstscope probe night/ --at 412,230 --slopes-u -3:3:7 --plot why.svg
  burstscope probe night/ --feature 0 --json

JSON (--json), beside version, params, name, inputs and what was searched:
  \"probe\": {\"pos_image\", \"summary\", \"samples\",
    \"reasons\": [{\"kind\": too-small, at-another-slope or ghost, \"slope\", \"sentence\", \"sigma_and_snr\": [sigma, snr] or null, \"feature\": index or null, \"change\" or null}],
    \"motion\": {\"slope\", \"sigma\"} or null, \"own_slope\": {\"u\", \"v\"} or null,
    \"fates\": [{\"octave\", \"level\", \"slope_index\", \"sample\": [x, y], \"pos_image\", \"sigma\", \"slope\": {\"u\", \"v\"}, \"edge\": {\"direction\", \"along_motion\"} or null, \"value\", \"snr\", \"sigma_d\",
      \"tests\": [{\"test\", \"outcome\": passes, fails, not-asked or unknown, \"value\", \"limit\", \"side\": at-least or at-most, \"unit\", \"rival\"}],
      \"first_failed\": test or null, \"features\": [index], \"verdict\", \"remedy\": {\"sentence\", \"change\": {\"parameter\", \"value\"}, \"then_fails\"}}],
    \"subject\", \"response\": {\"scales\", \"slopes\", \"snr\": [row], \"gate\", \"plane\"}, \"shares\": {\"frames\", \"coherence\", \"shape\", \"meaning\"},
    \"outlook\": {\"factor\", \"frames_now\", \"frames\", \"frames_inside\", \"exposure\", \"shot_part\", \"speed\", \"sentence\"} or null,
    \"judged\": {\"verdict\": real, ghost, alias, duplicate or unclear, \"coherence\", \"why\"} or null,
    \"suspicions\": [{\"kind\", \"evidence\", \"number\", \"other\", \"change\"}]}";

pub(super) fn check_inside([u, v]: [f32; 2], (width, height): (usize, usize)) -> Result<(), Error> {
    let inside = u >= 0.0 && v >= 0.0 && u <= (width - 1) as f32 && v <= (height - 1) as f32;
    if inside { Ok(()) } else { Err(outside([u, v], (width, height))) }
}

pub(super) fn parse_place(text: &str) -> Result<[f32; 2], String> {
    two(text, ',', f32::is_finite).ok_or_else(|| format!("'{text}' is not U,V in pixels, such as 412,230.5"))
}

/// Estimate which part of the features is false, by searching copies whose frames are in other orders.
///
/// The copies are searched with the noise, the gates and the slopes of the burst. Nothing moves in them as it did, so
/// their features are false: noise, or clutter of single frames. The answer is the number of features in a copy for
/// each feature of the burst, above some SNRs. It tends to be too high, and may exceed 1, because in a copy no true
/// feature takes the place of a false one. Features that hardly move are found in copies too, true or not; if there are
/// many, the answer says so.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = DECOYS_HELP)]
pub struct DecoysArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    pub inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub study: DecoyStudy,
    #[command(flatten)]
    pub run: BurstSearchArgs,
}

const DECOYS_HELP: &str = "\
Examples:
  burstscope decoys night/
  burstscope decoys night/ --slopes-u -3:3:13 --copies 10 --json

JSON (--json), beside version, params, name, inputs, width, height and slope_grid:
  \"decoys\": {\"frames\", \"copies\", \"seed\", \"still\" (features whose places in the frames spread by less than their size),
    \"rates\": [{\"snr\" (smallest of the features counted, 0 for all), \"found\", \"in_copies\": [count], \"rate\" or null, \"error\" or null}]}
  rate is the mean of in_copies over found; error is its standard error.";

pub(super) fn run_decoys(args: &DecoysArgs) -> Outcome {
    let params = args.run.search.params()?;
    let (inputs, run, overwrite) = (args.inputs.clone(), args.run.clone(), OverwriteArgs::default());
    let OneBurst { console, input, options, .. } = BurstsArgs { inputs, run, overwrite }.begin("decoys", &[])?;
    let burst = input.open_to_search(&options, &params, &console.monitor.silent())?;
    // Checked before the long search.
    args.study.check(&params, burst.len())?;
    let of_burst = 1.0 / (args.study.copies + 1) as f32;
    let cache = ProbeCache::new(&burst, &params, &console.monitor.part(0.0, of_burst))?;
    let report = decoys(&cache.trail, &args.study, false, &console.monitor.part(of_burst, 1.0 - of_burst))?.report;
    console.monitor.check()?;
    console.say(&decoys_text(&report, &input.name))?;
    let (width, height) = burst.size();
    let document = document! {
        params, name: &input.name, inputs: input.path_texts(), width, height,
        slope_grid: cache.params().used_slopes(), decoys: report,
    };
    console.say_document("decoys", &document)
}
