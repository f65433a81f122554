//! Photon transfer of a sensor: the variance of the noise over brightness, variance = a·I + b.
//!
//! Light comes in photons, whose number varies by its square root, so the variance of a pixel grows in proportion to
//! its brightness I; reading it out adds b. The squares of the frames are sorted by brightness into groups; the quiet
//! part of a group gives its variance, even if texture moves through some of its squares. A line is fitted to the
//! groups: first with the median slope between any two (Theil–Sen), then by iteratively reweighted least squares, in
//! which a group counts by its relative error and not at all far from the line, so that groups whose noise is cut off
//! at white or black do not bend it.

use super::high_pass::quiet_variance;
use serde::Serialize;

/// Variance over brightness.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PhotonTransfer {
    /// a: variance per brightness, fraction of full scale; the inverse of the number of electrons at full scale for a
    /// sensor without offset. At least 0.
    pub slope: f32,
    /// b: variance at brightness 0, in (fraction of full scale)²; negative where black is lifted by more than the read
    /// noise amounts to.
    pub dark: f32,
    /// Lower bound of the variance, in (fraction of full scale)².
    pub min: f32,
    /// Points to which the line was fitted, from dark to bright.
    pub points: Vec<TransferPoint>,
}

/// Group of squares of about equal brightness.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TransferPoint {
    /// Mean brightness, fraction of full scale.
    pub brightness: f32,
    /// Variance of the noise of one frame, in (fraction of full scale)².
    pub variance: f32,
    /// Number of squares.
    pub squares: usize,
}

/// Minimum number of squares of a group.
const LEAST_SQUARES: usize = 24;
/// Maximum number of groups.
const MAX_GROUPS: usize = 16;
/// Relative distance from the line beyond which a group does not count.
const FAR: f64 = 0.4;
/// Minimum difference between the darkest and the brightest group, in standard deviations of a square's brightness;
/// groups of one brightness, sorted by their noise, differ by four.
const LEAST_SPAN: f64 = 7.0;
/// Number of iterations of the fit.
const FITS: usize = 12;

impl PhotonTransfer {
    /// Fits squares of brightness `squares[i].0`, the mean of `pixels` values, and variance `squares[i].1`, from `free`
    /// independent values. All 0 without squares.
    pub fn fit(squares: &[(f32, f32)], pixels: usize, free: f32) -> Self {
        let mut sorted = squares.to_vec();
        sorted.sort_by(|x, y| x.0.total_cmp(&y.0));
        let groups = (sorted.len() / LEAST_SQUARES).clamp(1, MAX_GROUPS);
        let points: Vec<TransferPoint> = (0..groups)
            .map(|g| &sorted[g * sorted.len() / groups..(g + 1) * sorted.len() / groups])
            .filter(|group| !group.is_empty())
            .map(|group| TransferPoint {
                brightness: group.iter().map(|s| s.0).sum::<f32>() / group.len() as f32,
                variance: variance_of(group, free),
                squares: group.len(),
            })
            .collect();
        let (slope, dark) = line(&points, pixels, free);
        let min = 0.5 * points.iter().map(|p| p.variance).reduce(f32::min).unwrap_or(0.0);
        Self { slope, dark, min, points }
    }

    /// Variance of the noise of one frame at brightness `brightness`.
    pub fn variance(&self, brightness: f32) -> f32 {
        (self.slope * brightness + self.dark).max(self.min)
    }
}

/// Variance of the quiet part of a group; where that is 0, as in files that round it away nearly everywhere, the mean.
fn variance_of(group: &[(f32, f32)], free: f32) -> f32 {
    let quiet = quiet_variance(group.iter().map(|s| s.1).collect(), free);
    if quiet > 0.0 { quiet } else { group.iter().map(|s| s.1).sum::<f32>() / group.len() as f32 }
}

/// Slope and offset of the line through the points; the slope is 0 where it is less than three times its error, or the
/// brightness does not differ by more than its noise.
fn line(points: &[TransferPoint], pixels: usize, free: f32) -> (f32, f32) {
    let total = points.iter().map(|p| p.squares).sum::<usize>() as f64;
    let mean = points.iter().map(|p| f64::from(p.variance) * p.squares as f64).sum::<f64>() / total.max(1.0);
    if mean <= 0.0 {
        return (0.0, 0.0);
    }
    let floor = 1e-3 * mean;
    let span = points[points.len() - 1].brightness - points[0].brightness;
    if f64::from(span) < LEAST_SPAN * (mean / pixels as f64).sqrt() {
        return (0.0, mean as f32);
    }
    let (mut a, mut b) = median_line(points);
    let mut error = f64::INFINITY;
    for _ in 0..FITS {
        let mut sums = [0.0f64; 5];
        for p in points {
            let (x, y) = (f64::from(p.brightness), f64::from(p.variance));
            let expected = (a * x + b).max(floor);
            let off = ((y / expected - 1.0) / FAR).abs().min(1.0);
            // In relative errors; that of a group of n squares is √(2/(free·n)).
            let weight = p.squares as f64 / (expected * expected) * (1.0 - off * off).powi(2);
            for (sum, term) in sums.iter_mut().zip([1.0, x, x * x, y, x * y]) {
                *sum += weight * term;
            }
        }
        let [n, x, xx, y, xy] = sums;
        if n <= 0.0 {
            break;
        }
        let across = xx - x * x / n;
        if across <= 1e-12 * xx {
            return (0.0, (y / n) as f32);
        }
        a = (xy - x * y / n) / across;
        b = (y - a * x) / n;
        if a < 0.0 {
            (a, b) = (0.0, y / n);
        }
        let off = |p: &TransferPoint| {
            let expected = (a * f64::from(p.brightness) + b).max(floor);
            p.squares as f64 * (f64::from(p.variance) / expected - 1.0).powi(2).min(FAR * FAR)
        };
        // The residual expected of noise alone, or the actual one if larger.
        let noise = 2.0 / (0.7 * f64::from(free));
        let left = points.iter().map(off).sum::<f64>() / (points.len() as f64 - 2.0).max(1.0);
        error = (noise.max(left) / across).sqrt();
    }
    if a < 3.0 * error {
        let weighted = points.iter().map(|p| p.squares as f64 * f64::from(p.variance)).sum::<f64>() / total;
        return (0.0, weighted as f32);
    }
    (a as f32, b as f32)
}

/// Slope and offset by the median slope between any two points, and the median offset for that slope.
fn median_line(points: &[TransferPoint]) -> (f64, f64) {
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let at = |p: &TransferPoint| (f64::from(p.brightness), f64::from(p.variance));
    let mut slopes = Vec::new();
    for (i, p) in points.iter().enumerate() {
        for q in &points[..i] {
            let ((x, y), (x0, y0)) = (at(p), at(q));
            if x > x0 {
                slopes.push((y - y0) / (x - x0));
            }
        }
    }
    let a = middle(slopes).max(0.0);
    (a, middle(points.iter().map(|p| at(p).1 - a * at(p).0).collect()))
}

#[cfg(test)]
mod tests {
    use super::super::high_pass::{FREE_VALUES, HighPass};
    use super::*;
    use crate::monitor::Monitor;
    use crate::plane::Plane;
    use crate::synth::Camera;
    use crate::synth::random::Stream;

    /// Brightness and variance of the squares of a sensor's frames of `signal`.
    fn squares(camera: &Camera, signal: &Plane) -> Vec<(f32, f32)> {
        let frames: Vec<Plane> = (1..=3)
            .map(|t| camera.capture(signal, &mut Stream::new(9, t), &Monitor::default()).expect("not cancelled"))
            .collect();
        let squares = HighPass::new(&frames.iter().collect::<Vec<_>>());
        let variances = squares.variances(&[(0, 1.0), (1, -2.0), (2, 1.0)]);
        squares.brightness[1].iter().copied().zip(variances).collect()
    }

    #[test]
    fn sensors_of_known_slope_and_offset_are_found() {
        for (electrons, read_noise) in [(500.0, 4.0), (2000.0, 20.0), (15_000.0, 3.0)] {
            let camera = Camera {
                full_scale_electrons: electrons,
                read_noise_electrons: read_noise,
                black_level: 0.0625,
                bits: Some(14),
            };
            let signal = Plane::from_fn(640, 400, |u, _| 0.8 * (u as f32 / 640.0).powi(2));
            let fit = PhotonTransfer::fit(&squares(&camera, &signal), 256, FREE_VALUES);
            let a = 1.0 / electrons;
            let b = (read_noise * read_noise / electrons - camera.black_level) / electrons;
            assert!((f64::from(fit.slope) / a - 1.0).abs() < 0.08, "{electrons}: {fit:?}");
            for signal in [0.02, 0.2, 0.7] {
                let brightness = signal + camera.black_level;
                let expected = a * brightness + b;
                let got = f64::from(fit.variance(brightness as f32));
                assert!((got / expected - 1.0).abs() < 0.12, "{electrons} {signal}: {got} {expected}");
            }
        }
    }

    #[test]
    fn noise_that_knows_no_brightness_has_no_slope() {
        let mut stream = Stream::new(1, 0);
        let frame = Plane::from_fn(640, 400, |u, _| u as f32 / 640.0 + 0.01 * stream.normal() as f32);
        let squares = HighPass::new(&[&frame]);
        let pairs: Vec<(f32, f32)> =
            squares.brightness[0].iter().copied().zip(squares.variances(&[(0, 1.0)])).collect();
        let fit = PhotonTransfer::fit(&pairs, 256, FREE_VALUES);
        assert_eq!(fit.slope, 0.0);
        assert!((fit.dark / 1e-4 - 1.0).abs() < 0.05, "{fit:?}");
    }

    #[test]
    fn clipped_black_and_texture_bend_nothing() {
        // The darkest tenth is so dark that half of its noise is cut off, a seventh of all squares has texture.
        let camera =
            Camera { full_scale_electrons: 1000.0, read_noise_electrons: 20.0, black_level: 0.0, bits: Some(12) };
        let signal = Plane::from_fn(640, 400, |u, _| (0.6 * (u as f32 - 64.0) / 576.0).max(0.0));
        let mut pairs = squares(&camera, &signal);
        pairs.iter_mut().step_by(7).for_each(|p| p.1 *= 8.0);
        let fit = PhotonTransfer::fit(&pairs, 256, FREE_VALUES);
        assert!((fit.slope / 1e-3 - 1.0).abs() < 0.3, "{fit:?}");
        assert!((fit.variance(0.3) / (0.3e-3 + 0.4e-3) - 1.0).abs() < 0.12, "{fit:?}");
    }

    #[test]
    fn no_noise_and_no_squares_have_an_answer() {
        assert_eq!(PhotonTransfer::fit(&[], 256, 17.0), PhotonTransfer::default());
        let still = PhotonTransfer::fit(&[(0.5, 0.0); 60], 256, 17.0);
        assert_eq!((still.slope, still.dark), (0.0, 0.0));
    }
}
