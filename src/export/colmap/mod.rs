//! What COLMAP takes: features as [text](text) for its importer, and a [database](database) with features, matches and two-view geometries, from which its mapper
//! can begin at once.
//!
//! In COLMAP the centre of the first pixel is (0.5, 0.5), in Burstscope it is (0, 0); here, and only here, 0.5 is added. Everything that this room takes is
//! in Burstscope's convention.

mod database;
mod geometry;
mod keypoint;
mod schema;
#[cfg(test)]
mod tests;
mod text;

pub use database::{DatabaseCamera, DatabaseWriter, MAX_IMAGE_ID, pair_id, write_colmap_database};
pub use geometry::{DatabaseGeometry, GeometryKind};
pub use keypoint::ColmapKeypoint;
pub use text::{read_colmap, write_colmap, write_colmap_keypoints};
