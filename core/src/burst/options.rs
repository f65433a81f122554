//! Options for opening a burst: calibration, linearisation, and the colour that is taken of raw frames.

use super::limits::Limits;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Options for opening a burst.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OpenOptions {
    /// A bias frame, or a stack or folder of them, which is averaged. It is subtracted in the frames' unit, before the
    /// division by the full scale. Negative differences are kept: clipping them would raise the mean of the noise and
    /// make it look smaller than it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bias: Option<PathBuf>,
    /// A flat frame, or a stack or folder of them, which is averaged: a picture of an even surface. The frames are
    /// divided by it (less the bias, over its mean), which corrects the lens's vignetting and each pixel's own
    /// sensitivity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flat: Option<PathBuf>,
    /// File value that becomes 1.0, such as 4095 for 12-bit values in 16-bit files. `None` takes it from the files: see
    /// [`super::Burst::open_with`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_scale: Option<f32>,
    /// File value that becomes 0, where there is no bias frame; values below it become negative. `None` is 0, or a raw
    /// file's own level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub black_level: Option<f32>,
    /// Whether to undo the sRGB encoding of integer pictures, so that values are proportional to light.
    pub linearise: bool,
    /// Whether JPEG frames whose data is damaged or ends early are accepted as far as they can be decoded; the rest of
    /// such a frame is grey. [`super::Burst::remarks`] lists them.
    pub accept_damaged: bool,
    /// Colour that is taken of a raw frame.
    pub raw_colour: RawColour,
    /// Limits of the burst's size.
    #[serde(skip)]
    pub limits: Limits,
}

impl OpenOptions {
    /// Whether every option but the limits has its default: nothing is calibrated.
    pub fn is_plain(&self) -> bool {
        *self == Self { limits: self.limits, ..Self::default() }
    }
}

/// Colour that is taken of a raw frame, whose pixels have one colour each, in squares of 2×2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RawColour {
    /// The mean of the four pixels of a square.
    #[default]
    Luma,
    /// The mean of the two green pixels.
    Green,
    /// The red pixel, which is not in the middle of its square.
    Red,
    /// The blue pixel, which is not in the middle of its square.
    Blue,
}
