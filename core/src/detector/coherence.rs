//! Coherence of a feature: how alike the single frames respond along its motion.
//!
//! A true feature is in every frame: the responses are level. A ghost (a blob of another motion that shows in the stack
//! of a wrong slope) responds only in frames in which the true blob crosses its path: its responses form a bump.

use crate::burst::Offset;
use crate::detector::along::Along;
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

/// Pixel in whose columns and rows `place` lies, inside an image of `size`.
pub(super) fn floor_pixel(place: (f32, f32), size: (usize, usize)) -> (usize, usize) {
    let pixel = |x: f32, n: usize| (x.max(0.0) as usize).min(n - 1);
    (pixel(place.0, size.0), pixel(place.1, size.1))
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
