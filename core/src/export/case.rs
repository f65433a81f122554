//! A case: a burst, or the part of it around a place, with the settings and the question about it, in one file.
//!
//! The file is a ZIP without compression of its own: `case.toml`, a 16-bit grey PNG for each frame (`frames/00000.png`
//! and on), and where there are some the frames' masks, the window's `session.toml` and the frames' `truth.json`.
//! Values are `offset + word·scale`; those of 8 and 16-bit files come back exactly, calibrated ones within rounding.
//! Reading is bounded: declared sizes are checked before frames are decoded, and no entry is read beyond these.

use super::atomic::write_marked;
use crate::burst::{Burst, Encoding, Limits, Positions};
use crate::detector::SearchParams;
use crate::error::{Error, ErrorKind, Result};
use crate::files::{self, MAX_SESSION_BYTES, MAX_SETTINGS_BYTES, mark::OutputKind};
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::{Mask, Plane, memory, tile::Region};
use crate::synth::{FeatureTruth, Truth};
use serde::{Deserialize, Serialize};
use std::io::{self, BufReader, Cursor, Write};
use std::{borrow::Cow, fs::File, path::Path, sync::Arc};
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

/// Ending of the names of cases.
pub const CASE_EXTENSION: &str = "burstcase";
const ABOUT: &str = "case.toml";
const SESSION: &str = "session.toml";
const TRUTH: &str = "truth.json";
const VERSION: u32 = 1;

/// Contents of a case beside its frames and settings.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Enclosed {
    /// Text of the window's session, which is of the case's frames.
    pub session: Option<String>,
    /// Truth of the frames: planted things, or the scene from which the frames were made.
    pub truth: Option<Truth>,
}

/// Settings, place and note of a case, and the form of its frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)] // where a name says it
pub struct Case {
    /// Version of the format: 1.
    pub version: u32,
    pub name: String,
    #[serde(default)]
    pub note: String,
    /// The place that is asked about, pixels of the case's frames at mid-burst.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<[f32; 2]>,
    /// Column and row of the burst at which the case's frames begin.
    pub corner: [usize; 2],
    /// Columns and rows of the case's frames.
    pub size: [usize; 2],
    pub frames: usize,
    /// Position of each frame from the first one, frame intervals; empty for even ones: 0, 1, 2, ….
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub times: Vec<f64>,
    /// Column and row of each view of a light field from the first one; empty for frames in time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub views: Vec<[f64; 2]>,
    /// Seconds of a frame interval, where they are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval_s: Option<f64>,
    /// Intensity of the word 0.
    pub offset: f64,
    /// Intensity of a step of one word.
    pub scale: f64,
    /// Smallest difference of the burst's files, fraction of full scale; 0 if unknown.
    pub quantisation_step: f32,
    /// File value that became intensity 1.
    pub full_scale: f32,
    /// Relation of the values to light.
    pub encoding: Encoding,
    /// Sensor pixels along a side of a pixel.
    pub binning: usize,
    /// Parameters of the search, and the choice of slopes.
    pub search: SearchParams,
}

mod bounds {
    use crate::detector::params::Bounds;
    use std::ops::Bound::{Excluded, Included};

    pub const PLACE: Bounds = Bounds::new((Included(-1e6), Included(1e6)), "a place is within 1000000 pixels");
    pub const CORNER: Bounds = Bounds::new((Included(0.0), Included(1e6)), "a corner is within 1000000 pixels");
    pub const COUNT: Bounds = Bounds::new((Included(1.0), Included(1e6)), "there are 1 to 1000000");
    pub const BINNING: Bounds = Bounds::new((Included(1.0), Included(64.0)), "there are 1 to 64");
    pub const OFFSET: Bounds = Bounds::new((Included(-1e30), Included(1e30)), "an offset is within 1e30");
    pub const SCALE: Bounds = Bounds::new((Excluded(0.0), Included(1e33)), "a scale is above 0 and up to 1e33");
    pub const STEP: Bounds = Bounds::new((Included(0.0), Included(1e33)), "a step is 0 to 1e33");
}

impl Case {
    /// This case for the weights of masks, from 0 to 1, in the place of values.
    fn of_weights(&self) -> Self {
        Self { offset: 0.0, scale: 1.0 / 65535.0, ..self.clone() }
    }

    /// A case of `burst`, or of the square of `around` pixels to each side of `place` in it, with the case's burst.
    pub fn of(
        burst: &Burst,
        search: &SearchParams,
        (place, around): (Option<[f32; 2]>, Option<usize>),
        note: &str,
        monitor: &Monitor,
    ) -> Result<(Self, Burst), Cancelled> {
        let (width, height) = burst.size();
        let whole = Region { columns: 0..width, rows: 0..height };
        let region = place.zip(around).map_or(whole, |(at, half)| Region::around(at, half, (width, height)));
        let (columns, rows) = (&region.columns, &region.rows);
        // Frames are shared: only a crop copies pixels.
        let mut part = burst.clone();
        if columns.len() < width || rows.len() < height {
            part.frames = burst.frames.iter().map(|frame| Arc::new(frame.part(&region))).collect();
        }
        // For the part alone, which may need fewer words than the whole burst.
        let (offset, scale) = words_of(&part, monitor)?;
        let case = Self {
            version: VERSION,
            name: burst.name.clone(),
            note: note.to_owned(),
            place: place.map(|[u, v]| [u - columns.start as f32, v - rows.start as f32]),
            corner: [columns.start, rows.start],
            size: [columns.len(), rows.len()],
            frames: burst.len(),
            times: burst.positions.list(),
            views: burst.positions.views(),
            interval_s: burst.positions.interval_s(),
            offset,
            scale,
            quantisation_step: burst.quantisation_step,
            full_scale: burst.full_scale,
            encoding: burst.encoding,
            binning: burst.binning,
            search: search.clone(),
        };
        Ok((case, part))
    }

    /// Bytes of the file, about: a 16-bit word for each pixel, which PNG seldom halves, and 8 KB for all else.
    pub fn estimated_bytes(&self) -> u64 {
        2 * self.size[0] as u64 * self.size[1] as u64 * self.frames as u64 + 8192
    }

    /// A file may hold anything.
    fn check(&self) -> Result<()> {
        for place in self.place.iter().flatten() {
            bounds::PLACE.check("place", f64::from(*place))?;
        }
        self.corner.iter().try_for_each(|&at| bounds::CORNER.check("corner", at as f64))?;
        self.size.iter().try_for_each(|&side| bounds::COUNT.check("size", side as f64))?;
        bounds::COUNT.check("frames", self.frames as f64)?;
        bounds::BINNING.check("binning", self.binning as f64)?;
        bounds::OFFSET.check("offset", self.offset)?;
        bounds::SCALE.check("scale", self.scale)?;
        bounds::SCALE.check("full_scale", f64::from(self.full_scale))?;
        bounds::STEP.check("quantisation_step", f64::from(self.quantisation_step))?;
        self.positions()?;
        self.search.validate()
    }

    fn positions(&self) -> Result<Positions> {
        let positions = Positions::of_lists(self.frames, &self.times, &self.views);
        let positions =
            positions.filter(|_| self.interval_s.is_none_or(|seconds| seconds.is_finite() && seconds > 0.0));
        let wrong = || match self.views.is_empty() {
            true => Error::param("times", "these are no times of the frames", "give one for each, in increasing order"),
            false => {
                Error::param("views", "these are no places of the frames", "give column and row of each, no two alike")
            }
        };
        Ok(positions.ok_or_else(wrong)?.with_interval(self.interval_s))
    }
}

/// Offset and scale of words: those of 8 and 16-bit files or of the full scale if exact, else the files' steps.
fn words_of(burst: &Burst, monitor: &Monitor) -> Result<(f64, f64), Cancelled> {
    // Values below masks are filled, and need not be exact.
    let values: Vec<Cow<'_, [f32]>> = burst.frames.iter().map(|frame| frame.seen_values()).collect();
    let rows = || values.iter().flat_map(|values| values.chunks(burst.size().0.max(1)));
    let all = |test: &dyn Fn(f32) -> bool| -> Result<bool, Cancelled> {
        for row in rows() {
            monitor.check()?;
            if !row.iter().copied().filter(|x| x.is_finite()).all(test) {
                return Ok(false);
            }
        }
        Ok(true)
    };
    // The step of 16-bit files holds 8-bit values too: 65535 is 255 · 257.
    for scale in [1.0 / 65535.0, 1.0 / f64::from(burst.full_scale)] {
        let holds = |x: f32| {
            let word = (f64::from(x) / scale).round();
            (0.0..=65535.0).contains(&word) && (word * scale) as f32 == x
        };
        if scale.is_finite() && scale > 0.0 && all(&holds)? {
            return Ok((0.0, scale));
        }
    }
    let (mut min, mut max) = (f32::INFINITY, f32::NEG_INFINITY);
    for row in rows() {
        monitor.check()?;
        let finite = row.iter().copied().filter(|x| x.is_finite());
        (min, max) = finite.fold((min, max), |(a, b), x| (a.min(x), b.max(x)));
    }
    let (min, max) = if min <= max { (f64::from(min), f64::from(max)) } else { (0.0, 1.0) };
    // Calibration shifts and stretches the files' steps, but keeps them even: a lattice.
    let step = f64::from(burst.quantisation_step);
    let on_lattice = |x: f32| {
        let steps = (f64::from(x) - min) / step;
        (steps - steps.round()).abs() < 0.02
    };
    if step > 0.0 && (max - min) / step <= 65535.5 && all(&on_lattice)? {
        return Ok((min, step));
    }
    // No common step: the whole range is divided, and values are within half a word.
    Ok((min, ((max - min) / 65535.0).max(f64::MIN_POSITIVE)))
}

impl Truth {
    /// The truth of the part of a burst that a case holds: what is centred in it at mid-burst, at its places there.
    pub fn within(&self, case: &Case) -> Self {
        let [corner_u, corner_v] = case.corner.map(|at| at as f64);
        let [width, height] = case.size;
        let features =
            self.features.iter().map(|one| FeatureTruth { u: one.u - corner_u, v: one.v - corner_v, ..*one });
        let is_inside = |x: f64, n: usize| x >= -0.5 && x < n as f64 - 0.5;
        // Half a pixel beyond the outer centres the picture ends.
        let features = features.filter(|one| is_inside(one.u, width) && is_inside(one.v, height)).collect();
        Self { width, height, features, ..self.clone() }
    }
}

/// Writes a case; `burst` has its frames.
pub fn write_case(path: &Path, (case, burst): (&Case, &Burst), enclosed: &Enclosed, monitor: &Monitor) -> Result<()> {
    let about = toml::to_string(case).expect("a case is plain values, which TOML can always hold");
    let truth = enclosed.truth.as_ref().map(|truth| truth.within(case));
    let truth = truth.map(|truth| serde_json::to_string(&truth).expect("a truth is plain values"));
    let texts = [(ABOUT, Some(about)), (SESSION, enclosed.session.clone()), (TRUTH, truth)];
    let texts = texts.into_iter().filter_map(|(name, text)| Some(Ok((name.to_owned(), text?.into_bytes()))));
    let frames = burst.frames.iter().enumerate().map(|(t, frame)| {
        monitor.report(Stage::Write, t as f32 / burst.len() as f32);
        Ok((frame_name(t), encoded(frame, case, monitor)?))
    });
    let weights = case.of_weights();
    // Masks may be soft: their weights are stored as words over the whole range, whatever scale the values have.
    let masks = burst.frames.iter().enumerate().filter_map(|(t, frame)| Some((t, frame.mask()?)));
    let masks = masks.map(|(t, mask)| Ok((mask_name(t), encoded(mask.weights(), &weights, monitor)?)));
    write_marked(path, OutputKind::Case, |out| out.write_all(&zipped(texts.chain(frames).chain(masks))?))
}

/// A ZIP of entries, each with its name. In memory, because an entry's size and sum come before its bytes.
fn zipped(entries: impl Iterator<Item = io::Result<(String, Vec<u8>)>>) -> io::Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for entry in entries {
        let (name, bytes) = entry?;
        zip.start_file(name, stored).map_err(io::Error::other)?;
        zip.write_all(&bytes)?;
    }
    Ok(zip.finish().map_err(io::Error::other)?.into_inner())
}

fn frame_name(t: usize) -> String {
    format!("frames/{t:05}.png")
}

fn mask_name(t: usize) -> String {
    format!("masks/{t:05}.png")
}

fn encoded(frame: &Plane, case: &Case, monitor: &Monitor) -> io::Result<Vec<u8>> {
    let word =
        |&x: &f32| (((f64::from(x) - case.offset) / case.scale).round().clamp(0.0, 65535.0) as u16).to_be_bytes();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, case.size[0] as u32, case.size[1] as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    let mut rows = writer.stream_writer().map_err(io::Error::other)?;
    for row in frame.data().chunks(frame.width().max(1)) {
        monitor.check().map_err(io::Error::other)?;
        rows.write_all(&row.iter().flat_map(word).collect::<Vec<u8>>())?;
    }
    rows.finish().map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)?;
    Ok(bytes)
}

/// Whether `path` is named as a case.
pub fn is_case(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(CASE_EXTENSION))
}

/// Reads a case without its frames.
pub fn read_about(path: &Path) -> Result<Case> {
    about(path, &mut opened(path)?)
}

/// Reads a case and its frames.
pub fn read_case(path: &Path, limits: &Limits, monitor: &Monitor) -> Result<(Case, Burst)> {
    let mut zip = opened(path)?;
    let case = about(path, &mut zip)?;
    let [width, height] = case.size;
    // Checked by the declared numbers: no frame is decoded of a case that no memory holds.
    limits
        .check_frame(path, width as u64, height as u64)
        .and_then(|()| limits.check_burst(path, case.frames as u64, width as u64, height as u64))
        .map_err(|error| invalid(path, error.to_string()))?;
    // The number of frames is within the limits: room may be made.
    let mut frames = Vec::with_capacity(case.frames);
    for t in 0..case.frames {
        monitor.check()?;
        monitor.report(Stage::Open, t as f32 / case.frames as f32);
        let (plane, mask) = (frame(path, &mut zip, &case, &frame_name(t))?, mask_name(t));
        // A case of a burst without masks has no such entries.
        let has_mask = zip.index_for_name(&mask).is_some();
        let weights = has_mask.then(|| frame(path, &mut zip, &case.of_weights(), &mask)).transpose()?;
        frames.push(plane.masked(weights.and_then(Mask::new)));
    }
    let burst = Burst {
        positions: case.positions()?,
        frame_names: (0..frames.len()).map(frame_name).collect(),
        full_scale: case.full_scale,
        quantisation_step: case.quantisation_step,
        encoding: case.encoding,
        binning: case.binning,
        sources: vec![path.to_owned()],
        ..Burst::from_planes(case.name.clone(), frames)
    };
    Ok((case, burst))
}

/// Reads the text of a case's session; `None` where it has none.
pub fn read_session(path: &Path) -> Result<Option<String>> {
    text(path, &mut opened(path)?, SESSION, MAX_SESSION_BYTES)
}

/// Reads the truth of a case's frames; `None` where it has none.
pub fn read_truth(path: &Path) -> Result<Option<Truth>> {
    let text = text(path, &mut opened(path)?, TRUTH, MAX_SESSION_BYTES)?;
    let Some(text) = text else { return Ok(None) };
    let wrong = |problem: String| invalid(path, format!("{TRUTH}: {problem}"));
    let truth: Truth = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    truth.check().map_err(wrong)?;
    Ok(Some(truth))
}

/// Whether a case has the truth of its frames; its contents are not read.
pub fn has_truth(path: &Path) -> bool {
    opened(path).is_ok_and(|zip| zip.index_for_name(TRUTH).is_some())
}

/// The text of an entry, of which there may be `limit` bytes at most; `None` where there is no such entry.
fn text(path: &Path, zip: &mut Zip, name: &str, limit: u64) -> Result<Option<String>> {
    if zip.index_for_name(name).is_none() {
        return Ok(None);
    }
    let bytes = entry(path, zip, name, limit)?;
    String::from_utf8(bytes).map(Some).map_err(|_| invalid(path, format!("{name} is no text")))
}

fn invalid(path: &Path, problem: impl ToString) -> Error {
    let problem = format!("not a case that can be opened: {}", problem.to_string());
    Error::new(ErrorKind::Content, problem, "give a file that 'burstscope case' or Save case wrote").about(path)
}

type Zip = ZipArchive<BufReader<File>>;

fn opened(path: &Path) -> Result<Zip> {
    let file = files::open(path).map_err(|error| invalid(path, error))?;
    ZipArchive::new(BufReader::new(file)).map_err(|error| invalid(path, error))
}

fn entry(path: &Path, zip: &mut Zip, name: &str, limit: u64) -> Result<Vec<u8>> {
    let entry = zip.by_name(name).map_err(|error| invalid(path, format!("{name}: {error}")))?;
    // The declared size is no promise.
    let bytes = files::next_bytes(entry, limit + 1).map_err(|error| invalid(path, format!("{name}: {error}")))?;
    if bytes.len() as u64 > limit {
        return Err(invalid(path, format!("{name} is larger than {limit} bytes")));
    }
    Ok(bytes)
}

fn about(path: &Path, zip: &mut Zip) -> Result<Case> {
    let text = text(path, zip, ABOUT, MAX_SETTINGS_BYTES)?;
    let text = text.ok_or_else(|| invalid(path, format!("there is no {ABOUT}")))?;
    let wrong = |problem: String| invalid(path, format!("{ABOUT}: {problem}"));
    let case: Case = toml::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    if case.version != VERSION {
        return Err(wrong("its version is not 1".to_owned()));
    }
    case.check().map_err(|error| wrong(error.to_string()))?;
    Ok(case)
}

fn frame(path: &Path, zip: &mut Zip, case: &Case, name: &str) -> Result<Plane> {
    let [width, height] = case.size;
    let words = 2 * width as u64 * height as u64;
    // A PNG of random words is hardly larger than these.
    let bytes = entry(path, zip, name, words + words / 64 + (1 << 16))?;
    let wrong = |problem: String| invalid(path, format!("{name}: {problem}"));
    // A small picture may declare rows of gigabytes.
    let limits = png::Limits { bytes: words as usize + (1 << 20) };
    let mut reader = png::Decoder::new_with_limits(Cursor::new(bytes), limits)
        .read_info()
        .map_err(|error| wrong(error.to_string()))?;
    let info = reader.info();
    let is_grey = (info.color_type, info.bit_depth) == (png::ColorType::Grayscale, png::BitDepth::Sixteen);
    if !is_grey || (info.width as usize, info.height as usize) != (width, height) {
        return Err(wrong(format!("not a 16-bit grey PNG of {width}×{height} pixels")));
    }
    let mut words: Vec<u8> = memory::zeroed(2 * width * height);
    reader.next_frame(&mut words).map_err(|error| wrong(error.to_string()))?;
    let value = |pair: &[u8]| (case.offset + f64::from(u16::from_be_bytes([pair[0], pair[1]])) * case.scale) as f32;
    Ok(Plane::from_vec(width, height, words.chunks_exact(2).map(value).collect()))
}
