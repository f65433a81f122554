//! PNG, JPEG, PNM, WebP and BMP. Of an animation, the first picture is taken.

use super::{Expected, FileScale, Header, RawFrame, frame_from_data, read_failure};
use crate::burst::error::OpenError;
use crate::burst::limits::Limits;
use crate::burst::luma::{Sample, grey_from_interleaved};
use crate::plane::Plane;
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageReader};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

pub(super) fn header(path: &Path, file: File, format: ImageFormat, limits: &Limits) -> Result<Header, OpenError> {
    let decoder = decoder(path, file, format, limits)?;
    let (width, height) = decoder.dimensions();
    limits.check_frame(path, width.into(), height.into())?;
    Ok(Header { width: width as usize, height: height as usize, frames: 1 })
}

pub(super) fn frame(
    path: &Path,
    file: File,
    format: ImageFormat,
    expected: Expected<'_>,
    limits: &Limits,
) -> Result<RawFrame, OpenError> {
    let decoder = decoder(path, file, format, limits)?;
    let (width, height) = decoder.dimensions();
    limits.check_frame(path, width.into(), height.into())?;
    let size = (width as usize, height as usize);
    expected.check(path, size)?;
    let color = decoder.color_type();
    let channels = usize::from(color.channel_count());
    let values = size.0 * size.1 * channels;
    let failure = |e: ImageError| failure(path, format, e);
    let plane = |values| Plane::from_vec(size.0, size.1, values);
    match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            let values = read::<u8>(decoder, values).map_err(failure)?;
            let values = grey_from_interleaved(&values, channels, 255.0);
            Ok(RawFrame { plane: plane(values), scale: FileScale::Range(255.0) })
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let values = read::<u16>(decoder, values).map_err(failure)?;
            let values = grey_from_interleaved(&values, channels, 65535.0);
            Ok(RawFrame { plane: plane(values), scale: FileScale::Range(65535.0) })
        }
        ColorType::Rgb32F | ColorType::Rgba32F => {
            let values = read::<f32>(decoder, values).map_err(failure)?;
            frame_from_data(path, 0, size, grey_from_interleaved(&values, channels, 1.0), false)
        }
        other => Err(OpenError::Unsupported {
            path: path.into(),
            kind: name(format),
            reason: format!("its pixels are {other:?}; save it as grey or RGB of 8 or 16 bit"),
        }),
    }
}

/// All samples of the picture, in the machine's byte order.
fn read<T: Sample + bytemuck::Pod>(decoder: impl ImageDecoder, count: usize) -> Result<Vec<T>, ImageError> {
    let mut values = vec![T::zeroed(); count];
    decoder.read_image(bytemuck::cast_slice_mut(&mut values))?;
    Ok(values)
}

fn decoder(
    path: &Path,
    file: File,
    format: ImageFormat,
    limits: &Limits,
) -> Result<impl ImageDecoder + use<>, OpenError> {
    let mut reader = ImageReader::with_format(BufReader::with_capacity(1 << 16, file), format);
    let mut own = image::Limits::no_limits();
    // Sizes are checked by `Limits` before pixels are read; this bounds what a decoder takes besides: at most four
    // channels of four bytes.
    own.max_alloc = Some(limits.max_pixels.saturating_mul(16).saturating_add(1 << 26));
    reader.limits(own);
    reader.into_decoder().map_err(|e| failure(path, format, e))
}

fn failure(path: &Path, format: ImageFormat, error: ImageError) -> OpenError {
    let (path, kind) = (path.to_path_buf(), name(format));
    match error {
        ImageError::IoError(e) => read_failure(&path, kind, &e),
        ImageError::Unsupported(e) => OpenError::Unsupported { path, kind, reason: e.to_string() },
        ImageError::Limits(e) => OpenError::BeyondLimit {
            path,
            found: e.to_string(),
            limit: "the memory of the largest frame allowed".into(),
            remedy: "crop or shrink the frame",
        },
        ImageError::Decoding(_) | ImageError::Encoding(_) | ImageError::Parameter(_) => {
            OpenError::Corrupt { path, kind, reason: error.to_string() }
        }
    }
}

fn name(format: ImageFormat) -> &'static str {
    super::Kind::Picture(format).name()
}
