//! What each frame of a burst is worth: which ones are copies, black, flashed, empty or too noisy, and how bright and how noisy the others are.
//!
//! A frame that repeats another brings no new noise, so it does not count; a frame that is much noisier than the others makes their mean worse. Both are left
//! out, and frames whose exposure differs are brought to the same brightness.

use super::high_pass::{FREE_VALUES, HighPass, quiet_variance};
use serde::Serialize;

/// Why a frame takes no part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftOut {
    /// It is the same as an earlier frame, whose index among the used frames this is.
    Duplicate(usize),
    /// It is less than half as bright as the others.
    Black,
    /// It is more than twice as bright as the others.
    Flash,
    /// It has no noise at all, though the others have.
    Empty,
    /// Its noise has this many times the variance of the others', so that their mean is better without it.
    Noisy(f32),
}

/// One frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrameFacts {
    /// Its exposure over the others'; 1 where no flicker was found.
    pub gain: f32,
    /// The variance of its noise over that of a usual frame.
    pub relative_variance: f32,
    /// Why it takes no part, if it does not.
    pub left_out: Option<LeftOut>,
}

/// All frames.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameSurvey {
    /// One a frame, in order.
    pub frames: Vec<FrameFacts>,
    /// Standard deviation of the exposures, after a steady trend is taken off, if it is enough to be taken for flicker; else 0.
    pub flicker: f32,
    /// The correlation of the noise of consecutive frames; 0 where none was found.
    pub correlation: f32,
}

/// Exposures that spread more than this are flicker; less is what moves through the picture.
const LEAST_FLICKER: f32 = 0.015;
/// Frames under this share of the usual brightness are black, those above its inverse flashed.
const BLACK: f32 = 0.5;
/// A pair of frames whose difference has less than this share of their noise is a copy.
const COPY: f32 = 0.02;
/// Copies are looked for this many frames back.
const LOOK_BACK: usize = 4;
/// A frame is left out for its noise only if the mean's variance falls by more than this factor.
const WORTH_LEAVING_OUT: f32 = 0.9;
/// Relative variances closer to 1 than this are taken for 1.
const SAME_VARIANCE: f32 = 0.15;
/// Correlations of consecutive frames below this are taken for none.
const LEAST_CORRELATION: f32 = 0.15;

impl FrameSurvey {
    /// Indices of the frames that take part.
    pub fn kept(&self) -> Vec<usize> {
        (0..self.frames.len()).filter(|&t| self.frames[t].left_out.is_none()).collect()
    }

    /// What the squares of the frames tell.
    pub fn new(squares: &HighPass) -> Self {
        let count = squares.frames();
        let usual = FrameFacts { gain: 1.0, relative_variance: 1.0, left_out: None };
        let mut survey = Self { frames: vec![usual; count], ..Self::default() };
        if count < 2 || squares.places.is_empty() {
            return survey;
        }
        let of_frames: Vec<Vec<f32>> = (0..count).map(|t| squares.variances(&[(t, 1.0)])).collect();
        let noise: Vec<f32> = of_frames.iter().map(|v| quiet_variance(v.clone(), FREE_VALUES)).collect();
        survey.leave_out_empty(&of_frames);
        survey.leave_out_copies(squares, &noise);
        survey.compare_brightness(squares);
        survey.compare_noise(squares, &noise);
        survey.correlation = correlation(squares, &of_frames, &survey.kept());
        survey
    }

    /// Leaves out a frame and says why, unless it is left out already or would be the last but one.
    fn leave_out(&mut self, t: usize, why: LeftOut) {
        if self.frames[t].left_out.is_none() && self.kept().len() > 2 {
            self.frames[t].left_out = Some(why);
        }
    }

    fn leave_out_empty(&mut self, of_frames: &[Vec<f32>]) {
        let is_empty: Vec<bool> = of_frames.iter().map(|variances| variances.iter().all(|&v| v == 0.0)).collect();
        // Where most frames have no noise, that is what the burst is like.
        if 2 * is_empty.iter().filter(|&&empty| empty).count() < is_empty.len() {
            (0..is_empty.len()).filter(|&t| is_empty[t]).for_each(|t| self.leave_out(t, LeftOut::Empty));
        }
    }

    fn leave_out_copies(&mut self, squares: &HighPass, noise: &[f32]) {
        for (t, &own) in noise.iter().enumerate().skip(1) {
            for before in t.saturating_sub(LOOK_BACK)..t {
                if self.frames[before].left_out.is_some() || self.frames[t].left_out.is_some() || own == 0.0 {
                    continue;
                }
                // Copies that went through a file once more follow their original.
                let nearly = || {
                    let differ = squares.variances(&[(t, 1.0), (before, -1.0)]);
                    before + 1 == t && quiet_variance(differ, FREE_VALUES) < COPY * own
                };
                if squares.same(t, before) || nearly() {
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

    /// Finds how noisy each frame is, and leaves out those without which the mean is better.
    fn compare_noise(&mut self, squares: &HighPass, noise: &[f32]) {
        let kept = self.kept();
        let pairs =
            kept.windows(2).map(|w| quiet_variance(squares.variances(&[(w[0], 1.0), (w[1], -1.0)]), FREE_VALUES));
        // What frames show beyond their differences is texture, the same in all of them.
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
}

/// The ratio of brightnesses that the brighter squares agree on: the median, each with its brightness as weight.
fn bright_ratio(squares: &[f32], reference: &[f32]) -> f32 {
    let mut ratios: Vec<(f32, f32)> =
        squares.iter().zip(reference).filter(|(_, r)| **r > 0.0).map(|(x, r)| (x / r, *r)).collect();
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * ratios.iter().map(|(_, weight)| weight).sum::<f32>();
    let mut so_far = 0.0;
    for (ratio, weight) in ratios {
        so_far += weight;
        if so_far >= half {
            return ratio;
        }
    }
    1.0
}

/// The standard deviation of values around their straight line over time; 0 for fewer than three.
fn spread_without_trend(points: &[(f32, f32)]) -> f32 {
    let n = points.len() as f32;
    if points.len() < 3 {
        return 0.0;
    }
    let mean = |value: fn(&(f32, f32)) -> f32| points.iter().map(value).sum::<f32>() / n;
    let (t, x) = (mean(|p| p.0), mean(|p| p.1));
    let along = points.iter().map(|p| (p.0 - t) * (p.1 - x)).sum::<f32>();
    let slope = along / points.iter().map(|p| (p.0 - t).powi(2)).sum::<f32>();
    (points.iter().map(|p| (p.1 - x - slope * (p.0 - t)).powi(2)).sum::<f32>() / (n - 2.0)).sqrt()
}

/// The correlation of the noise of consecutive frames, from the flattest squares; 0 where texture may be what they share.
fn correlation(squares: &HighPass, of_frames: &[Vec<f32>], kept: &[usize]) -> f32 {
    if kept.len() < 5 {
        return 0.0;
    }
    // The squares are chosen by the first frames and measured in the others, so that choosing does not change what is measured.
    let (choosing, measuring) = kept.split_at(2);
    let mean = |variances: Vec<Vec<f32>>| -> Vec<f32> {
        let n = variances.len() as f32;
        (0..squares.places.len()).map(|i| variances.iter().map(|v| v[i]).sum::<f32>() / n).collect()
    };
    let chosen_by = mean(choosing.iter().map(|&t| of_frames[t].clone()).collect());
    let mut order: Vec<usize> = (0..squares.places.len()).collect();
    order.sort_by(|&a, &b| chosen_by[a].total_cmp(&chosen_by[b]));
    let flat = &order[..order.len().div_ceil(3)];
    let of_frames = mean(measuring.iter().map(|&t| of_frames[t].clone()).collect());
    let of_pairs = mean(measuring.windows(2).map(|w| squares.variances(&[(w[0], 1.0), (w[1], -1.0)])).collect());
    let mut frames: Vec<f32> = flat.iter().map(|&i| of_frames[i]).collect();
    let pairs: f32 = flat.iter().map(|&i| of_pairs[i]).sum();
    let own: f32 = frames.iter().sum();
    if own <= 0.0 {
        return 0.0;
    }
    let shared = 1.0 - pairs / own;
    // Noise varies little from square to square; texture does.
    frames.sort_by(f32::total_cmp);
    let spread = frames[frames.len() * 8 / 10] / frames[frames.len() * 2 / 10].max(f32::MIN_POSITIVE);
    if shared > LEAST_CORRELATION && spread < 1.6 { shared.min(0.95) } else { 0.0 }
}

/// The middle value; 0 of none.
pub(super) fn median(mut values: Vec<f32>) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::super::pyramid::BoxPyramid;
    use super::*;
    use crate::monitor::Monitor;
    use crate::plane::Plane;
    use crate::synth::{NoiseCase, SceneParams, synth_scene};

    fn survey_of(frames: &[&Plane]) -> FrameSurvey {
        let pyramids: Vec<BoxPyramid> = frames.iter().map(|f| BoxPyramid::new(f, 1)).collect();
        FrameSurvey::new(&HighPass::new(&pyramids.iter().collect::<Vec<_>>()))
    }

    fn survey(case: NoiseCase) -> FrameSurvey {
        let burst = case.burst((320, 240), 10, 0.02, 5, &Monitor::default()).expect("not cancelled");
        survey_of(&burst.frames.iter().map(|f| &**f).collect::<Vec<_>>())
    }

    #[test]
    fn good_frames_all_take_part_unchanged() {
        for case in
            [NoiseCase::White, NoiseCase::Correlated, NoiseCase::Jpeg(60), NoiseCase::NoisyHalf, NoiseCase::Constant]
        {
            let survey = survey(case);
            assert_eq!(survey.kept().len(), 10, "{case:?} {survey:?}");
            assert!(survey.frames.iter().all(|f| f.gain == 1.0 && f.relative_variance == 1.0), "{case:?} {survey:?}");
            assert_eq!((survey.flicker, survey.correlation), (0.0, 0.0), "{case:?}");
        }
    }

    #[test]
    fn a_frame_that_repeats_another_does_not_count() {
        let survey = survey(NoiseCase::Doubled);
        assert_eq!(survey.kept(), [0, 2, 4, 6, 8]);
        assert_eq!(survey.frames[7].left_out, Some(LeftOut::Duplicate(6)));
    }

    #[test]
    fn black_empty_and_noisy_frames_are_left_out() {
        let without_5 = [0, 1, 2, 3, 4, 6, 7, 8, 9];
        let black = survey(NoiseCase::BlackFrame);
        assert_eq!(black.kept(), without_5);
        assert!(matches!(black.frames[5].left_out, Some(LeftOut::Black | LeftOut::Empty)), "{:?}", black.frames[5]);
        let empty = survey(NoiseCase::ConstantFrame);
        assert_eq!((empty.kept(), empty.frames[5].left_out), (without_5.to_vec(), Some(LeftOut::Empty)));
        let noisy = survey(NoiseCase::NoisyFrame);
        assert_eq!(noisy.kept(), without_5);
        match noisy.frames[5].left_out {
            Some(LeftOut::Noisy(times)) => assert!((times / 25.0 - 1.0).abs() < 0.1, "{times}"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn flicker_is_measured_and_a_steady_change_is_none() {
        let burst = NoiseCase::GainFlicker.burst((320, 240), 10, 0.02, 5, &Monitor::default()).expect("not cancelled");
        let survey = survey(NoiseCase::GainFlicker);
        assert!((0.04..0.2).contains(&survey.flicker), "{}", survey.flicker);
        let mean = |t: usize| burst.frames[t].data().iter().sum::<f32>() / burst.frames[t].data().len() as f32;
        for t in 1..10 {
            let ratio = survey.frames[t].gain / survey.frames[0].gain;
            assert!((ratio / (mean(t) / mean(0)) - 1.0).abs() < 2e-3, "{t}: {ratio}");
        }
        let steady: Vec<Plane> = (0..6).map(|t| Plane::from_fn(100, 100, |_, _| 0.5 + 0.02 * t as f32)).collect();
        assert_eq!(survey_of(&steady.iter().collect::<Vec<_>>()).flicker, 0.0);
    }

    #[test]
    fn smoothing_over_time_shows_as_correlation() {
        let burst = NoiseCase::White.burst((320, 240), 12, 0.02, 5, &Monitor::default()).expect("not cancelled");
        let mut smooth: Vec<Plane> = vec![(*burst.frames[0]).clone()];
        for frame in &burst.frames[1..] {
            let before = smooth.last().expect("one").data();
            let values = frame.data().iter().zip(before).map(|(x, y)| 0.5 * x + 0.5 * y).collect();
            smooth.push(Plane::from_vec(320, 240, values));
        }
        let survey = survey_of(&smooth.iter().skip(3).collect::<Vec<_>>());
        assert!((survey.correlation - 0.5).abs() < 0.05, "{}", survey.correlation);
    }

    #[test]
    fn a_moving_scene_has_nothing_to_be_left_out() {
        let scene = SceneParams { width: 240, height: 180, frames: 6, layers: 1, ..SceneParams::default() };
        let (burst, _) = synth_scene(&scene, &Monitor::default()).expect("a scene");
        let survey = survey_of(&burst.frames.iter().map(|f| &**f).collect::<Vec<_>>());
        assert_eq!((survey.kept().len(), survey.flicker, survey.correlation), (6, 0.0, 0.0), "{survey:?}");
    }
}
