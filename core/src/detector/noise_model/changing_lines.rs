//! Columns or rows whose offsets change from frame to frame: drifting stripes, columns with noise of their own, bands.
//!
//! Unlike a scene, a line has the same offset from one end of the image to the other. Offsets are measured in eight
//! bands across the lines: the power that even and odd bands share is compared with the variance between bands. Sharp
//! lines have little in common with the next one, since no lens makes structure so sharp; wide ones are weak and agree
//! closely in all bands. Without this `drifting-stripes-0.3` has 13 590 false features a megapixel, not 6.

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
    /// Whether neighbouring lines differ, which decides how the offsets are measured and taken off.
    pub extent: Extent,
    /// Whether the smooth part of sharp offsets is shared by all bands as well, so that it is taken off too.
    #[serde(skip)]
    is_whole: bool,
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
/// Correlation with the next two lines up to which lines are sharp: interpolation shares up to a half with the next.
const SHARP: [f32; 2] = [0.6, 0.4];
/// Minimum ratio of the power that the bands share to the variance between them, for sharp and for wide lines.
const SHARED: [f32; 2] = [0.25, 4.0];
/// Maximum amplitude of wide lines, relative to the brightness.
const MAX_WIDE: f32 = 0.05;
/// Inverse of the share of white offsets' power that two linear interpolations may leave.
const INTERPOLATED: f32 = 2.0;
const MAX_TRIED: f32 = 200.0;
/// Number of lines to each side over which wide offsets are smoothed.
const SMOOTHED: usize = 4;

impl ChangingLines {
    /// Finds the offsets, given the mean `brightness` and the `slopes` of the search across the lines, lines per frame.
    pub(super) fn find(frames: &[Lines], brightness: f32, slopes: &[f32]) -> Option<Self> {
        [Extent::Sharp, Extent::Wide].into_iter().find_map(|extent| {
            // Even and odd bands see the same offsets and different noise: their product has no bias by noise.
            let found: Vec<Shared> = frames.iter().map(|frame| Shared::of(&less_surroundings(frame, extent))).collect();
            let n = found.iter().map(|frame| frame.even.len()).sum::<usize>() as f32;
            let sum = |of: &dyn Fn(&Shared) -> f32| found.iter().map(of).sum::<f32>() / n;
            let common = sum(&|frame| dot(&frame.even, &frame.odd));
            let error =
                (sum(&|frame| dot(&frame.even, &frame.even)) * sum(&|frame| dot(&frame.odd, &frame.odd)) / n).sqrt();
            let between = sum(&|frame| frame.between);
            let is_common = common > SURE * error;
            let tells = match extent {
                // A scene is smooth: sharp offsets must fall off within a line or two. Wide ones must be weak instead.
                Extent::Sharp => {
                    let next = |by: usize| sum(&|frame| dot(&frame.even, &frame.odd[by.min(frame.odd.len())..]));
                    common > SHARED[0] * between && next(1) <= SHARP[0] * common && next(2) <= SHARP[1] * common
                }
                Extent::Wide => common > SHARED[1] * between && common.sqrt() <= MAX_WIDE * brightness.abs(),
            };
            (is_common && tells).then(|| {
                let offsets: Vec<Vec<f32>> = frames.iter().map(|frame| offsets(frame, extent)).collect();
                let next = sum(&|frame| dot(&frame.even, &frame.odd[1..])).max(0.0);
                let coarse = 1.0 + 2.0 * next / common;
                let is_whole = extent == Extent::Sharp && shares_smooth_part(frames, brightness);
                Self { deviation: common.sqrt(), lasting: lasting(&offsets, slopes), coarse, extent, is_whole }
            })
        })
    }

    pub(super) fn remove_from(&self, frame: &mut Plane, axis: usize) {
        let lines = &lines_of(frame)[axis];
        let offsets = match self.is_whole {
            // With a straight line taken off alone, the smooth part of the offsets goes too.
            true => median(less_surroundings(lines, Extent::Wide).iter()),
            false => offsets(lines, self.extent),
        };
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
        if self.is_whole { 0.0 } else { self.deviation.powi(2) * self.coarse * (INTERPOLATED * self.lasting).min(1.0) }
    }
}

struct Shared {
    even: Vec<f32>,
    odd: Vec<f32>,
    /// Variance between the bands, summed over the lines.
    between: f32,
}

impl Shared {
    fn of(bands: &Lines) -> Self {
        let half = |first: usize| median(bands.iter().skip(first).step_by(2));
        let count = bands.len() as f32;
        let between = (0..bands[0].len())
            .map(|i| {
                let (sum, squares) = bands.iter().fold((0.0, 0.0), |(a, b), band| (a + band[i], b + band[i] * band[i]));
                (squares - sum * sum / count) / (count - 1.0)
            })
            .sum();
        Self { even: half(0), odd: half(1), between }
    }
}

/// Whether all bands also share the smooth part of sharp offsets, and the part is small enough to be no scene.
fn shares_smooth_part(frames: &[Lines], brightness: f32) -> bool {
    let smooth = |frame: &Lines| {
        let mut smooth = less_surroundings(frame, Extent::Wide);
        let sharp = less_surroundings(frame, Extent::Sharp);
        smooth.iter_mut().flatten().zip(sharp.iter().flatten()).for_each(|(whole, sharp)| *whole -= sharp);
        Shared::of(&smooth)
    };
    let found: Vec<Shared> = frames.iter().map(smooth).collect();
    let sum = |of: fn(&Shared) -> f32| found.iter().map(of).sum::<f32>();
    let common = sum(|frame| dot(&frame.even, &frame.odd));
    let lines = found.iter().map(|frame| frame.even.len()).sum::<usize>() as f32;
    common > SHARED[0] * sum(|frame| frame.between) && (common / lines).sqrt() <= MAX_WIDE * brightness.abs()
}

pub(super) fn offsets(frame: &Lines, extent: Extent) -> Vec<f32> {
    let offsets = median(less_surroundings(frame, extent).iter());
    match extent {
        Extent::Sharp => offsets,
        Extent::Wide => (0..offsets.len())
            .map(|i| {
                let around = &offsets[i.saturating_sub(SMOOTHED)..(i + SMOOTHED + 1).min(offsets.len())];
                around.iter().sum::<f32>() / around.len() as f32
            })
            .collect(),
    }
}

/// Values of each band less the mean of those around, or, for wide offsets, less their straight line.
fn less_surroundings(frame: &Lines, extent: Extent) -> Lines {
    let less = |values: &Vec<f32>| match extent {
        Extent::Sharp => less_local_mean(values),
        Extent::Wide => less_line(values),
    };
    frame.iter().map(less).collect()
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

fn median<'a>(bands: impl Iterator<Item = &'a Vec<f32>>) -> Vec<f32> {
    let bands: Vec<&Vec<f32>> = bands.collect();
    let mut values = vec![0.0; bands.len()];
    (0..bands[0].len())
        .map(|i| {
            values.iter_mut().zip(&bands).for_each(|(value, band)| *value = band[i]);
            values.sort_by(f32::total_cmp);
            0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
        })
        .collect()
}

fn dot(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
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
