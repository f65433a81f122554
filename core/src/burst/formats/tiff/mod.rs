//! TIFF and BigTIFF with one page or many: grey or RGB (with or without alpha, interleaved or in planes) of 8, 16, 32
//! or 64-bit integers or floats. Pages that are marked as thumbnails are left out.
//!
//! A page in planes and tiles is assembled here, tile by tile: the library (tiff 0.11.3) panics where the size of such
//! a page is no multiple of the tile's.

mod axes;
mod contiguous;
mod described;
mod directories;

pub(super) use directories::{Directories, OF_SENSORS, begins as is_tiff, is_of_sensor};

use super::picture::jpeg;
use super::{Format, Input, Rank, Record, Start, found};
use crate::burst::options::{Encoding, Limits, OpenOptions};
use crate::burst::reading::confined::wire::Part;
use crate::burst::reading::confined::{self, Budget};
use crate::burst::reading::pixels::{Curve, Sample, grey_from_interleaved, grey_from_planes, turned, turned_size};
use crate::burst::reading::plain::Plain;
use crate::burst::reading::{Declared, Expected, FileScale, RawFrame, Reading, exif, frame_of_plane, in_order};
use crate::burst::times::Times;
use crate::error::{Error, ErrorKind, Result};
use crate::plane::{Plane, memory};
use described::{Axes, Described, Page};
use flate2::{Decompress, FlushDecompress, Status};
use image::metadata::Orientation;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use tiff::decoder::{ChunkType, Decoder, DecodingResult};
use tiff::tags::Tag;
use tiff::{ColorType, TiffResult};

const NAME: &str = "TIFF";

pub(super) struct Tiff;

impl Format for Tiff {
    fn record(&self) -> Record {
        let opens = "grey or RGB of one page or many, 8 to 64 bits, integers or floats; BigTIFF, OME-TIFF, ImageJ";
        Record {
            name: NAME,
            rank: Rank::Picture,
            extensions: &["tif", "tiff", "stk", "lsm"],
            opens,
            options: &["axis", "mosaic"],
        }
    }

    fn begins(&self, start: &Start<'_>) -> bool {
        is_tiff(start.bytes) && !is_of_sensor(start)
    }

    fn check(&self, input: &Input, path: &Path, pages: usize) -> Result<()> {
        let mut reader = BufReader::with_capacity(512, &input.file);
        let found = Directories::read(&mut reader, input.length, false, pages);
        found.map(drop).map_err(|e| Error::from_read(path, NAME, &e))
    }

    fn count(&self, input: Input, reading: Reading<'_>) -> Result<usize> {
        frame_count(reading.path, input, reading.options)
    }

    fn declared(&self, input: Input, reading: Reading<'_>) -> Result<Declared> {
        let pages = Pages::taken(reading.path, input, reading.options)?;
        let (frames, times) = (pages.count(), pages.plain.map_or_else(Times::default, |plain| plain.times));
        let declared = Declared::new(NAME, pages.size, frames, pages.samples, pages.is_colour);
        Ok(Declared { taken: pages.taken, times, ..declared })
    }

    fn times(&self, input: Input, reading: Reading<'_>) -> Result<Times> {
        let times = Pages::taken(reading.path, input, reading.options)?.plain.map(|plain| plain.times);
        Ok(times.filter(|times| !times.seconds.is_empty()).unwrap_or_else(|| exif::times(reading.path)))
    }

    fn frames(&self, input: Input, reading: Reading<'_>) -> Result<Vec<RawFrame>> {
        stack(reading, input)
    }

    fn only(&self, input: Input, reading: Reading<'_>) -> Result<RawFrame> {
        let (path, length) = (reading.path, input.length);
        let pages = Pages::taken(path, input, reading.options)?;
        let [Page { file: None, number }] = pages.list[..] else {
            return Err(Error::stack_among_frames(path, pages.count()));
        };
        reading.check(pages.size)?;
        PageReader::open(reading, path, length)?.read(number, 0)
    }

    fn page(&self, input: Input, reading: Reading<'_>, page: usize, frame: usize) -> Result<RawFrame> {
        self::page(reading, input, page, frame)
    }
}

/// Number of frames, 2 standing for any larger number: reads no further than the second.
fn frame_count(path: &Path, input: Input, options: &OpenOptions) -> Result<usize> {
    let limits = Limits { max_frames: 1, ..Limits::default() };
    match Pages::read(path, input, &OpenOptions { limits, ..options.clone() }) {
        Ok(pages) => Ok(pages.count()),
        Err(error) if matches!(error.kind, ErrorKind::TooLarge | ErrorKind::Mismatch) => Ok(2),
        Err(error) => Err(error),
    }
}

/// Page `page`, which is frame `frame` of its burst.
fn page(reading: Reading<'_>, input: Input, page: usize, frame: usize) -> Result<RawFrame> {
    // A page of another file of a set is asked of that file.
    PageReader::open(reading, reading.path, input.length)?.read(page, frame)
}

fn stack(reading: Reading<'_>, input: Input) -> Result<Vec<RawFrame>> {
    let Reading { path, options, ticker, .. } = reading;
    let length = input.length;
    let pages = Pages::taken(path, input, options)?;
    if let Some(plain) = &pages.plain {
        let frames = plain.stack(reading)?;
        let turn = |frame: RawFrame| RawFrame { plane: turned(frame.plane, pages.orientation), ..frame };
        return Ok(frames.into_iter().map(turn).collect());
    }
    // A decoder finds a page by following the chain from the first one, so each thread takes runs of pages of a file.
    let most = pages.list.len().div_ceil(4 * rayon::current_num_threads()).max(1);
    let of_file = pages.list.chunk_by(|a, b| a.file == b.file);
    let runs: Vec<&[Page]> = of_file.flat_map(|pages| pages.chunks(most)).collect();
    let starts: Vec<usize> = runs.iter().scan(0, |sum, run| Some(std::mem::replace(sum, *sum + run.len()))).collect();
    let frames = in_order(runs.len(), |i| {
        let other = runs[i][0].file.as_ref().map(|name| beside(path, name));
        let mut reader = match &other {
            None => PageReader::open(reading, path, length)?,
            Some(other) => {
                let (_, input) = found(other, options)?;
                Tiff.check(&input, other, usize::MAX)?;
                PageReader::open(Reading { path: other, ..reading }, other, input.length)?
            }
        };
        let mut frames = Vec::with_capacity(runs[i].len());
        for (k, page) in runs[i].iter().enumerate() {
            ticker.check()?;
            let frame = reader.read(page.number, starts[i] + k)?;
            let expected = Some(Expected { first: path, size: pages.size });
            Reading { path: other.as_deref().unwrap_or(path), expected, ..reading }.check(frame.plane.size())?;
            frames.push(frame);
            ticker.tick();
        }
        Ok(frames)
    })?;
    Ok(frames.into_iter().flatten().collect())
}

/// A file of a set, which lies beside the first one.
fn beside(path: &Path, name: &str) -> PathBuf {
    path.with_file_name(Path::new(name).file_name().unwrap_or_default())
}

fn decoder(path: &Path, mut file: File, limits: &Limits) -> Result<FileDecoder> {
    file.rewind().map_err(|e| Error::from_io(path, &e))?; // handles of one file share their place
    let file_bytes = file.metadata().map_err(|e| Error::from_io(path, &e))?.len();
    let decoder = Decoder::new(BufReader::new(file)).map_err(|e| failure(path, e))?;
    let bytes = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let mut own = tiff::decoder::Limits::default();
    // At most four samples of eight bytes.
    own.decoding_buffer_size = bytes(limits.max_pixels.saturating_mul(32));
    own.intermediate_buffer_size = bytes(file_bytes.max(1 << 24));
    own.ifd_value_size = bytes(file_bytes.clamp(1 << 16, 1 << 26));
    Ok(decoder.with_limits(own))
}

struct Pages {
    /// Size (columns, rows) of all pages.
    size: (usize, usize),
    orientation: Orientation,
    /// Pages that are frames, in their order.
    list: Vec<Page>,
    /// The frames of a file of which one directory tells of all.
    plain: Option<Plain>,
    /// Type of the samples of the first page.
    samples: String,
    is_colour: bool,
    /// Words about which pages were chosen.
    taken: Vec<String>,
}

impl Pages {
    /// The pages that are to be taken.
    fn taken(path: &Path, input: Input, options: &OpenOptions) -> Result<Self> {
        let pages = Self::read(path, input, &options.of_whole())?;
        let plain = pages.plain.map(|plain| plain.part(path, options)).transpose()?;
        let list = if plain.is_some() { pages.list } else { options.taken(path, pages.list, pages.size)? };
        Ok(Self { list, plain, ..pages })
    }

    fn count(&self) -> usize {
        self.plain.as_ref().map_or(self.list.len(), |plain| plain.places.len())
    }

    fn read(path: &Path, input: Input, options: &OpenOptions) -> Result<Self> {
        let (limits, fail) = (&options.limits, |e| failure(path, e));
        let Input { file, length } = input;
        let start = Directories::read(&mut BufReader::with_capacity(512, &file), length, false, 1);
        let planes = start.map_err(|e| Error::from_read(path, NAME, &e))?.planes;
        let mut decoder = decoder(path, file, limits)?;
        let description = description(&mut decoder);
        let (samples, is_colour) = samples_of(&mut decoder).map_err(fail)?;
        let orientation = orientation(&mut decoder);
        let (of_microscope, nothing) = (axes_of_lsm(&mut decoder), no_data(&mut decoder));
        let (mut size, mut list) = (None, Vec::new());
        for page in 0.. {
            if !is_thumbnail(&mut decoder) {
                let (width, height) = decoder.dimensions().map_err(fail)?;
                limits.check_frame(path, width.into(), height.into())?;
                let this = turned_size((width as usize, height as usize), self::orientation(&mut decoder));
                let first_size = *size.get_or_insert(this);
                if this != first_size {
                    let name = |page: usize| format!("{} (page {})", path.display(), page + 1);
                    return Err(Error::different_sizes((&name(list[0]), first_size), (&name(page), this)));
                }
                list.push(page);
                limits.check_burst(path, list.len() as u64, width.into(), height.into())?;
            }
            if !decoder.more_images() {
                break;
            }
            decoder.next_image().map_err(fail)?;
        }
        let thumbnails = "all its pages are thumbnails; save the full pictures";
        let size = size.ok_or_else(|| Error::unsupported(path, NAME, thumbnails))?;
        let refused = |(problem, remedy)| Error::new(ErrorKind::Unsupported, problem, remedy).about(path);
        let (mut behind, mut times) = (None, Times::default());
        if list.len() == 1 {
            behind = axes_of_volume(&mut decoder).or_else(|| contiguous::announced(description.as_deref(), path));
            if planes.count > 1 {
                let axes;
                (times, axes) = planes.told();
                behind = Some(Described::in_order(axes, planes.count as usize));
            }
        }
        let pages = behind.as_ref().map_or(list.len(), |behind| behind.pages.len());
        let described = match (&behind, &of_microscope) {
            (Some(behind), _) => Ok(Some(behind.clone())),
            (_, Some(axes)) if axes.iter().map(|(_, length)| length).product::<usize>() == pages => {
                Ok(Some(Described::in_order(axes.clone(), pages)))
            }
            _ if pages == 1 && description.as_deref().is_none_or(|text| !text.contains("OME")) => Ok(None),
            _ => match &description {
                Some(text) => described::described(text, path, pages, options.array.as_deref()),
                None => Ok(None),
            },
        };
        let chosen = axes::frames_of(described, pages, options.axis.as_ref()).map_err(refused)?;
        let plain = behind.map(|_| {
            let whole = turned_size(size, orientation);
            let plain = contiguous::plain(&mut decoder, (path, length), (pages as u64, whole), limits)?;
            let place = |page: &Page| plain.places.at(page.number);
            let places: Vec<u64> = chosen.pages.iter().map(place).collect();
            if times.seconds.len() == pages {
                times.seconds = chosen.pages.iter().map(|page| times.seconds[page.number]).collect();
            }
            Ok::<_, Error>(Plain { places: places.into(), times, ..plain })
        });
        let plain = plain.transpose()?;
        let own = |page: Page| match (&page.file, list.get(page.number)) {
            (None, Some(number)) if plain.is_none() => Page { number: *number, ..page },
            _ => page,
        };
        let list: Vec<Page> = chosen.pages.into_iter().map(own).collect();
        limits.check_burst(path, list.len() as u64, size.0 as u64, size.1 as u64)?;
        if let Some(missing) =
            list.iter().filter_map(|page| page.file.as_ref()).find(|name| !beside(path, name).is_file())
        {
            let problem = format!("pages of this set of files are in '{missing:.200}', which does not lie beside it");
            return Err(refused((problem, "copy it there".to_owned())));
        }
        let mut taken = chosen.said;
        taken.extend(nothing.map(|value| format!("the value {value} is no data (GDAL_NODATA), and is masked")));
        Ok(Self { size, orientation, list, plain, samples, is_colour, taken })
    }
}

/// Axes of an LSM file of Zeiss: its times and depths. Its channels are samples of a pixel.
fn axes_of_lsm(decoder: &mut FileDecoder) -> Option<Axes> {
    let bytes = decoder.find_tag(Tag::Unknown(34412)).ok().flatten()?.into_u8_vec().ok()?;
    let number = |at: usize| {
        let bytes = bytes.get(at..at + 4)?.try_into().ok()?;
        usize::try_from(u32::from_le_bytes(bytes)).ok().filter(|length| *length > 0)
    };
    Some(vec![('T', number(24)?), ('Z', number(16)?)])
}

/// Axes of a volume in one directory (SGI's ImageDepth).
fn axes_of_volume(decoder: &mut FileDecoder) -> Option<Described> {
    let depth = decoder.find_tag_unsigned::<u32>(Tag::Unknown(32997)).ok().flatten()? as usize;
    (depth > 1).then(|| Described::in_order(vec![('Z', depth)], depth))
}

/// Bytes that deflated strips and tiles may have besides their pixels.
const FILLING_BYTES: u64 = 1 << 20;

/// Number of bytes, at most `most`, to which zlib's data unpacks whose checksum is right. The error is the end of a
/// sentence.
fn unpacked_bytes(packed: &[u8], most: u64) -> Result<u64, String> {
    let (mut state, mut block) = (Decompress::new(true), [0; 1 << 14]);
    loop {
        let before = (state.total_in(), state.total_out());
        let status = state.decompress(&packed[before.0 as usize..], &mut block, FlushDecompress::None);
        let status = status.map_err(|e| format!("its deflated data: {e}"))?;
        match status {
            _ if state.total_out() > most => return Err("its deflated data is far more than its pixels".to_owned()),
            Status::StreamEnd => return Ok(state.total_out()),
            _ if (state.total_in(), state.total_out()) == before => {
                return Err("its deflated data ends before its checksum".to_owned());
            }
            _ => {}
        }
    }
}

struct PageReader<'a> {
    reading: Reading<'a>,
    decoder: FileDecoder,
    length: u64,
}

impl<'a> PageReader<'a> {
    fn open(reading: Reading<'a>, path: &Path, length: u64) -> Result<Self> {
        let file = File::open(path).map_err(|e| Error::from_io(reading.path, &e))?;
        let decoder = decoder(reading.path, file, &reading.options.limits)?;
        Ok(Self { reading, decoder, length })
    }

    /// Decodes page `page`, whose size has been checked, as frame `frame` of the burst.
    fn read(&mut self, page: usize, frame: usize) -> Result<RawFrame> {
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
        if confined::takes(taken) {
            let budget = Budget::new(self.length, pixels, taken.saturating_mul(2));
            let part = Part::Page { page, frame };
            return confined::decode(Reading { expected: None, ..self.reading }, NAME, part, budget);
        }
        memory::check_room(taken);
        // Strips and tiles at the edges may be filled up.
        let most = pixels.saturating_add(chunk).saturating_mul(2 * sample_bytes).saturating_add(FILLING_BYTES);
        let damage = self.damage(most).map_err(fail)?;
        if let Some(reason) = damage.as_ref().filter(|_| !options.accept_damaged) {
            return Err(Error::corrupt(path, NAME, reason));
        }
        let decoded = decode_page(path, frame, &mut self.decoder, options)?;
        Ok(RawFrame { damage, ..decoded })
    }

    /// Damage of the decoder's current page that the decoder would not report: its strips or tiles may be JPEGs, or
    /// deflated, of which it does not read the checksum: a wrong one is an error. All unpack to at most `most` bytes.
    fn damage(&mut self, mut most: u64) -> TiffResult<Option<String>> {
        const JPEG: u16 = 7;
        const DEFLATED: [u16; 2] = [8, 32946];
        let compression = self.decoder.find_tag_unsigned::<u16>(Tag::Compression)?.unwrap_or_default();
        let is_deflated = DEFLATED.contains(&compression);
        let corrupt = |reason: String| std::io::Error::new(std::io::ErrorKind::InvalidData, reason);
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
        let mut file = File::open(self.reading.path)?;
        for (at, length) in places.into_iter().zip(lengths) {
            if at.saturating_add(length) > self.length {
                return Ok(Some("it ends before its picture data does".to_owned()));
            }
            let mut bytes: Vec<u8> = memory::zeroed(length as usize);
            file.seek(SeekFrom::Start(at))?;
            file.read_exact(&mut bytes)?;
            if is_deflated {
                if self.reading.ticker.monitor().is_cancelled() {
                    break;
                }
                let unpacked = unpacked_bytes(&bytes, most).map_err(corrupt)?;
                most -= unpacked;
                continue;
            }
            // Tables that stand apart have the picture's start marker, and an end marker of their own.
            if !tables.is_empty() {
                bytes.splice(..2.min(bytes.len()), tables[..tables.len().saturating_sub(2)].iter().copied());
            }
            if let Err(reason) = jpeg::samples(&bytes, false) {
                return Ok(Some(reason));
            }
        }
        Ok(None)
    }
}

/// How the camera was held; no turn where the tag is missing or not one of the eight values.
fn orientation(decoder: &mut FileDecoder) -> Orientation {
    let value = decoder.find_tag_unsigned::<u8>(Tag::Orientation).ok().flatten();
    value.and_then(Orientation::from_exif).unwrap_or(Orientation::NoTransforms)
}

fn is_thumbnail(decoder: &mut FileDecoder) -> bool {
    matches!(decoder.find_tag_unsigned::<u32>(Tag::NewSubfileType), Ok(Some(kind)) if kind & 1 == 1)
}

/// Description of the first page.
fn description(decoder: &mut FileDecoder) -> Option<String> {
    let bytes = decoder.find_tag(Tag::ImageDescription).ok()??;
    // Some programs write text as bytes, and others characters of no encoding.
    let bytes = bytes.clone().into_u8_vec().or_else(|_| bytes.into_string().map(String::into_bytes)).ok()?;
    Some(String::from_utf8_lossy(bytes.split(|byte| *byte == 0).next()?).into_owned())
}

/// Type of the samples of the current page, and whether they are colours.
fn samples_of(decoder: &mut FileDecoder) -> TiffResult<(String, bool)> {
    let color = decoder.colortype()?;
    let format =
        decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).ok().flatten().and_then(|list| list.first().copied());
    let bits = color.bit_depth();
    let samples = match format {
        Some(3) => format!("floats of {bits} bit"),
        _ if bits > 16 => format!("integers of {bits} bit"),
        Some(2) => format!("{bits} bit with a sign"),
        _ => format!("{bits} bit"),
    };
    Ok((samples, matches!(color, ColorType::RGB(_) | ColorType::RGBA(_))))
}

/// Samples of `$result`, whatever their type, as `$samples` in `$value`.
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
/// Decodes the decoder's current page; its size has been checked.
fn decode_page(path: &Path, frame: usize, decoder: &mut FileDecoder, options: &OpenOptions) -> Result<RawFrame> {
    let fail = |e| failure(path, e);
    let unsupported = |reason: String| Error::unsupported(path, NAME, reason);
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
    let has_no_data = no_data(decoder);
    let (mut samples, kind, planar) = read_samples(decoder, size, channels).map_err(fail)?;
    let tag = |decoder: &mut FileDecoder, tag| decoder.find_tag_unsigned::<u16>(tag).ok().flatten().unwrap_or(1);
    if tag(decoder, Tag::FillOrder) == 2 {
        match &mut samples {
            DecodingResult::U8(bytes) if tag(decoder, Tag::Compression) == 1 => {
                bytes.iter_mut().for_each(|byte| *byte = byte.reverse_bits());
            }
            // The bits of each byte are reversed, and not the order of bytes.
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
        let nothing = nothing as f32 / kind.range.unwrap_or(1.0);
        values.iter_mut().filter(|value| **value == nothing).for_each(|value| *value = f32::NAN);
    }
    let too_few = || Error::corrupt(path, NAME, "it has fewer samples than its size announces");
    let plane = Plane::from_vec(size.0, size.1, values.ok_or_else(too_few)?);
    let decoded = match kind.range {
        Some(range) => RawFrame::linear(plane, FileScale::Range(range)),
        None => frame_of_plane(path, frame, plane, !kind.is_float)?,
    };
    let is_photograph = channels > 2 && kind.range == Some(255.0) && !options.linearise;
    let encoding = if is_photograph { Encoding::Srgb } else { decoded.encoding };
    Ok(RawFrame { plane: turned(decoded.plane, orientation), encoding, is_colour: channels > 2, ..decoded })
}

/// Value of pixels without a value, as GDAL writes it.
fn no_data(decoder: &mut FileDecoder) -> Option<f64> {
    decoder.find_tag(Tag::Unknown(42113)).ok()??.into_string().ok()?.trim().parse().ok()
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

fn failure(path: &Path, error: tiff::TiffError) -> Error {
    use tiff::TiffError::{FormatError, IntSizeError, IoError, LimitsExceeded, UnsupportedError, UsageError};
    match error {
        IoError(e) => Error::from_read(path, NAME, &e),
        UnsupportedError(e) => {
            Error::unsupported(path, NAME, format!("{e}; save it as grey or RGB without exotic compression"))
        }
        LimitsExceeded => Error::too_large(
            path,
            "a table or strip in it announces too many bytes",
            "what the file itself could hold",
            "copy it again, or save it anew",
        ),
        FormatError(_) | IntSizeError | UsageError(_) => Error::corrupt(path, NAME, error),
    }
}

type FileDecoder = Decoder<BufReader<File>>;

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

/// Reads the decoder's current page, of `size` (columns, rows) and `channels` samples a pixel; returns its samples, the
/// type that they have in the file, and whether they are plane after plane.
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
