//! Images of a burst as 32-bit float TIFF: `stack` writes the motion-stack image at a slope or its DoG response,
//! `merge` the merged frames.

use super::args::{MergeArgs, StackArgs};
use super::console::Console;
use super::failure::Failure;
use super::inputs::{OneBurst, check_ending, open_options, resolve_one};
use crate::SlopeGrid;
use crate::baseline::merge_burst;
use crate::detect::prepare;
use crate::detector::noise::frame_noise;
use crate::detector::view::{combined_view, dog_view};
use crate::detector::{DetectorParams, Method};
use crate::export::write_tiff;
use crate::files::path_text;
use crate::monitor::Stage;
use serde_json::json;

pub(super) fn run(args: &StackArgs) -> Result<(), Failure> {
    let mut params = args.run.search.params()?.detector;
    // Only this slope is computed, so only this slope is checked.
    params.slopes = SlopeGrid::single(args.slope);
    check_ending(&args.out, &["tif", "tiff"], NO_TIFF)?;
    let OneBurst { console, input, options, rules } =
        args.run.begin("stack", &args.inputs, args.overwrite, &[Some(&args.out)])?;
    let burst = input.open(&options, &console.monitor)?;
    let (burst, params) = prepare(&burst, &params, &console.monitor)?;
    let image = match (args.octave, args.level) {
        (Some(octave), Some(level)) => dog_view(&burst, &params, args.slope, octave, level, &console.monitor)?,
        _ => combined_view(&burst, &params, args.slope, args.combine, &console.monitor)?,
    };
    console.monitor.check()?;
    console.monitor.report(Stage::Write, 0.0);
    rules.check(&args.out)?;
    write_tiff(&args.out, &image)?;
    let (mut low, mut high, mut sum) = (f32::INFINITY, f32::NEG_INFINITY, 0.0f64);
    for &x in image.data() {
        (low, high) = (low.min(x), high.max(x));
        sum += f64::from(x);
    }
    let mean = sum / image.data().len() as f64;
    let (width, height) = image.size();
    console.say(&format!(
        "{} at slope ({}, {}): {width}×{height}, values {low:.5} to {high:.5}, mean {mean:.5}\nwrote {}\n",
        if args.octave.is_some() { "DoG response" } else { "motion-stack image" },
        args.slope.u,
        args.slope.v,
        args.out.display()
    ))?;
    console.say_document(
        "stack",
        &json!({
            "file": path_text(&args.out),
            "slope": args.slope,
            "combine": args.combine,
            "octave": args.octave,
            "level": args.level,
            "width": width,
            "height": height,
            "min": low,
            "max": high,
            "mean": mean,
        }),
    )
}

const NO_TIFF: &str = "--out: float values are written as TIFF; name the file .tiff";

pub(super) fn run_merge(args: &MergeArgs) -> Result<(), Failure> {
    let params = DetectorParams { method: Method::Merge, frames: args.frames, ..DetectorParams::default() };
    params.validate()?;
    check_ending(&args.out, &["tif", "tiff"], NO_TIFF)?;
    let console = Console::new(&args.output)?;
    let input = resolve_one(&args.inputs, "merge")?;
    let options = open_options(std::slice::from_ref(&input), &args.calibration)?;
    let rules = args.overwrite.rules(std::slice::from_ref(&input), &options, &[]);
    rules.check(&args.out)?;
    console.begin(format!("{}: ", input.name));
    let burst = input.open(&options, &console.monitor)?;
    // Of the search parameters only the frames matter here: an image of any size is merged.
    params.validate_frames(burst.len())?;
    let used = params.used_frames(burst.len());
    let merged = merge_burst(&burst, used.clone(), &console.monitor)?;
    let noise_of_frame = frame_noise(&burst, used.clone(), &console.monitor)?;
    let noise_of_merge = frame_noise(&merged, 0..1, &console.monitor)?;
    console.monitor.check()?;
    console.monitor.report(Stage::Write, 0.0);
    rules.check(&args.out)?;
    write_tiff(&args.out, &merged.frames[0])?;
    let (width, height) = merged.size();
    let frames = used.len();
    console.say(&format!(
        "{frames} frames of {width}×{height} merged where frame {} is; noise {noise_of_frame:.5} of full scale in a frame, {noise_of_merge:.5} in the image \
         ({:.5} if all were averaged)\nwrote {}\n",
        merged.frame_names[0],
        noise_of_frame / (frames as f32).sqrt(),
        args.out.display()
    ))?;
    console.say_document(
        "merge",
        &json!({
            "file": path_text(&args.out),
            "width": width,
            "height": height,
            "frames_used": [used.start, used.end],
            "reference": merged.frame_names[0],
            "frame_noise": noise_of_frame,
            "merged_noise": noise_of_merge,
        }),
    )
}
