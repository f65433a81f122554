//! `evaluate matches`: counts the matches of a dataset's bursts, method by method.

use super::study::{StudySearch, TableArgs, once_each, searched_by, write_figure};
use super::synth::levels_of;
use super::{
    Both, BurstSearchArgs, Console, Failure, Input, MatchingArgs, Outcome, SequenceArgs, document, open_options,
    resolve_bursts,
};
use crate::burst::{Burst, OpenOptions};
use crate::detector::SlopeGrid;
use crate::error::Error;
use crate::evaluate::matches::{AngleRow, MatchRow, TrueViews, TruthReport};
use crate::evaluate::poses::read_trajectory;
use crate::evaluate::{BurstMethod, MatchReport, MatchStudy, Searches, Shot, slopes_of};
use crate::export::{ANGLE_COLUMNS, Cell, METHOD_MATCH_COLUMNS, Table};
use crate::inspect::words::counted;
use crate::matching::PairSelection;
use crate::synth::NoisyParams;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;
use std::str::FromStr;

fn noisy() -> NoisyParams {
    NoisyParams::default()
}

/// Count the matches between the bursts of a dataset, method by method.
///
/// Every method finds the features of every burst; pairs of bursts are matched and verified. The table has the columns
/// of the paper's that need no reconstruction. With --snr the frames are taken for what the camera sees, each burst is
/// taken anew with noise, and the frames themselves are the gold standard.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = MATCHES_HELP, allow_negative_numbers = true)]
pub struct MatchesArgs {
    /// Folder of bursts (each a folder of frames), several of them, stacks, or a long sequence with --burst-length.
    #[arg(value_name = "DATASET", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Rows of the table, separated by commas: gold, sift-frame, sift-mean, sift-merge, buff-1d, buff-2d, buff-auto
    /// (each burst's slopes found) [default: gold if there is one, sift-frame, sift-merge, and buff-auto, or with given
    /// slopes buff-1d, buff-2d].
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',', value_parser = parse_method)]
    pub methods: Vec<BurstMethod>,
    /// Sharp images of the same views, in the bursts' order: a dataset as the bursts are, or with one image for each;
    /// SIFT on its middle frames is the gold standard.
    #[arg(long, value_name = "DATASET", conflicts_with = "snr")]
    pub gold: Option<PathBuf>,
    /// Add noise: signal-to-noise ratio of one pixel in one frame, the standard deviation of all pixels over that of
    /// the noise at their mean.
    #[arg(long, value_name = "RATIO")]
    pub snr: Option<f64>,
    /// Standard deviation of the read noise that is added, electrons.
    #[arg(long, value_name = "ELECTRONS", default_value_t = noisy().read_noise, requires = "snr")]
    pub read_noise: f64,
    /// Bits of the converter of the noisy camera.
    #[arg(long, value_name = "BITS", default_value_t = noisy().bits, requires = "snr")]
    pub bits: u32,
    /// Seed of the noise: the same seed makes the same bursts on every machine.
    #[arg(long, value_name = "N", default_value_t = noisy().seed, requires = "snr")]
    pub noise_seed: u64,
    /// Which bursts are matched: all, or each with the next K (sequential:K).
    #[arg(long, value_name = "WHICH", default_value_t = PairSelection::default(), value_parser = PairSelection::from_str)]
    pub pairs: PairSelection,
    /// Table that is shown last and written by --table: right matches by the angle between the two cameras of a pair as
    /// seen from the scene. Needs a known --camera.
    #[arg(long, value_name = "WHAT", value_parser = ["angle"], requires = "truth")]
    pub by: Option<String>,
    /// True poses of the bursts, by which matches are judged: as 'evaluate poses --truth' takes them. The points of a
    /// sparse model say which part of the scene both cameras of a pair see.
    #[arg(long, value_name = "POSES", requires = "by")]
    pub truth: Option<PathBuf>,
    /// Largest distance of a right match from true epipolar geometry.
    #[arg(long, value_name = "PX", default_value_t = 2.0, requires = "truth")]
    pub right_px: f64,
    #[command(flatten)]
    pub sequence: SequenceArgs,
    #[command(flatten)]
    pub matching: MatchingArgs,
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[command(flatten)]
    pub file: TableArgs,
}

const MATCHES_HELP: &str = "\
Slopes: where none are given, each burst's are found (buff-auto). A plane of slopes that is given is BuFF 2D's, and its u axis BuFF 1D's; a line that is given is BuFF 1D's, and
BuFF 2D has it on both axes. Named without a range, BuFF 1D searches the default line.

Columns: an image's matches with all others are added up: each match counts for both of its images (inliers/image is twice the inliers over the images), and ratios may pass
1. The inlier ratio, inliers over putative matches, is that of all pairs together. Pairs are matched, aligned and refused as 'match' does with the same options. 'on gold'
counts the putative matches of an image that lie, as found, on the geometry that the sharp images' matches agree on; inliers lie on one that the same matches were used to find.

By angle: the median over the points of the scene that both cameras see of the angle between the two viewing rays, or where the truth has no points over the right matches.
'seen by both' is the mean share of the points seen by either camera, 'matches' the inliers of all pairs of the bin, 'precision' right matches over matches.

JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"evaluate matches\", \"noise\": null or {\"snr\", \"seed\", \"gain\", \"frame_noise\"}, \"bursts\": [name], \"frames\", \"size\": [columns, rows],
   \"pairs\": [[a, b]], \"detector\": {as in the parameter file}, \"slopes_1d\", \"slopes_2d\", \"matching\", \"methods\": [{\"method\", \"keypoints_per_image\",
     \"putative_per_image\", \"inliers_per_image\", \"match_ratio\", \"match_score\", \"inlier_ratio\", \"verified_pairs\", \"on_gold_geometry_per_image\",
     \"slopes_found\": [one grid a burst, where the method finds them],
     \"by_pair\": [{\"keypoints_a\", \"keypoints_b\", \"putative\", \"inliers\", \"refused\": why there are none, else absent, \"on_gold_geometry\", \"right\": with a truth}]}],
   \"truth\": with one {\"right_px\", \"pairs\": [[angle in degrees or null, share seen by both or null]],
     \"by_angle\": [{\"method\", \"from_deg\", \"to_deg\", \"pairs\", \"seen_by_both\", \"matches\", \"right\", \"precision\"}]}}
  frame_noise is that of a frame at the mean signal, a fraction of full scale.";

#[derive(Debug, Clone, Copy, Serialize)]
struct AddedNoise {
    snr: f64,
    seed: u64,
    gain: f64,
    frame_noise: f64,
}

pub(super) fn run(args: &MatchesArgs) -> Outcome {
    let has_gold = args.gold.is_some() || args.snr.is_some();
    let StudySearch { detector, slopes, direction_deg } = searched_by(&args.run.search, &args.methods)?;
    let methods = methods(args, has_gold, slopes.is_none());
    let (slopes_1d, slopes_2d) = slopes_of(slopes.unwrap_or(detector.slopes));
    let matching = args.matching.params(&args.run.search.file, None)?;
    let console = Console::new(&args.run.output)?;
    let inputs = resolve_bursts(&args.inputs, args.sequence, &args.run.calibration)?;
    let golds = sharp_inputs(args, &inputs)?;
    let options = open_options(&inputs, &args.run.calibration)?;
    let settings = [args.run.search.file.params.as_ref(), args.truth.as_ref()];
    let rules = args.file.overwrite.rules(&inputs, &options, &settings);
    args.file.table.iter().try_for_each(|path| rules.check(path))?;
    let noisy = |snr| NoisyParams { snr, read_noise: args.read_noise, bits: args.bits, seed: args.noise_seed };
    let exposure = match args.snr.map(noisy) {
        Some(params) => Some(params.exposure(&levels_of(&inputs, &options, &console)?)?),
        None => None,
    };
    let names: Vec<String> = inputs.iter().map(|i| i.name.clone()).collect();
    let truth = args.truth.as_ref().map(|poses| {
        let unknown = || Error::param("camera", "viewing rays need it", "give the camera of the bursts");
        TrueViews::of(&names, matching.camera.clone().ok_or_else(unknown)?, &read_trajectory(poses)?, args.right_px)
    });
    let (searches, pairs) = (Searches { detector, slopes_1d, slopes_2d, direction_deg }, args.pairs.clone());
    let study = MatchStudy { methods, has_gold, searches, matching, pairs, truth: truth.transpose()? };
    // Bursts are opened again for each method: the noise of one follows from its place, as in copies that are written.
    let mut frames_before = vec![0];
    let report = study.run(
        &names,
        |k, shot| -> Outcome<Burst> {
            let silent = console.monitor.silent();
            match (shot, &golds) {
                (Shot::Gold, Some(golds)) => Ok(golds[k].open(&OpenOptions::default(), &silent)?),
                // Without --gold the frames before the noise are the sharp images.
                (Shot::Gold, None) => Ok(inputs[k].open(&options, &silent)?),
                (Shot::Burst, _) => {
                    let burst = inputs[k].open(&options, &silent)?;
                    let first_stream = 1 + frames_before[k] as u64;
                    if frames_before.len() == k + 1 {
                        frames_before.push(frames_before[k] + burst.len());
                    }
                    Ok(match &exposure {
                        Some(exposure) => exposure.capture(&burst, args.noise_seed, first_stream, &silent)?,
                        None => burst,
                    })
                }
            }
        },
        &console.monitor,
    )?;
    let noise = exposure.map(|e| AddedNoise {
        snr: args.snr.unwrap_or(f64::INFINITY),
        seed: args.noise_seed,
        gain: e.gain,
        frame_noise: e.camera.sigma(e.mean_signal),
    });
    console.say(&text(&report, noise))?;
    let table = || report.truth.as_ref().map_or_else(|| methods_table(&report), angles_table);
    write_figure(&console, args.file.table.as_deref(), &rules, || table().into())?;
    console.say_document("evaluate matches", &Both { one: document! { noise }, other: &report })
}

fn parse_method(text: &str) -> Result<BurstMethod, String> {
    match text {
        "gold" => Ok(BurstMethod::Gold),
        text => text.parse().map_err(|error: String| error.replace("give ", "give gold, ")),
    }
}

fn methods(args: &MatchesArgs, has_gold: bool, finds_slopes: bool) -> Vec<BurstMethod> {
    if !args.methods.is_empty() {
        return once_each(&args.methods);
    }
    use BurstMethod::{Buff1d, Buff2d, BuffAuto, SiftFrame, SiftMerge};
    // Given ranges are for BuFF 1D and 2D; without a range each burst's own slopes are found.
    let buff: &[BurstMethod] = if finds_slopes { &[BuffAuto] } else { &[Buff1d, Buff2d] };
    has_gold.then_some(&BurstMethod::Gold).into_iter().chain(&[SiftFrame, SiftMerge]).chain(buff).copied().collect()
}

/// Sharp images of the bursts, where `--gold` names them: cut as the bursts are, or one for each burst.
fn sharp_inputs(args: &MatchesArgs, inputs: &[Input]) -> Outcome<Option<Vec<Input>>> {
    let Some(gold) = &args.gold else { return Ok(None) };
    let sharp = std::slice::from_ref(gold);
    let options = args.run.calibration.clone();
    let mut found = resolve_bursts(sharp, args.sequence, &options)?;
    if found.len() != inputs.len() {
        // A folder with one picture for each burst.
        found = resolve_bursts(sharp, SequenceArgs { burst_length: Some(1), burst_step: None }, &options)?;
    }
    if found.len() != inputs.len() {
        return Err(Failure::usage(format!(
            "--gold: {} sharp images for {} bursts; give one for each burst, or a dataset like that of the bursts: {}",
            found.len(),
            inputs.len(),
            gold.display()
        )));
    }
    Ok(Some(found))
}

fn text(report: &MatchReport, noise: Option<AddedNoise>) -> String {
    let (bursts, pairs) = (counted(report.bursts.len(), "burst"), counted(report.pairs.len(), "pair"));
    let (frames, (width, height)) = (counted(report.frames, "frame"), report.size);
    let mut text = format!("{bursts} of {frames} of {width}×{height}, {pairs}\n");
    if let Some(AddedNoise { snr, seed, frame_noise, .. }) = noise {
        text +=
            &format!("noise added: SNR {snr} of one pixel in one frame, {frame_noise:.4} of full scale, seed {seed}\n");
    }
    let Searches { slopes_1d, slopes_2d, .. } = report.searches;
    for (method, slopes) in [(BurstMethod::Buff1d, slopes_1d), (BurstMethod::Buff2d, slopes_2d)] {
        if report.methods.iter().any(|row| row.method == method) {
            text += &format!("slopes of {} {} (min:max:count, px/frame)\n", method.label(), grid_text(&slopes));
        }
    }
    for found in report.methods.iter().filter_map(|row| row.slopes_found.as_ref()) {
        text += "slopes found (min:max:count, px/frame)\n";
        text.extend(report.bursts.iter().zip(found).map(|(name, slopes)| format!("  {name}: {}\n", grid_text(slopes))));
    }
    let by_angle = report.truth.as_ref().map_or_else(String::new, |truth| {
        let unknown = counted(truth.pairs.iter().filter(|(angle, _)| angle.is_none()).count(), "pair");
        let title = format!("Right matches, within {} px, by angle ({unknown} without a known one)", truth.right_px);
        format!("\n{title}\n{}", angles_table(truth).text())
    });
    text + "\n" + &methods_table(report).text() + &by_angle
}

fn angles_table(truth: &TruthReport) -> Table {
    let row = |row: &AngleRow| {
        let bin = [Cell::of(Some(row.from_deg), 0), Cell::of(row.to_deg, 0), Cell::count(row.pairs)];
        let counts = [Cell::of(row.seen_by_both, 3), Cell::count(row.matches), Cell::count(row.right)];
        let bin = std::iter::once(row.method.label().into()).chain(bin);
        bin.chain(counts).chain([Cell::of(row.precision, 3)]).collect()
    };
    let heads = ["method", "from °", "to °", "pairs", "seen by both", "matches", "right", "precision"];
    Table::new("Right matches by angle", ANGLE_COLUMNS, truth.by_angle.iter().map(row).collect()).headed(&heads)
}

fn methods_table(report: &MatchReport) -> Table {
    let row = |row: &MatchRow| {
        let counts = &row.counts;
        let per_image = [counts.keypoints_per_image, counts.putative_per_image, counts.inliers_per_image];
        let per_image = per_image.map(|x| Cell::of(Some(x), 1));
        let ratios = [Some(counts.match_ratio), Some(counts.match_score), counts.inlier_ratio].map(|x| Cell::of(x, 3));
        let pairs = [Cell::count(counts.verified_pairs), Cell::of(row.on_gold_geometry_per_image, 1)];
        std::iter::once(row.method.label().into()).chain(per_image).chain(ratios).chain(pairs).collect()
    };
    let per_image = ["method", "keypoints/image", "putative/image", "inliers/image"];
    let ratios = ["match ratio", "match score", "inlier ratio", "pairs verified", "on gold/image"];
    Table::new("Matches of bursts", METHOD_MATCH_COLUMNS, report.methods.iter().map(row).collect())
        .headed(&[&per_image[..], &ratios].concat())
}

fn grid_text(grid: &SlopeGrid) -> String {
    let turned = if grid.direction_deg == 0.0 { String::new() } else { format!(" turned by {}°", grid.direction_deg) };
    format!("u {} v {}{turned}", grid.u, grid.v)
}
