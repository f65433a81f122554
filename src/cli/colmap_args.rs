//! The arguments of `colmap` as they are written.

use super::args::SequenceArgs;
use super::burst_search_args::BurstSearchArgs;
use super::choices::{CAMERA_MODELS, IMAGE_KINDS, words};
use super::matching_args::MatchingArgs;
use crate::dataset::ImageKind;
use crate::matching::CameraModel;
use crate::matching::PairSelection;
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;

/// Write what COLMAP's mapper takes: images, features and a database with verified matches.
///
/// Each burst becomes an image. Its features are found, matched with those of the other bursts and verified. Bursts
/// whose features are in --out already, found with the same parameters from the same files, are not done again: after
/// an interruption the same command goes on. A burst that cannot be opened is reported and left out.
#[derive(Debug, Clone, Args)]
#[command(after_long_help = COLMAP_HELP)]
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
    /// Which bursts are matched: all, or each with the next K (sequential:K).
    #[arg(long, value_name = "WHICH", default_value_t = PairSelection::default(), value_parser = PairSelection::from_str)]
    pub pairs: PairSelection,
    /// The picture that stands for a burst: middle, its middle frame, or merged, its frames merged; stretched to 8 bit.
    #[arg(long, value_name = "KIND", default_value = "middle", value_parser = words::<ImageKind>(IMAGE_KINDS))]
    pub images: ImageKind,
    /// The model of a guessed camera: focal length 1.2 times the larger side, as COLMAP guesses.
    #[arg(long, value_name = "MODEL", default_value = "SIMPLE_RADIAL", conflicts_with = "camera",
        value_parser = words::<CameraModel>(CAMERA_MODELS))]
    pub camera_model: CameraModel,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub sequence: SequenceArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub matching: MatchingArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub run: BurstSearchArgs,
}

const COLMAP_HELP: &str = "\
Files in DIR:
  images/NAME.png            one for each burst
  features/NAME.png.txt      its features, as COLMAP's feature_importer reads them
  database.db                cameras, images, keypoints, descriptors, matches, two-view geometries; COLMAP 3.12 and later make no change but to
                             add what is theirs, earlier ones overlook rigs and frames
  manifest.json              with which parameters this was made
  records/NAME.png.json      what is finished: its frames with their lengths, times and checksums

Camera file: model = \"PINHOLE\", width = 640, height = 480, params = [500.0, 500.0, 320.0, 240.0], a line each. One camera is shared by all images;
without one, COLMAP's guess is taken. Models: SIMPLE_PINHOLE f,cx,cy;
PINHOLE fx,fy,cx,cy; SIMPLE_RADIAL f,cx,cy,k; OPENCV fx,fy,cx,cy,k1,k2,p1,p2. The centre of the first pixel is at (0.5, 0.5). With a known camera matches are
verified by the essential matrix, otherwise by the fundamental matrix.

JSON (--json):
  {\"version\", \"command\": \"colmap\", \"params\": {as in the parameter file}, \"matching\", \"database\", \"images_folder\", \"cameras\", \"known_camera\",
   \"images\": [{\"id\", \"burst\", \"image\", \"features\", \"resumed\"}],
   \"pairs\": [{\"ids\": [a, b], \"keypoints_a\", \"keypoints_b\", \"putative\", \"inliers\"}],
   \"gathered\": with --gather, {\"brought\": [burst], \"left_out\": [{\"folder\", \"burst\", \"reason\"}], \"strange_folders\": [path]},
   \"failures\": [{\"name\", \"error\"}], \"next\": [command]}";
