//! Coarser levels of a picture: each cell is the mean of the 2×2 cells below it.

use crate::plane::Plane;
use rayon::prelude::*;

/// Next coarser level of `fine`: (⌈columns/2⌉, ⌈rows/2⌉) cells, each the mean of those of its four cells that exist and
/// are numbers; NaN when none is.
pub fn halve(fine: &Plane) -> Plane {
    let (width, height) = (fine.width().div_ceil(2), fine.height().div_ceil(2));
    let mut coarse = Plane::zeros(width, height);
    if width == 0 {
        return coarse;
    }
    coarse.data_mut().par_chunks_mut(width).enumerate().with_min_len(8).for_each(|(v, out)| {
        let top = fine.row(2 * v);
        // The last row or column of an odd size counts twice.
        let bottom = fine.row((2 * v + 1).min(fine.height() - 1));
        for (u, cell) in out.iter_mut().enumerate() {
            let (left, right) = (2 * u, (2 * u + 1).min(fine.width() - 1));
            let four = [top[left], top[right], bottom[left], bottom[right]];
            let mean = 0.25 * (four[0] + four[1] + four[2] + four[3]);
            *cell = if mean.is_nan() { mean_of_numbers(four) } else { mean };
        }
    });
    coarse
}

/// Mean of the values that are numbers.
fn mean_of_numbers(values: [f32; 4]) -> f32 {
    let numbers = values.into_iter().filter(|x| !x.is_nan());
    let (sum, count) = numbers.fold((0.0, 0), |(s, n), x| (s + x, n + 1));
    if count == 0 { f32::NAN } else { sum / count as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_and_odd_sizes() {
        let plane = Plane::from_fn(5, 3, |u, v| (u + 10 * v) as f32);
        let half = halve(&plane);
        assert_eq!(half.size(), (3, 2));
        assert_eq!(half.at(0, 0), (0.0 + 1.0 + 10.0 + 11.0) / 4.0);
        assert_eq!(half.at(2, 0), (4.0 + 14.0) / 2.0);
        assert_eq!(half.at(2, 1), 24.0);
        assert_eq!(halve(&Plane::zeros(0, 0)).size(), (0, 0));
    }

    #[test]
    fn a_nan_counts_only_where_there_is_nothing_else() {
        let nan = f32::NAN;
        let plane = Plane::from_vec(4, 2, vec![nan, 2.0, nan, nan, 4.0, nan, nan, nan]);
        let half = halve(&plane);
        assert_eq!(half.at(0, 0), 3.0);
        assert!(half.at(1, 0).is_nan());
    }
}
