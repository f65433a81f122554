//! Values of single frames along the motion of a feature: the response of each with its noise (its share), and slices.
//!
//! A true feature is in every frame: the responses are level. A ghost — a blob of another motion that shows in the
//! stack of a wrong slope — responds only in the frames in which the true blob crosses its path, so its responses form
//! a bump. Whether two keypoints at one place are different is decided by the search itself, from the frames in which
//! their paths are apart (`two_motions`); the number here is only for information.
//!
//! A slice is taken along a line of pixels and has one row for each frame (the epipolar-plane image, *Reslice* in
//! ImageJ). Content that moves along the line is slanted in it.

use crate::detector::{Feature, Slope, Trail};
use crate::monitor::{Cancelled, Monitor, Stage};
use crate::plane::Plane;
use crate::plane::sample::{bilinear, sample_patch};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Response of one frame along a feature's motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameShare {
    /// Index of the frame in the burst.
    pub frame: usize,
    /// Position of the feature in the frame, input pixels.
    pub pos_frame: [f32; 2],
    /// Whether the frame shows the place and was used.
    pub covers: bool,
    /// D of this frame alone, fraction of full scale.
    pub value: f32,
    /// Noise of that D.
    pub sigma_d: f32,
    /// Pixels around the position; NaN beyond the frame.
    #[serde(skip)]
    pub patch: Plane,
}

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

/// Shares of all frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shares {
    /// Octave of the responses.
    pub octave: i32,
    /// DoG level.
    pub level: i32,
    /// (u, v) at mid-burst, input pixels.
    pub pos_image: [f32; 2],
    /// Slope of the motion, px/frame.
    pub slope: Slope,
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Shares of the frames, in time order.
    pub frames: Vec<FrameShare>,
    /// Mean of the responses: D of the stack.
    pub mean: f32,
    /// Coherence, 0 … 1: the square of the mean over the mean square, both without the contribution of noise. 1 when
    /// all frames respond equally; m when only a part m of the frames responds. `None` where single frames are too
    /// noisy to tell.
    pub coherence: Option<f32>,
    /// Excess of the responses' spread over that of noise, in standard deviations.
    pub unevenness: f32,
    /// Pattern that follows from these.
    pub shape: Shape,
    /// Interpretation as a sentence.
    pub meaning: String,
    /// Side of a patch, input pixels.
    pub patch_px: f32,
}

/// Number of samples along a side of a patch.
const PATCH_SIDE: usize = 33;
/// Distance from the centre of a patch to its sides, in σ.
const PATCH_SIGMAS: f32 = 4.0;
/// Unevenness, in standard deviations, above which the responses differ.
const UNEVEN: f32 = 3.0;
/// Coherence below which uneven responses may be a bump.
const BUMP_COHERENCE: f32 = 0.6;
/// Share of the largest smoothed response from which a frame counts as responding.
const ANSWERS: f32 = 0.5;

/// Computes the shares of all frames at `octave` and `level`, along the motion through `place` (input pixels, at
/// mid-burst) at `slope`.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn shares(
    trail: &Trail,
    (octave, level): (i32, i32),
    place: [f32; 2],
    slope: Slope,
    monitor: &Monitor,
) -> Result<Shares, Cancelled> {
    let (planes, ..) = trail.frames();
    let sigma = trail.space().sigma_image(octave, f64::from(level)) as f32;
    let half_px = PATCH_SIGMAS * sigma;
    let answers = answers(trail, (octave, level), place, slope, monitor)?;
    let share = |(plane, &answer): (&Arc<Plane>, &FrameAnswer)| {
        let FrameAnswer { frame, pos_frame, covers, value, sigma_d } = answer;
        let patch = sample_patch(plane, (pos_frame[0], pos_frame[1]), half_px, PATCH_SIDE);
        FrameShare { frame, pos_frame, covers, value, sigma_d, patch }
    };
    let frames: Vec<FrameShare> = planes.iter().zip(&answers).map(share).collect();
    monitor.check()?;
    let Evenness { mean, coherence, unevenness, shape } = evenness_of(&answers);
    let meaning = meaning(&frames, shape, coherence);
    Ok(Shares {
        octave,
        level,
        pos_image: place,
        slope,
        sigma,
        frames,
        mean,
        coherence,
        unevenness,
        shape,
        meaning,
        patch_px: 2.0 * half_px,
    })
}

/// Computes the coherence (see [`Shares::coherence`]) of each feature of the detection of `trail`: for each the value
/// from [`shares`] at its octave and level, along its motion.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub fn coherences(trail: &Trail, monitor: &Monitor) -> Result<Vec<Option<f32>>, Cancelled> {
    let features = &trail.detection().features;
    let done = AtomicUsize::new(0);
    monitor.report(Stage::Frames, 0.0);
    let coherence = |feature: &Feature| {
        let (scale, place) = ((feature.octave, feature.level), [feature.u, feature.v]);
        let answers = answers(trail, scale, place, feature.slope, monitor)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        monitor.report(Stage::Frames, done as f32 / features.len() as f32);
        Ok(evenness_of(&answers).coherence)
    };
    features.par_iter().map(coherence).collect()
}

/// Response of one frame along a motion.
#[derive(Debug, Clone, Copy)]
struct FrameAnswer {
    frame: usize,
    pos_frame: [f32; 2],
    covers: bool,
    value: f32,
    sigma_d: f32,
}

/// The response of each frame at a scale, along the motion through `place` at `slope`, in time order.
fn answers(
    trail: &Trail,
    scale: (i32, i32),
    place: [f32; 2],
    slope: Slope,
    monitor: &Monitor,
) -> Result<Vec<FrameAnswer>, Cancelled> {
    let (_, kept, frame_count) = trail.frames();
    let t0 = 0.5 * (frame_count as f32 - 1.0);
    let first_frame = trail.detection().frames_used.start;
    let size = trail.size_image();
    let offsets = trail.offsets(slope);
    let pixel = |x: f32, n: usize| (x.round().max(0.0) as usize).min(n - 1);
    let at = (pixel(place[0], size.0), pixel(place[1], size.1));
    let (octave, level) = scale;
    let way = ((place[0], place[1]), slope);
    let answer = |(index, &t): (usize, &usize)| {
        monitor.check()?;
        let dt = t as f32 - t0;
        let covers = offsets[index].covers(at.0, at.1, size);
        let value = if covers { trail.point_response((octave, level..level + 1), way, &[index])[0] } else { f32::NAN };
        Ok(FrameAnswer {
            frame: first_frame + t,
            pos_frame: [place[0] + dt * slope.u, place[1] + dt * slope.v],
            covers,
            value,
            sigma_d: trail.sigma_d_at(scale, way, &[index]),
        })
    };
    kept.iter().enumerate().map(answer).collect()
}

/// The evenness of the responses of the frames that show the place.
fn evenness_of(answers: &[FrameAnswer]) -> Evenness {
    evenness(&answers.iter().filter(|answer| answer.covers).map(|a| (a.value, a.sigma_d)).collect::<Vec<_>>())
}

/// Evenness of responses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evenness {
    /// Mean of the responses.
    pub mean: f32,
    /// See [`Shares::coherence`].
    pub coherence: Option<f32>,
    /// See [`Shares::unevenness`].
    pub unevenness: f32,
    /// See [`Shares::shape`].
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
    let (of_mean, of_all) = (mean * mean - noise / n, square - noise);
    // The mean square is known to about √(2/n) of the noise's; below twice that there is too little to compare.
    let is_seen = of_all > 2.0 * (2.0 / n).sqrt() * noise && of_all > 0.0;
    let coherence = is_seen.then(|| (of_mean / of_all).clamp(0.0, 1.0) as f32);
    let free = n - 1.0;
    let unevenness = match () {
        () if free < 1.0 => 0.0,
        () if noise <= 0.0 => {
            // Without noise only rounding remains: differences of a thousandth do not count.
            let spread = ((square - mean * mean).max(0.0)).sqrt();
            if spread > 1e-3 * mean.abs() { f64::from(UNEVEN) * (spread / (0.3 * mean.abs().max(1e-30))) } else { 0.0 }
        }
        () => {
            let chi2: f64 = answers.iter().map(|a| ((value(a) - mean) / f64::from(a.1).max(1e-30)).powi(2)).sum();
            (chi2 - free) / (2.0 * free).sqrt()
        }
    };
    let uneven = unevenness > f64::from(UNEVEN);
    let shape = match coherence {
        _ if answers.len() < 3 => Shape::Unclear,
        Some(coherence) if uneven && coherence < BUMP_COHERENCE && is_one_bump(answers) => Shape::Bump,
        _ if uneven => Shape::Uneven,
        Some(_) => Shape::Level,
        None => Shape::Unclear,
    };
    Evenness { mean: mean as f32, coherence, unevenness: unevenness as f32, shape }
}

/// Whether the frames that respond lie next to each other and are not all.
fn is_one_bump(answers: &[(f32, f32)]) -> bool {
    let smooth: Vec<f32> = answering(answers);
    let max = smooth.iter().copied().fold(0.0, f32::max);
    let on: Vec<bool> = smooth.iter().map(|&x| x >= ANSWERS * max).collect();
    let starts = (0..on.len()).filter(|&i| on[i] && (i == 0 || !on[i - 1])).count();
    max > 0.0 && starts == 1 && on.iter().any(|&x| !x)
}

/// The responses with the sign of their mean, each averaged with its neighbours.
fn answering(answers: &[(f32, f32)]) -> Vec<f32> {
    let sign = answers.iter().map(|a| a.0).sum::<f32>().signum();
    let at = |i: i64| answers[i.clamp(0, answers.len() as i64 - 1) as usize].0;
    (0..answers.len() as i64).map(|i| sign * (0.25 * at(i - 1) + 0.5 * at(i) + 0.25 * at(i + 1))).collect()
}

fn meaning(frames: &[FrameShare], shape: Shape, coherence: Option<f32>) -> String {
    let number = coherence.map_or_else(String::new, |c| format!("coherence {c:.2}: "));
    let covering: Vec<&FrameShare> = frames.iter().filter(|f| f.covers).collect();
    match shape {
        Shape::Level => format!("{number}all frames respond alike, as for an object with this motion"),
        Shape::Uneven => format!("{number}the frames differ by more than their noise, but no part of them stands out"),
        Shape::Bump => {
            let answers: Vec<(f32, f32)> = covering.iter().map(|f| (f.value, f.sigma_d)).collect();
            let smooth = answering(&answers);
            let max = smooth.iter().copied().fold(0.0, f32::max);
            let on: Vec<usize> =
                (0..smooth.len()).filter(|&i| smooth[i] >= ANSWERS * max).map(|i| covering[i].frame).collect();
            let (first, last) = (on.first().copied().unwrap_or(0), on.last().copied().unwrap_or(0));
            let which = if first == last {
                format!("frame {first} responds")
            } else {
                format!("frames {first} to {last} respond")
            };
            format!("{number}only {which}, as for a ghost: an object with another motion crosses here")
        }
        Shape::Unclear if covering.len() < 3 => "too few frames show the place to compare them".to_owned(),
        Shape::Unclear => "a single frame is too noisy here to compare the frames".to_owned(),
    }
}

/// A slice: columns are pixels along a direction, rows are frames in time order.
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    /// Values, fraction of full scale; NaN beyond a frame.
    pub plane: Plane,
    /// Column that goes through the place.
    pub centre_column: usize,
    /// Place, input pixels.
    pub pos_image: [f32; 2],
    /// Direction along u and v, of length 1; from one column to the next it is one pixel.
    pub direction: [f32; 2],
    /// Index in the burst of each row's frame.
    pub frames: Vec<usize>,
    /// Time of each row's frame minus mid-burst, frames.
    pub times: Vec<f32>,
}

impl Slice {
    /// The column in row `row` of content that moves at `slope` through the place at mid-burst; only the motion along
    /// this line counts.
    pub fn column_at(&self, slope: Slope, row: usize) -> f32 {
        let along = slope.u * self.direction[0] + slope.v * self.direction[1];
        self.centre_column as f32 + along * self.times[row]
    }
}

/// Cuts the slice through `place` (input pixels) along `direction` (u, v; of any length but 0), `half_px` pixels to
/// each side.
pub fn slice(trail: &Trail, place: [f32; 2], direction: [f32; 2], half_px: usize) -> Slice {
    let length = direction[0].hypot(direction[1]);
    let direction = if length > 0.0 { direction.map(|x| x / length) } else { [1.0, 0.0] };
    let (planes, kept, frame_count) = trail.frames();
    let t0 = 0.5 * (frame_count as f32 - 1.0);
    let at = |column: usize, row: usize| {
        let along = column as f32 - half_px as f32;
        let (u, v) = (place[0] + along * direction[0], place[1] + along * direction[1]);
        bilinear(&planes[row], u, v).unwrap_or(f32::NAN)
    };
    Slice {
        plane: Plane::from_fn(2 * half_px + 1, planes.len(), at),
        centre_column: half_px,
        pos_image: place,
        direction,
        frames: kept.iter().map(|t| t + trail.detection().frames_used.start).collect(),
        times: kept.iter().map(|&t| t as f32 - t0).collect(),
    }
}

/// The direction of a slope; to the right for slope 0.
pub fn direction_of(slope: Slope) -> [f32; 2] {
    let length = slope.magnitude();
    if length > 0.0 { [slope.u / length, slope.v / length] } else { [1.0, 0.0] }
}

/// The direction perpendicular to `direction`, a quarter turn from +u towards +v.
pub fn across([u, v]: [f32; 2]) -> [f32; 2] {
    [-v, u]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::random::Stream;
    use proptest::prelude::*;

    #[test]
    fn level_answers_are_coherent_and_a_bump_is_its_part() {
        let level: Vec<(f32, f32)> = vec![(-0.1, 0.0); 10];
        assert_eq!(evenness(&level).coherence, Some(1.0));
        assert_eq!(evenness(&level).shape, Shape::Level);
        // Three of ten respond: the coherence is 0.3.
        let bump: Vec<(f32, f32)> = (0..10).map(|t| (if (4..7).contains(&t) { 0.2 } else { 0.0 }, 0.005)).collect();
        let seen = evenness(&bump);
        assert!((seen.coherence.expect("clear") - 0.3).abs() < 0.02, "{seen:?}");
        assert_eq!(seen.shape, Shape::Bump);
        // Equal responses that are not side by side.
        let apart: Vec<(f32, f32)> = (0..10).map(|t| (if t % 4 == 1 { 0.2 } else { 0.0 }, 0.005)).collect();
        assert_eq!(evenness(&apart).shape, Shape::Uneven);
    }

    #[test]
    fn noise_alone_says_nothing_and_hides_nothing_strong() {
        let mut noise = Stream::new(4, 0);
        let (mut unclear, mut level) = (0, 0);
        for _ in 0..200 {
            let nothing: Vec<(f32, f32)> = (0..10).map(|_| (noise.normal() as f32, 1.0)).collect();
            unclear += usize::from(evenness(&nothing).shape == Shape::Unclear);
            let there: Vec<(f32, f32)> = (0..10).map(|_| (4.0 + noise.normal() as f32, 1.0)).collect();
            level += usize::from(evenness(&there).shape == Shape::Level);
        }
        assert!(unclear > 180 && level > 190, "{unclear} {level}");
    }

    proptest! {
        #[test]
        fn coherence_is_a_part_and_does_not_depend_on_sign_or_unit(
            values in prop::collection::vec(-1.0f32..1.0, 0..20), noise in 0.0f32..0.5, gain in 0.1f32..10.0,
        ) {
            let answers = |gain: f32| values.iter().map(|v| (gain * v, gain.abs() * noise)).collect::<Vec<_>>();
            let (a, b) = (evenness(&answers(1.0)), evenness(&answers(-gain)));
            prop_assert!(a.coherence.is_none_or(|c| (0.0..=1.0).contains(&c)));
            if let (Some(a), Some(b)) = (a.coherence, b.coherence) {
                prop_assert!((a - b).abs() < 1e-3);
            }
            prop_assert!(a.mean.is_finite() && a.unevenness.is_finite());
        }
    }
}
