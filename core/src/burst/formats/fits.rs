//! FITS images: two axes, or three with the frames last, of any type, scaled by BSCALE and BZERO; as numbers, or as
//! tiles in the rows of a table (`fpack`). Of several images the first is taken, or the one that is named or numbered.
//!
//! Rows are in the file's order, as astropy reads them; many programs show the first one at the bottom. Format: the
//! FITS standard 4.0, <https://fits.gsfc.nasa.gov/fits_standard.html>; tiles are section 10 of it.

use super::{Input, Numbers, Rank, Record};
use crate::burst::layout::{Axis, Mosaic};
use crate::burst::number::{Number, Scaling};
use crate::burst::options::OpenOptions;
use crate::burst::reading::plain::{Places, Plain};
use crate::burst::reading::{Reading, tiles::Tiles};
use crate::burst::times::{Times, seconds_of};
use crate::error::{Error, ErrorKind, Result};
use fitsio_pure::header::{Card, parse_card};
use fitsio_pure::value::Value;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::{fs::File, path::Path};

const KIND: &str = "FITS";
const BLOCK_BYTES: u64 = 2880;
const CARD_BYTES: usize = 80;
/// Largest number of cards of a header, and of headers of a file.
const MAX_CARDS: usize = 1 << 14;
const MAX_UNITS: usize = 1 << 12;
/// Bytes of data that are added up at a time; a multiple of a word.
const SUMMED_BYTES: u64 = 1 << 20;
const MAX_AXES: u64 = 999;
/// Beginnings of CTYPE3 for axes that are not time.
const NOT_TIME: [&str; 12] =
    ["FREQ", "WAVE", "AWAV", "VELO", "VRAD", "VOPT", "ZOPT", "ENER", "LAMB", "STOKES", "FELO", "BETA"];

pub(super) struct Fits;

impl Numbers for Fits {
    const MAGIC: Option<&'static [u8]> = Some(b"SIMPLE  =");

    fn record(&self) -> Record {
        let opens = "the first image: two axes, or three for frames; of three pictures it has to be said whether they are colours; BITPIX 8 to 64, -32, -64, BSCALE, BZERO; also compressed in tiles, as `fpack` and astropy write it (RICE_1, GZIP_1, GZIP_2, HCOMPRESS_1, PLIO_1); the mosaic of BAYERPAT is binned; undefined values (BLANK, NaN) are masked, and a note says how many; rows in the file's order, as astropy reads them";
        let options = "`--array NAME` for another extension, `--axis C` for colours, `--axis last` for frames";
        Record { name: KIND, rank: Rank::Film, extensions: &["fits", "fit", "fts", "fz"], opens, options }
    }

    fn verify(&self, input: &Input, reading: Reading<'_>) -> Result<()> {
        let (unit, ..) = chosen(reading.path, input, reading.options)?;
        unit.verify(&input.file, reading)
    }

    fn plain(&self, input: Input, path: &Path, options: &OpenOptions) -> Result<Plain> {
        let (unit, number, all) = chosen(path, &input, options)?;
        let mut plain = unit.plain(path, input.length, options)?;
        if all > 1 {
            let name = unit.name();
            plain.taken.push(format!("of {all} images number {number} ({name}) is taken; --array takes another"));
        }
        Ok(plain)
    }
}

struct Unit {
    cards: Vec<Card>,
    data: u64,
    /// Axes of the data, and of the image: those of the data, unless these are a table of tiles.
    own_axes: Vec<u64>,
    axes: Vec<u64>,
    is_tiled: bool,
    /// Bytes of the data, without padding.
    bytes: u64,
}

impl Unit {
    fn read(path: &Path, reader: &mut (impl Read + Seek)) -> Result<Self> {
        let fail = |e: io::Error| Error::from_read(path, KIND, &e);
        let corrupt = |reason: String| Error::corrupt(path, KIND, reason);
        let mut cards = Vec::new();
        let mut card = [0; CARD_BYTES];
        for count in 0.. {
            reader.read_exact(&mut card).map_err(fail)?;
            // A header without END would be read to the end of the file.
            if count >= MAX_CARDS {
                return Err(corrupt(format!("a header has no END within {MAX_CARDS} lines")));
            }
            if card.starts_with(b"END     ") {
                break;
            }
            // Some programs write comments that are no ASCII.
            card.iter_mut().filter(|byte| !byte.is_ascii()).for_each(|byte| *byte = b'?');
            cards.extend(parse_card(&card));
        }
        let data = reader.stream_position().map_err(fail)?.next_multiple_of(BLOCK_BYTES);
        let unit = Self { cards, data, own_axes: Vec::new(), axes: Vec::new(), is_tiled: false, bytes: 0 };
        let positive = |name: &str| -> Result<Option<u64>> {
            Ok(unit.whole(path, name)?.and_then(|number| number.try_into().ok()))
        };
        let axes_of = |prefix: &str| {
            let (count, own) = (format!("{prefix}NAXIS"), |axis| format!("{prefix}NAXIS{axis}"));
            let wrong = || corrupt(format!("{count}, the number of axes, is missing or not 0 to {MAX_AXES}"));
            let length = |axis| {
                let wrong = || corrupt(format!("{}, the length of an axis, is missing or negative", own(axis)));
                positive(&own(axis))?.ok_or_else(wrong)
            };
            let count = positive(&count)?.filter(|count| *count <= MAX_AXES).ok_or_else(wrong)?;
            (1..=count).map(length).collect::<Result<Vec<u64>>>()
        };
        let axes = axes_of("")?;
        let bits = unit.whole(path, "BITPIX")?.ok_or_else(|| corrupt("BITPIX is missing".to_owned()))?.unsigned_abs();
        let values =
            if axes.is_empty() { 0 } else { axes.iter().fold(1u64, |product, length| product.saturating_mul(*length)) };
        // Bytes of a unit, by the standard: |BITPIX| / 8 · GCOUNT · (PCOUNT + product of the axes).
        let (pcount, gcount) = (positive("PCOUNT")?.unwrap_or(0), positive("GCOUNT")?.unwrap_or(1));
        let bytes = values.saturating_add(pcount).saturating_mul(gcount).saturating_mul(bits / 8);
        let is_tiled = unit.text("XTENSION") == Some("BINTABLE") && unit.value("ZIMAGE") == Some(&Value::Logical(true));
        // A table of tiles keeps the image's axes under names with a Z.
        let image = if is_tiled { axes_of("Z")? } else { axes.clone() };
        Ok(Self { own_axes: axes, axes: image, is_tiled, bytes, ..unit })
    }

    /// Value of a keyword; one without a value, or with one that cannot be read, is undefined.
    fn value(&self, name: &str) -> Option<&Value> {
        let card = self.cards.iter().find(|card| card.keyword_str() == name)?;
        Some(card.value.as_ref().unwrap_or(&Value::Undefined))
    }

    fn text(&self, name: &str) -> Option<&str> {
        if let Some(Value::String(text)) = self.value(name) { Some(text) } else { None }
    }

    fn whole(&self, path: &Path, name: &str) -> Result<Option<i64>> {
        match self.value(name) {
            None => Ok(None),
            Some(Value::Integer(number)) => Ok(Some(*number)),
            Some(_) => Err(Error::corrupt(path, KIND, format!("{name} is no whole number"))),
        }
    }

    /// A number, or a text that is one; an error names the keyword.
    fn number(&self, path: &Path, name: &str) -> Result<Option<f64>> {
        let number = match self.value(name) {
            None => return Ok(None),
            Some(Value::Integer(number)) => Some(*number as f64),
            Some(Value::Float(number)) => Some(*number),
            Some(Value::String(text)) => text.trim().parse().ok(),
            Some(_) => None,
        };
        let wrong = || Error::corrupt(path, KIND, format!("{name} is no number"));
        number.filter(|number| number.is_finite()).map(Some).ok_or_else(wrong)
    }

    fn is_image(&self) -> bool {
        let is_kind = self.is_tiled || self.text("XTENSION").is_none_or(|kind| kind == "IMAGE");
        is_kind && self.axes.len() >= 2 && self.bytes > 0 && !self.axes.contains(&0)
    }

    fn name(&self) -> &str {
        self.text("EXTNAME").unwrap_or("without a name")
    }

    fn plain(&self, path: &Path, length: u64, options: &OpenOptions) -> Result<Plain> {
        let refused = |problem: String, remedy: &str| Error::new(ErrorKind::Unsupported, problem, remedy).about(path);
        let number = match self.whole(path, if self.is_tiled { "ZBITPIX" } else { "BITPIX" })? {
            Some(8) => Number::U8,
            Some(16) => Number::I16,
            Some(32) => Number::I32,
            Some(64) => Number::I64,
            Some(-32) => Number::F32,
            Some(-64) => Number::F64,
            bits => {
                let bits = bits.map_or("missing".to_owned(), |bits| bits.to_string());
                let reason = format!("BITPIX is {bits}, and 8, 16, 32, 64, -32 and -64 are possible");
                return Err(Error::corrupt(path, KIND, reason));
            }
        };
        let frames = self.axes.get(2).copied().unwrap_or(1);
        if self.axes.iter().skip(3).any(|length| *length != 1) {
            let problem = format!("this image has the axes {:?}", self.axes);
            return Err(refused(problem, "save columns, rows and frames alone"));
        }
        let mut taken = Vec::new();
        let axis = self.text("CTYPE3").unwrap_or_default().trim();
        let chosen = options.axis.as_ref().map(|axis| axis.along);
        // Three pictures may be colours or frames: the options or the header decide, else the user is asked.
        let is_named = axis.to_uppercase().starts_with("RGB") || axis.eq_ignore_ascii_case("COLOR");
        let are_colours = frames == 3 && (chosen == Some(Axis::C) || chosen.is_none() && is_named);
        let is_said = NOT_TIME.iter().any(|start| axis.starts_with(start)) || axis.to_uppercase().starts_with("TIME");
        if frames == 3 && chosen.is_none() && !are_colours && !is_said {
            let problem = "the three pictures of this image may be its colours, or three frames";
            return Err(refused(
                problem.to_owned(),
                "--axis C takes them for red, green and blue, --axis last for frames",
            ));
        }
        if are_colours {
            taken.push("its three pictures are taken for red, green and blue, whose luma is used".to_owned());
        } else if frames > 1 {
            if options.axis.is_none() && NOT_TIME.iter().any(|start| axis.starts_with(start)) {
                let problem = format!("the {frames} pictures of this image differ in {axis} (CTYPE3), not in time");
                return Err(refused(problem, "--axis last takes them for frames"));
            }
            taken.push(format!("the third axis, of {frames} pictures, is taken for that of the frames"));
        }
        let factor = self.number(path, "BSCALE")?.unwrap_or(1.0);
        let offset = self.number(path, "BZERO")?.unwrap_or(0.0);
        // Tiles have a blank of their own where the image has none.
        let blank = match self.number(path, "BLANK")? {
            None if self.is_tiled => self.number(path, "ZBLANK")?,
            given => given,
        };
        let blank = blank.filter(|_| !number.is_float()).map(|blank| blank as i64);
        let is_plain = (factor, offset, blank) == (1.0, 0.0, None);
        let white = match (number, factor, offset) {
            // Unsigned numbers are stored as signed ones, and bytes with a sign as those without.
            (Number::I16, 1.0, 32768.0) => Some(65535.0),
            (Number::U8, 1.0, -128.0) => Some(127.0),
            (_, 1.0, 0.0) => number.range(),
            _ => None,
        };
        let step = number.bytes(self.axes[0].saturating_mul(self.axes[1]));
        let shape = (frames, self.axes[1], self.axes[0]);
        let (places, tiles) = if self.is_tiled {
            let place = (self.data, length);
            let tiles = Tiles::of(path, &self.cards, &self.own_axes, shape, place, &options.limits)?;
            // Places of a tiled image are numbers of pictures, not bytes.
            (Places::Even { first: 0, step: 1, count: frames }, Some(tiles))
        } else {
            (Plain::places_in(path, KIND, shape, (self.data, step, length), &options.limits)?, None)
        };
        let scaling = (!is_plain).then_some(Scaling { factor, offset, blank });
        let size = (self.axes[0] as usize, self.axes[1] as usize);
        let (times, mosaic, plain) =
            (self.times(frames), self.mosaic().filter(|_| !are_colours), Plain::new(KIND, size, places, number));
        let plain = Plain { big_endian: true, white, scaling, times, taken, tiles, mosaic, ..plain };
        if !are_colours {
            return Ok(plain);
        }
        // Three planes of a picture: its frame begins with the first.
        let first = plain.places.at(0);
        let step = if plain.tiles.is_some() { 1 } else { step };
        let places = Places::Even { first, step: 3 * step, count: 1 };
        Ok(Plain { places, planes: step, ..plain })
    }

    /// Compares DATASUM, the sum of the padded data in words of 32 bits with carries added (FITS standard, 4.4.2.7).
    fn verify(&self, mut file: &File, reading: Reading<'_>) -> Result<()> {
        let Some(stated) = self.text("DATASUM").and_then(|text| text.trim().parse::<u32>().ok()) else { return Ok(()) };
        let fail = |e: io::Error| Error::from_read(reading.path, KIND, &e);
        file.seek(SeekFrom::Start(self.data)).map_err(fail)?;
        let mut data = file.take(self.bytes.next_multiple_of(BLOCK_BYTES));
        let (mut sum, mut block) = (0u64, Vec::with_capacity(SUMMED_BYTES as usize));
        while (&mut data).take(SUMMED_BYTES).read_to_end(&mut block).map_err(fail)? > 0 {
            reading.ticker.check()?;
            let words =
                block.chunks_exact(4).map(|word| u64::from(u32::from_be_bytes([word[0], word[1], word[2], word[3]])));
            sum += words.sum::<u64>();
            // Carries are folded back after each block, so that the sum never overflows.
            sum = (sum >> 32) + (sum & u64::from(u32::MAX));
            block.clear();
        }
        sum = (sum >> 32) + (sum & u64::from(u32::MAX));
        // Zero has two forms in ones' complement, so sums are compared modulo 2³² − 1.
        if sum % u64::from(u32::MAX) == u64::from(stated) % u64::from(u32::MAX) || reading.options.accept_damaged {
            return Ok(());
        }
        let problem = format!("the data of this FITS image add up to {sum}, not to {stated} as DATASUM says");
        let remedy =
            "copy it again; or, where a program has changed the data and left DATASUM, take them with --accept-damaged";
        Err(Error::new(ErrorKind::Damaged, problem, remedy).about(reading.path))
    }

    fn mosaic(&self) -> Option<Mosaic> {
        let pattern = self.text("BAYERPAT").or_else(|| self.text("COLORTYP"))?.trim();
        let mut mosaic = Mosaic::ALL.into_iter().find(|mosaic| pattern.eq_ignore_ascii_case(&format!("{mosaic:?}")))?;
        let offset = |name: &str| match self.value(name) {
            Some(Value::Integer(number)) => number.rem_euclid(2) == 1,
            Some(Value::Float(number)) => (*number as i64).rem_euclid(2) == 1,
            _ => false,
        };
        // Patterns begin at the upper left corner: in a file from the lowest row up, an even number of rows swaps them.
        let is_upside_down = self.text("ROWORDER").is_some_and(|order| order.trim().eq_ignore_ascii_case("BOTTOM-UP"));
        let is_even = self.axes[1].is_multiple_of(2);
        if offset("XBAYROFF") {
            mosaic = mosaic.shifted(1, 0);
        }
        if offset("YBAYROFF") != (is_upside_down && is_even) {
            mosaic = mosaic.shifted(0, 1);
        }
        Some(mosaic)
    }

    /// The middle of the exposure of a single frame.
    fn times(&self, frames: u64) -> Times {
        if frames != 1 {
            return Times::default();
        }
        // Only times need these: what is no number leaves the frames as they are.
        let number = |name: &str| self.number(Path::new(""), name).ok().flatten();
        let date = |name: &str| {
            let date = self.text(name)?;
            match self.text("TIME-OBS").filter(|_| !date.contains('T')) {
                Some(time) => seconds_of(&format!("{date}T{time}")),
                None => seconds_of(date),
            }
        };
        // Days count from midnight of 17 November 1858.
        let day = |name: &str| number(name).map(|days| (days - 40_587.0) * 86_400.0);
        let exposure_s = ["EXPTIME", "EXPOSURE", "XPOSURE"].into_iter().find_map(number).unwrap_or(0.0);
        let start = ["DATE-OBS", "DATE-BEG"].into_iter().find_map(date);
        let start = start.or_else(|| ["MJD-OBS", "MJD-BEG"].into_iter().find_map(day));
        let middle = date("DATE-AVG").or_else(|| day("MJD-AVG"));
        let seconds = middle.or(start.map(|start| start + exposure_s / 2.0));
        Times { seconds: seconds.into_iter().collect(), is_absolute: true }
    }
}

/// The image that the options name, or the first one; its number, and that of all images.
fn chosen(path: &Path, input: &Input, options: &OpenOptions) -> Result<(Unit, usize, usize)> {
    let fail = |e: io::Error| Error::from_read(path, KIND, &e);
    let mut reader = BufReader::with_capacity(BLOCK_BYTES as usize, &input.file);
    let (mut images, mut at) = (Vec::<Unit>::new(), 0u64);
    // Units follow one another by their declared lengths, in a damaged file perhaps without end.
    for _ in 0..MAX_UNITS {
        reader.seek(SeekFrom::Start(at)).map_err(fail)?;
        let start = reader.fill_buf().map_err(fail)?;
        // Behind the last unit the standard allows records of any kind; a file that was made in one piece ends with 0.
        if at > 0 && !["XTENSION", "SIMPLE  "].iter().any(|begins| start.starts_with(begins.as_bytes())) {
            break;
        }
        let unit = Unit::read(path, &mut reader)?;
        at = unit.data.saturating_add(unit.bytes).checked_next_multiple_of(BLOCK_BYTES).unwrap_or(u64::MAX);
        images.extend(Some(unit).filter(Unit::is_image));
        // Bytes behind the last unit, and a part of a block, belong to no unit.
        if at.saturating_add(BLOCK_BYTES) > input.length {
            break;
        }
    }
    if images.is_empty() {
        let (problem, remedy) = ("this FITS file has no image", "name one with an image of two or three axes");
        return Err(Error::new(ErrorKind::Unsupported, problem, remedy).about(path));
    }
    // The name first, which may be a number too.
    let number = match &options.array {
        None => 0,
        Some(name) => {
            let named = images.iter().position(|unit| unit.text("EXTNAME") == Some(name));
            let numbered = || name.parse::<usize>().ok().filter(|number| *number < images.len());
            named.or_else(numbered).ok_or_else(|| {
                let names: Vec<&str> = images.iter().map(Unit::name).collect();
                let remedy = format!("say with --array its name, or its number from 0 on: {}", names.join(", "));
                Error::new(ErrorKind::Unsupported, format!("this file has no image '{name}'"), remedy).about(path)
            })?
        }
    };
    let all = images.len();
    Ok((images.swap_remove(number), number, all))
}
