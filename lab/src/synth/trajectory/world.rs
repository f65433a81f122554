//! The world of a trajectory: textured planes, the lens, a wall with boards before it, and the path past them.
//!
//! The world is metric, with axes right, down and forward like a camera's; poses are of the camera in the world.
//!
//! A plane carries a painted [`Sheet`]. A camera sees it through a homography: the plane's coordinates in a pixel's
//! direction are a quotient of linear functions of the pixel. The texture is averaged over a pixel's area once, at the
//! resolution of the sheet, and is then a fixed smooth function that every frame samples at the pixels' centres: only
//! the geometry moves, by any fraction of a pixel.

use super::{TrajectoryParams, leaves::paint_leaves};
use crate::synth::paint::{Area, OVERSAMPLING, Sheet};
use crate::synth::{Motion, random::Stream};
use burstscope_core::error::{Error, Result};
use burstscope_core::monitor::{Cancelled, Monitor};
use burstscope_core::plane::{Plane, memory};
use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// Distance of the wall, metres.
const WALL_DEPTH: f64 = 5.0;
/// Ratio of the depth of the nearest plane to that of the wall.
const NEAREST_SHARE: f64 = 0.55;
/// Values of a texture's leaves, as fractions of scene white.
const LEAF_VALUES: std::ops::RangeInclusive<f64> = 0.06..=1.0;
/// Radius of the finest leaves, pixels.
const FINEST_LEAF: f64 = 1.5;
/// Stream of the seed for the layout; those from `TEXTURE_STREAM` on are for textures. Frames use those from 1 on.
const LAYOUT_STREAM: u64 = 0;
const TEXTURE_STREAM: u64 = 1 << 40;
/// Maximum number of samples of the textures of all planes together: 1 GiB.
const MAX_SAMPLES: usize = 1 << 27;

/// The camera at each mid-burst, and the direction of its motion during the burst, in its own axes.
pub(super) fn stations(params: &TrajectoryParams) -> Vec<(Isometry3<f64>, Vector3<f64>)> {
    let mut stream = Stream::new(params.seed, LAYOUT_STREAM);
    let gaps = params.bursts.saturating_sub(1) as f64;
    let (sideways, forward) = match params.motion {
        Motion::OneD => ((0.25 * gaps).min(2.0), 0.0),
        Motion::TwoD => ((0.12 * gaps).min(1.0), (0.2 * gaps).min(1.2)),
    };
    let station = |index: usize| {
        let along = if gaps > 0.0 { index as f64 / gaps - 0.5 } else { 0.0 };
        let mut jitter = |reach: f64| stream.within(-reach, reach);
        // A path that is not quite straight: about a straight one an alignment of poses would be undetermined.
        let x = sideways * along;
        let (y, z) = (jitter(0.05), forward * along - 0.4 * sideways * along * along + jitter(0.03));
        // It looks half towards the middle of the scene, like a camera that films a scene in passing.
        let yaw = 0.6 * libm::atan2(-x, 0.8 * WALL_DEPTH - z) + jitter(0.02);
        let rotation = turn(yaw, jitter(0.02), jitter(0.03));
        let side = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let heading = if params.motion == Motion::OneD { Vector3::x() } else { Vector3::new(0.12, 0.04 * side, 0.35) };
        (Isometry3::from_parts(Translation3::new(x, y, z), rotation), heading)
    };
    (0..params.bursts).map(station).collect()
}

/// The painted planes, large enough for all that is seen from `stations`; an error where a sheet would be too large.
pub(super) fn planes(
    params: &TrajectoryParams,
    lens: &Lens,
    stations: &[(Isometry3<f64>, Vector3<f64>)],
    monitor: &Monitor,
) -> Result<Vec<ScenePlane>> {
    (0..params.planes)
        .map(|index| {
            monitor.check()?;
            let mut stream = Stream::new(params.seed, TEXTURE_STREAM + index as u64);
            let nearer = if params.planes > 1 { index as f64 / (params.planes - 1) as f64 } else { 0.0 };
            let depth = WALL_DEPTH * (1.0 - (1.0 - NEAREST_SHARE) * nearer);
            let slant = turn(stream.within(-0.1, 0.1), stream.within(-0.08, 0.08), 0.0);
            let pixel = depth / lens.focal_px;
            let frame = Frame {
                centre: Point3::new(0.0, 0.0, depth),
                right: slant * Vector3::new(pixel, 0.0, 0.0),
                down: slant * Vector3::new(0.0, pixel, 0.0),
            };
            // The part seen at mid-burst, and the motion of content from there to the first and last frame.
            let way = 1.5 * params.max_slope * 0.5 * (params.frames - 1) as f64;
            let way = way + lens.focal_px * params.shake_deg.to_radians();
            let [left, top, right, bottom] = frame.seen_from(lens, stations, way + 8.0)?;
            let (width, height) = ((right - left).ceil() as usize, (bottom - top).ceil() as usize);
            if (width + 16) * (height + 16) > MAX_SAMPLES / (4 * params.planes) {
                let problem = format!("{} planes of {width}×{height} pixels take too much memory", params.planes);
                return Err(Error::param("width", problem, "make smaller frames or fewer planes"));
            }
            let mut sheet = Sheet::new(width, height, 4, 4);
            let coarsest = (0.1 * lens.width.min(lens.height) as f64).max(2.0 * FINEST_LEAF);
            paint_leaves(&mut sheet, &(FINEST_LEAF..=coarsest), &LEAF_VALUES, &mut stream);
            // The wall stays whole, so that every gap between boards shows texture.
            if index > 0 {
                sheet.keep_where(&boards((width, height), lens, &mut stream));
            }
            let name = if index == 0 { "wall".to_owned() } else { format!("boards {index}") };
            let origin = frame.centre + left * frame.right + top * frame.down;
            Ok(ScenePlane::new(&name, origin, frame.right, frame.down, &sheet))
        })
        .collect()
}

/// Plane without a size: a point on it, and the step of one pixel on each axis.
struct Frame {
    centre: Point3<f64>,
    right: Vector3<f64>,
    down: Vector3<f64>,
}

impl Frame {
    /// Part of the plane seen from the stations, with a margin: `[left, top, right, bottom]`, pixels from the centre.
    fn seen_from(&self, lens: &Lens, stations: &[(Isometry3<f64>, Vector3<f64>)], margin: f64) -> Result<[f64; 4]> {
        let mut seen = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let normal = self.right.cross(&self.down);
        let (width, height) = (lens.width as f64, lens.height as f64);
        for (camera, _) in stations {
            for (u, v) in [(-0.5, -0.5), (width - 0.5, -0.5), (-0.5, height - 0.5), (width - 0.5, height - 0.5)] {
                let direction = camera.rotation * lens.direction(u, v);
                // A ray that meets the plane behind the camera, or not at all, would need an endless sheet.
                let along = normal.dot(&direction);
                let depth = normal.dot(&(self.centre.coords - camera.translation.vector)) / along;
                if !(depth.is_finite() && depth > 0.0) {
                    let problem = "a camera looks past a plane of the scene";
                    return Err(Error::param("bursts", problem, "make fewer bursts"));
                }
                let from_centre = camera.translation.vector + depth * direction - self.centre.coords;
                let p = from_centre.dot(&self.right) / self.right.norm_squared();
                let q = from_centre.dot(&self.down) / self.down.norm_squared();
                seen = [seen[0].min(p), seen[1].min(q), seen[2].max(p), seen[3].max(q)];
            }
        }
        Ok([seen[0] - margin, seen[1] - margin, seen[2] + margin, seen[3] + margin])
    }
}

/// Boards on a loose grid, as the mask of a sheet.
fn boards(size: (usize, usize), lens: &Lens, stream: &mut Stream) -> Sheet {
    let mut mask = Sheet::new(size.0, size.1, 4, 4);
    let cell = 0.45 * lens.height as f64;
    let (columns, rows) = ((size.0 as f64 / cell).ceil() as usize, (size.1 as f64 / cell).ceil() as usize);
    for row in 0..rows {
        for column in 0..columns {
            // An absent board draws its numbers too, so that the other boards do not depend on it.
            let there = stream.uniform() < 0.4;
            let (half_u, half_v) = (cell * stream.within(0.3, 0.48), cell * stream.within(0.3, 0.48));
            let u = cell * (column as f64 + stream.within(0.4, 0.6));
            let v = cell * (row as f64 + stream.within(0.4, 0.6));
            if there {
                let (u0, v0) = ((u - half_u) as f32, (v - half_v) as f32);
                mask.rectangle(Area::new(u0, v0, (u + half_u) as f32, (v + half_v) as f32), 1.0);
            }
        }
    }
    mask
}

/// Points of the world that the camera sees on a grid over its image.
fn points_seen(planes: &[ScenePlane], lens: &Lens, camera: &Isometry3<f64>) -> Vec<Point3<f64>> {
    const STEPS: usize = 32;
    let place = |k: usize, pixels: usize| (pixels - 1) as f64 * k as f64 / (STEPS - 1) as f64;
    let grid = (0..STEPS).flat_map(|j| (0..STEPS).map(move |i| (i, j)));
    grid.filter_map(|(i, j)| nearest_point(planes, lens, camera, place(i, lens.width), place(j, lens.height))).collect()
}

/// Apparent motions of `points` as means over each half of the burst, px/frame; empty for a burst of one frame.
fn motions(camera: &BurstCamera, lens: &Lens, points: &[Point3<f64>], half_span: f64) -> Vec<[f64; 2]> {
    let halves = points.iter().flat_map(|point| [-half_span, half_span].map(|dt| (point, dt)));
    let motion = |(point, dt): (&Point3<f64>, f64)| {
        let (from, to) = (camera.pixel_of(lens, point, 0.0)?, camera.pixel_of(lens, point, dt)?);
        (dt != 0.0).then(|| [(to[0] - from[0]) / dt, (to[1] - from[1]) / dt])
    };
    halves.filter_map(motion).collect()
}

/// Camera of a burst whose largest apparent motion on an axis is `max_slope` px/frame; [min, max] motion in u and v.
pub(super) fn burst_camera(
    params: &TrajectoryParams,
    lens: &Lens,
    planes: &[ScenePlane],
    station: &(Isometry3<f64>, Vector3<f64>),
    monitor: &Monitor,
) -> Result<(BurstCamera, [[f64; 2]; 2]), Cancelled> {
    monitor.check()?;
    let (world_from_camera, heading) = *station;
    let half_span = 0.5 * (params.frames - 1) as f64;
    let points = points_seen(planes, lens, &world_from_camera);
    let at_speed = |speed: f64| {
        let step = world_from_camera.rotation * (speed * heading);
        BurstCamera { world_from_camera, step, shake: Shake::default() }
    };
    let largest = |motions: &[[f64; 2]]| motions.iter().flatten().fold(0.0f64, |max, x| max.max(x.abs()));
    // A start near 0, where apparent motion is proportional to the speed.
    let mut speed = if half_span > 0.0 && params.max_slope > 0.0 { 1e-4 } else { 0.0 };
    // Apparent motion is nearly proportional to speed, so a few corrections converge.
    for _ in 0..6 {
        let max = largest(&motions(&at_speed(speed), lens, &points, half_span));
        if max > 0.0 {
            speed *= params.max_slope / max;
        }
    }
    let camera = at_speed(speed);
    let motions = motions(&camera, lens, &points, half_span);
    let range = |axis: usize| {
        let values = motions.iter().map(|motion| [motion[axis]; 2]);
        values.reduce(|[low, high], [x, _]| [low.min(x), high.max(x)]).unwrap_or_default()
    };
    Ok((camera, [range(0), range(1)]))
}

/// Half a pixel: the centre of the first pixel in COLMAP's convention.
const FIRST_PIXEL: f64 = 0.5;

/// Pinhole camera whose principal point is the middle of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct Lens {
    pub width: usize,
    pub height: usize,
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

    /// The pixel (column, row) of a point in the camera's axes; the first pixel's centre is (0, 0). `None` behind.
    pub fn pixel(&self, point: &Point3<f64>) -> Option<[f64; 2]> {
        let [cu, cv] = self.centre();
        (point.z > 1e-9).then(|| [cu + self.focal_px * point.x / point.z, cv + self.focal_px * point.y / point.z])
    }

    /// Parameters fx, fy, cx, cy in COLMAP's convention: the centre of the first pixel is (0.5, 0.5).
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
    /// Turning beside the step.
    pub shake: Shake,
}

/// Uneven turning of a camera, as of a hand: none at mid-burst. Angles are pitch, yaw and roll, radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shake {
    /// Angles that go to and fro.
    swing: Vector3<f64>,
    /// Angles at the ends of the burst, alike at both.
    nod: Vector3<f64>,
    /// Phase of both, radians a frame.
    rate: f64,
}

impl Shake {
    /// Shake of burst `index`, about an axis of its own.
    pub(super) fn of(params: &TrajectoryParams, index: usize) -> Self {
        let (angle, half_span) = (2.4 * index as f64, 0.5 * (params.frames as f64 - 1.0).max(1.0));
        let (sin, cos, size) = (libm::sin(angle), libm::cos(angle), params.shake_deg.to_radians());
        let [swing, nod] = [Vector3::new(cos, sin, 0.3) * (0.45 * size), Vector3::new(-sin, cos, -0.3) * (0.2 * size)];
        Self { swing, nod, rate: 2.5 / half_span }
    }

    fn at(&self, dt: f64) -> UnitQuaternion<f64> {
        let phase = self.rate * dt;
        let angles = self.swing * libm::sin(phase) + self.nod * (1.0 - libm::cos(phase));
        turn(angles.y, angles.x, angles.z)
    }
}

impl BurstCamera {
    /// The pose of the camera in the world `dt` frames after mid-burst.
    pub fn at(&self, dt: f64) -> Isometry3<f64> {
        let place = Translation3::from(self.world_from_camera.translation.vector + dt * self.step);
        let rotation = self.world_from_camera.rotation;
        // Bits of a camera that does not turn stay as they are.
        let is_still = self.shake == Shake::default();
        Isometry3::from_parts(place, if is_still { rotation } else { rotation * self.shake.at(dt) })
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

/// Rotation by `yaw` to the right, `pitch` up, `roll` clockwise, radians; `libm` rounds alike on every machine.
pub fn turn(yaw: f64, pitch: f64, roll: f64) -> UnitQuaternion<f64> {
    let about =
        |angle: f64, axis: Vector3<f64>| Quaternion::from_parts(libm::cos(0.5 * angle), axis * libm::sin(0.5 * angle));
    UnitQuaternion::from_quaternion(about(yaw, Vector3::y()) * about(pitch, Vector3::x()) * about(roll, Vector3::z()))
}

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

    /// G with G·(x, y, 1) = (p, q, 1) / depth where the camera's direction (x, y, 1) meets the plane; `None` within it.
    fn plane_from_direction(&self, world_from_camera: &Isometry3<f64>) -> Option<Matrix3<f64>> {
        let turn = world_from_camera.rotation.inverse();
        let origin = world_from_camera.inverse_transform_point(&self.origin).coords;
        Matrix3::from_columns(&[turn * self.right, turn * self.down, origin]).try_inverse()
    }
}

/// Sheet position (p, q) and inverse depth (1/m) where a direction meets a plane in front of the camera.
fn meet(matrix: &Matrix3<f64>, direction: &Vector3<f64>) -> Option<(f64, f64, f64)> {
    let met = matrix * direction;
    (met.z > 1e-9).then(|| (met.x / met.z, met.y / met.z, met.z))
}

/// Renders `planes` as painted, without noise; nearer planes are composited over farther ones, on a signal of 0.
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
            // Farthest first: each nearer plane covers what lies under it, and values are already multiplied by alpha.
            hits.sort_by(|a, b| a.inverse_depth.total_cmp(&b.inverse_depth));
            *pixel = hits.iter().fold(0.0, |under, hit| under * (1.0 - hit.alpha) + hit.value);
        }
    }
    Ok(picture)
}

/// The nearest point of the world at the pixel (u, v), among planes that cover at least half of that pixel.
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

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: Lens = Lens { width: 64, height: 48, focal_px: 50.0 };

    #[test]
    fn a_turn_to_the_right_brings_what_is_there_to_the_middle() {
        let camera = BurstCamera {
            world_from_camera: Isometry3::from_parts(Translation3::identity(), turn(0.3, 0.0, 0.0)),
            step: Vector3::new(0.1, 0.0, 0.0),
            shake: Shake::default(),
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
