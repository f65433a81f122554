//! The features of one image near the place that a geometry expects for a feature of the other.

use super::linear::{Homography, mapped, squared_error};
use super::model::{TwoViewModel, straight_fundamental, straightened};
use super::points::RayPair;
use nalgebra::{Matrix3, Vector3};

/// For each feature of one image the features of the other with an error of at most a limit, as
/// [`TwoViewModel::error_px`] has it.
#[derive(Debug)]
pub struct GuidingBand {
    max_squared: f64,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    /// The epipolar line of each feature, and the other image's features; each with the squared length of the first two
    /// elements of its line.
    Epipolar { lines: Vec<(Vector3<f64>, f64)>, others: Vec<([f64; 2], f64)> },
    /// From the features to the others.
    Homography { homography: Homography, places: Vec<[f64; 2]>, others: Vec<[f64; 2]> },
}

impl TwoViewModel {
    /// The features `b` of image B near the places that are expected for the features `a` of image A, to
    /// `max_error_px`.
    pub fn band_in_b(&self, a: &[[f64; 2]], b: &[[f64; 2]], max_error_px: f64) -> GuidingBand {
        self.band(a, b, max_error_px, false)
    }

    /// The features `a` of image A near the places that are expected for the features `b` of image B, to
    /// `max_error_px`.
    pub fn band_in_a(&self, a: &[[f64; 2]], b: &[[f64; 2]], max_error_px: f64) -> GuidingBand {
        self.band(b, a, max_error_px, true)
    }

    fn band(&self, from: &[[f64; 2]], to: &[[f64; 2]], max_error_px: f64, into_a: bool) -> GuidingBand {
        let max_squared = max_error_px * max_error_px;
        let epipolar = |there: &Matrix3<f64>, straight: &dyn Fn(&[f64; 2]) -> [f64; 2]| {
            let there = if into_a { there.transpose() } else { *there };
            let line = |matrix: &Matrix3<f64>, [u, v]: [f64; 2]| {
                let line = matrix * Vector3::new(u, v, 1.0);
                (line, line.x * line.x + line.y * line.y)
            };
            let lines = from.iter().map(|place| line(&there, straight(place))).collect();
            let back = there.transpose();
            let others = to.iter().map(straight).map(|place| (place, line(&back, place).1)).collect();
            Kind::Epipolar { lines, others }
        };
        let kind = match self {
            Self::Fundamental { fundamental } => epipolar(fundamental, &|place| *place),
            Self::Essential { essential, camera } => {
                epipolar(&straight_fundamental(essential, camera), &|place| straightened(camera, *place))
            }
            Self::Homography { forward, backward } => {
                let (forward, backward) = if into_a { (*backward, *forward) } else { (*forward, *backward) };
                let homography = Homography { forward, backward };
                Kind::Homography { homography, places: from.to_vec(), others: to.to_vec() }
            }
        };
        GuidingBand { max_squared, kind }
    }
}

impl GuidingBand {
    /// Calls `on` with the index of each feature of the other image near the place expected for feature `index`, in
    /// order.
    pub fn for_each_within(&self, index: usize, mut on: impl FnMut(usize)) {
        match &self.kind {
            Kind::Epipolar { lines, others } => {
                let (line, gradient) = &lines[index];
                for (other, ([u, v], other_gradient)) in others.iter().enumerate() {
                    let value = line.x * u + line.y * v + line.z;
                    if value * value <= self.max_squared * (gradient + other_gradient) {
                        on(other);
                    }
                }
            }
            Kind::Homography { homography, places, others } => {
                let Some([u, v]) = mapped(&homography.forward, places[index]) else { return };
                // The mean of two squared distances is within the limit only if neither passes twice of it.
                let reach = (2.0 * self.max_squared).sqrt();
                for (other, b) in
                    others.iter().enumerate().filter(|(_, b)| (b[0] - u).abs().max((b[1] - v).abs()) <= reach)
                {
                    if squared_error(homography, &RayPair { a: places[index], b: *b }) <= self.max_squared {
                        on(other);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{camera_bending, scene_in_space};
    use crate::matching::{Geometry, MatchParams, PointPair, verify};
    use crate::monitor::Monitor;
    use crate::synth::random::Stream;

    #[test]
    fn a_band_holds_what_has_a_small_error() {
        let mut random = Stream::new(0, 5);
        let scene = scene_in_space(&mut random, 120);
        let pairs: Vec<PointPair> = scene.iter().map(|&(a, b)| PointPair { a, b, rank: 0.0 }).collect();
        let (a, b): (Vec<[f64; 2]>, Vec<[f64; 2]>) = scene.into_iter().unzip();
        for (geometry, limit) in
            [(Geometry::Fundamental, 3.0), (Geometry::Essential, 5.0), (Geometry::Homography, 90.0)]
        {
            let camera = (geometry == Geometry::Essential).then(camera_bending);
            let params = MatchParams { geometry, camera, max_error_px: 60.0, min_inliers: 4, ..MatchParams::default() };
            let found = verify(&pairs, &params, &Monitor::default()).expect("valid").expect("asked for");
            let model = found.model.expect("a model");
            let (in_b, in_a) = (model.band_in_b(&a, &b, limit), model.band_in_a(&a, &b, limit));
            let mut held = 0;
            for i in 0..a.len() {
                let (mut there, mut back) = (Vec::new(), Vec::new());
                in_b.for_each_within(i, |j| there.push(j));
                in_a.for_each_within(i, |j| back.push(j));
                let near = |a: [f64; 2], b: [f64; 2]| model.error_px(a, b) <= limit;
                assert_eq!(there, (0..b.len()).filter(|&j| near(a[i], b[j])).collect::<Vec<_>>(), "{geometry:?}");
                assert_eq!(back, (0..a.len()).filter(|&j| near(a[j], b[i])).collect::<Vec<_>>(), "{geometry:?}");
                held += there.len();
            }
            assert!(held > 100, "{geometry:?}: {held}");
        }
    }
}
