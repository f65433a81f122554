//! Export to COLMAP: features as [text](text) for its importer, or a [database](database) for its mapper.
//!
//! Input is in Burstscope's pixels, the first centre at (0, 0); COLMAP's (0.5, 0.5) is made here and nowhere else.

#[cfg(feature = "colmap")]
mod database;
mod text;

#[cfg(feature = "colmap")]
pub use database::{DatabaseGeometry, DatabaseWriter, GeometryKind, MAX_IMAGE_ID, pair_id, write_colmap_database};
/// Centre of the first pixel in COLMAP's convention.
const FIRST_PIXEL: f64 = 0.5;

pub(super) use text::is_colmap_text;
pub use text::{ColmapKeypoint, parse_colmap, read_colmap, write_colmap, write_colmap_keypoints};
