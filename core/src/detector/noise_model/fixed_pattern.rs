//! Fixed pattern of a sensor: hot pixels, far brighter or darker than all around them in every frame, or in some if
//! they flicker; and stripes, columns and rows with an offset of their own.
//!
//! The pattern stays while the scene moves, and is sharper than any image through a lens. So it is detected in the mean
//! of the frames at slope 0, and must be in both halves of the burst. On a tripod the two cannot be separated, and
//! nothing is changed. Without this `column-stripes` has 597 false features a megapixel, `hot-pixels` 47, not 6.

use super::changing_lines::{ChangingLines, dot, median as median_of_bands};
use super::contrast::Contrast;
use super::high_pass::{FREE_VALUES, HighPass, around, quiet_variance};
use super::reading::{BoxPyramid, Lines, REACH, Reading, less_local_mean};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The pattern of a sensor, in the units of the frames.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct FixedPattern {
    /// Columns and rows of pixels far brighter or darker than all around them, in every frame or in some; row by row.
    pub hot_pixels: Vec<(usize, usize)>,
    /// Offsets of the columns; `None` where they are smooth or not significant.
    pub columns: Option<Stripes>,
    /// Offsets of the rows, alike.
    pub rows: Option<Stripes>,
    /// Offsets of columns that change from frame to frame, which are taken off each frame anew.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub changing_columns: Option<ChangingLines>,
    /// Offsets of rows that change from frame to frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub changing_rows: Option<ChangingLines>,
    /// Number of pixels that were bright in one frame only, all frames together, and were masked there.
    #[serde(skip_serializing_if = "super::is_zero")]
    pub struck: usize,
    /// Number of pixels that would be hot, but cannot be separated from a scene that stays in place too.
    pub inseparable: usize,
}

const MAX_HOT: f32 = 0.005;

impl FixedPattern {
    /// Contrast with its row above which a pixel stands out from noise of `variance`; `None` for few or tiny frames.
    pub(super) fn stands_out(frames: usize, (width, height): (usize, usize), variance: f32) -> Option<f32> {
        let can_be_found = frames >= 4 && width >= 2 * REACH && height >= 2 * REACH && variance > 0.0;
        can_be_found.then(|| HOT * (variance / frames as f32).sqrt())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.hot_pixels.is_empty() && !self.has_lines()
    }

    pub(super) fn has_lines(&self) -> bool {
        let changing = [self.changing_columns, self.changing_rows];
        self.columns.is_some() || self.rows.is_some() || changing.iter().any(Option::is_some)
    }

    /// Hot pixels of frames of equal brightness, whose noise has this `variance`; none where only pyramids were read.
    pub(super) fn find(frames: &[&Plane], reading: &Reading, variance: f32) -> Self {
        if reading.columns.is_empty() {
            return Self::default();
        }
        let (width, height) = frames[0].size();
        let mut hot_pixels = find(&reading.standing_out, frames, variance);
        let mut inseparable = 0;
        let are_texture = hot_pixels.len() as f32 > MAX_HOT * (width * height) as f32;
        // So many pixels are texture, and on a tripod even few may belong to the scene: nothing is masked then.
        if !hot_pixels.is_empty() && (are_texture || stays(&reading.pyramids, &hot_pixels)) {
            inseparable = hot_pixels.len();
            hot_pixels.clear();
        }
        let smeared: Vec<(usize, usize)> = hot_pixels.iter().flat_map(|at| smeared(frames, variance, *at)).collect();
        hot_pixels.extend(smeared);
        hot_pixels.sort_unstable_by_key(|&(u, v)| (v, u));
        hot_pixels.dedup();
        Self { hot_pixels, inseparable, ..Self::default() }
    }

    /// Offsets of the lines, once hot pixels are masked: a few lift the means of their lines by more than any offset.
    pub(super) fn with_lines(self, reading: &Reading) -> Self {
        let [columns, rows] = [&reading.columns, &reading.rows].map(|lines| Stripes::find(&halves(lines)));
        Self { columns, rows, ..self }
    }

    pub(super) fn remove_from(&self, frame: &mut Plane) {
        let (width, height) = frame.size();
        let along = |x: usize, length: usize| (x as f32 + 0.5) / length as f32 - 0.5;
        let of = |lines: &Option<Stripes>, line: usize, along| lines.as_ref().map_or(0.0, |s| s.at(line, along));
        let lines = if self.has_lines() { height } else { 0 };
        for v in 0..lines {
            for (u, x) in frame.row_mut(v).iter_mut().enumerate() {
                *x -= of(&self.columns, u, along(v, height)) + of(&self.rows, v, along(u, width));
            }
        }
        // Last, as their neighbours have other lines' offsets.
        mask(frame, &self.hot_pixels);
    }
}

fn halves(frames: &[Lines]) -> [Lines; 2] {
    let (first, second) = frames.split_at(frames.len() / 2);
    [first, second].map(|half| {
        let mut mean = half[0].clone();
        for frame in &half[1..] {
            mean.iter_mut().flatten().zip(frame.iter().flatten()).for_each(|(sum, x)| *sum += x);
        }
        mean.iter_mut().flatten().for_each(|sum| *sum /= half.len() as f32);
        mean
    })
}

fn stays(pyramids: &[BoxPyramid], hot: &[(usize, usize)]) -> bool {
    let (first, second) = pyramids.split_at(pyramids.len() / 2);
    let mean = |half: &[BoxPyramid]| {
        let mut sum = half[0].level(1).clone();
        for pyramid in &half[1..] {
            sum.data_mut().iter_mut().zip(pyramid.level(1).data()).for_each(|(sum, x)| *sum += x);
        }
        let (width, height) = sum.size();
        // The hot pixels themselves must not make the halves alike.
        let halved = hot.iter().map(|&(u, v)| (u / 2, v / 2)).filter(|&(u, v)| u < width && v < height);
        mask(&mut sum, &halved.collect::<Vec<_>>());
        sum
    };
    let squares = HighPass::new(&[&mean(first), &mean(second)]);
    // The sum of the halves keeps what stays, their difference only noise.
    let of = |sign: f32| quiet_variance(squares.variances(&[(0, 1.0), (1, sign)]), FREE_VALUES);
    !squares.places.is_empty() && of(1.0) > 1.5 * of(-1.0)
}

/// Distance of a hot pixel from every neighbour, in standard deviations of the frames' mean.
const HOT: f32 = 6.0;

/// Part of a hot pixel's contrast that one beside it has at least if it is smeared; standard deviations of the mean.
const SMEARED: [f32; 2] = [0.1, 3.0];

/// Hot pixels among those that stand out of their row and their neighbours, from the first row to the last.
pub fn find(standing_out: &[(usize, usize)], frames: &[&Plane], variance: f32) -> Vec<(usize, usize)> {
    let is_hot = |at: &(usize, usize), known: &[(usize, usize)]| is_hot(frames, variance, *at, known);
    let mut found: Vec<(usize, usize)> = standing_out.iter().copied().filter(|at| is_hot(at, &[])).collect();
    // Where two hot pixels touch, the brighter one hides the other.
    let mut beside: Vec<(usize, usize)> = found.iter().flat_map(|at| around(*at, frames[0].size())).collect();
    beside.sort_unstable();
    beside.dedup();
    beside.retain(|at| !found.contains(at) && is_hot(at, &found));
    found.extend(beside);
    found.sort_by_key(|&(u, v)| (v, u));
    found
}

/// Pixels around a hot one with a part of its contrast: making colours or smoothing spreads a hot pixel over nine.
fn smeared(frames: &[&Plane], variance: f32, (u, v): (usize, usize)) -> Vec<(usize, usize)> {
    let (width, height) = frames[0].size();
    if u < 2 || v < 2 || u + 2 >= width || v + 2 >= height {
        return Vec::new();
    }
    let n = frames.len() as f32;
    let mean = |x: usize, y: usize| frames.iter().map(|frame| frame.at(x, y)).sum::<f32>() / n;
    let is_beyond = |x: usize, y: usize| x.abs_diff(u) == 2 || y.abs_diff(v) == 2;
    let places = (v - 2..=v + 2).flat_map(|y| (u - 2..=u + 2).map(move |x| (x, y)));
    let (beyond, near): (Vec<_>, Vec<_>) = places.partition(|&(x, y)| is_beyond(x, y));
    let beyond = median(&mut beyond.into_iter().map(|(x, y)| mean(x, y)).collect::<Vec<f32>>());
    let hot = mean(u, v) - beyond;
    let least = (SMEARED[0] * hot.abs()).max(SMEARED[1] * (variance / n).sqrt());
    near.into_iter().filter(|&(x, y)| (x, y) != (u, v) && (mean(x, y) - beyond) * hot.signum() > least).collect()
}

/// Replaces each of `pixels` by the median of those around it that are not among them, or were replaced before.
pub fn mask(plane: &mut Plane, pixels: &[(usize, usize)]) {
    let mut left: BTreeSet<(usize, usize)> = pixels.iter().copied().collect();
    for &(u, v) in pixels {
        let around = neighbours(u, v, plane.size()).into_iter().filter(|at| !left.contains(at));
        let mut around: Vec<f32> = around.map(|(x, y)| plane.at(x, y)).collect();
        if !around.is_empty() {
            plane.row_mut(v)[u] = median(&mut around);
            left.remove(&(u, v));
        }
    }
}

/// Median, for an even number the mean of both in the middle.
fn median(values: &mut [f32]) -> f32 {
    values.sort_by(f32::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

/// The eight pixels around one; beyond the border of an image of `size` they are mirrored.
fn neighbours(u: usize, v: usize, (width, height): (usize, usize)) -> [(usize, usize); 8] {
    let inside = |x: usize, by: isize, n: usize| match x.checked_add_signed(by) {
        None => 1,
        Some(x) if x >= n => n - 2,
        Some(x) => x,
    };
    let at = |(du, dv): (isize, isize)| (inside(u, du, width), inside(v, dv, height));
    [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)].map(at)
}

/// Distance of a flickering pixel from its neighbours in the frames that show it, standard deviations.
const FLICKERS: f32 = 4.0;
/// Variance of the neighbours from frame to frame, relative to the noise's, up to which nothing crosses them.
const QUIET: f32 = 2.0;

/// Signed distance of a value from the range of `around`; 0 inside it.
fn beyond(value: f32, around: &[f32; 8]) -> f32 {
    let (min, max) = around.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
    (value - max).max(0.0) + (value - min).min(0.0)
}

/// Whether the pixel exceeds all its neighbours but the `known` ones, in the mean and in nearly all or some frames.
fn is_hot(frames: &[&Plane], variance: f32, (u, v): (usize, usize), known: &[(usize, usize)]) -> bool {
    let places = neighbours(u, v, frames[0].size());
    let masked = places.map(|at| known.contains(&at));
    let around_in = |frame: &Plane| {
        let mut around = places.map(|(x, y)| frame.at(x, y));
        if masked.contains(&true) {
            let instead = median(&mut around.clone());
            around.iter_mut().zip(masked).filter(|(_, masked)| *masked).for_each(|(x, _)| *x = instead);
        }
        around
    };
    // The local noise, which may be larger: the change of the pixels around. Objects that cross make it larger too.
    let n = frames.len() as f32;
    let (mut sums, mut squares) = ([0.0f32; 8], [0.0f32; 8]);
    let (mut value, mut mean, mut own, mut above) = (0.0, 0.0, 0.0, 0usize);
    let mut shown = Vec::with_capacity(frames.len());
    for frame in frames {
        let around = around_in(frame);
        let here = frame.at(u, v) - around.iter().sum::<f32>() / 8.0;
        (value, mean, own) = (value + frame.at(u, v) / n, mean + here / n, own + here * here);
        above += usize::from(here > 0.0);
        shown.push(here);
        for ((sum, square), x) in sums.iter_mut().zip(&mut squares).zip(around) {
            (*sum, *square) = (*sum + x, *square + x * x);
        }
    }
    let off = beyond(value, &sums.map(|sum| sum / n));
    if off.abs() < HOT * (variance / n).sqrt() {
        return false;
    }
    let around = squares.iter().zip(sums).map(|(square, sum)| square - sum * sum / n).sum::<f32>() / (8.0 * (n - 1.0));
    let own = (own - n * mean * mean) / (n - 1.0);
    let in_nearly_all = above.min(frames.len() - above) * 10 <= frames.len();
    let error = (around.max(variance) / n).sqrt();
    if off.abs() <= HOT * error || mean.abs() <= HOT * error {
        return false;
    }
    // A pixel that flickers is far off in some frames; an object that crosses shows in the neighbours as well.
    let far = FLICKERS * around.max(variance).sqrt();
    let flickers = || {
        around <= QUIET * variance && shown.iter().filter(|x| x.signum() == mean.signum() && x.abs() > far).count() >= 2
    };
    (in_nearly_all && mean.abs() > HOT * 0.5 * (own.max(0.0) / n).sqrt()) || flickers()
}

/// Variance of a square, relative to the noise's, above which a contrast shows a strike, and below which none.
const STRUCK: [f32; 2] = [4.0, 2.0];
const MIN_STRUCK: usize = 3;
/// Distance in deviations from all pixels around in the frames before and after: of a struck pixel, of one beside it.
const STRIKES: [f32; 2] = [5.0, 2.5];
const MAX_STRUCK: f32 = 0.005;
/// Least height of a strike above all that is near, relative to the range of that.
const OUTSHINES: f32 = 0.5;

/// Whether some squares have far more than `noise` in one contrast only; moving structures are in all contrasts.
pub fn are_struck(squares: &HighPass, contrasts: &[Contrast], noise: f32) -> bool {
    let all: Vec<Vec<f32>> = contrasts.iter().map(|contrast| squares.variances(contrast)).collect();
    let is_struck = |square: &usize| {
        let above = |times: f32| all.iter().filter(|of| of[*square] > times * noise).count();
        above(STRUCK[0]) == 1 && above(STRUCK[1]) == 1
    };
    noise > 0.0 && contrasts.len() > 1 && (0..squares.places.len()).filter(is_struck).count() >= MIN_STRUCK
}

/// Masks the pixels of each frame that are several times the noise of `variance` brighter than all within `reach` of
/// them in the frames before and after; returns their number. Structures that move by up to `reach` px/frame stay.
pub fn mask_struck(frames: &mut [Arc<Plane>], variance: f32, reach: usize) -> usize {
    if frames.len() < 3 {
        return 0;
    }
    let deviation = variance.sqrt();
    let (width, height) = frames[0].size();
    let struck_in = |t: usize| -> Vec<(usize, usize)> {
        // The first and the last frame have two neighbours on one side.
        let others = match t {
            0 => [1, 2],
            t if t + 1 == frames.len() => [t - 1, t - 2],
            t => [t - 1, t + 1],
        };
        let [own, before, after] = [t, others[0], others[1]].map(|t| &frames[t]);
        let stands_out = |u: usize, v: usize, deviation: f32| {
            let limit = own.at(u, v) - (STRIKES[0] - 1.0) * deviation;
            let columns = u.saturating_sub(reach)..(u + reach + 1).min(width);
            let rows = v.saturating_sub(reach)..(v + reach + 1).min(height);
            let near = rows.flat_map(|y| [before, after].map(|frame| &frame.row(y)[columns.clone()])).flatten();
            // The peak of a star depends on where it lies between pixels: it outshines nothing by much.
            near.clone().all(|x| *x < limit) && {
                let (min, max) = near.fold((f32::MAX, f32::MIN), |(min, max), x| (min.min(*x), max.max(*x)));
                own.at(u, v) - max > OUTSHINES * (max - min)
            }
        };
        let candidates = |v: usize| {
            // Compared in place first: the search within `reach` is costly and rarely needed.
            let rows = [own, before, after].map(|frame| frame.row(v));
            let limit = STRIKES[0] * deviation;
            let parts = (0..width).step_by(TOGETHER).map(move |u| u..(u + TOGETHER).min(width));
            let parts = parts.filter(move |part| any_brighter(rows.map(|row| &row[part.clone()]), limit));
            let is_brighter = move |u: &usize| rows[0][*u] > rows[1][*u].max(rows[2][*u]) + limit;
            parts.flatten().filter(is_brighter).map(move |u| (u, v))
        };
        let (mut struck, mut count): (Vec<(usize, usize)>, usize) = (Vec::new(), 0);
        for (u, v) in (0..height).flat_map(candidates).filter(|&(u, v)| stands_out(u, v, deviation)) {
            count += 1;
            // Strikes are rare: so many candidates are something else, and the frame stays as it is.
            if count as f32 > MAX_STRUCK * (width * height) as f32 {
                return Vec::new();
            }
            if stands_out(u, v, deviation_around(before, after, (u, v))) {
                struck.push((u, v));
            }
        }
        // Grow each struck pixel into fainter neighbours: a hit spreads over several pixels.
        let mut known: BTreeSet<(usize, usize)> = struck.iter().copied().collect();
        while let Some((u, v)) = struck.pop() {
            for beside in neighbours(u, v, (width, height)) {
                let limit = before.at(beside.0, beside.1).max(after.at(beside.0, beside.1)) + STRIKES[1] * deviation;
                if own.at(beside.0, beside.1) > limit && known.insert(beside) {
                    struck.push(beside);
                }
            }
        }
        known.into_iter().collect()
    };
    let struck: Vec<Vec<(usize, usize)>> = (0..frames.len()).into_par_iter().map(struck_in).collect();
    for (frame, struck) in frames.iter_mut().zip(&struck).filter(|(_, struck)| !struck.is_empty()) {
        mask(Arc::make_mut(frame), struck);
    }
    struck.iter().map(Vec::len).sum()
}

/// Standard deviation of one frame around a pixel, from the median difference of two: noise may differ by place.
fn deviation_around(a: &Plane, b: &Plane, (u, v): (usize, usize)) -> f32 {
    let around = |at: usize, n: usize| at.saturating_sub(AROUND)..(at + AROUND + 1).min(n);
    let columns = around(u, a.width());
    let of_row =
        |y: usize| a.row(y)[columns.clone()].iter().zip(&b.row(y)[columns.clone()]).map(|(a, b)| (a - b).abs());
    let mut values: Vec<f32> = around(v, a.height()).flat_map(of_row).filter(|x| !x.is_nan()).collect();
    let median = if values.is_empty() { 0.0 } else { median(&mut values) };
    median / (0.6745 * 2f32.sqrt())
}

/// Distance of the pixels around a strike that show the noise there.
const AROUND: usize = 5;

/// Number of pixels that [`any_brighter`] compares at once.
const TOGETHER: usize = 128;

/// Whether any pixel of the first row may be brighter than those of both others by more than `limit`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn any_brighter([own, before, after]: [&[f32]; 3], limit: f32) -> bool {
    // All lanes take part: an early end would be decided pixel by pixel. What is NaN in one frame is no limit.
    let mut any = 0u32;
    for ((x, a), b) in own.iter().zip(before).zip(after) {
        any |= u32::from((*x > a + limit || a.is_nan()) & (*x > b + limit || b.is_nan()));
    }
    any != 0
}

/// Offsets of columns or rows, as far as they change within 16 of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stripes {
    /// Offset of each column or row in its middle, fraction of full scale.
    pub offsets: Vec<f32>,
    /// Growth of each offset from the first end of the line to the last; empty where there is none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub growths: Vec<f32>,
    /// Standard deviation of the offsets, at the ends of the lines, as far as both halves of the burst share them.
    pub deviation: f32,
}

const STRIPES: f32 = 6.0;
/// Least part of the lines' power that different bands share: a half for lines that grow from 0 along themselves.
const OF_BANDS: f32 = 0.4;
/// Least ratio of what the halves share to the square of their difference where few lines decide.
const ALIKE: f32 = 2.0;
/// Correlation with the next two lines up to which lines are sharp.
const SHARP: [f32; 2] = [0.55, 0.4];

impl Stripes {
    /// Stripes that both halves of a burst share; `None` if there are none, or they are smooth as a scene is.
    pub(super) fn find(halves: &[Lines; 2]) -> Option<Self> {
        let sharp = halves.each_ref().map(|bands| bands.iter().map(|band| less_local_mean(band)).collect::<Lines>());
        let (offsets, common) = shared(sharp.each_ref().map(|bands| median_of_bands(bands.iter().cloned())))?;
        // Pixels that differ each by itself give every band of a line another offset.
        let (count, [first, second]) = (sharp[0].len(), &sharp);
        let pairs = (0..count).flat_map(|a| (0..count).map(move |b| (a, b))).filter(|(a, b)| a != b);
        let of_others = pairs.map(|(a, b)| dot(&first[a], &second[b])).sum::<f32>() / offsets.len() as f32;
        if of_others < OF_BANDS * common * (count * (count - 1)) as f32 {
            return None;
        }
        let (growths, grown) = shared(halves.each_ref().map(growths)).unwrap_or_default();
        Some(Self { offsets, growths, deviation: (common + 0.25 * grown).sqrt() })
    }

    /// Offset of a line at a part of its length from its middle, −0.5 … 0.5.
    fn at(&self, line: usize, along: f32) -> f32 {
        self.offsets[line] + self.growths.get(line).map_or(0.0, |growth| along * growth)
    }
}

/// Mean of what was measured of the lines in two halves of the burst, and the variance that the halves share.
fn shared([first, second]: [Vec<f32>; 2]) -> Option<(Vec<f32>, f32)> {
    let n = first.len() as f32;
    let product = |shift: usize| dot(&first, &second[shift..]) / n;
    let power = |x: &[f32]| dot(x, x) / n;
    let common = product(0);
    let error = (power(&first) * power(&second) / n).sqrt();
    // Few lines with noise of their own agree by chance: then the halves must differ by far less than they share.
    let of_few = first.iter().zip(&second).map(|(a, b)| (a * b).powi(2)).sum::<f32>().sqrt() / n;
    let between = first.iter().zip(&second).map(|(a, b)| (a - b).powi(2)).sum::<f32>() / n;
    let is_sure = common > STRIPES * error && (common > STRIPES * of_few || common > ALIKE * between);
    // A scene is correlated from line to line, offsets of a sensor hardly; interpolated colours share up to a half.
    let are_sharp = is_sure && (1..3).zip(SHARP).all(|(by, most)| product(by) <= most * common);
    are_sharp.then(|| (first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b)).collect(), common))
}

/// Growth of each line's offset from end to end, the straight line through its bands.
fn growths(bands: &Lines) -> Vec<f32> {
    let (count, mut sums) = (bands.len() as f32, vec![0.0; bands[0].len()]);
    for (band, values) in bands.iter().enumerate() {
        let weight = 12.0 * (band as f32 - 0.5 * (count - 1.0)) / (count * count - 1.0);
        sums.iter_mut().zip(less_local_mean(values)).for_each(|(sum, x)| *sum += weight * x);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Burst;
    use crate::monitor::Monitor;
    use crate::synth::random::Stream;
    use crate::synth::{NoiseCase, SceneParams, synth_scene};

    fn planes(burst: &Burst) -> Vec<Plane> {
        burst.frames.iter().map(|f| (**f).clone()).collect()
    }

    fn find(frames: &[Plane], sigma: f32) -> FixedPattern {
        let frames: Vec<&Plane> = frames.iter().collect();
        let stands_out = FixedPattern::stands_out(frames.len(), frames[0].size(), sigma * sigma);
        let reading = Reading::new(&frames, 3, stands_out, &Monitor::default()).expect("not cancelled");
        FixedPattern::find(&frames, &reading, sigma * sigma)
    }

    fn case(case: NoiseCase) -> Vec<Plane> {
        planes(&case.burst((320, 240), 10, 0.02, 5, &Monitor::default()).expect("not cancelled"))
    }

    fn scene(max_slope: f64) -> Vec<Plane> {
        let scene = SceneParams { width: 320, height: 240, layers: 1, max_slope, ..SceneParams::default() };
        planes(&synth_scene(&scene, &Monitor::default()).expect("a scene").0)
    }

    #[test]
    fn pixels_that_flicker_are_found_and_objects_that_cross_are_not() {
        let frames = case(NoiseCase::FlickeringPixels);
        let found = find(&frames, 0.02).hot_pixels.len();
        // Of 76 pixels some are weak, or bright in too few frames.
        assert!((55..=76).contains(&found), "{found}");
        // Stars, a pixel wide, that move by a third of a pixel and by a pixel a frame.
        let star = |t: usize, u: usize, v: usize, speed: f32| {
            let (x, y) = (u as f32 - 30.0 - speed * t as f32, v as f32 - 40.0);
            0.4 * (-2.0 * (x * x + y * y)).exp()
        };
        for speed in [0.3, 1.0] {
            let sky: Vec<Plane> = (0..10)
                .map(|t| {
                    let mut noise = Stream::new(6, t as u64);
                    Plane::from_fn(80, 80, |u, v| 0.3 + star(t, u, v, speed) + 0.02 * noise.normal() as f32)
                })
                .collect();
            assert_eq!(find(&sky, 0.02).hot_pixels, [], "{speed}");
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
        // One scene with new noise in each frame: the pattern may be a part of the scene.
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

    #[test]
    fn neighbours_of_each_other_are_both_found() {
        let frame = |t: u64| {
            let mut stream = Stream::new(5, t);
            let mut frame = Plane::from_fn(60, 50, |_, _| 0.5 + 0.01 * stream.normal() as f32);
            [(20, 20, 0.4), (21, 20, 0.2), (0, 0, 0.3), (59, 30, -0.3)]
                .iter()
                .for_each(|&(u, v, by)| frame.row_mut(v)[u] += by);
            frame
        };
        let frames = [0, 1, 2, 3, 4, 5].map(frame);
        let frames: Vec<&Plane> = frames.iter().collect();
        assert_eq!(
            super::find(&[(20, 20), (30, 30), (0, 0), (59, 30)], &frames, 1e-4),
            [(0, 0), (20, 20), (21, 20), (59, 30)]
        );
        let mut clean = frames[0].clone();
        mask(&mut clean, &[(20, 20), (21, 20)]);
        assert!((clean.at(20, 20) - 0.5).abs() < 0.05 && clean.at(59, 30) < 0.3);
    }
}
