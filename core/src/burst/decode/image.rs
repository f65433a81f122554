//! PNG, JPEG, PNM, WebP and BMP. Of an animation, the first picture is taken.

use super::turned::{turned, turned_size};
use super::{Expected, FileScale, Header, RawFrame, frame_from_data, read_failure};
use crate::burst::encoding::Encoding;
use crate::burst::error::OpenError;
use crate::burst::limits::Limits;
use crate::burst::luma::{Curve, Sample, grey_from_interleaved};
use crate::burst::options::OpenOptions;
use crate::plane::{Plane, memory};
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageReader};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

pub(super) fn header(path: &Path, file: File, format: ImageFormat, limits: &Limits) -> Result<Header, OpenError> {
    let mut decoder = decoder(path, file, format, limits)?;
    let (width, height) = decoder.dimensions();
    limits.check_frame(path, width.into(), height.into())?;
    let (width, height) = turned_size((width as usize, height as usize), orientation(&mut decoder));
    Ok(Header { width, height, frames: 1 })
}

pub(super) fn frame(
    path: &Path,
    file: File,
    format: ImageFormat,
    expected: Expected<'_>,
    options: &OpenOptions,
) -> Result<RawFrame, OpenError> {
    let limits = &options.limits;
    let mut decoder = decoder(path, file, format, limits)?;
    let (width, height) = decoder.dimensions();
    limits.check_frame(path, width.into(), height.into())?;
    let size = (width as usize, height as usize);
    let orientation = orientation(&mut decoder);
    expected.check(path, turned_size(size, orientation))?;
    let color = decoder.color_type();
    let channels = usize::from(color.channel_count());
    let values = size.0 * size.1 * channels;
    let failure = |e: ImageError| failure(path, format, e);
    let ranged = |values, largest, is_byte: bool| {
        // A byte of a colour picture is encoded for a screen; JPEG and WebP hold nothing else.
        let is_photograph = is_byte && (channels > 2 || matches!(format, ImageFormat::Jpeg | ImageFormat::WebP));
        let encoding = if is_photograph && !options.linearise { Encoding::Srgb } else { Encoding::Linear };
        let plane = turned(Plane::from_vec(size.0, size.1, values), orientation);
        RawFrame { plane, scale: FileScale::Range(largest), encoding, binning: 1 }
    };
    match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            let values = read::<u8>(decoder, values).map_err(failure)?;
            Ok(ranged(grey_from_interleaved(&values, channels, Curve::of(255.0, options.linearise)), 255.0, true))
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let values = read::<u16>(decoder, values).map_err(failure)?;
            Ok(ranged(grey_from_interleaved(&values, channels, Curve::of(65535.0, options.linearise)), 65535.0, false))
        }
        ColorType::Rgb32F | ColorType::Rgba32F => {
            let values = read::<f32>(decoder, values).map_err(failure)?;
            let values = grey_from_interleaved(&values, channels, Curve::Linear(1.0));
            let frame = frame_from_data(path, 0, size, values, false)?;
            Ok(RawFrame { plane: turned(frame.plane, orientation), ..frame })
        }
        other => Err(OpenError::Unsupported {
            path: path.into(),
            kind: name(format),
            reason: format!("its pixels are {other:?}; save it as grey or RGB of 8 or 16 bit"),
        }),
    }
}

/// How the camera was held. A note that cannot be read is none.
fn orientation(decoder: &mut impl ImageDecoder) -> Orientation {
    decoder.orientation().unwrap_or(Orientation::NoTransforms)
}

/// All samples of the picture, in the machine's byte order.
fn read<T: Sample + bytemuck::Pod>(decoder: impl ImageDecoder, count: usize) -> Result<Vec<T>, ImageError> {
    let mut values: Vec<T> = memory::zeroed(count);
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
    super::kind::Kind::Picture(format).name()
}
