//! The cosine transform of a tile: orthonormal, so that white noise has its variance in every coefficient.

use super::tiles::TILE;
use multiversion::multiversion;
use std::f64::consts::PI;

/// The pixels, or the coefficients, of a tile, row by row.
pub(super) type Block = [[f32; TILE]; TILE];

/// The transform along an axis: row k holds the k-th cosine, of length 1.
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
