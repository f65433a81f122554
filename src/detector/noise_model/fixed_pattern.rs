//! What belongs to the sensor and not to the scene: hot pixels, and columns and rows with an offset of their own.
//!
//! A fixed pattern stays where it is while the scene moves, and it is as sharp as a pixel, which nothing is that came through a lens. So it is looked for in the mean of
//! the frames at slope 0, separately in the first and the second half of the burst, and must be in both. On a tripod the scene stays as well; then
//! the two cannot be told apart, and nothing is changed.

use super::high_pass::{FREE_VALUES, HighPass, quiet_variance};
use super::pyramid::BoxPyramid;
use crate::detector::motion::motion_stack;
use crate::detector::params::Interpolation;
use crate::detector::slope_grid::Slope;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use rayon::prelude::*;
use serde::Serialize;

/// The pattern of a sensor, in the units of the frames.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct FixedPattern {
    /// Columns and rows of pixels that are far brighter or darker than all pixels around them, in every frame; row by row.
    pub hot_pixels: Vec<(usize, usize)>,
    /// What each column is lifted by.
    pub columns: Option<Stripes>,
    /// What each row is lifted by.
    pub rows: Option<Stripes>,
    /// How many pixels would be hot, were it not that the scene stays in place too.
    pub inseparable: usize,
}

/// Offsets of columns or rows, as far as they change within [`REACH`] of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stripes {
    /// One a column or row, fraction of full scale.
    pub offsets: Vec<f32>,
    /// Their standard deviation.
    pub deviation: f32,
}

/// Columns to each side whose mean an offset is measured against: what changes more slowly may be the scene.
pub const REACH: usize = 16;
/// How many standard deviations of the frames' mean a hot pixel is beyond every neighbour.
const HOT: f32 = 6.0;
/// Parts that an image is cut into; a stripe must be in most of them.
const BANDS: usize = 8;
/// How many standard errors the halves' common stripes must be above none.
const STRIPES: f32 = 6.0;
/// Frames of each half that are looked at: what they do not show is far below the noise of D.
const FRAMES_A_HALF: usize = 3;
/// More hot pixels than this share of all are texture.
const MOST_HOT: f32 = 0.005;

impl FixedPattern {
    /// Whether there is nothing to be removed.
    pub fn is_empty(&self) -> bool {
        self.hot_pixels.is_empty() && self.columns.is_none() && self.rows.is_none()
    }

    /// Finds the pattern of frames of equal brightness; `variance` is that of the noise of one. Nothing for fewer than four frames.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` was cancelled.
    pub fn find(frames: &[&Plane], variance: f32, monitor: &Monitor) -> Result<Self, Cancelled> {
        let (width, height) = frames[0].size();
        if frames.len() < 4 || width < 2 * REACH || height < 2 * REACH || variance <= 0.0 {
            return Ok(Self::default());
        }
        let mean_of = |frames: &[&Plane]| motion_stack(frames, Slope::default(), Interpolation::Linear, monitor);
        let (first, second) = frames.split_at(frames.len() / 2);
        let (first, second) = (spread_over(first), spread_over(second));
        let mut halves = [mean_of(&first)?, mean_of(&second)?];
        let frames = &[first, second].concat()[..];
        let mut hot_pixels = hot_pixels(&halves, frames, variance);
        halves.iter_mut().for_each(|half| mask(half, &hot_pixels));
        // Where two hot pixels touch, the brighter one hides the other.
        let more = hot_beside(&hot_pixels, &halves, frames, variance);
        halves.iter_mut().for_each(|half| mask(half, &more));
        hot_pixels.extend(more);
        hot_pixels.sort_by_key(|&(u, v)| (v, u));
        let mut inseparable = 0;
        if !hot_pixels.is_empty() && (stays(&halves) || hot_pixels.len() as f32 > MOST_HOT * (width * height) as f32) {
            inseparable = hot_pixels.len();
            hot_pixels.clear();
        }
        let columns = Stripes::find(&halves.each_ref().map(band_means));
        let rows = Stripes::find(&halves.each_ref().map(row_means));
        Ok(Self { hot_pixels, columns, rows, inseparable })
    }

    /// Takes the pattern off a frame.
    pub fn remove_from(&self, frame: &mut Plane) {
        mask(frame, &self.hot_pixels);
        let rows = self.rows.as_ref().map(|rows| &rows.offsets);
        for v in 0..frame.height() {
            let of_row = rows.map_or(0.0, |rows| rows[v]);
            let row = frame.row_mut(v);
            match &self.columns {
                Some(columns) => row.iter_mut().zip(&columns.offsets).for_each(|(x, offset)| *x -= offset + of_row),
                None => row.iter_mut().for_each(|x| *x -= of_row),
            }
        }
    }
}

/// A few of the frames, from the first to the last.
fn spread_over<'a>(frames: &[&'a Plane]) -> Vec<&'a Plane> {
    let count = frames.len().min(FRAMES_A_HALF);
    (0..count).map(|i| frames[i * frames.len() / count]).collect()
}

/// Replaces pixels by the median of those around them.
fn mask(plane: &mut Plane, pixels: &[(usize, usize)]) {
    for &(u, v) in pixels {
        let mut around = neighbours(plane, u, v);
        around.sort_by(f32::total_cmp);
        plane.row_mut(v)[u] = 0.5 * (around[3] + around[4]);
    }
}

/// The eight pixels around one; at the border the nearest ones there are.
fn neighbours(plane: &Plane, u: usize, v: usize) -> [f32; 8] {
    let (width, height) = plane.size();
    let at = |du: i64, dv: i64| {
        let inside = |x: i64, n: usize| {
            if x < 0 {
                1
            } else if x >= n as i64 {
                n as i64 - 2
            } else {
                x
            }
        };
        plane.at(inside(u as i64 + du, width) as usize, inside(v as i64 + dv, height) as usize)
    };
    [at(-1, -1), at(0, -1), at(1, -1), at(-1, 0), at(1, 0), at(-1, 1), at(0, 1), at(1, 1)]
}

/// How far a value lies beyond all of `around`, with its sign; 0 inside their range.
fn beyond(value: f32, around: &[f32; 8]) -> f32 {
    let (min, max) = around.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
    (value - max).max(0.0) + (value - min).min(0.0)
}

fn hot_pixels(halves: &[Plane; 2], frames: &[&Plane], variance: f32) -> Vec<(usize, usize)> {
    let (width, height) = halves[0].size();
    // A first look at single halves, whose noise is √2 of the whole's.
    let limit = 0.5 * HOT * (variance / frames.len() as f32).sqrt();
    (0..height)
        .into_par_iter()
        .flat_map_iter(|v| {
            let row = halves[0].row(v);
            // Beyond the two neighbours in the row by the limit: nearly nothing is, and it is quickly seen.
            let stands_out = move |u: usize| {
                let (left, right) =
                    (row[if u == 0 { 1 } else { u - 1 }], row[if u + 1 == width { u - 1 } else { u + 1 }]);
                row[u] > left.max(right) + limit || row[u] < left.min(right) - limit
            };
            (0..width).filter(move |&u| stands_out(u)).map(move |u| (u, v)).collect::<Vec<_>>()
        })
        .filter(|&(u, v)| is_hot(halves, frames, variance, u, v))
        .collect()
}

fn hot_beside(found: &[(usize, usize)], halves: &[Plane; 2], frames: &[&Plane], variance: f32) -> Vec<(usize, usize)> {
    let (width, height) = halves[0].size();
    let mut beside: Vec<(usize, usize)> = found
        .iter()
        .flat_map(|&(u, v)| {
            (v.saturating_sub(1)..(v + 2).min(height))
                .flat_map(move |y| (u.saturating_sub(1)..(u + 2).min(width)).map(move |x| (x, y)))
        })
        .filter(|at| !found.contains(at) && is_hot(halves, frames, variance, at.0, at.1))
        .collect();
    beside.sort_unstable();
    beside.dedup();
    beside
}

/// Whether the pixel lies beyond all its neighbours in both halves together, and beyond their mean in nearly every frame.
fn is_hot(halves: &[Plane; 2], frames: &[&Plane], variance: f32, u: usize, v: usize) -> bool {
    let mut around = neighbours(&halves[0], u, v);
    around.iter_mut().zip(neighbours(&halves[1], u, v)).for_each(|(a, b)| *a = 0.5 * (*a + b));
    let off = beyond(0.5 * (halves[0].at(u, v) + halves[1].at(u, v)), &around);
    if off.abs() < HOT * (variance / frames.len() as f32).sqrt() {
        return false;
    }
    // The noise there, which may be more than usual: how the pixels around change from frame to frame. What crosses the pixel makes it larger too.
    let n = frames.len() as f32;
    let mut squares = [0.0f32; 8];
    let mut sums = [0.0f32; 8];
    let (mut mean, mut own, mut above) = (0.0, 0.0, 0usize);
    for frame in frames {
        let around = neighbours(frame, u, v);
        let here = frame.at(u, v) - around.iter().sum::<f32>() / 8.0;
        (mean, own) = (mean + here / n, own + here * here);
        above += usize::from(here > 0.0);
        for ((sum, square), x) in sums.iter_mut().zip(&mut squares).zip(around) {
            (*sum, *square) = (*sum + x, *square + x * x);
        }
    }
    let around = squares.iter().zip(sums).map(|(square, sum)| square - sum * sum / n).sum::<f32>() / (8.0 * (n - 1.0));
    let own = (own - n * mean * mean) / (n - 1.0);
    let in_nearly_all = above.min(frames.len() - above) * 10 <= frames.len();
    let error = (around.max(variance) / n).sqrt();
    in_nearly_all && off.abs() > HOT * error && mean.abs() > HOT * error.max(0.5 * (own.max(0.0) / n).sqrt())
}

/// Whether the scene stays in place: what the halves have in common is more than what they differ by.
fn stays(halves: &[Plane; 2]) -> bool {
    let coarse = halves.each_ref().map(|half| {
        let by_2 = BoxPyramid::new(half, 1);
        BoxPyramid::new(by_2.level(1), 1)
    });
    if coarse.iter().any(BoxPyramid::is_empty) {
        return false;
    }
    let squares = HighPass::new(&[&coarse[0], &coarse[1]]);
    let of = |sign: f32| quiet_variance(squares.variances(&[(0, 1.0), (1, sign)]), FREE_VALUES);
    !squares.places.is_empty() && of(1.0) > 1.5 * of(-1.0)
}

/// The means of each column over each of [`BANDS`] bands of rows.
fn band_means(plane: &Plane) -> Vec<Vec<f32>> {
    let height = plane.height();
    (0..BANDS)
        .into_par_iter()
        .map(|band| {
            let rows = band * height / BANDS..(band + 1) * height / BANDS;
            let mut sums = vec![0.0f32; plane.width()];
            for v in rows.clone() {
                sums.iter_mut().zip(plane.row(v)).for_each(|(sum, x)| *sum += x);
            }
            sums.iter_mut().for_each(|sum| *sum /= rows.len().max(1) as f32);
            sums
        })
        .collect()
}

/// The means of each row over each of [`BANDS`] bands of columns.
fn row_means(plane: &Plane) -> Vec<Vec<f32>> {
    let width = plane.width();
    let mut bands = [(); BANDS].map(|()| Vec::with_capacity(plane.height()));
    for v in 0..plane.height() {
        let row = plane.row(v);
        for (i, band) in bands.iter_mut().enumerate() {
            let part = &row[i * width / BANDS..(i + 1) * width / BANDS];
            // Four sums, so that they do not wait for one another.
            let (quads, rest) = part.as_chunks::<4>();
            let sums = quads.iter().fold([0.0f32; 4], |s, q| [s[0] + q[0], s[1] + q[1], s[2] + q[2], s[3] + q[3]]);
            band.push((sums.iter().sum::<f32>() + rest.iter().sum::<f32>()) / part.len().max(1) as f32);
        }
    }
    bands.to_vec()
}

impl Stripes {
    /// The stripes that the band means of both halves of a burst share; `None` if there are none, or they are smooth as a scene is.
    fn find(halves: &[Vec<Vec<f32>>; 2]) -> Option<Self> {
        let [first, second] = halves.each_ref().map(|bands| offsets(bands));
        let n = first.len() as f32;
        let product = |shift: usize| first.iter().zip(&second[shift..]).map(|(a, b)| a * b).sum::<f32>() / n;
        let power = |x: &[f32]| x.iter().map(|x| x * x).sum::<f32>() / n;
        let common = product(0);
        let error = (power(&first) * power(&second) / n).sqrt();
        if common <= STRIPES * error || product(1) > 0.4 * common || product(2) > 0.4 * common {
            return None;
        }
        let both: Vec<f32> = first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b)).collect();
        Some(Self { offsets: both, deviation: common.sqrt() })
    }
}

/// By how much each column differs from those around it: the median over the bands.
fn offsets(bands: &[Vec<f32>]) -> Vec<f32> {
    let sharp: Vec<Vec<f32>> = bands.iter().map(|band| less_local_mean(band)).collect();
    (0..bands[0].len())
        .map(|u| {
            let mut values: Vec<f32> = sharp.iter().map(|band| band[u]).collect();
            values.sort_by(f32::total_cmp);
            0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
        })
        .collect()
}

/// Values less the mean of those within [`REACH`].
fn less_local_mean(values: &[f32]) -> Vec<f32> {
    let mut sums = vec![0.0f64];
    for x in values {
        sums.push(sums[sums.len() - 1] + f64::from(*x));
    }
    (0..values.len())
        .map(|u| {
            let (start, end) = (u.saturating_sub(REACH), (u + REACH + 1).min(values.len()));
            values[u] - ((sums[end] - sums[start]) / (end - start) as f64) as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Burst;
    use crate::synth::random::Stream;
    use crate::synth::{NoiseCase, SceneParams, synth_scene};

    /// Rows as columns.
    fn turned(plane: &Plane) -> Plane {
        Plane::from_fn(plane.height(), plane.width(), |u, v| plane.at(v, u))
    }

    fn planes(burst: &Burst) -> Vec<Plane> {
        burst.frames.iter().map(|f| (**f).clone()).collect()
    }

    fn find(frames: &[Plane], sigma: f32) -> FixedPattern {
        FixedPattern::find(&frames.iter().collect::<Vec<_>>(), sigma * sigma, &Monitor::default())
            .expect("not cancelled")
    }

    fn case(case: NoiseCase) -> Vec<Plane> {
        planes(&case.burst((320, 240), 10, 0.02, 5, &Monitor::default()).expect("not cancelled"))
    }

    fn scene(max_slope: f64) -> Vec<Plane> {
        let scene = SceneParams { width: 320, height: 240, layers: 1, max_slope, ..SceneParams::default() };
        planes(&synth_scene(&scene, &Monitor::default()).expect("a scene").0)
    }

    fn deviation(plane: &Plane) -> f32 {
        let n = plane.data().len() as f32;
        let mean = plane.data().iter().sum::<f32>() / n;
        (plane.data().iter().map(|x| (x - mean).powi(2)).sum::<f32>() / n).sqrt()
    }

    #[test]
    fn nothing_is_found_where_there_is_no_pattern() {
        for noise in [NoiseCase::White, NoiseCase::Correlated, NoiseCase::NoisyFrame] {
            assert_eq!(find(&case(noise), 0.02), FixedPattern::default(), "{noise:?}");
        }
        assert_eq!(find(&scene(3.0), 0.04), FixedPattern::default());
    }

    #[test]
    fn hot_pixels_are_found_and_masked() {
        let frames = case(NoiseCase::HotPixels);
        let pattern = find(&frames, 0.02);
        assert!((190..=200).contains(&pattern.hot_pixels.len()), "{}", pattern.hot_pixels.len());
        let mut clean = frames[3].clone();
        pattern.remove_from(&mut clean);
        assert!(deviation(&frames[3]) > 0.021 && (deviation(&clean) / 0.02 - 1.0).abs() < 0.01);
        assert!(clean.data().iter().all(|x| (x - 0.5).abs() < 0.13));
    }

    #[test]
    fn columns_and_rows_are_taken_off() {
        let upright = case(NoiseCase::ColumnStripes);
        let lying: Vec<Plane> = upright.iter().map(turned).collect();
        for (frames, is_upright) in [(upright, true), (lying, false)] {
            let pattern = find(&frames, 0.02);
            assert_eq!((pattern.columns.is_some(), pattern.rows.is_some()), (is_upright, !is_upright));
            let stripes = pattern.columns.as_ref().or(pattern.rows.as_ref()).expect("found");
            assert!((stripes.deviation / 0.02 - 1.0).abs() < 0.15, "{}", stripes.deviation);
            let mut clean = frames[0].clone();
            pattern.remove_from(&mut clean);
            assert!(deviation(&frames[0]) > 0.026 && deviation(&clean) < 0.0215, "{}", deviation(&clean));
        }
    }

    #[test]
    fn a_pattern_is_found_under_a_moving_scene_and_not_on_a_tripod() {
        let mut chance = Stream::new(3, 0);
        let hot: Vec<(usize, usize)> = (0..40).map(|_| (chance.below(320), chance.below(240))).collect();
        let with_hot = |mut frames: Vec<Plane>| {
            frames.iter_mut().for_each(|f| hot.iter().for_each(|&(u, v)| f.row_mut(v)[u] += 0.5));
            frames
        };
        let moving = find(&with_hot(scene(3.0)), 0.04);
        assert!((36..=42).contains(&moving.hot_pixels.len()), "{}", moving.hot_pixels.len());
        assert_eq!(moving.inseparable, 0);
        // The same frame with new noise each time: what stays may be the scene.
        let picture = scene(3.0).swap_remove(0);
        let still = (0..10)
            .map(|t| {
                let mut noise = Stream::new(4, t);
                Plane::from_fn(320, 240, |u, v| picture.at(u, v) + 0.01 * noise.normal() as f32)
            })
            .collect();
        let still = find(&with_hot(still), 0.01);
        assert!(still.hot_pixels.is_empty() && still.inseparable >= 30, "{still:?}");
    }
}
