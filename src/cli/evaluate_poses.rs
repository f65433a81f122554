//! `evaluate poses`: compares an estimated trajectory with the true one.

use super::study::{TableArgs, write_figure};
use super::{Both, Console, Outcome, OutputArgs, document};
use crate::burst::OpenOptions;
use crate::evaluate::poses::{ErrorSummary, ModelSummary, PoseReport, PoseStudy, evaluate_poses, read_trajectory};
use crate::export::{Cell, POSE_COLUMNS, Table};
use crate::inspect::words::counted;
use clap::Args;
use std::path::PathBuf;

/// Compare camera poses that were estimated with the true ones.
///
/// Poses are paired, and the estimate is laid on the truth by the best similarity of the camera centres (scale,
/// rotation, translation; Umeyama 1991). Then the errors are: the absolute trajectory error of each pose, and the
/// relative pose error of the motion from one pose to the next, in translation (the truth's unit of length) and
/// rotation. Cameras on a straight line leave the rotation about that line open; there the directions in which they
/// look decide.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = POSES_HELP)]
pub struct PosesArgs {
    /// COLMAP's sparse model (its folder or a file in it, or the folder above: then its largest part is taken), or a
    /// trajectory file.
    #[arg(long, value_name = "SPARSE_DIR")]
    pub estimate: PathBuf,
    /// The true poses: a trajectory file 'timestamp tx ty tz qx qy qz qw' (an image's name may stand for the time), or
    /// a sparse model.
    #[arg(long, value_name = "POSES")]
    pub truth: PathBuf,
    #[command(flatten)]
    pub study: PoseStudy,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub file: TableArgs,
}

const POSES_HELP: &str = "\
Pairing: names are compared whole, or without folders and endings if no two agree. Times of a sparse model are the last numbers in its images'
names (23 for image.0023.png). The order is the image's id, or the line.

JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"evaluate poses\", \"estimate\", \"truth\", \"images\", \"registered\", \"right\": cameras, \"images_pass_percent\", \"associated\", \"scale\", \"straight\",
   \"absolute\": {\"count\", \"translation\": {\"rmse\", \"mean\", \"median\", \"max\"}, \"rotation_deg\": {…}}, \"common_rotation_deg\", \"step\", \"relative\": {as absolute},
   \"model\": null or {\"registered_images\", \"points\", \"points_per_image\", \"mean_track_length\", \"mean_reprojection_error_px\"},
   \"pairs\": [{\"label\", \"true_centre\": [x, y, z], \"aligned_centre\", \"translation_error\", \"rotation_error_deg\"}]}";

pub(super) fn run(args: &PosesArgs) -> Outcome {
    let console = Console::new(&args.output)?;
    let rules = args.file.overwrite.rules(&[], &OpenOptions::default(), &[Some(&args.estimate), Some(&args.truth)]);
    args.file.table.iter().try_for_each(|path| rules.check(path))?;
    let estimate = read_trajectory(&args.estimate)?;
    let truth = read_trajectory(&args.truth)?;
    let report = evaluate_poses(&estimate, &truth, &args.study)?;
    if let Some(taken) = estimate.model.as_ref().and_then(|model| model.taken()) {
        console.say(&format!("{taken}\n"))?;
    }
    console.say(&text(&report))?;
    write_figure(&console, args.file.table.as_deref(), &rules, || errors_table(&report).into())?;
    let images_pass_percent = report.images_pass_percent();
    let one = document! { estimate: &args.estimate, truth: &args.truth, images_pass_percent };
    console.say_document("evaluate poses", &Both { one, other: &report })
}

fn text(report: &PoseReport) -> String {
    let passed = report.images_pass_percent();
    let images = counted(report.images, "image");
    let mut text = format!(
        "{} of {images} registered ({passed:.0} %), {} right, within 3 % of the way's extent and 3°\n",
        report.registered,
        counted(report.right, "camera")
    );
    if let Some(ModelSummary { points, points_per_image, mean_track_length, mean_reprojection_error_px, .. }) =
        report.model
    {
        text += &format!(
            "{}, {points_per_image:.1} an image, seen in {mean_track_length:.2} images each, mean reprojection error {mean_reprojection_error_px:.3} px\n",
            counted(points, "3D point")
        );
    }
    let on_line = "; they lie on a line, so the cameras' directions fixed the rotation about it";
    let (count, paired, scale) = (report.absolute.count, report.associated.phrase(), report.scale);
    let straight = if report.straight { on_line } else { "" };
    text += &format!("{count} poses paired {paired}, aligned with scale {scale:.6}{straight}\n");
    text += if count > 2 { "\n" } else { "two poses always fit: their errors say nothing\n\n" };
    text += &errors_table(report).headed(&[""]).text();
    let (common, mean) = (report.common_rotation_deg, report.absolute.rotation_deg.mean);
    if count > 2 && common > 0.5 * mean {
        text += &format!("all cameras turned by {common:.2}° in common, as by a principal point that is off\n");
    }
    if report.relative.count == 0 {
        text += &format!("no motion over {} poses: fewer are paired\n", report.step);
    }
    text
}

fn errors_table(report: &PoseReport) -> Table {
    let row = |words: String, e: &ErrorSummary| {
        let numbers = [e.rmse, e.mean, e.median, e.max].map(|error| Cell::Number(error, 6));
        std::iter::once(Cell::Text(words)).chain(numbers).collect()
    };
    let mut rows = vec![
        row("absolute trajectory error, truth's unit".to_owned(), &report.absolute.translation),
        row("absolute trajectory error, deg".to_owned(), &report.absolute.rotation_deg),
    ];
    if report.relative.count > 0 {
        let over = if report.step == 1 { String::new() } else { format!(" over {} poses", report.step) };
        rows.push(row(format!("relative pose error{over}, truth's unit"), &report.relative.translation));
        rows.push(row(format!("relative pose error{over}, deg"), &report.relative.rotation_deg));
    }
    Table::new("Errors of poses", POSE_COLUMNS, rows).headed(&["error", "RMSE"])
}
