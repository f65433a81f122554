//! One octave of the search: where its first level comes from, and the strips of its levels.
//!
//! For the first octave the first level is made from the frames: stacked at a slope, brought to the octave's resolution and blurred. Later octaves
//! start from planes that the octave before left behind, one for each slope. Everything is made in strips of rows; a strip carries the rows
//! above and below that its blurs need, so each row has the same bits whatever the strips.

use super::motion::{FrameOffset, stack_row};
use super::scale_space::ScaleSpace;
use crate::plane::Plane;
use crate::plane::blur::{blur_rows, subtract_rows};
use crate::plane::rows::{RowSource, Rows};
use std::ops::Range;

/// Where the first level (s = −1) of an octave at one slope comes from.
#[derive(Debug)]
pub enum Base<'a> {
    /// The frames, shifted by a slope's offsets: for the first octave.
    Frames {
        /// Frames of one size, in time order.
        frames: &'a [&'a Plane],
        /// [`super::motion::frame_offsets`] of the slope.
        offsets: &'a [FrameOffset],
        /// The octave, which is the first one.
        octave: i32,
    },
    /// The finished first level, on the octave's pixels.
    Level(&'a Plane),
}

/// Scratch space for the strips of one slope; reused, so that the search does not allocate per strip.
#[derive(Debug, Default)]
pub struct StripScratch {
    raw: Rows,
    stacked: Vec<f32>,
    padded: Vec<f32>,
    levels: Vec<Rows>,
}

/// A strip of the DoG levels −1 … S of one slope (index 0 is level −1).
#[derive(Debug, Default)]
pub struct DogStrip {
    /// One strip a level.
    pub levels: Vec<Rows>,
}

/// `range` widened by `by` rows and clamped to an image of `height` rows.
pub fn widened(range: &Range<usize>, by: usize, height: usize) -> Range<usize> {
    range.start.saturating_sub(by)..(range.end + by).min(height)
}

impl Base<'_> {
    /// Rows `rows` and columns `columns` of the stacked image at the octave's resolution, before any blur. Each written by `write(v, row)`.
    pub(super) fn raw_rows(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
        stacked: &mut Vec<f32>,
        mut write: impl FnMut(usize, &[f32]),
    ) {
        let Self::Frames { frames, offsets, octave } = self else {
            unreachable!("a finished level has no raw rows");
        };
        let (width_image, height_image) = frames[0].size();
        match octave {
            0 => {
                stacked.resize(columns.len(), 0.0);
                for v in rows {
                    stack_row(frames, offsets, v, columns.clone(), stacked);
                    write(v, stacked);
                }
            }
            -1 => doubled_rows(frames, offsets, rows, columns, (width_image, height_image), stacked, write),
            _ => {
                let step = 1usize << octave;
                let wide = columns.start * step..(columns.end - 1) * step + 1;
                stacked.resize(wide.len(), 0.0);
                let mut row = vec![0.0; columns.len()];
                for v in rows {
                    stack_row(frames, offsets, v * step, wide.clone(), stacked);
                    for (out, chunk) in row.iter_mut().zip(stacked.chunks(step)) {
                        *out = chunk[0];
                    }
                    write(v, &row);
                }
            }
        }
    }

    /// σ of what the octave is made from, in octave pixels.
    pub fn sigma_octave(&self) -> f64 {
        match self {
            Self::Frames { octave, .. } => super::scale_space::SIGMA_INPUT * 2f64.powi(-octave),
            Self::Level(_) => super::scale_space::SIGMA_BASE,
        }
    }

    /// Gaussian levels −1 … S+1 around rows `wanted`, into the scratch; level index `i` has `space.halo(i)` more rows on each side.
    fn levels<'s>(
        &self,
        space: &ScaleSpace,
        size: (usize, usize),
        wanted: &Range<usize>,
        scratch: &'s mut StripScratch,
    ) -> &'s [Rows] {
        let (width, height) = size;
        scratch.levels.resize_with(space.levels + 3, Rows::default);
        let base_range = widened(wanted, space.halo(0), height);
        match self {
            Self::Frames { .. } => {
                let raw_range = widened(&base_range, space.base_kernel.radius(), height);
                let (raw, padded) = (&mut scratch.raw, &mut scratch.padded);
                raw.reset(width, raw_range.clone());
                self.raw_rows(raw_range, 0..width, &mut scratch.stacked, |v, row| {
                    raw.row_mut(v).copy_from_slice(row);
                });
                blur_rows(raw, size, &space.base_kernel, base_range, padded, &mut scratch.levels[0]);
            }
            Self::Level(plane) => {
                let base = &mut scratch.levels[0];
                base.reset(width, base_range.clone());
                for v in base_range {
                    base.row_mut(v).copy_from_slice(plane.source_row(v));
                }
            }
        }
        for (i, kernel) in space.step_kernels.iter().enumerate() {
            let (before, after) = scratch.levels.split_at_mut(i + 1);
            let range = widened(wanted, space.halo(i + 1), height);
            blur_rows(&before[i], size, kernel, range, &mut scratch.padded, &mut after[0]);
        }
        &scratch.levels
    }

    /// DoG levels −1 … S for rows `wanted` of an octave of `size`, into `dog`. Returns the Gaussian level S−1, from which the next octave starts; it
    /// holds at least the rows `wanted`.
    pub fn dog_strip<'s>(
        &self,
        space: &ScaleSpace,
        size: (usize, usize),
        wanted: &Range<usize>,
        scratch: &'s mut StripScratch,
        dog: &mut DogStrip,
    ) -> &'s Rows {
        let levels = self.levels(space, size, wanted, scratch);
        dog.levels.resize_with(space.levels + 2, Rows::default);
        for (s, out) in dog.levels.iter_mut().enumerate() {
            out.reset(size.0, wanted.clone());
            for v in wanted.clone() {
                subtract_rows(levels[s + 1].row(v), levels[s].row(v), out.row_mut(v));
            }
        }
        &levels[space.levels]
    }
}

/// Rows of the stacked image doubled by linear interpolation: pixel (2i, 2j) is pixel (i, j), the last one is repeated.
fn doubled_rows(
    frames: &[&Plane],
    offsets: &[FrameOffset],
    rows: Range<usize>,
    columns: Range<usize>,
    size_image: (usize, usize),
    stacked: &mut Vec<f32>,
    mut write: impl FnMut(usize, &[f32]),
) {
    let (width, height) = size_image;
    let narrow = columns.start / 2..((columns.end - 1) / 2 + 2).min(width);
    let n = narrow.len();
    stacked.resize(n, 0.0);
    let double = |v: usize, stacked: &mut [f32], out: &mut [f32]| {
        stack_row(frames, offsets, v.min(height - 1), narrow.clone(), stacked);
        for (out, x) in out.iter_mut().zip(columns.clone()) {
            let i = x / 2 - narrow.start;
            *out = if x % 2 == 0 { stacked[i] } else { 0.5 * (stacked[i] + stacked[(i + 1).min(n - 1)]) };
        }
    };
    let (mut upper, mut lower, mut middle) =
        (vec![0.0; columns.len()], vec![0.0; columns.len()], vec![0.0; columns.len()]);
    let mut upper_is = None;
    for v in rows {
        let i = v / 2;
        if upper_is != Some(i) {
            if upper_is.is_some_and(|held| held + 1 == i) && v % 2 == 0 {
                std::mem::swap(&mut upper, &mut lower);
            } else {
                double(i, stacked, &mut upper);
            }
            upper_is = Some(i);
        }
        if v % 2 == 0 {
            write(v, &upper);
        } else {
            double(i + 1, stacked, &mut lower);
            for ((out, a), b) in middle.iter_mut().zip(&upper).zip(&lower) {
                *out = 0.5 * (a + b);
            }
            write(v, &middle);
        }
    }
}
