//! Files without header, whose shape the user says.

use super::{Input, Numbers, Rank, Record, Start, named};
use crate::burst::layout::Dump as Shape;
use crate::burst::options::{Limits, OpenOptions};
use crate::burst::reading::plain::{Places, Plain};
use crate::burst::reading::{Reading, Ticker};
use crate::error::{Error, ErrorKind, Result};
use crate::{monitor::Monitor, plane::Plane};
use std::path::Path;

pub(super) const NAME: &str = "headerless";

pub(super) struct Dump;

impl Numbers for Dump {
    // A file may begin like another format by chance.
    const MAGIC: Option<&'static [u8]> = None;

    fn record(&self) -> Record {
        let opens = "frames one after the other, in one file or in several, of any name";
        let options = "`--raw 1600x1200:u16le+512`; without it the window shows the first frame in each likely shape, and in one that is typed, and the error of a command lists shapes that fill the file";
        Record { name: NAME, rank: Rank::Other, extensions: &["raw", "bin", "dat"], opens, options }
    }

    fn is_asked_for(&self, start: &Start<'_>, options: &OpenOptions) -> bool {
        options.raw.is_some() && named(start.path).is_none_or(|format| format.record().name == NAME)
    }

    fn plain(&self, input: Input, path: &Path, options: &OpenOptions) -> Result<Plain> {
        let dump = options.raw.ok_or_else(|| without_shape(path, input.length, &options.limits))?;
        let plain = plain(dump, input.length, path, &options.limits)?.0;
        let is_calibrated = options.black_level.is_some() || options.bias.is_some();
        let words = "a file without header says no black level, and what a camera adds to all values stays in them; --black-level or --bias takes it away";
        let is_told = !is_calibrated && dump.number.range().is_some_and(|white| white > 255.0);
        Ok(Plain { taken: is_told.then(|| words.to_owned()).into_iter().collect(), ..plain })
    }
}

/// The frames of a file of `length` bytes in the shape `dump`, and their number.
fn plain(dump: Shape, length: u64, path: &Path, limits: &Limits) -> Result<(Plain, u64)> {
    let there = length.saturating_sub(dump.skip);
    let step = dump.frame_bytes();
    let frames = there / step;
    if frames == 0 || !there.is_multiple_of(step) {
        let problem = format!("{there} bytes are no whole number of frames of {dump}, {step} bytes each");
        // The same frames behind a header of the bytes that are too many.
        let behind = Shape { skip: dump.skip + there % step, ..dump };
        return Err(refused(path, problem, (frames > 0).then_some((behind, frames)), length, limits));
    }
    let shape = (frames, dump.size.1 as u64, dump.size.0 as u64);
    let places = Plain::places_in(path, NAME, shape, (dump.skip, step, length), limits)?;
    Ok((Plain { big_endian: dump.big_endian, ..Plain::new(NAME, dump.size, places, dump.number) }, frames))
}

pub(super) fn without_shape(path: &Path, length: u64, limits: &Limits) -> Error {
    refused(path, "this file has no header that says its size".to_owned(), None, length, limits)
}

/// A shape that fills a file without header, with its first frame.
#[derive(Debug, Clone)]
pub struct LikelyShape {
    /// Size, type of the numbers and bytes to skip, as `--raw` takes them.
    pub dump: Shape,
    /// Number of frames that it gives.
    pub frames: u64,
    /// The first of them; its values are not calibrated.
    pub first: Plane,
    /// How much rows of it resemble the next ones, −1 to 1: near 0 where the width is wrong.
    pub likeness: f32,
}

fn length_of(path: &Path) -> Result<u64> {
    Ok(std::fs::metadata(path).map_err(|e| Error::from_read(path, NAME, &e))?.len())
}

/// Shapes of usual sensors that fill the file at `path`, best first by the likeness of neighbouring rows.
pub fn likely_shapes(path: &Path, limits: &Limits, monitor: &Monitor) -> Result<Vec<LikelyShape>> {
    let likely = Shape::likely(length_of(path)?, limits.max_frames as u64).into_iter();
    let mut shapes: Vec<_> = likely.filter_map(|(dump, _)| shape_of(path, dump, limits, monitor).ok()).collect();
    monitor.check()?;
    shapes.sort_by(|a, b| b.likeness.total_cmp(&a.likeness));
    Ok(shapes)
}

/// The shape `dump` of the file at `path`, with its first frame.
///
/// # Errors
/// A shape that does not fill the file, with those that would, and a file that cannot be read.
pub fn shape_of(path: &Path, dump: Shape, limits: &Limits, monitor: &Monitor) -> Result<LikelyShape> {
    let (plain, frames) = plain(dump, length_of(path)?, path, limits)?;
    // A wrong shape shows in the first frame already.
    let one = Plain { places: Places::Listed(vec![dump.skip]), ..plain };
    let read = one.stack(Reading::new(path, &OpenOptions::default(), &Ticker::new(monitor, 1)))?;
    let first = read.into_iter().next().ok_or_else(|| Error::corrupt(path, NAME, "it has no frame"))?.plane;
    Ok(LikelyShape { dump, frames, likeness: likeness_of_rows(&first), first })
}

/// Correlation of the upper half's rows with the next ones, less that with far rows; −1 for values of no camera. Where
/// rows repeat from left to right, as where each holds several of a narrower picture, half of it.
fn likeness_of_rows(plane: &Plane) -> f32 {
    let (width, height) = plane.size();
    // Bytes read as floats of a wrong type give tiny, infinite or undefined values.
    let sound = plane.data().iter().filter(|x| x.is_finite() && (x.abs() > 1e-20 || **x == 0.0)).count();
    if height < 4 || 10 * sound < 9 * width * height {
        return -1.0;
    }
    let correlation = |by: usize, shift: usize| {
        let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
        // Rows of the upper half, so that the row half a height below exists.
        for v in 0..height / 2 {
            let (a, b) = (&plane.row(v)[..width - shift], &plane.row(v + by)[shift..]);
            let mean = |row: &[f32]| row.iter().map(|x| f64::from(*x)).sum::<f64>() / row.len() as f64;
            let (mean_a, mean_b) = (mean(a), mean(b));
            for (x, y) in a.iter().zip(b) {
                let (x, y) = (f64::from(*x) - mean_a, f64::from(*y) - mean_b);
                (ab, aa, bb) = (ab + x * y, aa + x * x, bb + y * y);
            }
        }
        if aa * bb > 0.0 { (ab / (aa * bb).sqrt()) as f32 } else { 0.0 }
    };
    // Columns of a constant pattern correlate at any distance, in a wrong width too: far rows take that share away.
    let near = correlation(1, 0);
    let likeness = near - correlation(height / 2, 0).max(0.0);
    let repeats = |parts: usize| width.is_multiple_of(parts) && correlation(0, width / parts) > 0.8 * near;
    if likeness > 0.0 && [2, 3, 5].into_iter().any(repeats) { 0.5 * likeness } else { likeness }
}

/// Error with shapes that fill the file: `near` the said one, and usual ones.
fn refused(path: &Path, problem: String, near: Option<(Shape, u64)>, length: u64, limits: &Limits) -> Error {
    const FEW: usize = 6;
    let shapes: Vec<String> = near
        .into_iter()
        .chain(Shape::likely(length, limits.max_frames as u64))
        .take(FEW)
        .map(|(dump, frames)| match frames {
            1 => format!("{dump} (one frame)"),
            _ => format!("{dump} ({frames} frames)"),
        })
        .collect();
    let fitting = match &shapes[..] {
        [] => format!("no usual size fills its {length} bytes"),
        _ => format!("its {length} bytes would be {}", shapes.join(", ")),
    };
    let remedy = format!("say it with --raw WIDTHxHEIGHT:TYPE, such as --raw 1600x1200:u16le; {fitting}");
    Error::new(ErrorKind::NoShape, problem, remedy).about(path)
}
