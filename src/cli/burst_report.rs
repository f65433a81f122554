//! `report`: a burst on one page.

use super::probe::parse_place;
use super::{BurstSearchArgs, Failure, INPUT_HELP, OneBurst, OverwriteArgs, check_ending};
use crate::burst::Info;
use crate::export::{write_drawing, write_text};
use crate::files::mark::OutputKind;
use crate::files::path_text;
use crate::inspect::ProbeCache;
use crate::inspect::place::check_place;
use crate::inspect::report::BurstPage;
use crate::inspect::result::DecoyStudy;
use crate::requests::page_drawing;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Write a burst on one page: what it is, its slopes, noise, tests, how many features are false, and places.
///
/// The page has the answers of 'info', 'slopes', 'detect', 'decoys' and 'probe': the input with what was guessed, the
/// slopes with their judgement, the noise and its gate, the features and how many copies in other orders have, how
/// many samples each test rejects, and the fate of each place of --at. As Markdown it is text and tables; as SVG, PDF
/// or PNG one sheet under a picture of the burst.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = REPORT_HELP)]
pub struct ReportArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    pub inputs: Vec<PathBuf>,
    /// The file to write: .md, .svg, .pdf or .png.
    #[arg(long, short, value_name = "FILE.md")]
    pub out: PathBuf,
    /// A place to be told about, in pixels at mid-burst: column and row. Give the option again for more places.
    #[arg(long, value_name = "U,V", allow_hyphen_values = true, value_parser = parse_place)]
    pub at: Vec<[f32; 2]>,
    #[command(flatten)]
    pub study: DecoyStudy,
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

const REPORT_HELP: &str = "\
Examples:
  burstscope report night/ --out night.md
  burstscope report night/ --out night.pdf --at 412,230 --at 96,58

JSON (--json), beside version, params, inputs and file:
  {\"info\": {as of 'info'}, \"notes\": [text], \"features\", \"frame_noise\", \"noise_gate_factor\", \"tally\": {as of 'detect'}, \"spectrum\": {as of 'slopes'},
   \"decoys\": {as of 'decoys'} or null, \"no_decoys\": the reason or null, \"places\": [{as \"probe\" of 'probe'}]}";

const SEARCH_SHARE: f32 = 0.3;

pub(super) fn run(args: &ReportArgs) -> Result<(), Failure> {
    let params = args.run.search.params()?;
    check_ending(&args.out, &["md", "svg", "pdf", "png"], "--out: name the report .md, .svg, .pdf or .png")?;
    let OneBurst { console, input, options, rules } =
        args.run.begin("report", &args.inputs, args.overwrite, &[Some(&args.out)])?;
    let silent = console.monitor.silent();
    let info = Info { name: input.name.clone(), ..input.source.clone()?.info(&options, &silent)? };
    let burst = input.open_to_search(&options, &params, &silent)?;
    // Checked before the long search. Of too few frames the page says so.
    let is_known = args.study.check(&params, burst.len()).or_else(|error| match error.subject == "copies" {
        true => Err(error),
        false => Ok(()),
    });
    is_known.and_then(|()| args.at.iter().try_for_each(|place| check_place(*place, burst.size())))?;
    let cache = ProbeCache::new(&burst, &params, &console.monitor.part(0.0, SEARCH_SHARE))?;
    let rest = console.monitor.part(SEARCH_SHARE, 1.0 - SEARCH_SHARE);
    let page = BurstPage::of((&cache, &burst, info), &args.at, &args.study, &rest)?;
    let is_text = args.out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("md"));
    let drawing = if is_text { None } else { Some(page_drawing(&page, &silent)?) };
    console.monitor.check()?;
    rules.check(&args.out)?;
    match drawing {
        None => write_text(&args.out, OutputKind::Page, page.markdown())?,
        Some(drawing) => write_drawing(&args.out, &drawing)?,
    }
    console.say(&format!("wrote {}\n", args.out.display()))?;
    let detection = cache.detection();
    console.say_document(
        "report",
        &json!({
            "params": params,
            "inputs": input.path_texts(),
            "file": path_text(&args.out),
            "info": page.info,
            "notes": burst.notes().iter().map(|note| &note.text).collect::<Vec<_>>(),
            "features": detection.features.len(),
            "frame_noise": detection.frame_noise,
            "noise_gate_factor": detection.noise_gate_factor,
            "tally": detection.tally,
            "spectrum": page.spectrum,
            "decoys": page.decoys.as_ref().ok(),
            "no_decoys": page.decoys.as_ref().err(),
            "places": page.places,
        }),
    )
}
