//! Bursts of arrays in memory, calibrated as files of the same type are.

use super::open::{Measured, RawBurst, calibrated};
use super::reading::{FileScale, RawFrame, frame_of_plane};
use super::{Burst, layout::ViewsChoice, masks::Masks, options::OpenOptions, views::placed};
use crate::error::{Error, Result};
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use std::path::{Path, PathBuf};

/// Frame in memory, before calibration.
#[derive(Debug, Clone)]
pub enum ArrayFrame {
    /// Integers of 8 or 16 bit, as fractions of their type's largest value.
    Integers {
        /// The integers divided by `range`, in [0, 1].
        plane: Plane,
        /// Largest value of the type: 255 or 65535.
        range: f32,
    },
    /// Floats in any unit.
    Floats(Plane),
}

impl ArrayFrame {
    /// Frame of 8-bit integers, row by row. Panics if there are not `width × height`.
    pub fn of_u8(width: usize, height: usize, values: impl ExactSizeIterator<Item = u8>) -> Self {
        Self::integers(width, height, f32::from(u8::MAX), values.map(f32::from))
    }

    /// Frame of 16-bit integers, row by row. Panics if there are not `width × height`.
    pub fn of_u16(width: usize, height: usize, values: impl ExactSizeIterator<Item = u16>) -> Self {
        Self::integers(width, height, f32::from(u16::MAX), values.map(f32::from))
    }

    fn integers(width: usize, height: usize, range: f32, values: impl ExactSizeIterator<Item = f32>) -> Self {
        let mut pixels = crate::plane::memory::with_capacity(values.len());
        pixels.extend(values.map(|value| value / range));
        Self::Integers { plane: Plane::from_vec(width, height, pixels), range }
    }

    fn plane(&self) -> &Plane {
        match self {
            Self::Integers { plane, .. } | Self::Floats(plane) => plane,
        }
    }

    fn decoded(self, path: &Path, t: usize) -> Result<RawFrame> {
        match self {
            Self::Integers { plane, range } => Ok(RawFrame::linear(plane, FileScale::Range(range))),
            Self::Floats(plane) => frame_of_plane(path, t, plane, false),
        }
    }
}

/// Arrays of which a burst is made; all frames of each are of one type.
#[derive(Debug, Clone, Default)]
pub struct Arrays {
    /// Frames of the burst, in time order.
    pub frames: Vec<ArrayFrame>,
    /// Bias frames, which are averaged; empty for none.
    pub bias: Vec<ArrayFrame>,
    /// Flat frames, which are averaged; empty for none.
    pub flat: Vec<ArrayFrame>,
    /// Masks, one for all frames or one a frame, as [`OpenOptions::mask`]; empty for none.
    pub mask: Vec<ArrayFrame>,
}

impl Burst {
    /// Makes a burst of arrays, as of `.npy` files ([`Burst::open_with`]); errors name `frames`, `bias`, `flat` or
    /// `mask`. Floats that need no conversion are not copied. Options about levels, saturation, views and limits count.
    pub fn from_arrays(
        name: impl Into<String>,
        arrays: Arrays,
        options: &OpenOptions,
        monitor: &Monitor,
    ) -> Result<Self> {
        monitor.check()?;
        monitor.report(Stage::Open, 0.0);
        let frames = decoded("frames", arrays.frames, options)?.ok_or_else(Error::nothing_given)?;
        let calibration = [decoded("bias", arrays.bias, options)?, decoded("flat", arrays.flat, options)?];
        let count = frames.frames.len();
        // Arrays have no file names, and one array is one view: of the choices of views only a grid applies.
        let views = options.views.filter(|views| matches!(views, ViewsChoice::Grid(_)));
        let of_grid = OpenOptions { views, ..OpenOptions::default() };
        let Measured { frames, path } = frames;
        let frame_names = (0..count).map(|t| format!("frame {t}")).collect();
        let origins = (0..count).map(|t| (path.clone(), t)).collect();
        let positions = placed(&mut vec![path], Some((count, None)), &of_grid, monitor)?.positions;
        let (name, taken, seconds) = (name.into(), Vec::new(), Vec::new());
        let raw = RawBurst { name, frames, frame_names, origins, taken, positions, seconds };
        let mask = decoded("mask", arrays.mask, options)?.map_or_else(Vec::new, |mask| mask.frames);
        let masks = Masks::of_frames(&mask, (count, raw.size()), options, Path::new("mask"))?;
        calibrated(raw, calibration, &masks, Vec::new(), options, monitor)
    }
}

fn decoded(name: &str, frames: Vec<ArrayFrame>, options: &OpenOptions) -> Result<Option<Measured>> {
    let path = PathBuf::from(name);
    let Some(first) = frames.first() else { return Ok(None) };
    let (width, height) = first.plane().size();
    options.limits.check_burst(&path, frames.len() as u64, width as u64, height as u64)?;
    let frames = frames.into_iter().enumerate().map(|(t, frame)| {
        let size = frame.plane().size();
        if size == (width, height) {
            frame.decoded(&path, t)
        } else {
            Err(Error::different_sizes((name, (width, height)), (&format!("{name} (frame {t})"), size)))
        }
    });
    Ok(Some(Measured { frames: frames.collect::<Result<_, _>>()?, path }))
}
