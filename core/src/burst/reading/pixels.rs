//! Conversion of a file's samples to one float value a pixel, and turning of photographs as the camera was held.
//!
//! Colour becomes luma: Y' = 0.2126 R' + 0.7152 G' + 0.0722 B', the weights of Rec. ITU-R BT.709, applied to the values
//! as stored, that is gamma-encoded, unless the [`Curve`] undoes the encoding first. Alpha is ignored.
//!
//! Of a mosaic of colours before a sensor nothing is filled in (demosaicing), which would make noise that neighbours
//! share: the four pixels of a square become one, their mean ([`RawColour::Luma`]), or one colour alone is taken.

use super::{FileScale, RawFrame};
use crate::burst::layout::Mosaic;
use crate::burst::options::{OpenOptions, RawColour};
use crate::error::{Error, ErrorKind, Result};
use crate::plane::{Plane, memory};
use image::metadata::Orientation;
use std::{path::Path, sync::LazyLock};

/// Weights of Rec. 709 for red, green and blue. They sum to 1.
pub const LUMA_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

pub trait Sample: Copy {
    fn to_f32(self) -> f32;
}

macro_rules! sample {
    ($($type:ty)*) => { $(impl Sample for $type {
        #[inline]
        fn to_f32(self) -> f32 {
            self as f32
        }
    })* };
}

sample!(u8 u16 u32 u64 i8 i16 i32 i64 f32 f64);

impl Sample for half::f16 {
    fn to_f32(self) -> f32 {
        self.to_f32()
    }
}

/// Luma of a colour. The luma of grey (r = g = b) is exact, because only differences are weighted.
#[inline]
fn luma(r: f32, g: f32, b: f32) -> f32 {
    g + LUMA_WEIGHTS[0] * (r - g) + LUMA_WEIGHTS[2] * (b - g)
}

/// Conversion of stored samples to fractions of full scale.
#[derive(Debug, Clone, Copy)]
pub enum Curve {
    Linear(f32),
    /// Inverse of the sRGB encoding (IEC 61966-2-1) of samples up to this value; the result is proportional to light.
    Srgb(f32),
}

impl Curve {
    pub fn of(largest: f32, linearise: bool) -> Self {
        if linearise { Self::Srgb(largest) } else { Self::Linear(largest) }
    }
}

static BYTES_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|n| linear(n as f64 / 255.0)));

/// Linear intensity of an sRGB-encoded value, both 0 … 1.
fn linear(encoded: f64) -> f32 {
    (if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }) as f32
}

fn byte_linear<T: Sample>(byte: T) -> f32 {
    BYTES_LINEAR[(byte.to_f32() as usize).min(255)]
}

fn sample_linear<T: Sample>(largest: f32) -> impl Fn(T) -> f32 {
    move |sample| linear(f64::from(sample.to_f32()) / f64::from(largest))
}

/// One value for each pixel of interleaved `samples` (1 to 4 channels: grey or RGB, without or with alpha), by `curve`.
pub fn grey_from_interleaved<T: Sample>(samples: &[T], channels: usize, curve: Curve) -> Vec<f32> {
    // The curve is chosen here, not for each sample: a loop over pixels without a branch is vectorised.
    match curve {
        Curve::Linear(divisor) => interleaved(samples, channels, T::to_f32, divisor),
        Curve::Srgb(255.0) => interleaved(samples, channels, byte_linear, 1.0),
        Curve::Srgb(largest) => interleaved(samples, channels, sample_linear(largest), 1.0),
    }
}

fn interleaved<T: Sample>(samples: &[T], channels: usize, value: impl Fn(T) -> f32, divisor: f32) -> Vec<f32> {
    let pixels = samples.chunks_exact(channels);
    let mut grey = memory::with_capacity(pixels.len());
    match channels {
        1 => grey.extend(samples.iter().map(|s| value(*s) / divisor)),
        2 => grey.extend(pixels.map(|s| value(s[0]) / divisor)),
        _ => grey.extend(pixels.map(|s| luma(value(s[0]), value(s[1]), value(s[2])) / divisor)),
    }
    grey
}

pub fn grey_from_planes<T: Sample>(red: &[T], green: &[T], blue: &[T], curve: Curve) -> Vec<f32> {
    match curve {
        Curve::Linear(divisor) => of_planes([red, green, blue], T::to_f32, divisor),
        Curve::Srgb(255.0) => of_planes([red, green, blue], byte_linear, 1.0),
        Curve::Srgb(largest) => of_planes([red, green, blue], sample_linear(largest), 1.0),
    }
}

fn of_planes<T: Sample>([red, green, blue]: [&[T]; 3], value: impl Fn(T) -> f32, divisor: f32) -> Vec<f32> {
    let mut grey = memory::with_capacity(red.len());
    grey.extend(red.iter().zip(green).zip(blue).map(|((r, g), b)| luma(value(*r), value(*g), value(*b)) / divisor));
    grey
}

pub fn turned_size((width, height): (usize, usize), orientation: Orientation) -> (usize, usize) {
    match orientation {
        Orientation::Rotate90 | Orientation::Rotate270 | Orientation::Rotate90FlipH | Orientation::Rotate270FlipH => {
            (height, width)
        }
        _ => (width, height),
    }
}

pub fn turned_mosaic(mosaic: Mosaic, size: (usize, usize), orientation: Orientation) -> Mosaic {
    // A small picture that ends as the whole one does: odd sides shift the pattern in turning.
    let colours = Plane::from_fn(2 + size.0 % 2, 2 + size.1 % 2, |u, v| mosaic.colour_at(u, v) as f32);
    let colours = turned(colours, orientation);
    Mosaic::of(|u, v| colours.at(u, v) as usize).unwrap_or(mosaic)
}

pub fn turned(plane: Plane, orientation: Orientation) -> Plane {
    let (width, height) = plane.size();
    let (right, bottom) = (width - 1, height - 1);
    let (new_width, new_height) = turned_size((width, height), orientation);
    if orientation == Orientation::NoTransforms {
        return plane;
    }
    Plane::from_fn(new_width, new_height, |u, v| match orientation {
        Orientation::NoTransforms => plane.at(u, v),
        Orientation::FlipHorizontal => plane.at(right - u, v),
        Orientation::FlipVertical => plane.at(u, bottom - v),
        Orientation::Rotate180 => plane.at(right - u, bottom - v),
        Orientation::Rotate90 => plane.at(v, bottom - u),
        Orientation::Rotate270 => plane.at(right - v, u),
        // First turned, then flipped from left to right.
        Orientation::Rotate90FlipH => plane.at(v, u),
        Orientation::Rotate270FlipH => plane.at(right - v, bottom - u),
    })
}

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

/// Mean of the wanted pixels of each square of 2×2, of an area of `size`; `None` for one smaller than a square.
pub fn binned(
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

pub fn with_mosaic(path: &Path, frame: RawFrame, options: &OpenOptions) -> Result<RawFrame> {
    // A raw frame's mosaic is known to its decoder.
    let is_raw = matches!(frame.scale, FileScale::Raw { .. });
    let Some(mosaic) = options.mosaic_of(frame.mosaic).filter(|_| !is_raw) else { return Ok(frame) };
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
