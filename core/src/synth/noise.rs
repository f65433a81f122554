//! The camera's noise: the capture of a noiseless signal by a sensor; and bursts with one deviation from white noise.
//!
//! A signal `x` is a fraction of full scale *above the black level*. The sensor collects `Poisson(x·F)` electrons,
//! where `F` is the number of electrons at full scale (a small `F` is a high gain, as cameras use in the dark). Reading
//! it out adds Gaussian noise of `r` electrons. The result, divided by `F`, is raised by the black level, a pedestal
//! that keeps the noise around a dark signal from being clipped at zero, and rounded to the levels of a converter of
//! `bits` bits.
//!
//! # Signal-to-noise ratio
//! The per-pixel SNR of two levels, a background and an object on it, is
//!
//! ```text
//! SNR = |x_object − x_background| / σ
//! ```
//!
//! where σ is the standard deviation of the noise of one pixel in one frame at the mean of the two levels:
//! `σ² = (x·F + r²)/F² + q²/12` with `x = (x_object + x_background)/2` and `q` the quantisation step.
//!
//! # Values in files
//! A level `d` of a converter with `bits` bits is the value `d·2^(16−bits)/65535`: the bits sit at the top of a 16-bit
//! word, as many cameras deliver them. A 16-bit file therefore holds each value exactly.
//!
//! # Noise as cameras and files produce it
//! Every frame of a [`NoiseCase`] is a grey level with white Gaussian noise, except for the changes of the case. There
//! are no objects, so every feature of such a burst is false. Values are floats without rounding unless the case is
//! about files.

use super::SynthError;
use super::random::Stream;
use crate::burst::Burst;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use serde::{Serialize, Serializer};
use std::io::Cursor;

/// Camera: electrons at full scale, read noise, pedestal, and converter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Electrons at full scale, F; infinite for a camera without noise.
    pub full_scale_electrons: f64,
    /// Standard deviation of the read noise, electrons.
    pub read_noise_electrons: f64,
    /// Pedestal, fraction of full scale.
    pub black_level: f64,
    /// Bits of the converter, 4 … 16, or `None` for values that are not rounded.
    pub bits: Option<u32>,
}

impl Camera {
    /// A camera without noise and rounding, which only adds the black level.
    pub fn noiseless(black_level: f64) -> Self {
        Self { full_scale_electrons: f64::INFINITY, read_noise_electrons: 0.0, black_level, bits: None }
    }

    /// The camera whose exposure gives the per-pixel SNR `snr` between the signals `background` and `object`
    /// (fractions of full scale above black), with the given read noise (electrons) and converter.
    /// An infinite `snr` gives [`Self::noiseless`].
    ///
    /// # Errors
    /// When `snr` is not positive, or so high that rounding alone makes more noise.
    pub fn for_snr(
        snr: f64,
        background: f64,
        object: f64,
        read_noise_electrons: f64,
        black_level: f64,
        bits: u32,
    ) -> Result<Self, SynthError> {
        if snr == f64::INFINITY {
            return Ok(Self::noiseless(black_level));
        }
        if !(snr.is_finite() && snr > 0.0) {
            return Err(SynthError::param("snr", format!("{snr}"), "give a ratio above 0, or inf for no noise"));
        }
        // Solve σ² = x·y + r²·y² + q²/12 for y = 1/F.
        let middle = 0.5 * (background + object);
        let sigma = (object - background).abs() / snr;
        let rounding = quantisation_step(bits).powi(2) / 12.0;
        let rest = sigma * sigma - rounding;
        if rest <= 0.0 {
            return Err(SynthError::param(
                "snr",
                format!("{snr} is out of reach: rounding to {bits} bits alone makes more noise"),
                "give a lower ratio, more bits, or inf for no noise",
            ));
        }
        // The stable form of the quadratic formula; it also holds for r = 0.
        let r2 = read_noise_electrons * read_noise_electrons;
        let y = 2.0 * rest / (middle + (middle * middle + 4.0 * r2 * rest).sqrt());
        Ok(Self { full_scale_electrons: 1.0 / y, read_noise_electrons, black_level, bits: Some(bits) })
    }

    /// Whether frames are captured without noise.
    pub fn is_noiseless(&self) -> bool {
        self.full_scale_electrons.is_infinite()
    }

    /// The smallest difference between two values, fraction of full scale; 0 when values are not rounded.
    pub fn quantisation_step(&self) -> f64 {
        self.bits.map_or(0.0, quantisation_step)
    }

    /// Standard deviation of the noise of one pixel of one frame where the signal is `signal`; both are fractions of
    /// full scale.
    pub fn sigma(&self, signal: f64) -> f64 {
        let rounding = self.quantisation_step().powi(2) / 12.0;
        if self.is_noiseless() {
            return rounding.sqrt();
        }
        let f = self.full_scale_electrons;
        ((signal.max(0.0) * f + self.read_noise_electrons.powi(2)) / (f * f) + rounding).sqrt()
    }

    /// Captures one frame: `signal` (fractions of full scale above black) with black level, noise and rounding, in [0,
    /// 1].
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` was cancelled.
    pub fn capture(&self, signal: &Plane, stream: &mut Stream, monitor: &Monitor) -> Result<Plane, Cancelled> {
        let mut frame = signal.clone();
        for row in 0..frame.height() {
            monitor.check()?;
            for value in frame.row_mut(row) {
                *value = self.capture_pixel(f64::from(*value), stream);
            }
        }
        Ok(frame)
    }

    fn capture_pixel(&self, signal: f64, stream: &mut Stream) -> f32 {
        let mut value = signal.max(0.0);
        if !self.is_noiseless() {
            let electrons =
                stream.poisson(value * self.full_scale_electrons) + self.read_noise_electrons * stream.normal();
            value = electrons / self.full_scale_electrons;
        }
        value += self.black_level;
        match self.bits {
            Some(bits) => f32::from(quantised_word(value, bits)) / 65535.0,
            None => value.clamp(0.0, 1.0) as f32,
        }
    }
}

/// The 16-bit word that holds `value` rounded to `bits` bits, which are at its top.
pub fn quantised_word(value: f64, bits: u32) -> u16 {
    let shift = 16 - bits.min(16);
    let levels = (1u32 << bits.min(16)) - 1;
    // Truncation rounds down, because nothing is negative after the clamp.
    let level = (value * (65535.0 / f64::from(1u32 << shift)) + 0.5).clamp(0.0, f64::from(levels));
    ((level as u32) << shift) as u16
}

/// The difference between neighbouring levels of a converter of `bits` bits, fraction of full scale.
pub fn quantisation_step(bits: u32) -> f64 {
    f64::from(1u32 << (16 - bits.min(16))) / 65535.0
}

/// Deviation of a burst's noise from white noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoiseCase {
    /// No deviation: white noise of equal strength in every frame, around half of full scale.
    #[default]
    White,
    /// Every frame occurs twice.
    Doubled,
    /// Frames are stored as JPEG files of this quality (1 … 100), 8 bits.
    Jpeg(u8),
    /// Each pixel shares its noise with the neighbouring pixels, with weights 1, 2, 1 along both axes; as strong as
    /// white noise.
    Correlated,
    /// The middle frame is black.
    BlackFrame,
    /// The middle frame has five times the noise.
    NoisyFrame,
    /// The right half has three times the noise.
    NoisyHalf,
    /// Each column has its own offset, as strong as the noise, the same in all frames.
    ColumnStripes,
    /// 200 pixels are brighter by 5 to 20 standard deviations, the same in all frames.
    HotPixels,
    /// Each frame has its own exposure, with a spread of 10 %.
    GainFlicker,
    /// The level is black, so that half of the noise is clipped.
    ClippedBlack,
    /// The level is white, so that half of the noise is clipped.
    Saturated,
    /// The middle frame has no noise, like a dropped one that was filled.
    ConstantFrame,
    /// No frame has noise.
    Constant,
}

/// Ratio of the noise of the middle frame of [`NoiseCase::NoisyFrame`] to that of the others.
const NOISY_FRAME: f64 = 5.0;
/// Ratio of the noise of the right half of [`NoiseCase::NoisyHalf`] to that of the left.
const NOISY_HALF: f64 = 3.0;
/// Number of hot pixels of [`NoiseCase::HotPixels`].
const HOT_PIXELS: usize = 200;
/// Spread of exposures of [`NoiseCase::GainFlicker`].
const FLICKER: f64 = 0.1;
/// Grey level of the scene, fraction of full scale.
const LEVEL: f64 = 0.5;

impl NoiseCase {
    /// All cases, with the JPEG qualities that are commonly measured.
    pub const ALL: [Self; 16] = [
        Self::White,
        Self::Doubled,
        Self::Jpeg(90),
        Self::Jpeg(60),
        Self::Jpeg(30),
        Self::Correlated,
        Self::BlackFrame,
        Self::NoisyFrame,
        Self::NoisyHalf,
        Self::ColumnStripes,
        Self::HotPixels,
        Self::GainFlicker,
        Self::ClippedBlack,
        Self::Saturated,
        Self::ConstantFrame,
        Self::Constant,
    ];

    /// Name on the command line and in reports; [`str::parse`] reads it.
    pub fn name(self) -> String {
        let word = match self {
            Self::White => "white",
            Self::Doubled => "doubled",
            Self::Jpeg(quality) => return format!("jpeg-{quality}"),
            Self::Correlated => "correlated",
            Self::BlackFrame => "black-frame",
            Self::NoisyFrame => "noisy-frame",
            Self::NoisyHalf => "noisy-half",
            Self::ColumnStripes => "column-stripes",
            Self::HotPixels => "hot-pixels",
            Self::GainFlicker => "gain-flicker",
            Self::ClippedBlack => "clipped-black",
            Self::Saturated => "saturated",
            Self::ConstantFrame => "constant-frame",
            Self::Constant => "constant",
        };
        word.to_owned()
    }

    /// Makes a burst of `frames` frames of `size` = (columns, rows), with noise of standard deviation `sigma` (fraction
    /// of full scale) unless the case changes it.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` was cancelled.
    pub fn burst(
        self,
        size: (usize, usize),
        frames: usize,
        sigma: f64,
        seed: u64,
        monitor: &Monitor,
    ) -> Result<Burst, Cancelled> {
        // Stream 0 is for the pattern shared by all frames; frame t has stream t + 1.
        let pattern = self.pattern(size, sigma, &mut Stream::new(seed, 0));
        let mut exposures = Stream::new(seed, frames as u64 + 1);
        let mut planes: Vec<Plane> = Vec::with_capacity(frames);
        for t in 0..frames {
            monitor.check()?;
            if self == Self::Doubled && t % 2 == 1 {
                planes.push(planes[t - 1].clone());
                continue;
            }
            let middle = t == frames / 2;
            let gain = if self == Self::GainFlicker { 1.0 + FLICKER * exposures.normal() } else { 1.0 };
            let frame = self.frame(size, sigma, &pattern, middle, &mut Stream::new(seed, t as u64 + 1));
            planes.push(match self {
                Self::GainFlicker => mapped(&frame, |x| (f64::from(x) * gain) as f32),
                Self::Jpeg(quality) => through_jpeg(&frame, quality),
                Self::Correlated => with_shared_noise(&frame),
                Self::ClippedBlack | Self::Saturated => mapped(&frame, |x| x.clamp(0.0, 1.0)),
                _ => frame,
            });
        }
        let mut burst = Burst::from_planes(self.name(), planes);
        if matches!(self, Self::Jpeg(_)) {
            burst.quantisation_step = quantisation_step(8) as f32;
        }
        Ok(burst)
    }

    /// The pattern added to every frame.
    fn pattern(self, (width, height): (usize, usize), sigma: f64, stream: &mut Stream) -> Plane {
        let mut pattern = Plane::zeros(width, height);
        match self {
            Self::ColumnStripes => {
                let columns: Vec<f32> = (0..width).map(|_| (sigma * stream.normal()) as f32).collect();
                (0..height).for_each(|v| pattern.row_mut(v).copy_from_slice(&columns));
            }
            Self::HotPixels => {
                for _ in 0..HOT_PIXELS {
                    let (u, v) = (stream.below(width), stream.below(height));
                    pattern.row_mut(v)[u] = (sigma * stream.within(5.0, 20.0)) as f32;
                }
            }
            _ => {}
        }
        pattern
    }

    /// One frame before the effects of files and exposures; `middle` is true for the middle one.
    fn frame(self, size: (usize, usize), sigma: f64, pattern: &Plane, middle: bool, stream: &mut Stream) -> Plane {
        let level = match self {
            Self::ClippedBlack => 0.0,
            Self::Saturated => 1.0,
            Self::BlackFrame if middle => 0.0,
            _ => LEVEL,
        };
        let factor = |u: usize| match self {
            Self::NoisyFrame if middle => NOISY_FRAME,
            Self::NoisyHalf if 2 * u >= size.0 => NOISY_HALF,
            Self::ConstantFrame if middle => 0.0,
            Self::BlackFrame if middle => 0.0,
            Self::Constant => 0.0,
            _ => 1.0,
        };
        Plane::from_fn(size.0, size.1, |u, v| (level + sigma * factor(u) * stream.normal()) as f32 + pattern.at(u, v))
    }
}

impl std::str::FromStr for NoiseCase {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let quality = text.strip_prefix("jpeg-").and_then(|q| q.parse().ok());
        if let Some(quality @ 1..=100) = quality {
            return Ok(Self::Jpeg(quality));
        }
        Self::ALL.into_iter().find(|case| case.name() == text).ok_or_else(|| {
            let names: Vec<String> = Self::ALL.iter().map(|case| case.name()).collect();
            format!("'{text}' is none of {} (any quality from 1 to 100)", names.join(", "))
        })
    }
}

impl Serialize for NoiseCase {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name())
    }
}

fn mapped(plane: &Plane, value: impl Fn(f32) -> f32) -> Plane {
    Plane::from_vec(plane.width(), plane.height(), plane.data().iter().map(|&x| value(x)).collect())
}

/// The frame after storage in an 8-bit grey JPEG file of `quality`.
fn through_jpeg(frame: &Plane, quality: u8) -> Plane {
    let (width, height) = frame.size();
    let grey: Vec<u8> = frame.data().iter().map(|&x| (quantised_word(f64::from(x), 8) >> 8) as u8).collect();
    let mut file = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, quality)
        .encode(&grey, width as u32, height as u32, image::ExtendedColorType::L8)
        .expect("a grey picture of a burst's size can be a JPEG file");
    let decoded = image::load(Cursor::new(file), image::ImageFormat::Jpeg).expect("the file was just written");
    Plane::from_vec(width, height, decoded.to_luma8().iter().map(|&x| f32::from(x) / 255.0).collect())
}

/// The frame around [`LEVEL`] filtered by 1, 2, 1 along both axes and scaled to its previous strength.
fn with_shared_noise(frame: &Plane) -> Plane {
    let (width, height) = frame.size();
    let at = |u: i64, v: i64| frame.at(u.clamp(0, width as i64 - 1) as usize, v.clamp(0, height as i64 - 1) as usize);
    // The weights' squares sum to (1 + 4 + 1)².
    let scale = 1.0 / 6.0;
    Plane::from_fn(width, height, |u, v| {
        let line = |dv: i64| {
            let at = |du: i64| at(u as i64 + du, v as i64 + dv) - LEVEL as f32;
            at(-1) + 2.0 * at(0) + at(1)
        };
        LEVEL as f32 + scale * (line(-1) + 2.0 * line(0) + line(1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expose(camera: &Camera, signal: &Plane, seed: u64) -> Plane {
        camera.capture(signal, &mut Stream::new(seed, 1), &Monitor::default()).expect("not cancelled")
    }

    fn statistics(plane: &Plane) -> (f64, f64) {
        let n = plane.data().len() as f64;
        let mean = plane.data().iter().map(|&x| f64::from(x)).sum::<f64>() / n;
        (mean, plane.data().iter().map(|&x| (f64::from(x) - mean).powi(2)).sum::<f64>() / n)
    }

    #[test]
    fn mean_and_variance_follow_the_model() {
        const SIDE: usize = 500;
        for (electrons, signal, bits) in [(60.0, 0.05, 12), (300.0, 0.2, 8), (15_000.0, 0.3, 12), (40.0, 0.1, 10)] {
            let camera = Camera {
                full_scale_electrons: electrons,
                read_noise_electrons: 3.0,
                black_level: 0.45,
                bits: Some(bits),
            };
            let frame = expose(&camera, &Plane::from_fn(SIDE, SIDE, |_, _| signal as f32), 2);
            let (mean, variance) = statistics(&frame);
            let n = (SIDE * SIDE) as f64;
            let sigma = camera.sigma(signal);
            assert!((mean - 0.45 - signal).abs() < 5.0 * sigma / n.sqrt(), "{electrons}: mean {mean}");
            // The variance of a variance is 2σ⁴/n for Gaussian noise; Poisson's tails make it a little larger.
            let error = (2.2 / n).sqrt() * sigma * sigma;
            assert!((variance - sigma * sigma).abs() < 5.0 * error, "{electrons}: {variance} for {}", sigma * sigma);
        }
    }

    #[test]
    fn the_snr_asked_for_is_the_snr_of_the_model() {
        for snr in [0.05, 0.2, 0.35, 1.0, 5.0, 20.0] {
            for read_noise in [0.0, 3.0] {
                let camera = Camera::for_snr(snr, 0.1, 0.12, read_noise, 0.02, 12).expect("within reach");
                let got = 0.02 / camera.sigma(0.11);
                assert!((got - snr).abs() < 1e-9 * snr, "{snr}: {got}");
            }
        }
        assert!(Camera::for_snr(f64::INFINITY, 0.1, 0.12, 3.0, 0.0, 12).expect("noiseless").is_noiseless());
        for bad in [0.0, -1.0, f64::NAN, 1e9] {
            let error = Camera::for_snr(bad, 0.1, 0.12, 3.0, 0.0, 12).expect_err("nonsense").to_string();
            assert!(error.starts_with("snr: "), "{error}");
        }
    }

    #[test]
    fn rounding_keeps_to_the_levels_of_the_converter() {
        assert_eq!(quantised_word(0.0, 12), 0);
        assert_eq!(quantised_word(-1.0, 12), 0);
        assert_eq!(quantised_word(2.0, 12), 65520);
        assert_eq!(quantised_word(1.0, 16), 65535);
        assert_eq!(quantised_word(quantisation_step(12) * 7.4, 12), 7 * 16);
        let words: Vec<u16> = (0..4096u16).map(|d| quantised_word(f64::from(d * 16) / 65535.0, 12)).collect();
        assert!(words.iter().enumerate().all(|(d, &w)| usize::from(w) == d * 16));
    }

    #[test]
    fn a_noiseless_camera_only_lifts() {
        let signal = Plane::from_fn(4, 3, |u, v| 0.01 * (u + v) as f32);
        let frame = expose(&Camera::noiseless(0.25), &signal, 0);
        for (out, x) in frame.data().iter().zip(signal.data()) {
            assert!((out - x - 0.25).abs() < 1e-7);
        }
    }

    const SIZE: (usize, usize) = (200, 120);

    fn burst(case: NoiseCase) -> Burst {
        case.burst(SIZE, 10, 0.02, 3, &Monitor::default()).expect("not cancelled")
    }

    /// Mean and standard deviation of the columns `columns` of frame `t`.
    fn of_frame(burst: &Burst, t: usize, columns: std::ops::Range<usize>) -> (f64, f64) {
        let frame = &burst.frames[t];
        let values: Vec<f64> =
            (0..SIZE.1).flat_map(|v| frame.row(v)[columns.clone()].iter().map(|&x| f64::from(x))).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
    }

    #[test]
    fn names_are_read_back_and_others_are_refused() {
        for case in NoiseCase::ALL {
            assert_eq!(case.name().parse(), Ok(case));
        }
        assert_eq!("jpeg-77".parse(), Ok(NoiseCase::Jpeg(77)));
        for bad in ["jpeg-0", "jpeg-101", "grey", ""] {
            let error = bad.parse::<NoiseCase>().expect_err(bad);
            assert!(error.contains("column-stripes"), "{error}");
        }
    }

    #[test]
    fn every_case_is_what_it_says() {
        let all = 0..SIZE.0;
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.03;
        let doubled = burst(NoiseCase::Doubled);
        assert!(doubled.frames[4] == doubled.frames[5] && doubled.frames[5] != doubled.frames[6]);
        assert_eq!(of_frame(&burst(NoiseCase::BlackFrame), 5, all.clone()), (0.0, 0.0));
        assert!(near(of_frame(&burst(NoiseCase::NoisyFrame), 5, all.clone()).1, 0.1));
        assert!(near(of_frame(&burst(NoiseCase::NoisyFrame), 4, all.clone()).1, 0.02));
        let half = burst(NoiseCase::NoisyHalf);
        assert!(near(of_frame(&half, 2, 0..100).1, 0.02) && near(of_frame(&half, 2, 100..200).1, 0.06));
        assert!(near(of_frame(&burst(NoiseCase::Correlated), 1, all.clone()).1, 0.02));
        assert!(near(of_frame(&burst(NoiseCase::ClippedBlack), 1, all.clone()).0, 0.02 * 0.398_9));
        assert!(near(1.0 - of_frame(&burst(NoiseCase::Saturated), 1, all.clone()).0, 0.02 * 0.398_9));
        assert_eq!(of_frame(&burst(NoiseCase::ConstantFrame), 5, all.clone()).1, 0.0);
        assert_eq!(of_frame(&burst(NoiseCase::Constant), 1, all.clone()), (0.5, 0.0));
        let flicker = burst(NoiseCase::GainFlicker);
        let means: Vec<f64> = (0..10).map(|t| of_frame(&flicker, t, all.clone()).0 / 0.5 - 1.0).collect();
        let spread = (means.iter().map(|x| x * x).sum::<f64>() / 10.0).sqrt();
        assert!((0.04..0.2).contains(&spread), "{spread}");
    }

    #[test]
    fn fixed_patterns_stay_and_jpeg_files_lose_fine_noise() {
        let mean_of = |case: NoiseCase| {
            let burst = burst(case);
            Plane::from_fn(SIZE.0, SIZE.1, |u, v| burst.frames.iter().map(|f| f.at(u, v)).sum::<f32>() / 10.0)
        };
        let stripes = mean_of(NoiseCase::ColumnStripes);
        let columns: Vec<f32> =
            (0..SIZE.0).map(|u| (0..SIZE.1).map(|v| stripes.at(u, v)).sum::<f32>() / SIZE.1 as f32 - 0.5).collect();
        let spread = (columns.iter().map(|x| x * x).sum::<f32>() / SIZE.0 as f32).sqrt();
        assert!((spread / 0.02 - 1.0).abs() < 0.15, "{spread}");
        let hot = mean_of(NoiseCase::HotPixels).data().iter().filter(|&&x| x > 0.5 + 0.08).count();
        assert!((HOT_PIXELS * 9 / 10..=HOT_PIXELS).contains(&hot), "{hot}");
        // Neighbouring pixels differ less with stronger compression.
        let difference = |case| {
            let frame = &burst(case).frames[0];
            let differences = frame.data().windows(2).map(|w| (w[1] - w[0]).powi(2));
            differences.sum::<f32>() / (frame.data().len() - 1) as f32
        };
        let [white, fine, coarse] = [NoiseCase::White, NoiseCase::Jpeg(90), NoiseCase::Jpeg(30)].map(difference);
        assert!(coarse < 0.1 * fine && fine < 1.1 * white, "{white} {fine} {coarse}");
    }
}
