//! `detect`: features of one or many bursts.

use super::args::DetectArgs;
use super::console::Console;
use super::failure::Failure;
use super::inputs::{Input, open_options, resolve_bursts};
use super::report::{BurstReport, DetectReport, FailureReport, summary};
use crate::burst::OpenOptions;
use crate::detector::{DetectorParams, detect};
use crate::export::{ExportFormat, write_detection};
use crate::monitor::Stage;
use std::path::Path;
use std::time::Instant;

pub(super) fn run(args: &DetectArgs) -> Result<(), Failure> {
    let params = args.search.params()?;
    if args.out.exists() && !args.out.is_dir() {
        return Err(Failure::usage(format!(
            "--out: this is not a folder; name a folder for the features: {}",
            args.out.display()
        )));
    }
    let mut formats = args.format.clone();
    formats.sort_unstable();
    formats.dedup();
    let console = Console::new(&args.output)?;
    let inputs = resolve_bursts(&args.inputs, args.sequence)?;
    let options = open_options(&inputs, args.bias.bias.as_ref())?;
    let count = inputs.len();
    let mut report = DetectReport::new(&params);
    for (index, input) in inputs.into_iter().enumerate() {
        let name = input.name.clone();
        console.begin(if count > 1 { format!("[{}/{count}] {name}: ", index + 1) } else { format!("{name}: ") });
        match one_burst(input, &options, &params, &args.out, &formats, &console) {
            Ok(burst) => report.bursts.push(burst),
            Err(Failure::Interrupted) => return Err(Failure::Interrupted),
            Err(Failure::Failed(error) | Failure::Usage(error)) => {
                console.complain(&format!("{name}: {error:#}"));
                report.failures.push(FailureReport { name, error: format!("{error:#}") });
            }
            Err(Failure::Reported) => report.failures.push(FailureReport { name, error: String::new() }),
        }
    }
    if count > 1 {
        let features: usize = report.bursts.iter().map(|b| b.features).sum();
        let done = report.bursts.len();
        console.say(&format!("{done} of {count} bursts done, {features} features in {}\n", args.out.display()))?;
    }
    console.say_json(&report)?;
    if report.failures.is_empty() { Ok(()) } else { Err(Failure::Reported) }
}

fn one_burst(
    input: Input,
    options: &OpenOptions,
    params: &DetectorParams,
    out: &Path,
    formats: &[ExportFormat],
    console: &Console,
) -> Result<BurstReport, Failure> {
    let (name, paths) = (input.name.clone(), input.paths());
    let start = Instant::now();
    let burst = input.open(options, &console.monitor)?;
    let open_secs = start.elapsed().as_secs_f32();
    let detection = detect(&burst, params, &console.monitor)?;
    // From here on the features are written for good; a Ctrl-C stops before the next burst.
    console.monitor.check()?;
    console.monitor.report(Stage::Write, 0.0);
    let start = Instant::now();
    let files = write_detection(out, &name, &detection, formats)?;
    let write_secs = start.elapsed().as_secs_f32();
    let files = formats.iter().map(ToString::to_string).zip(files).collect();
    let report = BurstReport::new(&name, paths, &burst, &detection, files, open_secs, write_secs);
    console.say(&summary(&report, params, &detection))?;
    Ok(report)
}
