//! `evaluate advice`: measures how often the sentence about the slopes is right.

use super::args::OutputArgs;
use super::console::Console;
use super::evaluate_tables::{or_dash, table};
use super::failure::Failure;
use crate::evaluate::advice::{AdviceReport, AdviceStudy, AdvisedBurst, Statement};
use clap::Args;

/// Count how often the sentence about the slopes is right, on bursts whose motion is known.
///
/// Layered scenes are searched with slopes that are found (line, plane, layers, masked), with wrong ones (narrow,
/// coarse, beside, wide, still), and with frames that do not fit (exchanged, curved, noise). What 'detect' and 'slopes'
/// say of the slopes is counted against what is true. 'unknown', said where the frames show too little, is never wrong.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = ADVICE_HELP)]
pub struct AdviceArgs {
    #[command(flatten)]
    pub study: AdviceStudy,
    #[command(flatten)]
    pub output: OutputArgs,
}

const ADVICE_HELP: &str = "\
JSON (--json):
  {\"version\", \"command\": \"evaluate advice\", \"snrs\", \"seeds\", \"first_seed\",
   \"said\": {statement: {what is true: bursts}}, each of fits, range, step, direction, cost, times, frames and unknown,
   \"wrong_share\" of what is said and not unknown, or null, \"bursts\": [{\"kind\", \"snr\", \"seed\", \"said\", \"true\", \"sentence\"}]}";

pub(super) fn run(args: &AdviceArgs) -> Result<(), Failure> {
    let console = Console::new(&args.output)?;
    let report = args.study.run(&console.monitor)?;
    console.say(&advice_tables(&report))?;
    console.say_document("evaluate advice", &report)
}

fn advice_tables(report: &AdviceReport) -> String {
    let AdviceReport { study: AdviceStudy { snrs, seeds, first_seed }, said, bursts, .. } = report;
    let name = |statement: &Statement| format!("{statement:?}").to_lowercase();
    let heads: Vec<String> = ["said \\ true".to_owned()].into_iter().chain(Statement::ALL.iter().map(name)).collect();
    let rows = said.iter().map(|(said, of)| {
        // Most are 0, and would hide the others.
        let counts = of.values().map(|&count| if count > 0 { count.to_string() } else { "·".to_owned() });
        [name(said)].into_iter().chain(counts).collect()
    });
    let share = or_dash(report.wrong_share, |share| format!("{:.1} %", 100.0 * share));
    let text = format!(
        "{seeds} bursts for each kind and SNR, seeds from {first_seed}\n\n{}wrong, of what is said and not unknown: {share}\n\n",
        table(&heads, rows)
    );
    let heads: Vec<String> =
        ["right, wrong, unknown".to_owned()].into_iter().chain(snrs.iter().map(|snr| format!("SNR {snr}"))).collect();
    // All bursts of a kind lie together, and so do those of a ratio.
    let by_kind = bursts.chunk_by(|a, b| a.kind == b.kind).map(|of_kind| {
        let cell = |of_snr: &[AdvisedBurst]| {
            let right = of_snr.iter().filter(|burst| burst.said == burst.truth).count();
            let wrong = of_snr.iter().filter(|burst| burst.is_wrong()).count();
            format!("{right} {wrong} {}", of_snr.len() - right - wrong)
        };
        let cells = of_kind.chunks(*seeds as usize).map(cell);
        [of_kind[0].kind.to_owned()].into_iter().chain(cells).collect()
    });
    text + &table(&heads, by_kind)
}
