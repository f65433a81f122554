//! Contrasts: differences of neighbouring frames in which the scene cancels and the noise stays.
//!
//! Three consecutive frames enter with the weights 1, −2, 1, which removes steady changes; each is read where the scene
//! has moved to, in whole pixels, so that nothing is interpolated and the noise is unchanged. A texture that lies half
//! a pixel off leaves less than two percent of its power.

use super::pyramid::BoxPyramid;
use crate::detector::params::slope_grid::Slope;
use crate::detector::scale_space::octave::stack_tiles;
use crate::kernel::stack::FrameOffset;
use crate::plane::Plane;
use crate::plane::tile::{Region, Tile};
use std::ops::Range;

/// Frames, by index, and their weights; the squares of the weights sum to 1, so that a contrast has the variance of one
/// frame.
pub type Contrast = Vec<(usize, f32)>;

/// Contrasts of neighbours among `frames` frames (at least two): those that share no frame come first.
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

/// Chooses the frames, of `frames` frames of `pixels` pixels each, that are examined closely, and the contrasts among
/// these: triples of neighbours, from the first to the last, about three million pixels in all, at least two triples.
/// All frames where they are few.
pub fn looked_at(frames: usize, pixels: usize) -> (Vec<usize>, Vec<Contrast>) {
    let max = frames / 3;
    let triples = (LOOKED_PIXELS / (3 * pixels.max(1))).clamp(2, max.max(2));
    if triples > max || frames < 6 {
        return ((0..frames).collect(), contrasts(frames));
    }
    let start = |i: usize| i * (frames - 3) / (triples - 1);
    let looked = (0..triples).flat_map(|i| start(i)..start(i) + 3).collect();
    let apart = contrasts(3 * triples).into_iter().take(triples).collect();
    (looked, apart)
}

/// Number of pixels of all frames that are examined closely, about.
const LOOKED_PIXELS: usize = 3_000_000;

/// Pixels that a contrast reads: the frames themselves at an octave's resolution, or means over squares.
#[derive(Debug, Clone, Copy)]
pub enum Pixels<'a> {
    /// The frames, and the octave to whose resolution they are brought.
    Frames(&'a [&'a Plane], i32),
    /// The pyramids, and the level whose means over squares of 2^level pixels are read.
    Squares(&'a [&'a BoxPyramid], usize),
}

impl Pixels<'_> {
    /// Size (columns, rows) of the pixels that are read, and the width of each in image pixels.
    fn grid(&self) -> ((usize, usize), f32) {
        match self {
            Self::Frames(frames, _) => (frames[0].size(), 1.0),
            Self::Squares(pyramids, level) => (pyramids[0].level(*level).size(), (1usize << level) as f32),
        }
    }

    /// Width of a pixel of a contrast's `region`, in the grid's pixels.
    fn unit(&self) -> f32 {
        match self {
            Self::Frames(_, octave) => (*octave as f32).exp2(),
            Self::Squares(..) => 1.0,
        }
    }

    /// Writes the contrast of the frames taken at `times` into `out`, in `region` of the octave, for a scene that moves
    /// by `slope` px/frame. `single` is scratch.
    pub fn contrast(
        &self,
        (contrast, times, slope): (&Contrast, &[f32], Slope),
        region: &Region,
        (out, single): (&mut Tile, &mut Vec<Tile>),
    ) {
        out.reset(region, (region.columns.len() + PADDING).next_multiple_of(16));
        region.rows.clone().for_each(|v| out.row_mut(v).fill(0.0));
        let ((width, height), pixel) = self.grid();
        let read = |range: &Range<usize>| {
            let at = |x: usize| x as f32 * self.unit();
            at(range.start).floor() as usize..at(range.end).ceil() as usize
        };
        let shifts_u = shifts(contrast, times, slope.u / pixel, &read(&region.columns), width);
        let shifts_v = shifts(contrast, times, slope.v / pixel, &read(&region.rows), height);
        for ((&(t, weight), whole_u), whole_v) in contrast.iter().zip(shifts_u).zip(shifts_v) {
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

/// Shifts in whole pixels by which the frames of a contrast, taken at `times`, are read farther along an axis of `n`
/// pixels for a scene that moves by `slope` pixels a frame. All are moved by the same amount where that keeps the read
/// of the pixels `range` inside: near a border another part of the scene is used.
pub(super) fn shifts(contrast: &Contrast, times: &[f32], slope: f32, range: &Range<usize>, n: usize) -> Vec<i64> {
    let middle = times[contrast[contrast.len() / 2].0];
    let mut shifts: Vec<i64> = contrast.iter().map(|&(t, _)| ((times[t] - middle) * slope).round() as i64).collect();
    let (min, max) = shifts.iter().fold((0, 0), |(a, b), &s| (a.min(s), b.max(s)));
    let (start, end, n) = (range.start as i64, range.end as i64, n as i64);
    if end - start + max - min > n {
        // The scene moves farther than the readable range: frames are compared where they are.
        shifts.fill(0);
    } else if start + min < 0 {
        shifts.iter_mut().for_each(|s| *s -= start + min);
    } else if end + max > n {
        shifts.iter_mut().for_each(|s| *s += n - end - max);
    }
    shifts
}

#[cfg(test)]
mod tests {
    use super::*;
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
        for frames in 2..40 {
            for pixels in [1000, 200_000, 5_000_000] {
                let (looked, contrasts) = looked_at(frames, pixels);
                assert!(looked.windows(2).all(|w| w[0] < w[1]) && looked[looked.len() - 1] < frames, "{looked:?}");
                assert!(!contrasts.is_empty());
                let neighbours = |c: &Contrast| looked[c[c.len() - 1].0] - looked[c[0].0] == c.len() - 1;
                assert!(contrasts.iter().all(neighbours), "{frames} {pixels}");
            }
        }
    }

    #[test]
    fn a_scene_that_moves_by_whole_pixels_cancels_and_noise_stays() {
        let mut stream = Stream::new(4, 0);
        let scene = Plane::from_fn(200, 100, |_, _| stream.normal() as f32);
        let moved = |t: usize, noise: f32, stream: &mut Stream| {
            let at = |u: usize, v: usize| scene.at((u + 20).saturating_sub(3 * t), (v + t).min(99));
            Plane::from_fn(160, 90, |u, v| at(u, v) + noise * stream.normal() as f32)
        };
        for noise in [0.0f32, 0.5] {
            let frames = [0, 1, 2].map(|t| moved(t, noise, &mut Stream::new(5, t as u64)));
            let frames: Vec<&Plane> = frames.iter().collect();
            // In the middle and at both ends, where another part of the scene is read.
            for columns in [0..40, 60..100, 120..160] {
                let region = Region { columns, rows: 10..60 };
                let (mut out, mut single) = (Tile::default(), Vec::new());
                let contrast = &contrasts(3)[0];
                let what = (contrast, &[0.0, 1.0, 2.0][..], Slope::new(3.0, -1.0));
                Pixels::Frames(&frames, 0).contrast(what, &region, (&mut out, &mut single));
                let power: f32 = region.rows.clone().flat_map(|v| out.row(v).to_vec()).map(|x| x * x).sum();
                let variance = power / (40.0 * 50.0);
                assert!(
                    (variance - noise * noise).abs() < 0.1 * noise * noise + 1e-9,
                    "{region:?} {noise}: {variance}"
                );
            }
        }
    }

    #[test]
    fn reads_stay_inside() {
        let contrast = &contrasts(3)[0];
        let shifts = |slope: f32, range: Range<usize>| shifts(contrast, &[0.0, 1.0, 2.0], slope, &range, 40);
        assert_eq!(shifts(3.0, 0..20), [0, 3, 6]);
        assert_eq!(shifts(3.0, 20..40), [-6, -3, 0]);
        assert_eq!(shifts(-3.0, 10..20), [3, 0, -3]);
        assert_eq!(shifts(3.0, 0..40), [0, 0, 0], "there is nowhere to go");
    }
}
