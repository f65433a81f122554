//! Keypoints in COLMAP's convention, and its importer's text: `N 128`, then `x y scale orientation d1 … d128` each.
//!
//! The descriptors are in UBC order, which is the order of [`Descriptor`] and of COLMAP's own SIFT. Numbers read back
//! exactly. Format: <https://colmap.github.io/tutorial.html#feature-detection-and-extraction>.

use super::FIRST_PIXEL;
use crate::detector::{Descriptor, Feature};
use crate::error::{Error, Result};
use crate::export::{atomic::write_whole, csv::first_line};
use crate::files::{MAX_TABLE_BYTES, read_text};
use std::io::{self, Write};
use std::{path::Path, str::FromStr};

/// Writes features and descriptors for COLMAP's importer; panics if the numbers of them differ.
///
/// ```
/// use burstscope_core::{Feature, export::{read_colmap, write_colmap}};
/// let folder = tempfile::tempdir()?;
/// let file = folder.path().join("night.png.txt");
/// write_colmap(&file, &[Feature { u: 10.0, v: 20.0, sigma: 2.0, ..Feature::default() }], &[[7; 128]])?;
/// let (keypoints, descriptors) = read_colmap(&file)?;
/// assert_eq!([keypoints[0].x, keypoints[0].y], [10.5, 20.5], "the first pixel's centre is at 0.5");
/// assert_eq!(descriptors, [[7u8; 128]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_colmap(path: &Path, features: &[Feature], descriptors: &[Descriptor]) -> Result<()> {
    write_colmap_keypoints(path, &features.iter().map(ColmapKeypoint::from).collect::<Vec<_>>(), descriptors)
}

/// Writes features that are already in COLMAP's convention, with their descriptors, for COLMAP's importer.
pub fn write_colmap_keypoints(path: &Path, keypoints: &[ColmapKeypoint], descriptors: &[Descriptor]) -> Result<()> {
    assert_eq!(keypoints.len(), descriptors.len(), "each feature has one descriptor");
    write_whole(path, |out| print(out, keypoints, descriptors))
}

fn print(out: &mut impl Write, keypoints: &[ColmapKeypoint], descriptors: &[Descriptor]) -> io::Result<()> {
    writeln!(out, "{} 128", keypoints.len())?;
    for (ColmapKeypoint { x, y, scale, orientation }, descriptor) in keypoints.iter().zip(descriptors) {
        write!(out, "{x} {y} {scale} {orientation}")?;
        for value in descriptor {
            write!(out, " {value}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Whether the file has COLMAP's header; with `is_whole`, also numbers exactly as this program prints them.
pub(in crate::export) fn is_colmap_text(path: &Path, is_whole: bool) -> bool {
    let is_number = |count: &str| !count.is_empty() && count.bytes().all(|byte| byte.is_ascii_digit());
    let is_printed = |text: String| {
        let mut bytes = Vec::with_capacity(text.len());
        let printed = parse_colmap(path, &text).map(|(keypoints, all)| print(&mut bytes, &keypoints, &all));
        printed.is_ok_and(|printed| printed.is_ok()) && bytes == text.as_bytes()
    };
    first_line(path).is_some_and(|line| line.strip_suffix(" 128").is_some_and(is_number))
        && (!is_whole || read_text(path, MAX_TABLE_BYTES).is_ok_and(is_printed))
}

/// Reads features and descriptors that [`write_colmap`] wrote; all numbers are the same.
///
/// # Errors
/// The file cannot be read, or a line, which is named, is not in this format.
pub fn read_colmap(path: &Path) -> Result<(Vec<ColmapKeypoint>, Vec<Descriptor>)> {
    parse_colmap(path, &read_text(path, MAX_TABLE_BYTES).map_err(|e| Error::unread_file(path, e))?)
}

/// Parses the `text` of a file that `write_colmap` wrote, as [`read_colmap`]; `path` is for messages.
pub fn parse_colmap(path: &Path, text: &str) -> Result<(Vec<ColmapKeypoint>, Vec<Descriptor>)> {
    let mut lines = text.lines();
    let bad = |line: usize, problem: String| Error::in_line(path, line, &problem);
    let header = lines.next().unwrap_or_default();
    let count = header.strip_suffix(" 128").and_then(|count| count.parse::<usize>().ok());
    let count = count.ok_or_else(|| bad(1, format!("'{header:.40}' is not the number of features and 128")))?;
    let (mut keypoints, mut descriptors) = (Vec::new(), Vec::new());
    for (index, line) in lines.enumerate() {
        let (keypoint, descriptor) = parse(line).map_err(|problem| bad(index + 2, problem))?;
        keypoints.push(keypoint);
        descriptors.push(descriptor);
    }
    if keypoints.len() != count {
        return Err(bad(1, format!("{count} features are announced, but there are {}", keypoints.len())));
    }
    Ok((keypoints, descriptors))
}

fn parse(line: &str) -> Result<(ColmapKeypoint, Descriptor), String> {
    let mut words = line.split_ascii_whitespace();
    let mut numbers = [0.0f32; 4];
    for number in &mut numbers {
        *number = next(&mut words)?;
    }
    if numbers.iter().any(|x| !x.is_finite()) {
        return Err("a number is not finite".to_owned());
    }
    let mut descriptor: Descriptor = [0; 128];
    for value in &mut descriptor {
        *value = next(&mut words)?;
    }
    if words.next().is_some() {
        return Err("there is more than x, y, scale, orientation and 128 numbers".to_owned());
    }
    let [x, y, scale, orientation] = numbers;
    Ok((ColmapKeypoint { x, y, scale, orientation }, descriptor))
}

fn next<'a, T: FromStr>(words: &mut impl Iterator<Item = &'a str>) -> Result<T, String> {
    let word = words.next().ok_or("it ends too early; a feature is x, y, scale, orientation and 128 numbers")?;
    word.parse().map_err(|_| format!("'{word:.40}' is not a number that can stand here"))
}

/// Keypoint in COLMAP's convention: the centre of the first pixel is (0.5, 0.5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColmapKeypoint {
    /// Column, pixels.
    pub x: f32,
    /// Row, pixels.
    pub y: f32,
    /// Scale σ, pixels.
    pub scale: f32,
    /// Orientation, radians, from +x towards +y.
    pub orientation: f32,
}

impl ColmapKeypoint {
    /// Position (u, v) in Burstscope's convention, where the centre of the first pixel is (0, 0).
    pub fn pos_image(&self) -> [f64; 2] {
        [f64::from(self.x) - FIRST_PIXEL, f64::from(self.y) - FIRST_PIXEL]
    }

    #[cfg(feature = "colmap")]
    pub(super) fn set_pos_image(&mut self, pos_image: [f64; 2]) {
        [self.x, self.y] = pos_image.map(|place| (place + FIRST_PIXEL) as f32);
    }
}

impl From<&Feature> for ColmapKeypoint {
    fn from(feature: &Feature) -> Self {
        // COLMAP uses 32-bit floats; the sum is rounded once.
        let moved = |place: f32| (f64::from(place) + FIRST_PIXEL) as f32;
        Self { x: moved(feature.u), y: moved(feature.v), scale: feature.sigma, orientation: feature.orientation }
    }
}
