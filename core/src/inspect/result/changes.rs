//! Comparison of two lists of features of one burst, before and after a change. The second list may come from another
//! program: a [`ForeignFeature`], read from our own CSV table or COLMAP's text.
//!
//! Two features are the same when one finds the other by the rule of [`finds`](super::finds), taken as a disc of
//! radius √2·σ, and neither is known to be bright where the other is dark. Those of the later list choose in order of
//! strength, each the nearest free one; the features of one keypoint, which differ in their orientation, choose
//! together.

use super::score::{REACH_IN_RADII, REACH_PIXELS, SCALE_FACTOR};
use crate::detector::{Feature, Slope};
use crate::error::{Error, Result};
use crate::export::{feature_header, read_colmap, read_features_csv};
use crate::files;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// A feature as used by the comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// (u, v), input pixels.
    pub pos_image: [f32; 2],
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Slope, px/frame, if known.
    pub slope: Option<Slope>,
    /// Whether it is brighter than its surroundings, if known.
    pub is_bright: Option<bool>,
}

impl From<&Feature> for Spot {
    fn from(f: &Feature) -> Self {
        // A bright blob is a negative extremum.
        Self { pos_image: [f.u, f.v], sigma: f.sigma, slope: Some(f.slope), is_bright: Some(f.response < 0.0) }
    }
}

impl From<&ForeignFeature> for Spot {
    fn from(f: &ForeignFeature) -> Self {
        Self { pos_image: f.pos_image, sigma: f.sigma, slope: f.slope, is_bright: f.response.map(|r| r < 0.0) }
    }
}

/// A feature that is in both lists.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Same {
    /// Index in the earlier list.
    pub before: usize,
    /// Index in the later list.
    pub after: usize,
    /// Distance that it moved, input pixels.
    pub moved_px: f32,
    /// Magnitude of the change of its slope, px/frame; 0 where one is unknown.
    pub slope_moved: f32,
    /// Ratio of the later scale to the earlier one.
    pub scale_ratio: f32,
}

impl Same {
    /// Whether its position, scale or slope changed noticeably.
    pub fn has_moved(&self) -> bool {
        self.moved_px > MOVED_PX || self.slope_moved > MOVED_SLOPE || (self.scale_ratio.ln()).abs() > MOVED_SCALE.ln()
    }
}

/// Result of a comparison.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Changes {
    /// Features in both lists, in the order of the later list.
    pub same: Vec<Same>,
    /// Indices in the later list of features missing in the earlier one.
    pub gained: Vec<usize>,
    /// Indices in the earlier list of features missing in the later one.
    pub lost: Vec<usize>,
}

impl Changes {
    /// The features in both lists that moved.
    pub fn moved(&self) -> impl Iterator<Item = &Same> {
        self.same.iter().filter(|same| same.has_moved())
    }

    /// The counts as a sentence.
    pub fn summary(&self) -> String {
        let (gained, lost, moved) = (self.gained.len(), self.lost.len(), self.moved().count());
        format!("{gained} gained, {lost} lost, {moved} moved, {} as before", self.same.len() - moved)
    }
}

const MOVED_PX: f32 = 0.5;
const MOVED_SLOPE: f32 = 0.1;
const MOVED_SCALE: f32 = 1.1;

/// Compares two lists of features, each strongest first.
pub fn compare(before: &[Spot], after: &[Spot]) -> Changes {
    let mut free = keypoints(before);
    let cells = Cells::new(before, free.keys().copied());
    let mut changes = Changes::default();
    for (index, features) in keypoints(after) {
        let spot = &after[index];
        let near = cells.around(spot).filter(|other| free.contains_key(other) && finds(spot, &before[*other]));
        let nearest = near.min_by(|&a, &b| apart(spot, &before[a]).total_cmp(&apart(spot, &before[b])).then(a.cmp(&b)));
        let earlier = nearest.and_then(|other| free.remove(&other)).unwrap_or_default();
        let both = earlier.len().min(features.len());
        changes.same.extend(earlier.iter().zip(&features).map(|(&was, &is)| {
            let (was_spot, is_spot) = (&before[was], &after[is]);
            let slopes = is_spot.slope.zip(was_spot.slope);
            let slope_moved = slopes.map_or(0.0, |(a, b)| (a.u - b.u).hypot(a.v - b.v));
            let (moved_px, scale_ratio) = (apart(is_spot, was_spot), is_spot.sigma / was_spot.sigma);
            Same { before: was, after: is, moved_px, slope_moved, scale_ratio }
        }));
        changes.gained.extend(&features[both..]);
        changes.lost.extend(&earlier[both..]);
    }
    changes.lost.extend(free.into_values().flatten());
    changes.lost.sort_unstable();
    changes.gained.sort_unstable();
    changes.same.sort_unstable_by_key(|same| same.after);
    changes
}

/// Features of each keypoint, by the index of its first one.
fn keypoints(spots: &[Spot]) -> BTreeMap<usize, Vec<usize>> {
    let mut first = HashMap::with_capacity(spots.len());
    let mut keypoints = BTreeMap::<usize, Vec<usize>>::new();
    for (index, spot) in spots.iter().enumerate() {
        let slope = spot.slope.unwrap_or_default();
        let key = [spot.pos_image[0], spot.pos_image[1], spot.sigma, slope.u, slope.v].map(f32::to_bits);
        keypoints.entry(*first.entry(key).or_insert(index)).or_default().push(index);
    }
    keypoints
}

fn apart(a: &Spot, b: &Spot) -> f32 {
    (a.pos_image[0] - b.pos_image[0]).hypot(a.pos_image[1] - b.pos_image[1])
}

/// Maximum distance, input pixels, of a feature that is the same as one of scale `sigma`.
fn reach(sigma: f32) -> f32 {
    REACH_IN_RADII as f32 * std::f32::consts::SQRT_2 * sigma + REACH_PIXELS as f32
}

fn finds(spot: &Spot, earlier: &Spot) -> bool {
    let ratio = f64::from(spot.sigma / earlier.sigma);
    let is_alike = spot.is_bright.zip(earlier.is_bright).is_none_or(|(a, b)| a == b);
    is_alike && apart(spot, earlier) <= reach(earlier.sigma) && (1.0 / SCALE_FACTOR..=SCALE_FACTOR).contains(&ratio)
}

/// Spots by position, in squares; each class of scales has its own, so that no square holds much smaller spots.
struct Cells {
    squares: HashMap<(i32, i32, i32), Vec<usize>>,
}

/// The class of a scale: the whole number of doublings of σ.
fn class(sigma: f32) -> i32 {
    sigma.max(1e-3).log2().floor() as i32
}

impl Cells {
    fn new(spots: &[Spot], which: impl IntoIterator<Item = usize>) -> Self {
        let mut squares: HashMap<_, Vec<usize>> = HashMap::new();
        for index in which {
            squares.entry(Self::square(&spots[index], class(spots[index].sigma))).or_default().push(index);
        }
        Self { squares }
    }

    fn square(spot: &Spot, class: i32) -> (i32, i32, i32) {
        // The side is at least the reach of the class's spots.
        let at = |x: f32| (x / reach(2f32.powi(class + 1))).floor() as i32;
        (class, at(spot.pos_image[0]), at(spot.pos_image[1]))
    }

    fn around(&self, spot: &Spot) -> impl Iterator<Item = usize> + '_ {
        let own = class(spot.sigma);
        let spot = *spot;
        (own - 1..=own + 1).flat_map(move |class| {
            let (_, x, y) = Self::square(&spot, class);
            let places = (y - 1..=y + 1).flat_map(move |y| (x - 1..=x + 1).map(move |x| (class, x, y)));
            places.filter_map(|place| self.squares.get(&place)).flatten().copied()
        })
    }
}

/// A feature from a file, with the values that the file has.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ForeignFeature {
    /// (u, v), input pixels; the centre of the first pixel is (0, 0).
    pub pos_image: [f32; 2],
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Orientation, radians, from +u towards +v.
    pub orientation: f32,
    /// Slope, px/frame.
    pub slope: Option<Slope>,
    /// D with its sign.
    pub response: Option<f32>,
    /// Ratio of |D| to its noise.
    pub snr: Option<f32>,
}

/// Reads features from a file: CSV if it begins like our table, otherwise COLMAP's text.
///
/// # Errors
/// The file cannot be read, or a line, which is named, has a wrong form, a place that is no number, or a scale that is
/// not above 0.
pub fn read_features(path: &Path) -> Result<Vec<ForeignFeature>> {
    let features: Vec<ForeignFeature> = if is_table(path)? {
        let of_row = |Feature { u, v, sigma, orientation, slope, response, snr, .. }: Feature| {
            let (slope, response, snr) = (Some(slope), Some(response), Some(snr));
            ForeignFeature { pos_image: [u, v], sigma, orientation, slope, response, snr }
        };
        read_features_csv(path)?.into_iter().map(of_row).collect()
    } else {
        let keypoints = read_colmap(path)?.0.into_iter().map(|k| ForeignFeature {
            pos_image: k.pos_image().map(|x| x as f32),
            sigma: k.scale,
            orientation: k.orientation,
            ..ForeignFeature::default()
        });
        keypoints.collect()
    };
    let usable = |f: &ForeignFeature| f.pos_image.iter().all(|x| x.is_finite()) && f.sigma.is_finite() && f.sigma > 0.0;
    let Some(index) = features.iter().position(|f| !usable(f)) else { return Ok(features) };
    Err(Error::in_line(path, index + 2, "the place must be two numbers and the scale a number above 0"))
}

/// Whether a file is a feature table of ours, from its beginning; otherwise it is COLMAP's text.
fn is_table(path: &Path) -> Result<bool> {
    let read = |e: std::io::Error| Error::unread_file(path, e);
    let start = files::open(path).and_then(|file| files::next_bytes(file, 256)).map_err(read)?;
    let start = String::from_utf8_lossy(&start);
    let first = start.lines().next().unwrap_or_default();
    let header = feature_header();
    if first.starts_with(&header[..header.len().min(12)]) {
        return Ok(true);
    }
    let words: Vec<&str> = first.split_whitespace().collect();
    if matches!(words[..], [count, size] if count.parse::<u64>().is_ok() && size.parse::<u64>().is_ok()) {
        return Ok(false);
    }
    let problem = format!(
        "the first line '{first:.40}' is neither the header of a feature table ({header}) nor that of COLMAP's text (a count and 128)"
    );
    Err(Error::in_line(path, 1, &problem))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn spot(u: f32, v: f32, sigma: f32) -> Spot {
        Spot { pos_image: [u, v], sigma, slope: Some(Slope::default()), is_bright: None }
    }

    fn spots() -> impl Strategy<Value = Vec<Spot>> {
        let spot = (0.0f32..60.0, 0.0f32..40.0, 0.7f32..12.0).prop_map(|(u, v, s)| spot(u, v, s));
        prop::collection::vec(spot, 0..60)
    }

    proptest! {
        #[test]
        fn squares_lose_nobody(a in spots(), b in spots()) {
            let cells = Cells::new(&a, 0..a.len());
            for spot in &b {
                let near: std::collections::HashSet<usize> = cells.around(spot).collect();
                for (index, other) in a.iter().enumerate() {
                    prop_assert!(!finds(spot, other) || near.contains(&index), "{spot:?} {other:?}");
                }
            }
        }
    }
}
