//! Motion of the scene in parts of the picture, so that it can be separated from the noise.
//!
//! Fine structure that moves fast does not cancel between frames that are compared at the same pixel, and would be
//! taken for noise that neighbouring pixels share. So for each part that is measured, the slope is found, among those
//! of the search, at which the mean of the shifted frames has the most power: there the scene adds up. The mean of
//! frames is independent of a contrast of the same frames with weights that sum to 0, so the choice by one does not
//! change the noise measured in the other.

use super::pyramid::BoxPyramid;
use crate::detector::params::slope_grid::Slope;
use crate::plane::Plane;
use crate::plane::tile::Region;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

/// Motion from frame to frame, in pixels of the measurement, below which it does not matter.
const LEAST_SHIFT: f32 = 0.25;
/// Level of the pyramid, above the octave's, at which the motion is measured: noise is small there, and its squares are
/// still a fraction of the reach of the octave's filters.
const LEVELS_UP: i32 = 2;

/// Minimum side of the parts of an image that each have a motion, pixels.
const PART: usize = 64;
/// Maximum number of parts, about.
const MAX_PARTS: usize = 48;

/// Input for measuring the scene's motion.
#[derive(Debug, Clone, Copy)]
pub struct SceneMotion<'a> {
    /// Pyramids of the frames that take part.
    pub pyramids: &'a [&'a BoxPyramid],
    /// Times at which they were taken, in frames of the burst.
    pub times: &'a [f32],
    /// Possible slopes, px/frame.
    pub slopes: &'a [Slope],
}

impl SceneMotion<'_> {
    /// Motion for parts that are measured with pixels of 2^`octave` image pixels.
    pub fn for_octave(&self, octave: i32) -> OctaveMotion {
        let mut slopes = self.slopes.to_vec();
        // Of equally good slopes the slowest is taken.
        slopes.sort_by(|a, b| a.magnitude().total_cmp(&b.magnitude()));
        let slowest = slopes.first().copied().unwrap_or_default();
        let fastest = slopes.last().map_or(0.0, |slope| slope.magnitude());
        let level = (octave + LEVELS_UP).max(1) as usize;
        let is_small = self.pyramids.first().is_none_or(|p| p.len() < level);
        if is_small || slopes.len() < 2 || fastest < LEAST_SHIFT * (octave as f32).exp2() {
            return OctaveMotion { planes: Vec::new(), square: 1.0, candidates: vec![(slowest, Vec::new())] };
        }
        let square = (1usize << level) as f32;
        let middle = 0.5 * (self.times[0] + self.times[self.times.len() - 1]);
        let (mut candidates, mut known) = (Vec::new(), BTreeSet::new());
        for slope in slopes {
            let shift = |t: f32, along: f32| ((t - middle) * along / square).round() as i64;
            let shifts: Vec<(i64, i64)> = self.times.iter().map(|&t| (shift(t, slope.u), shift(t, slope.v))).collect();
            if known.insert(shifts.clone()) {
                candidates.push((slope, shifts));
            }
        }
        let planes = self.pyramids.par_iter().map(|p| without_slopes(p.level(level))).collect();
        OctaveMotion { planes, square, candidates }
    }
}

impl SceneMotion<'_> {
    /// Slope at each of the image's `places`, for an image of `size`: that of the part around it, of which the middle
    /// 64 pixels a side are used.
    pub fn slopes_at(&self, places: &[(f32, f32)], (width, height): (usize, usize)) -> Vec<Slope> {
        let side = PART.max(((width * height) as f32 / MAX_PARTS as f32).sqrt() as usize);
        let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
        let motion = self.for_octave(0);
        let part = |index: usize| {
            let range = |i: usize, n: usize| {
                let (start, end) = (i * side, ((i + 1) * side).min(n));
                let spare = (end - start).saturating_sub(PART) / 2;
                start + spare..end - spare
            };
            motion.slope_in(&Region { columns: range(index % columns, width), rows: range(index / columns, height) })
        };
        let slopes: Vec<Slope> = (0..columns * rows).into_par_iter().map(part).collect();
        let at = |x: f32, n: usize| ((x.max(0.0) as usize) / side).min(n - 1);
        places.iter().map(|&(u, v)| slopes[at(v, rows) * columns + at(u, columns)]).collect()
    }
}

/// Motion at an octave's resolution.
#[derive(Debug)]
pub struct OctaveMotion {
    /// Each frame less its surroundings, in squares of the pyramid; empty where the motion does not matter.
    planes: Vec<Plane>,
    /// Side of a square, image pixels.
    square: f32,
    /// Slopes that differ in squares, from the slowest on, with the squares by which each frame is shifted.
    candidates: Vec<(Slope, Vec<(i64, i64)>)>,
}

impl OctaveMotion {
    /// Slope, px/frame, of the scene in `region` of the image.
    pub fn slope_in(&self, region: &Region) -> Slope {
        let mut best = (f32::NEG_INFINITY, self.candidates[0].0);
        if self.planes.is_empty() || self.candidates.len() == 1 {
            return best.1;
        }
        for (slope, shifts) in &self.candidates {
            let power = self.power(region, shifts);
            if power > best.0 {
                best = (power, *slope);
            }
        }
        best.1
    }

    /// Power of the sum of the shifted frames in a region, divided by the number of frames that cover each place.
    fn power(&self, region: &Region, shifts: &[(i64, i64)]) -> f32 {
        let (width, height) = self.planes[0].size();
        let squares = |range: &Range<usize>, n: usize| {
            let start = ((range.start as f32 / self.square) as usize).min(n - 1);
            start..((range.end as f32 / self.square).ceil() as usize).clamp(start + 1, n)
        };
        let (columns, rows) = (squares(&region.columns, width), squares(&region.rows, height));
        let (mut sums, mut counts) = (vec![0.0f32; columns.len()], vec![0.0f32; columns.len()]);
        let mut power = 0.0;
        for y in rows {
            sums.fill(0.0);
            counts.fill(0.0);
            for (plane, &(du, dv)) in self.planes.iter().zip(shifts) {
                let row = y as i64 + dv;
                if row < 0 || row >= height as i64 {
                    continue;
                }
                let start = (columns.start as i64).max(-du);
                let end = (columns.end as i64).min(width as i64 - du);
                if start >= end {
                    continue;
                }
                let at = (start - columns.start as i64) as usize..(end - columns.start as i64) as usize;
                let from = &plane.row(row as usize)[(start + du) as usize..(end + du) as usize];
                sums[at.clone()].iter_mut().zip(from).for_each(|(sum, x)| *sum += x);
                counts[at].iter_mut().for_each(|count| *count += 1.0);
            }
            power += sums.iter().zip(&counts).map(|(sum, count)| sum * sum / count.max(1.0)).sum::<f32>();
        }
        power
    }
}

/// Each value less the mean of its four neighbours, with the border repeated.
fn without_slopes(plane: &Plane) -> Plane {
    let (width, height) = plane.size();
    let mut out = Plane::zeros(width, height);
    for v in 0..height {
        let (above, at, below) = (plane.row(v.saturating_sub(1)), plane.row(v), plane.row((v + 1).min(height - 1)));
        let row = out.row_mut(v);
        for u in 0..width {
            let (left, right) = (at[u.saturating_sub(1)], at[(u + 1).min(width - 1)]);
            row[u] = at[u] - 0.25 * ((above[u] + below[u]) + (left + right));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::params::slope_grid::SlopeGrid;
    use crate::synth::random::Stream;

    #[test]
    fn each_part_has_its_own_motion() {
        let mut stream = Stream::new(3, 0);
        let scene = Plane::from_fn(340, 200, |_, _| stream.normal() as f32);
        // The left half moves by 2 px/frame to the right, the right half as fast to the left.
        let frame = |t: usize| {
            Plane::from_fn(256, 192, |u, v| {
                let by = if u < 128 { 40 - 2 * t } else { 40 + 2 * t };
                scene.at(u + by, v)
            })
        };
        let frames: Vec<BoxPyramid> = (0..8).map(|t| BoxPyramid::new(&frame(t), 5)).collect();
        let pyramids: Vec<&BoxPyramid> = frames.iter().collect();
        let times: Vec<f32> = (0..8).map(|t| t as f32).collect();
        let slopes: Vec<Slope> = SlopeGrid::plane(-3.0..=3.0, 7, -1.0..=1.0, 3).slopes().collect();
        let motion = SceneMotion { pyramids: &pyramids, times: &times, slopes: &slopes };
        let found = motion.slopes_at(&[(30.0, 90.0), (220.0, 90.0)], (256, 192));
        assert_eq!(found, [Slope::new(2.0, 0.0), Slope::new(-2.0, 0.0)]);
        // Where pixels are so large that nothing moves, and where there is no choice, the slowest is taken.
        let region = Region { columns: 0..128, rows: 0..128 };
        assert_eq!(motion.for_octave(4).slope_in(&region), Slope::default());
        let one = SceneMotion { slopes: &slopes[..1], ..motion };
        assert_eq!(one.for_octave(0).slope_in(&region), slopes[0]);
    }
}
