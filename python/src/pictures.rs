//! Arrays as pictures, by the colour maps of the window.

use crate::burst::plane_of;
use burstscope::plane::display::{ColourMap, Display, to_rgba8};
use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, ImageFormat};
use numpy::PyArray2;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::io::Cursor;

/// Names of the colour maps, in the order of the window.
#[pyfunction]
pub(crate) fn colour_maps() -> Vec<&'static str> {
    ColourMap::ALL.iter().map(|map| map.name()).collect()
}

/// The array as a picture, PNG or JPEG of this quality (1 to 100); values from `range` by the colour map.
#[pyfunction]
pub(crate) fn encode_picture(
    array: &Bound<'_, PyArray2<f32>>,
    range: (f32, f32),
    colour_map: &str,
    jpeg_quality: Option<u8>,
) -> PyResult<Vec<u8>> {
    let map = ColourMap::ALL.into_iter().find(|map| map.name().eq_ignore_ascii_case(colour_map));
    let map = map.ok_or_else(|| {
        PyValueError::new_err(format!(
            "there is no colour map '{colour_map}'; give one of {}",
            colour_maps().join(", ")
        ))
    })?;
    let display = Display { map, ..Display::default() }.with_range(range.0, range.1);
    let shown = DynamicImage::from(to_rgba8(&plane_of(array)?, &display));
    let mut bytes = Vec::new();
    let encoded = match (map, jpeg_quality) {
        (ColourMap::Grey, Some(quality)) => {
            JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(&shown.to_luma8())
        }
        (_, Some(quality)) => JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(&shown.to_rgb8()),
        (ColourMap::Grey, None) => shown.to_luma8().write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png),
        (_, None) => shown.to_rgb8().write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png),
    };
    encoded.map_err(|error| PyRuntimeError::new_err(format!("the picture cannot be encoded: {error}")))?;
    Ok(bytes)
}
