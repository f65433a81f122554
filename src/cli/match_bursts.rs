//! `match`: finds the features of two bursts and matches them.

use super::detect::{DetectJob, detect_burst};
use super::evaluate_tables::or_dash;
use super::matching_args::cameras_help;
use super::report::BurstReport;
use super::{
    Both, BurstSearchArgs, Console, Input, MatchingArgs, Outcome, OverwriteArgs, document, open_options, resolve_pair,
};
use crate::burst::{Burst, BurstFiles};
use crate::dataset::{CameraChoice, DetectedBurst, match_bursts, match_rows};
use crate::detector::Detection;
use crate::detector::params::Word;
use crate::export::{ExportFormat, FigureAmount, FigureFormat, safe_file_name, write_drawing, write_matches_csv};
use crate::files::path_text;
use crate::matching::params::doc;
use crate::matching::{MatchCounts, MatchParams, TwoViewModel};
use crate::monitor::Stage;
use crate::requests::{MatchFigure, MatchPictures};
use clap::Args;
use std::path::PathBuf;

pub(super) fn run(args: &MatchArgs) -> Outcome {
    let params = args.run.search.params()?;
    let mut job = DetectJob::new(&args.out, &args.format, &params)?;
    let console = Console::new(&args.run.output)?;
    let inputs = resolve_pair(&args.a, &args.b, &args.run.calibration)?;
    let files = |input: &Input| BurstFiles { name: input.name.clone(), paths: input.paths().to_vec() };
    let (bursts, file): (Vec<_>, _) = (inputs.iter().map(files).collect(), &args.run.search.file);
    let cameras = args.matching.cameras(file, &bursts, &[args.a.clone(), args.b.clone()], CameraChoice::default())?;
    let [of_a, of_b] = [0, 1].map(|side| cameras.of_burst(&bursts[side].name));
    let matching = args.matching.params(file, cameras.known().next())?.with_cameras(of_a.known(), of_b.known());
    let options = open_options(&inputs, &args.run.calibration)?;
    let name = safe_file_name(&format!("{}_{}", inputs[0].name, inputs[1].name));
    let [matches, picture] =
        ["csv", args.picture.extension()].map(|end| args.out.join(format!("{name}.matches.{end}")));
    let settings: Vec<_> = file.params.iter().chain(args.matching.camera_files(&cameras)).map(Some).collect();
    job.rules = args.overwrite.rules(&inputs, &options, &settings);
    // Features, matches and picture are checked together: refused after the search, the work would be lost.
    let folder = job.take_folder(&inputs, &[matches.clone(), picture.clone()])?;
    let mut found: Vec<(BurstReport, Burst, Detection)> = Vec::with_capacity(2);
    for (index, input) in inputs.into_iter().enumerate() {
        console.begin(format!("[{}/2] {}: ", index + 1, input.name));
        // A burst of another size than its camera's is refused.
        job.camera = [of_a, of_b][index].clone();
        found.push(detect_burst(input, &options, &job, &folder, &console)?);
    }
    console.begin("matches: ".to_owned());
    let [(report_a, burst_a, a), (report_b, burst_b, b)] = &found[..] else { unreachable!("two inputs") };
    let searched = params.at_given();
    let of = |burst, detection| DetectedBurst { burst, params: &searched, detection };
    let result = match_bursts([of(burst_a, a), of(burst_b, b)], &matching, &console.monitor)?;
    let figure = MatchFigure { pictures: args.images, matches: args.drawn, width_mm: args.width };
    let drawing = figure.drawing([of(burst_a, a), of(burst_b, b)], &result, &console.monitor.silent())?;
    // From here on files are written: a cancelled run leaves none behind.
    console.monitor.check()?;
    console.monitor.report(Stage::Write, 0.0);
    // Checked again, because the searches took long.
    folder.check()?;
    [&matches, &picture].into_iter().try_for_each(|file| job.rules.check(file))?;
    write_matches_csv(&matches, &match_rows(&a.features, &b.features, &result))?;
    write_drawing(&picture, &drawing)?;
    folder.check()?;
    let model = result.verification.as_ref().and_then(|v| v.model.as_ref());
    let why_none = match result.counts.refused {
        _ if model.is_some() => String::new(),
        Some(reason) => format!("; refused: {}", reason.words()),
        None => "; too few agree on any".to_owned(),
    };
    console.say(&summary(&result.counts, &matching, &why_none))?;
    console.say(&format!("  wrote        {}\n  wrote        {}\n", matches.display(), picture.display()))?;
    let named = |model: &TwoViewModel| {
        let matrix: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| model.matrix()[(i, j)]));
        document! { kind: matching.geometry.word(), matrix }
    };
    let other = document! {
        params: &params, matching: &matching, a: report_a, b: report_b, match_ratio: result.counts.match_ratio(),
        match_score: result.counts.match_score(), inlier_ratio: result.counts.inlier_ratio(),
        model: model.map(named),
        files: document! { matches: path_text(&matches), picture: path_text(&picture) },
    };
    console.say_document("match", &Both { one: result.counts, other })
}

fn parse_drawn(text: &str) -> Result<FigureAmount, String> {
    let strongest = || text.parse().ok().filter(|count| *count > 0).map(FigureAmount::Strongest);
    let amount = if text == "all" { Some(FigureAmount::All) } else { strongest() };
    amount.ok_or_else(|| format!("'{text}' is no number of matches; give 'all' or a whole number from 1 on"))
}

fn parse_width(text: &str) -> Result<f32, String> {
    let bad = || format!("'{text}' is no width of a figure; give 10 to 2000 mm, such as 88 for one column");
    text.parse().ok().filter(|width| (10.0..=2000.0).contains(width)).ok_or_else(bad)
}

fn summary(counts: &MatchCounts, matching: &MatchParams, why_none: &str) -> String {
    let MatchCounts { keypoints_a, keypoints_b, putative, inliers, .. } = *counts;
    let verified = |inliers: usize| format!("{inliers} ({}{why_none})", matching.geometry.word());
    let inliers = inliers.map_or_else(|| "not verified".to_owned(), verified);
    let [score, ratio] = [counts.match_score(), counts.inlier_ratio()].map(|x| or_dash(x, |x: f64| format!("{x:.3}")));
    format!(
        "matches\n  keypoints    {keypoints_a} and {keypoints_b}\n  putative     {putative}\n  inliers      {inliers}\n  \
         match ratio  {:.3}\n  match score  {score}\n  inlier ratio {ratio}\n",
        counts.match_ratio()
    )
}

/// Match the features of two bursts, verify the matches, and draw them.
///
/// The features of both bursts are found with the same parameters. Each is matched with the feature of the other burst
/// with the nearest descriptor, if that is clearly nearer than the second nearest, and both ways. Matches that agree on
/// a geometry of the two views are inliers.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = MATCH_HELP, mut_arg(doc::CAMERA.name, cameras_help))]
pub struct MatchArgs {
    /// The first burst: a folder of frames, an image, a multi-page TIFF, a .npy stack, or 'demo'.
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// The second burst.
    #[arg(value_name = "B")]
    pub b: PathBuf,
    /// Folder for features, matches and picture, made if it is missing; files are named after the bursts.
    #[arg(long, short, value_name = "DIR")]
    pub out: PathBuf,
    /// Formats of the features, separated by commas: csv, colmap, npz.
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', default_value = "csv")]
    pub format: Vec<ExportFormat>,
    /// Format of the picture: PDF and SVG are vectors, PNG has 300 pixels an inch.
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "png")]
    pub picture: FigureFormat,
    /// What the picture shows of each burst: its motion stack at the slope with most features, its middle frame, or its
    /// frames merged; dark ones are stretched.
    #[arg(long, value_name = "KIND", value_enum, default_value = "stack")]
    pub images: MatchPictures,
    /// Matches that the picture shows: so many of the smallest distance, or 'all'.
    #[arg(long, value_name = "N", default_value = "100", value_parser = parse_drawn)]
    pub drawn: FigureAmount,
    /// Width of the picture on paper, millimetres: 88 for one column, 181 for two. Letters have 8 points.
    #[arg(long, value_name = "MM", default_value = "181", value_parser = parse_width)]
    pub width: f32,
    #[command(flatten)]
    pub matching: MatchingArgs,
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

const MATCH_HELP: &str = "\
Files in DIR, for bursts A and B:
  A.csv, B.csv       features, as 'detect' writes them
  A_B.matches.csv    a,b,u_a,v_a,u_b,v_b,distance,ratio,error_px,inlier,shift_u_b,shift_v_b,correlation,how,among,ratio_among_all,aligned_u_a,aligned_v_a,
                     aligned_u_b,aligned_v_b,error_found_px; a and b count the features from 0, and a cell is empty where there is no value. u and v are the places of
                     the features. What A's place shows lies at (u_b + shift_u_b, v_b + shift_v_b) in B, unless the pictures do not tell or were not compared
                     (--align false). aligned_* are the places on which all matches of a feature agree, within 20 px of those found: error_px is the
                     error there, error_found_px that of the places found. how: sure (by descriptors alone; ratio is among all of B) or predicted (where its motion
                     puts it; ratio is among the features at so many places there, ratio_among_all among all of B, above 1 where another one is nearer)
  A_B.matches.png    both pictures with their names, lines between the matches of the smallest distance, and the numbers of inliers (solid, yellow) and outliers
                     (dashed, vermilion): the figure that the window exports of two bursts. --picture makes it .svg or .pdf

Numbers, as in the paper's tables: match ratio = putative matches over keypoints, match score = inliers over keypoints (each the mean of A's and B's), inlier ratio =
inliers over putative matches.

JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"match\", \"params\": {as in the parameter file}, \"matching\", \"a\": {as a burst of 'detect'}, \"b\",
   \"keypoints_a\", \"keypoints_b\", \"putative\", \"inliers\", \"refused\": \"motions\" or \"pictures\" where they contradict the geometry, else absent, \"match_ratio\", \"match_score\", \"inlier_ratio\",
   \"model\": null or {\"kind\", \"matrix\": [[row], …]}, \"files\": {\"matches\", \"picture\"}}
  The matrix maps pixels whose first centre is at (0, 0): x_b^T F x_a = 0, or x_b ~ H x_a; the essential matrix maps directions. inliers, match_score and
  inlier_ratio are null where nothing was verified (--geometry none).";
