//! Cutting a row into blocks for the inner loops.
//!
//! A block's sums stay in vector registers. A row is computed in large blocks; the rest is covered by one more block
//! that overlaps the last, so that rows of any length run in vector lanes. Each value is computed by itself, so
//! computing some twice changes nothing.

/// Pixels of a large block: enough independent sums to hide the latency of an addition.
pub const LARGE: usize = 64;
/// Pixels of a small block, for rows shorter than a large one: a vector register's worth.
pub const SMALL: usize = 16;

/// Size of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockSize {
    /// [`LARGE`] values.
    Large,
    /// [`SMALL`] values.
    Small,
    /// A single value.
    One,
}

/// Calls `block(start, size)` for blocks that cover `0 … n`; each lies inside.
#[inline(always)]
pub fn for_blocks(n: usize, mut block: impl FnMut(usize, BlockSize)) {
    if n >= LARGE {
        for i in 0..n / LARGE {
            block(i * LARGE, BlockSize::Large);
        }
        if n % LARGE > SMALL {
            block(n - LARGE, BlockSize::Large);
        } else if !n.is_multiple_of(LARGE) {
            block(n - SMALL, BlockSize::Small);
        }
    } else if n >= SMALL {
        for i in 0..n / SMALL {
            block(i * SMALL, BlockSize::Small);
        }
        if !n.is_multiple_of(SMALL) {
            block(n - SMALL, BlockSize::Small);
        }
    } else {
        for i in 0..n {
            block(i, BlockSize::One);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_every_length_and_stay_inside() {
        for n in 0..300 {
            let mut covered = vec![false; n];
            for_blocks(n, |start, size| {
                let length = match size {
                    BlockSize::Large => LARGE,
                    BlockSize::Small => SMALL,
                    BlockSize::One => 1,
                };
                covered[start..start + length].fill(true);
            });
            assert!(covered.iter().all(|&c| c), "{n}");
        }
    }
}
