//! PNG, JPEG, PNM, WebP and BMP. Of an animation, the first picture is taken.

pub(super) mod jpeg;
#[cfg(test)]
mod midway;

use super::{Format, Input, Rank, Record, Start, alone};
use crate::burst::options::{Encoding, Limits, OpenOptions};
use crate::burst::reading::confined::{self, Budget, wire::Part};
use crate::burst::reading::pixels::{Curve, Sample, grey_from_interleaved, turned, turned_size};
use crate::burst::reading::{
    Asked, Declared, FileScale, RawFrame, Reading, corrupt, exif, frame_of_plane, read_at, too_few_bytes,
};
use crate::error::{Error, Result};
use crate::plane::{Plane, memory};
use crate::{burst::times::Times, files::read_bytes};
use image::codecs::{png::PngDecoder, webp::WebPDecoder};
use image::error::{DecodingError, ImageFormatHint, LimitError, LimitErrorKind};
use image::metadata::Orientation;
use image::{AnimationDecoder, ColorType, Frames, ImageDecoder, ImageError, ImageFormat, ImageReader, ImageResult};
use png::{BitDepth, DecodeOptions, Decoder, Reader, Transformations};
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::{borrow::Cow, fs::File, path::Path};

/// Memory that a decoder may take beyond the pixels, bytes.
const BESIDES_BYTES: u64 = 1 << 26;
/// Largest number of pixels of a byte of a file: of one bit each, in deflated data of the largest ratio, about.
const PIXELS_A_BYTE: u64 = 8 * 1040;

pub(super) struct PictureFormat {
    format: ImageFormat,
    extensions: &'static [&'static str],
    opens: &'static str,
}

impl PictureFormat {
    fn delays_s(&self, input: &Input, path: &Path) -> Result<Vec<f64>> {
        let mut reader = BufReader::with_capacity(64, &input.file);
        let found = delays_of(&mut reader, self.format, input.length);
        let found = found.and_then(|delays| (&input.file).rewind().map(|()| delays));
        found.map_err(|e| Error::from_read(path, name(self.format), &e))
    }

    const fn new(format: ImageFormat, extensions: &'static [&'static str], opens: &'static str) -> Self {
        Self { format, extensions, opens }
    }
}

const ONE: &str = "each file is a frame of 8 or 16 bits; luma of colours; photographs as their EXIF orientation says";
/// What is opened of formats with animations.
const SEVERAL: &str = "each file is a frame; the frames of an animation as they are shown, with their times";
pub(super) static PNG: PictureFormat = PictureFormat::new(ImageFormat::Png, &["png"], SEVERAL);
pub(super) static JPEG: PictureFormat = PictureFormat::new(ImageFormat::Jpeg, &["jpg", "jpeg", "mpo"], ONE);
pub(super) static PNM: PictureFormat = PictureFormat::new(ImageFormat::Pnm, &["pgm", "ppm", "pnm", "pbm", "pam"], ONE);
pub(super) static WEBP: PictureFormat = PictureFormat::new(ImageFormat::WebP, &["webp"], SEVERAL);
pub(super) static BMP: PictureFormat = PictureFormat::new(ImageFormat::Bmp, &["bmp"], ONE);

impl Format for PictureFormat {
    fn record(&self) -> Record {
        let Self { format, extensions, opens } = *self;
        let options = "`--mosaic rggb` for a Bayer mosaic without a header of its own (all formats)";
        Record { name: name(format), rank: Rank::Picture, extensions, opens, options }
    }

    fn begins(&self, start: &Start<'_>) -> bool {
        image::guess_format(start.bytes).is_ok_and(|format| format == self.format)
    }

    fn check(&self, input: &Input, path: &Path, _pages: usize) -> Result<()> {
        if self.format != ImageFormat::WebP {
            return Ok(());
        }
        let mut reader = BufReader::with_capacity(512, &input.file);
        let checked = check_webp(&mut reader, input.length).and_then(|()| (&input.file).rewind());
        checked.map_err(|e| Error::from_read(path, name(self.format), &e))
    }

    fn count(&self, input: Input, reading: Reading<'_>) -> Result<usize> {
        Ok(self.delays_s(&input, reading.path)?.len().max(1))
    }

    fn declared(&self, input: Input, reading: Reading<'_>) -> Result<Declared> {
        let Reading { path, options, .. } = reading;
        let delays = self.delays_s(&input, path)?;
        let declared = declared(path, input.file, self.format, &options.limits)?;
        if delays.is_empty() {
            return Ok(declared);
        }
        let (width, height) = (declared.width, declared.height);
        let mut times = times_of(&delays);
        let frames = options.taken_of(path, delays.len(), (width, height))?;
        options.limits.check_burst(path, frames.len() as u64, width as u64, height as u64)?;
        if !times.seconds.is_empty() {
            times.seconds = times.seconds[frames.clone()].to_vec();
        }
        let taken = vec!["the frames of the animation are taken as they are shown".to_owned()];
        Ok(Declared { frames: frames.len(), times, taken, ..declared })
    }

    fn times(&self, input: Input, reading: Reading<'_>) -> Result<Times> {
        let times = times_of(&self.delays_s(&input, reading.path)?);
        Ok(if times.seconds.is_empty() { exif::times(reading.path) } else { times })
    }

    fn frames(&self, input: Input, reading: Reading<'_>) -> Result<Vec<RawFrame>> {
        let Reading { path, options, .. } = reading;
        if self.delays_s(&input, path)?.is_empty() {
            return alone(reading, self.only(input, reading)?);
        }
        let file = input.file.try_clone().map_err(|e| Error::from_io(path, &e))?;
        let is_colour = declared(path, file, self.format, &options.limits)?.is_colour;
        (&input.file).rewind().map_err(|e| Error::from_io(path, &e))?;
        frames_of(reading, BufReader::with_capacity(1 << 16, input.file), (self.format, is_colour))
    }

    fn only(&self, input: Input, reading: Reading<'_>) -> Result<RawFrame> {
        match self.delays_s(&input, reading.path)?.len() {
            0 | 1 => {}
            frames => return Err(Error::stack_among_frames(reading.path, frames)),
        }
        only(reading, input, self.format)
    }
}

fn declared(path: &Path, file: File, format: ImageFormat, limits: &Limits) -> Result<Declared> {
    let bytes = jpeg_bytes(path, format, limits)?;
    declared_of(path, BufReader::with_capacity(1 << 16, file), &bytes, format, limits)
}

pub(super) fn declared_of(
    path: &Path,
    reader: impl BufRead + Seek,
    bytes: &[u8],
    format: ImageFormat,
    limits: &Limits,
) -> Result<Declared> {
    let bytes = &*normalised(path, bytes, format)?;
    let mut reader = reader;
    let full = full_scale(path, &mut reader, format)?;
    // Binary PNM files may hold several pictures one after another.
    let is_binary = reader.fill_buf().is_ok_and(|start| start.starts_with(b"P5") || start.starts_with(b"P6"));
    let length = reader.seek(SeekFrom::End(0)).and_then(|length| reader.rewind().map(|()| length)).unwrap_or(0);
    let mut decoder = decoder(path, reader, bytes, format, limits)?;
    let (width, height) = decoder.dimensions();
    limits.check_frame(path, width.into(), height.into())?;
    let color = decoder.color_type();
    let pictures = if is_binary { length / decoder.total_bytes().max(1) } else { 1 };
    let (width, height) = turned_size((width as usize, height as usize), orientation(&mut decoder));
    let (samples, is_colour) = samples_of(color);
    let samples = full.map_or(samples, |full| FileScale::Range(full).samples());
    let mut declared = Declared::new(name(format), (width, height), 1, samples, is_colour);
    if format == ImageFormat::Jpeg && jpeg::pictures(bytes) > 1 {
        declared.taken.push(format!("of {} pictures in the file (MPF) the first is taken", jpeg::pictures(bytes)));
    }
    if pictures > 1 {
        declared.taken.push(format!("the file is as long as {pictures} pictures, of which the first is taken"));
    }
    Ok(declared)
}

fn only(reading: Reading<'_>, input: Input, format: ImageFormat) -> Result<RawFrame> {
    let bytes = &jpeg_bytes(reading.path, format, &reading.options.limits)?;
    if format == ImageFormat::Pnm {
        check_end_of_text(reading.path, &input.file)?;
    }
    let reader = BufReader::with_capacity(1 << 16, input.file);
    decoded(reading, Source { reader, bytes, length: input.length, format, part: Part::Only })
}

pub(super) struct Source<'a, R> {
    pub reader: R,
    /// All bytes of a JPEG.
    pub bytes: &'a [u8],
    pub length: u64,
    pub format: ImageFormat,
    pub part: Part,
}

pub(super) fn decoded(reading: Reading<'_>, source: Source<'_, impl BufRead + Seek>) -> Result<RawFrame> {
    let frame = frame_of(reading, source);
    // A cancelled decoder fails with an error of its own: the cancellation is reported instead.
    reading.ticker.check().and(frame)
}

fn frame_of(reading: Reading<'_>, source: Source<'_, impl BufRead + Seek>) -> Result<RawFrame> {
    let Reading { path, options, ticker, .. } = reading;
    let Source { reader, bytes, length, format, part } = source;
    let limits = &options.limits;
    let bytes = &*normalised(path, bytes, format)?;
    let mut reader = Asked::new(reader, ticker.monitor());
    let full = full_scale(path, &mut reader, format)?;
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
    if confined::takes(taken) {
        // Its memory is given back before another process takes as much.
        drop(decoder);
        return confined::decode(reading, name(format), part, Budget::new(length, pixels, 2 * taken));
    }
    memory::check_room(taken);
    // The strict decoder first: the lenient one below serves damage that is accepted.
    let (whole, damage) = match (format == ImageFormat::Jpeg).then(|| jpeg::samples(bytes, true, ticker.monitor())) {
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
            let mut values = whole.map_or_else(|| read::<u8>(decoder, values), Ok).map_err(failure)?;
            if let Some(full) = full {
                // The decoder has stretched whole numbers to its own type.
                values.iter_mut().for_each(|value| *value = (f32::from(*value) * full / 255.0).round() as u8);
            }
            let full = full.unwrap_or(255.0);
            Ok(ranged(grey_from_interleaved(&values, channels, Curve::of(full, options.linearise)), full, true))
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let mut values = read::<u16>(decoder, values).map_err(failure)?;
            if let Some(full) = full {
                values.iter_mut().for_each(|value| *value = (f32::from(*value) * full / 65535.0).round() as u16);
            }
            let full = full.unwrap_or(65535.0);
            Ok(ranged(grey_from_interleaved(&values, channels, Curve::of(full, options.linearise)), full, false))
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

/// A JPEG as decoders take it, and other formats as they are.
fn normalised<'a>(path: &Path, bytes: &'a [u8], format: ImageFormat) -> Result<Cow<'a, [u8]>> {
    match format {
        ImageFormat::Jpeg => jpeg::normalised(bytes).map_err(|reason| Error::unsupported(path, name(format), reason)),
        _ => Ok(Cow::Borrowed(bytes)),
    }
}

/// Largest value of a PNM whose numbers do not fill their type; `None` for others.
fn full_scale(path: &Path, reader: &mut (impl BufRead + Seek), format: ImageFormat) -> Result<Option<f32>> {
    if format != ImageFormat::Pnm {
        return Ok(None);
    }
    const HEAD_BYTES: u64 = 1 << 16;
    let mut head = Vec::new();
    let read = reader.take(HEAD_BYTES).read_to_end(&mut head).and_then(|_| reader.rewind());
    read.map_err(|e| Error::from_read(path, name(format), &e))?;
    let text = String::from_utf8_lossy(&head);
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    let mut words = lines.flat_map(str::split_ascii_whitespace);
    let largest = match words.next() {
        Some("P2" | "P3" | "P5" | "P6") => words.nth(2),
        Some("P7") => words.skip_while(|word| *word != "MAXVAL").nth(1),
        _ => None,
    };
    let largest = largest.and_then(|word| word.parse::<u32>().ok());
    Ok(largest.filter(|largest| !matches!(largest, 0 | 255 | 65535..)).map(|largest| largest as f32))
}

const MAX_PARTS: usize = 1 << 16;

/// Seconds for which each frame of an animation is shown; none for a single picture.
fn delays_of(file: &mut (impl Read + Seek), format: ImageFormat, length: u64) -> io::Result<Vec<f64>> {
    let (is_png, mut delays, mut start) = (format == ImageFormat::Png, Vec::new(), [0; 8]);
    if !is_png && format != ImageFormat::WebP {
        return Ok(delays);
    }
    let (mut at, mut is_announced) = (if is_png { 8 } else { 12 }, false);
    for _ in 0..MAX_PARTS {
        if at + 8 > length {
            break;
        }
        read_at(file, at, &mut start)?;
        let [first, second] = [[0, 1, 2, 3], [4, 5, 6, 7]].map(|of| of.map(|byte| start[byte]));
        let (size, kind) =
            if is_png { (u32::from_be_bytes(first), second) } else { (u32::from_le_bytes(second), first) };
        is_announced |= [b"acTL", b"ANIM"].contains(&&kind);
        // Of a single picture only what precedes the pixels is read.
        if !is_announced && [b"IDAT", b"VP8 ", b"VP8L", b"IEND"].contains(&&kind) {
            break;
        }
        let end = at + 8 + u64::from(size) + if is_png { 4 } else { u64::from(size % 2) };
        let mut data = [0; 26];
        let most = data.len().min(size as usize);
        if [b"fcTL", b"ANMF"].contains(&&kind) && end <= length && most > 14 {
            read_at(file, at + 8, &mut data[..most])?;
            let number = |at: usize| f64::from(u16::from_be_bytes([data[at], data[at + 1]]));
            delays.push(match is_png {
                // A denominator of 0 stands for hundredths.
                true if number(22) > 0.0 => number(20) / number(22),
                true => number(20) / 100.0,
                false => f64::from(u32::from_le_bytes([data[12], data[13], data[14], 0])) * 1e-3,
            });
        }
        at = end;
    }
    Ok(if delays.len() > 1 { delays } else { Vec::new() })
}

/// Times from the first frame on; none where a frame is shown for no time.
fn times_of(delays_s: &[f64]) -> Times {
    if delays_s.iter().any(|delay| *delay <= 0.0) {
        return Times::default();
    }
    let from = |sum: &mut f64, delay: &f64| Some(std::mem::replace(sum, *sum + delay));
    Times { seconds: delays_s.iter().scan(0.0, from).collect(), is_absolute: false }
}

fn frames_of(
    reading: Reading<'_>,
    reader: impl BufRead + Seek,
    (format, is_colour): (ImageFormat, bool),
) -> Result<Vec<RawFrame>> {
    let Reading { path, options, ticker, .. } = reading;
    let (fail, reader) = (|e| failure(path, format, e), Asked::new(reader, ticker.monitor()));
    let shown: Frames<'_> = match format {
        ImageFormat::Png => PngDecoder::new(reader).and_then(PngDecoder::apng).map_err(fail)?.into_frames(),
        _ => WebPDecoder::new(reader).map_err(fail)?.into_frames(),
    };
    let OpenOptions { take, linearise, limits, .. } = options;
    let end = take.map_or(usize::MAX, |range| range.end);
    let mut frames = Vec::new();
    for frame in shown.take(end) {
        ticker.check()?; // after the frame was decoded, or was not
        let picture = frame.map_err(fail)?.into_buffer();
        let (width, height) = picture.dimensions();
        limits.check_burst(path, frames.len() as u64 + 1, width.into(), height.into())?;
        memory::check_room(4 * u64::from(width) * u64::from(height));
        let values = grey_from_interleaved(picture.as_raw(), 4, Curve::of(255.0, *linearise));
        let plane = Plane::from_vec(width as usize, height as usize, values);
        let encoding = if is_colour && !linearise { Encoding::Srgb } else { Encoding::Linear };
        frames.push(RawFrame { encoding, is_colour, ..RawFrame::linear(plane, FileScale::Range(255.0)) });
        ticker.tick();
    }
    if frames.is_empty() {
        return Err(Error::corrupt(path, name(format), "no frame of its animation is whole"));
    }
    // Frames are drawn one over another, so those before the part had to be decoded too.
    options.taken(path, frames, (1, 1))
}

/// How the camera was held; no turn where the tag cannot be read.
fn orientation(decoder: &mut impl ImageDecoder) -> Orientation {
    // Some programs write the data with the words that begin it in a JPEG.
    let found = decoder.exif_metadata().ok().flatten();
    let found = found.and_then(|exif| Orientation::from_exif_chunk(exif.strip_prefix(b"Exif\0\0").unwrap_or(&exif)));
    found.or_else(|| decoder.orientation().ok()).unwrap_or(Orientation::NoTransforms)
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
    // `Limits` checks sizes; this bounds the decoder's other memory: at most four channels of four bytes.
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
    match format {
        ImageFormat::Png => "PNG",
        ImageFormat::Jpeg => "JPEG",
        ImageFormat::Pnm => "PNM",
        ImageFormat::WebP => "WebP",
        _ => "BMP",
    }
}

/// Checks that each chunk of a WebP of `length` bytes lies within it: the decoder would take memory for notes.
fn check_webp(file: &mut (impl Read + Seek), length: u64) -> io::Result<()> {
    const CHUNKS: usize = 1 << 16;
    let mut head = [0; 8];
    let size_in = |head: [u8; 8]| u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
    read_at(file, 0, &mut head)?;
    // Bytes after the announced end are ignored.
    let end = length.min(8 + size_in(head));
    let mut at = 12;
    for _ in 0..CHUNKS {
        if at + 8 > end {
            return Ok(());
        }
        read_at(file, at, &mut head)?;
        let size = size_in(head);
        at += 8 + size;
        if at > length {
            let name = String::from_utf8_lossy(&head[..4]);
            return Err(corrupt(format!("its chunk {name} announces {size} bytes, more than are left")));
        }
        at += size % 2;
    }
    Err(corrupt(format!("it has more than {CHUNKS} chunks")))
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
        // PNG stores the high byte first; the buffer holds native numbers.
        if self.color.bytes_per_pixel() == 2 * self.color.channel_count() {
            let pairs = buffer.as_chunks_mut::<2>().0.iter_mut();
            pairs.for_each(|bytes| *bytes = u16::from_be_bytes(*bytes).to_ne_bytes());
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
