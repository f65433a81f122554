//! How the values of a picture follow the light.

use serde::{Deserialize, Serialize};

/// How the values of a burst's files follow the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Encoding {
    /// In proportion, as far as the files say.
    #[default]
    Linear,
    /// Encoded for screens (sRGB): dark values are spread, bright ones crowded. Colour pictures of 8 bit, JPEG and
    /// WebP.
    Srgb,
}
