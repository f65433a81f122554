//! TIFF and BigTIFF: grey or RGB, alpha or not, of 8 to 64-bit integers or floats. Thumbnails are left out.

mod axes;
mod described;
pub(super) mod directories;
mod page;
mod sensor;

pub(super) use directories::is_of_sensor;

use super::{Format, Input, Rank, Record, Start, found};
use crate::burst::options::{Limits, OpenOptions};
use crate::burst::reading::pixels::{turned, turned_size};
use crate::burst::reading::plain::{Places, Plain};
use crate::burst::reading::{Asked, Declared, Expected, RawFrame, Reading, exif, in_order};
use crate::burst::{layout::Mosaic, times::Times};
use crate::error::{Error, ErrorKind, Result};
use crate::monitor::Monitor;
use described::{Described, Page};
use directories::Directories;
use image::metadata::Orientation;
use page::PageReader;
use sensor::AsGrey;
use std::path::{Path, PathBuf};
use std::{fs::File, io::BufReader};
use tiff::{ColorType, decoder::Decoder, tags::Tag};

const NAME: &str = "TIFF";

pub(super) struct Tiff;

impl Format for Tiff {
    fn record(&self) -> Record {
        let opens = "pages of 8 to 64 bits, integers or floats, grey or RGB, BigTIFF too; of the axes of ImageJ, OME (in the order of its TiffData, also of a set of files), Micro-Manager, ScanImage, LSM, FluoView, STK, QPTIFF and tifffile only time makes frames: depths and channels, and descriptions that do not fit, are an error; frames behind one another of which one directory tells";
        let options = "`--axis Z`, `--axis T,C=1` to choose, `--axis first` for all pages, `--array NAME` for one of several images";
        Record { name: NAME, rank: Rank::Picture, extensions: &["tif", "tiff", "stk", "lsm"], opens, options }
    }

    fn begins(&self, start: &Start<'_>) -> bool {
        directories::begins(start.bytes) && !is_of_sensor(start)
    }

    fn check(&self, input: &Input, path: &Path, pages: usize) -> Result<()> {
        let mut reader = BufReader::with_capacity(512, &input.file);
        let found = Directories::read(&mut reader, input.length, false, pages);
        found.map(drop).map_err(|e| Error::from_read(path, NAME, &e))
    }

    fn count(&self, input: Input, reading: Reading<'_>) -> Result<usize> {
        // Reads no further than the second frame.
        let limits = Limits { max_frames: 1, ..Limits::default() };
        match Pages::read(reading.path, input, &OpenOptions { limits, ..reading.options.clone() }) {
            Ok(pages) => Ok(pages.count()),
            Err(error) if matches!(error.kind, ErrorKind::TooLarge | ErrorKind::Mismatch) => Ok(2),
            Err(error) => Err(error),
        }
    }

    fn declared(&self, input: Input, reading: Reading<'_>) -> Result<Declared> {
        let pages = Pages::taken(reading.path, input, reading.options)?;
        let (frames, times) = (pages.count(), pages.plain.map_or_else(Times::default, |plain| plain.times));
        let declared = Declared::new(NAME, pages.size, frames, pages.samples, pages.is_colour);
        Ok(Declared { taken: pages.taken, times, mosaic: pages.mosaic, ..declared })
    }

    fn times(&self, input: Input, reading: Reading<'_>) -> Result<Times> {
        let times = Pages::taken(reading.path, input, reading.options)?.plain.map(|plain| plain.times);
        Ok(times.filter(|times| !times.seconds.is_empty()).unwrap_or_else(|| exif::times(reading.path)))
    }

    fn frames(&self, input: Input, reading: Reading<'_>) -> Result<Vec<RawFrame>> {
        let Reading { path, options, ticker, .. } = reading;
        let length = input.length;
        let pages = Pages::taken(path, input, options)?;
        // One directory stands for all frames: the decoder would find the first alone.
        if let Some(plain) = &pages.plain {
            let frames = plain.stack(reading)?;
            let turn = |frame: RawFrame| RawFrame { plane: turned(frame.plane, pages.orientation), ..frame };
            return Ok(frames.into_iter().map(turn).collect());
        }
        // A decoder finds a page by following the chain from the first one: each thread takes runs of pages of a file.
        let most = pages.list.len().div_ceil(4 * rayon::current_num_threads()).max(1);
        let of_file = pages.list.chunk_by(|a, b| a.file == b.file);
        let runs: Vec<&[Page]> = of_file.flat_map(|pages| pages.chunks(most)).collect();
        let starts: Vec<usize> =
            runs.iter().scan(0, |sum, run| Some(std::mem::replace(sum, *sum + run.len()))).collect();
        let frames = in_order(runs.len(), |i| {
            let other = runs[i][0].file.as_ref().map(|name| beside(path, name));
            let mut reader = match &other {
                None => PageReader::open(reading, path, length)?,
                Some(other) => {
                    let (_, input) = found(other, options)?;
                    // Another file of the set has not been checked yet.
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
        // A page of another file of a set is asked of that file.
        PageReader::open(reading, reading.path, input.length)?.read(page, frame)
    }
}

/// A file of a set, which lies beside the first one.
fn beside(path: &Path, name: &str) -> PathBuf {
    path.with_file_name(Path::new(name).file_name().unwrap_or_default())
}

fn decoder(path: &Path, file: File, limits: &Limits, monitor: &Monitor) -> Result<FileDecoder> {
    let file_bytes = file.metadata().map_err(|e| Error::from_io(path, &e))?.len();
    let mut file = BufReader::new(file);
    let mut sensor = |pages| Directories::read(&mut file, file_bytes, false, pages).map(|found| found.sensor);
    // All directories are read only where the first page has a mosaic.
    let sensor = sensor(1).and_then(|first| if first.marks.is_empty() { Ok(first) } else { sensor(usize::MAX) });
    let file = sensor.and_then(|sensor| AsGrey::new(file, sensor)).map_err(|e| Error::from_read(path, NAME, &e))?;
    let decoder = Decoder::new(Asked::new(file, monitor)).map_err(|e| failure(path, e))?;
    let bytes = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let mut own = tiff::decoder::Limits::default();
    // At most four samples of eight bytes.
    own.decoding_buffer_size = bytes(limits.max_pixels.saturating_mul(32));
    own.intermediate_buffer_size = bytes(file_bytes.max(1 << 24));
    own.ifd_value_size = bytes(file_bytes.clamp(1 << 16, 1 << 26));
    Ok(decoder.with_limits(own))
}

struct Pages {
    size: (usize, usize),
    orientation: Orientation,
    list: Vec<Page>,
    /// The frames of a file of which one directory tells of all.
    plain: Option<Plain>,
    samples: String,
    is_colour: bool,
    mosaic: Option<Mosaic>,
    taken: Vec<String>,
}

impl Pages {
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
        let Directories { planes, sensor, tile_depth, .. } = start.map_err(|e| Error::from_read(path, NAME, &e))?;
        if tile_depth > 1 {
            let reason = format!("its tiles are {tile_depth} pages deep; save it as pages, without tiles");
            return Err(Error::unsupported(path, NAME, reason));
        }
        let mosaic = match options.mosaic {
            Some(_) => None,
            None => sensor.mosaic().map_err(|reason| Error::unsupported(path, NAME, reason))?,
        };
        let mut decoder = decoder(path, file, limits, &Monitor::default())?;
        let description = description(&mut decoder);
        let (samples, is_colour) = samples_of(path, &mut decoder)?;
        let (columns, rows) = decoder.dimensions().map_err(fail)?;
        let color = decoder.colortype().map_err(fail)?;
        let channels = page::channels_of(color).map_err(|reason| Error::unsupported(path, NAME, reason))?;
        let shape = [rows as usize, columns as usize, channels];
        let orientation = orientation(&mut decoder);
        let of_microscope = described::of_microscope(&mut decoder, description.as_deref().unwrap_or_default());
        let nothing = no_data(&mut decoder);
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
                // Checked at each page: a file may chain more pages than a burst can have.
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
        // One directory may announce frames that lie behind its own.
        if list.len() == 1 {
            behind = axes_of_volume(&mut decoder).or_else(|| page::announced(description.as_deref(), path, shape));
            if planes.count > 1 {
                let axes;
                (times, axes) = planes.told();
                behind = Some(Described::in_order(axes, planes.count as usize));
            }
        }
        let pages = behind.as_ref().map_or(list.len(), |behind| behind.pages.len());
        let described = match (&behind, &of_microscope) {
            (Some(behind), _) => Ok(Some(behind.clone())),
            (_, Some(axes)) if pages > 1 => described::fitting(axes.clone(), pages),
            _ if pages == 1 && description.as_deref().is_none_or(|text| !text.contains("OME")) => Ok(None),
            _ => match &description {
                Some(text) => described::described(text, path, (pages, shape), options.array.as_deref()),
                None => Ok(None),
            },
        };
        let chosen = axes::frames_of(described, pages, options.axis.as_ref()).map_err(refused)?;
        // Such frames lie at even distances; the axes choose among them.
        let plain = behind.map(|_| {
            let whole = turned_size(size, orientation);
            let plain = page::plain(&mut decoder, (path, length), (pages as u64, whole), limits)?;
            let places = chosen.pages.iter().map(|page| plain.places.at(page.number)).collect();
            if times.seconds.len() == pages {
                times.seconds = chosen.pages.iter().map(|page| times.seconds[page.number]).collect();
            }
            Ok::<_, Error>(Plain { places: Places::Listed(places), times, ..plain })
        });
        let plain = plain.transpose()?;
        // Chosen pages are counted without thumbnails, which the decoder counts.
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
        taken.extend((channels == 2).then(|| "of the two samples of each pixel the first is taken".to_owned()));
        taken.extend(nothing.map(|value| format!("the value {value} is no data (GDAL_NODATA), and is masked")));
        Ok(Self { size, orientation, list, plain, samples, is_colour, mosaic, taken })
    }
}

fn axes_of_volume(decoder: &mut FileDecoder) -> Option<Described> {
    let depth = decoder.find_tag_unsigned::<u32>(Tag::Unknown(32997)).ok().flatten()? as usize;
    (depth > 1).then(|| Described::in_order(vec![('Z', depth)], depth))
}

/// How the camera was held; no turn where the tag is missing or not one of the eight values.
fn orientation(decoder: &mut FileDecoder) -> Orientation {
    let value = decoder.find_tag_unsigned::<u8>(Tag::Orientation).ok().flatten();
    value.and_then(Orientation::from_exif).unwrap_or(Orientation::NoTransforms)
}

fn is_thumbnail(decoder: &mut FileDecoder) -> bool {
    matches!(decoder.find_tag_unsigned::<u32>(Tag::NewSubfileType), Ok(Some(kind)) if kind & 1 == 1)
}

fn description(decoder: &mut FileDecoder) -> Option<String> {
    let bytes = decoder.find_tag(Tag::ImageDescription).ok()??;
    // Some programs write text as bytes, and others characters of no encoding.
    let bytes = bytes.clone().into_u8_vec().or_else(|_| bytes.into_string().map(String::into_bytes)).ok()?;
    Some(String::from_utf8_lossy(bytes.split(|byte| *byte == 0).next()?).into_owned())
}

fn samples_of(path: &Path, decoder: &mut FileDecoder) -> Result<(String, bool)> {
    let color = decoder.colortype().map_err(|e| failure(path, e))?;
    let format =
        decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).ok().flatten().and_then(|list| list.first().copied());
    let bits = color.bit_depth();
    let samples = match format {
        Some(3) => format!("floats of {bits} bit"),
        Some(5 | 6) => return Err(Error::unsupported(path, NAME, "its samples are complex; save their magnitude")),
        _ if bits > 16 => format!("integers of {bits} bit"),
        Some(2) => format!("{bits} bit with a sign"),
        _ => format!("{bits} bit"),
    };
    Ok((samples, matches!(color, ColorType::RGB(_) | ColorType::RGBA(_))))
}

/// Value of pixels without a value, as GDAL writes it.
fn no_data(decoder: &mut FileDecoder) -> Option<f64> {
    decoder.find_tag(Tag::Unknown(42113)).ok()??.into_string().ok()?.trim().parse().ok()
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

type FileDecoder = Decoder<Asked<AsGrey>>;
