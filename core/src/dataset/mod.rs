//! A dataset: many bursts along a robot's way, and what is made of all of them together.
//!
//! Features of each burst ([`features`]: found once, kept in files, and taken from these the next time), matches of
//! chosen pairs of bursts ([`pairs`]), what several runs have found brought together ([`mod@gather`]), and the folder
//! from which COLMAP goes on ([`colmap`]): images, feature files and its database. [`camera`] says what is known of the
//! lens.

pub mod camera;
#[cfg(feature = "colmap")]
pub mod colmap;
mod error;
pub mod features;
pub mod gather;
#[cfg(feature = "colmap")]
mod geometry;
mod kept;
mod manifest;
pub mod pairs;
mod picture;
mod source;
mod stamp;
mod thumbnail;

pub use camera::{CameraChoice, GUESSED_FOCAL_FACTOR};
#[cfg(feature = "colmap")]
pub use colmap::{ColmapJob, ColmapReport, Event, ImageReport, PairReport, export_colmap, export_colmap_from};
pub use error::DatasetError;
pub use features::{BurstEvent, BurstFeatures, FeatureJob, FeatureStore, FinishedBurst, detect_all, image_name};
pub use gather::{GatherReport, LeftOut, gather};
pub use kept::NotKept;
pub use pairs::match_pairs;
pub use picture::{BurstPicture, ImageKind, burst_picture};
pub use source::DatasetSource;
pub(crate) use stamp::Checksum;
pub use stamp::Comparison;
pub use thumbnail::{Thumbnail, thumbnail};
