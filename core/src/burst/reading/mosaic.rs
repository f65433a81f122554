//! Binning of the mosaic of colours before a sensor.
//!
//! Filling in the colours (demosaicing) would make noise that neighbours share. So the four pixels of a square become
//! one, their mean ([`RawColour::Luma`]), or one colour alone is taken; places, scales and slopes are in binned pixels.

use super::{FileScale, RawFrame};
use crate::burst::options::{OpenOptions, RawColour};
use crate::error::{Error, ErrorKind, Result};
use crate::plane::Plane;
use std::path::Path;

impl RawColour {
    /// Index of the colour (red, green, blue) that is taken; `None` for all.
    pub(in crate::burst) fn index(self) -> Option<usize> {
        match self {
            Self::Luma => None,
            Self::Red => Some(0),
            Self::Green => Some(1),
            Self::Blue => Some(2),
        }
    }
}

/// One value for each square of 2×2 pixels of an area of `size`: the mean of the wanted pixels. `None` for an area that
/// is smaller than a square.
pub(in crate::burst) fn binned(
    size: (usize, usize),
    colour: RawColour,
    colour_at: impl Fn(usize, usize) -> usize,
    at: impl Fn(usize, usize) -> f32,
) -> Option<Plane> {
    let (width, height) = (size.0 / 2, size.1 / 2);
    if width == 0 || height == 0 {
        return None;
    }
    let is_wanted = |&(u, v): &(usize, usize)| colour.index().is_none_or(|c| c == colour_at(u, v));
    let wanted: Vec<(usize, usize)> = (0..4).map(|k| (k % 2, k / 2)).filter(is_wanted).collect();
    let share = 1.0 / wanted.len() as f32;
    Some(Plane::from_fn(width, height, |u, v| {
        wanted.iter().map(|(du, dv)| at(2 * u + du, 2 * v + dv)).sum::<f32>() * share
    }))
}

/// The frame with its mosaic binned, where the options or the file say that there is one.
pub(in crate::burst) fn applied(path: &Path, frame: RawFrame, options: &OpenOptions) -> Result<RawFrame> {
    // A raw frame's mosaic is known to its decoder.
    let is_raw = matches!(frame.scale, FileScale::Raw { .. });
    let Some(mosaic) = options.mosaic.or(frame.mosaic).filter(|_| !is_raw) else { return Ok(frame) };
    let refused = |problem: &str, remedy: &str| Error::new(ErrorKind::Unsupported, problem, remedy).about(path);
    if frame.is_colour {
        return Err(refused("a mosaic of colours is asked for, but this frame has colours already", "leave it out"));
    }
    let plane = &frame.plane;
    let plane = binned(plane.size(), options.raw_colour, |u, v| mosaic.colour_at(u, v), |u, v| plane.at(u, v));
    let plane =
        plane.ok_or_else(|| refused("this frame is smaller than a square of its mosaic", "open larger frames"))?;
    Ok(RawFrame { plane, binning: 2, ..frame })
}
