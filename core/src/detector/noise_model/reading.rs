//! Single pass over the frames that are examined closely, row by row: pyramids of means over squares of 2, 4, 8 …
//! pixels and, for the sensor's pattern, the means of lines, and pixels that stand out of their row.

use crate::monitor::{Cancelled, Monitor};
use crate::plane::{Plane, halve_pair};
use multiversion::multiversion;
use rayon::prelude::*;
use std::ops::Range;

/// Number of bands into which an image is cut along each axis.
pub const BANDS: usize = 8;

#[derive(Debug, Clone, Default)]
pub struct Reading {
    pub pyramids: Vec<BoxPyramid>,
    /// Column and row of each pixel that stands out of its row in the mean of the frames, row by row.
    pub standing_out: Vec<(usize, usize)>,
    /// By frame; empty unless the pattern's data was read.
    pub columns: Vec<Lines>,
    pub rows: Vec<Lines>,
}

/// Means of the lines (columns or rows) of a frame, one list for each of [`BANDS`] bands across them.
pub type Lines = Vec<Vec<f32>>;

pub fn lines_of(frame: &Plane) -> [Lines; 2] {
    let mut found = Reading::default();
    found.add_lines(cuts(frame.height()).into_iter().map(|rows| {
        let mut band = Band::empty(1, frame.width(), rows.len());
        rows.clone().for_each(|v| band.add_row(0, frame.row(v)));
        band.finished(rows.len())
    }));
    [found.columns.swap_remove(0), found.rows.swap_remove(0)]
}

/// Bands of rows of an image; each begins at an even row, so that pairs of rows stay together.
fn cuts(height: usize) -> Vec<Range<usize>> {
    let cut = |i: usize| if i == BANDS { height } else { i * height / BANDS / 2 * 2 };
    (0..BANDS).map(|i| cut(i)..cut(i + 1)).collect()
}

struct Band {
    standing_out: Vec<(usize, usize)>,
    columns: Vec<Vec<f32>>,
    rows: Vec<Lines>,
}

impl Reading {
    /// Reads `frames` of one size (at least 2×2 pixels) into pyramids of `count` levels; with `stands_out`, from at
    /// least two frames, also the pattern's data and the pixels whose mean differs by more from both beside.
    pub fn new(frames: &[&Plane], count: usize, stands_out: Option<f32>, monitor: &Monitor) -> Result<Self, Cancelled> {
        let (width, height) = frames[0].size();
        let bands = cuts(height);
        let mut halved: Vec<Plane> = frames.iter().map(|_| Plane::zeros(width / 2, height / 2)).collect();
        let mut parts: Vec<Vec<&mut [f32]>> = bands.iter().map(|_| Vec::with_capacity(frames.len())).collect();
        // Bands write disjoint parts of the halved frames, so that threads need no lock.
        for plane in &mut halved {
            let mut rest = plane.data_mut();
            for (part, band) in parts.iter_mut().zip(&bands) {
                let (mine, others) = rest.split_at_mut((band.end / 2 - band.start / 2) * (width / 2));
                part.push(mine);
                rest = others;
            }
        }
        let read = |(rows, mut halved): (Range<usize>, Vec<&mut [f32]>)| {
            monitor.check()?;
            for (frame, out) in frames.iter().zip(&mut halved).filter(|_| stands_out.is_none()) {
                let pairs = rows.clone().step_by(2).zip(out.chunks_exact_mut(width / 2));
                pairs.for_each(|(v, out)| halve_pair(frame.row(v), frame.row(v + 1), out));
            }
            Ok(stands_out.map(|limit| Band::new(frames, rows, &mut halved, limit)))
        };
        let found: Vec<Option<Band>> = bands.into_par_iter().zip(parts).map(read).collect::<Result<_, Cancelled>>()?;
        let mut reading = Self::default();
        reading.add_lines(found.into_iter().flatten());
        reading.pyramids = halved.into_par_iter().map(|plane| BoxPyramid::from_halved(plane, count)).collect();
        Ok(reading)
    }

    fn add_lines(&mut self, bands: impl Iterator<Item = Band>) {
        for band in bands {
            self.standing_out.extend(band.standing_out);
            self.columns.resize(band.columns.len(), Vec::new());
            self.rows.resize(band.rows.len(), vec![Vec::new(); BANDS]);
            self.columns.iter_mut().zip(band.columns).for_each(|(all, columns)| all.push(columns));
            for (all, of_band) in self.rows.iter_mut().zip(band.rows) {
                all.iter_mut().zip(of_band).for_each(|(all, rows)| all.extend(rows));
            }
        }
    }
}

impl Band {
    fn empty(frames: usize, width: usize, rows: usize) -> Self {
        let of_rows = [(); BANDS].map(|()| Vec::with_capacity(rows)).to_vec();
        Self { standing_out: Vec::new(), columns: vec![vec![0.0; width]; frames], rows: vec![of_rows; frames] }
    }

    fn add_row(&mut self, frame: usize, row: &[f32]) {
        add(&mut self.columns[frame], row);
        for (i, out) in self.rows[frame].iter_mut().enumerate() {
            let part = &row[i * row.len() / BANDS..(i + 1) * row.len() / BANDS];
            out.push(sum_of(part) / part.len().max(1) as f32);
        }
    }

    fn finished(mut self, rows: usize) -> Self {
        let scale = 1.0 / rows.max(1) as f32;
        self.columns.iter_mut().flatten().for_each(|sum| *sum *= scale);
        self
    }

    fn new(frames: &[&Plane], rows: Range<usize>, halved: &mut [&mut [f32]], limit: f32) -> Self {
        let width = frames[0].width();
        let mut band = Self::empty(frames.len(), width, rows.len());
        let mut all = vec![0.0f32; width];
        let limit = limit * frames.len() as f32;
        for v in rows.clone() {
            all.fill(0.0);
            for (t, frame) in frames.iter().enumerate() {
                add(&mut all, frame.row(v));
                band.add_row(t, frame.row(v));
            }
            note_standing_out(&all, v, limit, &mut band.standing_out);
            // The pair of rows is still in the first-level cache.
            if v % 2 == 1 {
                let at = (v - rows.start) / 2 * (width / 2);
                for (frame, out) in frames.iter().zip(halved.iter_mut()) {
                    halve_pair(frame.row(v - 1), frame.row(v), &mut out[at..at + width / 2]);
                }
            }
        }
        band.finished(rows.len())
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn add(sums: &mut [f32], row: &[f32]) {
    sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn sum_of(values: &[f32]) -> f32 {
    // Sixteen partial sums: a single one fixes an order of additions that vector lanes cannot follow.
    let (parts, rest) = values.as_chunks::<16>();
    let mut sums = [0.0f32; 16];
    for part in parts {
        for (sum, x) in sums.iter_mut().zip(part) {
            *sum += x;
        }
    }
    sums.iter().sum::<f32>() + rest.iter().sum::<f32>()
}

/// Whether a pixel differs from both pixels beside it by more than `limit` to the same side.
#[inline(always)]
fn is_out(left: f32, at: f32, right: f32, limit: f32) -> bool {
    (at > left.max(right) + limit) | (at < left.min(right) - limit)
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn any_out(row: &[f32], limit: f32) -> bool {
    let n = row.len() - 2;
    let (left, at, right) = (&row[..n], &row[1..n + 1], &row[2..n + 2]);
    let mut any = 0u32;
    for i in 0..n {
        any |= u32::from(is_out(left[i], at[i], right[i], limit));
    }
    any != 0
}

fn note_standing_out(row: &[f32], v: usize, limit: f32, out: &mut Vec<(usize, usize)>) {
    let n = row.len();
    if n < 3 {
        return;
    }
    // A pixel at an end has one neighbour, which stands for both.
    if is_out(row[1], row[0], row[1], limit) {
        out.push((0, v));
    }
    if any_out(row, limit) {
        out.extend((1..n - 1).filter(|&u| is_out(row[u - 1], row[u], row[u + 1], limit)).map(|u| (u, v)));
    }
    if is_out(row[n - 2], row[n - 1], row[n - 2], limit) {
        out.push((n - 1, v));
    }
}

/// A frame's means over squares of 2, 4, 8 … pixels, without overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxPyramid {
    levels: Vec<Plane>,
}

impl BoxPyramid {
    /// The means over squares of 2¹ … 2^`count` pixels, as far as both sides hold a whole square; the `first` always.
    pub(super) fn from_halved(first: Plane, count: usize) -> Self {
        let coarser = |finer: &Plane| (finer.width() >= 2 && finer.height() >= 2).then(|| finer.halved());
        Self { levels: std::iter::successors(Some(first), coarser).take(count.max(1)).collect() }
    }

    /// Means over squares of 2^`level` pixels, `level` from 1 on; the coarsest ones where the pyramid ends before.
    pub fn level(&self, level: usize) -> &Plane {
        &self.levels[(level - 1).min(self.levels.len() - 1)]
    }

    pub fn len(&self) -> usize {
        self.levels.len()
    }
}

/// Value of a pyramid's `plane` of squares of `square` px at the image's (u, v): bilinear, constant beyond the rim.
pub fn sample_at(plane: &Plane, square: f32, u: f32, v: f32) -> f32 {
    let split = |x: f32, n: usize| {
        let at = ((x + 0.5) / square - 0.5).clamp(0.0, n as f32 - 1.0);
        let whole = (at as usize).min(n.saturating_sub(2));
        (whole, at - whole as f32)
    };
    let ((x, fx), (y, fy)) = (split(u, plane.width()), split(v, plane.height()));
    let (right, below) = ((x + 1).min(plane.width() - 1), (y + 1).min(plane.height() - 1));
    let along = |y: usize| (1.0 - fx) * plane.at(x, y) + fx * plane.at(right, y);
    (1.0 - fy) * along(y) + fy * along(below)
}

/// Number of columns to each side in the mean from which an offset is measured: slower changes may be the scene.
pub const REACH: usize = 16;

pub(super) fn less_local_mean(values: &[f32]) -> Vec<f32> {
    let mut sums = vec![0.0f64];
    values.iter().for_each(|x| sums.push(sums[sums.len() - 1] + f64::from(*x)));
    (0..values.len())
        .map(|u| {
            let (start, end) = (u.saturating_sub(REACH), (u + REACH + 1).min(values.len()));
            values[u] - ((sums[end] - sums[start]) / (end - start) as f64) as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::random::Stream;

    #[test]
    fn one_reading_gives_what_single_looks_give() {
        let mut stream = Stream::new(2, 0);
        let mut frames = [(); 5].map(|()| Plane::from_fn(101, 75, |_, _| stream.normal() as f32));
        for frame in &mut frames {
            [(0, 3), (40, 40), (100, 74)].iter().for_each(|&(u, v)| frame.row_mut(v)[u] = 50.0);
        }
        let frames: Vec<&Plane> = frames.iter().collect();
        let reading = Reading::new(&frames, 4, Some(20.0), &Monitor::default()).expect("not cancelled");
        assert_eq!(reading.standing_out, [(0, 3), (40, 40), (100, 74)]);
        let alone = Reading::new(&frames, 4, None, &Monitor::default()).expect("not cancelled");
        for ((pyramid, alone), frame) in reading.pyramids.iter().zip(&alone.pyramids).zip(&frames) {
            assert_eq!(*pyramid, BoxPyramid::from_halved(frame.halved(), 4));
            assert_eq!(pyramid, alone);
        }
        for (t, frame) in frames.iter().enumerate() {
            let mean = |columns: Range<usize>, rows: Range<usize>| {
                let count = (columns.len() * rows.len()) as f32;
                rows.map(|v| frame.row(v)[columns.clone()].iter().sum::<f32>()).sum::<f32>() / count
            };
            assert!((reading.columns[t][0][7] - mean(7..8, 0..8)).abs() < 1e-5);
            assert!((reading.columns[t][7][7] - mean(7..8, 64..75)).abs() < 1e-5);
            assert!((reading.rows[t][1][70] - mean(12..25, 70..71)).abs() < 1e-5);
            assert_eq!(reading.rows[t][1].len(), 75);
            assert_eq!(lines_of(frame), [reading.columns[t].clone(), reading.rows[t].clone()]);
        }
    }

    #[test]
    fn a_ramp_is_sampled_as_it_is_and_levels_end_where_no_square_fits() {
        let small = BoxPyramid::from_halved(Plane::zeros(6, 4), 9);
        assert_eq!((small.len(), small.level(1).size(), small.level(7).size()), (3, (6, 4), (1, 1)));
        let frame = Plane::from_fn(64, 48, |u, v| u as f32 + 2.0 * v as f32);
        let pyramid = BoxPyramid::from_halved(frame.halved(), 3);
        for (u, v) in [(20.0, 11.0), (3.5, 3.5), (41.25, 30.0)] {
            assert!((sample_at(pyramid.level(3), 8.0, u, v) - (u + 2.0 * v)).abs() < 1e-3);
        }
        assert!((sample_at(pyramid.level(3), 8.0, 0.0, 0.0) - (3.5 + 7.0)).abs() < 1e-3, "the nearest square");
        assert!(sample_at(pyramid.level(6), 64.0, 5.0, 5.0).is_finite());
    }
}
