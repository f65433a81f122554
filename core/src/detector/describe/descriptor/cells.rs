//! Cells of a descriptor, and the samples that pixels add to them: computed in vectors, added one by one.

use crate::kernel::gradient::Lane;
use crate::kernel::patch::LANES;

/// Number of cells along a side.
pub(super) const CELLS: usize = 4;
/// Number of directions in a cell.
pub(super) const DIRECTIONS: usize = 8;
/// Number of sums of a descriptor.
pub(super) const BINS: usize = CELLS * CELLS * DIRECTIONS;
/// Number of cells along a side with one more at each end for pixels outside, so that no weight needs a test.
const PADDED: usize = CELLS + 2;
/// Number of independent accumulators, so that an addition need not wait for the one before it.
const TURNS: usize = 4;

/// Number of pairs in a row of cells.
pub(super) const PAIRS: usize = PADDED - 1;

/// Values that some pixels add, in the order of the pixels. Cells and directions are counted from the first padded
/// ones.
#[derive(Debug, Default)]
pub(super) struct Samples {
    /// Pair of cells above the pixel, between which it lies.
    cell: Vec<u32>,
    /// Direction before the pixel's, and the pixel's distance from it, in steps of directions.
    direction: Vec<u32>,
    past_direction: Vec<f32>,
    /// Distance of the pixel from the pair's left cell, as a fraction of the way to the right one.
    past_column: Vec<f32>,
    /// Weights in the pair and in the one below it.
    upper: Vec<f32>,
    lower: Vec<f32>,
}

/// [`Samples`] of one vector, to be written.
pub(super) struct SampleVector<'a> {
    pub(super) cell: &'a mut [u32; LANES],
    pub(super) direction: &'a mut [u32; LANES],
    pub(super) past_direction: &'a mut Lane,
    pub(super) past_column: &'a mut Lane,
    pub(super) upper: &'a mut Lane,
    pub(super) lower: &'a mut Lane,
}

impl Samples {
    /// Makes room for `count` samples and a partly used vector.
    pub(super) fn room(&mut self, count: usize) {
        let count = count + LANES;
        if self.cell.len() < count {
            self.cell.resize(count, 0);
            self.direction.resize(count, 0);
            for values in [&mut self.past_direction, &mut self.past_column, &mut self.upper, &mut self.lower] {
                values.resize(count, 0.0);
            }
        }
    }

    /// Samples of one vector from `at` on.
    #[inline(always)]
    pub(super) fn vector(&mut self, at: usize) -> SampleVector<'_> {
        fn part<T>(values: &mut [T], at: usize) -> &mut [T; LANES] {
            (&mut values[at..at + LANES]).try_into().expect("a vector")
        }
        SampleVector {
            cell: part(&mut self.cell, at),
            direction: part(&mut self.direction, at),
            past_direction: part(&mut self.past_direction, at),
            past_column: part(&mut self.past_column, at),
            upper: part(&mut self.upper, at),
            lower: part(&mut self.lower, at),
        }
    }
}

/// Sums for each pair of neighbouring cells of a row: the parts of samples between the two for the left one, then for
/// the right one. A sample adds to one pair and to the one below it; kept apart, pairs never overlap.
#[repr(C, align(64))]
pub(super) struct PairedCells([[[f32; 2 * DIRECTIONS]; PADDED * PAIRS]; TURNS]);

/// For each direction, its share in each of a pair's directions, and the change of that towards the next direction.
#[repr(C, align(64))]
struct Shares([[[f32; 2 * DIRECTIONS]; 2]; DIRECTIONS]);

static SHARES: Shares = {
    let mut shares = [[[0.0; 2 * DIRECTIONS]; 2]; DIRECTIONS];
    let mut direction = 0;
    while direction < DIRECTIONS {
        let next = (direction + 1) % DIRECTIONS;
        let [at, change] = &mut shares[direction];
        (at[direction], at[DIRECTIONS + direction]) = (1.0, 1.0);
        (change[direction], change[DIRECTIONS + direction]) = (-1.0, -1.0);
        (change[next], change[DIRECTIONS + next]) = (1.0, 1.0);
        direction += 1;
    }
    Shares(shares)
};

impl PairedCells {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self([[[0.0; 2 * DIRECTIONS]; PADDED * PAIRS]; TURNS])
    }

    /// Adds the first `count` samples.
    #[inline(always)]
    pub(super) fn add(&mut self, samples: &mut Samples, count: usize) {
        // Unused samples of the last turn add nothing.
        samples.upper[count..count + TURNS].fill(0.0);
        samples.lower[count..count + TURNS].fill(0.0);
        let count = count.next_multiple_of(TURNS);
        let Samples { cell, direction, past_direction, past_column, upper, lower } = &*samples;
        let (cell, direction, past_direction) = (&cell[..count], &direction[..count], &past_direction[..count]);
        let (past_column, upper, lower) = (&past_column[..count], &upper[..count], &lower[..count]);
        for first in (0..count).step_by(TURNS) {
            for (turn, pairs) in self.0.iter_mut().enumerate() {
                let i = first + turn;
                let [at, change] = &SHARES.0[direction[i] as usize % DIRECTIONS];
                let mut share = [0.0f32; 2 * DIRECTIONS];
                for (j, share) in share.iter_mut().enumerate() {
                    // 1 − past for the left cell, past for the right one.
                    let (start, slope) = if j < DIRECTIONS { (1.0, -1.0) } else { (0.0, 1.0) };
                    let column = past_column[i].mul_add(slope, start);
                    *share = past_direction[i].mul_add(change[j], at[j]) * column;
                }
                let pair = (cell[i] as usize).min((CELLS + 1) * PAIRS - 1);
                for (weight, pair) in [(upper[i], pair), (lower[i], pair + PAIRS)] {
                    for (sum, share) in pairs[pair].iter_mut().zip(&share) {
                        *sum = weight.mul_add(*share, *sum);
                    }
                }
            }
        }
    }

    /// Sums of the cells that are not padding.
    pub(super) fn sums(&self) -> [f32; BINS] {
        let mut out = [0.0; BINS];
        for (cell, out) in out.chunks_exact_mut(DIRECTIONS).enumerate() {
            let right = (cell / CELLS + 1) * PAIRS + cell % CELLS;
            for pairs in &self.0 {
                for (direction, out) in out.iter_mut().enumerate() {
                    *out += pairs[right][DIRECTIONS + direction] + pairs[right + 1][direction];
                }
            }
        }
        out
    }
}
