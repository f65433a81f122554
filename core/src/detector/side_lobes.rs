//! Side lobes: what strong keypoints leave at other places, scales and slopes, where there is no blob of its own.
//!
//! A strong blob makes D non-zero all around it: a hollow of the opposite sign beside it, extrema on its rim, and traces
//! at slopes with which it does not move, where it is smeared. On dark charts these are most of the keypoints that are
//! no disc. So the test compares |D| of a keypoint with the spread of the stronger ones: the |D| of each times a bump of
//! its size, at the keypoint's place, averaged over the frames, because the two may move differently.
//!
//! Real scenes consist of structures beside stronger ones, which are found again in other bursts as well as any other.
//! There the test costs right matches (docs/MEASUREMENTS.md), so it is off unless it is asked for.

use crate::detector::feature::Keypoint;
use crate::detector::params::slope_grid::Slope;
use crate::monitor::{Cancelled, Monitor};
use rayon::prelude::*;

/// Noise that may add to a side lobe, in standard deviations of D.
const NOISE: f32 = 2.0;
/// Radius within which a blob spreads all of its |D|, in its σ; beyond it the spread falls as a Gaussian.
const FLAT_RADIUS: f32 = 1.5;
/// Distance from that radius beyond which nothing is left, in standard deviations of the Gaussian.
const CUT: f32 = 4.0;

/// A keypoint as the test sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Blob {
    /// Column and row at mid-burst, input pixels.
    place: [f32; 2],
    /// Scale, input pixels; above 0.
    sigma: f32,
    slope: Slope,
    /// |D|, fraction of full scale.
    magnitude: f32,
}

impl Blob {
    fn of(keypoint: &Keypoint) -> Self {
        let (u, v, sigma) = keypoint.in_image();
        Self { place: [u, v], sigma, slope: keypoint.slope, magnitude: keypoint.value.abs() }
    }

    /// |D| that this blob leaves at `other`'s place, scale and slope; `dts` are the frames' times from mid-burst, in order.
    fn spread_to(&self, other: &Self, dts: &[f32]) -> f32 {
        let apart = [other.place[0] - self.place[0], other.place[1] - self.place[1]];
        let moves = [other.slope.u - self.slope.u, other.slope.v - self.slope.v];
        let variance = self.sigma * self.sigma + other.sigma * other.sigma;
        let (flat, width) = (FLAT_RADIUS * self.sigma, variance.sqrt());
        let distance_at = |dt: f32| {
            let [du, dv] = [0, 1].map(|axis| apart[axis] + dt * moves[axis]);
            (du * du + dv * dv).sqrt()
        };
        // Most pairs never come near each other.
        let speed_squared = moves[0] * moves[0] + moves[1] * moves[1];
        let nearest_dt = -(apart[0] * moves[0] + apart[1] * moves[1]) / speed_squared.max(f32::MIN_POSITIVE);
        let (first, last) = (dts[0], dts[dts.len() - 1]);
        if distance_at(nearest_dt.clamp(first, last)) - flat >= 1.01 * CUT * width {
            return 0.0;
        }
        let bump = |dt: &f32| {
            let at = (distance_at(*dt) - flat).max(0.0) / width;
            if at < CUT { (-0.5 * at * at).exp() } else { 0.0 }
        };
        // D of a blob falls with the square of the scale at scales beyond its own.
        let scale = (self.sigma / other.sigma).min(1.0).powi(2);
        self.magnitude * scale * dts.iter().map(bump).sum::<f32>() / dts.len() as f32
    }
}

/// Blobs of one octave of scales, by row.
struct Class {
    /// Largest scale, input pixels.
    sigma_max: f32,
    blobs: Vec<Blob>,
}

/// Limits below which |D| of each of `keypoints` is a side lobe of the stronger ones: `part` of their spread, and twice
/// the noise. `dts` are the times of the frames from mid-burst, in frames and in order; at least one.
///
/// # Errors
/// [`Cancelled`] once `monitor` was cancelled.
pub(super) fn limits(
    keypoints: &[&Keypoint],
    part: f32,
    dts: &[f32],
    monitor: &Monitor,
) -> Result<Vec<f32>, Cancelled> {
    let blobs: Vec<Blob> = keypoints.iter().map(|keypoint| Blob::of(keypoint)).collect();
    let mut classes: Vec<(i32, Class)> = Vec::new();
    for blob in &blobs {
        let octave = blob.sigma.log2().floor() as i32;
        let at = classes.iter().position(|(of, _)| *of == octave).unwrap_or_else(|| {
            classes.push((octave, Class { sigma_max: 0.0, blobs: Vec::new() }));
            classes.len() - 1
        });
        let class = &mut classes[at].1;
        class.sigma_max = class.sigma_max.max(blob.sigma);
        class.blobs.push(*blob);
    }
    classes.iter_mut().for_each(|(_, class)| class.blobs.sort_by(|a, b| a.place[1].total_cmp(&b.place[1])));
    let slopes_v = || blobs.iter().map(|blob| blob.slope.v);
    let range_v = slopes_v().fold(0.0, f32::max) - slopes_v().fold(0.0, f32::min);
    let moved = range_v * dts.iter().fold(0.0, |max: f32, dt| max.max(dt.abs()));
    let spread = |blob: &Blob| {
        monitor.check()?;
        let of_class = |(_, class): &(i32, Class)| -> f32 {
            let reach = FLAT_RADIUS * class.sigma_max + CUT * class.sigma_max.hypot(blob.sigma) + moved;
            let first = class.blobs.partition_point(|other| other.place[1] < blob.place[1] - reach);
            let near = class.blobs[first..].iter().take_while(|other| other.place[1] <= blob.place[1] + reach);
            near.filter(|other| other.magnitude > blob.magnitude).map(|other| other.spread_to(blob, dts)).sum()
        };
        Ok(classes.iter().map(of_class).sum())
    };
    let spread: Vec<f32> = blobs.par_iter().with_min_len(16).map(spread).collect::<Result<_, Cancelled>>()?;
    let limit = |(keypoint, spread): (&&Keypoint, f32)| part * spread + NOISE * noise(keypoint);
    Ok(keypoints.iter().zip(spread).map(limit).collect())
}

/// Standard deviation of the noise in D of a keypoint.
fn noise(keypoint: &Keypoint) -> f32 {
    keypoint.value.abs() / keypoint.snr
}

/// Part of the spread at which `keypoint`, whose limit at `part` is `limit`, is a side lobe no more; 0 or less where its
/// |D| is within the noise.
pub fn passing_part(keypoint: &Keypoint, limit: f32, part: f32) -> f32 {
    let noise = NOISE * noise(keypoint);
    part * (keypoint.value.abs() - noise) / (limit - noise)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keypoint((x, sigma): (f32, f32), slope_u: f32, value: f32) -> Keypoint {
        Keypoint {
            octave: 0,
            x,
            y: 50.0,
            sigma_octave: sigma,
            level: 0,
            sample: [x as u32, 50],
            slope_index: 0,
            slope: Slope { u: slope_u, v: 0.0 },
            value,
            snr: value.abs() / 0.001,
        }
    }

    fn limits_of(keypoints: &[Keypoint]) -> Vec<f32> {
        let dts: Vec<f32> = (0..9).map(|t| t as f32 - 4.0).collect();
        limits(&keypoints.iter().collect::<Vec<_>>(), 0.5, &dts, &Monitor::default()).expect("nobody cancels it")
    }

    #[test]
    fn only_stronger_keypoints_spread_and_less_farther_away() {
        let strong = keypoint((50.0, 4.0), 0.0, -0.1);
        let limits = limits_of(&[
            strong,
            keypoint((58.0, 4.0), 0.0, 0.02),
            keypoint((66.0, 4.0), 0.0, 0.019),
            keypoint((300.0, 4.0), 0.0, 0.01),
        ]);
        let noise = NOISE * 0.001;
        assert!((limits[0] - noise).abs() < 1e-6 && (limits[3] - noise).abs() < 1e-6, "{limits:?}");
        // 2 px beyond the flat part of 6 px: nearly all of it.
        assert!((limits[1] - noise - 0.5 * 0.1 * (-0.5 * 4.0 / 32.0f32).exp()).abs() < 2e-3, "{limits:?}");
        assert!(limits[2] < limits[1] && limits[2] > noise, "{limits:?}");
    }

    #[test]
    fn what_moves_differently_spreads_only_to_the_frames_that_it_passes() {
        let limit = |slope_u: f32, x: f32| {
            limits_of(&[keypoint((50.0, 2.0), 0.0, -0.1), keypoint((x, 2.0), slope_u, -0.01)])[1] - NOISE * 0.001
        };
        assert!((limit(0.0, 50.0) - 0.05).abs() < 1e-6);
        assert!(limit(3.0, 50.0) < 0.7 * limit(0.0, 50.0));
        // 12 px away at mid-burst, and there in the first frame.
        assert!(limit(3.0, 62.0) > 10.0 * limit(0.0, 62.0).max(1e-4));
    }

    #[test]
    fn a_keypoint_passes_just_below_its_part() {
        let all = [keypoint((50.0, 4.0), 0.0, -0.1), keypoint((58.0, 4.0), 0.0, 0.02)];
        let part = passing_part(&all[1], limits_of(&all)[1], 0.5);
        let dts = [0.0];
        let limit = |part| limits(&[&all[0], &all[1]], part, &dts, &Monitor::default()).expect("nobody cancels it")[1];
        assert!(limit(0.99 * part) < 0.02 && limit(1.01 * part) > 0.02);
    }
}
