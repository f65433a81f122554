//! The pixels around one feature, from the frames or from an octave's stored first level.

use crate::detector::scale_space::octave::Base;
use crate::kernel::patch::{Patch, PatchScratch, inside, stack_patch};
use std::ops::Range;

/// Pixels within `radius` of the pixel in which `place` lies.
pub(in crate::detector) fn around(place: f32, radius: usize) -> Range<i64> {
    let (middle, radius) = ((place + 0.5).floor() as i64, radius as i64);
    middle - radius..middle + radius + 1
}

impl Base<'_> {
    /// Reads columns `columns` and rows `rows` of the octave of `size`, before any blur of this octave and less the
    /// value in the middle, into `patch`. The rectangle must touch the octave.
    pub fn patch(
        &self,
        size: (usize, usize),
        columns: Range<i64>,
        rows: Range<i64>,
        scratch: &mut PatchScratch,
        patch: &mut Patch,
    ) {
        match self {
            Self::Level(level) => {
                patch.reset(columns.clone(), rows.clone());
                let columns = inside(&columns, size.0);
                for v in inside(&rows, size.1) {
                    let from = &level.row(v)[columns.clone()];
                    patch.values_mut(columns.start as i64, v as i64)[..from.len()].copy_from_slice(from);
                }
                patch.repeat_border(size);
            }
            Self::Frames { frames, offsets, octave: 0 } => {
                patch.reset(columns, rows);
                stack_patch(frames, offsets, patch, &mut scratch.sums);
                patch.repeat_border(size);
            }
            Self::Frames { frames, offsets, octave: -1 } => {
                // Pixels between which those of the doubled image lie. Repeated border pixels double to repeated ones.
                let narrow = |range: &Range<i64>| range.start.div_euclid(2)..(range.end - 1).div_euclid(2) + 2;
                scratch.narrow.reset(narrow(&columns), narrow(&rows));
                stack_patch(frames, offsets, &mut scratch.narrow, &mut scratch.sums);
                scratch.narrow.repeat_border(frames[0].size());
                patch.reset(columns, rows);
                patch.double(&scratch.narrow, &mut scratch.row);
            }
            Self::Frames { .. } => {
                patch.reset(columns.clone(), rows.clone());
                let columns = inside(&columns, size.0);
                self.raw_rows(inside(&rows, size.1), columns.clone(), &mut scratch.row, |v, row| {
                    patch.values_mut(columns.start as i64, v as i64)[..row.len()].copy_from_slice(row);
                });
                patch.repeat_border(size);
            }
        }
        patch.centre();
    }
}
