//! As many marks as each part of a picture can bear.
//!
//! The image is divided into square cells whose side is a power of two, in image pixels, of up to [`CELL_POINTS`] on
//! the screen or sheet. The caller adds the marks from the strongest to the weakest and draws the first [`IN_A_CELL`]
//! of each cell. Cells nest in those of the next coarser zoom: zooming in only adds marks, and panning changes none.

/// Largest side of a cell on the screen, in points.
const CELL_POINTS: f32 = 64.0;

/// Number of features that are drawn in a cell.
pub const IN_A_CELL: u16 = 2;

/// Largest number of cells along a side of the view and its surroundings; larger views share the cells at their rim.
const MAX_CELLS: usize = 256;

/// Square cells over a view and its surroundings, with the number of marks in each.
#[derive(Debug, Clone)]
pub struct Cells {
    /// One over the side of a cell.
    per_pixel: f32,
    first: [f32; 2],
    size: [usize; 2],
    held: Vec<u16>,
}

impl Cells {
    /// Empty cells for a picture of `points_per_pixel` points an image pixel, seen from `min` to `max` (image pixels).
    pub fn new(points_per_pixel: f32, [min, max]: [[f32; 2]; 2]) -> Self {
        let side = (CELL_POINTS / points_per_pixel.clamp(1e-6, 1e6)).log2().floor().exp2();
        // Circles reach into the view from outside: cells one view around it are counted too.
        let size = [max[0] - min[0], max[1] - min[1]];
        let first = [0, 1].map(|axis| ((min[axis] - size[axis]) / side).floor());
        let count = |axis: usize| (((max[axis] + size[axis]) / side).floor() - first[axis]) as usize + 1;
        let size = [0, 1].map(|axis| count(axis).clamp(1, MAX_CELLS));
        // The side is a power of two, so that this is exact.
        Self { per_pixel: side.recip(), first, size, held: vec![0; size[0] * size[1]] }
    }

    /// Adds a mark to the cell of `place`; returns the number of marks there before. `None` for a place that is NaN.
    pub fn add(&mut self, place: [f32; 2]) -> Option<u16> {
        if place.iter().any(|x| x.is_nan()) {
            return None;
        }
        let index = |axis: usize| {
            let at = (place[axis] * self.per_pixel - self.first[axis]).max(0.0) as usize;
            at.min(self.size[axis] - 1)
        };
        let at = index(1) * self.size[0] + index(0);
        let before = self.held[at];
        self.held[at] = before.saturating_add(1);
        Some(before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_counts_its_marks_and_halves_when_the_scale_doubles() {
        let view = [[0.0, 0.0], [256.0, 256.0]];
        for (scale, side) in [(1.0, 64.0), (2.0, 32.0), (0.25, 256.0)] {
            let mut cells = Cells::new(scale, view);
            assert_eq!(cells.add([1.0, 1.0]), Some(0));
            assert_eq!(cells.add([side - 1.0, side - 1.0]), Some(1));
            assert_eq!(cells.add([side + 1.0, 1.0]), Some(0), "{scale}");
            assert_eq!((cells.add([f32::NAN, 1.0]), cells.add([-1e9, 1e9])), (None, Some(0)));
        }
    }
}
