//! Rotation of the camera during a burst, where it is known: by a gyro, or by a robot's odometry.
//!
//! A camera that turns moves near and far things alike, mostly along no straight line. Its frames are turned to the
//! orientation at mid-burst: what then moves is what the camera's way moves, in straight lines, the nearer the faster.
//! Keypoints are of the camera at mid-burst, as without rotation.

use super::{Burst, layout::FrameRange};
use crate::camera::{Camera, read_camera};
use crate::error::{Error, ErrorKind, Result};
use crate::files::read_text;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::{Plane, sample::cubic};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rayon::prelude::*;
use std::{path::Path, sync::Arc};

/// Largest list that is read: a day at 1000 orientations a second, 90 bytes each, has more.
const MAX_LIST_BYTES: u64 = 1 << 30;
/// Distance of the places, pixels, at which a turned pixel is computed; between them it is linear, which at a turn of
/// 3° and a focal length of 300 px is off by 0.01 px.
const GRID_PX: usize = 16;
/// Deviation of a quaternion's length from 1 that digits leave.
const UNIT: f64 = 0.01;
/// Stamps above it are nanoseconds: as seconds they would be of the year 2286.
const MAX_SECONDS: f64 = 1e10;
/// Distance, seconds, up to which a frame before the first stamp or after the last is of that moment.
const SAME_S: f64 = 1e-4;

/// Orientations of a camera in the world, in the order of the file.
struct Orientations {
    /// Seconds; empty for a line a frame.
    seconds: Vec<f64>,
    turns: Vec<UnitQuaternion<f64>>,
}

impl Orientations {
    /// Reads `text`; the error is the number of a line and its fault.
    fn read(text: &str) -> Result<Self, String> {
        let (mut seconds, mut turns) = (Vec::new(), Vec::new());
        for (number, line) in text.lines().enumerate().map(|(at, line)| (at + 1, line.trim())) {
            let words: Vec<&str> = line.split([',', ';', ' ', '\t']).filter(|word| !word.is_empty()).collect();
            let numbers: Option<Vec<f64>> = words.iter().map(|word| word.parse().ok()).collect();
            let is_heading = turns.is_empty() && numbers.is_none();
            if words.is_empty() || line.starts_with('#') || is_heading {
                continue;
            }
            let fail = |fault: &str| Err(format!("line {number}: {fault}"));
            let Some(numbers) = numbers.filter(|numbers| numbers.iter().all(|x| x.is_finite())) else {
                return fail("not all of it are numbers");
            };
            let is_euroc = numbers.len() >= 8 && line.contains(',');
            let (stamp, [x, y, z, w]) = match numbers[..] {
                [x, y, z, w] => (None, [x, y, z, w]),
                [stamp, x, y, z, w] => (Some(stamp), [x, y, z, w]),
                // EuRoC parts numbers by commas, and its quaternions begin with w.
                [stamp, _, _, _, w, x, y, z, ..] if is_euroc => (Some(stamp), [x, y, z, w]),
                [stamp, _, _, _, x, y, z, w] => (Some(stamp), [x, y, z, w]),
                _ => return fail(&format!("{} numbers, where there are 4, 5 or 8", numbers.len())),
            };
            let turn = Quaternion::new(w, x, y, z);
            if (turn.norm() - 1.0).abs() > UNIT {
                return fail(&format!("the quaternion has the length {}, not 1", turn.norm()));
            }
            turns.push(UnitQuaternion::from_quaternion(turn));
            let is_whole = is_euroc && !words[0].contains('.');
            let unit = |stamp: f64| if is_whole || stamp.abs() > MAX_SECONDS { 1e-9 } else { 1.0 };
            seconds.extend(stamp.map(|stamp| unit(stamp) * stamp));
            if !seconds.is_empty() && seconds.len() != turns.len() {
                return fail("some lines have stamps, and some have none");
            }
            if let [.., before, last] = seconds[..]
                && before >= last
            {
                return fail("the stamps do not rise");
            }
        }
        if turns.is_empty() { Err("it holds no orientation".to_owned()) } else { Ok(Self { seconds, turns }) }
    }

    /// Orientation at each of `frames` frames: line by line, or at their times; `part` is the part taken of a file. The
    /// error is the problem and its remedy.
    fn of_frames(
        &self,
        frames: usize,
        seconds: &[f64],
        part: Option<FrameRange>,
    ) -> Result<Vec<UnitQuaternion<f64>>, (String, &'static str)> {
        let lines = self.turns.len();
        if self.seconds.is_empty() || seconds.is_empty() {
            let part = part.filter(|part| part.end <= lines && part.end - part.start == frames);
            let part = if lines == frames { Some(0..frames) } else { part.map(|part| part.start..part.end) };
            let problem = || format!("it has {lines} orientations for {frames} frames without times");
            let remedy = "give a line a frame, or stamps in the list and --times for the frames";
            return part.map(|part| self.turns[part].to_vec()).ok_or_else(|| (problem(), remedy));
        }
        let [first, last] = [self.seconds[0], self.seconds[lines - 1]];
        let at = |(t, time): (usize, &f64)| {
            let inside = time.clamp(first, last);
            if (inside - time).abs() > SAME_S {
                let problem = format!("frame {t} was taken at {time} s, and its stamps are from {first} to {last} s");
                return Err((problem, "give a list of the burst's time, on the clock of the frames"));
            }
            let next = self.seconds.partition_point(|stamp| *stamp < inside);
            let Some(before) = next.checked_sub(1) else { return Ok(self.turns[0]) };
            let [from, to] = [before, next].map(|line| self.seconds[line]);
            Ok(between(&self.turns[before], &self.turns[next], (inside - from) / (to - from)))
        };
        seconds.iter().enumerate().map(at).collect()
    }
}

/// Orientation at `share` (0 … 1) of the shortest turn from `a` to `b`.
fn between(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>, share: f64) -> UnitQuaternion<f64> {
    a.try_slerp(b, share, 1e-12).unwrap_or(*a)
}

/// `burst` with each frame turned to the camera's orientation at mid-burst. `seconds` are its frames' times, if known;
/// `list` has the orientations and `lens` is the camera; `part` was taken of a file. Places that a frame does not show
/// from there are masked.
///
/// # Errors
/// A file that cannot be read or does not suit the burst, views of a light field, and cancellation.
pub(super) fn turned(
    burst: Burst,
    seconds: &[f64],
    (list, lens): (&Path, &Path),
    part: Option<FrameRange>,
    monitor: &Monitor,
) -> Result<Burst> {
    let wrong = |problem: String, remedy: &str| {
        Error::new(ErrorKind::Mismatch, format!("rotations: {problem}"), remedy).about(list)
    };
    if burst.positions.are_views() {
        return Err(wrong("the views of a light field do not turn".to_owned(), "leave out either views or rotations"));
    }
    let text = read_text(list, MAX_LIST_BYTES).map_err(|e| Error::from_io(list, &e))?;
    let form = "write qx qy qz qw, a line a frame, or lines as of TUM or EuRoC with stamps";
    let orientations = Orientations::read(&text).map_err(|problem| wrong(problem, form))?;
    if !lens.is_file() {
        let remedy = "give its file with --lens, or put it beside the frames as camera.toml";
        return Err(wrong(format!("there is no camera {}", lens.display()), remedy));
    }
    let camera = read_camera(lens)?;
    let ((columns, rows), Camera { width, height, .. }) = (burst.size(), &camera);
    if (columns, rows) != (*width, *height) {
        let problem = format!("{} is of {width}×{height} pixels, the frames are of {columns}×{rows}", lens.display());
        return Err(wrong(problem, "give the camera of these frames"));
    }
    let turns =
        orientations.of_frames(burst.len(), seconds, part).map_err(|(problem, remedy)| wrong(problem, remedy))?;
    // The orientation at mid-burst, the mean of the frames' positions.
    let times: Vec<f64> = burst.positions.offsets().iter().map(|offset| offset.u).collect();
    let middle = match times.partition_point(|time| *time < 0.0) {
        0 => turns[0],
        next => between(&turns[next - 1], &turns[next], -times[next - 1] / (times[next] - times[next - 1])),
    };
    let mut largest = 0.0f64;
    let mut frames = Vec::with_capacity(burst.len());
    for (t, (frame, turn)) in burst.frames.iter().zip(&turns).enumerate() {
        let from_middle = turn.inverse() * middle;
        largest = largest.max(from_middle.angle());
        // A frame that is not turned keeps its values to the bit.
        if from_middle.angle() < 1e-9 {
            frames.push(frame.clone());
            continue;
        }
        let turned = turned_frame(frame, &camera, &from_middle, monitor)?;
        // As of orientations of something else, or of numbers in another order.
        if turned.data().iter().all(|value| value.is_nan()) {
            let problem = format!("frame {t}, turned by {:.0}°, shows nothing", from_middle.angle().to_degrees());
            return Err(wrong(problem, "give orientations of the camera itself, as qx qy qz qw"));
        }
        frames.push(Arc::new(turned.with_nan_masked()));
    }
    let said = format!(
        "the frames are turned to the camera's orientation at mid-burst, by up to {:.2}°, as {} says",
        largest.to_degrees(),
        list.file_name().unwrap_or_default().to_string_lossy()
    );
    Ok(Burst { frames, taken: burst.taken.iter().cloned().chain([said]).collect(), ..burst })
}

/// Picture that `camera` would have taken at another orientation: `from_turned` turns directions of that camera into
/// those of the camera that took `frame`. NaN where `frame` shows nothing.
fn turned_frame(frame: &Plane, camera: &Camera, from_turned: &UnitQuaternion<f64>, monitor: &Monitor) -> Result<Plane> {
    let (width, height) = frame.size();
    let source = |u: usize, v: usize| {
        let [x, y] = camera.direction_of([u as f64, v as f64]);
        let seen = from_turned * Vector3::new(x, y, 1.0);
        if seen.z > 0.0 { camera.pixel_of([seen.x / seen.z, seen.y / seen.z]).map(|x| x as f32) } else { [f32::NAN; 2] }
    };
    let columns = width.div_ceil(GRID_PX) + 1;
    let grid: Vec<[f32; 2]> = (0..columns * (height.div_ceil(GRID_PX) + 1))
        .map(|at| source(at % columns * GRID_PX, at / columns * GRID_PX))
        .collect();
    let mut turned = Plane::zeros(width, height);
    let row_of = |(v, row): (usize, &mut [f32])| -> Result<(), Cancelled> {
        monitor.check()?;
        let (above, down) = (&grid[v / GRID_PX * columns..], (v % GRID_PX) as f32 / GRID_PX as f32);
        for (u, value) in row.iter_mut().enumerate() {
            let (left, right) = (u / GRID_PX, (u % GRID_PX) as f32 / GRID_PX as f32);
            let mix = |a: f32, b: f32, share: f32| a + share * (b - a);
            let [x, y] = [0, 1].map(|axis| {
                let row = |from: usize| mix(above[from + left][axis], above[from + left + 1][axis], right);
                mix(row(0), row(columns), down)
            });
            let is_seen = x.is_finite() && y.is_finite() && !hides(frame, x, y);
            *value = cubic(frame, x, y).filter(|_| is_seen).unwrap_or(f32::NAN);
        }
        Ok(())
    };
    turned.data_mut().par_chunks_mut(width).enumerate().try_for_each(row_of)?;
    Ok(turned)
}

/// Whether a mask of `frame` hides one of the four pixels around (`u`, `v`), which lies inside or not.
fn hides(frame: &Plane, u: f32, v: f32) -> bool {
    let inside = |x: f32, count: usize| (x.max(0.0) as usize).min(count - 1);
    let at = |du: f32, dv: f32| frame.is_hidden_at(inside(u + du, frame.width()), inside(v + dv, frame.height()));
    frame.mask().is_some() && (at(0.0, 0.0) || at(1.0, 0.0) || at(0.0, 1.0) || at(1.0, 1.0))
}
