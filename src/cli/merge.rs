//! `merge`: writes the merged image of a burst, as 32-bit float TIFF.

use super::args::MergeArgs;
use super::console::Console;
use super::failure::Failure;
use super::inputs::{open_options, resolve_one};
use super::stack::check_tiff;
use crate::baseline::merge_burst;
use crate::detector::noise::frame_noise;
use crate::detector::{DetectorParams, Method};
use crate::export::write_tiff;
use crate::files::path_text;
use crate::monitor::Stage;
use serde_json::json;

pub(super) fn run(args: &MergeArgs) -> Result<(), Failure> {
    let params = DetectorParams { method: Method::Merge, frames: args.frames, ..DetectorParams::default() };
    params.validate()?;
    check_tiff(&args.out)?;
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
    console.say_json(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": "merge",
        "file": path_text(&args.out),
        "width": width,
        "height": height,
        "frames_used": [used.start, used.end],
        "reference": merged.frame_names[0],
        "frame_noise": noise_of_frame,
        "merged_noise": noise_of_merge,
    }))
}
