//! `evaluate advice`: measures how often the sentence about the slopes is right.

use super::args::OutputArgs;
use super::console::Console;
use super::evaluate_tables::{or_dash, table};
use super::failure::Failure;
use crate::evaluate::AdviceStudy;
use crate::evaluate::advice::{AdviceKind, AdviceReport, AdvisedBurst, Statement};
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
  {\"version\", \"command\": \"evaluate advice\", \"width\", \"height\", \"frames\", \"first_seed\", \"seeds\",
   \"rows\": [{\"said\": fits, range, step, direction, cost, times, frames or unknown, \"true\": {statement: bursts}, \"wrong\"}], \"wrong_share\" of what is said and not unknown, or null,
   \"bursts\": [{\"kind\", \"snr\", \"seed\", \"said\", \"true\", \"sentence\"}]}";

pub(super) fn run(args: &AdviceArgs) -> Result<(), Failure> {
    let console = Console::new(&args.output)?;
    let report = args.study.run(&console.monitor)?;
    console.say(&advice_tables(&report, &args.study.snrs))?;
    console.say_document("evaluate advice", &report)
}

fn advice_tables(report: &AdviceReport, snrs: &[f64]) -> String {
    let AdviceReport { width, height, frames, first_seed, seeds, rows, bursts, .. } = report;
    let heads = ["said \\ true"].into_iter().chain(Statement::ALL.map(Statement::name)).chain(["wrong"]);
    let said = rows.iter().map(|row| {
        let counts = Statement::ALL.map(|truth| row.of.get(&truth).map_or(String::new(), ToString::to_string));
        [row.said.name().to_owned()].into_iter().chain(counts).chain([row.wrong.to_string()]).collect()
    });
    let share = or_dash(report.wrong_share, |share| format!("{:.1} %", 100.0 * share));
    let text = format!(
        "{seeds} bursts of {frames} frames of {width}×{height} for each kind and SNR, seeds from {first_seed}\n\n\
         What is said of the slopes, and what is true\n{}wrong, of what is said and not unknown: {share}\n\n\
         Right, wrong and unknown by kind of burst\n",
        table(&heads.collect::<Vec<_>>(), said)
    );
    let heads = ["kind".to_owned()].into_iter().chain(snrs.iter().map(|snr| format!("SNR {snr}")));
    let by_kind = AdviceKind::ALL.into_iter().map(|kind| {
        let cell = |snr: &f64| {
            let count = |counts: &dyn Fn(&AdvisedBurst) -> bool| {
                bursts.iter().filter(|burst| burst.kind == kind && burst.snr == *snr && counts(burst)).count()
            };
            let (right, wrong) = (count(&|burst| burst.said == burst.truth), count(&AdvisedBurst::is_wrong));
            format!("{right} {wrong} {}", count(&|burst| burst.said != burst.truth && !burst.is_wrong()))
        };
        [kind.name().to_owned()].into_iter().chain(snrs.iter().map(cell)).collect()
    });
    text + &table(&heads.collect::<Vec<_>>(), by_kind)
}
