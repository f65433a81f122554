//! Chips as numbers, and their values between the samples.

use super::chip::{Chip, REACH, SIDE, STEP};

/// An affine map of the plane: `matrix`·x + `shift`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Affine {
    pub matrix: [[f32; 2]; 2],
    pub shift: [f32; 2],
}

impl Affine {
    pub fn shifted(shift: [f32; 2]) -> Self {
        Self { matrix: [[1.0, 0.0], [0.0, 1.0]], shift }
    }

    pub fn apply(&self, x: f32, y: f32) -> [f32; 2] {
        let along = |i: usize| self.matrix[i][0] * x + self.matrix[i][1] * y + self.shift[i];
        [along(0), along(1)]
    }

    pub fn after(&self, first: &Self) -> Self {
        let (m, f) = (&self.matrix, &first.matrix);
        let entry = |i: usize, j: usize| m[i][0] * f[0][j] + m[i][1] * f[1][j];
        let matrix = [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]];
        Self { matrix, shift: self.apply(first.shift[0], first.shift[1]) }
    }

    pub fn inverse(&self) -> Option<Self> {
        let [[a, b], [c, d]] = self.matrix;
        let determinant = a * d - b * c;
        let matrix = [[d / determinant, -b / determinant], [-c / determinant, a / determinant]];
        let inverse = Self { matrix, shift: [0.0, 0.0] };
        let back = inverse.apply(self.shift[0], self.shift[1]);
        let finite = matrix.iter().flatten().chain(&back).all(|x| x.is_finite());
        finite.then_some(Self { shift: back.map(|x| -x), ..inverse })
    }
}

/// Values of a chip, of mean 0 and standard deviation 1, and the places of a lattice in it.
pub(super) type OnLattice<'a> = (&'a Grid, &'a Affine);

/// Values of a chip, of mean 0 and standard deviation 1.
#[derive(Debug)]
pub(super) struct Grid {
    values: Vec<f32>,
    /// Least columns and rows that can be read, and the first that cannot.
    readable: [[f32; 2]; 2],
}

impl Grid {
    /// `None` for a chip without contrast or with hardly a sample.
    pub fn new(chip: &Chip) -> Option<Self> {
        let seen = chip.seen();
        let count = seen[0].len() * seen[1].len();
        let mut values = vec![0.0; SIDE * SIDE];
        let (mut sum, mut squares) = (0.0f64, 0.0f64);
        for j in seen[1].clone() {
            for i in seen[0].clone() {
                let value = chip.level(i, j);
                values[j * SIDE + i] = value;
                sum += f64::from(value);
                squares += f64::from(value) * f64::from(value);
            }
        }
        let mean = sum / count.max(1) as f64;
        let variance = squares / count.max(1) as f64 - mean * mean;
        if seen.iter().any(|range| range.len() < 4) || variance <= 0.0 {
            return None;
        }
        let (mean, scale) = (mean as f32, variance.sqrt().recip() as f32);
        values.iter_mut().for_each(|x| *x = (*x - mean) * scale);
        // A value between two samples is made from two more on each side.
        Some(Self { values, readable: seen.map(|range| [(range.start + 1) as f32, (range.end - 2) as f32]) })
    }

    /// Map from a lattice around the middle of `chip`, whose axes are the columns of `turn` in steps of `unit_px` input
    /// pixels, to its samples.
    pub fn places(chip: &Chip, unit_px: f32, turn: [[f32; 2]; 2]) -> Affine {
        let scale = unit_px / (STEP * chip.sigma);
        Affine { matrix: turn.map(|row| row.map(|x| scale * x)), shift: [REACH as f32; 2] }
    }

    /// The 4 × 4 samples around a place, and its distance beyond the inner first one; `None` where a sample is missing.
    #[inline(always)]
    fn around(&self, [u, v]: [f32; 2]) -> Option<([&[f32; 4]; 4], f32, f32)> {
        let [columns, rows] = self.readable;
        if !(u >= columns[0] && u < columns[1] && v >= rows[0] && v < rows[1]) {
            return None;
        }
        // Signed and of 32 bits, so that the processor has an instruction for it.
        let (i, j) = (u as i32, v as i32);
        let first = ((j - 1) * SIDE as i32 + i - 1) as usize;
        // One check for all four rows.
        let rows: &[f32; 3 * SIDE + 4] = self.values[first..].first_chunk()?;
        let row = |k: usize| rows[k * SIDE..].first_chunk().expect("four samples in each row");
        Some(([row(0), row(1), row(2), row(3)], u - i as f32, v - j as f32))
    }

    /// Writes values at the points into `values`, and 1 into `seen` where there is one; elsewhere both are 0.
    pub fn read(&self, places: &Affine, points: Points<'_>, values: &mut [f32], seen: &mut [f32]) {
        for (((&x, &y), value), seen) in points.x.iter().zip(points.y).zip(values).zip(seen) {
            (*value, *seen) = (0.0, 0.0);
            if let Some((rows, u, v)) = self.around(places.apply(x, y)) {
                (*value, *seen) = (dot(&columns(&rows, &weights(v)), &weights(u)), 1.0);
            }
        }
    }

    /// As [`Self::read`], with the derivatives along the axes of the points.
    pub fn read_with_gradient(&self, places: &Affine, points: Points<'_>, out: [&mut [f32]; 4]) {
        let [values, along_x, along_y, seen] = out;
        let [[xu, yu], [xv, yv]] = places.matrix;
        for (k, (&x, &y)) in points.x.iter().zip(points.y).enumerate() {
            let found = self.around(places.apply(x, y)).map(|(rows, u, v)| {
                let level = columns(&rows, &weights(v));
                let along_u = dot(&level, &slopes(u));
                let along_v = dot(&columns(&rows, &slopes(v)), &weights(u));
                (dot(&level, &weights(u)), along_u * xu + along_v * xv, along_u * yu + along_v * yv)
            });
            (values[k], along_x[k], along_y[k]) = found.unwrap_or_default();
            seen[k] = f32::from(u8::from(found.is_some()));
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Points<'a> {
    pub x: &'a [f32],
    pub y: &'a [f32],
}

/// Weights of four samples at `t` of 0 … 1 between the middle two: cubic convolution (Keys, 1981).
#[inline(always)]
fn weights(t: f32) -> [f32; 4] {
    [
        t * (-0.5 + t * (1.0 - 0.5 * t)),
        1.0 + t * t * (1.5 * t - 2.5),
        t * (0.5 + t * (2.0 - 1.5 * t)),
        t * t * (0.5 * t - 0.5),
    ]
}

#[inline(always)]
fn slopes(t: f32) -> [f32; 4] {
    [-0.5 + t * (2.0 - 1.5 * t), t * (4.5 * t - 5.0), 0.5 + t * (4.0 - 4.5 * t), t * (1.5 * t - 1.0)]
}

#[inline(always)]
fn columns(rows: &[&[f32; 4]; 4], weights: &[f32; 4]) -> [f32; 4] {
    let mut sums = [0.0; 4];
    for (row, weight) in rows.iter().zip(weights) {
        for (sum, x) in sums.iter_mut().zip(row.iter()) {
            *sum += weight * x;
        }
    }
    sums
}

#[inline(always)]
fn dot(a: &[f32; 4], b: &[f32; 4]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_affine_map_and_its_inverse_undo_one_another() {
        let map = Affine { matrix: [[1.2, -0.3], [0.4, 0.9]], shift: [3.0, -2.0] };
        let none = map.after(&map.inverse().expect("it can be undone"));
        let [u, v] = none.apply(5.0, -7.0);
        assert!((u - 5.0).abs() < 1e-5 && (v + 7.0).abs() < 1e-5, "{none:?}");
        assert_eq!(Affine { matrix: [[1.0, 2.0], [2.0, 4.0]], ..map }.inverse(), None);
    }

    #[test]
    fn between_the_samples_a_parabola_is_exact_with_its_derivatives() {
        let value = |x: f32, y: f32| 0.5 * x * x - 0.2 * x * y + 0.1 * y * y + x - 3.0;
        let values = (0..SIDE * SIDE).map(|k| value((k % SIDE) as f32 - 20.0, (k / SIDE) as f32 - 20.0)).collect();
        let grid = Grid { values, readable: [[1.0, SIDE as f32 - 2.0]; 2] };
        let places = Affine { matrix: [[0.9, -0.4], [0.4, 0.9]], shift: [20.0, 20.0] };
        let (x, y) = ([0.3f32, -4.1, 7.77, 90.0], [0.0f32, 2.6, -5.5, 0.0]);
        let (mut values, mut along_x, mut along_y, mut seen) = ([0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]);
        let into = [&mut values, &mut along_x, &mut along_y, &mut seen].map(|out| &mut out[..]);
        grid.read_with_gradient(&places, Points { x: &x, y: &y }, into);
        assert_eq!(seen, [1.0, 1.0, 1.0, 0.0]);
        let at = |x: f32, y: f32| value(0.9 * x - 0.4 * y, 0.4 * x + 0.9 * y);
        for k in 0..3 {
            let (x, y) = (x[k], y[k]);
            let slopes = [at(x + 0.5, y) - at(x - 0.5, y), at(x, y + 0.5) - at(x, y - 0.5)];
            for (found, expected) in [values[k], along_x[k], along_y[k]].iter().zip([at(x, y), slopes[0], slopes[1]]) {
                assert!((found - expected).abs() < 1e-3, "{k}: {found} {expected}");
            }
        }
        let (mut again, mut seen) = ([0.0; 4], [0.0; 4]);
        grid.read(&places, Points { x: &x, y: &y }, &mut again, &mut seen);
        assert_eq!(again, values);
    }
}
