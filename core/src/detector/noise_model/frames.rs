//! Survey of the frames of a burst: finds copies and frames that are black, flashed, empty, too noisy or blurred, and
//! the relative exposure and noise of the others.
//!
//! A frame that repeats another brings no new noise, so it does not count; a frame that is much noisier than the others
//! makes their mean worse. Both are left out, and frames whose exposure differs are scaled to the same brightness.

mod measures;

use super::high_pass::HighPass;
use measures::{Looks, bright_ratio, correlation, spread_without_trend};
use serde::Serialize;

pub(super) use measures::median;

/// Reason why a frame takes no part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftOut {
    /// A copy of an earlier frame; the value is the earlier one's index among the used frames.
    Duplicate(usize),
    /// Less than half as bright as the others.
    Black,
    /// More than twice as bright as the others.
    Flash,
    /// Without any noise, though the others have some.
    Empty,
    /// Noisier than the others by this factor of variance, so that their mean is better without it.
    Noisy(f32),
    /// Blurred: its texture, beyond the noise, has this share of the power of the others'.
    Blurred(f32),
}

/// Exposure and noise of one frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrameFacts {
    /// Exposure relative to the others'; 1 where no flicker was found.
    pub gain: f32,
    /// Variance of the noise relative to that of a usual frame.
    pub relative_variance: f32,
    /// Reason why it takes no part; `None` if it does.
    pub left_out: Option<LeftOut>,
}

/// Exposure and noise of all frames.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameSurvey {
    /// One entry a frame, in order.
    pub frames: Vec<FrameFacts>,
    /// Standard deviation of the logarithms of the exposures after removal of a steady trend, if it is large enough to
    /// be flicker; else 0.
    pub flicker: f32,
    /// Correlation of the noise of consecutive frames; 0 where none was found.
    pub correlation: f32,
}

/// Spread of exposures above which it is flicker; a smaller one comes from objects that move through the picture.
const LEAST_FLICKER: f32 = 0.015;
/// Share of the usual brightness below which a frame is black; above its inverse it is flashed.
const BLACK: f32 = 0.5;
/// Share of the frames' noise below which the difference of two frames means a copy.
const COPY: f32 = 0.02;
/// Number of earlier frames that are compared to find copies.
const LOOK_BACK: usize = 4;
/// Factor by which the mean's variance must fall for a frame to be left out for its noise.
const WORTH_LEAVING_OUT: f32 = 0.9;
/// Difference from 1 below which a relative variance is taken for 1.
const SAME_VARIANCE: f32 = 0.15;
/// Share of the power of the others' texture below which a frame is blurred.
const BLURRED: f32 = 0.4;
/// Power of texture, relative to the noise's, below which the two cannot be told apart.
const LEAST_TEXTURE: f32 = 0.15;
/// Share by which the mean of all squares must exceed that of the quiet ones to show texture, which differs from square
/// to square.
const UNEVEN: f32 = 0.08;
/// Noise, relative to the usual, above which a frame is not judged by its texture.
const NOISIER: f32 = 1.5;
/// Difference of textures, relative to the usual difference, up to which frames are sharp.
const UNUSUAL: f32 = 6.0;

impl FrameSurvey {
    /// Indices of the frames that take part.
    pub fn kept(&self) -> Vec<usize> {
        (0..self.frames.len()).filter(|&t| self.frames[t].left_out.is_none()).collect()
    }

    /// Surveys the frames by their squares.
    pub fn new(squares: &HighPass) -> Self {
        let count = squares.frames();
        let usual = FrameFacts { gain: 1.0, relative_variance: 1.0, left_out: None };
        let mut survey = Self { frames: vec![usual; count], ..Self::default() };
        if count < 2 || squares.places.is_empty() {
            return survey;
        }
        let looks = Looks::new(squares);
        survey.leave_out_empty(&looks);
        survey.leave_out_copies(squares, &looks);
        survey.compare_brightness(squares);
        survey.leave_out_blurred(&looks);
        survey.compare_noise(squares, &looks);
        survey.correlation = correlation(squares, &looks, &survey.kept());
        survey
    }

    /// Leaves out a frame for the reason `why`, unless it is left out already or only two are kept.
    fn leave_out(&mut self, t: usize, why: LeftOut) {
        if self.frames[t].left_out.is_none() && self.kept().len() > 2 {
            self.frames[t].left_out = Some(why);
        }
    }

    fn leave_out_empty(&mut self, looks: &Looks) {
        let is_empty: Vec<bool> = looks.frames.iter().map(|variances| variances.iter().all(|&v| v == 0.0)).collect();
        // Where most frames have no noise, that is normal for the burst.
        if 2 * is_empty.iter().filter(|&&empty| empty).count() < is_empty.len() {
            (0..is_empty.len()).filter(|&t| is_empty[t]).for_each(|t| self.leave_out(t, LeftOut::Empty));
        }
    }

    fn leave_out_copies(&mut self, squares: &HighPass, looks: &Looks) {
        for (t, &own) in looks.noise.iter().enumerate().skip(1) {
            for before in t.saturating_sub(LOOK_BACK)..t {
                if self.frames[before].left_out.is_some() || self.frames[t].left_out.is_some() || own == 0.0 {
                    continue;
                }
                // A copy that was compressed or converted again follows its original directly.
                let nearly = before + 1 == t && looks.in_pair(squares, before, t) < COPY * own;
                if nearly || squares.same(t, before) {
                    self.leave_out(t, LeftOut::Duplicate(before));
                    break;
                }
            }
        }
    }

    /// Finds black and flashed frames, and the exposures of the others.
    fn compare_brightness(&mut self, squares: &HighPass) {
        let mean = |t: usize| squares.brightness[t].iter().sum::<f32>() / squares.places.len() as f32;
        let mut order = self.kept();
        order.sort_by(|&a, &b| mean(a).total_cmp(&mean(b)));
        let reference = order[order.len() / 2];
        if mean(reference) <= 0.0 {
            return;
        }
        let gains: Vec<f32> = (0..squares.frames())
            .map(|t| bright_ratio(&squares.brightness[t], &squares.brightness[reference]))
            .collect();
        for (t, &gain) in gains.iter().enumerate() {
            if gain < BLACK {
                self.leave_out(t, LeftOut::Black);
            } else if gain > 1.0 / BLACK {
                self.leave_out(t, LeftOut::Flash);
            }
        }
        let kept = self.kept();
        let flicker = spread_without_trend(&kept.iter().map(|&t| (t as f32, gains[t].ln())).collect::<Vec<_>>());
        if flicker > LEAST_FLICKER {
            self.flicker = flicker;
            let middle = kept.iter().map(|&t| gains[t]).sum::<f32>() / kept.len() as f32;
            kept.iter().for_each(|&t| self.frames[t].gain = gains[t] / middle);
        }
    }

    /// Finds the noise of each frame, and leaves out frames without which the mean is better.
    fn compare_noise(&mut self, squares: &HighPass, looks: &Looks) {
        let kept = self.kept();
        let noise = &looks.noise;
        let pairs = kept.windows(2).map(|w| looks.in_pair(squares, w[0], w[1]));
        // The power of frames beyond that of their differences is texture, the same in all of them.
        let own: Vec<f32> = kept.iter().map(|&t| noise[t]).collect();
        let in_pairs = median(pairs.collect());
        let texture = (median(own) - in_pairs).max(0.0);
        if in_pairs <= 0.0 || texture > 3.0 * in_pairs {
            return;
        }
        let variance = |t: usize| {
            let gain = self.frames[t].gain;
            (noise[t] - texture).max(0.05 * in_pairs) / (gain * gain)
        };
        let variances: Vec<f32> = (0..squares.frames()).map(variance).collect();
        let usual = median(kept.iter().map(|&t| variances[t]).collect());
        for &t in &kept {
            let relative = variances[t] / usual;
            self.frames[t].relative_variance = if (relative - 1.0).abs() < SAME_VARIANCE { 1.0 } else { relative };
        }
        let mut quietest = kept.clone();
        quietest.sort_by(|&a, &b| variances[a].total_cmp(&variances[b]));
        let sum = |n: usize| quietest[..n].iter().map(|&t| self.frames[t].relative_variance).sum::<f32>();
        let of_mean = |n: usize| sum(n) / (n * n) as f32;
        let best = (quietest.len().div_ceil(2)..=quietest.len())
            .min_by(|&a, &b| of_mean(a).total_cmp(&of_mean(b)))
            .unwrap_or(quietest.len());
        if of_mean(best) < WORTH_LEAVING_OUT * of_mean(quietest.len()) {
            for &t in &quietest[best..] {
                let relative = self.frames[t].relative_variance;
                self.leave_out(t, LeftOut::Noisy(relative));
            }
        }
    }

    /// Leaves out frames whose squares have far less power beyond the noise than those of the others.
    fn leave_out_blurred(&mut self, looks: &Looks) {
        let kept = self.kept();
        if kept.len() < 4 {
            return;
        }
        let per_gain = |t: usize, power: f32| power / self.frames[t].gain.powi(2);
        let powers: Vec<f32> = kept
            .iter()
            .map(|&t| per_gain(t, looks.frames[t].iter().sum::<f32>() / looks.frames[t].len() as f32))
            .collect();
        let quiet: Vec<f32> = kept.iter().map(|&t| per_gain(t, looks.noise[t])).collect();
        let usual = median(powers.clone());
        let beyond_quiet = median(powers.iter().zip(&quiet).map(|(power, quiet)| power - quiet).collect());
        let difference = median(powers.iter().map(|power| (power - usual).abs()).collect());
        // A blurred frame has only noise, so its power is the noise, or more.
        let noise = quiet.iter().copied().fold(f32::INFINITY, f32::min);
        let texture = usual - noise;
        if texture <= LEAST_TEXTURE * noise || beyond_quiet <= UNEVEN * median(quiet.clone()) {
            return;
        }
        for ((t, power), own_noise) in kept.into_iter().zip(powers).zip(&quiet) {
            // Strong noise hides texture, but that is another fault.
            let is_noisy = *own_noise > NOISIER * median(quiet.clone());
            let share = (power - noise) / texture;
            if share < BLURRED && usual - power > UNUSUAL * difference && !is_noisy {
                self.leave_out(t, LeftOut::Blurred(share.max(0.0)));
            }
        }
    }
}

#[cfg(test)]
mod tests;
