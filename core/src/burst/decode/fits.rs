//! FITS images without compression: two axes, or three of which the last is that of the frames, of any type, scaled by
//! BSCALE and BZERO. Of several images in a file the first is taken, or the one whose EXTNAME or number is named.
//!
//! Rows are in the file's order, as astropy reads them; many programs show the first one at the bottom. Format: the
//! FITS standard 4.0, <https://fits.gsfc.nasa.gov/fits_standard.html>.

use super::plain::Plain;
use crate::burst::number::{Number, Scaling};
use crate::burst::options::OpenOptions;
use crate::burst::times::{Times, seconds_of};
use crate::error::{Error, ErrorKind, Result};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

const KIND: &str = "FITS";
/// First bytes of every file.
pub(super) const MAGIC: &[u8] = b"SIMPLE  =";
const BLOCK_BYTES: u64 = 2880;
const CARD_BYTES: usize = 80;
/// Largest number of cards of a header, and of headers of a file.
const MAX_CARDS: usize = 1 << 14;
const MAX_UNITS: usize = 1 << 12;
/// Largest number of axes of the standard.
const MAX_AXES: u64 = 999;
/// Values of CTYPE3 of axes that are no time begin with these.
const NOT_TIME: [&str; 12] =
    ["FREQ", "WAVE", "AWAV", "VELO", "VRAD", "VOPT", "ZOPT", "ENER", "LAMB", "STOKES", "FELO", "BETA"];

/// Header of an image, or of another unit of a file.
struct Unit {
    /// Keyword and value of each card that has a value, without quotes and comment.
    cards: Vec<(String, String)>,
    /// Place of the data.
    data: u64,
    axes: Vec<u64>,
    /// Bytes of the data, without padding.
    bytes: u64,
}

impl Unit {
    /// Reads the header at the reader's place.
    fn read(path: &Path, reader: &mut (impl Read + Seek)) -> Result<Self> {
        let fail = |e: io::Error| Error::from_read(path, KIND, &e);
        let corrupt = |reason: String| Error::corrupt(path, KIND, reason);
        let mut cards = Vec::new();
        let mut card = [0; CARD_BYTES];
        let mut count = 0;
        loop {
            reader.read_exact(&mut card).map_err(fail)?;
            count += 1;
            if count > MAX_CARDS {
                return Err(corrupt(format!("a header has no END within {MAX_CARDS} lines")));
            }
            let text = String::from_utf8_lossy(&card);
            let name = text.get(..8).unwrap_or(&text).trim_end();
            if name == "END" {
                break;
            }
            if let Some(value) = text.get(8..).and_then(|rest| rest.strip_prefix("= ")) {
                cards.push((name.to_owned(), value_of(value)));
            }
        }
        let at = reader.stream_position().map_err(fail)?;
        let unit = Self { cards, data: at.next_multiple_of(BLOCK_BYTES), axes: Vec::new(), bytes: 0 };
        let whole = |name: &str| {
            let value = unit.text(name).map(|text| text.parse::<i64>());
            value
                .transpose()
                .map_err(|_| corrupt(format!("{name} is '{}', no whole number", unit.text(name).unwrap_or_default())))
        };
        let count = whole("NAXIS")?.and_then(|count| u64::try_from(count).ok()).filter(|count| *count <= MAX_AXES);
        let count = count.ok_or_else(|| corrupt("NAXIS, the number of axes, is missing or not 0 to 999".to_owned()))?;
        let axes = (1..=count).map(|axis| {
            let name = format!("NAXIS{axis}");
            let length = whole(&name)?.and_then(|length| u64::try_from(length).ok());
            length.ok_or_else(|| corrupt(format!("{name}, the length of an axis, is missing or negative")))
        });
        let axes = axes.collect::<Result<Vec<_>, _>>()?;
        let bits = whole("BITPIX")?.ok_or_else(|| corrupt("BITPIX is missing".to_owned()))?.unsigned_abs();
        let positive =
            |name: &str, default| Ok::<u64, Error>(whole(name)?.map_or(default, |value| value.max(0) as u64));
        let values =
            if axes.is_empty() { 0 } else { axes.iter().fold(1u64, |product, length| product.saturating_mul(*length)) };
        let values = values.saturating_add(positive("PCOUNT", 0)?).saturating_mul(positive("GCOUNT", 1)?);
        let bytes = values.saturating_mul(bits / 8);
        Ok(Self { axes, bytes, ..unit })
    }

    fn text(&self, name: &str) -> Option<&str> {
        self.cards.iter().find(|(own, _)| own == name).map(|(_, value)| &**value)
    }

    /// A number, in which an exponent may begin with D; an error names the keyword.
    fn number(&self, path: &Path, name: &str) -> Result<Option<f64>> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let number = text.replace(['D', 'd'], "E").parse::<f64>().ok().filter(|number| number.is_finite());
        let wrong = || Error::corrupt(path, KIND, format!("{name} is '{text}', no number"));
        number.map(Some).ok_or_else(wrong)
    }

    fn is_image(&self) -> bool {
        self.axes.len() >= 2 && self.bytes > 0 && self.text("XTENSION").is_none_or(|kind| kind == "IMAGE")
    }

    fn name(&self) -> &str {
        self.text("EXTNAME").unwrap_or("without a name")
    }

    fn plain(&self, path: &Path, length: u64, options: &OpenOptions) -> Result<Plain> {
        let refused = |problem: String, remedy: &str| Error::new(ErrorKind::Unsupported, problem, remedy).about(path);
        let number = match self.text("BITPIX") {
            Some("8") => Number::U8,
            Some("16") => Number::I16,
            Some("32") => Number::I32,
            Some("64") => Number::I64,
            Some("-32") => Number::F32,
            Some("-64") => Number::F64,
            bits => {
                let reason =
                    format!("BITPIX is {}, and 8, 16, 32, 64, -32 and -64 are possible", bits.unwrap_or("missing"));
                return Err(Error::corrupt(path, KIND, reason));
            }
        };
        let frames = self.axes.get(2).copied().unwrap_or(1);
        if self.axes.iter().skip(3).any(|length| *length != 1) {
            let problem = format!("this image has the axes {:?}", self.axes);
            return Err(refused(problem, "save columns, rows and frames alone"));
        }
        let mut taken = Vec::new();
        if frames > 1 {
            let axis = self.text("CTYPE3").unwrap_or_default();
            if options.axis.is_none() && NOT_TIME.iter().any(|start| axis.starts_with(start)) {
                let problem = format!("the {frames} pictures of this image differ in {axis} (CTYPE3), not in time");
                return Err(refused(problem, "--axis last takes them for frames"));
            }
            taken.push(format!("the third axis, of {frames} pictures, is taken for that of the frames"));
        }
        let factor = self.number(path, "BSCALE")?.unwrap_or(1.0);
        let offset = self.number(path, "BZERO")?.unwrap_or(0.0);
        let blank = self.number(path, "BLANK")?.filter(|_| !number.is_float()).map(|blank| blank as i64);
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
        let places = Plain::places_in(path, KIND, shape, (self.data, step, length), &options.limits)?;
        let scaling = (!is_plain).then_some(Scaling { factor, offset, blank });
        let size = (self.axes[0] as usize, self.axes[1] as usize);
        let (times, plain) = (self.times(path, frames)?, Plain::new(KIND, size, places, number));
        Ok(Plain { big_endian: true, white, scaling, times, taken, ..plain })
    }

    /// The middle of the exposure of a single frame.
    fn times(&self, path: &Path, frames: u64) -> Result<Times> {
        let Some(date) = self.text("DATE-OBS").filter(|_| frames == 1) else { return Ok(Times::default()) };
        let start = match self.text("TIME-OBS").filter(|_| !date.contains('T')) {
            Some(time) => seconds_of(&format!("{date}T{time}")),
            None => seconds_of(date),
        };
        let exposure_s = match self.number(path, "EXPTIME")? {
            None => self.number(path, "EXPOSURE")?,
            given => given,
        };
        let seconds = start.map(|start| start + exposure_s.unwrap_or(0.0) / 2.0);
        Ok(Times { seconds: seconds.into_iter().collect(), is_absolute: true })
    }
}

/// Value of a card, without quotes and comment.
fn value_of(text: &str) -> String {
    let text = text.trim_start();
    let Some(quoted) = text.strip_prefix('\'') else {
        return text.split('/').next().unwrap_or_default().trim().to_owned();
    };
    // Two quotes stand for one.
    let mut value = String::new();
    let mut characters = quoted.chars().peekable();
    while let Some(c) = characters.next() {
        if c == '\'' && characters.next_if_eq(&'\'').is_none() {
            break;
        }
        value.push(c);
    }
    value.trim_end().to_owned()
}

/// The image that the options name, or the first one.
pub(super) fn plain(path: &Path, file: File, length: u64, options: &OpenOptions) -> Result<Plain> {
    let fail = |e: io::Error| Error::from_read(path, KIND, &e);
    let mut reader = BufReader::with_capacity(BLOCK_BYTES as usize, file);
    let (mut images, mut at, mut is_compressed) = (Vec::new(), 0u64, false);
    for _ in 0..MAX_UNITS {
        reader.seek(SeekFrom::Start(at)).map_err(fail)?;
        let unit = Unit::read(path, &mut reader)?;
        at = unit.data.saturating_add(unit.bytes).checked_next_multiple_of(BLOCK_BYTES).unwrap_or(u64::MAX);
        is_compressed |= unit.text("ZIMAGE") == Some("T");
        if unit.is_image() {
            images.push(unit);
        }
        // What is behind the last unit is nobody's, and so is a part of a block.
        if at.saturating_add(BLOCK_BYTES) > length {
            break;
        }
    }
    if images.is_empty() {
        let quoted = path.display().to_string().replace('\'', r"'\''");
        let (problem, remedy) = if is_compressed {
            ("the image in this FITS file is compressed in tiles", format!("unpack it first: funpack '{quoted}'"))
        } else {
            ("this FITS file has no image", "name one with an image of two or three axes".to_owned())
        };
        return Err(Error::new(ErrorKind::Unsupported, problem, remedy).about(path));
    }
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
    let mut plain = images[number].plain(path, length, options)?;
    if images.len() > 1 {
        let (name, all) = (images[number].name(), images.len());
        plain.taken.push(format!("of {all} images number {number} ({name}) is taken; --array takes another"));
    }
    Ok(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_cards_are_without_quotes_and_comments() {
        for (card, value) in [
            ("                  16 / bits", "16"),
            ("'O''Hara / x ' / name", "O'Hara / x"),
            ("'2021-03-01T22:00:00'", "2021-03-01T22:00:00"),
            ("T", "T"),
            ("", ""),
            ("'", ""),
        ] {
            assert_eq!(value_of(card), value);
        }
    }
}
