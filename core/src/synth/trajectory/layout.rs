//! Layout of a trajectory: a wall with boards before it at several depths, and the camera's path past them.

use super::TrajectoryParams;
use super::lens::{BurstCamera, Lens, turn};
use super::plane::{ScenePlane, nearest_point};
use crate::monitor::{Cancelled, Monitor};
use crate::synth::leaves::paint_leaves;
use crate::synth::paint::{Area, Sheet};
use crate::synth::random::Stream;
use crate::synth::{Motion, SynthError};
use nalgebra::{Isometry3, Point3, Translation3, Vector3};

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
        let heading = match params.motion {
            Motion::OneD => Vector3::x(),
            Motion::TwoD => Vector3::new(0.12, 0.04 * side, 0.35),
        };
        (Isometry3::from_parts(Translation3::new(x, y, z), rotation), heading)
    };
    (0..params.bursts).map(station).collect()
}

/// The painted planes, large enough for everything that is seen from `stations`.
///
/// # Errors
/// Sheets that would be too large, or [`SynthError::Cancelled`].
pub(super) fn planes(
    params: &TrajectoryParams,
    lens: &Lens,
    stations: &[(Isometry3<f64>, Vector3<f64>)],
    monitor: &Monitor,
) -> Result<Vec<ScenePlane>, SynthError> {
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
            let [left, top, right, bottom] = frame.seen_from(lens, stations, way + 8.0)?;
            let (width, height) = ((right - left).ceil() as usize, (bottom - top).ceil() as usize);
            if (width + 16) * (height + 16) > MAX_SAMPLES / (4 * params.planes) {
                let problem = format!("{} planes of {width}×{height} pixels take too much memory", params.planes);
                return Err(SynthError::param("width", problem, "make smaller frames or fewer planes"));
            }
            let mut sheet = Sheet::new(width, height, 4, 4);
            let coarsest = (0.1 * lens.width.min(lens.height) as f64).max(2.0 * FINEST_LEAF);
            paint_leaves(&mut sheet, &(FINEST_LEAF..=coarsest), &LEAF_VALUES, &mut stream);
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
    /// The part of the plane seen from the stations, with a margin, in its pixels from the centre: `[left, top, right,
    /// bottom]`.
    fn seen_from(
        &self,
        lens: &Lens,
        stations: &[(Isometry3<f64>, Vector3<f64>)],
        margin: f64,
    ) -> Result<[f64; 4], SynthError> {
        let mut seen = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let normal = self.right.cross(&self.down);
        let (width, height) = (lens.width as f64, lens.height as f64);
        for (camera, _) in stations {
            for (u, v) in [(-0.5, -0.5), (width - 0.5, -0.5), (-0.5, height - 0.5), (width - 0.5, height - 0.5)] {
                let direction = camera.rotation * lens.direction(u, v);
                let along = normal.dot(&direction);
                let depth = normal.dot(&(self.centre.coords - camera.translation.vector)) / along;
                if !(depth.is_finite() && depth > 0.0) {
                    let problem = "a camera looks past a plane of the scene";
                    return Err(SynthError::param("bursts", problem, "make fewer bursts"));
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

/// The apparent motions of `points`, as means over each half of the burst, pixels per frame; empty for a burst of one
/// frame.
fn motions(camera: &BurstCamera, lens: &Lens, points: &[Point3<f64>], half_span: f64) -> Vec<[f64; 2]> {
    let halves = points.iter().flat_map(|point| [-half_span, half_span].map(|dt| (point, dt)));
    let motion = |(point, dt): (&Point3<f64>, f64)| {
        let (from, to) = (camera.pixel_of(lens, point, 0.0)?, camera.pixel_of(lens, point, dt)?);
        (dt != 0.0).then(|| [(to[0] - from[0]) / dt, (to[1] - from[1]) / dt])
    };
    halves.filter_map(motion).collect()
}

/// The camera of a burst at the speed at which the largest apparent motion on an axis is `max_slope` pixels per frame;
/// and the minimum and maximum motion on each axis, `[[u min, u max], [v min, v max]]`.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
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
    let at_speed = |speed: f64| BurstCamera { world_from_camera, step: world_from_camera.rotation * (speed * heading) };
    let largest = |motions: &[[f64; 2]]| motions.iter().flatten().fold(0.0f64, |max, x| max.max(x.abs()));
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
        let values = motions.iter().map(|motion| motion[axis]);
        values.fold(None, |range: Option<[f64; 2]>, x| {
            Some(range.map_or([x, x], |[low, high]| [low.min(x), high.max(x)]))
        })
    };
    Ok((camera, [range(0).unwrap_or_default(), range(1).unwrap_or_default()]))
}
