//! Single pass over the frames that are examined closely: computes everything that needs all of their pixels.
//!
//! Frames come from memory row by row. Each pair of rows goes into the pyramids and, for the sensor's pattern, into the
//! sums of the first and of the second half of the frames: these are added up by columns and by rows, and pixels that
//! stand out of their row are listed.

use super::pyramid::{BoxPyramid, halve_rows};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;
use std::ops::Range;

/// Number of bands into which an image is cut along each axis.
pub const BANDS: usize = 8;

/// Results of the pass.
#[derive(Debug, Clone, Default)]
pub struct Reading {
    /// Pyramids of the frames.
    pub pyramids: Vec<BoxPyramid>,
    /// Column and row of each pixel that stands out of its row in the mean of the frames, row by row.
    pub standing_out: Vec<(usize, usize)>,
    /// For each half of the frames, the means of each column over each of [`BANDS`] bands of rows.
    pub columns: [Vec<Vec<f32>>; 2],
    /// For each half of the frames, the means of each row over each of [`BANDS`] bands of columns.
    pub rows: [Vec<Vec<f32>>; 2],
}

/// Results of one band of rows.
struct Band {
    standing_out: Vec<(usize, usize)>,
    columns: [Vec<f32>; 2],
    /// Values by band of columns, one a row.
    rows: [Vec<Vec<f32>>; 2],
}

impl Reading {
    /// Reads `frames` of one size (at least one, of at least 2×2 pixels) into pyramids of `levels` levels. With
    /// `stands_out`, the data for finding the sensor's pattern is read as well, and pixels are listed whose mean over
    /// the frames differs from those beside them by more than it; this needs at least two frames.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` was cancelled.
    pub fn new(
        frames: &[&Plane],
        levels: usize,
        stands_out: Option<f32>,
        monitor: &Monitor,
    ) -> Result<Self, Cancelled> {
        let (width, height) = frames[0].size();
        let cuts: Vec<usize> =
            (0..=BANDS).map(|i| if i == BANDS { height } else { i * height / BANDS / 2 * 2 }).collect();
        let bands: Vec<Range<usize>> = cuts.windows(2).map(|w| w[0]..w[1]).collect();
        let mut halved: Vec<Plane> = frames.iter().map(|_| Plane::zeros(width / 2, height / 2)).collect();
        let mut parts: Vec<Vec<&mut [f32]>> = bands.iter().map(|_| Vec::with_capacity(frames.len())).collect();
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
                halve_rows(frame, rows.clone(), out);
            }
            Ok(stands_out.map(|limit| Band::new(frames, rows, &mut halved, limit)))
        };
        let found: Vec<Option<Band>> = bands.into_par_iter().zip(parts).map(read).collect::<Result<_, Cancelled>>()?;
        let mut reading = Self::default();
        reading.rows.iter_mut().for_each(|half| half.resize(BANDS, Vec::new()));
        for band in found.into_iter().flatten() {
            reading.standing_out.extend(band.standing_out);
            for ((all, of_band), columns) in
                reading.rows.iter_mut().zip(band.rows).zip(band.columns.into_iter().enumerate())
            {
                all.iter_mut().zip(of_band).for_each(|(all, rows)| all.extend(rows));
                reading.columns[columns.0].push(columns.1);
            }
        }
        reading.pyramids = halved.into_par_iter().map(|plane| BoxPyramid::from_halved(plane, levels)).collect();
        Ok(reading)
    }
}

impl Band {
    fn new(frames: &[&Plane], rows: Range<usize>, halved: &mut [&mut [f32]], limit: f32) -> Self {
        let width = frames[0].width();
        let (first, second) = frames.split_at(frames.len() / 2);
        let mut band = Self {
            standing_out: Vec::new(),
            columns: [vec![0.0; width], vec![0.0; width]],
            rows: [(); 2].map(|()| [(); BANDS].map(|()| Vec::with_capacity(rows.len())).to_vec()),
        };
        let (mut sums, mut all) = (vec![0.0f32; width], vec![0.0f32; width]);
        let limit = limit * frames.len() as f32;
        for v in rows.clone() {
            all.fill(0.0);
            for (index, half) in [first, second].into_iter().enumerate() {
                sums.fill(0.0);
                half.iter().for_each(|frame| add(&mut sums, frame.row(v)));
                add(&mut band.columns[index], &sums);
                add(&mut all, &sums);
                for (i, out) in band.rows[index].iter_mut().enumerate() {
                    let part = &sums[i * width / BANDS..(i + 1) * width / BANDS];
                    out.push(sum_of(part) / (part.len() * half.len()).max(1) as f32);
                }
            }
            note_standing_out(&all, v, limit, &mut band.standing_out);
            // The pair of rows is still in the first-level cache.
            if v % 2 == 1 {
                let at = (v - rows.start) / 2 * (width / 2);
                for (frame, out) in frames.iter().zip(halved.iter_mut()) {
                    halve_rows(frame, v - 1..v + 1, &mut out[at..at + width / 2]);
                }
            }
        }
        for (columns, count) in band.columns.iter_mut().zip([first.len(), second.len()]) {
            let scale = 1.0 / (rows.len() * count).max(1) as f32;
            columns.iter_mut().for_each(|sum| *sum *= scale);
        }
        band
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn add(sums: &mut [f32], row: &[f32]) {
    sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
}

/// Sum by sixteen independent partial sums.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn sum_of(values: &[f32]) -> f32 {
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

/// Whether any pixel of `row` except the first and the last differs so from its neighbours.
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

/// Appends the pixels of row `v` that stand out; nearly none do.
fn note_standing_out(row: &[f32], v: usize, limit: f32, out: &mut Vec<(usize, usize)>) {
    let n = row.len();
    if n < 3 {
        return;
    }
    // Pixels at the ends have one neighbour.
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
            assert_eq!(*pyramid, BoxPyramid::new(frame, 4));
            assert_eq!(pyramid, alone);
        }
        let halves = [&frames[..2], &frames[2..]];
        for (half, frames) in halves.iter().enumerate() {
            let mean = |columns: Range<usize>, rows: Range<usize>| {
                let count = (columns.len() * rows.len() * frames.len()) as f32;
                let row = |frame: &Plane, v: usize| frame.row(v)[columns.clone()].iter().sum::<f32>();
                frames.iter().map(|f| rows.clone().map(|v| row(f, v)).sum::<f32>()).sum::<f32>() / count
            };
            assert!((reading.columns[half][0][7] - mean(7..8, 0..8)).abs() < 1e-5);
            assert!((reading.columns[half][7][7] - mean(7..8, 64..75)).abs() < 1e-5);
            assert!((reading.rows[half][1][70] - mean(12..25, 70..71)).abs() < 1e-5);
            assert_eq!(reading.rows[half][1].len(), 75);
        }
    }
}
