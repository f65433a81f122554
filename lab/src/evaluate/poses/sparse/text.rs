//! Models in text: one line for each entry (two for an image), fields separated by blanks, comments after `#`.

use super::{SparseImage, SparsePoint, world_from_camera};
use crate::evaluate::poses::{corrupt, unread};
use burstscope_core::error::{Error, Result};
use burstscope_core::files;
use std::fmt::Display;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::str::FromStr;

pub(super) fn read_images(path: &Path) -> Result<Vec<SparseImage>> {
    images(BufReader::new(files::open(path).map_err(|e| unread(path, &e))?), path)
}

pub(super) fn read_points(path: &Path) -> Result<Vec<SparsePoint>> {
    points(BufReader::new(files::open(path).map_err(|e| unread(path, &e))?), path)
}

/// Parses images: a line of pose and name, then a line of keypoints, which may be empty.
pub(super) fn images(text: impl BufRead, path: &Path) -> Result<Vec<SparseImage>> {
    let mut lines = Lines { text, path, number: 0, line: Vec::new() };
    let mut images = Vec::new();
    while let Some(line) = lines.next_entry()? {
        let mut image = image(&line).map_err(|problem| lines.fail(problem))?;
        // An empty line of keypoints counts: it must not be skipped as other empty lines are.
        if let Some(keypoints) = lines.next_line()? {
            (image.keypoints, image.points) = keypoints_of(&keypoints).map_err(|problem| lines.fail(problem))?;
        }
        images.push(image);
    }
    Ok(images)
}

pub(super) fn points(text: impl BufRead, path: &Path) -> Result<Vec<SparsePoint>> {
    let mut lines = Lines { text, path, number: 0, line: Vec::new() };
    let mut points = Vec::new();
    while let Some(line) = lines.next_entry()? {
        points.push(point(&line).map_err(|problem| lines.fail(problem))?);
    }
    Ok(points)
}

/// Parses `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`; the name may contain blanks.
fn image(line: &str) -> Result<SparseImage, String> {
    const FORM: &str = "an image is 'IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME'";
    let mut rest = line;
    // Word by word, because the rest of the line is the name, blanks included.
    let mut word = || -> Result<&str, String> {
        let (word, after) = rest.split_once(char::is_whitespace).ok_or_else(|| format!("it ends too early; {FORM}"))?;
        rest = after.trim_start();
        Ok(word)
    };
    let id = number::<u32>(word()?)?;
    let mut values = [0.0f64; 7];
    for value in &mut values {
        *value = number(word()?)?;
    }
    let _camera_id = number::<u32>(word()?)?;
    if rest.is_empty() {
        return Err(format!("it ends too early; {FORM}"));
    }
    let [w, x, y, z, tx, ty, tz] = values;
    let world_from_camera = world_from_camera([w, x, y, z], [tx, ty, tz])?;
    Ok(SparseImage { id, name: rest.to_owned(), keypoints: 0, points: 0, world_from_camera })
}

/// The number of keypoints in a line of `X Y POINT3D_ID`, and of those that became points.
fn keypoints_of(line: &str) -> Result<(usize, usize), String> {
    let (mut words, mut points) = (0, 0);
    for word in line.split_whitespace() {
        words += 1;
        if words % 3 == 0 {
            points += usize::from(number::<i64>(word)? != -1);
        } else {
            number::<f64>(word)?;
        }
    }
    if words % 3 != 0 {
        return Err(format!("{words} values; keypoints are 'X Y POINT3D_ID' each"));
    }
    Ok((words / 3, points))
}

/// Parses `POINT3D_ID X Y Z R G B ERROR`, then `IMAGE_ID POINT2D_IDX` for each element of its track.
fn point(line: &str) -> Result<SparsePoint, String> {
    const FORM: &str =
        "a point is 'POINT3D_ID X Y Z R G B ERROR', then 'IMAGE_ID POINT2D_IDX' for each time it is seen";
    let mut words = line.split_whitespace();
    let mut values = [0.0f64; 8];
    for value in &mut values {
        *value = number(words.next().ok_or_else(|| format!("it ends too early; {FORM}"))?)?;
    }
    let mut track = 0;
    for word in words {
        number::<u32>(word)?;
        track += 1;
    }
    if track % 2 != 0 {
        return Err(format!("its track has {track} values; {FORM}"));
    }
    let position = [values[1], values[2], values[3]];
    Ok(SparsePoint { position, reprojection_error_px: values[7], track_length: track / 2 })
}

fn number<T: FromStr>(word: &str) -> Result<T, String> {
    word.parse().map_err(|_| format!("'{word}' is not a number that can stand here"))
}

struct Lines<'a, R> {
    text: R,
    path: &'a Path,
    number: usize,
    line: Vec<u8>,
}

impl<R: BufRead> Lines<'_, R> {
    fn fail(&self, problem: impl Display) -> Error {
        corrupt(self.path, &format!("line {}", self.number), problem)
    }

    /// The next line without blanks at its ends.
    fn next_line(&mut self) -> Result<Option<String>> {
        self.line.clear();
        let bytes = self.text.read_until(b'\n', &mut self.line).map_err(|e| unread(self.path, &e))?;
        self.number += 1;
        Ok((bytes > 0).then(|| String::from_utf8_lossy(&self.line).trim().to_owned()))
    }

    /// The next line that is neither empty nor a comment.
    fn next_entry(&mut self) -> Result<Option<String>> {
        loop {
            match self.next_line()? {
                Some(line) if line.is_empty() || line.starts_with('#') => {}
                other => return Ok(other),
            }
        }
    }
}
