//! Trajectory files in the format of the TUM RGB-D benchmark: one pose for each line, `timestamp tx ty tz qx qy qz qw`.
//!
//! Translation and rotation are those of the camera in the world. Lines that begin with `#` are comments; commas count
//! as blanks. An image's name may replace the time stamp, so that truth can be given for images by name; then all lines
//! have one. Format: <https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats>.

use super::{Pose, corrupt, no_pose, unread};
use burstscope_core::error::Result;
use burstscope_core::files::{MAX_TABLE_BYTES, read_bytes};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use std::path::Path;

/// Tolerance of the length of a quaternion about 1; values of three digits are within it.
const QUATERNION_TOLERANCE: f64 = 0.05;

/// Reads a trajectory file. The order of the poses is that of the lines.
///
/// # Errors
/// The file cannot be read, has no pose, or a line is no pose.
pub fn read_tum(path: &Path) -> Result<Vec<Pose>> {
    let bytes = read_bytes(path, MAX_TABLE_BYTES).map_err(|e| unread(path, &e))?;
    parse_tum(&String::from_utf8_lossy(&bytes), path)
}

/// Parses the text of a trajectory file; `path` is for messages. Errors as of [`read_tum`].
pub fn parse_tum(text: &str, path: &Path) -> Result<Vec<Pose>> {
    let mut poses: Vec<Pose> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let corrupt = |problem: String| corrupt(path, &format!("line {}", index + 1), problem);
        let pose = parse_line(line, poses.len() as u32).map_err(corrupt)?;
        // A mixed file leaves open whether its poses pair by time or by name.
        if poses.first().is_some_and(|first| first.time.is_some() != pose.time.is_some()) {
            return Err(corrupt("all poses have a time stamp, or all have an image's name".to_owned()));
        }
        poses.push(pose);
    }
    if poses.is_empty() { Err(no_pose(path)) } else { Ok(poses) }
}

fn parse_line(line: &str, order: u32) -> Result<Pose, String> {
    let mut words = line.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty());
    let label = words.next().unwrap_or_default().to_owned();
    let number = |word: &str| {
        let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
        number.ok_or_else(|| format!("'{word}' is not a number"))
    };
    let numbers = words.map(number).collect::<Result<Vec<_>, _>>()?;
    let wrong = |all: Vec<f64>| format!("{} values; a pose is 'timestamp tx ty tz qx qy qz qw'", all.len() + 1);
    let [x, y, z, qx, qy, qz, qw] = numbers.try_into().map_err(wrong)?;
    let rotation = rotation(Quaternion::new(qw, qx, qy, qz))?;
    let time = label.parse::<f64>().ok().filter(|t| t.is_finite());
    let world_from_camera = Isometry3::from_parts(Translation3::new(x, y, z), rotation);
    Ok(Pose { label, order, time, world_from_camera })
}

/// The rotation of a quaternion that was written with few digits.
pub(super) fn rotation(quaternion: Quaternion<f64>) -> Result<UnitQuaternion<f64>, String> {
    let norm = quaternion.norm();
    if (norm - 1.0).abs() > QUATERNION_TOLERANCE || !norm.is_finite() {
        return Err(format!("a rotation is a quaternion of length 1, but this one's length is {norm:.3}"));
    }
    Ok(UnitQuaternion::from_quaternion(quaternion))
}
