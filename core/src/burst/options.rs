//! How a burst is opened: what is taken off its values and what they are divided by, and what is taken of raw colours.

use super::limits::Limits;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How to open a burst.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OpenOptions {
    /// A bias frame, or a stack or folder of them, which is averaged. It is subtracted in the frames' unit, before the
    /// division by the full scale. Negative differences are kept: clipping them would raise the mean of the noise and
    /// make it look smaller than it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bias: Option<PathBuf>,
    /// A flat frame, or a stack or folder of them, which is averaged: a picture of an even surface. The frames are
    /// divided by it (less the bias, over its mean), which takes off the lens's falling light and each pixel's own
    /// sensitivity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flat: Option<PathBuf>,
    /// The file's value that becomes 1.0, such as 4095 for 12-bit values in 16-bit files. `None` takes it from the
    /// files: see [`super::Burst::open_with`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_scale: Option<f32>,
    /// The file's value that becomes 0, where no bias frame says it; values below it become negative. `None` is 0, or
    /// what a raw file says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub black_level: Option<f32>,
    /// Whether the sRGB encoding of integer pictures is undone, so that values are proportional to light.
    pub linearise: bool,
    /// Whether JPEG frames whose data is damaged or ends early are taken as far as they can be decoded; the rest of
    /// such a frame is grey. [`super::Burst::remarks`] says which they are.
    pub accept_damaged: bool,
    /// What is taken of the colours of a raw frame.
    pub raw_colour: RawColour,
    /// How large the burst may be.
    #[serde(skip)]
    pub limits: Limits,
}

impl OpenOptions {
    /// Whether files are taken as they are: nothing is calibrated.
    pub fn is_plain(&self) -> bool {
        *self == Self { limits: self.limits, ..Self::default() }
    }
}

/// What is taken of the colours of a raw frame, whose pixels see one colour each, in squares of 2×2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RawColour {
    /// The mean of the four pixels of a square: all the light there is.
    #[default]
    Luma,
    /// The mean of the two green pixels.
    Green,
    /// The red pixel; it does not lie in the middle of its square.
    Red,
    /// The blue pixel; it does not lie in the middle of its square.
    Blue,
}
