//! One octave of the search: where its first level comes from, and the strips of its levels.
//!
//! For the first octave the first level is made from the frames: stacked at a slope, brought to the octave's resolution and blurred. Later octaves
//! start from planes that the octave before left behind, one for each slope. Everything is made in strips of rows; a strip carries the rows
//! above and below that its blurs need, so each row has the same bits whatever the strips.

use super::motion::{FrameOffset, stack_row};
use super::scale_space::ScaleSpace;
use crate::plane::Plane;
use crate::plane::blur::{GaussianKernel, blur_row, blur_rows};
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

/// The pixels around a feature as they are before any blur of their octave, less the value in the middle.
#[derive(Debug)]
pub struct RawPatch {
    /// The pixels.
    pub plane: Plane,
    /// Column of the octave at which they begin.
    pub left: usize,
    /// Row of the octave at which they begin.
    pub top: usize,
    /// The octave's size.
    pub size: (usize, usize),
}

impl RawPatch {
    /// Columns `columns` and rows `rows` of the octave, blurred by `kernel`. The patch must reach farther by the kernel's radius, or to the octave's border.
    /// One blur to a level equals the levels' chain of blurs up to the kernels' cut.
    pub fn blurred(&self, columns: Range<usize>, rows: Range<usize>, kernel: &GaussianKernel) -> Plane {
        let reach = kernel.radius();
        let (width, height) = self.plane.size();
        let (wide, tall) = (widened(&columns, reach, self.size.0), widened(&rows, reach, self.size.1));
        debug_assert!(wide.start >= self.left && wide.end <= self.left + width, "the patch reaches far enough");
        debug_assert!(tall.start >= self.top && tall.end <= self.top + height, "the patch reaches far enough");
        // Repeated pixels at the patch's own border reach only what is not asked for, unless it is the octave's border.
        let (mut padded, mut row_out) = (Vec::new(), vec![0.0; width]);
        let mut out = Plane::zeros(columns.len(), rows.len());
        for (v, row) in rows.enumerate() {
            blur_row(&self.plane, height, kernel, row - self.top, &mut padded, &mut row_out);
            out.row_mut(v).copy_from_slice(&row_out[columns.start - self.left..columns.end - self.left]);
        }
        out
    }
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
    fn raw_rows(
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

    /// σ of what [`Self::patch`] gives, in octave pixels.
    pub fn sigma_octave(&self) -> f64 {
        match self {
            Self::Frames { octave, .. } => super::scale_space::SIGMA_INPUT * 2f64.powi(-octave),
            Self::Level(_) => super::scale_space::SIGMA_BASE,
        }
    }

    /// Columns `columns` and rows `rows` of the octave of `size`, inside it, as they are before any blur of this octave.
    pub fn patch(&self, size: (usize, usize), columns: Range<usize>, rows: Range<usize>) -> RawPatch {
        let (left, top) = (columns.start, rows.start);
        let mut plane = Plane::zeros(columns.len(), rows.len());
        match self {
            Self::Frames { .. } => {
                let mut stacked = Vec::new();
                self.raw_rows(rows, columns, &mut stacked, |v, row| plane.row_mut(v - top).copy_from_slice(row));
            }
            Self::Level(level) => {
                for v in rows {
                    plane.row_mut(v - top).copy_from_slice(&level.row(v)[columns.clone()]);
                }
            }
        }
        // Only differences matter around a feature; small numbers round less.
        let middle = plane.at(plane.width() / 2, plane.height() / 2);
        plane.data_mut().iter_mut().for_each(|x| *x -= middle);
        RawPatch { plane, left, top, size }
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
                blur_rows(raw, width, height, &space.base_kernel, base_range, padded, &mut scratch.levels[0]);
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
            blur_rows(&before[i], width, height, kernel, range, &mut scratch.padded, &mut after[0]);
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
                for ((out, high), low) in out.row_mut(v).iter_mut().zip(levels[s + 1].row(v)).zip(levels[s].row(v)) {
                    *out = high - low;
                }
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
