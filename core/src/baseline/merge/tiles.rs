//! Half-overlapping square tiles over an image, and the window under which they are blended.
//!
//! Tile (i, j) has its centre at ([`STEP`]·i, [`STEP`]·j) and reaches half a tile to each side, also beyond the image;
//! so each pixel lies in two tiles along each axis. The raised-cosine window weighs the pixels of a tile so that the
//! weights of those that share a pixel add up to 1.

use std::f64::consts::TAU;

/// Side of a tile, pixels.
pub(super) const TILE: usize = 16;
/// Distance between the centres of neighbouring tiles, pixels.
pub(super) const STEP: usize = TILE / 2;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TileGrid {
    pub columns: usize,
    pub rows: usize,
}

impl TileGrid {
    /// The tiles of an image of `size` = (columns, rows), neither of which is 0.
    pub fn of(size: (usize, usize)) -> Self {
        Self { columns: (size.0 - 1) / STEP + 2, rows: (size.1 - 1) / STEP + 2 }
    }
}

/// The first pixel of tile `index` along an axis; it may lie outside the image.
pub(super) fn first_pixel(index: usize) -> i64 {
    (index * STEP) as i64 - STEP as i64
}

/// Weights along an axis.
pub(super) fn window() -> [f32; TILE] {
    std::array::from_fn(|k| (0.5 - 0.5 * (TAU * (k as f64 + 0.5) / TILE as f64).cos()) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_has_weight_one() {
        for side in [1, 7, 8, 9, 16, 31, 100] {
            let grid = TileGrid::of((side, 1));
            let mut weights = vec![0.0; side];
            for i in 0..grid.columns {
                for (k, weight) in window().iter().enumerate() {
                    if let Some(sum) = usize::try_from(first_pixel(i) + k as i64).ok().and_then(|x| weights.get_mut(x))
                    {
                        *sum += weight;
                    }
                }
            }
            assert!(weights.iter().all(|w| (w - 1.0).abs() < 1e-6), "{side}: {weights:?}");
        }
    }
}
