//! More frames, longer exposure or slower motion by which nine of ten candidates like one below the gate would pass.
//!
//! The noise of the mean of n frames falls with √n. With e times the exposure the signal grows e times, shot noise with
//! √e, and read noise stays; the measured variance over brightness says which decides. A thing of 1/e of the speed
//! allows an exposure e times as long with as much motion in a frame.

use super::fate::{Fate, Outcome};
use super::remedy::LEAST_GATE;
use crate::detector::{Test, Trail};
use crate::inspect::words::{counted, number};
use crate::plane::sample::bilinear;
use serde::Serialize;

/// Added to the gate, in σ, so that nine of ten pass.
const NINE_OF_TEN: f64 = 1.2816;
/// Half the side, pixels, of the square whose mean is the brightness of the place.
const AROUND_PX: i32 = 4;
const MAX_FACTOR: f64 = 1000.0;

/// Changes in the world that would keep a candidate that fails the noise gate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Needed {
    /// Factor by which its SNR in D must grow.
    pub factor: f64,
    /// Number of frames that show it now.
    pub frames_now: usize,
    /// Frames needed at this motion; `None` where the candidate leaves the picture before.
    pub frames: Option<usize>,
    /// Number of frames for which it stays in the picture at this motion; `None` where it does not move.
    pub frames_inside: Option<usize>,
    /// Factor of the exposure that it takes; `None` where the place would be brighter than white, or is dark.
    pub exposure: Option<f64>,
    /// Part of the variance at the place that is shot noise, 0 … 1; `None` where the noise model does not tell.
    pub shot_part: Option<f64>,
    /// Part of the speed at which it passes with as much longer exposures; `None` where that does not help.
    pub speed: Option<f64>,
    /// A sentence without a full stop.
    pub sentence: String,
}

/// The changes that a candidate needs; `None` unless the noise gate is the first test that it fails, and where it is so
/// weak that it is hardly more than noise.
pub fn needed(trail: &Trail, fate: &Fate) -> Option<Needed> {
    let report = fate.report(Test::NoiseGate);
    let (value, limit) = (report.value?, report.limit?);
    if fate.first_failed != Some(Test::NoiseGate) || report.outcome != Outcome::Fails || value < LEAST_GATE {
        return None;
    }
    let factor = (limit + NINE_OF_TEN) / value;
    let frames_now = trail.showing(fate.pos_image.into(), fate.slope).len().max(1);
    let frames_inside = frames_inside(trail, fate);
    let needed = frames_needed(frames_now, factor);
    let frames = needed.filter(|needed| frames_inside.is_none_or(|inside| *needed <= inside));
    let brightness = brightness(trail, fate);
    let transfer = &trail.noise().transfer;
    let is_measured = !transfer.points.is_empty();
    let (shot, read) = (f64::from(transfer.slope) * brightness.max(0.0), f64::from(transfer.dark).max(0.0));
    let shot_part = (is_measured && shot + read > 0.0).then(|| shot / (shot + read));
    // Where the model does not tell, shot noise, which needs more.
    let exposure = exposure_needed(shot_part.unwrap_or(1.0), factor);
    let exposure = Some(exposure).filter(|exposure| *exposure <= MAX_FACTOR && brightness * exposure <= 1.0);
    let speed = exposure.filter(|_| fate.slope.magnitude() > 1e-3).map(|exposure| 1.0 / exposure);
    let mut out =
        Needed { factor, frames_now, frames, frames_inside, exposure, shot_part, speed, sentence: String::new() };
    out.sentence = sentence(&out, needed);
    Some(out)
}

/// Number of frames for an SNR that is `factor` times that of `now` frames; `None` beyond any burst.
pub fn frames_needed(now: usize, factor: f64) -> Option<usize> {
    let needed = (now as f64 * factor * factor).ceil();
    (needed.is_finite() && factor <= MAX_FACTOR).then_some((needed as usize).max(2))
}

/// Factor of the exposure for an SNR `factor` times as large, where `shot_part` of the variance is shot noise: the
/// solution of e/√(s·e + 1 − s) = f.
fn exposure_needed(shot_part: f64, factor: f64) -> f64 {
    let (s, f2) = (shot_part.clamp(0.0, 1.0), factor * factor);
    0.5 * (f2 * s + (f2 * f2 * s * s + 4.0 * f2 * (1.0 - s)).sqrt())
}

/// Number of frames for which a candidate is inside the picture, if the burst went on at both ends.
fn frames_inside(trail: &Trail, fate: &Fate) -> Option<usize> {
    let (width, height) = trail.size_image();
    let (_, _, positions) = trail.frames();
    let half = if positions.len().is_multiple_of(2) { 0.5 } else { 0.0 };
    // Time until an edge is reached, in frames, forwards and backwards.
    let until = |sign: f32| {
        let along = |x: f32, slope: f32, n: usize| match sign * slope {
            slope if slope > 0.0 => ((n - 1) as f32 - x) / slope,
            slope if slope < 0.0 => x / -slope,
            _ => f32::INFINITY,
        };
        along(fate.pos_image[0], fate.slope.u, width).min(along(fate.pos_image[1], fate.slope.v, height)).max(0.0)
    };
    let [forwards, backwards] = [1.0, -1.0].map(until);
    if forwards.is_infinite() || backwards.is_infinite() {
        return None;
    }
    let frames = |time: f32| if time < half { 0.0 } else { (time - half).floor() + 1.0 };
    let twice = if half == 0.0 { 1.0 } else { 0.0 };
    Some((frames(forwards) + frames(backwards) - twice).max(1.0) as usize)
}

/// Mean brightness around a candidate in the middle frame, fraction of full scale.
fn brightness(trail: &Trail, fate: &Fate) -> f64 {
    let (planes, ..) = trail.frames();
    let Some(frame) = planes.get(planes.len() / 2) else { return 0.0 };
    let offsets = || -AROUND_PX..=AROUND_PX;
    let at = |(du, dv): (i32, i32)| bilinear(frame, fate.pos_image[0] + du as f32, fate.pos_image[1] + dv as f32);
    let values: Vec<f32> =
        offsets().flat_map(|dv| offsets().map(move |du| (du, dv))).filter_map(at).filter(|x| x.is_finite()).collect();
    values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len().max(1) as f64
}

fn sentence(outlook: &Needed, needed: Option<usize>) -> String {
    let mut ways = Vec::new();
    let inside = outlook.frames_inside;
    let mut not = String::new();
    match (outlook.frames, needed, inside) {
        (Some(frames), _, Some(inside)) => {
            let frames = counted(frames, "frame");
            ways.push(format!("with {frames} at this motion (it stays in the picture for {inside})"));
        }
        (Some(frames), _, None) => ways.push(format!("with {}", counted(frames, "frame"))),
        (None, Some(needed), Some(inside)) => {
            not = format!("; not with more frames, because it takes {needed} and stays in the picture for {inside}");
        }
        _ => {}
    }
    if let Some(exposure) = outlook.exposure {
        let why = match outlook.shot_part {
            Some(part) if part > 0.7 => " (shot noise decides)",
            Some(part) if part < 0.3 => " (read noise decides)",
            _ => "",
        };
        ways.push(format!("with {} times the exposure{why}", number(exposure as f32, 2)));
    }
    let slower = |speed| format!("at {} of the speed with as much longer exposures", number(speed as f32, 2));
    ways.extend(outlook.speed.map(slower));
    if ways.is_empty() {
        return format!("neither more frames nor a longer exposure helps{not}");
    }
    format!("9 of 10 like it pass {}{not}", ways.join(", or "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn read_noise_needs_less_exposure_than_shot_noise() {
        assert!((exposure_needed(0.0, 1.4) - 1.4).abs() < 1e-12);
        assert!((exposure_needed(1.0, 1.4) - 1.96).abs() < 1e-12);
        let between = exposure_needed(0.5, 1.4);
        assert!((between / (0.5 * between + 0.5).sqrt() - 1.4).abs() < 1e-12);
        assert_eq!((frames_needed(10, 1.2), frames_needed(10, 1e9)), (Some(15), None));
    }
}
