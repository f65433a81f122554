//! The arguments of `slopes` and `probe`.

use super::args::INPUT_HELP;
use super::burst_search_args::BurstSearchArgs;
use super::output_args::OverwriteArgs;
use clap::Args;
use std::path::PathBuf;

/// Say which slopes a burst needs: its spectrum, what lies at the limit, and what to change.
///
/// Without slopes they are found; with the ranges that you search they are judged. The features at each slope stand
/// beside the evidence: what the frames have in common there, before any threshold, also beyond the range. Advice is
/// about the range, the step, the direction, frames that add nothing, textures that repeat themselves, and cost; none
/// is given when none is needed.
#[derive(Debug, Args)]
#[command(after_long_help = SLOPES_HELP)]
pub struct SlopesArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    #[allow(missing_docs)]
    pub inputs: Vec<PathBuf>,
    /// Draw the answer as a figure.
    #[arg(long, value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

const SLOPES_HELP: &str = "\
Examples:
  burstscope slopes night/                                which slopes, and why
  burstscope slopes night/ --slopes-u -3:3:7              is this range right?
  burstscope slopes night/ --slopes-u -3:3:7 --plot slopes.svg

JSON (--json), beside version, params, name and inputs:
  \"most_features_at\": {\"u\", \"v\"} or null, without those at the limit
  \"spectrum\": {\"grid\", \"frames\", \"features\", \"at_limit\", \"finding\" (as slopes_found of detect), \"cost\": {\"slopes\", \"samples\", \"search_secs\"},
    \"bars\": [{\"at\": [i, j], \"slope\": {\"u\", \"v\"}, \"is_searched\", \"is_on_rim\", \"features\", \"evidence\" (0 … 1), \"coverage\" (0 … 1)}],
    \"aliases\": [{\"period_px\", \"correlation\", \"direction\", \"slope\", \"inside_range\", \"side_lobe\", \"places\": [[u, v]]}],
    \"advice\": [{\"subject\": range, step, direction, frames, aliases, coverage or cost, \"number\", \"sentence\", \"changes\": [{\"parameter\", \"value\"}]}]}";

/// Say why there is a feature at a place, or why there is none.
///
/// Every candidate near the place (a sample that stands out in place and scale at its own slope, however weak) is put
/// through the tests of the search again: what it has, what is asked for, what beat it, the first test that it fails
/// and the later ones, and the one option that would keep it. What each frame answers along the motion says whether it
/// is one thing that moves or a ghost of another.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("place").required(true).args(["at", "feature"])), after_long_help = PROBE_HELP)]
pub struct ProbeArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    #[allow(missing_docs)]
    pub inputs: Vec<PathBuf>,
    /// The place, in pixels at mid-burst: column and row; the centre of the first pixel is 0,0.
    #[arg(long, value_name = "U,V", allow_hyphen_values = true, value_parser = parse_place)]
    pub at: Option<[f32; 2]>,
    /// The place of this feature, counted from 0 in the order of 'detect'.
    #[arg(long, value_name = "N")]
    pub feature: Option<usize>,
    /// Draw the answer as a figure: the response over slope and scale, each frame's share, a slice along the motion,
    /// and the tests.
    #[arg(long, value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

const PROBE_HELP: &str = "\
Examples:
  burstscope probe night/ --at 412,230
  burstscope probe night/ --at 412,230 --slopes-u -3:3:7 --plot why.svg
  burstscope probe night/ --feature 0 --json

JSON (--json), beside version, params, name, inputs and what was searched:
  \"probe\": {\"pos_image\", \"summary\", \"samples\",
    \"fates\": [{\"octave\", \"level\", \"slope_index\", \"sample\": [x, y], \"pos_image\", \"sigma\", \"slope\": {\"u\", \"v\"}, \"value\", \"snr\", \"sigma_d\",
      \"tests\": [{\"test\", \"outcome\": passes, fails, not-asked or unknown, \"value\", \"limit\", \"side\": at-least or at-most, \"unit\", \"rival\"}],
      \"first_failed\": test or null, \"features\": [index], \"verdict\", \"remedy\": {\"sentence\", \"change\": {\"parameter\", \"value\"}, \"then_fails\"}}],
    \"subject\", \"response\": {\"scales\", \"slopes\", \"snr\": [row], \"gate\", \"plane\"}, \"shares\": {\"frames\", \"coherence\", \"shape\", \"meaning\"},
    \"suspicions\": [{\"kind\", \"evidence\", \"number\", \"other\", \"change\"}]}";

fn parse_place(text: &str) -> Result<[f32; 2], String> {
    let bad = || format!("'{text}' is not U,V in pixels, such as 412,230.5");
    let (u, v) = text.split_once(',').ok_or_else(bad)?;
    let number = |s: &str| s.trim().parse::<f32>().ok().filter(|x| x.is_finite()).ok_or_else(bad);
    Ok([number(u)?, number(v)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_two_numbers() {
        assert_eq!(parse_place("412, 230.5"), Ok([412.0, 230.5]));
        for bad in ["", "412", "nan,2", "1,2,3", "a,b"] {
            assert!(parse_place(bad).is_err(), "{bad}");
        }
    }
}
