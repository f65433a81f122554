//! Rows of one level between the two passes, stored in blocks of columns.
//!
//! The second pass works on a block of columns at a time and reads rows above and below one another. So a block's rows
//! are contiguous: they are read from memory in order, and loops over them need no bounds checks.

use crate::kernel::gaussian_bank::lanes::BLOCK;
use crate::plane::aligned::Aligned;

/// A row of a block of columns.
pub(crate) type Row = [f32; BLOCK];

/// Some rows of one level.
#[derive(Debug, Default)]
pub(crate) struct Band {
    data: Aligned,
    blocks: usize,
    /// Capacity in rows.
    room: usize,
}

impl Band {
    /// Makes room for `room` rows of `blocks` blocks of columns.
    pub fn reset(&mut self, blocks: usize, room: usize) {
        self.data.grow(blocks * room * BLOCK);
        (self.blocks, self.room) = (blocks, room);
    }

    /// Values from a block's row to the same row of the next block.
    pub fn step(&self) -> usize {
        self.room * BLOCK
    }

    /// The rows of block `block`.
    #[inline(always)]
    pub fn block(&self, block: usize) -> &[Row] {
        self.data[block * self.step()..(block + 1) * self.step()].as_chunks().0
    }

    /// Row `row` of the first block; the same row of each other block lies [`Band::step`] values further.
    #[inline(always)]
    pub fn row_mut(&mut self, row: usize) -> &mut [f32] {
        let end = self.blocks * self.step();
        &mut self.data[row * BLOCK..end]
    }

    /// Moves rows `rows` to row `to` in every block.
    pub fn move_rows(&mut self, rows: std::ops::Range<usize>, to: usize) {
        for block in 0..self.blocks {
            let start = block * self.room;
            let from = (start + rows.start) * BLOCK..(start + rows.end) * BLOCK;
            self.data.copy_within(from, (start + to) * BLOCK);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_block_by_block_and_move_together() {
        let mut band = Band::default();
        band.reset(3, 5);
        for row in 0..5 {
            let step = band.step();
            let values = band.row_mut(row);
            (0..3).for_each(|block| values[block * step..][..BLOCK].fill((10 * block + row) as f32));
        }
        band.move_rows(3..5, 0);
        for block in 0..3 {
            let rows: Vec<f32> = band.block(block).iter().map(|row| row[BLOCK - 1]).collect();
            let first = 10.0 * block as f32;
            assert_eq!(rows, [first + 3.0, first + 4.0, first + 2.0, first + 3.0, first + 4.0]);
        }
    }
}
