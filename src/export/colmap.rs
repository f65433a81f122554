//! The text that COLMAP's feature importer reads: `N 128`, then for each feature `x y scale orientation d1 … d128`.
//!
//! In COLMAP the centre of the first pixel is (0.5, 0.5), in Burstscope it is (0, 0), so 0.5 is added. The descriptors are in UBC order, which is the order of
//! [`Descriptor`] and the one that COLMAP's own SIFT writes. Format: <https://colmap.github.io/tutorial.html#feature-detection-and-extraction>.

use super::atomic::write_whole;
use super::error::ExportError;
use crate::detector::{Descriptor, Feature};
use std::io::Write;
use std::path::Path;

/// Half a pixel: the place of the first pixel's centre in COLMAP.
const COLMAP_FIRST_PIXEL: f64 = 0.5;

/// Writes features and descriptors for COLMAP's importer.
///
/// # Errors
/// [`ExportError`] when the file cannot be written; an older one is then untouched.
///
/// # Panics
/// When there is not one descriptor for each feature: a mistake of the caller.
pub fn write_colmap(path: &Path, features: &[Feature], descriptors: &[Descriptor]) -> Result<(), ExportError> {
    assert_eq!(features.len(), descriptors.len(), "each feature has one descriptor");
    write_whole(path, |out| {
        writeln!(out, "{} 128", features.len())?;
        for (f, descriptor) in features.iter().zip(descriptors) {
            // COLMAP reads 32-bit floats; the sum is rounded once.
            let x = (f64::from(f.u) + COLMAP_FIRST_PIXEL) as f32;
            let y = (f64::from(f.v) + COLMAP_FIRST_PIXEL) as f32;
            write!(out, "{x} {y} {} {}", f.sigma, f.orientation)?;
            for value in descriptor {
                write!(out, " {value}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    })
}
