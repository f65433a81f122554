//! PNG, JPEG, PNM, WebP and BMP. Of an animation, the first picture is taken.

use super::child::{self, Budget};
use super::look::too_few_bytes;
use super::pixels::{turned, turned_size};
use super::wire::Part;
use super::{FileScale, Header, InputFile, RawFrame, Reading, frame_of_plane, jpeg};
use crate::burst::decode::pixels::{Curve, Sample, grey_from_interleaved};
use crate::burst::options::{Encoding, Limits};
use crate::error::{Error, Result};
use crate::files::read_bytes;
use crate::plane::{Plane, memory};
use image::error::{DecodingError, ImageFormatHint, LimitError, LimitErrorKind};
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageReader, ImageResult};
use png::{BitDepth, DecodeOptions, Decoder, Reader, Transformations};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

/// Memory that a decoder may take beyond the pixels, bytes.
const BESIDES_BYTES: u64 = 1 << 26;
/// Largest number of pixels of a byte of a file: of one bit each, in deflated data of the largest ratio, about.
const PIXELS_A_BYTE: u64 = 8 * 1040;

pub(super) fn header(path: &Path, file: File, format: ImageFormat, limits: &Limits) -> Result<Header> {
    let bytes = jpeg_bytes(path, format, limits)?;
    header_of(path, BufReader::with_capacity(1 << 16, file), &bytes, format, limits)
}

/// Header of the picture that `reader` gives; `bytes` are all of it, of a JPEG.
pub(super) fn header_of(
    path: &Path,
    reader: impl BufRead + Seek,
    bytes: &[u8],
    format: ImageFormat,
    limits: &Limits,
) -> Result<Header> {
    let mut decoder = decoder(path, reader, bytes, format, limits)?;
    let (width, height) = decoder.dimensions();
    limits.check_frame(path, width.into(), height.into())?;
    let color = decoder.color_type();
    let (width, height) = turned_size((width as usize, height as usize), orientation(&mut decoder));
    let (samples, is_colour) = samples_of(color);
    Ok(Header::new(name(format), (width, height), 1, samples, is_colour))
}

pub(super) fn frame(reading: Reading<'_>, input: InputFile, format: ImageFormat) -> Result<RawFrame> {
    let bytes = &jpeg_bytes(reading.path, format, &reading.options.limits)?;
    if format == ImageFormat::Pnm {
        check_end_of_text(reading.path, &input.file)?;
    }
    let reader = BufReader::with_capacity(1 << 16, input.file);
    decoded(reading, Source { reader, bytes, length: input.length, format, part: Part::Only })
}

/// A picture, and where it lies in its file.
pub(super) struct Source<'a, R> {
    pub reader: R,
    /// All bytes of a JPEG.
    pub bytes: &'a [u8],
    /// Number of its bytes.
    pub length: u64,
    pub format: ImageFormat,
    pub part: Part,
}

pub(super) fn decoded(reading: Reading<'_>, source: Source<'_, impl BufRead + Seek>) -> Result<RawFrame> {
    let Reading { path, options, .. } = reading;
    let Source { reader, bytes, length, format, part } = source;
    let limits = &options.limits;
    let mut decoder = decoder(path, reader, bytes, format, limits)?;
    let (width, height) = decoder.dimensions();
    limits.check_frame(path, width.into(), height.into())?;
    // Of WebP a few bytes can be a large picture of one colour.
    let is_too_short = too_few_bytes(length, width.into(), height.into(), PIXELS_A_BYTE);
    if let Some(reason) = is_too_short.filter(|_| format != ImageFormat::WebP) {
        return Err(Error::corrupt(path, name(format), reason));
    }
    let size = (width as usize, height as usize);
    let orientation = orientation(&mut decoder);
    reading.check(turned_size(size, orientation))?;
    let color = decoder.color_type();
    let pixels = u64::from(width) * u64::from(height);
    let taken = pixels * bytes_per_pixel(format, color);
    if child::takes(taken) {
        drop(decoder);
        let budget = Budget::new(length, pixels, 2 * taken);
        return child::decode(reading, name(format), part, budget);
    }
    memory::check_room(taken);
    let (whole, damage) = match (format == ImageFormat::Jpeg).then(|| jpeg::samples(bytes, true)) {
        None => (None, None),
        Some(Ok(samples)) => (Some(samples), None),
        Some(Err(reason)) if options.accept_damaged => (None, Some(reason)),
        Some(Err(reason)) => return Err(Error::corrupt(path, name(format), reason)),
    };
    let channels = usize::from(color.channel_count());
    let values = size.0 * size.1 * channels;
    let failure = |e: ImageError| failure(path, format, e);
    let ranged = |values, largest, is_byte: bool| {
        // 8-bit colour pictures are sRGB-encoded; JPEG and WebP hold nothing else.
        let is_photograph = is_byte && (channels > 2 || matches!(format, ImageFormat::Jpeg | ImageFormat::WebP));
        let encoding = if is_photograph && !options.linearise { Encoding::Srgb } else { Encoding::Linear };
        let plane = turned(Plane::from_vec(size.0, size.1, values), orientation);
        let is_colour = channels > 2;
        RawFrame { encoding, damage, is_colour, ..RawFrame::linear(plane, FileScale::Range(largest)) }
    };
    match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            let values = whole.map_or_else(|| read::<u8>(decoder, values), Ok).map_err(failure)?;
            Ok(ranged(grey_from_interleaved(&values, channels, Curve::of(255.0, options.linearise)), 255.0, true))
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let values = read::<u16>(decoder, values).map_err(failure)?;
            Ok(ranged(grey_from_interleaved(&values, channels, Curve::of(65535.0, options.linearise)), 65535.0, false))
        }
        ColorType::Rgb32F | ColorType::Rgba32F => {
            let values = read::<f32>(decoder, values).map_err(failure)?;
            let values = grey_from_interleaved(&values, channels, Curve::Linear(1.0));
            let frame = frame_of_plane(path, 0, Plane::from_vec(size.0, size.1, values), false)?;
            Ok(RawFrame { plane: turned(frame.plane, orientation), is_colour: true, ..frame })
        }
        other => {
            let reason = format!("its pixels are {other:?}; save it as grey or RGB of 8 or 16 bit");
            Err(Error::unsupported(path, name(format), reason))
        }
    }
}

/// Name of the samples of a colour type, and whether there are colours.
fn samples_of(color: ColorType) -> (String, bool) {
    let bits = color.bits_per_pixel() / u16::from(color.channel_count());
    (if bits == 32 { "floats of 32 bit".to_owned() } else { format!("{bits} bit") }, color.has_color())
}

/// Checks that a PNM of numbers in decimal digits does not end with a digit: its last number may have lost others.
fn check_end_of_text(path: &Path, mut file: &File) -> Result<()> {
    let mut ends = || -> io::Result<([u8; 2], u8)> {
        let (mut first, mut last) = ([0; 2], [0]);
        file.rewind()?;
        file.read_exact(&mut first)?;
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
        file.rewind()?;
        Ok((first, last[0]))
    };
    let (first, last) = ends().map_err(|e| Error::from_read(path, "PNM", &e))?;
    if matches!(&first, b"P2" | b"P3") && last.is_ascii_digit() {
        let reason = "no space or line end follows its last number, which may be cut";
        return Err(Error::corrupt(path, "PNM", reason));
    }
    Ok(())
}

/// How the camera was held; no turn where the tag cannot be read.
fn orientation(decoder: &mut impl ImageDecoder) -> Orientation {
    decoder.orientation().unwrap_or(Orientation::NoTransforms)
}

fn read<T: Sample + bytemuck::Pod>(decoder: impl ImageDecoder, count: usize) -> Result<Vec<T>, ImageError> {
    let mut values: Vec<T> = memory::zeroed(count);
    decoder.read_image(bytemuck::cast_slice_mut(&mut values))?;
    Ok(values)
}

/// Bytes per pixel that decoding takes, at most: the samples, the value that they become, and the decoder's own data.
fn bytes_per_pixel(format: ImageFormat, color: ColorType) -> u64 {
    let kept = match format {
        // 16-bit coefficients of a progressive picture.
        ImageFormat::Jpeg => 2 * u64::from(color.channel_count()),
        ImageFormat::WebP => 4,
        _ => 0,
    };
    u64::from(color.bytes_per_pixel()) + size_of::<f32>() as u64 + kept
}

/// The whole file of a JPEG, which is decoded strictly, and otherwise where that is asked for; empty for other formats.
fn jpeg_bytes(path: &Path, format: ImageFormat, limits: &Limits) -> Result<Vec<u8>> {
    if format != ImageFormat::Jpeg {
        return Ok(Vec::new());
    }
    // Other data, as films and second pictures, may follow a picture.
    let most = limits.max_pixels.saturating_mul(4).saturating_add(BESIDES_BYTES);
    read_bytes(path, most).map_err(|e| Error::from_io(path, &e))
}

fn decoder<'a>(
    path: &Path,
    reader: impl BufRead + Seek + 'a,
    bytes: &'a [u8],
    format: ImageFormat,
    limits: &Limits,
) -> Result<Box<dyn ImageDecoder + 'a>> {
    // `Limits` checks sizes before pixels are read; this bounds the decoder's other memory: at most four channels of
    // four bytes.
    let max_bytes = limits.max_pixels.saturating_mul(16).saturating_add(BESIDES_BYTES);
    let mut own = image::Limits::no_limits();
    own.max_alloc = Some(max_bytes);
    let fail = |e| failure(path, format, e);
    match format {
        ImageFormat::Png => Ok(Box::new(PngPicture::new(reader, max_bytes).map_err(fail)?)),
        ImageFormat::Jpeg => {
            let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
            reader.limits(own);
            Ok(Box::new(reader.into_decoder().map_err(fail)?))
        }
        _ => {
            let mut reader = ImageReader::with_format(reader, format);
            reader.limits(own);
            Ok(Box::new(reader.into_decoder().map_err(fail)?))
        }
    }
}

fn failure(path: &Path, format: ImageFormat, error: ImageError) -> Error {
    match error {
        ImageError::IoError(e) => Error::from_read(path, name(format), &e),
        ImageError::Unsupported(e) => Error::unsupported(path, name(format), e),
        ImageError::Limits(e) => {
            let limit = "the memory of the largest frame allowed";
            Error::too_large(path, e.to_string(), limit, "crop or shrink the frame")
        }
        ImageError::Decoding(_) | ImageError::Encoding(_) | ImageError::Parameter(_) => {
            Error::corrupt(path, name(format), error)
        }
    }
}

fn name(format: ImageFormat) -> &'static str {
    super::look::Kind::Picture(format).name()
}

/// A PNG whose header is read. Colour profiles and texts are skipped: a few bytes of them can unpack to gigabytes.
pub(super) struct PngPicture<R: BufRead + Seek> {
    reader: Reader<R>,
    color: ColorType,
}

impl<R: BufRead + Seek> PngPicture<R> {
    /// Reads the file up to the pixels. The decoder may take `max_bytes` besides them.
    pub(super) fn new(file: R, max_bytes: u64) -> ImageResult<Self> {
        let mut options = DecodeOptions::default();
        options.set_ignore_iccp_chunk(true);
        options.set_ignore_text_chunk(true);
        let mut decoder = Decoder::new_with_options(file, options);
        decoder.set_limits(png::Limits { bytes: usize::try_from(max_bytes).unwrap_or(usize::MAX) });
        // Palettes become colours, and fewer than eight bits become eight.
        decoder.set_transformations(Transformations::EXPAND);
        let reader = decoder.read_info().map_err(png_failure)?;
        use png::ColorType::{Grayscale, GrayscaleAlpha, Rgb, Rgba};
        let color = match reader.output_color_type() {
            (Grayscale, BitDepth::Eight) => ColorType::L8,
            (Grayscale, BitDepth::Sixteen) => ColorType::L16,
            (GrayscaleAlpha, BitDepth::Eight) => ColorType::La8,
            (GrayscaleAlpha, BitDepth::Sixteen) => ColorType::La16,
            (Rgb, BitDepth::Eight) => ColorType::Rgb8,
            (Rgb, BitDepth::Sixteen) => ColorType::Rgb16,
            (Rgba, BitDepth::Eight) => ColorType::Rgba8,
            (Rgba, BitDepth::Sixteen) => ColorType::Rgba16,
            (color, depth) => return Err(decoding(format!("pixels of {color:?} and {depth:?} were not expanded"))),
        };
        Ok(Self { reader, color })
    }
}

impl<R: BufRead + Seek> ImageDecoder for PngPicture<R> {
    fn dimensions(&self) -> (u32, u32) {
        self.reader.info().size()
    }

    fn color_type(&self) -> ColorType {
        self.color
    }

    fn exif_metadata(&mut self) -> ImageResult<Option<Vec<u8>>> {
        Ok(self.reader.info().exif_metadata.as_ref().map(|exif| exif.to_vec()))
    }

    fn read_image(mut self, buffer: &mut [u8]) -> ImageResult<()> {
        self.reader.next_frame(buffer).map_err(png_failure)?;
        // The file's end must follow the pixels.
        self.reader.finish().map_err(png_failure)?;
        if self.color.bytes_per_pixel() == 2 * self.color.channel_count() {
            for bytes in buffer.as_chunks_mut::<2>().0 {
                *bytes = u16::from_be_bytes(*bytes).to_ne_bytes();
            }
        }
        Ok(())
    }

    fn read_image_boxed(self: Box<Self>, buffer: &mut [u8]) -> ImageResult<()> {
        (*self).read_image(buffer)
    }
}

fn png_failure(error: png::DecodingError) -> ImageError {
    match error {
        png::DecodingError::IoError(error) => ImageError::IoError(error),
        png::DecodingError::LimitsExceeded => {
            ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory))
        }
        error @ (png::DecodingError::Format(_) | png::DecodingError::Parameter(_)) => decoding(error),
    }
}

fn decoding(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> ImageError {
    ImageError::Decoding(DecodingError::new(ImageFormatHint::Exact(ImageFormat::Png), error))
}
