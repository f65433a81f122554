//! Memory that suits the processor's vectors. The widest vector is as long as a cache line; where rows begin at cache
//! lines no vector straddles two of them, which would take twice as long.

use std::ops::{Deref, DerefMut};

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
}
