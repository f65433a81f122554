//! `report`: a burst on one page, or the bursts of a flight.

use super::probe::parse_place;
use super::{
    Both, BurstsArgs, Console, Failure, Input, OneBurst, Outcome, SequenceArgs, check_ending, document, open_options,
    resolve_bursts,
};
use crate::burst::Info;
#[cfg(feature = "colmap")]
use crate::dataset::read_exported;
use crate::dataset::{ColmapReport, PairReport};
use crate::export::{Figure, write_text};
use crate::files::mark::OutputKind;
use crate::files::path_text;
use crate::inspect::ProbeCache;
use crate::inspect::place::check_place;
use crate::inspect::report::{BurstHealth, BurstPage, FlightRow, flight_page, flight_table, worst_bursts};
use crate::inspect::result::DecoyStudy;
use crate::requests::{window_line, write_page};
use clap::Args;
use std::path::PathBuf;

/// Write a burst on one page: input, slopes, noise, tests, false features, and places.
///
/// Of several bursts, or a long sequence with --burst-length, it says which need somebody, with a row for each.
///
/// The page has the answers of 'info', 'slopes', 'detect', 'decoys' and 'probe': the input with what was guessed, the
/// slopes with their judgement, the noise and its gate, the features and how many copies in other orders have, how
/// many samples each test rejects, and the fate of each place of --at. As Markdown or HTML it is text and tables; as
/// SVG, PDF or PNG one sheet under a picture of the burst.
///
/// Of several bursts the page begins with up to five that stand out, the worst first, with the reason and the command
/// that opens each: those that fail, whose slopes do not fit, that have less than a quarter of the features or twice
/// the noise of the others, or show too little to judge their slopes. A table has for each the noise, the slopes with
/// 'detect''s judgement, features, their median motion, and how even the times are.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = REPORT_HELP)]
pub struct ReportArgs {
    /// The file to write: .md, .html, .svg, .pdf or .png; of several bursts .md or .html, or the table alone as .csv.
    #[arg(long, short, value_name = "FILE.md")]
    pub out: PathBuf,
    /// A place to be told about, in pixels at mid-burst: column and row, after its name if it has one. Give the option
    /// again for more places.
    #[arg(long, value_name = "[NAME=]U,V", allow_hyphen_values = true, value_parser = parse_named_place)]
    pub at: Vec<(Option<String>, [f32; 2])>,
    /// A folder that 'colmap' wrote from these bursts. Tells of its pairs too: what the verified ones join, how many
    /// were refused and why, and the weakest; a burst without a verified pair stands out.
    #[cfg(feature = "colmap")]
    #[arg(long, value_name = "DIR")]
    pub pairs_of: Option<PathBuf>,
    #[command(flatten)]
    pub sequence: SequenceArgs,
    #[command(flatten)]
    pub study: DecoyStudy,
    #[command(flatten)]
    pub bursts: BurstsArgs,
}

fn parse_named_place(text: &str) -> Result<(Option<String>, [f32; 2]), String> {
    let (name, place) = text.rsplit_once('=').unzip();
    Ok((name.map(str::to_owned), parse_place(place.unwrap_or(text))?))
}

const REPORT_HELP: &str = "\
Examples:
  burstscope report night/ --out night.md
  burstscope report night/ --out night.pdf --at 412,230 --at mast=96,58
  burstscope report nights/ --out flight.html
  burstscope report nights/ --pairs-of rec --out flight.md

JSON (--json), beside version, params, inputs and file:
  {\"info\": {as of 'info'}, \"notes\": [text], \"features\", \"frame_noise\", \"noise_gate_factor\", \"tally\": {as of 'detect'}, \"spectrum\": {as of 'slopes'},
   \"decoys\": {as of 'decoys'} or null, \"no_decoys\": the reason or null, \"places\": [{as \"probe\" of 'probe'}]}
Of several bursts, beside version, params and file:
  {\"bursts\": [{\"name\", \"open\": the command that opens it, \"error\": null or why there is no \"health\", which is else {\"frames\", \"size\": [columns, rows], \"frame_noise\",
     \"slopes_judged\": {as of 'detect'} or null, \"features\", \"motion\": their median in px per frame or null, \"times\": \"even\" or a clause},
     \"verified_pairs\": their number, or null where the burst is not in the folder of --pairs-of}],
   \"worst\": [{\"name\", \"why\"}], \"pairs\": null, or those with a match, [{\"bursts\": [a, b], and as of 'colmap'}], \"joined\": null or as of 'colmap'}";

const SEARCH_SHARE: f32 = 0.3;

pub(super) fn run(args: &ReportArgs) -> Outcome {
    let inputs = resolve_bursts(&args.bursts.inputs, args.sequence, &args.bursts.run.calibration)?;
    let pairs: Option<ColmapReport> = None;
    #[cfg(feature = "colmap")]
    let pairs = match &args.pairs_of {
        Some(folder) => Some(read_exported(folder, &inputs.iter().map(|input| &*input.name).collect::<Vec<_>>())?),
        None => pairs,
    };
    if inputs.len() > 1 || args.sequence.burst_length.is_some() || pairs.is_some() {
        return run_flight(args, &inputs, pairs.as_ref());
    }
    let params = args.bursts.run.search.params()?;
    let endings = ["md", "html", "svg", "pdf", "png"];
    check_ending(&args.out, &endings, "--out: name the report .md, .html, .svg, .pdf or .png")?;
    let OneBurst { console, input, options, rules } = args.bursts.begin("report", &[Some(&args.out)])?;
    let silent = console.monitor.silent();
    let info = Info { name: input.name.clone(), ..input.source.clone()?.info(&options, &silent)? };
    let burst = input.open_to_search(&options, &params, &silent)?;
    // Checked before the long search. Of too few frames the page says so.
    let checked = args.study.check(&params, burst.len());
    checked.or_else(|error| if error.subject == "copies" { Err(error) } else { Ok(()) })?;
    args.at.iter().try_for_each(|(_, place)| check_place(*place, burst.size()))?;
    let cache = ProbeCache::new(&burst, &params, &console.monitor.part(0.0, SEARCH_SHARE))?;
    let rest = console.monitor.part(SEARCH_SHARE, 1.0 - SEARCH_SHARE);
    let named = |(number, (name, at)): (usize, &(Option<String>, [f32; 2]))| {
        (name.clone().unwrap_or_else(|| format!("Place {number}")), *at)
    };
    let places: Vec<(String, [f32; 2])> = (1..).zip(&args.at).map(named).collect();
    let page = BurstPage::of((&cache, &burst, info), &places, &args.study, &rest)?;
    console.monitor.check()?;
    rules.check(&args.out)?;
    write_page(&args.out, &page, &silent)?;
    console.say(&format!("wrote {}\n", args.out.display()))?;
    let (detection, notes) = (cache.detection(), burst.notes());
    let document = document! {
        params, inputs: input.path_texts(), file: path_text(&args.out), info: &page.info,
        notes: notes.iter().map(|note| &note.text).collect::<Vec<_>>(), features: detection.features.len(),
        frame_noise: detection.frame_noise, noise_gate_factor: detection.noise_gate_factor, tally: &detection.tally,
        spectrum: &page.spectrum, decoys: page.decoys.as_ref().ok(), no_decoys: page.decoys.as_ref().err(),
        places: page.places.iter().map(|(_, place)| place).collect::<Vec<_>>(),
    };
    console.say_document("report", &document)
}

fn run_flight(args: &ReportArgs, inputs: &[Input], pairs: Option<&ColmapReport>) -> Outcome {
    let BurstsArgs { run, overwrite, .. } = &args.bursts;
    let params = &run.search.params()?;
    check_ending(&args.out, &["md", "html", "csv"], "--out: name the report of several bursts .md, .html or .csv")?;
    if !args.at.is_empty() {
        return Err(Failure::usage("--at: a place is one of one burst, and the input names several; name one of them"));
    }
    let options = open_options(inputs, &run.calibration)?;
    let rules = overwrite.rules(inputs, &options, &[run.search.file.params.as_ref()]);
    // Refused before anything is computed.
    rules.check(&args.out)?;
    let console = Console::new(&run.output)?;
    let mut rows: Vec<FlightRow> = Vec::with_capacity(inputs.len());
    for (index, input) in inputs.iter().enumerate() {
        console.begin(format!("[{}/{}] {}: ", index + 1, inputs.len(), input.name));
        let burst = input.open_to_search(&options, params, &console.monitor);
        let health = match burst.and_then(|burst| Ok(BurstHealth::of(&burst, params, &console.monitor)?)) {
            Ok(health) => Ok(health),
            Err(Failure::Failed(error) | Failure::Usage(error)) => {
                console.complain(&format!("{}: {error:#}", input.name));
                Err(format!("{error:#}"))
            }
            Err(failure) => return Err(failure),
        };
        let source = if input.is_built_in() { vec![input.name.clone()] } else { input.path_texts() };
        let verified_pairs = pairs.and_then(|pairs| pairs.verified_pairs(&input.name));
        rows.push(FlightRow { name: input.name.clone(), open: window_line(&source, &options), health, verified_pairs });
    }
    console.monitor.check()?;
    rules.check(&args.out)?;
    match flight_page(&rows, pairs).text_for(&args.out) {
        Some(text) => write_text(&args.out, OutputKind::Page, text)?,
        None => Figure::from(flight_table(&rows)).write(&args.out)?,
    }
    let worst = worst_bursts(&rows);
    let lines: String = worst.iter().map(|(row, why)| format!("{}: {why}\n", row.name)).collect();
    console.say(&format!("{lines}wrote {}\n", args.out.display()))?;
    let bursts = rows.iter().map(|FlightRow { name, open, health, verified_pairs }| {
        document! { name, open, health: health.as_ref().ok(), error: health.as_ref().err(), verified_pairs }
    });
    let bursts: Vec<_> = bursts.collect();
    let worst: Vec<_> = worst.iter().map(|(row, why)| document! { name: &row.name, why }).collect();
    let pairs = pairs.map(|report| {
        let of =
            |pair: &PairReport| Both { one: document! { bursts: pair.ids.map(|id| report.burst(id)) }, other: *pair };
        (report.pairs.iter().map(of).collect::<Vec<_>>(), &report.joined)
    });
    let (pairs, joined) = pairs.unzip();
    console.say_document("report", &document! { params, file: path_text(&args.out), bursts, worst, pairs, joined })?;
    if rows.iter().all(|row| row.health.is_ok()) { Ok(()) } else { Err(Failure::Reported) }
}
