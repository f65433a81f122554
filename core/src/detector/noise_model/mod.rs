//! Noise model of a burst as cameras and files make it, for a noise gate that is right at every place.
//!
//! Real noise is not white noise of one strength: it grows with brightness and differs by place (`variance`), is
//! correlated and has long tails where files were compressed (`spectrum`); frames repeat others, are black or too noisy
//! (`frames`), and a sensor has a pattern of its own (`fixed_pattern`). [`examine()`] measures all of these from the
//! burst alone and returns a [`NoiseModel`], with a [`NoiseWarning`] for each assumption that fails.

mod changing_lines;
mod codec;
mod contrast;
mod examine;
mod fixed_pattern;
mod frames;
mod high_pass;
pub(in crate::detector) mod reading;
mod spectrum;
mod variance;
pub(in crate::detector) mod warning;

pub use changing_lines::{ChangingLines, Extent};
pub use codec::Flattened;
pub use examine::{Examined, ForSearch, examine};
pub use fixed_pattern::{FixedPattern, Stripes};
pub use frames::{FrameFacts, LeftOut};
pub use spectrum::LevelNoise;
pub use variance::{ExcessMap, PhotonTransfer, TransferPoint};
pub use warning::{NoiseWarning, WarningKind};

use crate::detector::noise::dog_noise_variance;
use crate::detector::params::Slope;
use crate::detector::scale_space::{SIGMA_INPUT, Scale, ScaleSpace};
use crate::kernel::stack::FrameOffset;
use crate::plane::Plane;
use codec::InBlock;
use reading::{BoxPyramid, REACH, sample_at};
use serde::Serialize;

/// Noise of a burst: σ_D for a scale and slope by [`sigma_d`](NoiseModel::sigma_d), by place with `place_factor`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct NoiseModel {
    /// Standard deviation of the noise of one frame at its middle brightness, fraction of full scale.
    pub frame_noise: f32,
    /// Whether the noise may differ from white noise of that one standard deviation.
    pub is_local: bool,
    /// Variance of one frame's noise over brightness.
    pub transfer: PhotonTransfer,
    /// Variance relative to that predicted by the brightness, by place; `None` where it is 1 everywhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub excess: Option<ExcessMap>,
    /// Noise by octave, from the first one that is searched, and by level.
    pub levels: Vec<Vec<LevelNoise>>,
    /// Exposure and noise of the used frames, and why some take no part.
    pub frames: Vec<FrameFacts>,
    /// Correlation of the noise of frames that are 1, 2, … frames apart; empty where there is none.
    pub correlations: Vec<f32>,
    /// Share of the variance of one frame's noise that differences of neighbouring frames show.
    #[serde(skip)]
    shown: f32,
    /// Share of the variance of one frame's noise that is the same in all frames, too weak to be seen pixel by pixel.
    #[serde(skip_serializing_if = "is_zero")]
    pub pattern_share: f32,
    /// Flattening of blocks by the codec of the frames' files; `None` where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flattened: Option<Flattened>,
    /// Fixed pattern of the sensor, already removed from the cleaned frames.
    pub pattern: FixedPattern,
    /// Assumptions about the noise that do not hold, with remedies.
    pub warnings: Vec<NoiseWarning>,
    #[serde(skip)]
    brightness: Brightness,
}

/// Brightness of the frames by place, and values derived from it for the search.
#[derive(Debug, Clone, PartialEq, Default)]
struct Brightness {
    /// Of some of the frames, with their indices among the kept frames; empty where the noise is uniform.
    pyramids: Vec<(usize, BoxPyramid)>,
    /// Smallest variance of one frame's noise, for each octave from `first_octave` on.
    min_variance: Vec<f32>,
    cut_off: f32,
    brightest: f32,
    /// Variance of each kept frame relative to that of the contrasts; empty where all have the same noise.
    of_frames: Vec<f32>,
    first_octave: i32,
}

/// Relative growth of the gate where all noise is cut off on one side: the rest is skewed, and a little so is D.
const SKEWED: f32 = 0.12;
/// Relative growth of the gate per unit by which the logarithm of the noise, relative to white noise, rises over an
/// octave: correlated noise falls more slowly with scale, so that more extrema beat the finer level too.
const RISING: f32 = 0.12;
const FRAMES_SAMPLED: usize = 4;
/// Rounding error of D relative to the brightest value: two steps of `f32`.
const ROUNDING: f32 = 2.4e-7;

fn is_zero<T: Default + PartialEq>(x: &T) -> bool {
    *x == T::default()
}

fn mean_or_1<'a>(values: impl IntoIterator<Item = &'a f32>) -> f32 {
    let (sum, count) = values.into_iter().fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
    if count == 0 { 1.0 } else { sum / count as f32 }
}

impl NoiseModel {
    /// White noise of standard deviation `frame_noise` everywhere.
    pub fn white(frame_noise: f32) -> Self {
        Self { frame_noise, ..Self::default() }
    }

    /// σ of D at `octave` and `level` (0 … S−1) for the slope whose frames are read at `offsets`, at the place of least
    /// noise. Noise with long tails counts as the normal noise that exceeds `gate` times it as rarely.
    pub fn sigma_d(&self, space: &ScaleSpace, scale: Scale, frames: (Slope, &[FrameOffset]), gate: f32) -> f32 {
        let (Scale { octave, level }, (slope, offsets)) = (scale, frames);
        // White noise first; each way in which noise is not white is a factor on its variance or its gate.
        let white = dog_noise_variance(space, octave, f64::from(level), offsets);
        if !self.is_local {
            return self.frame_noise * white.sqrt() as f32;
        }
        let levels = self.of_octave(octave);
        let noise = levels.get(level.max(0) as usize).or(levels.last()).unwrap_or(&LevelNoise::WHITE);
        let frame = self.brightness.min_variance[self.octave_index(octave)] * mean_or_1(&self.brightness.of_frames);
        let filter = [0, 1].map(|up| (space.sigma_image(octave, f64::from(level + up)) as f32).powi(2));
        let over_time = self.repeated_over_time(offsets.len(), slope.magnitude(), filter);
        let of_frames = white as f32 * noise.over_white * frame * over_time;
        let [low, high] = filter.map(|variance| f64::from(variance) - SIGMA_INPUT * SIGMA_INPUT);
        let skewed = self.transfer.skewed([low, high], offsets.len(), gate) + SKEWED * self.brightness.cut_off;
        let tails = match self.flattened {
            Some(_) => {
                let in_block = InBlock::of_filter(low, high);
                // At a place that blocks favour in all frames the noise is stronger, not rarer.
                let of_time = 3.0 * (noise.excess_kurtosis + 3.0) / (in_block.kurtosis() + 3.0) - 3.0;
                let shifts = offsets.iter().map(|o| (o.whole_u as f32 + o.part_u, o.whole_v as f32 + o.part_v));
                codec::rare(of_time, offsets.len(), gate) * in_block.largest(shifts).sqrt() - 1.0
            }
            None => noise.excess_kurtosis / offsets.len() as f32 / 24.0 * (gate * gate - 3.0).max(0.0),
        };
        // The gate itself cannot differ by scale, so growth of the gate is put into σ.
        let sigma = (of_frames + self.stripes_left(space, octave, level)).sqrt()
            * (1.0 + tails + skewed + RISING * self.rise(octave));
        // Without noise rounding alone makes extrema of D, which must not pass.
        sigma.max(ROUNDING * self.brightness.brightest)
    }

    /// Ratio (at least 1) of σ of D at pixel (u, v) to its smallest value, from some of the frames that cover it.
    pub fn place_factor(&self, octave: i32, read: &[FrameOffset], (u, v): (usize, usize), size: (usize, usize)) -> f32 {
        let Brightness { pyramids, min_variance, of_frames, .. } = &self.brightness;
        // Beside the border fewer frames cover a place, perhaps the noisier ones.
        let covering = of_frames.iter().zip(read).filter(|(_, offset)| offset.covers(u, v, size)).map(|(x, _)| x);
        let of_covering = mean_or_1(covering) / mean_or_1(of_frames);
        if pyramids.is_empty() {
            return of_covering.sqrt().max(1.0);
        }
        let min = min_variance[self.octave_index(octave)];
        let (mut sum, mut count) = (0.0, 0usize);
        let some = pyramids.iter().map(|(frame, pyramid)| (pyramid, &read[*frame]));
        for (pyramid, offset) in some.filter(|(_, offset)| offset.covers(u, v, size)) {
            let at = (
                (u as i64 + offset.whole_u) as f32 + offset.part_u,
                (v as i64 + offset.whole_v) as f32 + offset.part_v,
            );
            let of_blocks = self.flattened.map_or(1.0, |flattened| flattened.variance_factor_at(octave, at, size));
            sum += self.variance_at(pyramid, Some(octave), at) * of_blocks;
            count += 1;
        }
        // A place outside all sampled frames gets the least noise.
        if count == 0 || min <= 0.0 { 1.0 } else { (of_covering * sum / (count as f32 * min)).sqrt().max(1.0) }
    }

    /// Variance of the frame with `pyramid` around (u, v), at the resolution of `octave`, or for `None` as measured.
    fn variance_at(&self, pyramid: &BoxPyramid, octave: Option<i32>, (u, v): (f32, f32)) -> f32 {
        let level = Self::brightness_level(octave.unwrap_or(1)).min(pyramid.len());
        let brightness = sample_at(pyramid.level(level), (1usize << level) as f32, u, v);
        self.transfer.variance(brightness) * self.excess.as_ref().map_or(1.0, |excess| excess.at(octave, u, v))
    }

    /// σ of the noise of one frame by place, as the finest octave uses it, for an image of `size` in cells of `cell_px`
    /// pixels a side, from the mean variance of the frames that take part.
    pub fn sigma_map(&self, size: (usize, usize), cell_px: f32) -> Plane {
        let cells = |n: usize| ((n as f32 / cell_px).ceil() as usize).max(1);
        let pyramids = &self.brightness.pyramids;
        Plane::from_fn(cells(size.0), cells(size.1), |x, y| {
            let at = ((x as f32 + 0.5) * cell_px, (y as f32 + 0.5) * cell_px);
            if pyramids.is_empty() {
                return self.frame_noise;
            }
            let first = Some(self.brightness.first_octave);
            let sum: f32 = pyramids.iter().map(|(_, p)| self.variance_at(p, first, at)).sum();
            (sum / pyramids.len() as f32).sqrt()
        })
    }

    /// Pyramid level at which brightness is read for an octave: squares a few times as large as its σ.
    fn brightness_level(octave: i32) -> usize {
        (octave + 2).max(3) as usize
    }

    fn of_octave(&self, octave: i32) -> &[LevelNoise] {
        self.levels.get(self.octave_index(octave)).map_or(&[], Vec::as_slice)
    }

    /// Rise, over an octave, of the logarithm of the variance relative to white noise, clamped to 0 … 1.
    fn rise(&self, octave: i32) -> f32 {
        match self.of_octave(octave) {
            levels @ [first, .., last] if first.over_white > 0.0 => {
                let whole = levels.len() as f32 / (levels.len() as f32 - 1.0);
                (whole * (last.over_white / first.over_white).ln()).clamp(0.0, 1.0)
            }
            _ => 0.0,
        }
    }

    fn octave_index(&self, octave: i32) -> usize {
        let last = self.brightness.min_variance.len().saturating_sub(1);
        ((octave - self.brightness.first_octave).max(0) as usize).min(last)
    }

    /// Variance that the smooth part of stripes leaves in D: that of white stripes after the mean over REACH columns.
    fn stripes_left(&self, space: &ScaleSpace, octave: i32, level: i32) -> f32 {
        let of = |stripes: &Option<Stripes>| stripes.as_ref().map_or(0.0, |s| s.deviation.powi(2));
        let changing = |lines: &Option<ChangingLines>| match lines {
            Some(lines) if lines.extent == Extent::Sharp => lines.variance_in_mean(),
            _ => 0.0,
        };
        let variance = of(&self.pattern.columns)
            + of(&self.pattern.rows)
            + changing(&self.pattern.changing_columns)
            + changing(&self.pattern.changing_rows);
        if variance == 0.0 {
            return 0.0;
        }
        let [low, high] = [0, 1].map(|up| space.sigma_image(octave, f64::from(level + up)));
        let window = (2 * REACH + 1) as f64;
        // The midpoint rule over frequencies up to Nyquist; the midpoint avoids 0/0 at frequency 0.
        const STEPS: usize = 512;
        let step = std::f64::consts::PI / STEPS as f64;
        let energy: f64 = (0..STEPS)
            .map(|i| {
                let w = (i as f64 + 0.5) * step;
                let dog = (-0.5 * (w * low).powi(2)).exp() - (-0.5 * (w * high).powi(2)).exp();
                let mean = (0.5 * w * window).sin() / (window * (0.5 * w).sin());
                (dog * mean).powi(2)
            })
            .sum::<f64>()
            / STEPS as f64;
        variance * energy as f32
    }

    /// Variance in the mean of `frames` frames relative to that of independent ones whose differences show as much:
    /// noise that stays at `speed` px/frame counts again as far as the filter (variances, pixels²) reaches.
    fn repeated_over_time(&self, frames: usize, speed: f32, filter: [f32; 2]) -> f32 {
        if self.correlations.is_empty() && self.pattern_share == 0.0 {
            return 1.0;
        }
        let [low, high] = filter;
        let gaussian = |variance: f32, shift: f32| (-0.5 * shift * shift / variance).exp() / variance;
        let overlap =
            |shift: f32| gaussian(2.0 * low, shift) - 2.0 * gaussian(low + high, shift) + gaussian(2.0 * high, shift);
        let shared = |(k, correlation): (usize, f32)| {
            let lag = (k + 1) as f32;
            (1.0 - lag / frames as f32).max(0.0) * correlation * (overlap(lag * speed) / overlap(0.0)).max(0.0)
        };
        if self.correlations.is_empty() {
            // A pattern correlates at every lag alike; the measured differences of frames lack it.
            let always = std::iter::repeat_n(self.pattern_share, frames.saturating_sub(1));
            return (1.0 + 2.0 * always.enumerate().map(shared).sum::<f32>()).max(1.0) / (1.0 - self.pattern_share);
        }
        let sum = 1.0 + 2.0 * self.correlations.iter().copied().enumerate().map(shared).sum::<f32>();
        sum.max(1.0) / self.shown.max(0.02)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_that_repeat_each_other_are_worth_less() {
        let filter = [2.56, 3.6];
        let of = |correlations: Vec<f32>, frames: usize, speed: f32| {
            NoiseModel { correlations, shown: 0.5, ..NoiseModel::default() }.repeated_over_time(frames, speed, filter)
        };
        assert_eq!(of(Vec::new(), 10, 0.0), 1.0);
        let halves: Vec<f32> = (1..20).map(|k| 0.5f32.powi(k)).collect();
        // (1 + r)/(1 − r) for many frames, divided by the part that differences show.
        let still = of(halves.clone(), 2000, 0.0);
        assert!((still / 6.0 - 1.0).abs() < 0.02, "{still}");
        assert!((of(halves, 2000, 6.0) - 2.0).abs() < 0.02, "the noise is left behind");
    }
}
