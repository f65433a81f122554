//! Matched points, and the normalised coordinates in which models are estimated.
//!
//! Pixel coordinates are in the hundreds, so that the terms of an epipolar equation differ by factors of 10⁵ and linear
//! fits lose digits. Estimation therefore uses coordinates around the points' centre and of about unit size (Hartley,
//! "In Defense of the Eight-Point Algorithm", PAMI 1997). Both images share one scale, so that an error in these
//! coordinates is one in pixels up to a factor.

use nalgebra::{Matrix3, Vector3};

/// A matched pair of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RayPair {
    /// Point in image A.
    pub a: [f64; 2],
    /// Point in image B.
    pub b: [f64; 2],
}

impl RayPair {
    pub(super) fn a_homogeneous(&self) -> Vector3<f64> {
        Vector3::new(self.a[0], self.a[1], 1.0)
    }

    pub(super) fn b_homogeneous(&self) -> Vector3<f64> {
        Vector3::new(self.b[0], self.b[1], 1.0)
    }
}

/// Map from pixels to normalised coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Normalisation {
    centre_a: [f64; 2],
    centre_b: [f64; 2],
    /// Normalised units per pixel.
    pub scale: f64,
}

impl Normalisation {
    /// The normalisation of these pairs: their centre becomes 0, and their mean squared distance from it 2.
    pub(super) fn of(pairs: &[RayPair]) -> Self {
        let count = pairs.len().max(1) as f64;
        let mean = |point: fn(&RayPair) -> [f64; 2]| {
            let sum = pairs.iter().map(point).fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
            sum.map(|x| x / count)
        };
        let (centre_a, centre_b) = (mean(|p| p.a), mean(|p| p.b));
        let off = |p: [f64; 2], c: [f64; 2]| (p[0] - c[0]) * (p[0] - c[0]) + (p[1] - c[1]) * (p[1] - c[1]);
        let spread = pairs.iter().map(|p| off(p.a, centre_a) + off(p.b, centre_b)).sum::<f64>() / (2.0 * count);
        let scale = if spread > 0.0 { (2.0 / spread).sqrt() } else { 1.0 };
        Self { centre_a, centre_b, scale }
    }

    pub(super) fn apply(&self, pair: &RayPair) -> RayPair {
        let to = |p: [f64; 2], c: [f64; 2]| [(p[0] - c[0]) * self.scale, (p[1] - c[1]) * self.scale];
        RayPair { a: to(pair.a, self.centre_a), b: to(pair.b, self.centre_b) }
    }

    fn matrix(&self, centre: [f64; 2]) -> Matrix3<f64> {
        let s = self.scale;
        Matrix3::new(s, 0.0, -s * centre[0], 0.0, s, -s * centre[1], 0.0, 0.0, 1.0)
    }

    /// The fundamental matrix of pixels, from the one in normalised coordinates.
    pub(super) fn fundamental_in_pixels(&self, f: &Matrix3<f64>) -> Matrix3<f64> {
        self.matrix(self.centre_b).transpose() * f * self.matrix(self.centre_a)
    }

    /// The homography of pixels from A to B, from the one in normalised coordinates.
    pub(super) fn homography_in_pixels(&self, h: &Matrix3<f64>) -> Matrix3<f64> {
        let s = self.scale;
        let [x, y] = self.centre_b;
        let back = Matrix3::new(1.0 / s, 0.0, x, 0.0, 1.0 / s, y, 0.0, 0.0, 1.0);
        back * h * self.matrix(self.centre_a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_follow_the_points() {
        let pairs: Vec<RayPair> = (0..9)
            .map(|i| f64::from(i * i % 7))
            .map(|x| RayPair { a: [100.0 + x, 50.0 - 2.0 * x * x], b: [x * 30.0, 9.0 + x] })
            .collect();
        let normalisation = Normalisation::of(&pairs);
        let h = Matrix3::new(1.0, 0.2, 3.0, -0.1, 0.9, 4.0, 0.001, -0.002, 1.0);
        let f = Matrix3::new(0.1, 0.2, 0.3, -0.4, 0.5, 0.6, 0.7, -0.8, 0.9);
        let normalised: Vec<RayPair> = pairs.iter().map(|p| normalisation.apply(p)).collect();
        let mean: f64 = normalised.iter().map(|p| p.a[0] + p.a[1] + p.b[0] + p.b[1]).sum();
        assert!(mean.abs() < 1e-12);
        for (pixels, normal) in pairs.iter().zip(&normalised) {
            let mapped = normalisation.homography_in_pixels(&h) * pixels.a_homogeneous();
            let expected = h * normal.a_homogeneous();
            let expected = normalisation
                .apply(&RayPair { a: [0.0; 2], b: [mapped.x / mapped.z, mapped.y / mapped.z] })
                .b
                .map(|x| x * expected.z);
            let got = h * normal.a_homogeneous();
            assert!((expected[0] - got.x).abs() < 1e-9 && (expected[1] - got.y).abs() < 1e-9);
            let value = pixels.b_homogeneous().dot(&(normalisation.fundamental_in_pixels(&f) * pixels.a_homogeneous()));
            assert!((value - normal.b_homogeneous().dot(&(f * normal.a_homogeneous()))).abs() < 1e-9);
        }
    }

    #[test]
    fn equal_points_are_no_division_by_zero() {
        let pairs = [RayPair { a: [3.0, 4.0], b: [5.0, 6.0] }; 4];
        assert_eq!(Normalisation::of(&pairs).apply(&pairs[0]), RayPair { a: [0.0; 2], b: [0.0; 2] });
        assert!(Normalisation::of(&[]).scale.is_finite());
    }
}
