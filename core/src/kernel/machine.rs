//! Sizes tuned to the processor, of tiles, strips and blocks, and rows taken in vectors of its width.
//!
//! None of the sizes changes a bit of any result. The bench `stages` measures those of vectors, rows and levels,
//! `cpu_time` those of tiles, windows, slopes and strips: run it before and after changing one.

use pulp::Simd;

/// Vectors whose sums are held at once: they hide each other's latency and fit into sixteen registers.
pub(crate) const MAX_VECTORS: usize = 6;
pub(crate) const WIDEST_VECTOR: usize = 16;
/// Columns that the filter bank makes together: two vectors of the widest kind, a whole number of any kind.
pub(crate) const BLOCK_COLUMNS: usize = 32;
/// Rows that the filter bank finishes at a time: the values between the passes stay in the second cache.
pub(crate) const BATCH_ROWS: usize = 112;
/// Maximum number of rows of one level computed at once; half of them where vectors are shorter and registers fewer.
pub(crate) const MAX_LEVEL_ROWS: usize = 8;
/// Rows of a patch that are combined together: neighbouring rows read the same source rows but one.
pub(crate) const PATCH_ROWS_TOGETHER: usize = 4;
/// Columns of a tile: with its margin five blocks of vectors, whose values stay in the second cache.
pub(crate) const TILE_COLUMNS: usize = 148;
/// Rows of a tile at most: enough that the margin for its filters matters little.
pub(crate) const TILE_ROWS: usize = 548;
/// Maximum size of the DoG tiles of the windows of slopes of all threads together, bytes.
pub(crate) const WINDOWS_BYTES: usize = 128 << 20;
/// Maximum size of one window, bytes: a thread's share of the third cache.
pub(crate) const WINDOW_BYTES: usize = 6 << 20;
/// Slopes whose frames are stacked together at most: whole rows of a plane's grid share the mixing of rows.
pub(crate) const STACKED_SLOPES: usize = 16;
/// Rows that are stacked together: those of all frames, mixed for a row of a grid, stay in the second cache.
pub(crate) const STACKED_ROWS: usize = 16;
/// Width of the strips in which keypoints are described, columns: the pixels they share stay in the cache.
pub(crate) const STRIP_COLUMNS: f32 = 100.0;
/// Keypoints described by a thread before it takes new work.
pub(crate) const KEYPOINTS_TOGETHER: usize = 32;

#[inline(always)]
pub(crate) fn load<S: Simd>(row: &[f32], at: usize) -> S::f32s {
    S::as_simd_f32s(&row[at..at + S::F32_LANES]).0[0]
}

#[inline(always)]
pub(crate) fn store<S: Simd>(row: &mut [f32], at: usize, value: S::f32s) {
    S::as_mut_simd_f32s(&mut row[at..at + S::F32_LANES]).0[0] = value;
}

/// First values of `V` vectors from vector `first` on of a row of `n` values; the last one ends where the row does.
#[inline(always)]
pub(crate) fn places<const V: usize>(first: usize, lanes: usize, n: usize) -> [usize; V] {
    std::array::from_fn(|i| ((first + i) * lanes).min(n.saturating_sub(lanes)))
}

/// Runs `$body` for groups of `$count` (at most [`MAX_VECTORS`]) vectors at `$places`, which together cover `0 … $n`.
macro_rules! in_vectors {
    ($simd:ident, $n:expr, |$count:ident, $places:ident| $body:block) => {
        let (n, lanes) = ($n, $simd::F32_LANES);
        let vectors = n.div_ceil(lanes);
        macro_rules! group {
            ($first:expr, $size:literal) => {{
                const $count: usize = $size;
                let $places = $crate::kernel::machine::places::<$count>($first, lanes, n);
                $body
            }};
        }
        let mut first = 0;
        while vectors - first >= MAX_VECTORS {
            group!(first, 6);
            first += MAX_VECTORS;
        }
        match vectors - first {
            1 => group!(first, 1),
            2 => group!(first, 2),
            3 => group!(first, 3),
            4 => group!(first, 4),
            5 => group!(first, 5),
            _ => {}
        }
    };
}
pub(crate) use in_vectors;
