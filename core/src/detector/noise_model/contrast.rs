//! Contrasts, differences of neighbouring frames in which the scene cancels and noise stays; and the scene's motion.
//!
//! Three consecutive frames enter with the weights 1, −2, 1, which removes steady changes; each is read where the scene
//! has moved to, in whole pixels, so that nothing is interpolated. A texture half a pixel off leaves less than two
//! percent of its power. For each part the slope is the one of the search at which the mean of the shifted frames has
//! the most power. Contrasts, whose weights sum to 0, are independent of it: the choice leaves the noise.

use super::reading::BoxPyramid;
use crate::burst::Offset;
use crate::detector::params::Slope;
use crate::detector::scale_space::stack_tiles;
use crate::kernel::stack::FrameOffset;
use crate::plane::Plane;
use crate::plane::tile::{Region, Tile};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

/// Frames and their weights, whose squares sum to 1, so that a contrast has the variance of one frame.
pub type Contrast = Vec<(usize, f32)>;

/// Contrasts of neighbours among `frames` frames (at least two); contrasts that share no frame come first.
pub fn contrasts(frames: usize) -> Vec<Contrast> {
    let of = |start: usize, weights: &[f32]| {
        let norm = weights.iter().map(|w| w * w).sum::<f32>().sqrt();
        weights.iter().enumerate().map(|(i, &w)| (start + i, w / norm)).collect()
    };
    if frames == 2 {
        return vec![of(0, &[1.0, -1.0])];
    }
    let starts = (0..3).flat_map(|first| (first..frames - 2).step_by(3));
    starts.map(|start| of(start, &[1.0, -2.0, 1.0])).collect()
}

/// The frames that are examined closely, and their contrasts: at least two triples of neighbours; all frames if few.
pub fn looked_at(frames: usize, pixels: usize) -> (Vec<usize>, Vec<Contrast>) {
    let max = frames / 3;
    let triples = (LOOKED_PIXELS / (3 * pixels.max(1))).clamp(2, max.max(2));
    if triples > max || frames < 6 {
        return ((0..frames).collect(), contrasts(frames));
    }
    // From the first frame to the last, so that changes over the burst are seen.
    let start = |i: usize| i * (frames - 3) / (triples - 1);
    let looked = (0..triples).flat_map(|i| start(i)..start(i) + 3).collect();
    let apart = contrasts(3 * triples).into_iter().take(triples).collect();
    (looked, apart)
}

/// As [`looked_at`] for views at `offsets`: triples of neighbours in a row or in a column that share no view.
pub fn looked_at_views(offsets: &[Offset<f32>], pixels: usize) -> (Vec<usize>, Vec<Contrast>) {
    let at = |place: Offset<f32>| {
        offsets.iter().position(|own| (own.u - place.u).abs() < NEAR_STEPS && (own.v - place.v).abs() < NEAR_STEPS)
    };
    // A view in two triples would make their contrasts dependent.
    let mut free = vec![true; offsets.len()];
    let mut triples: Vec<[usize; 3]> = Vec::new();
    for step in [Offset { u: 1.0, v: 0.0 }, Offset { u: 0.0, v: 1.0 }] {
        for (middle, place) in offsets.iter().enumerate() {
            let back = at(*place - step);
            let on = at(Offset { u: place.u + step.u, v: place.v + step.v });
            let triple = back.zip(on).map(|(back, on)| [back, middle, on]);
            if let Some(triple) = triple.filter(|triple| triple.iter().all(|view| free[*view])) {
                triple.iter().for_each(|view| free[*view] = false);
                triples.push(triple);
            }
        }
    }
    if triples.is_empty() {
        return looked_at(offsets.len(), pixels);
    }
    let count = (LOOKED_PIXELS / (3 * pixels.max(1))).clamp(2, triples.len().max(2)).min(triples.len());
    let chosen: Vec<[usize; 3]> = (0..count).map(|i| triples[i * triples.len() / count]).collect();
    let mut looked: Vec<usize> = chosen.iter().flatten().copied().collect();
    looked.sort_unstable();
    let place = |view: &usize| looked.binary_search(view).unwrap_or_default();
    let weights = contrasts(3)[0].clone();
    let contrast = |triple: &[usize; 3]| triple.iter().map(place).zip(&weights).map(|(at, (_, w))| (at, *w)).collect();
    let contrasts = chosen.iter().map(contrast).collect();
    (looked, contrasts)
}

/// Distance in steps of the grid of views up to which a view counts as being at a place.
const NEAR_STEPS: f32 = 0.1;
/// Number of pixels of all frames that are examined closely, about.
const LOOKED_PIXELS: usize = 3_000_000;

/// Pixels that a contrast reads: the frames themselves at an octave's resolution, or means over squares.
#[derive(Debug, Clone, Copy)]
pub enum Pixels<'a> {
    /// Frames, and the octave to whose resolution they are brought.
    Frames(&'a [&'a Plane], i32),
    /// Pyramids, and the level whose means over squares of 2^level pixels are read.
    Squares(&'a [&'a BoxPyramid], usize),
}

impl Pixels<'_> {
    /// Writes the contrast in `region` of the octave, for a scene that moves by `slope` px/frame. `single` is scratch.
    pub fn contrast(
        &self,
        (contrast, offsets, slope): (&Contrast, &[Offset<f32>], Slope),
        region: &Region,
        (out, single): (&mut Tile, &mut Vec<Tile>),
    ) {
        out.reset(region, (region.columns.len() + PADDING).next_multiple_of(16));
        region.rows.clone().for_each(|v| out.row_mut(v).fill(0.0));
        // Size of the planes read, width of their pixels in image pixels, and of the octave's pixels in theirs.
        let ((width, height), pixel, unit) = match self {
            Self::Frames(frames, octave) => (frames[0].size(), 1.0, (*octave as f32).exp2()),
            Self::Squares(pyramids, level) => (pyramids[0].level(*level).size(), (1usize << level) as f32, 1.0),
        };
        let read = |range: &Range<usize>| {
            (range.start as f32 * unit).floor() as usize..(range.end as f32 * unit).ceil() as usize
        };
        let in_pixels = Slope::new(slope.u / pixel, slope.v / pixel);
        let region_read = (&read(&region.columns), &read(&region.rows));
        let shifts = shifts(contrast, offsets, in_pixels, region_read, (width, height));
        // Whole pixels only: interpolation would smooth the noise that is measured.
        for (&(t, weight), (whole_u, whole_v)) in contrast.iter().zip(shifts) {
            let mut add = |v: usize, row: &[f32]| {
                out.row_mut(v).iter_mut().zip(row).for_each(|(sum, x)| *sum += weight * x);
            };
            match self {
                Self::Frames(frames, octave) => {
                    let offset = FrameOffset { whole_u, whole_v, part_u: 0.0, part_v: 0.0, before_u: 0, before_v: 0 };
                    stack_tiles(&frames[t..=t], &[&[offset]], *octave, region, single);
                    region.rows.clone().for_each(|v| add(v, single[0].row(v)));
                }
                Self::Squares(pyramids, level) => {
                    let plane = pyramids[t].level(*level);
                    let mut row = vec![0.0; region.columns.len()];
                    for v in region.rows.clone() {
                        let from = plane.row((v as i64 + whole_v).clamp(0, height as i64 - 1) as usize);
                        for (x, u) in row.iter_mut().zip(region.columns.clone()) {
                            *x = from[(u as i64 + whole_u).clamp(0, width as i64 - 1) as usize];
                        }
                        add(v, &row);
                    }
                }
            }
        }
    }
}

/// Number of extra columns that a row of a tile has room for, for filters that read whole vectors.
const PADDING: usize = 32;

/// Shifts (u, v) in whole pixels by which the frames of a contrast, at `offsets`, are read farther for a scene that
/// moves by `slope` px/frame. On each axis all shift alike where the read of `columns` or `rows` leaves the image.
pub(super) fn shifts(
    contrast: &Contrast,
    offsets: &[Offset<f32>],
    slope: Slope,
    (columns, rows): (&Range<usize>, &Range<usize>),
    (width, height): (usize, usize),
) -> Vec<(i64, i64)> {
    let middle = offsets[contrast[contrast.len() / 2].0];
    let moved = |&(t, _): &(usize, f32)| slope.displacement(offsets[t] - middle);
    let moved: Vec<(f32, f32)> = contrast.iter().map(moved).collect();
    let u = kept_inside(moved.iter().map(|by| by.0.round() as i64).collect(), columns, width);
    let v = kept_inside(moved.iter().map(|by| by.1.round() as i64).collect(), rows, height);
    u.into_iter().zip(v).collect()
}

fn kept_inside(mut shifts: Vec<i64>, range: &Range<usize>, n: usize) -> Vec<i64> {
    let (min, max) = shifts.iter().fold((0, 0), |(a, b), &s| (a.min(s), b.max(s)));
    let (start, end, n) = (range.start as i64, range.end as i64, n as i64);
    if end - start + max - min > n {
        // The scene moves farther than the readable range: frames are compared in place.
        shifts.fill(0);
    } else if start + min < 0 {
        // All frames move back together, so that their distances stay those of the scene.
        shifts.iter_mut().for_each(|s| *s -= start + min);
    } else if end + max > n {
        shifts.iter_mut().for_each(|s| *s += n - end - max);
    }
    shifts
}

/// Motion from frame to frame, in pixels of the measurement, below which it does not matter.
const MIN_SHIFT: f32 = 0.25;
/// Level of the pyramid, above the octave's, at which the motion is measured: noise is small there.
const LEVELS_UP: i32 = 2;

/// Minimum side of the parts of an image that each have a motion, pixels.
const PART: usize = 64;
const MAX_PARTS: usize = 48;

#[derive(Debug, Clone, Copy)]
pub struct SceneMotion<'a> {
    pub pyramids: &'a [&'a BoxPyramid],
    /// Positions of the pyramids' frames, in frames of the burst.
    pub offsets: &'a [Offset<f32>],
    /// Possible slopes, px/frame.
    pub slopes: &'a [Slope],
}

impl SceneMotion<'_> {
    /// Motion for parts that are measured with pixels of 2^`octave` image pixels.
    pub fn for_octave(&self, octave: i32) -> OctaveMotion {
        let mut slopes = self.slopes.to_vec();
        // Slowest first: of equally good slopes the first one found is kept.
        slopes.sort_by(|a, b| a.magnitude().total_cmp(&b.magnitude()));
        let slowest = slopes.first().copied().unwrap_or_default();
        let fastest = slopes.last().map_or(0.0, |slope| slope.magnitude());
        let level = (octave + LEVELS_UP).max(1) as usize;
        let is_small = self.pyramids.first().is_none_or(|p| p.len() < level);
        if is_small || slopes.len() < 2 || fastest < MIN_SHIFT * (octave as f32).exp2() {
            return OctaveMotion { planes: Vec::new(), square: 1.0, candidates: vec![(slowest, Vec::new())] };
        }
        let square = (1usize << level) as f32;
        let (first, last) = (self.offsets[0], self.offsets[self.offsets.len() - 1]);
        let middle = Offset { u: 0.5 * (first.u + last.u), v: 0.5 * (first.v + last.v) };
        let (mut candidates, mut known) = (Vec::new(), BTreeSet::new());
        // Slopes that shift all frames by the same squares cannot be distinguished at this level.
        for slope in slopes {
            let squares = |px: f32| (px / square).round() as i64;
            let moved = self.offsets.iter().map(|&at| slope.displacement(at - middle));
            let shifts: Vec<(i64, i64)> = moved.map(|(u, v)| (squares(u), squares(v))).collect();
            if known.insert(shifts.clone()) {
                candidates.push((slope, shifts));
            }
        }
        let planes = self.pyramids.par_iter().map(|p| without_slopes(p.level(level))).collect();
        OctaveMotion { planes, square, candidates }
    }

    /// Slope at each of `places`: that of the middle 64 pixels a side of the part of the image around it.
    pub fn slopes_at(&self, places: &[(f32, f32)], (width, height): (usize, usize)) -> Vec<Slope> {
        let side = PART.max(((width * height) as f32 / MAX_PARTS as f32).sqrt() as usize);
        let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
        let motion = self.for_octave(0);
        let part = |index: usize| {
            let range = |i: usize, n: usize| {
                let (start, end) = (i * side, ((i + 1) * side).min(n));
                // The middle of a part stands for all of it, so that large pictures take no longer.
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

#[derive(Debug)]
pub struct OctaveMotion {
    /// Frames less their local mean, in squares of the pyramid; empty where the motion does not matter.
    planes: Vec<Plane>,
    /// Side of a square, image pixels.
    square: f32,
    /// Slopes that differ in squares, slowest first, with the squares by which each frame is shifted.
    candidates: Vec<(Slope, Vec<(i64, i64)>)>,
}

impl OctaveMotion {
    pub fn slope_in(&self, region: &Region) -> Slope {
        let slowest = self.candidates[0].0;
        if self.planes.is_empty() || self.candidates.len() == 1 {
            return slowest;
        }
        let powers = self.candidates.iter().map(|(slope, shifts)| (self.power(region, shifts), *slope));
        // Strictly more: of equal powers the slower slope, which comes first, stays.
        powers.fold((f32::NEG_INFINITY, slowest), |best, other| if other.0 > best.0 { other } else { best }).1
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
                let start = (columns.start as i64).max(-du);
                let end = (columns.end as i64).min(width as i64 - du);
                if row < 0 || row >= height as i64 || start >= end {
                    continue;
                }
                let at = (start - columns.start as i64) as usize..(end - columns.start as i64) as usize;
                let from = &plane.row(row as usize)[(start + du) as usize..(end + du) as usize];
                sums[at.clone()].iter_mut().zip(from).for_each(|(sum, x)| *sum += x);
                counts[at].iter_mut().for_each(|count| *count += 1.0);
            }
            // S²/n has the noise of one frame whatever n is, so that places with fewer frames count alike.
            power += sums.iter().zip(&counts).map(|(sum, count)| sum * sum / count.max(1.0)).sum::<f32>();
        }
        power
    }
}

fn without_slopes(plane: &Plane) -> Plane {
    let (width, height) = plane.size();
    let mut out = Plane::zeros(width, height);
    for v in 0..height {
        let (above, at, below) = (plane.row(v.saturating_sub(1)), plane.row(v), plane.row((v + 1).min(height - 1)));
        // The mean of the four neighbours equals the pixel wherever brightness is a plane.
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
    use crate::detector::params::SlopeGrid;
    use crate::synth::random::Stream;

    #[test]
    fn contrasts_keep_the_variance_and_take_off_what_changes_steadily() {
        for frames in [2, 3, 7, 10] {
            for contrast in contrasts(frames) {
                assert!((contrast.iter().map(|(_, w)| w * w).sum::<f32>() - 1.0).abs() < 1e-6);
                assert!(contrast.iter().map(|(_, w)| w).sum::<f32>().abs() < 1e-6);
                assert!(contrast.iter().all(|&(t, _)| t < frames));
            }
        }
        assert_eq!(contrasts(7).iter().map(|c| c[0].0).collect::<Vec<_>>(), [0, 3, 1, 4, 2]);
    }

    #[test]
    fn triples_lie_apart_from_first_to_last() {
        assert_eq!(looked_at(10, 2_000_000).0, [0, 1, 2, 7, 8, 9]);
        assert_eq!(looked_at(4, 2_000_000).0, [0, 1, 2, 3]);
        for (frames, pixels) in (2..40).flat_map(|frames| [(frames, 1000), (frames, 200_000), (frames, 5_000_000)]) {
            let (looked, contrasts) = looked_at(frames, pixels);
            assert!(
                looked.is_sorted_by(|a, b| a < b) && looked[looked.len() - 1] < frames && !contrasts.is_empty(),
                "{looked:?}"
            );
            let neighbours = |c: &Contrast| looked[c[c.len() - 1].0] - looked[c[0].0] == c.len() - 1;
            assert!(contrasts.iter().all(neighbours), "{frames} {pixels}");
        }
    }

    #[test]
    fn views_are_compared_with_their_neighbours_in_rows_and_columns() {
        let grid = |rows: usize, columns: usize| -> Vec<Offset<f32>> {
            crate::burst::Positions::grid(rows, columns).offsets().iter().map(|at| at.to_f32()).collect()
        };
        let (looked, contrasts) = looked_at_views(&grid(3, 5), 10_000);
        assert_eq!((looked.len(), contrasts.len()), (15, 5));
        assert_eq!(contrasts[1].iter().map(|(t, _)| looked[*t]).collect::<Vec<_>>(), [5, 6, 7]);
        assert_eq!(contrasts[3].iter().map(|(t, _)| looked[*t]).collect::<Vec<_>>(), [3, 8, 13]);
        let (looked, contrasts) = looked_at_views(&grid(9, 9), 500_000);
        assert_eq!((looked.len(), contrasts.len()), (6, 2));
        assert!(contrasts.iter().flatten().all(|(t, _)| *t < 6) && looked.is_sorted());
        assert_eq!(looked_at_views(&grid(2, 2), 10_000), looked_at(4, 10_000));
    }

    #[test]
    fn reads_stay_inside() {
        let contrast = &contrasts(3)[0];
        let at = [0.0, 1.0, 2.0].map(|time| Offset::from(time).to_f32());
        let both =
            |slope: f32, range: Range<usize>| shifts(contrast, &at, Slope::new(slope, 0.0), (&range, &range), (40, 40));
        let shifts = |slope: f32, range: Range<usize>| -> Vec<i64> {
            both(slope, range).into_iter().map(|(u, v)| if v == 0 { u } else { i64::MAX }).collect()
        };
        assert_eq!(shifts(3.0, 0..20), [0, 3, 6]);
        assert_eq!(shifts(3.0, 20..40), [-6, -3, 0]);
        assert_eq!(shifts(-3.0, 10..20), [3, 0, -3]);
        assert_eq!(shifts(3.0, 0..40), [0, 0, 0], "there is nowhere to go");
    }

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
        let frames: Vec<BoxPyramid> = (0..8).map(|t| BoxPyramid::from_halved(frame(t).halved(), 5)).collect();
        let pyramids: Vec<&BoxPyramid> = frames.iter().collect();
        let at: Vec<Offset<f32>> = (0..8).map(|t| Offset::from(f64::from(t)).to_f32()).collect();
        let slopes: Vec<Slope> = SlopeGrid::plane(-3.0..=3.0, 7, -1.0..=1.0, 3).slopes().collect();
        let motion = SceneMotion { pyramids: &pyramids, offsets: &at, slopes: &slopes };
        let found = motion.slopes_at(&[(30.0, 90.0), (220.0, 90.0)], (256, 192));
        assert_eq!(found, [Slope::new(2.0, 0.0), Slope::new(-2.0, 0.0)]);
        // Where pixels are so large that nothing moves, and where there is no choice, the slowest is taken.
        let region = Region { columns: 0..128, rows: 0..128 };
        assert_eq!(motion.for_octave(4).slope_in(&region), Slope::default());
        assert_eq!(SceneMotion { slopes: &slopes[..1], ..motion }.for_octave(0).slope_in(&region), slopes[0]);
    }
}
