//! Y4M films (YUV4MPEG2): the luma of each frame, of 8 to 16 bits; the planes of colour are skipped.
//!
//! A line of text says size, frames a second and colours; each frame has a line of its own. Luma is taken as it is
//! stored. Format: <https://wiki.multimedia.cx/index.php/YUV4MPEG2>.

use super::{Input, Numbers, Rank, Record};
use crate::burst::reading::plain::{Places, Plain};
use crate::burst::{number::Number, options::OpenOptions, times::Times};
use crate::error::{Error, Result};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

pub(super) const KIND: &str = "Y4M";
const MAX_LINE_BYTES: u64 = 1 << 12;
const MAX_SIDE: u64 = 1 << 20;
const FRAME: &[u8] = b"FRAME";

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Film {
    pub size: (usize, usize),
    luma_bytes: u64,
    frame_bytes: u64,
    bits: u32,
    has_colour: bool,
    is_full_range: bool,
    /// Seconds from a frame to the next; 0 where it is not known.
    interval_s: f64,
}

impl Film {
    pub(super) fn read(path: &Path, reader: &mut impl BufRead) -> Result<Self> {
        let line = line(path, reader)?;
        let text = String::from_utf8_lossy(&line);
        let corrupt = |reason: String| Error::corrupt(path, KIND, reason);
        let fields = text.split(' ').skip(1);
        let field = |letter: char| fields.clone().find_map(|field| field.strip_prefix(letter));
        let side = |letter| {
            let side = field(letter).and_then(|text| text.parse::<u32>().ok());
            side.ok_or_else(|| corrupt(format!("its line has no number of pixels {letter}")))
        };
        let (width, height) = (side('W')?, side('H')?);
        // 4:2:0 is the format's default.
        let colours = field('C').unwrap_or("420");
        let (chroma, bits) = planes_of(colours).ok_or_else(|| {
            let reason = format!("its colours are {colours}; save it as mono, 420, 422 or 444 of 8 to 16 bits");
            Error::unsupported(path, KIND, reason)
        })?;
        let interval_s = field('F').and_then(|rate| {
            let (count, seconds) = rate.split_once(':')?;
            let (count, seconds): (u32, u32) = (count.parse().ok()?, seconds.parse().ok()?);
            (count > 0).then(|| f64::from(seconds) / f64::from(count))
        });
        if field('I').is_some_and(|order| !matches!(order, "p" | "?")) {
            let reason =
                "its frames are interlaced: each has the rows of two moments; deinterlace it (ffmpeg -vf bwdif)";
            return Err(Error::unsupported(path, KIND, reason));
        }
        let (width, height) = (u64::from(width), u64::from(height));
        // Bytes are counted without overflow; whether sides are within the limits is checked with the frames.
        if width.max(height) > MAX_SIDE {
            return Err(corrupt(format!("its line announces {width}×{height} pixels")));
        }
        let bytes = u64::from(bits.div_ceil(8));
        // Planes of colour of an odd side are rounded up.
        let halved = |side: u64, by: u64| side.div_ceil(by);
        let planes = chroma.map_or(0, |(across, down)| 2 * halved(width, across) * halved(height, down));
        let alpha = if colours.contains("alpha") { width * height } else { 0 };
        let (size, has_colour) = ((width as usize, height as usize), chroma.is_some());
        let (luma_bytes, frame_bytes) = (bytes * width * height, bytes * (width * height + planes + alpha));
        let is_full_range = fields.clone().any(|field| field == "XCOLORRANGE=FULL");
        let interval_s = interval_s.unwrap_or(0.0);
        Ok(Self { size, luma_bytes, frame_bytes, bits, has_colour, is_full_range, interval_s })
    }

    /// Reads the line of the next frame; false at the end of the film.
    pub(super) fn next_frame(path: &Path, reader: &mut impl BufRead) -> Result<bool> {
        if reader.fill_buf().map_err(|e| Error::from_read(path, KIND, &e))?.is_empty() {
            return Ok(false);
        }
        let line = line(path, reader)?;
        if line == FRAME || line.starts_with(b"FRAME ") {
            return Ok(true);
        }
        Err(Error::corrupt(path, KIND, "a frame does not begin with the word FRAME"))
    }

    /// Bytes of a frame behind its luma.
    pub(super) fn rest_bytes(&self) -> u64 {
        self.frame_bytes - self.luma_bytes
    }

    pub(super) fn plain(&self, places: Vec<u64>) -> Plain {
        let frames = places.len();
        let range = ((1u32 << self.bits) - 1) as f32;
        let mut taken = Vec::new();
        taken.extend(self.has_colour.then(|| "the luma is taken, as it is stored".to_owned()));
        if self.has_colour && !self.is_full_range {
            let (black, white) = (16 << (self.bits - 8), 235 << (self.bits - 8));
            taken.push(format!("films usually have black at {black} and white at {white}"));
        }
        let seconds =
            if self.interval_s > 0.0 { (0..frames).map(|t| t as f64 * self.interval_s).collect() } else { Vec::new() };
        let times = Times { seconds, is_absolute: false };
        let number = if self.bits > 8 { Number::U16 } else { Number::U8 };
        let plain = Plain::new(KIND, self.size, Places::Listed(places), number);
        Plain { white: Some(range), is_encoded: self.has_colour, times, taken, ..plain }
    }
}

/// Pixels of a pixel of colour (across, down), `None` for a film without; and bits of a sample.
fn planes_of(colours: &str) -> Option<(Option<(u64, u64)>, u32)> {
    let bits = |text: &str| text.parse::<u32>().ok().filter(|bits| (9..=16).contains(bits));
    if let Some(depth) = colours.strip_prefix("mono") {
        return Some((None, if depth.is_empty() { 8 } else { bits(depth)? }));
    }
    let (subsampling, rest) = (colours.get(..3)?, colours.get(3..)?);
    let chroma = match subsampling {
        "420" => (2, 2),
        "411" => (4, 1),
        "422" => (2, 1),
        "440" => (1, 2),
        "444" => (1, 1),
        _ => return None,
    };
    match rest {
        "" | "jpeg" | "paldv" | "mpeg2" | "alpha" => Some((Some(chroma), 8)),
        _ => Some((Some(chroma), bits(rest.strip_prefix('p')?)?)),
    }
}

fn line(path: &Path, reader: &mut impl BufRead) -> Result<Vec<u8>> {
    let mut line = Vec::new();
    reader.take(MAX_LINE_BYTES).read_until(b'\n', &mut line).map_err(|e| Error::from_read(path, KIND, &e))?;
    let is_whole = line.pop() == Some(b'\n');
    if is_whole { Ok(line) } else { Err(Error::corrupt(path, KIND, "a line of text in it does not end")) }
}

pub(super) struct Y4m;

impl Numbers for Y4m {
    const MAGIC: Option<&'static [u8]> = Some(b"YUV4MPEG2 ");

    fn record(&self) -> Record {
        let opens = "luma of mono, 4:2:0, 4:2:2, 4:4:4 films of 8 to 16 bits, as it is stored";
        Record { name: KIND, rank: Rank::Film, extensions: &["y4m"], opens, options: "" }
    }

    fn plain(&self, input: Input, path: &Path, options: &OpenOptions) -> Result<Plain> {
        let fail = |e: io::Error| Error::from_read(path, KIND, &e);
        let mut reader = BufReader::with_capacity(256, input.file);
        let film = Film::read(path, &mut reader)?;
        let (width, height) = (film.size.0 as u64, film.size.1 as u64);
        options.limits.check_frame(path, width, height)?;
        let mut places = Vec::new();
        // Lines of frames may have parameters, so frames are not evenly spaced: each line is visited.
        while Film::next_frame(path, &mut reader)? {
            let place = reader.stream_position().map_err(fail)?;
            if input.length.saturating_sub(place) < film.frame_bytes {
                return Err(Error::corrupt(path, KIND, format!("it ends within frame {}", places.len())));
            }
            places.push(place);
            options.limits.check_burst(path, places.len() as u64, width, height)?;
            reader.seek(SeekFrom::Start(place + film.frame_bytes)).map_err(fail)?;
        }
        if places.is_empty() { Err(Error::corrupt(path, KIND, "it has no frame")) } else { Ok(film.plain(places)) }
    }
}
