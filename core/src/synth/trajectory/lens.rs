//! The lens and the poses of the camera that moves through a scene.
//!
//! The world is metric, its axes are right, down and forward, as a camera's are; a pose is that of the camera in the
//! world.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// Half a pixel: the centre of the first pixel in COLMAP's convention.
const FIRST_PIXEL: f64 = 0.5;

/// Pinhole camera whose principal point is the middle of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Focal length, pixels.
    pub focal_px: f64,
}

impl Lens {
    /// The column and row of the principal point; the centre of the first pixel is (0, 0).
    fn centre(&self) -> [f64; 2] {
        [0.5 * self.width as f64 - FIRST_PIXEL, 0.5 * self.height as f64 - FIRST_PIXEL]
    }

    /// The direction (x, y, 1) in the camera's axes seen at the pixel (u, v).
    pub fn direction(&self, u: f64, v: f64) -> Vector3<f64> {
        let [cu, cv] = self.centre();
        Vector3::new((u - cu) / self.focal_px, (v - cv) / self.focal_px, 1.0)
    }

    /// The pixel of a point in the camera's axes: column and row, the centre of the first pixel is (0, 0). `None`
    /// behind the camera.
    pub fn pixel(&self, point: &Point3<f64>) -> Option<[f64; 2]> {
        let [cu, cv] = self.centre();
        (point.z > 1e-9).then(|| [cu + self.focal_px * point.x / point.z, cv + self.focal_px * point.y / point.z])
    }

    /// The model's parameters in COLMAP's order and convention (fx, fy, cx, cy; the centre of the first pixel is (0.5,
    /// 0.5)).
    pub fn colmap_params(&self) -> [f64; 4] {
        [self.focal_px, self.focal_px, 0.5 * self.width as f64, 0.5 * self.height as f64]
    }

    /// The text of the camera file that `--camera` reads.
    pub fn to_toml(&self) -> String {
        let Self { width, height, .. } = self;
        format!("model = \"PINHOLE\"\nwidth = {width}\nheight = {height}\nparams = {:?}\n", self.colmap_params())
    }
}

/// Camera during one burst: it moves at constant speed and does not turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BurstCamera {
    /// Pose of the camera in the world at mid-burst.
    pub world_from_camera: Isometry3<f64>,
    /// Motion from one frame to the next, metres, in the world.
    pub step: Vector3<f64>,
}

impl BurstCamera {
    /// The pose of the camera in the world `dt` frames after mid-burst.
    pub fn at(&self, dt: f64) -> Isometry3<f64> {
        Isometry3::from_parts(
            Translation3::from(self.world_from_camera.translation.vector + dt * self.step),
            self.world_from_camera.rotation,
        )
    }

    /// The pixel of a point of the world `dt` frames after mid-burst; see [`Lens::pixel`].
    pub fn pixel_of(&self, lens: &Lens, point: &Point3<f64>, dt: f64) -> Option<[f64; 2]> {
        lens.pixel(&self.at(dt).inverse_transform_point(point))
    }

    /// The pose at mid-burst in the form of trajectory files: `tx ty tz qx qy qz qw` of the camera in the world.
    pub fn tum(&self) -> [f64; 7] {
        let t = &self.world_from_camera.translation;
        let q = &self.world_from_camera.rotation;
        [t.x, t.y, t.z, q.i, q.j, q.k, q.w]
    }
}

/// The rotation by `yaw` to the right, then `pitch` up, then `roll` clockwise, radians. Sine and cosine are `libm`'s,
/// which round alike on every machine.
pub(super) fn turn(yaw: f64, pitch: f64, roll: f64) -> UnitQuaternion<f64> {
    let about = |angle: f64, axis: Vector3<f64>| {
        let imaginary = axis * libm::sin(0.5 * angle);
        Quaternion::from_parts(libm::cos(0.5 * angle), imaginary)
    };
    UnitQuaternion::from_quaternion(about(yaw, Vector3::y()) * about(pitch, Vector3::x()) * about(roll, Vector3::z()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: Lens = Lens { width: 64, height: 48, focal_px: 50.0 };

    #[test]
    fn pixels_and_directions_are_inverse_and_the_middle_looks_ahead() {
        for (u, v) in [(0.0, 0.0), (31.5, 23.5), (63.0, 10.25)] {
            let seen = LENS.pixel(&Point3::from(7.0 * LENS.direction(u, v))).expect("in front");
            assert!((seen[0] - u).abs() < 1e-12 && (seen[1] - v).abs() < 1e-12, "{seen:?}");
        }
        assert_eq!(LENS.direction(31.5, 23.5), Vector3::new(0.0, 0.0, 1.0));
        assert_eq!(LENS.pixel(&Point3::new(0.0, 0.0, -1.0)), None);
    }

    #[test]
    fn a_turn_to_the_right_brings_what_is_there_to_the_middle() {
        let camera = BurstCamera {
            world_from_camera: Isometry3::from_parts(Translation3::identity(), turn(0.3, 0.0, 0.0)),
            step: Vector3::new(0.1, 0.0, 0.0),
        };
        let ahead = Point3::new(0.3f64.sin(), 0.0, 0.3f64.cos());
        let seen = camera.pixel_of(&LENS, &ahead, 0.0).expect("in front");
        assert!((seen[0] - 31.5).abs() < 1e-9 && (seen[1] - 23.5).abs() < 1e-9, "{seen:?}");
        // Positive pitch looks up, against the world's y.
        let up = turn(0.0, 0.2, 0.0) * Vector3::z();
        assert!(up.y < -0.19 && up.x.abs() < 1e-12);
        // The camera moves to the right, so the content moves to the left.
        assert!(camera.pixel_of(&LENS, &ahead, 1.0).expect("in front")[0] < 31.5);
    }
}
