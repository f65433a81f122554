//! `colmap`: writes the input of COLMAP's mapper from a dataset of bursts.

use super::matching_args::cameras_help;
use super::report::FailureReport;
use super::search_options::defaults_file;
use super::{
    Both, BurstSearchArgs, Console, Failure, Input, MatchingArgs, Outcome, SequenceArgs, document, open_options,
    resolve_bursts,
};
use crate::burst::BurstFiles;
use crate::dataset::{
    BurstEvent, CameraChoice, CameraReport, ColmapJob, ColmapReport, Comparison, FeatureJob, FeatureStore,
    GatherReport, ImageKind, LeftOut, export_colmap, gather, read_pairs,
};
use crate::detector::params::doc::NOISE_GATE;
use crate::detector::{Method, NoiseGate, SearchParams};
use crate::files::path_text;
use crate::inspect::report::joined_text;
use crate::inspect::words::{counted, some_of};
use crate::matching::{CameraModel, PairSelection};
use crate::matching::{aligned::Moved, params::doc};
use crate::requests::{next_commands, old_model};
use clap::{Arg, Args};
use std::path::{Path, PathBuf};

fn gate_help(arg: Arg) -> Arg {
    let text = |help: String| help.replace("[default: auto]", "[default of this command: matching]");
    arg.help(text(NOISE_GATE.short_help())).long_help(text(NOISE_GATE.long_help()))
}

pub(super) fn run(args: &ColmapArgs) -> Outcome {
    // As everywhere, with the gate for matching.
    let defaults = SearchParams { noise_gate: NoiseGate::Matching, ..SearchParams::default() };
    let detector = args.run.search.params_over(defaults)?;
    let inputs = resolve_bursts(&args.inputs, args.sequence, &args.run.calibration)?;
    if inputs.iter().any(Input::is_built_in) {
        return Err(Failure::usage(
            "colmap: a reconstruction needs bursts from several places, and the demo is one burst",
        ));
    }
    let open = open_options(&inputs, &args.run.calibration)?;
    let console = Console::new(&args.run.output)?;
    let mut failures: Vec<FailureReport> = Vec::new();
    let mut fail = |name: &str, error: String| {
        console.complain(&format!("{name}: {error}"));
        failures.push(FailureReport { name: name.to_owned(), error });
    };
    // Bursts that cannot be opened are reported before the long search; the others go on.
    let (mut bursts, mut failed) = (Vec::new(), Vec::new());
    for Input { name, source, .. } in inputs {
        match source {
            Ok(source) => bursts.push(BurstFiles { name, paths: source.paths().to_vec() }),
            Err(error) => {
                fail(&name, error.to_string());
                failed.push(BurstFiles { name, paths: Vec::new() });
            }
        }
    }
    let all = [&bursts[..], &failed].concat();
    let pairs = match &args.pairs {
        (pairs, None) => pairs.clone(),
        (_, Some(list)) => PairSelection::Listed(read_pairs(list, &all)?),
    };
    let file = &args.run.search.file;
    let cameras = args.matching.cameras(file, &all, &args.inputs, CameraChoice::Guessed(args.camera_model))?;
    let matching = args.matching.params(file, cameras.known().next())?;
    let job = ColmapJob { features: FeatureJob { detector, open, images: args.images }, matching, pairs, cameras };
    let comparison = if args.check_content { Comparison::Content } else { Comparison::Times };
    // Files that the command reads must never be replaced by those it writes.
    let opened = [args.run.search.file.params.as_ref(), args.pairs.1.as_ref()].into_iter().flatten();
    let opened = opened.chain(args.matching.camera_files(&job.cameras)).cloned().chain(defaults_file());
    let store = FeatureStore::open(&args.out, &job.features)?.and_opened(opened.collect());
    let mut store = store.comparing(comparison);
    let mut gathered = None;
    if !args.gather.is_empty() {
        let report = gather(&mut store, &bursts, &args.gather, &console.monitor)?;
        console.say(&format!("gathered the features of {} of {} bursts\n", report.brought.len(), bursts.len()))?;
        tell_what_was_left(&report).iter().for_each(|line| console.note(line));
        gathered = Some(report);
    }
    // An event returns no error: a closed output is kept until the work is done.
    let mut said = Ok(());
    let mut on = |event: BurstEvent<'_>| match event {
        BurstEvent::Begin(index) => console.begin(format!("[{}/{}] {}: ", index + 1, bursts.len(), bursts[index].name)),
        BurstEvent::Done(_, burst) => {
            let from = if burst.resumed { ", from an earlier run" } else { "" };
            let slopes = burst.slopes.as_ref().map_or(String::new(), |found| format!("; slopes {}", found.summary()));
            let features = counted(burst.keypoints.len(), "feature");
            let line = format!("{}: {features}{from}{slopes}\n", burst.name);
            said = std::mem::replace(&mut said, Ok(())).and_then(|()| console.say(&line));
            // What follows the last burst is about all.
            console.go_on(String::new());
        }
        BurstEvent::Failed(index, error) => fail(&bursts[index].name, error.to_string()),
        BurstEvent::Matching(pairs) => console.begin(format!("{}: ", counted(pairs, "pair"))),
    };
    let report = export_colmap(&mut store, &bursts, &job, &mut on, &console.monitor)?;
    said?;
    let [make, map, python] = next_commands(&args.out, report.known_camera);
    let then = format!("\nNext:\n  {make}\n  {map}\nor:\n  {python}\n");
    let mut text = summary(&report, &job.features);
    text.extend(old_model(&args.out).map(|old| old + "\n"));
    console.say(&(text + if report.no_start.is_none() { &then } else { "" }))?;
    let asked = document! { params: &job.features.detector, matching: &job.matching };
    let gathered = gathered.map(|gathered| document! { gathered });
    let left = Both { one: gathered, other: document! { failures: &failures, next: [make, map] } };
    console.say_document("colmap", &Both { one: asked, other: Both { one: &report, other: left } })?;
    if let Some(why) = &report.no_start {
        console.note(&format!("{why}; `burstscope match` shows what a pair lacks"));
    }
    if failures.is_empty() { Ok(()) } else { Err(Failure::Reported) }
}

/// Lists what was not gathered and why: one line for each folder and reason.
fn tell_what_was_left(report: &GatherReport) -> Vec<String> {
    let mut lines: Vec<(&Path, String, Vec<&str>)> = Vec::new();
    for LeftOut { folder, burst, reason } in &report.left_out {
        let reason = reason.to_string();
        match lines.iter_mut().find(|(of, why, _)| *of == folder && *why == reason) {
            Some((.., bursts)) => bursts.push(burst),
            None => lines.push((folder, reason, vec![burst])),
        }
    }
    let left = lines.into_iter().map(|(folder, reason, bursts)| {
        format!("--gather {}: {} not taken: {reason}", folder.display(), some_of(&bursts))
    });
    let strange = report.strange_folders.iter();
    left.chain(strange.map(|folder| format!("--gather {}: it holds none of these bursts", folder.display()))).collect()
}

fn summary(report: &ColmapReport, features: &FeatureJob) -> String {
    let mut text = String::new();
    for CameraReport { camera, known, from, images } in &report.cameras {
        let from: Vec<String> = from.iter().map(|file| path_text(file)).collect();
        let source = match (known, &from[..]) {
            (false, _) => " (guessed: give --camera if you know it)".to_owned(),
            (true, []) => String::new(),
            (true, from) => format!(" of {} (from {})", counted(images.len(), "image"), some_of(from)),
        };
        text += &format!("camera {camera}{source}\n");
    }
    let putative: usize = report.pairs.iter().map(|p| p.counts.putative).sum();
    let inliers: usize = report.pairs.iter().filter_map(|p| p.counts.inliers).sum();
    let verified = report.pairs.iter().filter(|p| p.counts.inliers > Some(0)).count();
    let resumed = report.pairs.iter().filter(|p| p.resumed).count();
    let resumed = if resumed > 0 { format!(", {resumed} from an earlier run") } else { String::new() };
    text += &format!(
        "{}, {}{resumed}: {}, {} in {}\n",
        counted(report.images.len(), "image"),
        counted(report.pairs.len(), "pair"),
        counted(putative, "match"),
        counted(inliers, "inlier"),
        counted(verified, "verified pair"),
    );
    for (count, how) in [
        (report.beside, "found beside others by their pictures"),
        (report.implied, "known by matches with other bursts alone"),
    ] {
        text.extend((count > 0).then(|| format!("{} {how}\n", counted(count, "inlier"))));
    }
    text += &joined_text(&report.joined);
    if let Some(Moved { share, median_px: Some(median), max_px: Some(max), refused }) = report.moved {
        text += &format!(
            "moved {:.0} % of the keypoints to where their matches agree, by {median:.1} px in the median and {max:.1} px at most; \
             {refused} more stay as found, like all in features/\n",
            100.0 * share
        );
    }
    // Other methods find features in the frame that is shown.
    let is_late = features.detector.method == Method::Buff && features.images != ImageKind::Stack;
    if is_late && report.images.iter().any(|image| image.frames.is_multiple_of(2)) {
        text += "the pictures of bursts with an even number of frames show half a frame after mid-burst, the time of the features \
                 and poses: for dense steps give --images stack, or leave a frame out with --frames\n";
    }
    text + &format!("wrote {}\n", report.database.display())
}

/// Pairs as they are chosen: by a rule, or in a file, which is named then.
type PairsArg = (PairSelection, Option<PathBuf>);

fn parse_pairs(text: &str) -> Result<PairsArg, String> {
    match text.parse() {
        Ok(pairs) => Ok((pairs, None)),
        Err(_) if Path::new(text).is_file() => Ok((PairSelection::default(), Some(text.into()))),
        Err(why) => Err(why + ", nor a file with two names a line"),
    }
}

/// Write what COLMAP's mapper takes: images, features and a database with verified matches.
///
/// Each burst becomes an image. Its features are found, matched with those of the other bursts and verified. Bursts
/// whose features are in --out already, found with the same parameters from the same files, and pairs of them that were
/// matched there with the same options, are not done again: after an interruption the same command goes on, and one
/// burst more costs its own pairs. A burst that cannot be opened is reported and left out.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = COLMAP_HELP, mut_arg(NOISE_GATE.name, gate_help), mut_arg(doc::CAMERA.name, cameras_help))]
pub struct ColmapArgs {
    /// Folder of bursts (each a folder of frames), several of them, stacks, or a long sequence with --burst-length.
    #[arg(value_name = "DATASET", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Folder to write, made if it is missing; one that this command began is continued.
    #[arg(long, short, value_name = "DIR")]
    pub out: PathBuf,
    /// Folder that another run of this command wrote, of some of these bursts with the same options: what it has
    /// finished is copied; what does not fit is named on the standard error. Given once for each.
    #[arg(long, value_name = "DIR")]
    pub gather: Vec<PathBuf>,
    /// Compare the frames of finished bursts with their checksums, not with their lengths and times alone: every frame
    /// is read.
    #[arg(long)]
    pub check_content: bool,
    /// Which bursts are matched: all, each with the next K (sequential:K), each with the K in which most of its 300
    /// strongest features have their nearest descriptor (near:K), or those of a list of hloc's or COLMAP's: a file with
    /// two names a line, with or without the extension of the picture.
    #[arg(long, value_name = "WHICH", default_value = "all", value_parser = parse_pairs)]
    pub pairs: PairsArg,
    /// The picture that stands for a burst: middle, its middle frame; merged, its frames merged at that one; or stack,
    /// each place stacked along its own motion, at mid-burst as the features; stretched to 8 bit.
    #[arg(long, value_name = "KIND", value_enum, default_value = "middle")]
    pub images: ImageKind,
    /// The model of a guessed camera: focal length 1.2 times the larger side, as COLMAP guesses.
    #[arg(long, value_name = "MODEL", default_value = "SIMPLE_RADIAL", conflicts_with = "camera", value_enum)]
    pub camera_model: CameraModel,
    #[command(flatten)]
    pub sequence: SequenceArgs,
    #[command(flatten)]
    pub matching: MatchingArgs,
    #[command(flatten)]
    pub run: BurstSearchArgs,
}

const COLMAP_HELP: &str = "\
Files in DIR:
  images/NAME.png            one for each burst
  features/NAME.png.txt      its features where they were found, as COLMAP's feature_importer reads them
  database.db                cameras, images, keypoints, descriptors, matches, two-view geometries; COLMAP 3.12 and later make no change but to
                             add what is theirs, earlier ones overlook rigs and frames. Its keypoints are aligned: moved to where all of their matches agree,
                             by at most 20 px, never out of the picture or under its mask; one that would be, and all with --align false, stay as found
  manifest.json              with which parameters this was made
  records/NAME.png.json      what is finished: its frames with their lengths, times and checksums
  records/pairs/             the pairs that are matched, before the places are aligned: A.png/B.png.pair

Camera file: model = \"PINHOLE\", width = 640, height = 480, params = [500.0, 500.0, 320.0, 240.0], a line each. Bursts of several cameras have one each:
--camera left=a.toml --camera right=b.toml, where left is a burst or a folder of bursts (the nearest counts), or a file camera.toml beside their frames or in a folder
above them in DATASET; --camera b.toml alone is for all other bursts, whatever files they have. Equal cameras are one in the database. Without a camera, COLMAP's guess is taken. Models: COLMAP's up to
RAD_TAN_THIN_PRISM_FISHEYE, with its parameters in its order: SIMPLE_PINHOLE f,cx,cy; PINHOLE fx,fy,cx,cy; SIMPLE_RADIAL f,cx,cy,k; OPENCV fx,fy,cx,cy,k1,k2,p1,p2;
OPENCV_FISHEYE fx,fy,cx,cy,k1,k2,k3,k4; …. The centre of the first pixel is at (0.5, 0.5). With known cameras matches are verified by the essential matrix, otherwise, and
where only one of the two cameras of a pair is known, by the fundamental matrix. The mapper's line holds the cameras if all are known; else it refines them all.

JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"colmap\", \"params\": {as in the parameter file}, \"matching\", \"database\", \"images_folder\",
   \"cameras\": [{\"model\", \"width\", \"height\", \"params\", \"known\": or guessed, \"from\": [file] of those of some bursts, \"images\": [id]}], \"known_camera\": whether all are,
   \"images\": [{\"id\", \"burst\", \"image\", \"frames\": in which features were found, \"features\", \"resumed\"}],
   \"pairs\": [{\"ids\": [a, b], \"resumed\", \"keypoints_a\", \"keypoints_b\", \"putative\", \"inliers\", \"refused\": why there are none, else absent}],
   \"joined\": by verified pairs, {\"parts\": [[burst]], the largest first, \"alone\": [burst], \"refused_by_motions\": pairs, \"refused_by_pictures\": pairs,
   \"refused_by_tracks\": pairs},
   \"moved\": null without an alignment, or {\"share\": of the keypoints, \"median_px\", \"max_px\", \"refused\": keypoints that stay as found},
   \"beside\": inliers, of all pairs, that the pictures beside other inliers show and no descriptor,
   \"implied\": inliers, of all pairs, that the matches of both with other images imply,
   \"no_start\": null, or why a mapper will not be able to start from the database,
   \"gathered\": with --gather, {\"brought\": [burst], \"left_out\": [{\"folder\", \"burst\", \"reason\"}], \"strange_folders\": [path]},
   \"failures\": [{\"name\", \"error\"}], \"next\": [command]}";
