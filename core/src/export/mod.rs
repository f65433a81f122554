//! Export: one source file for each file format.
//!
//! Pictures are written as 32-bit float TIFF (exact values) or PNG (as shown), figures as SVG with a vector overlay or
//! on a [`sheet`] with axes. Every file is written completely or not at all, see [`write_whole`]; [`OutputRules`]
//! decides which files may be replaced. `kept` records what results were made from.

mod atomic;
pub mod case;
mod colmap;
mod csv;
mod density;
mod error;
mod figure;
pub mod film;
mod floats;
mod format;
mod kept;
mod npz;
mod outputs;
mod plot;
mod png;
pub mod sheet;
mod svg;

pub use atomic::{FileWriter, write_marked, write_text, write_whole};
pub use colmap::{ColmapKeypoint, parse_colmap, read_colmap, write_colmap, write_colmap_keypoints};
#[cfg(feature = "colmap")]
pub use colmap::{
    DatabaseCamera, DatabaseGeometry, DatabaseWriter, GeometryKind, MAX_IMAGE_ID, pair_id, write_colmap_database,
};
pub use csv::{
    CURVE_COLUMNS, FeatureVerdict, MATCH_COLUMNS, MatchRow, PLANTED_COLUMNS, PROFILE_COLUMNS, PictureProfile,
    VERDICT_COLUMNS, feature_header, read_features_csv, write_csv, write_matches_csv, write_profiles_csv,
};
pub use density::{Cells, IN_A_CELL};
pub use figure::{
    Colour, ColourBar, DASH, Drawing, FAN_OPACITY, FigureAmount, FigureFormat, FigureLink, FigureMark, FigureMatches,
    FigureOptions, FigurePanel, FigureRect, FigureShape, FigureStroke, FigureUnit, FigureWidth, LegendEntry,
    LegendMark, MatchKind, fan, lay_out, motion_over, round_length, sigma_over, write_drawing_svg,
};
pub use floats::{write_field_pfm, write_field_tiff, write_tiff};
pub use format::{ExportFormat, detection_files, make_file_names_unique, safe_file_name, write_detection};
pub use kept::{MadeFrom, RECORDS_FOLDER, Record, Records, may_begin};
pub use npz::{write_field_npz, write_npz};
pub use outputs::{OpenedFiles, OutputRules, Overwrite, is_ours};
pub use plot::{Plot, Series, SeriesPoint, range_from_zero};
pub use png::{Bitmap, write_png};
pub use svg::Escaped;
