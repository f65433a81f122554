//! The geometry of two views, in pixels: the locus of a point's match, and the error of a match.

use super::essential::{RelativePose, pose_in_front};
use super::linear::{Homography, mapped, sampson_squared, squared_error};
use super::points::RayPair;
use crate::camera::Camera;
use crate::matching::params::{Geometry, MatchParams};
use nalgebra::{Matrix3, Vector3};

/// Relation between the points of image A and those of image B, in pixels; the centre of the first one is (0, 0).
#[derive(Debug, Clone, PartialEq)]
pub enum TwoViewModel {
    /// Any scene, unknown cameras: x_bᵀ·F·x_a = 0 for pixels x = (u, v, 1).
    Fundamental {
        /// F, of rank 2, with elements whose squares sum to 1.
        fundamental: Matrix3<f64>,
    },
    /// Any scene, known cameras: d_bᵀ·E·d_a = 0 for their directions d = (x, y, 1).
    Essential {
        /// `E = [t]×·R` with |t| = 1.
        essential: Matrix3<f64>,
        /// Cameras of A and of B.
        cameras: [Camera; 2],
    },
    /// A plane, or a camera that only turned: x_b ~ H·x_a for pixels x = (u, v, 1).
    Homography {
        /// H, from A to B.
        forward: Matrix3<f64>,
        /// Inverse of H, from B to A.
        backward: Matrix3<f64>,
    },
}

/// Number of points of a line that is bent by the lens.
const CURVE_POINTS: usize = 65;

impl TwoViewModel {
    /// The model of the geometry of `params` with this matrix, as [`Self::matrix`] gives it; `None` without a geometry,
    /// and for a homography without an inverse.
    pub fn of(matrix: Matrix3<f64>, params: &MatchParams) -> Option<Self> {
        match (params.geometry, params.cameras()) {
            (Geometry::Fundamental, _) => Some(Self::Fundamental { fundamental: matrix }),
            (Geometry::Essential, Some(cameras)) => {
                Some(Self::Essential { essential: matrix, cameras: cameras.map(Camera::clone) })
            }
            (Geometry::Homography, _) => Some(Self::Homography { forward: matrix, backward: matrix.try_inverse()? }),
            (Geometry::None | Geometry::Essential, _) => None,
        }
    }

    /// F, E, or H from A to B.
    pub fn matrix(&self) -> &Matrix3<f64> {
        match self {
            Self::Fundamental { fundamental: matrix }
            | Self::Essential { essential: matrix, .. }
            | Self::Homography { forward: matrix, .. } => matrix,
        }
    }

    /// Error of the match of `a` in image A with `b` in image B, in pixels: the Sampson distance (to first order, how
    /// far both points together must move to satisfy it) with the lens's distortion removed, or the root mean square of
    /// a homography's transfers in A and in B. Infinite at the epipoles and behind the camera.
    pub fn error_px(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        let pair = RayPair { a: self.straight(0, a), b: self.straight(1, b) };
        let squared = match self {
            Self::Fundamental { fundamental } => sampson_squared(fundamental, &pair),
            Self::Essential { essential, cameras } => sampson_squared(&straight_fundamental(essential, cameras), &pair),
            Self::Homography { forward, backward } => {
                squared_error(&Homography { forward: *forward, backward: *backward }, &pair)
            }
        };
        if squared.is_nan() { f64::INFINITY } else { squared.sqrt() }
    }

    /// Places in A (`image` 0) or B (1), of `size` (columns, rows), where `point` of the other image may be: a line of
    /// (u, v); one for a homography. Panics for another `image`.
    pub fn locus(&self, image: usize, point: [f64; 2], size: (usize, usize)) -> Vec<[f64; 2]> {
        let into_a = image == 0;
        let turned = |m: &Matrix3<f64>| if into_a { m.transpose() } else { *m };
        let line = |m: &Matrix3<f64>, [u, v]: [f64; 2]| turned(m) * Vector3::new(u, v, 1.0);
        let straight = |line| clipped(&line, Bounds::of_image(size)).map_or_else(Vec::new, Vec::from);
        match self {
            Self::Fundamental { fundamental } => straight(line(fundamental, point)),
            Self::Essential { essential, cameras } => {
                let line = line(&straight_fundamental(essential, cameras), self.straight(1 - image, point));
                let camera = &cameras[image];
                // A lens bends the line, which then needs many points.
                if camera.is_straight() { straight(line) } else { bent(&line, camera, size) }
            }
            Self::Homography { forward, backward } => {
                let there = mapped(if into_a { backward } else { forward }, point);
                there.into_iter().filter(|p| Bounds::of_image(size).contains(*p)).collect()
            }
        }
    }

    /// The pixel at which a camera without distortion would see what that of A (`image` 0) or B (1) sees at `pixel`.
    pub(crate) fn straight(&self, image: usize, pixel: [f64; 2]) -> [f64; 2] {
        if let Self::Essential { cameras, .. } = self { straightened(&cameras[image], pixel) } else { pixel }
    }

    /// The pixel at which the camera of B sees what one without distortion would see at `straight`.
    pub(crate) fn seen_in_b(&self, straight: [f64; 2]) -> [f64; 2] {
        if let Self::Essential { cameras: [_, b], .. } = self { seen_by(b, straight) } else { straight }
    }

    /// The relative pose with most `pairs` in front of both cameras, and their number; of an essential matrix only.
    pub fn relative_pose(&self, pairs: &[([f64; 2], [f64; 2])]) -> Option<(RelativePose, usize)> {
        let Self::Essential { essential, cameras: [of_a, of_b] } = self else { return None };
        let directions: Vec<RayPair> =
            pairs.iter().map(|(a, b)| RayPair { a: of_a.direction_of(*a), b: of_b.direction_of(*b) }).collect();
        pose_in_front(essential, directions.iter())
    }
}

/// The pixel at which a camera without distortion would see what this one sees at `pixel`.
pub(super) fn straightened(camera: &Camera, pixel: [f64; 2]) -> [f64; 2] {
    let [x, y] = camera.direction_of(pixel);
    let seen = camera.matrix() * Vector3::new(x, y, 1.0);
    [seen.x, seen.y]
}

fn seen_by(camera: &Camera, straight: [f64; 2]) -> [f64; 2] {
    let k = camera.matrix();
    camera.pixel_of([(straight[0] - k.m13) / k.m11, (straight[1] - k.m23) / k.m22])
}

fn straight_fundamental(essential: &Matrix3<f64>, cameras: &[Camera; 2]) -> Matrix3<f64> {
    let [of_a, of_b] = cameras.each_ref().map(|camera| {
        let k = camera.matrix();
        let (fx, fy, cx, cy) = (k.m11, k.m22, k.m13, k.m23);
        Matrix3::new(1.0 / fx, 0.0, -cx / fx, 0.0, 1.0 / fy, -cy / fy, 0.0, 0.0, 1.0)
    });
    of_b.transpose() * essential * of_a
}

#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    /// An image, to the outer edges of its pixels.
    fn of_image(size: (usize, usize)) -> Self {
        Self { low: [-0.5; 2], high: [size.0 as f64 - 0.5, size.1 as f64 - 0.5] }
    }

    fn contains(&self, p: [f64; 2]) -> bool {
        (0..2).all(|i| (self.low[i]..=self.high[i]).contains(&p[i]))
    }
}

/// The piece of the line a·u + b·v + c = 0 inside `bounds`.
fn clipped(line: &Vector3<f64>, bounds: Bounds) -> Option<[[f64; 2]; 2]> {
    let normal = [line.x, line.y];
    let squared = normal[0] * normal[0] + normal[1] * normal[1];
    if squared <= 0.0 || squared.is_nan() {
        return None;
    }
    let from = normal.map(|n| -n * line.z / squared);
    let along = [-normal[1], normal[0]];
    // The piece between each pair of opposite sides; what both pieces share is inside.
    let (mut start, mut end) = (f64::NEG_INFINITY, f64::INFINITY);
    for i in 0..2 {
        if along[i] == 0.0 {
            if !(bounds.low[i]..=bounds.high[i]).contains(&from[i]) {
                return None;
            }
            continue;
        }
        let (s, t) = ((bounds.low[i] - from[i]) / along[i], (bounds.high[i] - from[i]) / along[i]);
        (start, end) = (start.max(s.min(t)), end.min(s.max(t)));
    }
    let at = |s: f64| [from[0] + s * along[0], from[1] + s * along[1]];
    (start < end).then(|| [at(start), at(end)])
}

/// The image of a line of straightened pixels through the lens, within an image of `size`.
fn bent(line: &Vector3<f64>, camera: &Camera, size: (usize, usize)) -> Vec<[f64; 2]> {
    let image = Bounds::of_image(size);
    // Extent of the image without the distortion, along its border, because a lens may bend the corners in or out.
    let mut reach = Bounds { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
    for step in 0..=8 {
        let part = f64::from(step) / 8.0;
        let across = [0, 1].map(|i| image.low[i] + part * (image.high[i] - image.low[i]));
        let ([x, y], [left, top], [right, bottom]) = (across, image.low, image.high);
        for p in [[x, top], [x, bottom], [left, y], [right, y]] {
            let p = straightened(camera, p);
            reach =
                Bounds { low: [0, 1].map(|i| reach.low[i].min(p[i])), high: [0, 1].map(|i| reach.high[i].max(p[i])) };
        }
    }
    let Some([start, end]) = clipped(line, reach) else { return Vec::new() };
    let seen = |part: f64| {
        let straight = [0, 1].map(|i| start[i] + part * (end[i] - start[i]));
        let pixel = seen_by(camera, straight);
        // Far outside, strong distortion folds the plane back into the image; such points are not visible there.
        let back = straightened(camera, pixel);
        let is_seen = image.contains(pixel) && (0..2).all(|i| (back[i] - straight[i]).abs() < 0.01);
        is_seen.then_some(pixel)
    };
    let mut curve = Vec::new();
    let mut last = (0.0, seen(0.0));
    curve.extend(last.1);
    for step in 1..CURVE_POINTS {
        let part = step as f64 / (CURVE_POINTS - 1) as f64;
        let next = (part, seen(part));
        if last.1.is_some() != next.1.is_some() {
            // The curve crosses the border in between.
            let (mut inside, mut outside) = if last.1.is_some() { (last.0, part) } else { (part, last.0) };
            for _ in 0..20 {
                let middle = 0.5 * (inside + outside);
                *(if seen(middle).is_some() { &mut inside } else { &mut outside }) = middle;
            }
            curve.extend(seen(inside));
        }
        curve.extend(next.1);
        last = next;
    }
    curve
}
