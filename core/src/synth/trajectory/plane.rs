//! Textured planes in space, and their rendering through a pinhole.
//!
//! A plane carries a painted [`Sheet`]. A camera sees it through a homography: the plane's coordinates in a pixel's
//! direction are a quotient of linear functions of the pixel. The texture is averaged over a pixel's area once, at the
//! resolution of the sheet, and is then a fixed smooth function that every frame samples at the pixels' centres: only
//! the geometry moves, by any fraction of a pixel.

use super::lens::Lens;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::{Plane, memory};
use crate::synth::paint::{OVERSAMPLING, Sheet};
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

/// A plane with its texture.
#[derive(Debug, Clone)]
pub struct ScenePlane {
    /// Name of its content.
    pub name: String,
    /// Point of the world at the sheet's (0, 0).
    pub origin: Point3<f64>,
    /// Step in the world of one pixel of the sheet to the right, metres.
    pub right: Vector3<f64>,
    /// Step in the world of one pixel of the sheet downwards, metres.
    pub down: Vector3<f64>,
    texture: Texture,
}

/// Values and alphas of a sheet, averaged over squares of one pixel.
#[derive(Debug, Clone)]
struct Texture {
    width: usize,
    height: usize,
    /// Sample index of the sheet's (0, 0), on each axis.
    first: [f64; 2],
    /// Value times alpha, and alpha.
    samples: Vec<[f32; 2]>,
}

/// Content of a plane at a pixel.
#[derive(Debug, Clone, Copy)]
struct Hit {
    /// 1 / depth in front of the camera, 1/m.
    inverse_depth: f64,
    value: f32,
    alpha: f32,
}

impl Texture {
    fn of(sheet: &Sheet) -> Self {
        const N: usize = OVERSAMPLING;
        let (columns, rows) = sheet.size();
        let (width, height) = (columns + 1 - N, rows + 1 - N);
        let mut samples: Vec<[f32; 2]> = memory::zeroed(width * height);
        let share = 1.0 / (N * N) as f32;
        for (row, out) in samples.chunks_mut(width).enumerate() {
            for below in 0..N {
                let (values, alphas) = sheet.row(row + below);
                for (column, sample) in out.iter_mut().enumerate() {
                    sample[0] += share * values[column..column + N].iter().sum::<f32>();
                    sample[1] += share * alphas[column..column + N].iter().sum::<f32>();
                }
            }
        }
        // A mean over N samples is located at their middle.
        let shift = 0.5 * (N as f64 - 1.0);
        Self { width, height, first: [sheet.column_of(0.0) - shift, sheet.row_of(0.0) - shift], samples }
    }

    /// Value times alpha, and alpha, at the sheet's position (p, q), by Catmull–Rom; `None` outside.
    fn at(&self, p: f64, q: f64) -> Option<[f32; 2]> {
        let x = self.first[0] + OVERSAMPLING as f64 * p;
        let y = self.first[1] + OVERSAMPLING as f64 * q;
        let inside = |x: f64, samples: usize| x >= 1.0 && x < (samples - 2) as f64;
        if !(inside(x, self.width) && inside(y, self.height)) {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        let (weights_u, weights_v) = (cubic((x - column as f64) as f32), cubic((y - row as f64) as f32));
        let mut sum = [0.0f32; 2];
        for (k, weight_v) in weights_v.iter().enumerate() {
            let start = (row + k - 1) * self.width + column - 1;
            for (sample, weight_u) in self.samples[start..start + 4].iter().zip(&weights_u) {
                sum[0] += weight_u * weight_v * sample[0];
                sum[1] += weight_u * weight_v * sample[1];
            }
        }
        Some(sum)
    }
}

/// The Catmull–Rom weights of the four samples around a position at the fraction `f` between the middle two.
fn cubic(f: f32) -> [f32; 4] {
    [
        ((-0.5 * f + 1.0) * f - 0.5) * f,
        (1.5 * f - 2.5) * f * f + 1.0,
        ((-1.5 * f + 2.0) * f + 0.5) * f,
        (0.5 * f - 0.5) * f * f,
    ]
}

impl ScenePlane {
    /// The plane that carries `sheet`, whose (0, 0) is at `origin`.
    pub fn new(name: &str, origin: Point3<f64>, right: Vector3<f64>, down: Vector3<f64>, sheet: &Sheet) -> Self {
        Self { name: name.to_owned(), origin, right, down, texture: Texture::of(sheet) }
    }

    /// The point of the world at the sheet's position (p, q).
    pub fn point(&self, p: f64, q: f64) -> Point3<f64> {
        self.origin + p * self.right + q * self.down
    }

    /// The matrix G for which G·(x, y, 1) = (p, q, 1) / depth where the direction (x, y, 1) of the camera meets the
    /// plane; `None` where the camera lies in the plane.
    fn plane_from_direction(&self, world_from_camera: &Isometry3<f64>) -> Option<Matrix3<f64>> {
        let turn = world_from_camera.rotation.inverse();
        let origin = world_from_camera.inverse_transform_point(&self.origin).coords;
        Matrix3::from_columns(&[turn * self.right, turn * self.down, origin]).try_inverse()
    }
}

/// The sheet's position (p, q) and the inverse depth (1/m) where a direction meets a plane, given its matrix; `None`
/// where it does not meet it in front of the camera.
fn meet(matrix: &Matrix3<f64>, direction: &Vector3<f64>) -> Option<(f64, f64, f64)> {
    let met = matrix * direction;
    (met.z > 1e-9).then(|| (met.x / met.z, met.y / met.z, met.z))
}

/// Renders `planes` without noise from a camera in the world: the signal at each pixel, as painted. Nearer planes are
/// composited over farther ones; without any plane the signal is 0.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn render(
    planes: &[ScenePlane],
    lens: &Lens,
    world_from_camera: &Isometry3<f64>,
    monitor: &Monitor,
) -> Result<Plane, Cancelled> {
    let seen: Vec<(&ScenePlane, Matrix3<f64>)> =
        planes.iter().filter_map(|plane| Some((plane, plane.plane_from_direction(world_from_camera)?))).collect();
    let mut picture = Plane::zeros(lens.width, lens.height);
    let mut hits: Vec<Hit> = Vec::with_capacity(planes.len());
    for v in 0..lens.height {
        monitor.check()?;
        for (u, pixel) in picture.row_mut(v).iter_mut().enumerate() {
            let direction = lens.direction(u as f64, v as f64);
            hits.clear();
            hits.extend(seen.iter().filter_map(|(plane, matrix)| {
                let (p, q, inverse_depth) = meet(matrix, &direction)?;
                let [value, alpha] = plane.texture.at(p, q)?;
                (alpha != 0.0).then_some(Hit { inverse_depth, value, alpha })
            }));
            hits.sort_by(|a, b| a.inverse_depth.total_cmp(&b.inverse_depth));
            *pixel = hits.iter().fold(0.0, |under, hit| under * (1.0 - hit.alpha) + hit.value);
        }
    }
    Ok(picture)
}

/// The nearest point of the world at the pixel (u, v), among planes that cover at least half of it; `None` where none
/// does.
pub fn nearest_point(
    planes: &[ScenePlane],
    lens: &Lens,
    world_from_camera: &Isometry3<f64>,
    u: f64,
    v: f64,
) -> Option<Point3<f64>> {
    let direction = lens.direction(u, v);
    let met = planes.iter().filter_map(|plane| {
        let (p, q, inverse_depth) = meet(&plane.plane_from_direction(world_from_camera)?, &direction)?;
        (plane.texture.at(p, q)?[1] >= 0.5).then(|| (inverse_depth, plane.point(p, q)))
    });
    met.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, point)| point)
}
