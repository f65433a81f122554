//! What leaves the program: one file of code for each file format.
//!
//! Features go out as CSV, as COLMAP's text, or with their descriptors as `.npz`; pictures as 32-bit float TIFF (exact values) or PNG (as shown);
//! figures as SVG with a vector overlay. Every file is written whole or not at all, see [`write_whole`].

mod atomic;
mod base64;
mod colmap;
mod columns;
mod csv;
mod error;
mod format;
mod npz;
mod png;
mod svg;
mod tiff;

pub use atomic::{FileWriter, write_whole};
pub use colmap::write_colmap;
pub use columns::{COLUMNS, FeatureRow};
pub use csv::{read_features_csv, write_csv};
pub use error::ExportError;
pub use format::{ExportFormat, UnknownFormat, safe_file_name, write_detection};
pub use npz::write_npz;
pub use png::{Picture, write_png};
pub use svg::{FigureOptions, LegendEntry, write_svg};
pub use tiff::write_tiff;
