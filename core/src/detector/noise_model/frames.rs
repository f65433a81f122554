//! Survey: copies and black, flashed, empty, noisy or blurred frames go; exposure and noise of the others are measured.
//!
//! A copy brings no new noise, so it does not count; a frame much noisier than the others makes their mean worse.
//! Without exposures `gain-flicker` has 984 false features a megapixel at the strict gate, not 6; without noise by
//! frame `noisy-frame` 281, without correlations `smoothed` 16, without the weak pattern `fixed-pattern-30` 45.

use super::contrast::Contrast;
use super::high_pass::{FREE_VALUES, HighPass, SQUARE_PIXELS, median, quantile, sorted, spread};
use rayon::prelude::*;
use serde::Serialize;

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
    /// Variance of the noise relative to that of a usual frame; exactly 1 where they differ by under 15 %.
    pub relative_variance: f32,
    /// Reason why the frame takes no part; `None` where it does.
    pub left_out: Option<LeftOut>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameSurvey {
    pub frames: Vec<FrameFacts>,
    /// Standard deviation of the logarithms of the exposures around a steady trend; 0 where it is no flicker.
    pub flicker: f32,
    /// Range of the logarithms of exposures that change steadily and alike at all places; else 0.
    pub drift: f32,
    /// Correlation of the noise of frames that are 1, 2, … frames apart; empty where none was found.
    pub correlations: Vec<f32>,
    /// Flat squares and a frame's mean variance in them, where frames are correlated.
    pub(super) flat: (Vec<usize>, f32),
}

/// Spread of exposures above which frames flicker; moving objects cause a smaller spread.
const MIN_FLICKER: f32 = 0.015;
/// Spread of exposures, in standard errors of a frame's mean brightness, up to which the spread is noise.
const SURE_OF_FLICKER: f32 = 4.0;
/// Spread of exposures, in errors of the median over squares, up to which things that move explain it.
const SURE_OF_THINGS: f32 = 2.0;
/// Range of exposures above which a steady change is noticed, if all places share it.
const MIN_DRIFT: f32 = 0.005;
/// Ratio of that range to the spread between places above which all places share the change.
const SHARED: f32 = 2.0;
/// Share of the usual brightness below which a frame is black; above its inverse it is flashed.
const BLACK: f32 = 0.5;
/// Share of the frames' noise below which the difference of two frames means a copy.
const COPY: f32 = 0.02;
/// Brightness of a square, in standard deviations of its noise, above which it shows the exposure.
const BRIGHT: f32 = 4.0;
/// Number of squares of which at least one has to show the exposure.
const MIN_BRIGHT: usize = 20;
const LOOK_BACK: usize = 4;
/// Factor by which the mean's variance must fall for a frame to be left out for its noise.
const WORTH_LEAVING_OUT: f32 = 0.9;
/// Difference from 1 below which a relative variance is taken for 1.
const SAME_VARIANCE: f32 = 0.15;
/// Share of the power of the others' texture below which a frame is blurred.
const BLURRED: f32 = 0.4;
/// Power of texture, relative to the noise's, below which the two cannot be told apart.
const MIN_TEXTURE: f32 = 0.15;
/// Share by which the mean of all squares must exceed that of the quiet ones to show texture.
const UNEVEN: f32 = 0.08;
/// Noise, relative to the usual, above which a frame is not judged by its texture.
const NOISIER: f32 = 1.5;
/// Difference of textures, relative to the usual difference, up to which frames are sharp.
const UNUSUAL: f32 = 6.0;

impl FrameSurvey {
    pub fn kept(&self) -> Vec<usize> {
        (0..self.frames.len()).filter(|&t| self.frames[t].left_out.is_none()).collect()
    }

    pub fn new(squares: &HighPass) -> Self {
        let usual = FrameFacts { gain: 1.0, relative_variance: 1.0, left_out: None };
        let mut survey = Self { frames: vec![usual; squares.frames()], ..Self::default() };
        if squares.frames() < 2 || squares.places.is_empty() {
            return survey;
        }
        // Each test relies on those before: copies and flashes would spoil the comparison of noise.
        let looks = Looks::new(squares);
        // Where a codec rounded noise away, a frame that shows less has no less of it.
        let shows_noise = !squares.are_flattened;
        if shows_noise {
            survey.leave_out_empty(&looks);
        }
        survey.leave_out_copies(squares, &looks);
        survey.compare_brightness(squares, &looks);
        survey.leave_out_blurred(squares, &looks);
        if shows_noise {
            let kept = survey.kept().len();
            survey.compare_noise(squares, &looks);
            // Strong noise that is cut off at black makes a frame brighter: once it is left out, that is no flicker.
            if survey.kept().len() < kept {
                survey.compare_brightness(squares, &looks);
            }
        }
        survey.correlate(squares, &looks, &survey.kept());
        survey
    }

    /// Measures the correlations anew in `squares` of the kept frames alone, once hot pixels, which stay, are masked.
    pub fn correlate_again(&mut self, squares: &HighPass) {
        self.correlate(squares, &Looks::new(squares), &(0..squares.frames()).collect::<Vec<_>>());
    }

    fn correlate(&mut self, squares: &HighPass, looks: &Looks, frames: &[usize]) {
        (self.correlations, self.flat) = correlations(squares, looks, frames);
    }

    /// Whether what frames share stays, as a sensor's pattern does, instead of fading from frame to frame: noise that
    /// is smoothed over time fades at least like a geometric series.
    pub fn shares_pattern(&self) -> bool {
        let Some((&next, later)) = self.correlations.split_first().filter(|(_, later)| !later.is_empty()) else {
            return false;
        };
        let fading = (2..).map(|lag| next.powi(lag)).take(later.len()).sum::<f32>() / later.len() as f32;
        later.iter().sum::<f32>() / later.len() as f32 > STAYS * next + (1.0 - STAYS) * fading
    }

    /// Share of the variance of a frame's noise that `contrasts` of `squares` show; 1 for independent frames.
    pub fn shown(&self, squares: &HighPass, contrasts: &[Contrast]) -> f32 {
        let (flat, usual) = &self.flat;
        if self.correlations.is_empty() || *usual <= 0.0 {
            return 1.0;
        }
        let variances = squares.mean_variances(contrasts);
        let mean = flat.iter().map(|&i| variances[i]).sum::<f32>() / flat.len() as f32;
        (mean / usual).clamp(0.02, 1.0)
    }

    /// Variance of the noise in `contrasts` of the frames `looked`, whose `squares` are given, relative to their mean;
    /// and of each kept frame relative to the same mean, empty where all frames have the same noise.
    pub fn relative_noise(&self, squares: &HighPass, contrasts: &[Contrast], looked: &[usize]) -> (Vec<f32>, Vec<f32>) {
        let own = |t: usize| self.frames[t].relative_variance;
        let are_independent = self.correlations.is_empty();
        // Shared noise is in each frame and not in the differences: then the differences are measured.
        let in_contrast = |contrast: &Contrast| match are_independent {
            true => contrast.iter().map(|(i, weight)| weight * weight * own(looked[*i])).sum::<f32>(),
            false => {
                let variances = squares.variances(contrast);
                self.flat.0.iter().map(|&i| variances[i]).sum::<f32>()
            }
        };
        let mean = |values: &[f32]| (values.iter().sum::<f32>() / values.len() as f32).max(f32::MIN_POSITIVE);
        let relative = |values: Vec<f32>, to: f32| values.into_iter().map(|x| x / to).collect();
        let in_contrasts: Vec<f32> = contrasts.iter().map(in_contrast).collect();
        let usual = mean(&in_contrasts);
        let mut of_frames: Vec<f32> = self.kept().into_iter().map(own).collect();
        let base = if are_independent { usual } else { mean(&of_frames) };
        if of_frames.iter().all(|x| *x == 1.0) {
            of_frames.clear();
        }
        (relative(in_contrasts, usual), relative(of_frames, base))
    }

    /// Share of the variance common to all frames, where their mean exceeds `noise` everywhere; else 0.
    pub fn pattern_share(&self, squares: &HighPass, noise: f32) -> f32 {
        let kept = self.kept();
        if kept.len() < 4 || !self.correlations.is_empty() || squares.are_flattened || squares.are_bits || noise <= 0.0
        {
            return 0.0;
        }
        let weight = |t: usize| 1.0 / self.frames[t].gain;
        let variances = squares.variances(&kept.iter().map(|&t| (t, weight(t))).collect::<Vec<_>>());
        let all = squares.noise_in(variances.clone()) / noise - 1.0;
        let of_noise = (2.0 / FREE_VALUES).sqrt();
        let error = of_noise * 1.5 / (variances.len() as f32).sqrt();
        // A pattern is the same everywhere; what is uneven may be texture that stays in place.
        let is_uneven = spread(&sorted(variances)) > EVEN_PATTERN * of_noise;
        if all < SURE_OF_PATTERN * error || is_uneven { 0.0 } else { all / (kept.len() as f32 + all) }
    }

    /// Does nothing for a frame that is already left out, or where only two are kept.
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
            let is_kept = |t: usize| self.frames[t].left_out.is_none();
            let is_original = |&before: &usize| {
                // A copy that was compressed or converted again follows its original directly.
                let nearly = || before + 1 == t && looks.in_pair(squares, before, t) < COPY * own;
                is_kept(before) && is_kept(t) && own != 0.0 && (nearly() || squares.same(t, before))
            };
            if let Some(original) = (t.saturating_sub(LOOK_BACK)..t).find(is_original) {
                self.leave_out(t, LeftOut::Duplicate(original));
            }
        }
    }

    fn compare_brightness(&mut self, squares: &HighPass, looks: &Looks) {
        (self.flicker, self.drift) = (0.0, 0.0);
        self.frames.iter_mut().for_each(|frame| frame.gain = 1.0);
        let mean = |t: usize| squares.brightness[t].iter().sum::<f32>() / squares.places.len() as f32;
        let mut order = self.kept();
        order.sort_by(|&a, &b| mean(a).total_cmp(&mean(b)));
        // The frame of median brightness: neither a flash nor a black frame.
        let reference = order[order.len() / 2];
        // Around black, where a black level was subtracted, brightness is only noise.
        let least = BRIGHT * (looks.noise[reference] / SQUARE_PIXELS as f32).sqrt();
        // The brightest squares of a frame of bits are those with more photons by chance.
        let ratio = |t: usize| match squares.are_bits {
            true => (mean(t) / mean(reference), 0.0),
            false => bright_ratio(&squares.brightness[t], &squares.brightness[reference], least),
        };
        if !squares.are_bits
            && squares.brightness[reference].iter().filter(|b| **b > least).count() * MIN_BRIGHT < squares.places.len()
        {
            return;
        }
        let (gains, errors): (Vec<f32>, Vec<f32>) = (0..squares.frames()).map(ratio).unzip();
        for (t, (gain, error)) in gains.iter().zip(&errors).enumerate() {
            if gain + SURE_OF_THINGS * error < BLACK {
                self.leave_out(t, LeftOut::Black);
            } else if gain - SURE_OF_THINGS * error > 1.0 / BLACK {
                self.leave_out(t, LeftOut::Flash);
            }
        }
        let kept = self.kept();
        let flicker = spread_without_trend(&kept.iter().map(|&t| (t as f32, gains[t].ln())).collect::<Vec<_>>());
        let drift = shared_drift(squares, &kept, &gains, least);
        // The median over the squares of a dark frame differs by its noise alone.
        let pixels = (squares.places.len() * SQUARE_PIXELS) as f32;
        let error = SURE_OF_FLICKER * (looks.noise[reference] / pixels).sqrt() / mean(reference);
        // Few bright things that move in and out of squares change the median by its error.
        let of_things = SURE_OF_THINGS * kept.iter().map(|&t| errors[t]).fold(0.0, f32::max);
        let flickers = flicker > MIN_FLICKER.max(error).max(of_things);
        // The spread is taken around a trend, so a steady drift has a test of its own.
        if flickers || drift > 0.0 {
            (self.flicker, self.drift) = if flickers { (flicker, 0.0) } else { (0.0, drift) };
            let middle = kept.iter().map(|&t| gains[t]).sum::<f32>() / kept.len() as f32;
            kept.iter().for_each(|&t| self.frames[t].gain = gains[t] / middle);
        }
    }

    fn compare_noise(&mut self, squares: &HighPass, looks: &Looks) {
        let kept = self.kept();
        let noise = &looks.noise;
        let pairs = kept.windows(2).map(|w| looks.in_pair(squares, w[0], w[1]));
        // The power of frames beyond that of their differences is texture, equal in all frames.
        let own: Vec<f32> = kept.iter().map(|&t| noise[t]).collect();
        let in_pairs = median(pairs.collect());
        let texture = (median(own) - in_pairs).max(0.0);
        // Noise is what texture leaves, which strong texture makes uncertain.
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
        // The mean of n frames has Σσ²/n²: leaving out a noisy frame may lower it.
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

    fn leave_out_blurred(&mut self, squares: &HighPass, looks: &Looks) {
        let kept = self.kept();
        if kept.len() < 4 || squares.are_bits {
            return;
        }
        let per_gain = |power: &dyn Fn(usize) -> f32| -> Vec<f32> {
            kept.iter().map(|&t| power(t) / self.frames[t].gain.powi(2)).collect()
        };
        let powers = per_gain(&|t| looks.frames[t].iter().sum::<f32>() / looks.frames[t].len() as f32);
        let quiet = per_gain(&|t| looks.noise[t]);
        let usual = median(powers.clone());
        let beyond_quiet = median(powers.iter().zip(&quiet).map(|(power, quiet)| power - quiet).collect());
        let difference = median(powers.iter().map(|power| (power - usual).abs()).collect());
        // A blurred frame shows noise alone, so the lowest power is the noise, or more.
        let noise = quiet.iter().copied().fold(f32::INFINITY, f32::min);
        let texture = usual - noise;
        if texture <= MIN_TEXTURE * noise || beyond_quiet <= UNEVEN * median(quiet.clone()) {
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

const MIN_CORRELATION: f32 = 0.15;
/// Least place of later correlations between those of fading noise, 0, and that of consecutive frames, 1, of a pattern.
const STAYS: f32 = 0.75;

/// Variances in the squares, of single frames and of differences of neighbours.
struct Looks {
    /// By frame and square.
    frames: Vec<Vec<f32>>,
    /// By frame, from the quiet squares.
    noise: Vec<f32>,
    /// Of each frame's difference to the next, by frame and square.
    pairs: Vec<Vec<f32>>,
    /// Of the quiet squares of these differences.
    in_pairs: Vec<f32>,
}

impl Looks {
    fn new(squares: &HighPass) -> Self {
        let count = squares.frames();
        let quiet = |all: &Vec<Vec<f32>>| all.par_iter().map(|v| squares.noise_in(v.clone())).collect();
        let frames: Vec<Vec<f32>> = (0..count).into_par_iter().map(|t| squares.variances(&[(t, 1.0)])).collect();
        let pairs = (1..count).into_par_iter().map(|t| squares.variances(&[(t - 1, 1.0), (t, -1.0)])).collect();
        Self { noise: quiet(&frames), in_pairs: quiet(&pairs), frames, pairs }
    }

    /// Variance of the noise of one frame, measured in the difference of two.
    fn in_pair(&self, squares: &HighPass, a: usize, b: usize) -> f32 {
        if a + 1 == b { self.in_pairs[a] } else { squares.noise_in(squares.variances(&[(a, 1.0), (b, -1.0)])) }
    }
}

/// Median ratio over the squares in which the reference is brighter than `least`, weighted by brightness; its error.
fn bright_ratio(squares: &[f32], reference: &[f32], least: f32) -> (f32, f32) {
    let mut ratios: Vec<(f32, f32)> =
        squares.iter().zip(reference).filter(|(_, r)| **r > least).map(|(x, r)| (x / r, *r)).collect();
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A median with half of the brightness on each side: bright squares tell a ratio best.
    let all = ratios.iter().map(|(_, weight)| weight).sum::<f32>();
    let below = |part: f32| {
        let mut so_far = 0.0;
        let reaches = |(_, weight): &&(f32, f32)| {
            so_far += weight;
            so_far >= part * all
        };
        ratios.iter().find(reaches).map_or(1.0, |(ratio, _)| *ratio)
    };
    let squared = ratios.iter().map(|(_, weight)| weight * weight).sum::<f32>();
    (below(0.5), MEDIAN_ERROR * (below(0.75) - below(0.25)) / 1.35 * squared.sqrt() / all.max(f32::MIN_POSITIVE))
}

/// Standard error of a median relative to that of a mean of normal values.
const MEDIAN_ERROR: f32 = 1.25;

/// Range of the logarithms of the exposures `gains`, if the squares brighter than `least` share it; else 0.
fn shared_drift(squares: &HighPass, kept: &[usize], gains: &[f32], least: f32) -> f32 {
    if kept.len() < 3 || squares.are_bits {
        return 0.0;
    }
    // Means of three frames, so that noise counts less.
    let around = |i: usize| &kept[i.saturating_sub(1)..(i + 2).min(kept.len())];
    let gain = |i: usize| around(i).iter().map(|&t| gains[t]).sum::<f32>() / around(i).len() as f32;
    let mut order: Vec<usize> = (0..kept.len()).collect();
    order.sort_by(|&a, &b| gain(a).total_cmp(&gain(b)));
    let (dark, bright) = (order[0], order[order.len() - 1]);
    let mean = |i: usize, square: usize| {
        around(i).iter().map(|&t| squares.brightness[t][square]).sum::<f32>() / around(i).len() as f32
    };
    let changes = (0..squares.places.len()).map(|square| (mean(dark, square), mean(bright, square)));
    let changes = sorted(changes.filter(|(a, b)| a.min(*b) > least).map(|(a, b)| (b / a).ln()).collect());
    if changes.len() < MIN_BRIGHT {
        return 0.0;
    }
    let [low, middle, high] = [0.25, 0.5, 0.75].map(|part| quantile(&changes, part));
    let spread = (high - low) / 1.35;
    let range = (gains[kept[bright]] / gains[kept[dark]]).ln();
    if middle > MIN_DRIFT && middle > SHARED * spread { range } else { 0.0 }
}

/// Standard deviation of values around their straight line over time; 0 for fewer than three.
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

/// Number of standard errors by which the mean of the frames must have more noise than expected to show a pattern.
const SURE_OF_PATTERN: f32 = 6.0;
/// Spread of the squares, relative to that of noise, up to which the pattern is the same everywhere.
const EVEN_PATTERN: f32 = 1.25;

/// Ratio of the squares' upper to lower fifth of variances up to which there is no texture.
const EVEN: f32 = 1.75;
/// That ratio of the squares' variances in the differences of neighbours, relative to their own, up to which all share
/// noise alike, however strong: 1.15, and so much more per correlation. Texture varies more, and its share with it.
const EVEN_SHARES: f32 = 0.5;
/// Variance of a square, relative to the usual, above which it holds something: noise of one strength stays below.
const HOLDS: f32 = 4.0;
const MAX_LAG: usize = 16;

/// Correlations of the noise of frames 1, 2, … apart, and the flattest squares with their mean variance.
fn correlations(squares: &HighPass, looks: &Looks, kept: &[usize]) -> (Vec<f32>, (Vec<usize>, f32)) {
    let none = (Vec::new(), (Vec::new(), 0.0));
    if kept.len() < 4 {
        return none;
    }
    // Chosen by the first frames and measured in the others, so that the choice has no effect.
    let (choosing, measuring) = kept.split_at(2);
    let mean = |variances: &[&[f32]]| -> Vec<f32> {
        let n = variances.len() as f32;
        (0..squares.places.len()).map(|i| variances.iter().map(|v| v[i]).sum::<f32>() / n).collect()
    };
    let own =
        |frames: &[usize]| -> Vec<f32> { mean(&frames.iter().map(|&t| &looks.frames[t][..]).collect::<Vec<_>>()) };
    // Noise varies little from square to square; texture does.
    let spread = |values: Vec<f32>| {
        let values = sorted(values);
        values[values.len() * 8 / 10] / values[values.len() * 2 / 10].max(f32::MIN_POSITIVE)
    };
    let of_frames = own(measuring);
    let chosen_by = own(choosing);
    // Squares with far more than the others hold things, such as stars on a quiet ground.
    let of_all = own(kept);
    let most = if squares.are_flattened || squares.are_bits { f32::INFINITY } else { HOLDS * median(of_all.clone()) };
    let mut order: Vec<usize> = (0..squares.places.len()).filter(|&i| of_all[i] <= most).collect();
    order.sort_by(|&a, &b| chosen_by[a].total_cmp(&chosen_by[b]));
    // Where frames share noise the choice does bias the result: without texture all squares are taken.
    let next_to: Vec<usize> = measuring.windows(2).filter(|w| w[0] + 1 == w[1]).map(|w| w[0]).collect();
    let of_pairs = mean(&next_to.iter().map(|&t| &looks.pairs[t][..]).collect::<Vec<_>>());
    let shared = |squares: &[usize]| {
        let sum = |variances: &[f32]| squares.iter().map(|&i| variances[i]).sum::<f32>();
        1.0 - sum(&of_pairs) / sum(&of_frames)
    };
    let shares = of_pairs.iter().zip(&of_frames).map(|(pair, own)| pair / own).filter(|share| share.is_finite());
    let shares: Vec<f32> = shares.collect();
    let are_alike = shares.len() >= MIN_BRIGHT && spread(shares) < 1.15 + EVEN_SHARES * shared(&order);
    // Of a file that is mostly flat, squares that together hold less than a step hold no scene.
    let are_faint = || of_frames.iter().sum::<f32>() < squares.least_scene * of_frames.len() as f32;
    let all = are_alike || spread(of_frames.clone()) < EVEN || (squares.are_flattened && are_faint());
    let flat = if all { &order[..] } else { &order[..order.len().div_ceil(3)] };
    let is_even = all || spread(flat.iter().map(|&i| of_frames[i]).collect()) < EVEN;
    // It is no number without noise or neighbours.
    let is_shared = |share: f32| share > MIN_CORRELATION;
    if !is_even || !is_shared(shared(flat)) {
        return none;
    }
    let in_flat = |variances: &[f32]| flat.iter().map(|&i| variances[i]).sum::<f32>() / flat.len() as f32;
    // Relative to the mean variance of all frames, so that the sum over lags is the variance of their mean.
    let alone = |t: usize| in_flat(&looks.frames[t]);
    let usual = kept.iter().map(|&t| alone(t)).sum::<f32>() / kept.len() as f32;
    let at_lag = |lag: usize| {
        let pairs: Vec<(usize, usize)> =
            kept.iter().filter(|&&t| kept.contains(&(t + lag))).map(|&t| (t, t + lag)).collect();
        let covariance = |&(a, b): &(usize, usize)| {
            let difference = in_flat(&squares.variances(&[(a, 1.0), (b, -1.0)]));
            0.5 * (alone(a) + alone(b)) - difference
        };
        let count = pairs.len().max(1) as f32;
        pairs.par_iter().map(covariance).collect::<Vec<_>>().iter().sum::<f32>() / (count * usual)
    };
    let last = MAX_LAG.min(kept[kept.len() - 1] - kept[0]);
    let correlations: Vec<f32> = (1..=last).map(|lag| at_lag(lag).clamp(0.0, 0.98)).collect();
    (correlations, (flat.to_vec(), usual))
}
