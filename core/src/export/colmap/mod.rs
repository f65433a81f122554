//! Export to COLMAP: features as [text](text) for its importer, and a [database](database) with features, matches and
//! two-view geometries, from which its mapper can start directly.
//!
//! In COLMAP the centre of the first pixel is (0.5, 0.5), in Burstscope it is (0, 0); 0.5 is added here and nowhere
//! else. All input of this module is in Burstscope's convention.

#[cfg(feature = "colmap")]
mod database;
mod text;

#[cfg(feature = "colmap")]
pub use database::{
    DatabaseCamera, DatabaseGeometry, DatabaseWriter, GeometryKind, MAX_IMAGE_ID, pair_id, write_colmap_database,
};
pub(super) use text::is_colmap_text;
pub use text::{ColmapKeypoint, parse_colmap, read_colmap, write_colmap, write_colmap_keypoints};
