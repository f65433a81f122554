//! `recover` plants things in a burst and reports which of them the search finds.

use super::study::{FIGURE_FILE, check_figures, figure_file, write_figure};
use super::{BurstsArgs, OneBurst, Outcome, check_ending};
use crate::detector::SearchParams;
use crate::export::case::{CASE_EXTENSION, Case, Enclosed, write_case};
use crate::recover::RecoverStudy;
use crate::recover::plots::recover_figure;
use crate::recover::report::planted_table;
use clap::Args;
use std::path::PathBuf;

/// Plant things of known strength in a burst, and say which of them the search finds.
///
/// Discs or blobs of known SNR, size and slope are added to copies of the frames, with the noise of their light, away
/// from strong features. Every copy is searched. Each thing is found, or lost for a reason in the words of 'probe'. The
/// answer is the share found over SNR, over slope (dips between the slopes of the grid show that the step is too
/// coarse) and over radius, the SNR at which half are found, and how faint things are seen at each place.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = RECOVER_HELP)]
pub struct RecoverArgs {
    #[command(flatten)]
    pub study: RecoverStudy,
    /// Draw the curves and the map as a figure, or write the points of the curves as CSV or LaTeX (.tex).
    #[arg(long, value_name = FIGURE_FILE, value_parser = figure_file())]
    pub plot: Option<PathBuf>,
    /// Write the things, with the fate of each, as CSV or LaTeX (.tex), or as a drawn table.
    #[arg(long, alias = "csv", value_name = FIGURE_FILE, value_parser = figure_file())]
    pub table: Option<PathBuf>,
    /// Write the first copy, with the truth of its planted things, as a case for the window's comparison with the
    /// truth.
    #[arg(long, value_name = "FILE.burstcase")]
    pub case: Option<PathBuf>,
    #[command(flatten)]
    pub bursts: BurstsArgs,
}

const RECOVER_HELP: &str = "\
Examples:
  burstscope recover night/
  burstscope recover night/ --slopes-u -3:3:7 --plot seen.svg --table planted.csv
  burstscope recover night/ --shape blob --radius 2,4,8 --copies 50 --json
  burstscope recover night/ --copies 1 --case planted.burstcase

JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"recover\", \"burst\", \"size\": [columns, rows], \"frames\", \"detector\": {as in the parameter file}, \"grid\",
   \"noise_gate_factor\", \"frame_noise\", \"features\", \"shape\", \"contrast\",
   \"levels\": {\"snrs\", \"slopes\", \"radii\", \"at_snr\", \"at_radius\", \"per_copy\", \"expected_half\", \"expected_amplitude\"}, \"copies\", \"copies_done\",
   \"over_snr\", \"over_slope\", \"over_size\": [{\"level\", \"planted\", \"found\", \"interval\": [low, high], \"expected\"}],
   \"curve\": {\"middle\", \"middle_error\", \"steepness\"}, a logistic curve of ln SNR, \"half\": {\"snr\", \"error\"} or null,
   \"fates\": [{\"test\" or null, \"reason\", \"count\"}], \"map\": {\"cell_px\", \"rows\": [[amplitude or null]]}, \"times\",
   \"planted\": [{\"seed\", \"varied\": snr, slope or size, \"truth\": {as in truth.json}, \"snr\", \"amplitude\", \"is_in_range\", \"frames\", \"expected_snr_d\",
     \"found\": {\"feature\", \"slope\", \"snr\"} or null, \"failed\": test or null, \"why\"}]}
  Amplitudes are fractions of full scale; shares 0 … 1; expected is what the noise of the burst and the gate let expect.";

pub(super) fn run(args: &RecoverArgs) -> Outcome {
    let study = RecoverStudy { search: args.bursts.run.search.params()?, ..args.study.clone() };
    args.case.iter().try_for_each(|path| check_ending(path, &[CASE_EXTENSION], "--case: name the case .burstcase"))?;
    let outputs = [args.plot.as_ref(), args.table.as_ref(), args.case.as_ref()];
    let OneBurst { console, input, options, rules } = args.bursts.begin("recover", &outputs)?;
    check_figures([&args.plot, &args.table], &rules)?;
    let burst = input.open_to_search(&options, &study.search, &console.monitor.silent())?;
    let report = study.run(&burst, &console.monitor)?;
    console.say(&report.text())?;
    if let Some(path) = &args.case {
        // With the slopes that were searched.
        let search = SearchParams::from(report.detector.clone());
        let study = RecoverStudy { search, ..study };
        let (copy, truth) = study.planted_copy(&burst, study.first_seed, &console.monitor.silent())?;
        let note = format!("{} things planted, seed {}", truth.features.len(), truth.seed);
        let (case, copy) = Case::of(&copy, &study.search, (None, None), &note, &console.monitor)?;
        rules.check(path)?;
        write_case(path, (&case, &copy), &Enclosed { session: None, truth: Some(truth) }, &console.monitor.silent())?;
        console.say(&format!("wrote {}\n", path.display()))?;
    }
    write_figure(&console, args.plot.as_deref(), &rules, || recover_figure(&report))?;
    write_figure(&console, args.table.as_deref(), &rules, || planted_table(&report.planted).into())?;
    console.say_document("recover", &report)
}
