//! Patches: the pixels around one feature at one slope.
//!
//! The search leaves nothing behind but keypoints; localisation and description make the little that they need of a feature's own motion-stack image
//! again, from the frames or from the octave's stored first level.

use super::hat::PixelView;
use super::octave::{Base, widened};
use crate::plane::Plane;
use crate::plane::blur::{GaussianKernel, blur_rows};
use crate::plane::rows::Rows;
use std::ops::Range;

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
    /// The pixels and where they begin.
    pub fn pixels(&self) -> PixelView<'_> {
        PixelView { left: self.left as i64, top: self.top as i64, ..PixelView::of(&self.plane) }
    }

    /// Columns `columns` and rows `rows` of the octave, blurred by `kernel`. The patch must reach farther by the kernel's radius, or to the octave's border.
    /// One blur to a level equals the levels' chain of blurs up to the kernels' cut.
    pub fn blurred(&self, columns: Range<usize>, rows: Range<usize>, kernel: &GaussianKernel) -> Plane {
        let reach = kernel.radius();
        let (width, height) = self.plane.size();
        let (wide, tall) = (widened(&columns, reach, self.size.0), widened(&rows, reach, self.size.1));
        debug_assert!(wide.start >= self.left && wide.end <= self.left + width, "the patch reaches far enough");
        debug_assert!(tall.start >= self.top && tall.end <= self.top + height, "the patch reaches far enough");
        // Repeated pixels at the patch's own border reach only what is not asked for, unless it is the octave's border.
        let (mut padded, mut blurred) = (Vec::new(), Rows::default());
        let wanted = rows.start - self.top..rows.end - self.top;
        blur_rows(&self.plane, (width, height), kernel, wanted.clone(), &mut padded, &mut blurred);
        let mut out = Plane::zeros(columns.len(), rows.len());
        for (v, row) in wanted.enumerate() {
            out.row_mut(v).copy_from_slice(&blurred.row(row)[columns.start - self.left..columns.end - self.left]);
        }
        out
    }
}

impl Base<'_> {
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
}
