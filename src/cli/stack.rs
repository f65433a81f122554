//! `stack` writes a motion stack, its DoG response, all in focus or the field as TIFF; `merge` the merged frames.

use super::args::{MergeArgs, StackArgs};
use super::{
    Both, BurstSearchArgs, BurstsArgs, Console, Failure, OneBurst, Outcome, SearchArgs, check_ending, document,
};
use crate::SlopeGrid;
use crate::baseline::merge_burst;
use crate::detect::prepare;
use crate::detector::view::{combined_view, dog_view, field_view, in_focus_view};
use crate::detector::{DetectorParams, Method, MotionLayer};
use crate::detector::{field::NO_FIELD, noise::frame_noise, slopes::resolve};
use crate::export::{OutputRules, write_field_npz, write_field_pfm, write_field_tiff, write_tiff};
use crate::files::path_text;
use crate::inspect::words::counted;
use crate::monitor::Stage;
use crate::plane::Plane;
use serde::Serialize;

pub(super) fn run(args: &StackArgs) -> Outcome {
    let Some(slope) = args.slope else { return run_field(args) };
    // Only this slope is computed, so only this slope is checked.
    let params = args.bursts.run.search.params()?.at(SlopeGrid::single(slope));
    check_ending(&args.out, &["tif", "tiff"], NO_TIFF)?;
    let OneBurst { console, input, options, rules } = args.bursts.begin("stack", &[Some(&args.out)])?;
    let burst = input.open(&options, &console.monitor)?;
    // A search on merged frames has one frame, and its stack is that frame's.
    let (burst, params) = prepare(&burst, &params, &console.monitor)?;
    let image = match (args.octave, args.level) {
        (Some(octave), Some(level)) => dog_view(&burst, &params, slope, octave, level, &console.monitor)?,
        _ => combined_view(&burst, &params, slope, args.combine, &console.monitor)?,
    };
    let what = if args.octave.is_some() { "DoG response" } else { "motion-stack image" };
    let what = format!("{what} at slope ({}, {})", slope.u, slope.v);
    let more = document! { slope, combine: args.combine, octave: args.octave, level: args.level };
    write_image(args, &console, &rules, &image, &what, more)
}

/// Writes what has a slope of its own at each place: the field of motion, or all in focus.
fn run_field(args: &StackArgs) -> Outcome {
    let (endings, unfit): (&[&str], _) =
        if args.field { (&["tif", "tiff", "npz", "pfm"], NO_FIELD_FILE) } else { (&["tif", "tiff"], NO_TIFF) };
    check_ending(&args.out, endings, unfit)?;
    let params = args.bursts.run.search.params()?;
    let OneBurst { console, input, options, rules } = args.bursts.begin("stack", &[Some(&args.out)])?;
    let burst = input.open(&options, &console.monitor)?;
    // The field needs the range of slopes: unless given, it is found first.
    let (params, _) = resolve(&burst, &params, &console.monitor)?;
    let no_field = || Failure::usage(format!("{}: {NO_FIELD}", burst.name));
    if !args.field {
        let image = in_focus_view(&burst, &params, &console.monitor)?.ok_or_else(no_field)?;
        return write_image(args, &console, &rules, &image, "all in focus", document! { in_focus: true });
    }
    let field = field_view(&burst, &params, &console.monitor)?.ok_or_else(no_field)?;
    console.monitor.check()?;
    console.monitor.report(Stage::Write, 0.0);
    rules.check(&args.out)?;
    let ending = args.out.extension().map(|ending| ending.to_ascii_lowercase());
    match ending.as_ref().and_then(|ending| ending.to_str()) {
        Some("npz") => write_field_npz(&args.out, &field)?,
        Some("pfm") => write_field_pfm(&args.out, &field, burst.size())?,
        _ => write_field_tiff(&args.out, &field, burst.size())?,
    }
    let known = field.motions.iter().filter(|motion| field.is_known(motion)).count();
    let share = known as f32 / field.motions.len().max(1) as f32;
    let mut said =
        format!("field of motion: known in {:.0} % of the picture; layers, the nearest first\n", 100.0 * share);
    for (number, MotionLayer { slope, spread, share, inverse_depth }) in (1..).zip(&field.layers) {
        let (u, v) = (slope.u, slope.v);
        let moves = if inverse_depth.is_none() { "  moves by itself" } else { "" };
        said += &format!("  {number:2}  ({u:+.2}, {v:+.2}) ± {spread:.2} px/frame  {:3.0} %{moves}\n", 100.0 * share);
    }
    console.say(&format!("{said}wrote {}\n", args.out.display()))?;
    let document = document! {
        file: path_text(&args.out), cell_px: field.cell_px, columns: field.size.0, rows: field.size.1,
        known_share: share, layers: &field.layers,
    };
    console.say_document("stack", &document)
}

/// Writes an image and says what it is; `more` is about it in the document.
fn write_image(
    args: &StackArgs,
    console: &Console,
    rules: &OutputRules,
    image: &Plane,
    what: &str,
    more: impl Serialize,
) -> Outcome {
    console.monitor.check()?;
    console.monitor.report(Stage::Write, 0.0);
    rules.check(&args.out)?;
    write_tiff(&args.out, image)?;
    // Summed as f64: millions of f32 values would not keep the mean.
    let (mut low, mut high, mut sum) = (f32::INFINITY, f32::NEG_INFINITY, 0.0f64);
    for &x in image.data() {
        (low, high) = (low.min(x), high.max(x));
        sum += f64::from(x);
    }
    let mean = sum / image.data().len() as f64;
    let (width, height) = image.size();
    let numbers = format!("{width}×{height}, values {low:.5} to {high:.5}, mean {mean:.5}");
    console.say(&format!("{what}: {numbers}\nwrote {}\n", args.out.display()))?;
    let other = document! { file: path_text(&args.out), width, height, min: low, max: high, mean };
    console.say_document("stack", &Both { one: more, other })
}

const NO_TIFF: &str = "--out: float values are written as TIFF; name the file .tiff";
const NO_FIELD_FILE: &str =
    "--out: the field of motion is written as TIFF, PFM or NPZ; name the file .tiff, .pfm or .npz";

pub(super) fn run_merge(args: &MergeArgs) -> Outcome {
    let params: DetectorParams =
        DetectorParams { method: Method::Merge, frames: args.frames, ..DetectorParams::default() };
    params.validate()?;
    check_ending(&args.out, &["tif", "tiff"], NO_TIFF)?;
    let (search, calibration) = (SearchArgs::default(), args.calibration.clone());
    let run = BurstSearchArgs { search, calibration, output: args.output };
    let bursts = BurstsArgs { inputs: args.inputs.clone(), run, overwrite: args.overwrite };
    let OneBurst { console, input, options, rules } = bursts.begin("merge", &[Some(&args.out)])?;
    let burst = input.open(&options, &console.monitor)?;
    // Of the search parameters only the frames matter here: an image of any size is merged.
    params.validate_frames(burst.len())?;
    let used = params.used_frames(burst.len());
    let merged = merge_burst(&burst, used.clone(), &console.monitor)?;
    // The noise of frame and image, which report the gain of merging.
    let noise_of_frame = frame_noise(&burst, used.clone(), &console.monitor)?;
    let noise_of_merge = frame_noise(&merged, 0..1, &console.monitor)?;
    console.monitor.check()?;
    console.monitor.report(Stage::Write, 0.0);
    rules.check(&args.out)?;
    write_tiff(&args.out, &merged.frames[0])?;
    let (width, height) = merged.size();
    let frames = used.len();
    console.say(&format!(
        "{} of {width}×{height} merged where frame {} is; noise {noise_of_frame:.5} of full scale in a frame, {noise_of_merge:.5} in the image \
         ({:.5} if all were averaged)\nwrote {}\n",
        counted(frames, "frame"),
        merged.frame_names[0],
        noise_of_frame / (frames as f32).sqrt(),
        args.out.display()
    ))?;
    let document = document! {
        file: path_text(&args.out), width, height, frames_used: [used.start, used.end],
        reference: &merged.frame_names[0], frame_noise: noise_of_frame, merged_noise: noise_of_merge,
    };
    console.say_document("merge", &document)
}
