//! Options of opening a burst: how values in files become intensities.

use super::choices::{RAW_COLOURS, words};
use crate::burst::{OpenOptions, RawColour};
use clap::Args;
use std::path::PathBuf;

/// How the values of files become light.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Calibration", allow_negative_numbers = true)]
pub struct CalibrationArgs {
    /// Bias frame (or stack or folder of them, which is averaged), subtracted from each frame. Files of another kind
    /// are converted to the frames' unit, or refused.
    #[arg(long, value_name = "FILE")]
    pub bias: Option<PathBuf>,
    /// Flat frame (or stack or folder of them, which is averaged): a picture of an even surface, by which each frame is
    /// divided.
    #[arg(long, value_name = "FILE")]
    pub flat: Option<PathBuf>,
    /// Value in the files that becomes intensity 1, such as 4095 for 12 bits in 16-bit files [default: what their type
    /// can hold].
    #[arg(long, value_name = "VALUE")]
    pub full_scale: Option<f32>,
    /// Value in the files that becomes intensity 0; values below it become negative [default: 0, or what a raw file
    /// says].
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub black_level: Option<f32>,
    /// Undo the sRGB encoding of 8 and 16-bit pictures, so that values are proportional to light.
    #[arg(long)]
    pub linearise: bool,
    /// Take JPEG frames whose data is damaged or ends early as far as they can be decoded; the rest of such a frame is
    /// grey. The notes say which they are [default: such a frame is an error].
    #[arg(long)]
    pub accept_damaged: bool,
    /// What is taken of the 2×2 colours of raw frames: luma, the mean of the four, green, the mean of two, red or blue
    /// [default: luma].
    #[arg(long, value_name = "COLOUR", value_parser = words::<RawColour>(RAW_COLOURS))]
    pub raw_colour: Option<RawColour>,
}

impl CalibrationArgs {
    /// Options with which bursts are opened.
    pub fn options(&self) -> OpenOptions {
        OpenOptions {
            bias: self.bias.clone(),
            flat: self.flat.clone(),
            full_scale: self.full_scale,
            black_level: self.black_level,
            linearise: self.linearise,
            accept_damaged: self.accept_damaged,
            raw_colour: self.raw_colour.unwrap_or_default(),
            ..OpenOptions::default()
        }
    }
}
