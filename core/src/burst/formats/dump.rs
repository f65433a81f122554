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
        let options = "`--raw 1600x1200:u16le+512`; without it the window shows the first frame in each likely shape to choose from, and the error of a command lists them";
        Record { name: NAME, rank: Rank::Other, extensions: &["raw", "bin", "dat"], opens, options }
    }

    fn is_asked_for(&self, start: &Start<'_>, options: &OpenOptions) -> bool {
        options.raw.is_some() && named(start.path).is_none_or(|format| format.record().name == NAME)
    }

    fn plain(&self, input: Input, path: &Path, options: &OpenOptions) -> Result<Plain> {
        let (length, limits) = (input.length, &options.limits);
        let Some(dump) = options.raw else { return Err(without_shape(path, length, limits)) };
        let there = length.saturating_sub(dump.skip);
        let step = dump.frame_bytes();
        let frames = there / step;
        if frames == 0 || !there.is_multiple_of(step) {
            let problem = format!("{there} bytes are no whole number of frames of {dump}, {step} bytes each");
            return Err(refused(path, problem, length, limits));
        }
        let shape = (frames, dump.size.1 as u64, dump.size.0 as u64);
        let places = Plain::places_in(path, NAME, shape, (dump.skip, step, length), limits)?;
        Ok(Plain { big_endian: dump.big_endian, ..Plain::new(NAME, dump.size, places, dump.number) })
    }
}

pub(super) fn without_shape(path: &Path, length: u64, limits: &Limits) -> Error {
    refused(path, "this file has no header that says its size".to_owned(), length, limits)
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

/// Shapes of usual sensors that fill the file at `path`, best first by the likeness of neighbouring rows.
pub fn likely_shapes(path: &Path, limits: &Limits, monitor: &Monitor) -> Result<Vec<LikelyShape>> {
    let length = std::fs::metadata(path).map_err(|e| Error::from_read(path, NAME, &e))?.len();
    let options = OpenOptions::default();
    let mut shapes = Vec::new();
    let ticker = Ticker::new(monitor, 1);
    for (dump, frames) in Shape::likely(length, limits.max_frames as u64) {
        let Shape { size, number, skip, .. } = dump;
        let one = Plain::new(NAME, size, Places::Listed(vec![skip]), number);
        // A wrong shape shows in the first frame already.
        let Some(frame) = one.stack(Reading::new(path, &options, &ticker))?.into_iter().next() else { continue };
        let likeness = likeness_of_rows(&frame.plane);
        shapes.push(LikelyShape { dump, frames, first: frame.plane, likeness });
    }
    shapes.sort_by(|a, b| b.likeness.total_cmp(&a.likeness));
    Ok(shapes)
}

/// Correlation of the upper half's rows with the next ones, less that with far rows; −1 for values of no camera.
fn likeness_of_rows(plane: &Plane) -> f32 {
    let (width, height) = plane.size();
    // Bytes read as floats of a wrong type give tiny, infinite or undefined values.
    let sound = plane.data().iter().filter(|x| x.is_finite() && (x.abs() > 1e-20 || **x == 0.0)).count();
    if height < 4 || 10 * sound < 9 * width * height {
        return -1.0;
    }
    let correlation = |by: usize| {
        let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
        // Rows of the upper half, so that the row half a height below exists.
        for v in 0..height / 2 {
            let (a, b) = (plane.row(v), plane.row(v + by));
            let mean = |row: &[f32]| row.iter().map(|x| f64::from(*x)).sum::<f64>() / width as f64;
            let (mean_a, mean_b) = (mean(a), mean(b));
            for (x, y) in a.iter().zip(b) {
                let (x, y) = (f64::from(*x) - mean_a, f64::from(*y) - mean_b);
                (ab, aa, bb) = (ab + x * y, aa + x * x, bb + y * y);
            }
        }
        if aa * bb > 0.0 { (ab / (aa * bb).sqrt()) as f32 } else { 0.0 }
    };
    // Columns of a constant pattern correlate at any distance, in a wrong width too: far rows take that share away.
    correlation(1) - correlation(height / 2).max(0.0)
}

fn refused(path: &Path, problem: String, length: u64, limits: &Limits) -> Error {
    const FEW: usize = 6;
    let likely = Shape::likely(length, limits.max_frames as u64);
    let shapes: Vec<String> = likely
        .iter()
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
