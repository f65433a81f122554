//! Coherence of a feature: how alike the single frames respond along its motion.
//!
//! A true feature is in every frame: the responses are level. A ghost (a blob of another motion that shows in the stack
//! of a wrong slope) responds only in frames in which the true blob crosses its path: its responses form a bump.
//!
//! All frames may respond alike to what moves otherwise, too: to the smeared image of a thing too small for the scales,
//! to the hollow beside a bright blob, to a corner that becomes a blob only where it is smeared. But then the picture
//! around the feature changes from frame to frame ([`PatchCoherence`]). So the frames are taken in three parts, the
//! first, the middle and the last of them, and D is compared on a lattice around the feature along its motion: at the
//! right slope the parts differ by noise alone. A wrong slope shifts the picture steadily, and noise falls with the
//! number of frames: so there are only three.

use crate::burst::Offset;
use crate::detector::along::{Along, floor_pixel};
use crate::detector::feature::Feature;
use crate::detector::params::Slope;
use crate::detector::scale_space::Scale;
use crate::detector::search::setup::Inputs;
use crate::monitor::{Cancelled, Monitor};
use serde::Serialize;

/// Response of one frame along a motion.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct FrameResponse {
    /// Index of the frame in the burst.
    pub frame: usize,
    /// Position in the frame, input pixels.
    pub pos_frame: [f32; 2],
    /// Whether the frame shows the place and was used.
    pub covers: bool,
    /// D of this frame alone, fraction of full scale; NaN where it does not show the place.
    pub value: f32,
    /// Noise of that D: its standard deviation.
    pub sigma_d: f32,
}

impl Along<'_> {
    /// The response of each frame at a scale along a motion (input pixels), in time order.
    pub(crate) fn each_frame(
        &self,
        Scale { octave, level }: Scale,
        place: [f32; 2],
        slope: Slope,
        monitor: &Monitor,
    ) -> Result<Vec<FrameResponse>, Cancelled> {
        let Inputs { times, frames_used, size_image: size, noise, .. } = self.inputs;
        let offsets = self.inputs.offsets(slope);
        let pixel = |x: f32, n: usize| (x.round().max(0.0) as usize).min(n - 1);
        let at = (pixel(place[0], size.0), pixel(place[1], size.1));
        let frames = self.of(octave);
        let in_octave = frames.offsets(slope);
        // Brightness and noise follow the place through all frames, so that one factor serves them.
        let factor = noise.place_factor(octave, &offsets, floor_pixel((place[0], place[1]), *size), *size);
        let response = |(index, (&t, from_middle)): (usize, (&usize, Offset<f32>))| {
            monitor.check()?;
            let covers = self.inputs.sees(index, &offsets[index], at);
            let own = index..index + 1;
            let value = if covers {
                let (planes, offsets) = (&frames.planes[own.clone()], &in_octave[own.clone()]);
                frames.response(planes, offsets, level..level + 1, (place[0], place[1]))[0]
            } else {
                f32::NAN
            };
            let (moved_u, moved_v) = slope.displacement(from_middle);
            let pos_frame = [place[0] + moved_u, place[1] + moved_v];
            let sigma_d = self.inputs.sigma_d(octave, level, slope, &offsets[own]) * factor;
            Ok(FrameResponse { frame: frames_used.start + t, pos_frame, covers, value, sigma_d })
        };
        let all = times.kept.iter().zip(times.from_middle()).enumerate().map(response);
        let mut all = all.collect::<Result<Vec<_>, Cancelled>>()?;
        // A copy of the burst may have its frames in another order.
        all.sort_by_key(|one| one.frame);
        Ok(all)
    }

    pub(super) fn evenness(&self, feature: &Feature, monitor: &Monitor) -> Result<Evenness, Cancelled> {
        Ok(evenness_of(&self.each_frame(feature.scale(), [feature.u, feature.v], feature.slope, monitor)?))
    }
}

/// Unevenness, in standard deviations, above which the responses differ.
const UNEVEN: f32 = 3.0;
/// Coherence below which uneven responses may be a bump.
pub const BUMP_COHERENCE: f32 = 0.6;
/// Share of the largest smoothed response from which a frame counts as responding.
const ANSWERS: f32 = 0.5;

/// Pattern of the frames' responses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Equal in all frames, within the noise.
    Level,
    /// Different by more than noise explains.
    Uneven,
    /// Present in a part of the frames, next to each other, and absent in the others.
    Bump,
    /// Undecided: too few frames, or too much noise in each.
    Unclear,
}

/// Evenness of the responses of the frames that show the place, from [`FrameResponse`]s in time order.
pub fn evenness_of(answers: &[FrameResponse]) -> Evenness {
    evenness(&answers.iter().filter(|answer| answer.covers).map(|a| (a.value, a.sigma_d)).collect::<Vec<_>>())
}

/// Evenness of responses over frames: whether all frames, or only some, contribute to a feature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Evenness {
    /// Mean of the responses, fraction of full scale.
    pub mean: f32,
    /// Coherence, 0 … 1: the squared mean over the mean square, both without the contribution of noise. 1 when all
    /// frames respond equally; m when only a part m of them does. `None` where single frames are too noisy.
    pub coherence: Option<f32>,
    /// Excess of the responses' spread over that of noise, in standard deviations.
    pub unevenness: f32,
    /// Pattern that follows from coherence and unevenness.
    pub shape: Shape,
}

/// Computes the evenness of `answers`: values with their standard deviations, in time order.
pub fn evenness(answers: &[(f32, f32)]) -> Evenness {
    let n = answers.len() as f64;
    if answers.is_empty() {
        return Evenness { mean: 0.0, coherence: None, unevenness: 0.0, shape: Shape::Unclear };
    }
    let value = |a: &(f32, f32)| f64::from(a.0);
    let mean = answers.iter().map(value).sum::<f64>() / n;
    let square = answers.iter().map(|a| value(a).powi(2)).sum::<f64>() / n;
    let noise = answers.iter().map(|a| f64::from(a.1).powi(2)).sum::<f64>() / n;
    // Noise adds σ²/n to the squared mean and σ² to the mean square.
    let (of_mean, of_all, free) = (mean * mean - noise / n, square - noise, n - 1.0);
    // The mean square is known to about √(2/n) of the noise's; below twice that there is too little to compare.
    let is_seen = of_all > 2.0 * (2.0 / n).sqrt() * noise && of_all > 0.0;
    let coherence = is_seen.then(|| (of_mean / of_all).clamp(0.0, 1.0) as f32);
    let unevenness = if free < 1.0 {
        0.0
    } else if noise <= 0.0 {
        // Without noise only rounding remains: differences of a thousandth do not count.
        let spread = ((square - mean * mean).max(0.0)).sqrt();
        if spread > 1e-3 * mean.abs() { f64::from(UNEVEN) * (spread / (0.3 * mean.abs().max(1e-30))) } else { 0.0 }
    } else {
        // Standardised: the number of frames then does not change the limit.
        let chi2: f64 = answers.iter().map(|a| ((value(a) - mean) / f64::from(a.1).max(1e-30)).powi(2)).sum();
        (chi2 - free) / (2.0 * free).sqrt()
    };
    let uneven = unevenness > f64::from(UNEVEN);
    // The frames that respond lie next to each other and are not all.
    let is_one_bump = || {
        let on = responding(answers);
        let starts = (0..on.len()).filter(|&i| on[i] && (i == 0 || !on[i - 1])).count();
        starts == 1 && on.contains(&false)
    };
    let shape = match coherence {
        _ if answers.len() < 3 => Shape::Unclear,
        Some(coherence) if uneven && coherence < BUMP_COHERENCE && is_one_bump() => Shape::Bump,
        _ if uneven => Shape::Uneven,
        Some(_) => Shape::Level,
        None => Shape::Unclear,
    };
    Evenness { mean: mean as f32, coherence, unevenness: unevenness as f32, shape }
}

/// Whether each frame responds: its smoothed response has the sign of the mean and at least half of the maximum.
pub fn responding(answers: &[(f32, f32)]) -> Vec<bool> {
    let sign = answers.iter().map(|a| a.0).sum::<f32>().signum();
    let at = |i: i64| answers[i.clamp(0, answers.len() as i64 - 1) as usize].0;
    let smooth: Vec<f32> =
        (0..answers.len() as i64).map(|i| sign * (0.25 * at(i - 1) + 0.5 * at(i) + 0.25 * at(i + 1))).collect();
    let max = smooth.iter().copied().fold(0.0, f32::max);
    smooth.iter().map(|&x| max > 0.0 && x >= ANSWERS * max).collect()
}

/// How alike the parts of the frames show the picture around a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchCoherence {
    /// Share, 0 … 1, of the parts' squared D that their mean has, both without noise.
    pub coherence: f32,
    /// Excess of the differences between the parts over those that noise makes, in standard deviations.
    pub excess_sigmas: f32,
    /// Squared D of the mean over the noise's, less the noise's share.
    pub strength: f32,
    /// Direction (u, v), of length 1, along which the mean changes least.
    pub flattest: [f32; 2],
}

const PARTS: usize = 3;
/// Places to each side of the feature, their distance, and the σ of their weights, in σ of the feature.
const HALF: usize = 3;
const STEP_SIGMAS: f64 = 0.8;
const WINDOW_SIGMAS: f32 = 2.0;
/// Number of neighbouring places, about, that have the same noise.
const ALIKE: f32 = 2.0;
/// Error of D in a burst without noise.
const ROUNDING: f32 = 1e-6;

impl Along<'_> {
    /// Coherence of the picture around `place` (input pixels, at mid-burst) at `scale` and `slope`; `None` where fewer
    /// than two frames show it.
    pub fn patch_coherence(&self, scale: Scale, place: (f32, f32), slope: Slope) -> Option<PatchCoherence> {
        let (shown, frames) = (self.showing(place, slope), self.of(scale.octave));
        let sigma = self.inputs.space.sigma_octave(f64::from(scale.level));
        let step = ((STEP_SIGMAS * sigma).round() as usize).max(1);
        let count = shown.len().min(PARTS);
        // D over the noise of one frame, with the number of frames: parts of more of them count for more.
        let part = |index: usize| {
            let chosen = &shown[index * shown.len() / count..(index + 1) * shown.len() / count];
            let (planes, offsets) = frames.chosen(slope, chosen);
            let [d] = &frames.responses(&planes, &offsets, scale.level..scale.level + 1, place, (HALF, step))[..]
            else {
                unreachable!("one level");
            };
            let of_one = self.sigma_d_at(scale, (place, slope), chosen) * (chosen.len() as f32).sqrt();
            (chosen.len() as f32, d.iter().map(|d| d / of_one.max(ROUNDING)).collect::<Vec<f32>>())
        };
        let parts: Vec<(f32, Vec<f32>)> = (0..count).map(part).collect();
        (count > 1).then(|| compared(&parts, step as f32 / sigma as f32))
    }
}

/// Compares `parts`, each D over its noise on a lattice of steps of `step` σ, with its number of frames. Parts that
/// differ in strength alone, as brightness changes, are alike.
fn compared(parts: &[(f32, Vec<f32>)], step: f32) -> PatchCoherence {
    let (side, half) = (2 * HALF + 1, HALF as f32);
    let frames: f32 = parts.iter().map(|(count, _)| count).sum();
    let mean_at = |at: usize| parts.iter().map(|(count, d)| count * d[at]).sum::<f32>() / frames;
    let mean: Vec<f32> = (0..side * side).map(mean_at).collect();
    let weight = |at: usize| {
        let distance = step * ((at % side) as f32 - half).hypot((at / side) as f32 - half);
        (-0.5 * (distance / WINDOW_SIGMAS).powi(2)).exp()
    };
    let weights: Vec<f32> = (0..side * side).map(weight).collect();
    let product = |a: &[f32], b: &[f32]| -> f32 { a.iter().zip(b).zip(&weights).map(|((a, b), w)| a * b * w).sum() };
    let (sum, squares): (f32, f32) = (weights.iter().sum(), weights.iter().map(|w| w * w).sum());
    let of_all: f32 = parts.iter().map(|(count, d)| count * product(d, d)).sum();
    let as_mean = |(count, d): &(f32, Vec<f32>)| count * product(d, &mean).powi(2);
    let of_mean = parts.iter().map(as_mean).sum::<f32>() / product(&mean, &mean).max(f32::MIN_POSITIVE);
    let free = parts.len() as f32 - 1.0;
    let (strength, excess) = (of_mean - sum, of_all - of_mean - free * (sum - ALIKE * squares / sum));
    // The structure tensor: D changes least across the steepest direction.
    let inner = (1..side - 1).flat_map(|row| (1..side - 1).map(move |column| row * side + column));
    let [mut uu, mut uv, mut vv] = [0.0f32; 3];
    for at in inner {
        let (du, dv) = (mean[at + 1] - mean[at - 1], mean[at + side] - mean[at - side]);
        [uu, uv, vv] = [uu + weights[at] * du * du, uv + weights[at] * du * dv, vv + weights[at] * dv * dv];
    }
    let steepest = 0.5 * (2.0 * uv).atan2(uu - vv);
    PatchCoherence {
        coherence: (strength / (strength + excess).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0),
        excess_sigmas: excess / (2.0 * ALIKE * free * squares).sqrt(),
        strength,
        flattest: [-steepest.sin(), steepest.cos()],
    }
}
