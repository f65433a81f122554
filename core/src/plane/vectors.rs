//! Memory and loops that suit the processor's vectors.
//!
//! [`Aligned`] is a buffer of numbers that starts at a cache line. A vector of the widest kind is as long as a cache
//! line; where rows begin at cache lines no vector of a row straddles two of them, which would take twice as long.
//!
//! [`for_blocks`] cuts a row into blocks for the inner loops. A block's sums stay in vector registers. A row is
//! computed in large blocks; the rest is covered by one more block that overlaps the last, so that rows of any length
//! run in vector lanes. Each value is computed by itself, so computing some twice changes nothing.

use std::ops::{Deref, DerefMut};

/// A cache line of numbers.
#[derive(Debug, Clone, Copy, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Line([f32; 16]);

/// Growing buffer of `f32` whose first value lies at the start of a cache line.
#[derive(Debug, Clone, Default)]
pub struct Aligned {
    lines: Vec<Line>,
}

impl Aligned {
    /// Makes room for at least `len` numbers; existing ones keep their values, new ones are 0.
    pub fn grow(&mut self, len: usize) {
        let lines = len.div_ceil(16);
        if self.lines.len() < lines {
            self.lines.resize(lines, Line::default());
        }
    }
}

impl Deref for Aligned {
    type Target = [f32];

    #[inline]
    fn deref(&self) -> &[f32] {
        bytemuck::cast_slice(&self.lines)
    }
}

impl DerefMut for Aligned {
    #[inline]
    fn deref_mut(&mut self) -> &mut [f32] {
        bytemuck::cast_slice_mut(&mut self.lines)
    }
}

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
    fn buffers_begin_at_cache_lines_and_keep_what_they_hold() {
        let mut buffer = Aligned::default();
        for len in [1, 16, 17, 5000, 3] {
            buffer.grow(len);
            assert!(buffer.len() >= len);
            assert_eq!(buffer.as_ptr() as usize % 64, 0);
            buffer[0] = 7.0;
        }
        assert_eq!(buffer[0], 7.0);
        assert_eq!(buffer[4999], 0.0);
    }

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
