//! Pixels of a TIFF. A page is decoded: its strips or tiles in this process, or in another where they take much memory.
//!
//! A page in planes and tiles is assembled here: tiff 0.11.3 panics if its size is no multiple of the tile's.
//!
//! Frames of one directory (MetaMorph's STK, ImageJ beyond 4 GiB, tifffile, volumes) are numbers at even distances.

use super::described::{Described, PageShape, described, product};
use super::{FileDecoder, NAME, decoder, failure, no_data, orientation};
use crate::burst::options::{Encoding, Limits, OpenOptions};
use crate::burst::reading::confined::{self, Budget, wire::Part};
use crate::burst::reading::pixels::{Curve, Sample, grey_from_interleaved, grey_from_planes, turned, turned_mosaic};
use crate::burst::reading::{FileScale, RawFrame, Reading, corrupt, frame_of_plane, plain::Plain};
use crate::burst::{formats::picture::jpeg, number::Number};
use crate::error::{Error, Result};
use crate::files;
use crate::plane::{Plane, memory};
use flate2::{Decompress, FlushDecompress, Status};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use tiff::decoder::{ChunkType, DecodingResult};
use tiff::{ColorType, TiffResult, tags::Tag};

/// Bytes that deflated strips and tiles may have besides their pixels.
const FILLING_BYTES: u64 = 1 << 20;

/// Number of bytes, at most `most`, of zlib's data, whose checksum is compared. The error is the end of a sentence.
fn unpacked_bytes(packed: &[u8], most: u64) -> Result<u64, String> {
    let (mut state, mut block) = (Decompress::new(true), [0; 1 << 14]);
    loop {
        let before = (state.total_in(), state.total_out());
        let status = state.decompress(&packed[before.0 as usize..], &mut block, FlushDecompress::None);
        match status.map_err(|e| format!("its deflated data: {e}"))? {
            _ if state.total_out() > most => return Err("its deflated data is far more than its pixels".to_owned()),
            Status::StreamEnd => return Ok(state.total_out()),
            _ if (state.total_in(), state.total_out()) == before => {
                return Err("its deflated data ends before its checksum".to_owned());
            }
            _ => {}
        }
    }
}

pub(super) struct PageReader<'a> {
    reading: Reading<'a>,
    decoder: FileDecoder,
    length: u64,
}

impl<'a> PageReader<'a> {
    pub(super) fn open(reading: Reading<'a>, path: &Path, length: u64) -> Result<Self> {
        let file = files::open(path).map_err(|e| Error::from_io(reading.path, &e))?;
        let decoder = decoder(reading.path, file, &reading.options.limits, reading.ticker.monitor())?;
        Ok(Self { reading, decoder, length })
    }

    pub(super) fn read(&mut self, page: usize, frame: usize) -> Result<RawFrame> {
        let read = self.decoded(page, frame);
        // A cancelled decoder fails with an error of its own: the cancellation is reported instead.
        self.reading.ticker.check().and(read)
    }

    fn decoded(&mut self, page: usize, frame: usize) -> Result<RawFrame> {
        let Reading { path, options, .. } = self.reading;
        let fail = |e| failure(path, e);
        self.decoder.seek_to_image(page).map_err(fail)?;
        let (width, height) = self.decoder.dimensions().map_err(fail)?;
        let pixels = u64::from(width) * u64::from(height);
        let (chunk_width, chunk_height) = self.decoder.chunk_dimensions();
        let chunk = u64::from(chunk_width).saturating_mul(chunk_height.into());
        // Samples, planes of samples, and the values computed from them.
        let color = self.decoder.colortype().map_err(fail)?;
        let sample_bytes = u64::from(color.num_samples()) * u64::from(color.bit_depth()).div_ceil(8);
        let taken = pixels.saturating_mul(2 * sample_bytes + 4).saturating_add(chunk.saturating_mul(2 * sample_bytes));
        // A large page is decoded in a process of its own, whose memory has a limit.
        if confined::takes(taken) {
            let budget = Budget::new(self.length, pixels, taken.saturating_mul(2));
            let part = Part::Page { page, frame };
            return confined::decode(Reading { expected: None, ..self.reading }, NAME, part, budget);
        }
        memory::check_room(taken);
        // Strips and tiles at the edges may be filled up.
        let most = pixels.saturating_add(chunk).saturating_mul(2 * sample_bytes).saturating_add(FILLING_BYTES);
        // Searched before decoding, since the decoder does not report it.
        let damage = self.damage(most).map_err(fail)?;
        if let Some(reason) = damage.as_ref().filter(|_| !options.accept_damaged) {
            return Err(Error::corrupt(path, NAME, reason));
        }
        Ok(RawFrame { damage, ..decode_page(path, frame, &mut self.decoder, options)? })
    }

    /// Damage of the page that the decoder would not report: of JPEGs, and of deflated data, whose checksum it ignores.
    fn damage(&mut self, mut most: u64) -> TiffResult<Option<String>> {
        const JPEG: u16 = 7;
        const DEFLATED: [u16; 2] = [8, 32946];
        let compression = self.decoder.find_tag_unsigned::<u16>(Tag::Compression)?.unwrap_or_default();
        let is_deflated = DEFLATED.contains(&compression);
        if compression != JPEG && !is_deflated {
            return Ok(None);
        }
        let tables = self.decoder.find_tag(Tag::JPEGTables)?.map(|tables| tables.into_u8_vec()).transpose()?;
        let tables = tables.unwrap_or_default();
        let (places, lengths) = match self.decoder.get_chunk_type() {
            ChunkType::Strip => (Tag::StripOffsets, Tag::StripByteCounts),
            ChunkType::Tile => (Tag::TileOffsets, Tag::TileByteCounts),
        };
        let places = self.decoder.find_tag_unsigned_vec::<u64>(places)?.unwrap_or_default();
        let lengths = self.decoder.find_tag_unsigned_vec::<u64>(lengths)?.unwrap_or_default();
        let mut file = files::open(self.reading.path)?;
        let monitor = self.reading.ticker.monitor();
        for (at, length) in places.into_iter().zip(lengths) {
            // The caller reports the cancellation.
            if monitor.is_cancelled() {
                break;
            }
            if at.saturating_add(length) > self.length {
                return Ok(Some("it ends before its picture data does".to_owned()));
            }
            let mut bytes: Vec<u8> = memory::zeroed(length as usize);
            file.seek(SeekFrom::Start(at))?;
            file.read_exact(&mut bytes)?;
            if is_deflated {
                let unpacked = unpacked_bytes(&bytes, most).map_err(corrupt)?;
                // All strips together may not exceed the page.
                most -= unpacked;
                continue;
            }
            // Tables that stand apart have the picture's start marker, and an end marker of their own.
            if !tables.is_empty() {
                bytes.splice(..2.min(bytes.len()), tables[..tables.len().saturating_sub(2)].iter().copied());
            }
            if let Err(reason) = jpeg::samples(&bytes, false, monitor) {
                return Ok(Some(reason));
            }
        }
        Ok(None)
    }
}

macro_rules! with_samples {
    ($result:expr, $samples:ident => $value:expr) => {
        match $result {
            DecodingResult::U8($samples) => $value,
            DecodingResult::U16($samples) => $value,
            DecodingResult::U32($samples) => $value,
            DecodingResult::U64($samples) => $value,
            DecodingResult::I8($samples) => $value,
            DecodingResult::I16($samples) => $value,
            DecodingResult::I32($samples) => $value,
            DecodingResult::I64($samples) => $value,
            DecodingResult::F16($samples) => $value,
            DecodingResult::F32($samples) => $value,
            DecodingResult::F64($samples) => $value,
        }
    };
}
/// Samples of a pixel. The error is the reason why such pixels are not opened.
pub(super) fn channels_of(color: ColorType) -> Result<usize, String> {
    let channels = match color {
        ColorType::Gray(_) => 1,
        ColorType::GrayA(_) | ColorType::Multiband { num_samples: 2, .. } => 2,
        ColorType::RGB(_) => 3,
        ColorType::RGBA(_) => 4,
        other => return Err(format!("its pixels are {other:?}; save it as grey or RGB")),
    };
    let is_known = [8, 16, 32, 64].contains(&color.bit_depth());
    is_known
        .then_some(channels)
        .ok_or_else(|| format!("its samples have {} bits; save it with 8, 16 or 32", color.bit_depth()))
}

fn decode_page(path: &Path, frame: usize, decoder: &mut FileDecoder, options: &OpenOptions) -> Result<RawFrame> {
    let fail = |e| failure(path, e);
    let unsupported = |reason: String| Error::unsupported(path, NAME, reason);
    let (width, height) = decoder.dimensions().map_err(fail)?;
    let size = (width as usize, height as usize);
    let channels = channels_of(decoder.colortype().map_err(fail)?).map_err(unsupported)?;
    let orientation = orientation(decoder);
    let has_no_data = no_data(decoder);
    let (mut samples, kind, planar) = read_samples(decoder, size, channels).map_err(fail)?;
    let tag = |decoder: &mut FileDecoder, tag| decoder.find_tag_unsigned::<u16>(tag).ok().flatten().unwrap_or(1);
    if tag(decoder, Tag::FillOrder) == 2 {
        match &mut samples {
            DecodingResult::U8(bytes) if tag(decoder, Tag::Compression) == 1 => {
                bytes.iter_mut().for_each(|byte| *byte = byte.reverse_bits());
            }
            // Only the bits of each byte are reversed, not the order of bytes.
            DecodingResult::U16(words) if tag(decoder, Tag::Compression) == 1 => {
                words.iter_mut().for_each(|word| *word = word.reverse_bits().swap_bytes());
            }
            _ => {
                let reason = "the bits of its bytes are in reverse (FillOrder 2), and it is compressed or of more than \
                              16 bits; save it anew with libtiff's 'tiffcp -f msb2lsb'";
                return Err(unsupported(reason.to_owned()));
            }
        }
    }
    let curve = Curve::of(kind.range.unwrap_or(1.0), kind.is_unsigned && options.linearise);
    let mut values = with_samples!(&samples, s => grey(s, size.0 * size.1, channels, planar, curve));
    if let (Some(nothing), Some(values)) = (has_no_data, &mut values) {
        // In the unit of the values, which are divided by their range already.
        let nothing = nothing as f32 / kind.range.unwrap_or(1.0);
        values.iter_mut().filter(|value| **value == nothing).for_each(|value| *value = f32::NAN);
    }
    let too_few = || Error::corrupt(path, NAME, "it has fewer samples than its size announces");
    let plane = Plane::from_vec(size.0, size.1, values.ok_or_else(too_few)?);
    let decoded = match kind.range {
        Some(range) => RawFrame::linear(plane, FileScale::Range(range)),
        None => frame_of_plane(path, frame, plane, !kind.is_float)?,
    };
    // Colours of 8 bits are those of a photograph, encoded for screens.
    let is_photograph = channels > 2 && kind.range == Some(255.0) && !options.linearise;
    let encoding = if is_photograph { Encoding::Srgb } else { decoded.encoding };
    let mosaic = decoder.inner().inner.sensor.mosaic().ok().flatten();
    let mosaic = mosaic.map(|mosaic| turned_mosaic(mosaic, size, orientation));
    Ok(RawFrame { plane: turned(decoded.plane, orientation), encoding, is_colour: channels > 2, mosaic, ..decoded })
}

/// One value a pixel; `None` where there are too few samples.
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

struct SampleKind {
    /// Largest value, where it is the full scale.
    range: Option<f32>,
    /// Whether they are unsigned integers of 8 or 16 bit, which may be encoded for screens.
    is_unsigned: bool,
    is_float: bool,
}

impl SampleKind {
    fn of(samples: &DecodingResult) -> Self {
        let (range, is_unsigned, is_float) = match samples {
            DecodingResult::U8(_) => (Some(255.0), true, false),
            DecodingResult::U16(_) => (Some(65535.0), true, false),
            DecodingResult::I8(_) => (Some(127.0), false, false),
            DecodingResult::I16(_) => (Some(32767.0), false, false),
            DecodingResult::F16(_) | DecodingResult::F32(_) | DecodingResult::F64(_) => (None, false, true),
            _ => (None, false, false),
        };
        Self { range, is_unsigned, is_float }
    }
}

/// Samples of the current page, of `size` (columns, rows), their type in the file, and whether plane follows plane.
fn read_samples(
    decoder: &mut FileDecoder,
    (width, height): (usize, usize),
    channels: usize,
) -> TiffResult<(DecodingResult, SampleKind, bool)> {
    const PLANES: u16 = 2;
    let configuration = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration)?;
    let (tile_width, tile_height) = decoder.chunk_dimensions();
    let (tile_width, tile_height) = (tile_width as usize, tile_height as usize);
    let is_cut = !(width.is_multiple_of(tile_width) && height.is_multiple_of(tile_height));
    if decoder.get_chunk_type() != ChunkType::Tile || configuration != Some(PLANES) || channels < 2 || !is_cut {
        let mut samples = DecodingResult::U8(Vec::new());
        let layout = decoder.read_image_to_buffer(&mut samples)?;
        let kind = SampleKind::of(&samples);
        return Ok((samples, kind, layout.planes > 1));
    }
    let across = width.div_ceil(tile_width);
    let tiles = across * height.div_ceil(tile_height);
    // As floats, whatever the type of the tiles: one buffer takes all.
    let mut planes: Vec<f32> = memory::zeroed(channels * width * height);
    let mut kind = SampleKind { range: None, is_unsigned: false, is_float: true };
    for chunk in 0..tiles * channels {
        let tile = decoder.read_chunk(chunk as u32)?;
        let (columns, rows) = decoder.chunk_data_dimensions((chunk % tiles) as u32);
        let (columns, rows) = (columns as usize, rows as usize);
        kind = SampleKind::of(&tile);
        let values: Vec<f32> = with_samples!(&tile, s => s.iter().map(|v| Sample::to_f32(*v)).collect());
        // In samples from the start of the first plane.
        let start = chunk / tiles * width * height
            + (chunk % tiles) / across * tile_height * width
            + (chunk % tiles) % across * tile_width;
        for (row, values) in values.chunks_exact(columns.max(1)).take(rows).enumerate() {
            if let Some(target) = planes.get_mut(start + row * width..start + row * width + columns) {
                target.copy_from_slice(values);
            }
        }
    }
    Ok((DecodingResult::F32(planes), kind, true))
}

/// Images that the description of a file with one directory announces; none where it tells of one.
pub(super) fn announced(description: Option<&str>, path: &Path, shape: PageShape) -> Option<Described> {
    let text = description?;
    let images = text.lines().find_map(|line| line.strip_prefix("images=")?.trim().parse::<usize>().ok());
    if text.starts_with("ImageJ=") {
        let images = images.filter(|images| *images > 1)?;
        let fits = described(text, path, (images, shape), None).ok().flatten();
        return fits.or_else(|| Some(Described::in_order(vec![('T', images)], images)));
    }
    if !text.starts_with('{') || !text.contains("\"truncated\"") {
        return None;
    }
    let found = described(text, path, (1, shape), None).ok().flatten()?;
    let count = product(&found.axes);
    (count > 1).then(|| Described::in_order(found.axes, count))
}

/// `count` frames of `size` behind one another, of the current directory; an error if compressed or in tiles.
pub(super) fn plain(
    decoder: &mut FileDecoder,
    (path, length): (&Path, u64),
    (count, size): (u64, (usize, usize)),
    limits: &Limits,
) -> Result<Plain> {
    let mut tag =
        |tag: Tag, usual: u64| decoder.find_tag_unsigned_vec::<u64>(tag).ok().flatten().unwrap_or(vec![usual]);
    let [compression, bits, format, samples, light] = [
        (Tag::Compression, 1),
        (Tag::BitsPerSample, 1),
        (Tag::SampleFormat, 1),
        (Tag::SamplesPerPixel, 1),
        (Tag::PhotometricInterpretation, 1),
    ]
    .map(|(name, usual)| tag(name, usual).first().copied().unwrap_or(usual));
    let (places, lengths) = (tag(Tag::StripOffsets, 0), tag(Tag::StripByteCounts, 0));
    let number = match (format, bits) {
        (1, 8) => Some(Number::U8),
        (1, 16) => Some(Number::U16),
        (1, 32) => Some(Number::U32),
        (2, 8) => Some(Number::I8),
        (2, 16) => Some(Number::I16),
        (2, 32) => Some(Number::I32),
        (3, 16) => Some(Number::F16),
        (3, 32) => Some(Number::F32),
        (3, 64) => Some(Number::F64),
        _ => None,
    };
    // Strips must follow one another without a gap, or frames have no common step.
    let follow = places.windows(2).zip(&lengths).all(|(two, bytes)| two[0].saturating_add(*bytes) == two[1]);
    let Some(number) = number.filter(|_| (compression, samples, light) == (1, 1, 1) && follow && places[0] > 0) else {
        let reason = format!(
            "it announces {count} images but lists only the first, and they are not plain grey numbers behind one \
             another; save it as BigTIFF, as a .npy stack or as an image sequence"
        );
        return Err(Error::unsupported(path, NAME, reason));
    };
    let step = number.bytes(size.0 as u64 * size.1 as u64);
    let shape = (count, size.1 as u64, size.0 as u64);
    // Where the directory follows the first image, no other is there.
    let directory = decoder.ifd_pointer().map_or(0, |at| at.0);
    let length = if directory > places[0] { length.min(directory) } else { length };
    let places = Plain::places_in(path, NAME, shape, (places[0], step, length), limits)?;
    let big_endian = decoder.byte_order() == tiff::tags::ByteOrder::BigEndian;
    Ok(Plain { big_endian, ..Plain::new(NAME, size, places, number) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::reading::Ticker;
    use crate::monitor::Monitor;
    use tiff::encoder::{TiffEncoder, colortype};

    #[test]
    fn a_page_stops_where_its_decoder_reads() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("page.tif");
        let mut encoder = TiffEncoder::new(std::fs::File::create(&path).expect("made")).expect("begun");
        encoder.write_image::<colortype::Gray16>(90, 70, &[7; 6300]).expect("written");
        let (options, monitor) = (OpenOptions::default(), Monitor::default());
        let ticker = Ticker::new(&monitor, 1);
        let length = std::fs::metadata(&path).expect("a file").len();
        let mut reader = PageReader::open(Reading::new(&path, &options, &ticker), &path, length).expect("a TIFF");
        assert!(reader.read(0, 0).is_ok());
        monitor.cancel();
        assert!(decode_page(&path, 0, &mut reader.decoder, &options).is_err());
        assert!(reader.read(0, 0).is_err_and(|error| error.is_cancelled()));
    }
}
