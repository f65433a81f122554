//! TIFF and BigTIFF with one page or many: grey or RGB (with or without alpha, interleaved or in planes) of 8, 16, 32
//! or 64-bit integers or floats. Pages that are marked as thumbnails are left out.

use super::tiff_tiles::{FileDecoder, Samples, read_samples};
use super::turned::{turned, turned_size};
use super::{Expected, FileScale, Header, RawFrame, frame_from_data, read_failure};
use crate::burst::encoding::Encoding;
use crate::burst::error::OpenError;
use crate::burst::limits::Limits;
use crate::burst::luma::{Curve, Sample, grey_from_interleaved, grey_from_planes};
use crate::burst::options::OpenOptions;
use crate::burst::progress::{Ticker, in_order};
use crate::plane::Plane;
use image::metadata::Orientation;
use std::fs::File;
use std::io::{BufReader, Seek};
use std::path::{Path, PathBuf};
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

/// Whether the file says that it is a DNG: a TIFF whose values are those of a sensor.
pub(super) fn is_dng(file: &File) -> bool {
    const DNG_VERSION: Tag = Tag::Unknown(50706);
    let again = file.try_clone().and_then(|mut file| file.rewind().map(|()| file));
    again.is_ok_and(|file| {
        Decoder::new(BufReader::new(file)).is_ok_and(|mut decoder| matches!(decoder.find_tag(DNG_VERSION), Ok(Some(_))))
    })
}

/// Whether there is one frame or more: reads no further than the second.
pub(super) fn frame_count(path: &Path, file: File) -> Result<usize, OpenError> {
    let limits = Limits { max_frames: 1, ..Limits::default() };
    match pages(path, file, &limits) {
        Ok((_, pages)) => Ok(pages.len()),
        Err(OpenError::BeyondLimit { .. } | OpenError::DifferentSizes { .. }) => Ok(2),
        Err(error) => Err(error),
    }
}

pub(super) fn header(path: &Path, file: File, limits: &Limits) -> Result<Header, OpenError> {
    let ((width, height), pages) = pages(path, file, limits)?;
    Ok(Header { width, height, frames: pages.len() })
}

pub(super) fn frame(
    path: &Path,
    file: File,
    expected: Expected<'_>,
    options: &OpenOptions,
) -> Result<RawFrame, OpenError> {
    let limits = &options.limits;
    let second = file.try_clone().map_err(|e| OpenError::from_io(path, &e))?;
    let (size, pages) = pages(path, second, limits)?;
    let [page] = pages[..] else {
        return Err(OpenError::StackAmongFrames { path: path.into(), frames: pages.len() });
    };
    expected.check(path, size)?;
    let mut decoder = decoder(path, file, limits)?;
    decoder.seek_to_image(page).map_err(|e| failure(path, e))?;
    decode_page(path, 0, &mut decoder, options)
}

pub(super) fn stack(
    path: &Path,
    file: File,
    options: &OpenOptions,
    ticker: &Ticker<'_>,
) -> Result<Vec<RawFrame>, OpenError> {
    let limits = &options.limits;
    let (_, pages) = pages(path, file, limits)?;
    // A decoder finds a page by following the chain from the first, so each thread takes runs of pages rather than
    // single ones.
    let run = pages.len().div_ceil(4 * rayon::current_num_threads()).max(1);
    let runs: Vec<(usize, &[usize])> =
        pages.chunks(run).enumerate().map(|(i, run_pages)| (i * run, run_pages)).collect();
    let frames = in_order(runs.len(), |i| {
        let (first, pages) = runs[i];
        let file = File::open(path).map_err(|e| OpenError::from_io(path, &e))?;
        let mut decoder = decoder(path, file, limits)?;
        let mut frames = Vec::with_capacity(pages.len());
        for (k, &page) in pages.iter().enumerate() {
            ticker.check()?;
            decoder.seek_to_image(page).map_err(|e| failure(path, e))?;
            frames.push(decode_page(path, first + k, &mut decoder, options)?);
            ticker.tick();
        }
        Ok(frames)
    })?;
    Ok(frames.into_iter().flatten().collect())
}

fn decoder(path: &Path, mut file: File, limits: &Limits) -> Result<FileDecoder, OpenError> {
    file.rewind().map_err(|e| OpenError::from_io(path, &e))?; // handles of one file share their place
    let file_bytes = file.metadata().map_err(|e| OpenError::from_io(path, &e))?.len();
    let mut decoder = Decoder::new(BufReader::new(file)).map_err(|e| failure(path, e))?;
    let bytes = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let mut own = tiff::decoder::Limits::default();
    own.decoding_buffer_size = bytes(limits.max_pixels.saturating_mul(32)); // at most four samples of eight bytes
    own.intermediate_buffer_size = bytes(file_bytes.max(1 << 24));
    own.ifd_value_size = bytes(file_bytes.clamp(1 << 16, 1 << 26));
    decoder = decoder.with_limits(own);
    Ok(decoder)
}

/// The size of all frames, and which pages are frames.
fn pages(path: &Path, file: File, limits: &Limits) -> Result<((usize, usize), Vec<usize>), OpenError> {
    let fail = |e| failure(path, e);
    let mut decoder = decoder(path, file, limits)?;
    let (mut size, mut pages) = (None, Vec::new());
    let announced = announced_images(&mut decoder);
    for page in 0.. {
        if !is_thumbnail(&mut decoder) {
            let (width, height) = decoder.dimensions().map_err(fail)?;
            limits.check_frame(path, width.into(), height.into())?;
            let this = turned_size((width as usize, height as usize), orientation(&mut decoder));
            let first_size = *size.get_or_insert(this);
            if this != first_size {
                let label = |p: usize| PathBuf::from(format!("{} (page {})", path.display(), p + 1));
                return Err(OpenError::DifferentSizes {
                    first: label(pages[0]),
                    first_size,
                    path: label(page),
                    size: this,
                });
            }
            pages.push(page);
            limits.check_burst(path, pages.len() as u64, width.into(), height.into())?;
        }
        if !decoder.more_images() {
            break;
        }
        decoder.next_image().map_err(fail)?;
    }
    let Some(size) = size else {
        return Err(OpenError::Unsupported {
            path: path.into(),
            kind: "TIFF",
            reason: "all its pages are thumbnails; save the full pictures".into(),
        });
    };
    if let Some(announced) = announced.filter(|&n| n > 1 && pages.len() == 1) {
        return Err(OpenError::Unsupported {
            path: path.into(),
            kind: "TIFF",
            reason: format!(
                "it announces {announced} images but lists only the first, as ImageJ does in files beyond 4 GiB; save it as BigTIFF, \
                 as a .npy stack or as an image sequence"
            ),
        });
    }
    Ok((size, pages))
}

/// How the camera was held. A note that is none of the eight is none.
fn orientation(decoder: &mut FileDecoder) -> Orientation {
    let value = decoder.find_tag_unsigned::<u8>(Tag::Orientation).ok().flatten();
    value.and_then(Orientation::from_exif).unwrap_or(Orientation::NoTransforms)
}

fn is_thumbnail(decoder: &mut FileDecoder) -> bool {
    matches!(decoder.find_tag_unsigned::<u32>(Tag::NewSubfileType), Ok(Some(kind)) if kind & 1 == 1)
}

/// The number of images that ImageJ wrote into its description.
fn announced_images(decoder: &mut FileDecoder) -> Option<usize> {
    let text = decoder.get_tag_ascii_string(Tag::ImageDescription).ok()?;
    text.starts_with("ImageJ=").then_some(())?;
    text.lines().find_map(|line| line.strip_prefix("images=")?.trim().parse().ok())
}

/// Decodes the page at which the decoder stands; its size has been checked.
fn decode_page(
    path: &Path,
    frame: usize,
    decoder: &mut FileDecoder,
    options: &OpenOptions,
) -> Result<RawFrame, OpenError> {
    let fail = |e| failure(path, e);
    let unsupported = |reason: String| OpenError::Unsupported { path: path.into(), kind: "TIFF", reason };
    let (width, height) = decoder.dimensions().map_err(fail)?;
    let size = (width as usize, height as usize);
    let color = decoder.colortype().map_err(fail)?;
    let channels = match color {
        ColorType::Gray(_) => 1,
        ColorType::GrayA(_) | ColorType::Multiband { num_samples: 2, .. } => 2,
        ColorType::RGB(_) => 3,
        ColorType::RGBA(_) => 4,
        other => return Err(unsupported(format!("its pixels are {other:?}; save it as grey or RGB"))),
    };
    if ![8, 16, 32, 64].contains(&color.bit_depth()) {
        return Err(unsupported(format!("its samples have {} bits; save it with 8, 16 or 32", color.bit_depth())));
    }
    let orientation = orientation(decoder);
    let Samples { samples, planar } = read_samples(decoder, size, channels).map_err(fail)?;
    macro_rules! grey {
        ($samples:expr, $curve:expr) => {{
            let values = grey($samples, size.0 * size.1, channels, planar, $curve);
            values.ok_or_else(|| OpenError::Corrupt {
                path: path.into(),
                kind: "TIFF",
                reason: "it has fewer samples than its size announces".into(),
            })
        }};
    }
    macro_rules! ranged {
        ($samples:expr, $full_scale:expr, $curve:expr) => {{
            let plane = Plane::from_vec(size.0, size.1, grey!($samples, $curve)?);
            Ok(RawFrame::linear(plane, FileScale::Range($full_scale)))
        }};
    }
    let decoded = match &samples {
        DecodingResult::U8(s) => ranged!(s, 255.0, Curve::of(255.0, options.linearise)),
        DecodingResult::U16(s) => ranged!(s, 65535.0, Curve::of(65535.0, options.linearise)),
        DecodingResult::I8(s) => ranged!(s, 127.0, Curve::Linear(127.0)),
        DecodingResult::I16(s) => ranged!(s, 32767.0, Curve::Linear(32767.0)),
        DecodingResult::U32(s) => frame_from_data(path, frame, size, grey!(s, Curve::Linear(1.0))?, true),
        DecodingResult::U64(s) => frame_from_data(path, frame, size, grey!(s, Curve::Linear(1.0))?, true),
        DecodingResult::I32(s) => frame_from_data(path, frame, size, grey!(s, Curve::Linear(1.0))?, true),
        DecodingResult::I64(s) => frame_from_data(path, frame, size, grey!(s, Curve::Linear(1.0))?, true),
        DecodingResult::F32(s) => frame_from_data(path, frame, size, grey!(s, Curve::Linear(1.0))?, false),
        DecodingResult::F64(s) => frame_from_data(path, frame, size, grey!(s, Curve::Linear(1.0))?, false),
        DecodingResult::F16(s) => {
            let s: Vec<f32> = s.iter().map(|v| v.to_f32()).collect();
            frame_from_data(path, frame, size, grey!(&s[..], Curve::Linear(1.0))?, false)
        }
    }?;
    let is_photograph = channels > 2 && matches!(samples, DecodingResult::U8(_)) && !options.linearise;
    let encoding = if is_photograph { Encoding::Srgb } else { decoded.encoding };
    Ok(RawFrame { plane: turned(decoded.plane, orientation), encoding, ..decoded })
}

/// One value a pixel, or `None` when there are too few samples.
fn grey<T: Sample>(samples: &[T], pixels: usize, channels: usize, planar: bool, curve: Curve) -> Option<Vec<f32>> {
    if !planar {
        return Some(grey_from_interleaved(samples.get(..pixels * channels)?, channels, curve));
    }
    let plane = |i: usize| samples.get(i * pixels..(i + 1) * pixels);
    if channels < 3 {
        return Some(grey_from_interleaved(plane(0)?, 1, curve));
    }
    Some(grey_from_planes(plane(0)?, plane(1)?, plane(2)?, curve))
}

fn failure(path: &Path, error: tiff::TiffError) -> OpenError {
    use tiff::TiffError::{FormatError, IntSizeError, IoError, LimitsExceeded, UnsupportedError, UsageError};
    let (path, kind) = (path.to_path_buf(), "TIFF");
    match error {
        IoError(e) => read_failure(&path, kind, &e),
        UnsupportedError(e) => OpenError::Unsupported {
            path,
            kind,
            reason: format!("{e}; save it as grey or RGB without exotic compression"),
        },
        LimitsExceeded => OpenError::BeyondLimit {
            path,
            found: "a table or strip in it announces too many bytes".into(),
            limit: "what the file itself could hold".into(),
            remedy: "copy it again, or save it anew",
        },
        FormatError(_) | IntSizeError | UsageError(_) => OpenError::Corrupt { path, kind, reason: error.to_string() },
    }
}
