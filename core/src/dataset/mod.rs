//! A dataset: many bursts along a robot's path, and the results from all of them together.
//!
//! Features of each burst ([`features`]), matches of pairs of bursts ([`pairs`]), gathering of the features of several
//! runs ([`mod@gather`]), and the folder for COLMAP ([`colmap`]). [`camera`] describes the lenses.

mod blobs;
pub mod camera;
#[cfg(feature = "colmap")]
pub mod colmap;
pub mod features;
pub mod gather;
#[cfg(feature = "colmap")]
mod joint;
mod kept;
#[cfg(feature = "colmap")]
mod kept_pairs;
pub mod pairs;
mod picture;
mod report;
mod source;
mod stamp;

pub use camera::{BurstCameras, CameraChoice};
#[cfg(feature = "colmap")]
pub use colmap::{ColmapJob, export_colmap, export_detections, read_exported};
pub use features::{BurstEvent, BurstFeatures, FeatureJob, FeatureStore, FinishedBurst, detect_all, image_name};
pub use gather::{GatherReport, LeftOut, gather};
pub use kept::NotKept;
pub use pairs::{
    BurstSide, DetectedBurst, KeptBursts, MatchedPair, PairSource, match_bursts, match_pairs, match_rows, read_pairs,
};
pub use picture::{BurstPicture, ImageKind, burst_plane, thumbnail};
pub use report::{CameraReport, ColmapReport, INLIERS_TO_START, ImageReport, Joined, PairReport};
pub use source::DatasetSource;
pub use stamp::Comparison;
