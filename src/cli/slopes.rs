//! `slopes`: reports which slopes a burst needs.

use super::console::Console;
use super::failure::Failure;
use super::inputs::{open_options, resolve_one};
use super::inspect_args::SlopesArgs;
use super::outputs;
use super::probe::{check_svg, write_text};
use crate::files::path_text;
use crate::inspect::ProbeCache;
use crate::inspect::figure::spectrum_svg;
use crate::inspect::report::spectrum_text;
use crate::inspect::spectrum::spectrum;
use crate::monitor::Stage;
use serde_json::json;

/// Share of the progress that the search takes.
const SEARCH_SHARE: f32 = 0.8;

pub(super) fn run(args: &SlopesArgs) -> Result<(), Failure> {
    let params = args.run.search.params()?;
    if let Some(path) = &args.plot {
        check_svg(path)?;
    }
    let console = Console::new(&args.run.output)?;
    let input = resolve_one(&args.inputs, "slopes")?;
    let options = open_options(std::slice::from_ref(&input), &args.run.calibration)?;
    let rules = args.overwrite.rules(std::slice::from_ref(&input), &options, &[args.run.search.file.params.as_ref()]);
    outputs::check(&rules, args.plot.as_deref())?;
    console.begin(format!("{}: ", input.name));
    let burst = input.open_to_search(&options, &params, &console.monitor)?;
    let cache = ProbeCache::new(&burst, &params, &console.monitor.part(0.0, SEARCH_SHARE))?;
    let answer = spectrum(&cache, &console.monitor.part(SEARCH_SHARE, 1.0 - SEARCH_SHARE))?;
    console.monitor.check()?;
    let mut text = spectrum_text(&answer, &input.name);
    if let Some(path) = &args.plot {
        console.monitor.report(Stage::Write, 0.0);
        rules.check(path)?;
        write_text(path, &spectrum_svg(&answer, &input.name))?;
        text += &format!("wrote {}\n", path.display());
    }
    console.say(&text)?;
    console.say_json(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": "slopes",
        "params": params,
        "name": input.name,
        "inputs": input.path_texts(),
        "width": burst.size().0,
        "height": burst.size().1,
        "most_features_at": answer.most_features(),
        "plot": args.plot.as_deref().map(path_text),
        "spectrum": answer,
    }))
}
