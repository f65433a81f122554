//! Half-overlapping square tiles over an image, the window under which they are blended, and their cosine transform.
//!
//! Tile (i, j) has its centre at ([`STEP`]·i, [`STEP`]·j) and reaches half a tile to each side, also beyond the image:
//! each pixel lies in two tiles along each axis. Under the raised-cosine window the weights of a pixel add up to 1.

use multiversion::multiversion;
use std::f64::consts::{PI, TAU};

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
    /// Tiles of an image of `size` = (columns, rows), neither of which is 0.
    pub fn of(size: (usize, usize)) -> Self {
        Self { columns: (size.0 - 1) / STEP + 2, rows: (size.1 - 1) / STEP + 2 }
    }
}

/// First pixel of tile `index` along an axis; may lie outside the image.
pub(super) fn first_pixel(index: usize) -> i64 {
    (index * STEP) as i64 - STEP as i64
}

pub(super) fn window() -> [f32; TILE] {
    std::array::from_fn(|k| (0.5 - 0.5 * (TAU * (k as f64 + 0.5) / TILE as f64).cos()) as f32)
}

pub(super) type Block = [[f32; TILE]; TILE];

/// Cosine transform along an axis: row k holds the k-th cosine, of length 1.
pub(super) fn basis() -> Block {
    let n = TILE as f64;
    std::array::from_fn(|k| {
        let scale = if k == 0 { (1.0 / n).sqrt() } else { (2.0 / n).sqrt() };
        std::array::from_fn(|x| (scale * (PI / n * (x as f64 + 0.5) * k as f64).cos()) as f32)
    })
}

pub(super) fn transposed(block: &Block) -> Block {
    std::array::from_fn(|k| std::array::from_fn(|x| block[x][k]))
}

/// `left` · `block` · `leftᵀ`, where `right` is `leftᵀ`: with the basis the transform, with its transpose the inverse.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn transform(left: &Block, block: &Block, right: &Block) -> Block {
    let mut half = [[0.0f32; TILE]; TILE];
    for (out, weights) in half.iter_mut().zip(left) {
        for (row, &weight) in block.iter().zip(weights) {
            for x in 0..TILE {
                out[x] = weight.mul_add(row[x], out[x]);
            }
        }
    }
    let mut whole = [[0.0f32; TILE]; TILE];
    for (out, weights) in whole.iter_mut().zip(&half) {
        for (row, &weight) in right.iter().zip(weights) {
            for x in 0..TILE {
                out[x] = weight.mul_add(row[x], out[x]);
            }
        }
    }
    whole
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

    #[test]
    fn there_and_back_is_the_same_and_energy_stays() {
        let (basis, back) = (basis(), transposed(&basis()));
        let block: Block = std::array::from_fn(|v| std::array::from_fn(|u| ((u * 7 + v * v * 3) % 11) as f32 - 4.0));
        let coefficients = transform(&basis, &block, &back);
        let energy = |b: &Block| b.iter().flatten().map(|x| f64::from(*x).powi(2)).sum::<f64>();
        assert!((energy(&coefficients) / energy(&block) - 1.0).abs() < 1e-5);
        let again = transform(&back, &coefficients, &basis);
        assert!(again.iter().flatten().zip(block.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-4));
    }
}
