//! Relation of a picture's values to light.

use serde::{Deserialize, Serialize};

/// Relation of the values of a burst's files to light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Encoding {
    /// Proportional to light, as far as the files tell.
    #[default]
    Linear,
    /// Encoded for screens (sRGB), with more codes for dark values than for bright ones. Colour pictures of 8 bit, JPEG
    /// and WebP.
    Srgb,
}
