//! Planes of cells, on fewer and on more cells.

use crate::plane::Plane;

/// Means of squares of `by`² cells, and of what is left of them at the right and lower edge.
pub(super) fn means(plane: &Plane, by: usize) -> Plane {
    let (width, height) = plane.size();
    let mut means = Plane::zeros(width.div_ceil(by), height.div_ceil(by));
    for j in 0..means.height() {
        let rows = j * by..((j + 1) * by).min(height);
        let out = means.row_mut(j);
        for v in rows.clone() {
            out.iter_mut().zip(plane.row(v).chunks(by)).for_each(|(sum, cells)| *sum += cells.iter().sum::<f32>());
        }
        let whole = (rows.len() * by) as f32;
        let last = (rows.len() * (width - (out.len() - 1) * by)) as f32;
        let count = out.len();
        out.iter_mut().enumerate().for_each(|(i, sum)| *sum /= if i + 1 < count { whole } else { last });
    }
    means
}

/// `few`, which has one value for `by`² cells, on a plane of `size`, linear between.
pub(super) fn enlarged(few: &Plane, by: usize, (width, height): (usize, usize)) -> Plane {
    // The values before and after each place, and the part of the one after.
    let along = |count: usize, last: usize| -> Vec<(usize, usize, f32)> {
        let place = |x: usize| ((x as f32 + 0.5) / by as f32 - 0.5).clamp(0.0, last as f32);
        (0..count).map(place).map(|x| (x as usize, (x as usize + 1).min(last), x.fract())).collect()
    };
    let columns = along(width, few.width() - 1);
    let mut plane = Plane::zeros(width, height);
    for (v, (above, below, part)) in along(height, few.height() - 1).into_iter().enumerate() {
        let (above, below) = (few.row(above), few.row(below));
        let row: Vec<f32> = above.iter().zip(below).map(|(a, b)| a + part * (b - a)).collect();
        let values = columns.iter().map(|&(left, right, part)| row[left] + part * (row[right] - row[left]));
        plane.row_mut(v).iter_mut().zip(values).for_each(|(out, value)| *out = value);
    }
    plane
}
