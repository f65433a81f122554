//! Rows in vectors of the processor's width, several at once.

pub(crate) use super::machine::MAX_VECTORS;
use pulp::Simd;

/// The vector that begins at `row[at]`.
#[inline(always)]
pub(crate) fn load<S: Simd>(row: &[f32], at: usize) -> S::f32s {
    S::as_simd_f32s(&row[at..at + S::F32_LANES]).0[0]
}

/// Writes a vector to `row[at..]`.
#[inline(always)]
pub(crate) fn store<S: Simd>(row: &mut [f32], at: usize, value: S::f32s) {
    S::as_mut_simd_f32s(&mut row[at..at + S::F32_LANES]).0[0] = value;
}

/// First values of `V` vectors of `lanes`, the first one at vector `first` of a row of `n` values: one after the other,
/// but the row's last one ends where the row does, unless the row is shorter than a vector.
#[inline(always)]
pub(crate) fn places<const V: usize>(first: usize, lanes: usize, n: usize) -> [usize; V] {
    std::array::from_fn(|i| ((first + i) * lanes).min(n.saturating_sub(lanes)))
}

/// Runs `$body` for groups of `$count` vectors (a constant, at most [`MAX_VECTORS`]) of the kind `$simd` that begin at
/// `$places` and together cover `0 … $n`.
macro_rules! in_vectors {
    ($simd:ident, $n:expr, |$count:ident, $places:ident| $body:block) => {
        let (n, lanes) = ($n, $simd::F32_LANES);
        let vectors = n.div_ceil(lanes);
        macro_rules! group {
            ($first:expr, $size:literal) => {{
                const $count: usize = $size;
                let $places = $crate::kernel::vectors::places::<$count>($first, lanes, n);
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
