//! `decoys` reports how much of a search's features it finds as well when the frames are in other orders.

use super::{BurstSearchArgs, Failure, INPUT_HELP, OneBurst, OverwriteArgs, document};
use crate::inspect::ProbeCache;
use crate::inspect::report::decoys_text;
use crate::inspect::result::{DecoyStudy, decoys};
use clap::Args;
use std::path::PathBuf;

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

pub(super) fn run(args: &DecoysArgs) -> Result<(), Failure> {
    let params = args.run.search.params()?;
    let OneBurst { console, input, options, .. } =
        args.run.begin("decoys", &args.inputs, OverwriteArgs::default(), &[])?;
    let burst = input.open_to_search(&options, &params, &console.monitor.silent())?;
    // Checked before the long search.
    args.study.check(&params, burst.len())?;
    let of_burst = 1.0 / (args.study.copies + 1) as f32;
    let cache = ProbeCache::new(&burst, &params, &console.monitor.part(0.0, of_burst))?;
    let report = decoys(&cache.trail, &args.study, &console.monitor.part(of_burst, 1.0 - of_burst))?;
    console.monitor.check()?;
    console.say(&decoys_text(&report, &input.name))?;
    let (width, height) = burst.size();
    let document = document! {
        params, name: &input.name, inputs: input.path_texts(), width, height,
        slope_grid: cache.params().used_slopes(), decoys: report,
    };
    console.say_document("decoys", &document)
}
