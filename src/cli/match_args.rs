//! The arguments of `match` as they are written.

use super::burst_search_args::BurstSearchArgs;
use super::choices::{IMAGE_KINDS, words};
use super::matching_args::MatchingArgs;
use super::output_args::OverwriteArgs;
use crate::dataset::ImageKind;
use crate::export::ExportFormat;
use clap::Args;
use std::path::PathBuf;

/// Match the features of two bursts, and verify the matches.
///
/// The features of both bursts are found with the same parameters. Each is matched with the one of the other burst
/// whose descriptor is nearest, if it is clearly nearer than the second nearest and if that holds both ways; matches on
/// which a geometry of the two views agrees are inliers.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = MATCH_HELP)]
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
    /// What the picture shows of each burst: middle, its middle frame, or merged, its frames merged; stretched to 8
    /// bit.
    #[arg(long, value_name = "KIND", default_value = "middle", value_parser = words::<ImageKind>(IMAGE_KINDS))]
    pub images: ImageKind,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub matching: MatchingArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

const MATCH_HELP: &str = "\
Files in DIR, for bursts A and B:
  A.csv, B.csv       features, as 'detect' writes them
  A_B.matches.csv    a,b,u_a,v_a,u_b,v_b,distance,ratio,error_px,inlier; a and b count the features from 0
  A_B.matches.png    both pictures, inliers solid and yellow, other matches dashed and vermilion

Numbers, as in the paper's tables: match ratio = putative matches over keypoints, match score = inliers over keypoints (each the mean of A's and B's), precision =
inliers over putative matches.

JSON (--json):
  {\"version\", \"command\": \"match\", \"params\": {as in the parameter file}, \"matching\", \"a\": {as a burst of 'detect'}, \"b\",
   \"keypoints_a\", \"keypoints_b\", \"putative\", \"inliers\", \"match_ratio\", \"match_score\", \"precision\",
   \"model\": null or {\"kind\", \"matrix\": [[row], …]}, \"files\": {\"matches\", \"picture\"}}
  The matrix maps pixels whose first centre is at (0, 0): x_b^T F x_a = 0, or x_b ~ H x_a; the essential matrix maps directions. inliers, match_score and
  precision are null where nothing was verified (--geometry none).";
