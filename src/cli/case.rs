//! `case` writes a burst, its settings and the question about it into one file.

use super::probe::{check_inside, parse_place};
use super::{BurstsArgs, OneBurst, Outcome, check_ending, document};
use crate::export::case::{CASE_EXTENSION, Case, Enclosed, write_case};
use crate::files::path_text;
use crate::inspect::{result::truth_of, words::counted};
use clap::Args;
use std::path::PathBuf;

/// Write a burst, its settings and what is asked of it into one file.
///
/// The file holds the frames, opened and calibrated, with 16 bits for each pixel (or only the surroundings of a place),
/// the search, the place, a note, and the truth of the frames if it is known. Commands and window open it like a burst,
/// on any machine; 'detect FILE --params FILE' searches it with the settings in it.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = CASE_HELP)]
pub struct CaseArgs {
    /// The place of the question, in pixels at mid-burst: column and row.
    #[arg(long, value_name = "U,V", allow_hyphen_values = true, value_parser = parse_place)]
    pub at: Option<[f32; 2]>,
    /// Keep only the square of this many pixels to each side of the place.
    #[arg(long, value_name = "PX", requires = "at", value_parser = clap::value_parser!(u32).range(8..=32768))]
    pub around: Option<u32>,
    /// A note, in any words.
    #[arg(long, value_name = "TEXT", default_value = "")]
    pub note: String,
    /// The file to write.
    #[arg(long, short, value_name = "FILE.burstcase")]
    pub out: PathBuf,
    #[command(flatten)]
    pub bursts: BurstsArgs,
}

const CASE_HELP: &str = "\
Examples:
  burstscope case night/ --at 412,230 --note 'why is there nothing?' --out why.burstcase
  burstscope case night/ --at 412,230 --around 100 --out why.burstcase
  burstscope probe why.burstcase --params why.burstcase --at 100,100

JSON (--json): {\"version\", \"commit\", \"detector_revision\", \"command\": \"case\", \"file\", \"case\": {as case.toml in the file}, \"bytes\"}";

pub(super) fn run(args: &CaseArgs) -> Outcome {
    let search = args.bursts.run.search.params()?;
    check_ending(&args.out, &[CASE_EXTENSION], "--out: name the file .burstcase")?;
    let OneBurst { console, input, options, rules } = args.bursts.begin("case", &[Some(&args.out)])?;
    let burst = input.open(&options, &console.monitor.part(0.0, 0.5))?;
    args.at.map_or(Ok(()), |at| check_inside(at, burst.size()))?;
    let (case, part) =
        Case::of(&burst, &search, (args.at, args.around.map(|px| px as usize)), &args.note, &console.monitor)?;
    rules.check(&args.out)?;
    // A damaged truth, or a truth of other pictures, is left out.
    let enclosed = Enclosed { session: None, truth: truth_of(&burst).unwrap_or_default() };
    write_case(&args.out, (&case, &part), &enclosed, &console.monitor.part(0.5, 0.5))?;
    console.monitor.check()?;
    let bytes = std::fs::metadata(&args.out).map_or(0, |file| file.len());
    let (frames, [columns, rows], [u, v], megabytes) = (case.frames, case.size, case.corner, bytes as f64 * 1e-6);
    let frames = counted(frames, "frame");
    let part = format!("{frames} of {columns}×{rows} from ({u}, {v}), {megabytes:.1} MB");
    console.say(&format!("{part}\nwrote {}\n", args.out.display()))?;
    console.say_document("case", &document! { file: path_text(&args.out), case, bytes })
}
