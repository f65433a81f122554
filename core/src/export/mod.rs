//! Export: one source file for each file format.
//!
//! Pictures are written as 32-bit float TIFF (exact values) or PNG (as shown), drawings as SVG, PDF or PNG, and their
//! numbers as CSV or LaTeX. Every file is written completely or not at all, see [`write_whole`]; [`OutputRules`]
//! decides which files may be replaced. `kept` records what results were made from.

mod atomic;
pub mod case;
mod colmap;
mod csv;
mod density;
mod drawing;
pub mod film;
mod floats;
mod format;
mod kept;
mod npz;
mod outputs;
mod png;

pub use atomic::{FileWriter, write_marked, write_text, write_whole};
pub use colmap::{ColmapKeypoint, parse_colmap, read_colmap, write_colmap, write_colmap_keypoints};
#[cfg(feature = "colmap")]
pub use colmap::{DatabaseGeometry, DatabaseWriter, GeometryKind, MAX_IMAGE_ID, pair_id, write_colmap_database};
pub use csv::{
    ACCURACY_COLUMNS, ANGLE_COLUMNS, BURST_FRAMES_COLUMNS, CURVE_COLUMNS, FLIGHT_COLUMNS, FeatureVerdict,
    MATCH_COLUMNS, METHOD_COLUMNS, METHOD_MATCH_COLUMNS, MatchRow, NOISE_COLUMNS, PLANTED_COLUMNS, POSE_COLUMNS,
    PROFILE_COLUMNS, SPECTRUM_COLUMNS, VERDICT_COLUMNS, feature_header, profiles_table, read_features_csv, write_csv,
    write_matches_csv,
};
pub use density::{Cells, IN_A_CELL};
pub use drawing::*;
pub use floats::{write_field_pfm, write_field_tiff, write_tiff};
pub use format::{ExportFormat, detection_files, make_file_names_unique, safe_file_name, write_detection};
pub use kept::{MadeFrom, RECORDS_FOLDER, Record, Records, may_begin};
pub use npz::{write_field_npz, write_npz};
pub use outputs::{OpenedFiles, OutputRules, Overwrite, is_ours};
pub use png::{Bitmap, write_png};
