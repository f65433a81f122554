//! Columns or rows whose offsets change from frame to frame: drifting stripes, columns with noise of their own, bands.
//!
//! Unlike a scene, a line has the same offset from one end of the image to the other. Offsets are measured in eight
//! bands across the lines: the power that even and odd bands share is compared with the variance between bands. Sharp
//! lines have little in common with the next one, since no lens makes structure so sharp; wide ones are weak, and bands
//! differ by little more than noise. Without this `drifting-stripes-0.3` has 13 590 false features a megapixel, not 6.

use super::reading::{Lines, less_local_mean, lines_of};
use crate::plane::Plane;
use serde::Serialize;

/// Offsets of columns or rows that change from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChangingLines {
    /// Standard deviation of the offsets, fraction of full scale.
    pub deviation: f32,
    /// Share of their power that remains in the mean of the frames, at the slope at which most remains.
    pub lasting: f32,
    /// Variance of coarse means relative to that of independent lines: above 1 where lines share offsets with the next.
    #[serde(skip)]
    coarse: f32,
    /// Whether the offsets stay the same from the first frame to the last.
    pub stay: bool,
    /// Whether neighbouring lines differ, which decides how the offsets are measured and taken off.
    pub extent: Extent,
    /// Whether all bands share the smooth part of the offsets, and the sharp one, so that it is taken off.
    #[serde(skip)]
    parts: [bool; 2],
}

/// Extent of a pattern of lines: over how many lines an offset reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Extent {
    /// Neighbouring lines differ: columns with noise of their own, drifting stripes.
    Sharp,
    /// Neighbouring lines hardly differ: bands, as lamps that flicker make them.
    Wide,
}

/// Number of standard errors above which the power shared by bands is significant.
const SURE: f32 = 6.0;
/// Correlation with the next two lines up to which lines are sharp. Interpolation shares up to a half with the next, a
/// camera that smooths over three pixels two thirds; a scene shares more with the one after.
const SHARP: [f32; 2] = [0.75, 0.4];
/// Minimum ratio of the power that bands share to the variance between them; for wide lines to what is no noise of it.
const SHARED: [f32; 2] = [0.25, 4.0];
/// Error of the noise that is expected between bands, relative to it.
const NOISE_ERROR: f32 = 0.025;
/// Maximum amplitude of wide lines, relative to the brightness: rows of lamps and windows are stronger.
const MAX_WIDE: f32 = 0.05;
/// Inverse of the share of white offsets' power that two linear interpolations may leave.
const INTERPOLATED: f32 = 2.0;
const MAX_TRIED: f32 = 200.0;
/// Minimum product of offsets of two frames, relative to that at any other lag, and to that of a frame with itself.
const STAYING: [f32; 2] = [0.7, 0.15];
/// Share of the brightness below which offsets are errors of rounding.
const ROUNDING: f32 = 1e-5;
/// Number of frames whose lines are compared along themselves.
const FRAMES_ALONG: usize = 3;
/// Growth of the variance of lines with their squared offset above which things stand in a row, with standard errors.
const THINGS: f32 = 0.45;
const SURE_OF_THINGS: f32 = 3.0;
/// Number of lines to each side in the mean that parts smooth and sharp offsets of wide lines.
const SMOOTHED: usize = 4;
/// Share of the noise of a band's mean in its smooth and in its sharp part.
const SHARE_OF_NOISE: [f32; 2] = [1.0 / 9.0, 8.0 / 9.0];

impl ChangingLines {
    /// Finds the offsets, given the mean `brightness` and the `slopes` of the search across the lines, lines per frame.
    pub(super) fn find(frames: &[Lines], brightness: f32, slopes: &[f32]) -> Option<Self> {
        let noise = noise_of(frames);
        [Extent::Sharp, Extent::Wide].into_iter().find_map(|extent| {
            let of_frames: Vec<[Lines; 2]> = frames.iter().map(|frame| parts(frame, extent)).collect();
            let shared = [0, 1].map(|part| Shared::of(of_frames.iter().map(|parts| &parts[part])));
            let is_weak = |i: usize| shared[i].common.sqrt() <= MAX_WIDE * brightness.abs();
            let tells = |i: usize| {
                let Shared { common, error, between, next } = shared[i];
                let is_told_apart = match (extent, i) {
                    // A scene is smooth: sharp offsets must fall off within a line or two.
                    (Extent::Sharp, 1) => {
                        common > SHARED[0] * between && (0..2).all(|by| next[by] <= SHARP[by] * common)
                    }
                    (Extent::Sharp, _) => false,
                    // Wide ones must be weak instead, and bands may differ by noise alone.
                    (Extent::Wide, _) => {
                        let noise = noise * SHARE_OF_NOISE[i];
                        common > SHARED[1] * (between - noise).max(NOISE_ERROR * noise) && is_weak(i)
                    }
                };
                common > (SURE * error).max((ROUNDING * brightness).powi(2)) && is_told_apart
            };
            let told = [0, 1].map(tells);
            told.contains(&true).then(|| {
                // The other part goes too where the bands share it.
                let goes = |i: usize| shared[i].common > SHARED[0] * shared[i].between && is_weak(i);
                let parts = [0, 1].map(|i| told[i] || goes(i));
                let common = (0..2).filter(|i| parts[*i]).map(|i| shared[i].common).sum::<f32>();
                let coarse = 1.0 + 2.0 * shared[1].next[0].max(0.0) / shared[1].common;
                let mut lines = Self { deviation: common.sqrt(), lasting: 1.0, coarse, stay: false, extent, parts };
                let offsets: Vec<Vec<f32>> = frames.iter().map(|frame| lines.offsets(frame)).collect();
                (lines.lasting, lines.stay) = (lasting(&offsets, slopes), stay(&offsets));
                lines
            })
        })
    }

    /// Offsets of the lines of a frame, of the parts that are taken off.
    fn offsets(&self, frame: &Lines) -> Vec<f32> {
        if self.parts == [true; 2] {
            return median(frame.iter().map(|band| less_line(band)));
        }
        let [smooth, sharp] = parts(frame, self.extent);
        median(if self.parts[0] { smooth } else { sharp }.into_iter())
    }

    /// Whether lines with offsets vary more along themselves than the others, as rows of lamps do. Noise, which may
    /// differ by place, is what neighbours along a line do not share.
    pub(super) fn are_rows_of_things(&self, frames: &[&Plane], axis: usize) -> bool {
        // By line: the square of its offset, and the variance of its pixels.
        let mut lines: Vec<(f32, f32)> = Vec::new();
        for frame in frames.iter().step_by(frames.len().div_ceil(FRAMES_ALONG)) {
            let offsets = self.offsets(&lines_of(frame)[axis]);
            let mut sums = vec![[0.0f32; 3]; offsets.len()];
            for v in 0..frame.height() {
                let row = frame.row(v);
                for (u, x) in row.iter().enumerate() {
                    let before = if axis == 0 { frame.row(v.saturating_sub(1))[u] } else { row[u.saturating_sub(1)] };
                    let [sum, squares, steps] = &mut sums[[u, v][axis]];
                    (*sum, *squares, *steps) = (*sum + x, *squares + x * x, *steps + (x - before).powi(2));
                }
            }
            let length = [frame.height(), frame.width()][axis] as f32;
            let variance = |[sum, squares, steps]: [f32; 3]| {
                squares / length - (sum / length).powi(2) - 0.5 * steps / (length - 1.0)
            };
            lines.extend(offsets.iter().zip(sums).map(|(offset, sums)| (offset * offset, variance(sums))));
        }
        let n = lines.len() as f32;
        let mean = |of: fn(&(f32, f32)) -> f32| lines.iter().map(of).sum::<f32>() / n;
        let (square, variance) = (mean(|line| line.0), mean(|line| line.1));
        let along = lines.iter().map(|line| (line.0 - square) * (line.1 - variance)).sum::<f32>();
        let (spread, rest) = lines.iter().fold((0.0, 0.0), |(spread, rest), line| {
            (spread + (line.0 - square).powi(2), rest + (line.1 - variance).powi(2))
        });
        // Things that fill a part f of a line add (1 − f)/f of its squared offset; one that grows from 0 adds a third.
        let error = (rest / n / spread).sqrt();
        along / spread > THINGS + SURE_OF_THINGS * error
    }

    pub(super) fn remove_from(&self, frame: &mut Plane, axis: usize) {
        let offsets = self.offsets(&lines_of(frame)[axis]);
        for v in 0..frame.height() {
            let row = frame.row_mut(v);
            if axis == 0 {
                row.iter_mut().zip(&offsets).for_each(|(x, offset)| *x -= offset);
            } else {
                row.iter_mut().for_each(|x| *x -= offsets[v]);
            }
        }
    }

    /// Variance, in the frames' mean, of independent lines with the offsets' coarse means, which interpolation keeps.
    pub(super) fn variance_in_mean(&self) -> f32 {
        if self.parts[0] { 0.0 } else { self.deviation.powi(2) * self.coarse * (INTERPOLATED * self.lasting).min(1.0) }
    }
}

/// Powers of offsets, means over the lines of all frames.
struct Shared {
    /// Product of even and odd bands, which see the same offsets and different noise, so that noise adds no bias.
    common: f32,
    /// Standard error of `common` where nothing is shared.
    error: f32,
    between: f32,
    /// Product with the next line and with the one after it.
    next: [f32; 2],
}

impl Shared {
    fn of<'a>(frames: impl Iterator<Item = &'a Lines>) -> Self {
        let (mut products, mut between, mut lines) = ([0.0; 5], 0.0, 0.0);
        for bands in frames {
            let [even, odd] = [0, 1].map(|first| median(bands.iter().skip(first).step_by(2).cloned()));
            let next = |by: usize| dot(&even, &odd[by.min(odd.len())..]);
            let of_frame = [next(0), next(1), next(2), dot(&even, &even), dot(&odd, &odd)];
            products.iter_mut().zip(of_frame).for_each(|(sum, x)| *sum += x);
            let count = bands.len() as f32;
            for i in 0..bands[0].len() {
                let (sum, squares) = bands.iter().fold((0.0, 0.0), |(a, b), band| (a + band[i], b + band[i] * band[i]));
                between += (squares - sum * sum / count) / (count - 1.0);
            }
            lines += even.len() as f32;
        }
        let [common, next, after, even, odd] = products.map(|sum| sum / lines);
        Self { common, error: (even * odd / lines).sqrt(), between: between / lines, next: [next, after] }
    }
}

/// Variance of a band's mean by noise: white along the lines, as what the bands show of a scene is not.
fn noise_of(frames: &[Lines]) -> f32 {
    let second = |x: &[f32]| x.windows(3).map(|x| (x[0] - 2.0 * x[1] + x[2]).powi(2)).sum::<f32>();
    let of_frame = |bands: &Lines| {
        let count = bands.len() as f32;
        let mean: Vec<f32> =
            (0..bands[0].len()).map(|i| bands.iter().map(|band| band[i]).sum::<f32>() / count).collect();
        let less_mean = |band: &Vec<f32>| band.iter().zip(&mean).map(|(x, mean)| x - mean).collect::<Vec<f32>>();
        bands.iter().map(|band| second(&less_mean(band))).sum::<f32>() / (6.0 * (count - 1.0) * mean.len() as f32)
    };
    frames.iter().map(of_frame).sum::<f32>() / frames.len() as f32
}

/// Smooth and sharp part of the values of each band, less their straight line.
fn parts(frame: &Lines, extent: Extent) -> [Lines; 2] {
    let straight: Lines = frame.iter().map(|band| less_line(band)).collect();
    let sharp_part = if extent == Extent::Sharp { less_local_mean } else { less_even_mean };
    let sharp: Lines = straight.iter().map(|band| sharp_part(band)).collect();
    let less = |(whole, sharp): (&Vec<f32>, &Vec<f32>)| whole.iter().zip(sharp).map(|(x, s)| x - s).collect();
    [straight.iter().zip(&sharp).map(less).collect(), sharp]
}

/// Values less the mean of as many to both sides, so that bands are not bent at the ends.
fn less_even_mean(values: &[f32]) -> Vec<f32> {
    let less_mean = |i: usize| {
        let reach = SMOOTHED.min(i).min(values.len() - 1 - i);
        values[i] - values[i - reach..=i + reach].iter().sum::<f32>() / (2 * reach + 1) as f32
    };
    (0..values.len()).map(less_mean).collect()
}

fn less_line(values: &[f32]) -> Vec<f32> {
    let n = values.len() as f32;
    let (middle, mean) = (0.5 * (n - 1.0), values.iter().sum::<f32>() / n);
    let (mut along, mut spread) = (0.0, 0.0);
    for (i, x) in values.iter().enumerate() {
        let t = i as f32 - middle;
        (along, spread) = (along + t * (x - mean), spread + t * t);
    }
    let slope = along / spread.max(1.0);
    values.iter().enumerate().map(|(i, x)| x - mean - slope * (i as f32 - middle)).collect()
}

pub(super) fn median(bands: impl Iterator<Item = Vec<f32>>) -> Vec<f32> {
    let bands: Lines = bands.collect();
    let mut values = vec![0.0; bands.len()];
    (0..bands[0].len())
        .map(|i| {
            values.iter_mut().zip(&bands).for_each(|(value, band)| *value = band[i]);
            values.sort_by(f32::total_cmp);
            0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
        })
        .collect()
}

pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Whether offsets have as much in common however far apart their frames are.
fn stay(frames: &[Vec<f32>]) -> bool {
    let at_lag = |lag: usize| {
        frames.iter().zip(&frames[lag..]).map(|(a, b)| dot(a, b)).sum::<f32>() / (frames.len() - lag) as f32
    };
    let (min, max) = (1..frames.len()).map(at_lag).fold((f32::INFINITY, 0.0f32), |(a, b), x| (a.min(x), b.max(x)));
    min > STAYING[0] * max && min > STAYING[1] * at_lag(0)
}

/// Largest share of the frames' power that their mean keeps if each is shifted by a slope.
fn lasting(frames: &[Vec<f32>], slopes: &[f32]) -> f32 {
    let (n, lines) = (frames.len() as f32, frames[0].len());
    let power = frames.iter().map(|frame| dot(frame, frame)).sum::<f32>() / n;
    let kept = |slope: f32| {
        let mean = |i: usize| {
            let at = |(t, frame): (usize, &Vec<f32>)| {
                let x = (i as f32 + (t as f32 - 0.5 * (n - 1.0)) * slope).clamp(0.0, lines as f32 - 1.001).max(0.0);
                let part = x.fract();
                (1.0 - part) * frame[x as usize] + part * frame[(x as usize + 1).min(lines - 1)]
            };
            frames.iter().enumerate().map(at).sum::<f32>() / n
        };
        (0..lines).map(|i| mean(i).powi(2)).sum::<f32>() / power.max(f32::MIN_POSITIVE)
    };
    // Slopes between the searched ones count too: coarse octaves, where most remains, hardly separate them.
    let (min, max) = slopes.iter().fold((0.0f32, 0.0f32), |(a, b), s| (a.min(*s), b.max(*s)));
    let count = ((max - min) * n).ceil().min(MAX_TRIED);
    let tried = (0..=count as usize).map(|i| min + (max - min) * i as f32 / count.max(1.0));
    tried.map(kept).fold(1.0 / n, f32::max).min(1.0)
}
